//! Thresholds, their events, and reflex outputs (io:STD-HSC-11, io:STD-HSC-12).

use crate::rig::{Rig, dual, free};
use profile::ChannelSet;
use scanrig_expert::*;
use signal::Value;

const PINS: [&str; 4] = ["TH0", "TH1", "TH2", "TH3"];

fn with(thresholds: &[(i32, ThresholdEvent)]) -> CounterConfig {
    let mut config = dual(PhaseMode::UpDown, free(0, LimitsMode::Lock));
    config.thresholds =
        thresholds.iter().map(|(value, event)| Threshold { value: *value, event: *event }).collect();
    config
}

fn four() -> CounterConfig {
    with(&[10, 20, 30, 40].map(|value| (value, ThresholdEvent::None)))
}

fn counting(config: CounterConfig) -> Rig {
    let mut rig = Rig::new(config);
    rig.call(&[("F_Enable", 1), ("EN_Compare", 1)]).press("F_Preset").taken();
    rig
}

fn raised(rig: &mut Rig) -> Vec<(u8, i64)> {
    let taken = rig.taken().into_iter();
    taken
        .filter_map(|(at, effect)| match effect {
            ExpertEffect::Threshold { counter: 0, threshold } => Some((threshold, at)),
            _ => None,
        })
        .collect()
}

fn numbers(rig: &mut Rig) -> Vec<u8> {
    raised(rig).into_iter().map(|(threshold, _)| threshold).collect()
}

// VH-HSC-22
#[test]
fn a_threshold_is_reached_from_its_value_on() {
    let mut rig = counting(four());
    for value in 1..=45 {
        rig.pulses(0, 1);
        assert_eq!(rig.shows(PINS), [10, 20, 30, 40].map(|at| i64::from(value >= at)), "at {value}");
    }
    for value in (-5..45).rev() {
        rig.pulses(1, 1);
        assert_eq!(rig.shows(PINS), [10, 20, 30, 40].map(|at| i64::from(value >= at)), "at {value}");
    }
}

// VH-HSC-24
#[test]
fn crossings_raise_the_events_that_were_chosen() {
    use ThresholdEvent::{Both, Downwards, None, Upwards};
    let mut rig = counting(with(&[(1, Upwards), (2, Downwards), (3, Both), (4, None)]));
    let began = rig.now;
    rig.pulses(0, 5);
    assert_eq!(raised(&mut rig), [(0, began), (2, began + 20_000)]);
    rig.pulses(1, 5);
    assert_eq!(numbers(&mut rig), [2, 1]);
    // A preset crosses as pulses do.
    rig.pulses(0, 5).taken();
    rig.press("F_Preset");
    assert_eq!(numbers(&mut rig), [1, 2]);
}

// VH-HSC-25
#[test]
fn positions_raise_the_events_that_were_chosen() {
    use ThresholdEvent::{Above, Below, Between, None};
    let mut rig = Rig::new(with(&[(1, Below), (2, Between), (4, None), (6, Above)]));
    rig.call(&[("F_Enable", 1)]).press("F_Preset");
    assert_eq!(numbers(&mut rig), []);
    rig.call(&[("EN_Compare", 1)]);
    assert_eq!(numbers(&mut rig), [0], "below it from the start");
    rig.pulses(0, 1);
    assert_eq!(numbers(&mut rig), []);
    rig.pulses(0, 1);
    assert_eq!(numbers(&mut rig), [1]);
    rig.pulses(0, 3);
    assert_eq!(numbers(&mut rig), []);
    rig.pulses(0, 2);
    assert_eq!(numbers(&mut rig), [3]);
    rig.pulses(1, 4);
    assert_eq!(numbers(&mut rig), [1]);
    rig.pulses(1, 3);
    assert_eq!(numbers(&mut rig), [0]);
}

fn reflexes() -> CounterConfig {
    let mut config = four();
    config.reflex = [Reflex { output: Some(4), zones: 0b01010 }, Reflex { output: Some(5), zones: 0b10001 }];
    config
}

// io:STD-HSC-12
#[test]
fn reflexes_follow_the_zone_at_once() {
    let mut rig = counting(reflexes());
    assert_eq!(rig.expert.outputs(), ChannelSet::from_iter([4, 5]));
    rig.call(&[("EN_Out0", 1)]);
    let began = rig.now;
    for value in 1..=45 {
        rig.pulses(0, 1);
        let zone = [10, 20, 30, 40].iter().filter(|at| value >= **at).count();
        let expected = [i64::from(0b01010 >> zone & 1), i64::from(0b10001 >> zone & 1)];
        assert_eq!(rig.shows(["Reflex0", "Reflex1"]), expected, "at {value}");
        assert_eq!(rig.shows(["Out0", "Out1"]), [expected[0], 0]);
    }
    let switched: Vec<_> = rig.taken();
    let at = |pulse: i64, on: bool| (began + (pulse - 1) * 10_000, ExpertEffect::Output { output: 4, on });
    assert_eq!(switched, [at(10, true), at(20, false), at(30, true), at(40, false)]);
    rig.call(&[("F_Out0", 1), ("EN_Out1", 1)]);
    assert_eq!(rig.shows(["Out0", "Out1"]), [1, 1]);
}

