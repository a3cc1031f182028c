//! Counts of hardware in place of edges: the same value, events and reflexes as of pulse after pulse.

use crate::props::running;
use crate::rig::{dual, free, single};
use profile::ChannelSet;
use proptest::collection::vec;
use proptest::prelude::*;
use scanrig_expert::*;
use signal::{Span, Time, Value};

const PINS: [&str; 5] = ["F_Enable", "F_Preset", "EN_Compare", "EN_Out0", "EN_Out1"];
/// All that can be seen but how fast it was driven.
const FACTS: [FunctionProbe; 12] = [
    FunctionProbe::Value,
    FunctionProbe::Valid,
    FunctionProbe::Run,
    FunctionProbe::Error,
    FunctionProbe::Threshold(0),
    FunctionProbe::Threshold(1),
    FunctionProbe::Threshold(2),
    FunctionProbe::Threshold(3),
    FunctionProbe::Reflex(0),
    FunctionProbe::Reflex(1),
    FunctionProbe::ModuloFlag,
    FunctionProbe::PresetFlag,
];

fn modes() -> impl Strategy<Value = (CounterConfig, i64)> {
    let limits = prop_oneof![Just(LimitsMode::Lock), Just(LimitsMode::Rollover)];
    let ends = prop_oneof![Just(0), Just(i32::MAX - 4), Just(i32::MIN + 4)];
    prop_oneof![
        (1i32..30).prop_map(|preset| (single(CounterMode::OneShot { preset }), 1_000)),
        (2i32..12).prop_map(|modulo| {
            (dual(PhaseMode::UpDown, CounterMode::ModuloLoop { modulo }), 2 * i64::from(modulo) - 1)
        }),
        (ends, limits).prop_map(|(preset, limits)| (dual(PhaseMode::UpDown, free(preset, limits)), 1_000)),
    ]
}

fn with_thresholds() -> impl Strategy<Value = (CounterConfig, i64)> {
    let events = vec(
        prop_oneof![
            Just(ThresholdEvent::Upwards),
            Just(ThresholdEvent::Downwards),
            Just(ThresholdEvent::Both),
            Just(ThresholdEvent::Below),
            Just(ThresholdEvent::Above),
        ],
        4,
    );
    (modes(), vec(1i32..6, 4), events, any::<[u8; 2]>()).prop_map(|((config, most), gaps, events, zones)| {
        let mut value = match config.mode {
            CounterMode::FreeLarge { preset, .. } => preset.saturating_sub(8).max(i32::MIN + 1),
            _ => 0,
        };
        let thresholds = gaps.iter().zip(events).map_while(|(gap, event)| {
            value = value.checked_add(*gap)?;
            Some(Threshold { value, event })
        });
        let thresholds: Vec<Threshold> = thresholds.collect();
        let within = (1u8 << (thresholds.len() + 1)) - 1;
        let reflex = |n: usize| Reflex { output: Some(n as u8), zones: zones[n] & within };
        let reflex = if thresholds.is_empty() { Default::default() } else { [reflex(0), reflex(1)] };
        (CounterConfig { thresholds, reflex, ..config }, most)
    })
}

fn taken(expert: &mut ExpertFunctions, effects: &mut Vec<ExpertEffect>) {
    let mut place = 0;
    while let Some((_, effect)) = expert.take(place) {
        effects.push(effect);
        place += 1;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn steps_do_what_as_many_pulses_do(
        (config, most) in with_thresholds(),
        steps in vec(-40i64..40, 1..12),
    ) {
        let mut counted = running(&config, InputConditions::default(), &PINS).counted(ChannelSet::of(config.a.into()));
        let mut pulsed = running(&config, InputConditions::default(), &PINS);
        let (mut of_counts, mut of_pulses) = (Vec::new(), Vec::new());
        taken(&mut counted, &mut of_counts);
        taken(&mut pulsed, &mut of_pulses);
        let alone = matches!(config.mode, CounterMode::OneShot { .. });
        let mut at = Time::from_nanos(1_000);
        for steps in steps {
            let steps = steps.clamp(-most, most);
            counted.count(at, usize::from(config.a), steps);
            taken(&mut counted, &mut of_counts);
            let b = match config.kind {
                CounterKind::Dual { b, .. } => b,
                _ => config.a,
            };
            let input = usize::from(if steps < 0 && !alone { b } else { config.a });
            for _ in 0..steps.abs() {
                for high in [true, false] {
                    at += Span::from_micros(20);
                    pulsed.edge(at, input, high);
                    pulsed.fire(at);
                    taken(&mut pulsed, &mut of_pulses);
                }
            }
            at += Span::from_micros(20);
            for fact in FACTS {
                prop_assert_eq!(counted.read(0, fact), pulsed.read(0, fact), "{:?} after {}", fact, steps);
            }
        }
        prop_assert_eq!(of_counts, of_pulses);
    }
}

#[test]
fn phases_of_a_counter_that_hardware_counts_for_mean_nothing() {
    let config = dual(PhaseMode::X4, free(0, LimitsMode::Rollover));
    let mut expert =
        running(&config, InputConditions::default(), &PINS).counted(ChannelSet::of(config.a.into()));
    for (micros, input, high) in [(10, 0, true), (20, 1, true), (30, 0, false)] {
        expert.edge(Time::from_nanos(micros * 1_000), input, high);
    }
    assert_eq!(expert.read(0, FunctionProbe::Value), Value::Int(0));
    expert.count(Time::from_nanos(40_000), 0, -7);
    assert_eq!(expert.read(0, FunctionProbe::Value), Value::Int(-7));
    // Counts at an input that is none of its own are not its own.
    expert.count(Time::from_nanos(50_000), 1, 100);
    expert.count(Time::from_nanos(50_000), 2, 100);
    assert_eq!(expert.read(0, FunctionProbe::Value), Value::Int(-7));
    // Counts that were lost on the way are what it may be off by.
    expert.report_missed_edges(Time::from_nanos(60_000), 0, 3);
    assert_eq!(expert.read(0, FunctionProbe::Excess), Value::Int(3));
}

#[test]
fn many_turns_at_once_end_where_they_should() {
    let config = single(CounterMode::ModuloLoop { modulo: 7 });
    let mut expert =
        running(&config, InputConditions::default(), &PINS).counted(ChannelSet::of(config.a.into()));
    let mut expected = 0;
    for (micros, steps) in [(1, 1_000_003), (2, -999_999), (3, i64::from(i32::MAX)), (4, -5)] {
        expert.count(Time::from_nanos(micros * 1_000), usize::from(config.a), steps);
        expected += steps;
        assert_eq!(expert.read(0, FunctionProbe::Value), Value::Int(expected.rem_euclid(7)));
    }
}

#[test]
fn a_counter_that_stands_takes_no_counts() {
    let config = single(CounterMode::ModuloLoop { modulo: 100 });
    let mut expert =
        running(&config, InputConditions::default(), &[]).counted(ChannelSet::of(config.a.into()));
    expert.count(Time::from_nanos(1_000), usize::from(config.a), 5);
    assert_eq!(expert.read(0, FunctionProbe::Value), Value::Int(0));
}
