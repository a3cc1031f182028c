//! Records of GPIO lines: what they say, what is missing of them, and what is no record.

use crate::props::{ALL, running};
use crate::rig::{dual, free, single};
use proptest::collection::vec;
use proptest::prelude::*;
use scanrig_expert::*;
use signal::{Span, Time, Value};

/// A record as the kernel lays it out.
fn record(stamp: u64, id: u32, offset: u32, number: u32) -> Vec<u8> {
    let mut bytes = stamp.to_ne_bytes().to_vec();
    for word in [id, offset, 77, number, 0, 0, 0, 0, 0, 0] {
        bytes.extend(word.to_ne_bytes());
    }
    assert_eq!(bytes.len(), RECORD);
    bytes
}

fn counter(config: &CounterConfig) -> ExpertFunctions {
    running(config, InputConditions::default(), &["F_Enable", "F_Preset"])
}

fn read_all(lines: &mut LineEvents, mut bytes: &[u8], expert: &mut ExpertFunctions) {
    while bytes.len() >= RECORD {
        let taken = lines.read(bytes, expert);
        assert!(taken > 0 && taken.is_multiple_of(RECORD));
        bytes = &bytes[taken..];
        let mut place = 0;
        while expert.take(place).is_some() {
            place += 1;
        }
    }
}

fn fact(expert: &ExpertFunctions, fact: FunctionProbe) -> i128 {
    expert.read(0, fact).as_int().unwrap()
}

#[test]
fn records_are_edges_of_their_inputs() {
    let mut expert = counter(&dual(PhaseMode::UpDown, free(0, LimitsMode::Lock)));
    let mut lines = LineEvents::new(&[(17, 0), (4, 1)], 1_000_000);
    let mut bytes = Vec::new();
    for n in 0..5 {
        let at = 1_000_000 + u64::from(n) * 20_000;
        bytes.extend(record(at, 1, 17, 2 * n + 1));
        bytes.extend(record(at + 9_000, 2, 17, 2 * n + 2));
    }
    bytes.extend(record(1_200_000, 1, 4, 1));
    read_all(&mut lines, &bytes, &mut expert);
    assert_eq!((fact(&expert, FunctionProbe::Value), lines.lost(), lines.malformed()), (4, 0, 0));
}

// io: section 18: a gap is a lost edge, reported as such
#[test]
fn a_gap_is_a_fault_of_the_counter() {
    let mut expert = counter(&single(CounterMode::ModuloLoop { modulo: 1000 }));
    let mut lines = LineEvents::new(&[(3, 0)], 0);
    read_all(&mut lines, &[record(0, 1, 3, 1), record(9_000, 2, 3, 2)].concat(), &mut expert);
    assert_eq!((fact(&expert, FunctionProbe::Error), fact(&expert, FunctionProbe::Excess)), (0, 0));
    // Edges 3 to 7 are gone, two or three rising ones among them.
    lines.read(&record(90_000, 2, 3, 8), &mut expert);
    assert_eq!(expert.take(0), Some((Time::from_nanos(90_000), ExpertEffect::Overdriven { function: 0 })));
    assert_eq!(
        (fact(&expert, FunctionProbe::Error), fact(&expert, FunctionProbe::Excess), lines.lost()),
        (8, 3, 5)
    );
    // That is the rig's fault, not one that the controller's program sees.
    assert_eq!(expert.read(0, FunctionProbe::Valid), Value::Bool(true));
}

#[test]
fn numbers_begin_anew_behind_the_last() {
    let mut expert = counter(&single(CounterMode::ModuloLoop { modulo: 1000 }));
    let mut lines = LineEvents::new(&[(3, 0)], 0);
    // Two steps of just under half, as if that many were lost.
    let half = u32::MAX / 2;
    for number in [half, 2 * half, 2 * half + 1, 0, 1] {
        read_all(&mut lines, &record(0, 1, 3, number), &mut expert);
    }
    assert_eq!((lines.lost(), lines.malformed()), (u64::from(half - 1) + u64::from(half - 1), 0));
    read_all(&mut lines, &record(0, 1, 3, 1), &mut expert);
    assert_eq!(lines.malformed(), 1);
}

#[test]
fn what_is_no_record_of_these_lines() {
    let mut expert = counter(&single(CounterMode::ModuloLoop { modulo: 1000 }));
    let mut lines = LineEvents::new(&[(3, 0), (9, 200)], 0);
    let malformed = [
        record(0, 0, 3, 1),
        record(0, 3, 3, 1),
        record(0, 1, 4, 1),
        record(0, 1, 9, 1),
        record(1 << 63, 1, 3, 1),
        record(0, 1, 3, 0),
    ];
    read_all(&mut lines, &malformed.concat(), &mut expert);
    assert_eq!((fact(&expert, FunctionProbe::Value), lines.lost(), lines.malformed()), (0, 0, 6));
    assert_eq!(lines.read(&record(0, 1, 3, 1)[..RECORD - 1], &mut expert), 0);
}

