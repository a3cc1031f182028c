//! Functions that ask the caller of the machine (controller:TASK-13, controller:TASK-52, controller:TASK-53,
//! controller:STATE-03, controller:DEV-22, controller:LED-05).

use crate::support::{Rig, codes};
use proptest::prelude::*;
use scanrig_program::{Service, StopReason};
use signal::{Span, Time, Value};

/// Every service with its call and what it is asked with.
const CALLS: [(&str, Service, i64); 13] = [
    ("SysTaskWaitSleep(7)", Service::WaitSleep, 7),
    ("GetCurrentTaskCycle()", Service::GetTaskCycle, 0),
    ("SetCurrentTaskCycle(5000)", Service::SetTaskCycle, 5000),
    ("BOOL_TO_INT(IsFirstMastCycle())", Service::FirstMastCycle, 0),
    ("BOOL_TO_INT(IsFirstMastColdCycle())", Service::FirstMastColdCycle, 0),
    ("BOOL_TO_INT(IsFirstMastWarmCycle())", Service::FirstMastWarmCycle, 0),
    ("BOOL_TO_INT(hasforcedio())", Service::HasForcedIo, 0),
    ("LWORD_TO_LINT(__TM3_INTERNALSTATUS(513))", Service::ModuleInternalStatus, 513),
    ("GetRtc()", Service::GetRtc, 0),
    ("SetRTCDrift(-36, 1, 2, 3)", Service::SetRtcDrift, -36),
    ("InhibitBatLed(Inhibit := TRUE)", Service::InhibitBatteryLed, 1),
    ("WORD_TO_INT(TM3_GetModuleBusStatus(13))", Service::ModuleBusStatus, 13),
    ("UINT_TO_INT(TM3_GetModuleFWVersion(ModuleIndex := 255))", Service::ModuleFirmware, 255),
];

/// Runs a cycle in slices of these lengths; what was asked, at which instants, and the time of the cycle. Every
/// question is answered with `answer`.
fn cycle(
    rig: &mut Rig,
    slices: &[i64],
    mut answer: impl FnMut(Service) -> i64,
) -> (Vec<(Service, i64, i64)>, i64) {
    let (mut asked, mut now, mut turn) = (Vec::new(), 0, 0);
    let mut left = 0;
    rig.machine.begin(0);
    loop {
        if left == 0 {
            left = slices[turn % slices.len()];
            turn += 1;
        }
        let at = Time::ZERO + Span::from_nanos(now);
        let slice = rig.machine.resume(0, at, Span::from_nanos(left), &mut rig.memory);
        now += slice.used.as_nanos();
        left -= slice.used.as_nanos();
        match slice.stop {
            StopReason::Done => return (asked, now),
            StopReason::Budget { next } if left < next.as_nanos() => {
                left += slices[turn % slices.len()].max(1)
            }
            StopReason::Budget { .. } | StopReason::Touched { .. } => {}
            StopReason::Service { service, argument } => {
                // Without an answer nothing goes on and no time passes.
                let again = rig.machine.resume(0, at, Span::from_secs(1), &mut rig.memory);
                assert_eq!((again.used, again.stop), (Span::ZERO, slice.stop));
                asked.push((service, argument, now));
                rig.machine.answer(0, answer(service));
            }
            stop => panic!("{stop:?}"),
        }
    }
}

#[test]
fn each_function_asks_and_takes_the_answer() {
    for (call, service, argument) in CALLS {
        let mut rig =
            Rig::new(&format!("PROGRAM MAIN VAR n : LINT; END_VAR n := 1000 + {call}; END_PROGRAM"));
        let (asked, used) = cycle(&mut rig, &[1_000_000], |_| 1);
        assert_eq!(asked.len(), 1, "{call}");
        assert_eq!((asked[0].0, asked[0].1), (service, argument), "{call}");
        assert_eq!(rig.int("n"), 1001, "{call}");
        // The call is one function of the library: 1000 ns and what reads and writes; the rest comes after it.
        assert!(asked[0].2 >= 1000 && asked[0].2 < used, "{call}: {asked:?} of {used}");
        // A call may stand alone as a statement.
        let name = call.trim_start_matches("BOOL_TO_INT(");
        let name = if name.len() < call.len() { &name[..name.len() - 1] } else { name };
        let mut rig = Rig::new(&format!("PROGRAM MAIN {name}; END_PROGRAM"));
        assert_eq!(cycle(&mut rig, &[1_000_000], |_| 1).0.len(), 1, "{name}");
    }
}

