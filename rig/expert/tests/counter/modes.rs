//! What the modes count (io: section 17.3).

use crate::rig::{PERIOD, Rig, dual, free, millis, simple, single};
use profile::EventEdges;
use scanrig_expert::*;
use signal::{Span, Time, Value};

const MS: i64 = 1_000_000;

fn stops(rig: &mut Rig) -> Vec<i64> {
    let stop = ExpertEffect::Stop { counter: 0 };
    rig.taken().into_iter().filter(|(_, effect)| *effect == stop).map(|(at, _)| at).collect()
}

// io: 17.3 One-shot, io:STD-HSC-10, io:STD-HSC-05
#[test]
fn a_one_shot_counts_down_to_its_stop() {
    let mut rig = Rig::new(simple(CounterMode::OneShot { preset: 3 }));
    rig.call(&[("Enable", 1)]).pulses(0, 5);
    assert_eq!(rig.shows(["CurrentValue", "Run", "Validity", "Error"]), [0, 0, 0, 0]);
    rig.press("Sync");
    assert_eq!(rig.shows(["CurrentValue", "Run", "Validity", "Error"]), [3, 1, 1, 0]);
    rig.pulses(0, 2);
    assert_eq!(rig.shows(["CurrentValue", "Run"]), [1, 1]);
    assert_eq!(stops(&mut rig), []);
    let at = rig.now;
    rig.pulses(0, 3);
    assert_eq!(rig.shows(["CurrentValue", "Run", "Validity"]), [0, 0, 1]);
    assert_eq!(stops(&mut rig), [at]);
    // In the middle of counting, too (VH-HSC-40).
    rig.press("Sync").pulses(0, 1).press("Sync");
    assert_eq!(rig.shows(["CurrentValue", "Run"]), [3, 1]);
}

// io:STD-HSC-04
#[test]
fn without_enable_pulses_are_ignored() {
    let mut rig = Rig::new(simple(CounterMode::OneShot { preset: 9 }));
    rig.press("Sync").pulses(0, 4);
    assert_eq!(rig.shows(["CurrentValue", "Run"]), [9, 1]);
    rig.call(&[("Enable", 1)]).pulses(0, 4).call(&[("Enable", 0)]).pulses(0, 2);
    assert_eq!(rig.value(), 5);
}

// io: 17.3 Modulo-loop, io:STD-HSC-06
#[test]
fn a_modulo_loop_goes_round() {
    let mut rig = Rig::new(simple(CounterMode::ModuloLoop { modulo: 4 }));
    rig.call(&[("Enable", 1)]).pulses(0, 3);
    assert_eq!(rig.shows(["CurrentValue", "Modulo_Flag", "Validity", "Run"]), [3, 0, 1, 1]);
    rig.pulses(0, 1);
    assert_eq!(rig.shows(["CurrentValue", "Modulo_Flag"]), [0, 1]);
    rig.pulses(0, 1);
    assert_eq!(rig.shows(["CurrentValue", "Modulo_Flag"]), [1, 1]);
    rig.press("ACK_Modulo");
    assert_eq!(rig.shows(["Modulo_Flag"]), [0]);
    rig.pulses(0, 1).press("Sync");
    assert_eq!(rig.shows(["CurrentValue", "Modulo_Flag"]), [0, 0]);
}

// io: 17.3 Modulo-loop with two phases
#[test]
fn a_modulo_loop_goes_round_backwards() {
    let mut rig = Rig::new(dual(PhaseMode::UpDown, CounterMode::ModuloLoop { modulo: 1000 }));
    rig.call(&[("F_Enable", 1)]).pulses(1, 2);
    assert_eq!(rig.shows(["CurrentValue", "Modulo_Flag"]), [998, 1]);
    rig.press("ACK_Modulo").pulses(0, 2);
    assert_eq!(rig.shows(["CurrentValue", "Modulo_Flag"]), [0, 1]);
}

// VH-HSC-02, VH-HSC-03, VH-HSC-04
#[test]
fn a_free_large_counter_needs_a_preset() {
    let mut rig = Rig::new(dual(PhaseMode::UpDown, free(-5, LimitsMode::Lock)));
    rig.call(&[("F_Enable", 1)]).pulses(0, 3);
    assert_eq!(rig.shows(["CurrentValue", "Validity", "Run"]), [0, 0, 0]);
    rig.press("F_Preset");
    assert_eq!(rig.shows(["CurrentValue", "Validity", "Preset_Flag", "Run"]), [-5, 1, 1, 1]);
    rig.pulses(0, 3).pulses(1, 1);
    assert_eq!(rig.value(), -3);
    rig.call(&[("F_Enable", 0)]).pulses(0, 3);
    assert_eq!(rig.value(), -3);
    rig.press("F_Preset").press("ACK_Preset");
    assert_eq!(rig.shows(["CurrentValue", "Preset_Flag"]), [-5, 0]);
}