#[test]
fn a_gap_of_another_input_matters_where_it_says_something() {
    let mut config = single(CounterMode::ModuloLoop { modulo: 1000 });
    config.enable = Some(1);
    config.captures[0] = Some(CaptureInput { input: 2, edges: profile::EventEdges::Both });
    for (on, input, excess) in [
        (&["F_Enable"][..], 1, 0),
        (&["EN_Enable"], 1, i128::from(i64::MAX)),
        (&["F_Enable", "EN_Cap"], 2, 0),
    ] {
        let mut expert = running(&config, InputConditions::default(), on);
        let mut lines = LineEvents::new(&[(3, input)], 0);
        read_all(&mut lines, &record(0, 1, 3, 2), &mut expert);
        assert_eq!(
            (fact(&expert, FunctionProbe::Error), fact(&expert, FunctionProbe::Excess)),
            (8, excess),
            "{on:?}"
        );
    }
}

// Stamps of lines can be out of order: time does not go backwards for that.
#[test]
fn time_does_not_go_backwards() {
    let (measures, resolution, timeout) = (PeriodMeasurement::Period, Span::from_micros(1), Span::ZERO);
    let mut expert = counter(&single(CounterMode::Period { measures, resolution, timeout }));
    let mut lines = LineEvents::new(&[(3, 0)], 0);
    for (number, (at, id)) in (1..).zip([(0, 1), (90_000, 2), (100_000, 1), (40_000, 2), (50_000, 1)]) {
        read_all(&mut lines, &record(at, id, 3, number), &mut expert);
    }
    assert_eq!(fact(&expert, FunctionProbe::Value), 0);
}

// The end of time is no instant at which something is due.
#[test]
fn time_comes_to_its_end() {
    let mut expert = counter(&single(CounterMode::EventCounting { window: Span::from_millis(100) }));
    let mut lines = LineEvents::new(&[(3, 0)], 0);
    read_all(&mut lines, &record(i64::MAX as u64, 1, 3, 1), &mut expert);
    assert_eq!((lines.malformed(), expert.next()), (0, Time::MAX));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_survived(bytes in vec(any::<u8>(), 0..20 * RECORD), origin in any::<i64>()) {
        let mut expert = counter(&dual(PhaseMode::X4, free(0, LimitsMode::Lock)));
        let mut lines = LineEvents::new(&[(0, 0), (1, 1)], origin);
        read_all(&mut lines, &bytes, &mut expert);
    }

    // Sound but for a word here and there.
    #[test]
    fn broken_records_are_survived(
        words in vec((any::<u64>(), 0_u32..4, 0_u32..3, any::<u32>()), 0..50),
    ) {
        let mut expert = counter(&dual(PhaseMode::X4, free(0, LimitsMode::Lock)));
        let mut lines = LineEvents::new(&[(0, 0), (1, 1)], 0);
        let bytes: Vec<u8> =
            words.into_iter().flat_map(|(at, id, offset, number)| record(at, id, offset, number)).collect();
        read_all(&mut lines, &bytes, &mut expert);
        prop_assert!(lines.malformed() <= (bytes.len() / RECORD) as u64);
    }

    // What is lost is stated: the value is never further off than that.
    #[test]
    fn the_value_is_off_by_no_more_than_it_says(
        mode in 0_usize..8,
        steps in vec((any::<bool>(), 0_u8..3), 1..60),
        drops in vec(0_u8..4, 200),
    ) {
        let config = dual(ALL[mode], free(0, LimitsMode::Rollover));
        let (mut whole, mut holed) = (counter(&config), counter(&config));
        let (mut all, mut some) = (LineEvents::new(&[(0, 0), (1, 1)], 0), LineEvents::new(&[(0, 0), (1, 1)], 0));
        let mut levels = [false; 2];
        let mut numbers = [0; 2];
        // At the end both lines are heard of, so that no loss is still unknown.
        let steps: Vec<_> = steps.into_iter().chain([(false, 9), (true, 9)]).collect();
        for (n, (b, keep)) in steps.iter().enumerate() {
            let line = usize::from(*b);
            levels[line] = !levels[line];
            numbers[line] += 1;
            let bytes =
                record(n as u64 * 20_000, if levels[line] { 1 } else { 2 }, line as u32, numbers[line]);
            read_all(&mut all, &bytes, &mut whole);
            // Runs of lost records, and single ones.
            if *keep > 0 || drops[n / 8] == 0 {
                read_all(&mut some, &bytes, &mut holed);
            }
        }
        let off = (fact(&whole, FunctionProbe::Value) - fact(&holed, FunctionProbe::Value)).abs();
        prop_assert!(off <= fact(&holed, FunctionProbe::Excess), "{off} off, {} stated", fact(&holed, FunctionProbe::Excess));
        prop_assert_eq!(fact(&whole, FunctionProbe::Excess), 0);
        prop_assert_eq!(some.lost() > 0, fact(&holed, FunctionProbe::Error) & 8 != 0);
    }
}