// VH-HSC-23, io:STD-HSC-11
#[test]
fn without_comparison_there_is_nothing() {
    let mut config = reflexes();
    config.thresholds[0].event = ThresholdEvent::Both;
    let mut rig = counting(config);
    rig.call(&[("EN_Out0", 1), ("EN_Out1", 1)]).pulses(0, 12).taken();
    rig.call(&[("EN_Compare", 0)]);
    assert_eq!(rig.shows(PINS), [0; 4]);
    assert_eq!(rig.shows(["Reflex0", "Reflex1", "Out0", "Out1"]), [0; 4]);
    rig.pulses(1, 12);
    assert_eq!(numbers(&mut rig), []);
    // Nothing is crossed by switching comparison on, either.
    rig.pulses(0, 12).call(&[("EN_Compare", 1)]);
    assert_eq!((rig.shows(PINS), numbers(&mut rig)), ([1, 0, 0, 0], vec![]));
}

// io:STD-HSC-11: SuspendCompare
#[test]
fn suspended_comparison_stays_as_it_is() {
    let mut config = reflexes();
    config.thresholds[1].event = ThresholdEvent::Both;
    let mut rig = counting(config);
    rig.call(&[("EN_Out0", 1)]).pulses(0, 12).taken();
    rig.call(&[("SuspendCompare", 1)]).pulses(0, 12).call(&[("F_Out1", 1)]);
    assert_eq!(rig.shows(PINS), [1, 0, 0, 0]);
    assert_eq!(rig.shows(["Reflex0", "Out0", "Out1"]), [1, 1, 0]);
    assert_eq!(rig.taken(), []);
    rig.call(&[("SuspendCompare", 0)]);
    assert_eq!(rig.shows(PINS), [1, 1, 0, 0]);
    assert_eq!(rig.shows(["Reflex0", "Out0", "Out1"]), [0, 0, 1]);
    assert_eq!(numbers(&mut rig), []);
    // In STOPPED all outputs are off, suspended or not.
    rig.call(&[("SuspendCompare", 1)]).operate(ExpertOperation::Stopped);
    assert_eq!(rig.shows(["Out0", "Out1"]), [0, 0]);
}

// io:STD-HSC-14, VH-HSC-21
#[test]
fn thresholds_change_with_the_next_count() {
    let mut rig = counting(four());
    let mut set = crate::rig::Instance::new("EXPERTSetParam");
    let mut change = |rig: &mut Rig, param: i64, value: i64| {
        let now = rig.now;
        set.with(&[("HSC_REF_IN", 1), ("Execute", 0)]).call(&mut rig.expert, now);
        set.with(&[("Execute", 1), ("Param", param), ("ParamValue", value)]).call(&mut rig.expert, now);
        ["Done", "Error", "ErrID"].map(|pin| set.shows(pin))
    };
    rig.pulses(0, 7);
    assert_eq!(change(&mut rig, 2, 5), [1, 0, 0]);
    assert_eq!(rig.shows(PINS), [0; 4]);
    rig.pulses(0, 1);
    assert_eq!(rig.shows(PINS), [1, 0, 0, 0]);
    // Out of order, and beyond what there is.
    for (param, value, id) in [(2, 20, 3), (3, 30, 3), (5, 30, 3), (6, 1, 2), (1, 7, 2)] {
        assert_eq!(change(&mut rig, param, value), [0, 1, id], "{param} := {value}");
    }
    assert_eq!(change(&mut rig, 0, 100), [1, 0, 0]);
    assert_eq!(rig.value(), 8);
    rig.press("F_Preset");
    assert_eq!(rig.value(), 100);
    assert_eq!(rig.shows(PINS), [1; 4]);
    let mut get = crate::rig::Instance::new("EXPERTGetParam");
    get.with(&[("HSC_REF_IN", 1), ("Execute", 1), ("Param", 2)]).call(&mut rig.expert, rig.now);
    assert_eq!(get.shows("ParamValue"), 5);
}

#[test]
fn a_modulo_changes_with_the_next_count() {
    for (threshold, refused) in [(0, 1), (5, 5)] {
        let mut config = dual(PhaseMode::UpDown, CounterMode::ModuloLoop { modulo: 100 });
        config.thresholds = vec![Threshold { value: threshold, event: ThresholdEvent::None }];
        let mut rig = Rig::new(config);
        rig.call(&[("F_Enable", 1)]).pulses(0, 9);
        let mut set = crate::rig::Instance::new("EXPERTSetParam");
        for (modulo, done) in [(refused, 0), (10, 1)] {
            set.with(&[("HSC_REF_IN", 1), ("Execute", 0)]).call(&mut rig.expert, rig.now);
            set.with(&[("Execute", 1), ("Param", 1), ("ParamValue", modulo)]).call(&mut rig.expert, rig.now);
            assert_eq!(set.shows("Done"), done, "{modulo}");
        }
        rig.pulses(0, 1);
        assert_eq!(rig.shows(["CurrentValue", "Modulo_Flag"]), [0, 1]);
    }
}

#[test]
fn a_threshold_that_moves_across_the_value_is_not_crossed() {
    let mut rig = counting(with(&[(10, ThresholdEvent::Both)]));
    rig.pulses(0, 7);
    let mut set = crate::rig::Instance::new("EXPERTSetParam");
    set.with(&[("HSC_REF_IN", 1), ("Execute", 1), ("Param", 2), ("ParamValue", 5)]);
    set.call(&mut rig.expert, rig.now);
    rig.pulses(0, 1);
    assert_eq!(numbers(&mut rig), []);
    assert_eq!(rig.reads(FunctionProbe::Threshold(0)), Value::Bool(true));
}