// io: 17.3 Free-large, VH-HSC-06
#[test]
fn the_ends_of_the_range_lock_or_roll_over() {
    for (input, end, other, bit) in [(0, i32::MAX, i32::MIN, 2), (1, i32::MIN, i32::MAX, 4)] {
        let mut rig = Rig::new(dual(PhaseMode::UpDown, free(end, LimitsMode::Lock)));
        rig.call(&[("F_Enable", 1)]).press("F_Preset");
        assert_eq!(rig.shows(["CurrentValue", "Validity", "Error"]), [end.into(), 1, 0]);
        rig.pulses(input, 1);
        assert_eq!(rig.shows(["CurrentValue", "Validity", "Error", "Run"]), [end.into(), 0, 1, 0]);
        assert_eq!(rig.reads(FunctionProbe::Error), Value::Int(bit));
        // Held, in the other direction too, until the next preset.
        rig.pulses(1 - input, 2);
        assert_eq!(rig.shows(["CurrentValue", "Validity"]), [end.into(), 0]);
        rig.press("F_Preset").pulses(1 - input, 1);
        assert_eq!(rig.shows(["Validity", "Error"]), [1, 0]);
        assert_ne!(rig.value(), end.into());

        let mut rig = Rig::new(dual(PhaseMode::UpDown, free(end, LimitsMode::Rollover)));
        rig.call(&[("F_Enable", 1)]).press("F_Preset").pulses(input, 1);
        assert_eq!(rig.shows(["CurrentValue", "Validity", "Modulo_Flag", "Error"]), [other.into(), 1, 1, 0]);
    }
}

// VH-HSC-10...VH-HSC-15
#[test]
fn events_are_counted_window_by_window() {
    let mut rig = Rig::new(single(CounterMode::EventCounting { window: millis(100) }));
    rig.call(&[("F_Enable", 1)]).pulses(0, 7).pass(100 * MS - 7 * PERIOD - 1);
    assert_eq!(rig.shows(["CurrentValue", "Validity"]), [0, 0]);
    rig.pass(1);
    assert_eq!(rig.shows(["CurrentValue", "Validity"]), [7, 1]);
    // A preset begins a window again and leaves the value alone.
    rig.pulses(0, 2).pass(50 * MS - 2 * PERIOD).press("F_Preset").pulses(0, 3);
    rig.pass(99 * MS);
    assert_eq!(rig.shows(["CurrentValue", "Validity", "Preset_Flag"]), [7, 1, 1]);
    rig.pass(MS);
    assert_eq!(rig.value(), 3);
    // Disabled, the count that goes on is lost.
    rig.pulses(0, 5).call(&[("F_Enable", 0)]).pass(500 * MS);
    assert_eq!(rig.shows(["CurrentValue", "Validity"]), [3, 1]);
    rig.call(&[("F_Enable", 1)]).pulses(0, 1).pass(100 * MS - PERIOD);
    assert_eq!(rig.value(), 1);
}

// An edge at the end of a window belongs to the next one.
#[test]
fn a_window_ends_before_its_last_instant() {
    let mut rig = Rig::new(single(CounterMode::EventCounting { window: millis(100) }));
    rig.call(&[("F_Enable", 1)]).level(0, true).pass(MS).level(0, false);
    rig.now = 100 * MS;
    rig.level(0, true);
    assert_eq!(rig.value(), 1);
    rig.pass(100 * MS);
    assert_eq!(rig.value(), 1);
}

// io: 17.3 Frequency meter
#[test]
fn a_frequency_is_the_pulses_of_a_window() {
    for (window, pulses, hertz) in [(10, 37, 3700), (100, 37, 370), (1000, 37, 37)] {
        let mut rig = Rig::new(single(CounterMode::Frequency { window: millis(window) }));
        rig.call(&[("F_Enable", 1)]);
        assert_eq!(rig.shows(["CurrentValue", "Validity"]), [0, 1]);
        rig.pulses(0, pulses).pass(window * MS - pulses as i64 * PERIOD);
        assert_eq!(rig.value(), hertz);
        rig.pass(window * MS);
        assert_eq!(rig.shows(["CurrentValue", "Validity"]), [0, 1]);
    }
}

