//! Blocks: references, handshakes, samples; and what parameters cannot be.

use crate::rig::{Instance, Rig, dual, free, millis, simple, single};
use scanrig_expert::*;
use signal::{Span, Time};

// io:EXP-06, io:EXP-16
#[test]
fn a_wrong_reference_is_an_error_and_nothing_else() {
    let mut rig = Rig::new(single(CounterMode::ModuloLoop { modulo: 100 }));
    rig.call(&[("F_Enable", 1)]).pulses(0, 3);
    for reference in [0, 2, -1, 65_535] {
        rig.call(&[("HSC_REF_IN", reference), ("F_Enable", 0), ("F_Preset", 1)]);
        assert_eq!(rig.shows(["Error", "Validity", "Run", "CurrentValue"]), [1, 0, 0, 0]);
    }
    let mut wrong = Instance::new("HSCSimple_M241");
    wrong.with(&[("HSC_REF_IN", 1), ("Sync", 1)]);
    assert_eq!(wrong.call(&mut rig.expert, rig.now).shows("Error"), 1);
    rig.call(&[("HSC_REF_IN", 1), ("F_Enable", 1)]).pulses(0, 1);
    assert_eq!(rig.shows(["CurrentValue", "Error"]), [4, 0]);
}

#[test]
fn execute_is_answered_until_it_falls() {
    let mut rig = Rig::new(single(CounterMode::ModuloLoop { modulo: 100 }));
    rig.call(&[("F_Enable", 1)]).pulses(0, 3);
    let mut read = Instance::new("EXPERTGetImmediateValue");
    let shows =
        |read: &Instance| ["Done", "Busy", "Error", "ErrID", "ImmediateValue"].map(|pin| read.shows(pin));
    read.with(&[("HSC_REF_IN", 1)]).call(&mut rig.expert, rig.now);
    assert_eq!(shows(&read), [0, 0, 0, 0, 0]);
    read.with(&[("Execute", 1)]).call(&mut rig.expert, rig.now);
    assert_eq!(shows(&read), [1, 0, 0, 0, 3]);
    rig.pulses(0, 1);
    read.call(&mut rig.expert, rig.now);
    assert_eq!(shows(&read), [1, 0, 0, 0, 3], "no second rising edge");
    read.with(&[("Execute", 0)]).call(&mut rig.expert, rig.now);
    assert_eq!(shows(&read), [0, 0, 0, 0, 3]);
    read.with(&[("HSC_REF_IN", 7), ("Execute", 1)]).call(&mut rig.expert, rig.now);
    assert_eq!(shows(&read), [0, 0, 1, 1, 3]);
    let mut captured = Instance::new("EXPERTGetCapturedValue");
    captured.with(&[("HSC_REF_IN", 1), ("Execute", 1)]).call(&mut rig.expert, rig.now);
    assert_eq!(["Done", "Error", "ErrID"].map(|pin| captured.shows(pin)), [0, 1, 2]);
}

// io:STD-HSC-07
#[test]
fn a_task_sees_the_value_of_its_start() {
    let mut rig = Rig::new(single(CounterMode::ModuloLoop { modulo: 100 }));
    rig.call(&[("F_Enable", 1)]).pulses(0, 3);
    rig.expert.sample(Time::from_nanos(rig.now), 0);
    rig.expert.enter(0);
    rig.pulses(0, 2);
    assert_eq!(rig.value(), 3);
    // Another task comes in between.
    rig.expert.sample(Time::from_nanos(rig.now), 1);
    rig.expert.enter(1);
    assert_eq!(rig.value(), 5);
    rig.expert.enter(0);
    assert_eq!(rig.value(), 3);
    let mut read = Instance::new("EXPERTGetImmediateValue");
    read.with(&[("HSC_REF_IN", 1), ("Execute", 1)]).call(&mut rig.expert, rig.now);
    assert_eq!(read.shows("ImmediateValue"), 5);
}

