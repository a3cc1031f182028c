//! Task watchdogs, the system watchdog, and faults of the application.

use crate::support::*;
use profile::PlcRead;
use scanrig_controller::*;
use signal::{Level, Span};

/// MAST with its default watchdog, driving Q4.
fn lamp() -> Rig {
    Rig::running(config(), Script::new(vec![vec![(1_000, Act::Store(at("%QX0.4"), 1))]]))
}

fn with(change: impl FnOnce(&mut Config), ops: Vec<Vec<Op>>) -> Rig {
    let mut config = config();
    change(&mut config);
    Rig::running(config, Script::new(ops))
}

fn guarded(time: Span, sensitivity: u32) -> impl FnOnce(&mut Config) {
    move |config| config.tasks[0].watchdog = Some(TaskWatchdog { time, sensitivity })
}

// controller:WD-04, controller:WD-10, controller:WD-11
#[test]
fn the_first_cycle_longer_than_the_time_halts() {
    let mut rig = lamp();
    rig.to(run_at(ms(1_000)));
    rig.plc.overload(0, ms(101), 1);
    rig.to(run_at(ms(1_200)));
    assert_eq!(rig.plc.state(), State::Halt);
    assert_eq!(rig.states().last(), Some(&(run_at(ms(1_100)), State::Halt)));
    // The fallback is applied at once; a regular transistor lets go after 250 us.
    assert_eq!(rig.edges(4).last(), Some(&(run_at(us(1_100_250)), Level::Low)));
    assert_eq!(rig.system(PlcRead::LastApplicationError), 0x0010);
    assert_eq!(rig.system(PlcRead::LastStopCause), 0x03);
    assert_eq!(rig.system(PlcRead::Status), 4);
    assert_eq!(rig.plc.task_figures(0).unwrap().exceptions, 1);
}

#[test]
fn a_cycle_of_exactly_the_time_is_in_time() {
    for cycle in [ms(95), ms(100)] {
        let mut rig = lamp();
        rig.to(run_at(ms(1_000)));
        rig.plc.overload(0, cycle, 3);
        rig.to(run_at(ms(2_000)));
        assert_eq!(rig.plc.state(), State::Running);
        assert_eq!(rig.system(PlcRead::LastApplicationError), 0);
        assert_eq!(rig.plc.task_figures(0).unwrap().exceptions, 0);
    }
}

// controller:WD-10: exceptions have to be consecutive.
#[test]
fn sensitivity_counts_consecutive_exceptions() {
    let mut rig = with(guarded(ms(50), 3), vec![vec![]]);
    rig.plc.overload(0, ms(60), 2);
    rig.to(run_at(ms(1_000)));
    assert_eq!((rig.plc.state(), rig.plc.task_figures(0).unwrap().exceptions), (State::Running, 2));
    rig.plc.overload(0, ms(60), 3);
    rig.to(run_at(ms(2_000)));
    // Cycles start at 1000, 1060 and 1120 ms.
    assert_eq!(rig.states().last(), Some(&(run_at(ms(1_170)), State::Halt)));
    assert_eq!(rig.plc.task_figures(0).unwrap().exceptions, 5);
}

#[test]
fn an_endless_loop_trips_at_time_times_sensitivity() {
    for (sensitivity, trip) in [(0, 50), (1, 50), (3, 150)] {
        let mut rig = with(guarded(ms(50), sensitivity), vec![vec![(333, Act::Loop)]]);
        rig.to(run_at(ms(900)));
        assert_eq!(rig.states().last(), Some(&(run_at(ms(trip)), State::Halt)), "sensitivity {sensitivity}");
    }
}

// controller:WD-10: the time includes pre-emption, or not where so configured.
#[test]
fn preemption_counts_as_configured() {
    for (basis, ends) in [(WatchdogBasis::Elapsed, State::Halt), (WatchdogBasis::Processor, State::Running)] {
        let mut rig = with(
            |config| {
                guarded(us(1_400), 1)(config);
                config.tasks.push(task("FAST", 0, ms(1)));
                config.watchdog_basis = basis;
            },
            vec![vec![(100_000, Act::Nop); 10], vec![(500_000, Act::Nop)]],
        );
        rig.to(run_at(ms(30)));
        assert_eq!(rig.plc.state(), ends, "{basis:?}");
    }
    let mut rig = with(
        |config| {
            guarded(us(1_500), 1)(config);
            config.tasks.push(task("FAST", 0, ms(1)));
            config.watchdog_basis = WatchdogBasis::Processor;
        },
        vec![vec![(100_000, Act::Loop)], vec![(500_000, Act::Nop)]],
    );
    rig.to(run_at(ms(30)));
    // MAST has the processor from 0.5 to 1, 1.5 to 2 and 2.5 to 3 ms.
    assert_eq!(rig.states().last(), Some(&(run_at(ms(3)), State::Halt)));
}

// controller:TASK-12
#[test]
fn a_short_interval_has_its_own_limit() {
    let short = |watchdog: Option<TaskWatchdog>| {
        with(
            move |config| {
                config.tasks[0].kind = TaskKind::Cyclic { interval: ms(2) };
                config.tasks[0].watchdog = watchdog;
            },
            vec![vec![]],
        )
    };
    let guarded = Some(TaskWatchdog { time: ms(100), sensitivity: 1 });
    for (watchdog, cycle, ends) in [
        (guarded, us(3_000), State::Running),
        (guarded, us(3_001), State::Halt),
        (None, us(9_000), State::Running),
    ] {
        let mut rig = short(watchdog);
        rig.to(run_at(ms(10)));
        rig.plc.overload(0, cycle, 1);
        rig.to(run_at(ms(40)));
        assert_eq!(rig.plc.state(), ends, "{cycle}");
        if ends == State::Halt {
            assert_eq!(rig.states().last().unwrap().0, run_at(ms(13)));
        } else {
            assert_eq!(rig.plc.task_figures(0).unwrap().exceptions, 0);
            let overrun = |it: &LogEntry| matches!(it, LogEntry::Overrun { .. });
            assert!(rig.log().iter().any(overrun), "tolerated, but logged");
        }
    }
}