// Empty windows go by without anybody looking, and those after them end where they would have.
#[test]
fn empty_windows_keep_their_ends() {
    let mut rig = Rig::new(single(CounterMode::Frequency { window: millis(10) }));
    rig.call(&[("F_Enable", 1)]).pulses(0, 2).pass(19 * MS);
    assert_eq!(rig.value(), 200);
    rig.pass(MS);
    assert_eq!((rig.value(), rig.expert.next()), (0, Time::MAX));
    rig.now = 10_000_000 * MS + 9 * MS;
    rig.pulses(0, 3).pass(MS - 3 * PERIOD - 1);
    assert_eq!(rig.value(), 0);
    rig.pass(1);
    assert_eq!(rig.value(), 300);
    // At the end of an empty window begins the next one.
    rig.pass(10 * MS);
    rig.now = 20_000_000 * MS;
    rig.pulses(0, 1).pass(10 * MS - PERIOD);
    assert_eq!(rig.value(), 100);
}

fn period(measures: PeriodMeasurement, resolution: Span, timeout: Span) -> Rig {
    let mut rig = Rig::new(single(CounterMode::Period { measures, resolution, timeout }));
    rig.call(&[("F_Enable", 1)]);
    rig
}

// io: 17.3 Period meter
#[test]
fn a_period_meter_measures_between_edges() {
    for (nanos, value) in [(100, 12_345), (1_000, 1_234), (100_000, 12), (1_000_000, 1)] {
        let mut rig = period(PeriodMeasurement::Period, Span::from_nanos(nanos), Span::ZERO);
        rig.level(0, true).pass(234_567).level(0, false).pass(1_000_000);
        assert_eq!(rig.shows(["CurrentValue", "Validity"]), [0, 1]);
        rig.level(0, true);
        assert_eq!(rig.value(), value);
        let mut rig = period(PeriodMeasurement::PulseWidth, Span::from_nanos(nanos), Span::ZERO);
        rig.level(0, true).pass(1_234_567).level(0, false).pass(7).level(0, true);
        assert_eq!(rig.value(), value);
    }
}

#[test]
fn without_an_edge_in_time_a_period_is_not_valid() {
    let mut rig = period(PeriodMeasurement::Period, Span::from_micros(1), millis(20));
    rig.pass(20 * MS - 1);
    assert_eq!(rig.shows(["CurrentValue", "Validity"]), [0, 1]);
    rig.pass(1);
    assert_eq!(rig.shows(["CurrentValue", "Validity"]), [0, 0]);
    rig.level(0, true).pass(5 * MS).level(0, false).pass(5 * MS).level(0, true);
    assert_eq!(rig.shows(["CurrentValue", "Validity"]), [10_000, 1]);
    rig.pass(20 * MS);
    assert_eq!(rig.shows(["CurrentValue", "Validity"]), [0, 0]);
    // What began before the timeout is over.
    rig.pass(MS).level(0, false).level(0, true);
    assert_eq!(rig.shows(["CurrentValue", "Validity"]), [0, 0]);
}

// io:STD-HSC-05
#[test]
fn the_edge_of_sync_presets_where_it_is_authorised() {
    let levels = [(true, [1, 0, 1]), (false, [0, 1, 1])];
    for (high, presets) in levels {
        for (edges, expected) in
            [EventEdges::Rising, EventEdges::Falling, EventEdges::Both].into_iter().zip(presets)
        {
            let mut config = dual(PhaseMode::UpDown, free(50, LimitsMode::Lock));
            config.sync = Some(SyncInput { input: 3, edges, while_enable: None });
            let mut rig = Rig::new(config);
            rig.level(3, !high).pass(10).call(&[("EN_Preset", 1)]).level(3, high);
            assert_eq!(rig.shows(["Preset_Flag"]), [expected], "{edges:?} to {high}");
            // Without authority nothing happens.
            rig.call(&[("EN_Preset", 0)])
                .press("ACK_Preset")
                .pass(10)
                .level(3, !high)
                .pass(10)
                .level(3, high);
            assert_eq!(rig.shows(["Preset_Flag"]), [0]);
        }
    }
}

// io:STD-HSC-05: a level combination
#[test]
fn sync_can_ask_for_a_level_of_enable() {
    let mut config = dual(PhaseMode::UpDown, free(50, LimitsMode::Lock));
    config.enable = Some(2);
    config.sync = Some(SyncInput { input: 3, edges: EventEdges::Rising, while_enable: Some(true) });
    let mut rig = Rig::new(config);
    rig.call(&[("EN_Preset", 1)]).level(3, true).pass(10).level(3, false);
    assert_eq!(rig.shows(["Preset_Flag"]), [0]);
    rig.pass(10).level(2, true).pass(10).level(3, true);
    assert_eq!(rig.shows(["Preset_Flag"]), [1]);
}