// io:STD-HSC-09: both phases at once
#[test]
fn the_diagnosis_tells_what_the_phases_did() {
    let mut rig = Rig::behind(
        dual(PhaseMode::X4, free(0, LimitsMode::Lock)),
        InputConditions { delay: Span::from_micros(2), bounce: Span::ZERO },
    );
    rig.call(&[("F_Enable", 1)]).press("F_Preset");
    rig.level(0, true).level(1, true).pass(5_000);
    assert_eq!(rig.shows(["CurrentValue", "Error", "Validity"]), [0, 1, 1]);
    let mut diag = Instance::new("EXPERTGetDiag");
    diag.with(&[("HSC_REF_IN", 1), ("Execute", 1)]).call(&mut rig.expert, rig.now);
    assert_eq!(diag.shows("EXPERTDiag"), 1);
    rig.level(0, false).pass(5_000);
    assert_eq!(rig.value(), 1, "counting goes on from the phases as they are");
    rig.press("F_Preset");
    assert_eq!(rig.shows(["Error"]), [0]);
}

#[test]
fn parameters_that_cannot_be() {
    use CounterFault as F;
    let threshold = |value| Threshold { value, event: ThresholdEvent::None };
    let faults = |config: &CounterConfig| config.faults();
    assert_eq!(faults(&simple(free(0, LimitsMode::Lock))), [F::Mode]);
    assert_eq!(faults(&simple(CounterMode::Frequency { window: millis(10) })), [F::Mode]);
    assert_eq!(faults(&dual(PhaseMode::X1, CounterMode::OneShot { preset: 1 })), [F::Mode]);
    assert_eq!(faults(&single(CounterMode::OneShot { preset: 0 })), [F::Preset(0)]);
    assert_eq!(faults(&single(CounterMode::ModuloLoop { modulo: 1 })), [F::Modulo(1)]);
    for window in [0, 10, 99, 60_001] {
        let window = millis(window);
        assert_eq!(faults(&single(CounterMode::EventCounting { window })), [F::Window(window)]);
    }
    let (resolution, timeout) = (Span::from_nanos(7), Span::from_nanos(-1));
    let period = CounterMode::Period { measures: PeriodMeasurement::Period, resolution, timeout };
    assert_eq!(faults(&single(period)), [F::Resolution(resolution), F::Timeout(timeout)]);

    let mut config = simple(CounterMode::ModuloLoop { modulo: 10 });
    config.enable = Some(3);
    config.thresholds = vec![threshold(1)];
    assert_eq!(faults(&config), [F::Input(CounterRole::Enable), F::Thresholds]);

    let mut config = single(CounterMode::ModuloLoop { modulo: 10 });
    config.thresholds = [0, 10, 5, 5].map(threshold).to_vec();
    config.thresholds[3].event = ThresholdEvent::Between;
    assert_eq!(
        faults(&config),
        [F::ThresholdRange(1), F::ThresholdOrder(2), F::ThresholdOrder(3), F::NoNextThreshold(3)]
    );
    config.thresholds = [1, 2, 3, 4, 5].map(threshold).to_vec();
    assert_eq!(faults(&config), [F::TooManyThresholds(5)]);
    config.thresholds.truncate(2);
    config.reflex[1].zones = 0b1000;
    assert_eq!(faults(&config), [F::ReflexZone(1)]);
    config.thresholds.clear();
    assert_eq!(faults(&config), [F::ReflexWithoutThreshold(1)]);
    let mut config = single(CounterMode::ModuloLoop { modulo: 10 });
    config.sync = Some(SyncInput { input: 3, edges: profile::EventEdges::Both, while_enable: Some(false) });
    assert_eq!(faults(&config), [F::SyncWithoutEnable]);
    config.mode = CounterMode::Frequency { window: millis(100) };
    assert_eq!(faults(&config), [F::Input(CounterRole::Sync), F::SyncWithoutEnable]);
}
