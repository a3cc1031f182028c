//! How fast a counter may be driven, and what it says beyond that (io:STD-HSC-16).

use crate::rig::{Rig, dual, free, single};
use scanrig_expert::*;
use signal::{Span, Value};

fn counting(config: CounterConfig) -> Rig {
    let mut rig = Rig::new(config);
    rig.call(&[("F_Enable", 1)]).press("F_Preset").pass(1_000_000).taken();
    rig
}

fn round(a: u8) -> CounterConfig {
    CounterConfig { a, ..single(CounterMode::ModuloLoop { modulo: i32::MAX }) }
}

/// Pulses on an input, each so long after the last.
fn train(rig: &mut Rig, input: usize, gaps: impl IntoIterator<Item = i64>) {
    for gap in gaps {
        rig.level(input, true).pass(gap / 2).level(input, false).pass(gap - gap / 2);
    }
}

fn excess(rig: &Rig) -> Value {
    rig.reads(FunctionProbe::Excess)
}

#[test]
fn the_highest_frequency_of_each_kind_is_within_its_limit() {
    let phases = dual(PhaseMode::UpDown, free(0, LimitsMode::Rollover));
    for (config, input, period) in [
        (round(0), 0, 5_000),
        (round(7), 7, 5_000),
        (round(8), 8, 1_000_000),
        (phases.clone(), 0, 10_000),
        (phases, 1, 10_000),
    ] {
        let mut rig = counting(config.clone());
        train(&mut rig, input, [period; 1000]);
        assert_eq!((excess(&rig), rig.taken()), (Value::Int(0), vec![]));
        // With jitter it still is, a quarter of a period to either side.
        let jitter = period / 4;
        train(&mut rig, input, [period - jitter, period + jitter].repeat(500));
        train(&mut rig, input, [period - 2 * jitter, period + 2 * jitter].repeat(500));
        assert_eq!(excess(&rig), Value::Int(0));
        // One in a hundred more is not; what is said may be more than what there is.
        train(&mut rig, input, [period - period / 100; 1000]);
        let Value::Int(over) = excess(&rig) else { panic!() };
        assert!((9..=21).contains(&over), "{over}");
    }
}

#[test]
fn what_is_beyond_the_limit_is_counted_and_said_once() {
    let mut rig = counting(round(0));
    let began = rig.now;
    train(&mut rig, 0, [2_500; 1000]);
    assert_eq!(rig.value(), 1000);
    // Half of them, but for the half period that the first may be early.
    assert_eq!(excess(&rig), Value::Int(499));
    assert_eq!(rig.taken(), [(began + 5_000, ExpertEffect::Overdriven { function: 0 })]);
    assert_eq!(rig.shows(["Error", "Validity"]), [0, 1]);
    train(&mut rig, 0, [2_500; 10]);
    assert_eq!(rig.taken(), []);
}

#[test]
fn what_is_not_counted_is_not_too_fast() {
    let mut rig = Rig::new(dual(PhaseMode::UpDown, free(0, LimitsMode::Lock)));
    rig.call(&[("F_Enable", 1)]);
    train(&mut rig, 0, [1_000; 50]);
    rig.call(&[("F_Enable", 0)]).press("F_Preset");
    train(&mut rig, 0, [1_000; 50]);
    assert_eq!((excess(&rig), rig.taken()), (Value::Int(0), vec![]));
}

// An encoder may go at 100 kHz, which is 400 000 counts a second; a shaking edge is too fast on its own phase.
#[test]
fn an_encoder_is_as_fast_as_each_phase() {
    for (phases, weight) in [(PhaseMode::X1, 1), (PhaseMode::X2, 2), (PhaseMode::ReverseX4, 2)] {
        let mut rig = counting(dual(phases, free(0, LimitsMode::Lock)));
        for _ in 0..500 {
            for (input, high) in [(0, true), (1, true), (0, false), (1, false)] {
                rig.level(input, high).pass(2_500);
            }
        }
        assert_eq!(excess(&rig), Value::Int(0));
        train(&mut rig, 1, [5_000; 100]);
        let Value::Int(over) = excess(&rig) else { panic!() };
        assert!((49 * weight..=51 * weight).contains(&over), "{over}");
    }
}

fn behind(bounce: i64) -> Rig {
    let (delay, bounce) = (Span::from_micros(2), Span::from_micros(bounce));
    let mut rig = Rig::behind(round(0), InputConditions { delay, bounce });
    rig.call(&[("F_Enable", 1)]);
    rig
}

// Too fast for the filters, and too fast for the counter: nothing is counted, and that is not sure.
#[test]
fn what_filters_suppress_of_too_fast_a_train_is_said() {
    let mut rig = behind(2);
    train(&mut rig, 0, [3_333; 1000]);
    assert_eq!((rig.value(), excess(&rig)), (0, Value::Int(1000)));
    assert_eq!(rig.taken().len(), 1);
}

// Every second pulse is suppressed: half of the rate is within the limit, all of it is not.
#[test]
fn what_filters_let_through_is_part_of_the_rate() {
    let mut rig = behind(2);
    for _ in 0..1000 {
        rig.level(0, true).pass(2_400).level(0, false).pass(2_200);
        rig.level(0, true).pass(1_000).level(0, false).pass(2_400);
    }
    assert_eq!((rig.value(), excess(&rig)), (1000, Value::Int(1000)));
}

// What filters are for: a train that they are too slow for, and a contact that bounces.
#[test]
fn what_filters_may_suppress_is_not_said() {
    let mut rig = behind(5);
    train(&mut rig, 0, [5_000; 1000]);
    assert_eq!((rig.value(), excess(&rig)), (0, Value::Int(0)));
    let mut rig = behind(1000);
    for _ in 0..10 {
        train(&mut rig, 0, [1_000; 30]);
        rig.level(0, true).pass(2_000_000);
        train(&mut rig, 0, [1_000; 30]);
        rig.level(0, false).pass(2_000_000);
    }
    assert_eq!((rig.value(), excess(&rig)), (10, Value::Int(0)));
}