// io:STD-HSC-04
#[test]
fn input_en_enables_where_it_is_authorised() {
    let mut config = single(CounterMode::ModuloLoop { modulo: 1000 });
    config.enable = Some(2);
    let mut rig = Rig::new(config);
    rig.call(&[]).level(2, true).pass(10).pulses(0, 3);
    assert_eq!(rig.value(), 0);
    rig.call(&[("EN_Enable", 1)]).pulses(0, 3);
    assert_eq!(rig.value(), 3);
    rig.level(2, false).pass(10).pulses(0, 3);
    assert_eq!(rig.value(), 3);
    rig.call(&[("F_Enable", 1)]).pulses(0, 1);
    assert_eq!(rig.value(), 4);
}

// io:STD-HSC-13, io:STD-HSC-06
#[test]
fn captures_store_the_value_once_until_acknowledged() {
    let mut config = dual(PhaseMode::UpDown, free(0, LimitsMode::Lock));
    config.captures = [
        Some(CaptureInput { input: 4, edges: EventEdges::Rising }),
        Some(CaptureInput { input: 5, edges: EventEdges::Falling }),
    ];
    let mut rig = Rig::new(config);
    rig.call(&[("F_Enable", 1)]).press("F_Preset").pulses(0, 5).level(4, true).pass(10).level(4, false);
    assert_eq!(rig.shows(["Cap_Flag"]), [0]);
    rig.call(&[("EN_Cap", 1)]).pass(10).level(4, true).pass(10).level(4, false).pass(10).pulses(0, 2);
    rig.level(4, true).pass(10);
    assert_eq!(rig.shows(["Cap_Flag"]), [1]);
    assert_eq!(rig.reads(FunctionProbe::Captured), Value::Int(5));
    rig.press("ACK_Cap").level(4, false).pass(10).level(4, true);
    assert_eq!((rig.shows(["Cap_Flag"]), rig.reads(FunctionProbe::Captured)), ([1], Value::Int(7)));
    rig.pulses(0, 1).level(5, true).pass(10).level(5, false);
    let now = rig.now;
    for (number, value) in [(0, 7), (1, 8)] {
        let mut read = crate::rig::Instance::new("EXPERTGetCapturedValue");
        read.with(&[("HSC_REF_IN", 1), ("Execute", 1), ("CaptureNumber", number)]);
        assert_eq!(read.call(&mut rig.expert, now).shows("CaptureValue"), value);
    }
}

// io:OUT-20, io:STD-HSC-15
#[test]
fn in_stopped_nothing_is_counted() {
    let mut rig = Rig::new(dual(PhaseMode::UpDown, free(10, LimitsMode::Lock)));
    rig.call(&[("F_Enable", 1)])
        .press("F_Preset")
        .pulses(0, 5)
        .operate(ExpertOperation::Stopped)
        .pulses(0, 5);
    assert_eq!(
        (rig.reads(FunctionProbe::Value), rig.reads(FunctionProbe::Run)),
        (Value::Int(15), Value::Bool(false))
    );
    rig.operate(ExpertOperation::Running).pulses(0, 1);
    assert_eq!(rig.shows(["CurrentValue", "Validity", "Run", "Preset_Flag"]), [16, 1, 1, 1]);
    rig.operate(ExpertOperation::Stopped);
    rig.expert.reset(Time::from_nanos(rig.now));
    rig.operate(ExpertOperation::Running);
    rig.pulses(0, 1);
    assert_eq!(rig.shows(["CurrentValue", "Validity", "Run", "Preset_Flag"]), [0, 0, 0, 0]);
}

#[test]
fn a_one_shot_does_not_go_on_behind_a_stop() {
    let mut rig = Rig::new(single(CounterMode::OneShot { preset: 9 }));
    rig.call(&[("F_Enable", 1)]).press("F_Preset").pulses(0, 2);
    rig.operate(ExpertOperation::Stopped).operate(ExpertOperation::Running).pulses(0, 2);
    assert_eq!(rig.shows(["CurrentValue", "Validity", "Run"]), [7, 1, 0]);
    assert_eq!(stops(&mut rig), []);
}