// controller:WD-02, controller:WD-11, controller:WD-13, controller:WD-15, controller:TR-12
#[test]
fn full_load_reboots_into_empty() {
    let mut rig = with(|config| config.tasks[0].watchdog = None, vec![vec![(333, Act::Loop)]]);
    rig.to(run_at(ms(2_000)));
    assert_eq!(rig.plc.state(), State::Booting);
    assert_eq!(rig.states().last(), Some(&(run_at(ms(1_000)), State::Booting)));
    rig.to(run_at(ms(3_000)));
    assert_eq!(rig.states().last(), Some(&(run_at(ms(2_500)), State::Empty)));
    assert_eq!(rig.system(PlcRead::LastApplicationError), 0x0011);
    assert_eq!(rig.system(PlcRead::LastStopCause), 0x01);
    assert_eq!(rig.system(PlcRead::BootProjectStatus), 0x0002);
    // A power cycle clears the codes and loads the application that was kept.
    rig.power_off();
    rig.after(ms(100));
    rig.power_on();
    rig.after(ms(2_000));
    assert_eq!(rig.plc.state(), State::Stopped);
    assert_eq!(rig.system(PlcRead::LastApplicationError), 0);
    assert_eq!(rig.system(PlcRead::LastStopCause), 0);
    assert_eq!(rig.system(PlcRead::BootProjectStatus), 0xFFFF);
}

#[test]
fn full_load_needs_an_unbroken_second_of_controller_tasks() {
    // A background task may take the whole processor, up to the limit of all tasks (controller:WD-01).
    let background = |config: &mut Config| config.tasks[0] = task("MAST", 25, ms(10));
    let mut rig = with(background, vec![vec![(333, Act::Loop)]]);
    rig.to(run_at(ms(5_000)));
    assert_eq!(rig.states().last(), Some(&(run_at(ms(3_010)), State::Halt)));
    assert_eq!(rig.system(PlcRead::LastApplicationError), 0x0105);
    assert_eq!(rig.system(PlcRead::LastStopCause), 0x03);
    // One nanosecond of rest in each 500 ms is enough; cycles that follow without a gap are no rest.
    for (interval, cycle, ends) in
        [(ms(500), us(500_000) - Span::from_nanos(1), State::Running), (ms(500), ms(500), State::Booting)]
    {
        let mut rig = with(move |config| config.tasks[0] = task("MAST", 24, interval), vec![vec![]]);
        rig.plc.overload(0, cycle, 1_000);
        rig.to(run_at(ms(1_200)));
        // The first cycle began before the overload was asked for; it is an empty one.
        rig.to(run_at(ms(2_400)));
        assert_eq!(rig.plc.state(), ends, "{cycle}");
    }
}

#[test]
fn two_tasks_together_can_take_the_whole_processor() {
    let mut rig = with(
        |config| {
            config.tasks = vec![task("MAST", 15, ms(2)), task("FAST", 3, ms(2))];
        },
        vec![vec![(1_000_000, Act::Nop)], vec![(1_000_000, Act::Nop)]],
    );
    rig.to(run_at(ms(1_001)));
    assert_eq!(rig.states().last(), Some(&(run_at(ms(1_000)), State::Booting)));
}

// controller:ERR-01, controller:SYS-03
#[test]
fn faults_end_in_their_class() {
    let mut rig = with(
        |_| {},
        vec![vec![(5_000, Act::Store(at("%QX0.4"), 1)), (2_000, Act::Fault(FaultClass::Application))]],
    );
    rig.after(ms(1));
    assert_eq!(rig.states().last(), Some(&(run_at(us(7)), State::Halt)));
    assert_eq!(rig.system(PlcRead::LastApplicationError), 0x0102);
    assert_eq!(rig.system(PlcRead::LastStopCause), 0x03);
    assert_eq!(rig.edges(4), [], "the cycle never wrote its outputs");
    let mut rig = with(|_| {}, vec![vec![(5_000, Act::Fault(FaultClass::System))]]);
    rig.after(ms(2_000));
    assert_eq!(rig.plc.state(), State::Empty);
    assert_eq!(rig.system(PlcRead::LastStopCause), 0x03);
}

/// A variable that changes with the last operation of a cycle, just as the watchdog's time is over: watching it must
/// not make the cycle late.
#[test]
fn watching_never_delays_the_end_of_a_cycle() {
    for watched in [false, true] {
        let mut config = config();
        config.tasks[0].watchdog = Some(TaskWatchdog { time: ms(5), sensitivity: 1 });
        let mut script = Script::new(vec![vec![(5_000_000, Act::Add(0, 1))]]);
        script.variables = vec![(0, Keep::Plain)];
        let mut rig = Rig::running(config, script);
        if watched {
            rig.plc.watch(Probe::Variable(0));
        }
        rig.after(ms(50));
        assert_eq!(rig.plc.state(), State::Running, "watched {watched}");
    }
}