#[test]
fn arguments_are_checked() {
    for text in
        ["SysTaskWaitSleep()", "GetRtc(1)", "SetRTCDrift(1)", "InhibitBatLed(5)", "SysTaskWaitSleep('a')"]
    {
        assert!(!codes(&format!("PROGRAM MAIN {text}; END_PROGRAM")).is_empty(), "{text}");
    }
    // They are no constants.
    assert!(!codes("PROGRAM MAIN VAR n : DINT := GetRtc(); END_VAR END_PROGRAM").is_empty());
}

#[test]
fn an_answer_is_cut_to_its_type_and_reaches_every_place() {
    let text = "VAR_GLOBAL RETAIN kept : DINT; END_VAR
        FUNCTION deep : DINT VAR_INPUT n : DINT; END_VAR
          IF n > 0 THEN deep := deep(n - 1) + GetRtc(); END_IF;
        END_FUNCTION
        PROGRAM MAIN VAR b : BOOL; list : ARRAY[0..2] OF DINT; i : INT := 1; p : POINTER TO DINT; END_VAR
          b := HasForcedIo();
          list[i] := GetRtc();
          p := ADR(list[2]);
          p^ := GetRtc();
          %MD3 := GetRtc();
          kept := deep(4);
        END_PROGRAM";
    let mut rig = Rig::new(text);
    rig.machine.retained_dirty();
    let (asked, _) = cycle(&mut rig, &[50_000], |_| 0x1_0000_0003);
    assert_eq!(asked.len(), 8);
    assert!(rig.on("b"));
    assert_eq!((rig.int("list[1]"), rig.int("list[2]"), rig.int("kept")), (3, 3, 12));
    assert_eq!(rig.memory.get("%MD3"), 3);
    assert!(rig.machine.retained_dirty());
}

#[test]
fn a_cycle_that_is_abandoned_asks_no_more() {
    let mut rig =
        Rig::new("PROGRAM MAIN VAR n, rtc : DINT; END_VAR n := n + 1; rtc := GetRtc(); END_PROGRAM");
    rig.machine.begin(0);
    let slice = rig.machine.resume(0, Time::ZERO, Span::from_secs(1), &mut rig.memory);
    assert!(matches!(slice.stop, StopReason::Service { .. }));
    rig.machine.begin(0);
    rig.machine.answer(0, 5);
    let slice = rig.machine.resume(0, Time::ZERO, Span::from_secs(1), &mut rig.memory);
    assert!(matches!(slice.stop, StopReason::Service { .. }));
    assert_eq!((rig.int("n"), rig.machine.read(rig.machine.find("rtc").unwrap())), (2, Value::Int(0)));
}

#[test]
fn a_watched_answer_stops_the_slice() {
    let mut rig = Rig::new("PROGRAM MAIN VAR rtc : DINT; END_VAR rtc := GetRtc(); END_PROGRAM");
    rig.machine.watch(rig.machine.find("rtc").unwrap());
    rig.machine.begin(0);
    rig.machine.resume(0, Time::ZERO, Span::from_secs(1), &mut rig.memory);
    rig.machine.answer(0, 5);
    let slice = rig.machine.resume(0, Time::ZERO, Span::ZERO, &mut rig.memory);
    assert_eq!((slice.used, slice.stop), (Span::ZERO, StopReason::Touched { file: 0, line: 1 }));
    assert_eq!(rig.int("rtc"), 5);
}

/// Services in expressions, conditions, loops, arguments, and blocks.
const WORK: &str = "
    FUNCTION twice : DINT VAR_INPUT x : DINT; END_VAR twice := x + GetRtc(); END_FUNCTION
    FUNCTION_BLOCK stage VAR_OUTPUT y : DINT; END_VAR VAR n : DINT; END_VAR
      n := n + 1; IF IsFirstMastCycle() THEN y := y + n; END_IF; SysTaskWaitSleep(n);
    END_FUNCTION_BLOCK
    PROGRAM MAIN VAR s : stage; i, sum : DINT; used : UDINT; END_VAR
      FOR i := 1 TO 3 DO s(); sum := sum * 3 + twice(x := i + s.y) - GetRtc(); END_FOR;
      WHILE HasForcedIo() AND i < 9 DO i := i + 1; END_WHILE;
      used := used + GetCurrentTaskCycle();
    END_PROGRAM";

proptest! {
    #[test]
    fn slices_change_nothing(slices in proptest::collection::vec(1..4000i64, 1..9)) {
        let run = |slices: &[i64]| {
            let mut rig = Rig::new(WORK);
            let mut count = 0;
            let mut answer = |service: Service| {
                count += 1;
                if service == Service::HasForcedIo { i64::from(count % 5 != 0) } else { count }
            };
            let cycles: Vec<_> = (0..3).map(|_| cycle(&mut rig, slices, &mut answer)).collect();
            (cycles, ["i", "sum", "used", "s.y", "s.n"].map(|path| rig.int(path)))
        };
        prop_assert_eq!(run(&slices), run(&[1 << 40]));
    }
}