// Levels of one instant act in their written order, whatever their inputs' numbers.
#[test]
fn what_happens_at_one_instant() {
    let conditions = InputConditions { delay: Span::from_micros(2), bounce: Span::ZERO };
    for (a, sync, cap) in [(0, 1, 2), (2, 1, 0)] {
        let mut config = CounterConfig::new(
            CounterKind::Dual { b: 7, phases: PhaseMode::UpDown },
            a,
            free(100, LimitsMode::Lock),
        );
        config.sync = Some(SyncInput { input: sync, edges: EventEdges::Rising, while_enable: None });
        config.captures[0] = Some(CaptureInput { input: cap, edges: EventEdges::Rising });
        let mut rig = Rig::behind(config, conditions);
        rig.call(&[("F_Enable", 1), ("EN_Preset", 1), ("EN_Cap", 1)]).press("F_Preset").pulses(a.into(), 3);
        for input in [a, sync, cap] {
            rig.level(input.into(), true);
        }
        rig.pass(10_000);
        assert_eq!(
            (rig.reads(FunctionProbe::Captured), rig.reads(FunctionProbe::Value)),
            (Value::Int(104), Value::Int(100))
        );
    }
}

// io:OUT-20: inputs SYNC and CAP have no say in STOPPED, either.
#[test]
fn in_stopped_nothing_is_preset_or_captured() {
    let mut config = dual(PhaseMode::UpDown, free(50, LimitsMode::Lock));
    config.sync = Some(SyncInput { input: 3, edges: EventEdges::Rising, while_enable: None });
    config.captures[0] = Some(CaptureInput { input: 4, edges: EventEdges::Rising });
    let mut rig = Rig::new(config);
    rig.call(&[("EN_Preset", 1), ("EN_Cap", 1)]).operate(ExpertOperation::Stopped);
    rig.level(3, true).level(4, true).pass(10);
    let flags = [FunctionProbe::PresetFlag, FunctionProbe::CaptureFlag];
    assert_eq!(flags.map(|fact| rig.reads(fact)), [Value::Bool(false); 2]);
}

#[test]
fn a_preset_of_a_disabled_event_counter_begins_no_window() {
    let mut rig = Rig::new(single(CounterMode::EventCounting { window: millis(100) }));
    rig.call(&[("F_Enable", 1)]).pulses(0, 7).pass(100 * MS - 7 * PERIOD);
    rig.call(&[("F_Enable", 0)]).press("F_Preset").pass(500 * MS);
    assert_eq!(rig.shows(["CurrentValue", "Validity", "Preset_Flag"]), [7, 1, 1]);
}

// What a DINT cannot hold is not valid.
#[test]
fn a_period_can_be_too_long() {
    let mut rig = period(PeriodMeasurement::Period, Span::from_nanos(100), Span::ZERO);
    rig.level(0, true).pass(MS).level(0, false).pass(215_000 * MS).level(0, true);
    assert_eq!(rig.shows(["CurrentValue", "Validity"]), [i32::MAX.into(), 0]);
}

#[test]
fn a_measurement_does_not_outlast_enable() {
    let mut rig = period(PeriodMeasurement::Period, Span::from_micros(1), Span::ZERO);
    rig.level(0, true).pass(MS).level(0, false);
    rig.call(&[("F_Enable", 0)]).pass(MS).call(&[("F_Enable", 1)]).level(0, true);
    assert_eq!(rig.value(), 0);
    rig.pass(MS).level(0, false).pass(MS).level(0, true);
    assert_eq!(rig.value(), 2_000);
}

// io:STD-HSC-15: what a program said is forgotten with the value.
#[test]
fn a_new_beginning_forgets_all() {
    for off in [true, false] {
        let mut config = dual(PhaseMode::UpDown, CounterMode::ModuloLoop { modulo: 10 });
        config.captures[0] = Some(CaptureInput { input: 4, edges: EventEdges::Rising });
        let mut rig = Rig::new(config);
        rig.call(&[("F_Enable", 1), ("EN_Cap", 1)]).pulses(0, 15).level(4, true).pass(10);
        assert_eq!((rig.value(), rig.reads(FunctionProbe::Captured)), (5, Value::Int(5)));
        if off {
            rig.operate(ExpertOperation::Off);
        } else {
            rig.operate(ExpertOperation::Stopped);
            rig.expert.reset(Time::from_nanos(rig.now));
        }
        rig.operate(ExpertOperation::Running).pulses(0, 3);
        let facts = [
            FunctionProbe::Value,
            FunctionProbe::Captured,
            FunctionProbe::CaptureFlag,
            FunctionProbe::ModuloFlag,
        ];
        assert_eq!(facts.map(|fact| rig.reads(fact)), [Value::Int(0); 4]);
    }
}
