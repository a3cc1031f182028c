//! Outputs and inputs by state, and forcing.

use crate::support::*;
use profile::{ChannelSet, InputFilter, Profile};
use scanrig_controller::*;
use signal::{Cause, Level, Span, Value};

/// Once a cycle: Q4 from %MX2.0, which is 1; Q5 from I0; Q6 to 0.
fn script() -> Script {
    let mut script = Script::new(vec![vec![
        (1_000, Act::Copy(at("%MX2.0"), at("%QX0.4"))),
        (1_000, Act::Copy(at("%IX0.0"), at("%QX0.5"))),
        (1_000, Act::Store(at("%QX0.6"), 0)),
    ]]);
    script.located = vec![(at("%MX2.0"), 1)];
    script
}

fn with(change: impl FnOnce(&mut Config)) -> Rig {
    let mut config = config();
    config.inputs = vec![InputConfig::filtered(InputFilter::None)];
    change(&mut config);
    let mut rig = Rig::running(config, script());
    rig.after(ms(50));
    rig
}

fn write(rig: &mut Rig, place: &str, value: u64) {
    rig.plc
        .write(rig.now, &Probe::Address(at(place)), Value::Word(value), Cause::Step(0), &mut rig.fx)
        .unwrap();
}

/// Q4 with its default value 0, Q6 with 1.
fn fallback(config: &mut Config) {
    config.output_defaults.insert(6);
}

// controller:STOP-03, controller:STOP-04
#[test]
fn outputs_in_stop() {
    for (option, update, q4, q6, follows) in [
        (OutputsInStop::Default, true, Level::Low, Level::High, false),
        (OutputsInStop::Default, false, Level::Low, Level::High, false),
        (OutputsInStop::Keep, true, Level::High, Level::Low, true),
        (OutputsInStop::Keep, false, Level::High, Level::Low, false),
    ] {
        let mut rig = with(|config| {
            fallback(config);
            (config.outputs_in_stop, config.update_io_in_stop) = (option, update);
        });
        assert_eq!(rig.terminal(4), Level::High);
        let now = rig.now;
        rig.command(Command::Stop).unwrap();
        rig.after(ms(1));
        assert_eq!((rig.terminal(4), rig.terminal(6)), (q4, q6), "{option:?}");
        if option == OutputsInStop::Default {
            // At once, not at the next bus cycle.
            assert_eq!(rig.edges(6).last(), Some(&(now + us(34), Level::High)));
        }
        // A network write to %Q, and an input that changes.
        write(&mut rig, "%QX0.7", 1);
        rig.plc.input(rig.now, Terminal::input(0), Value::from(Level::High));
        rig.after(ms(40));
        assert_eq!(rig.terminal(7) == Level::High, follows, "{option:?} update {update}");
        assert_eq!(rig.memory("%IX0.0") == 1, update);
    }
}

#[test]
fn outputs_in_halt() {
    for (option, halt, q4) in [
        (OutputsInStop::Default, HaltOutputs::Configured, Level::Low),
        (OutputsInStop::Keep, HaltOutputs::Configured, Level::High),
        (OutputsInStop::Keep, HaltOutputs::Default, Level::Low),
    ] {
        let mut rig = with(|config| (config.outputs_in_stop, config.halt_outputs) = (option, halt));
        rig.plc.overload(0, ms(500), 1);
        rig.after(ms(300));
        assert_eq!((rig.plc.state(), rig.terminal(4)), (State::Halt, q4), "{option:?} {halt:?}");
    }
}

// controller:OUT-02, controller:OUT-05, controller:OUT-03
#[test]
fn outputs_through_a_boot() {
    let mut script = script();
    script.located = vec![(at("%QX0.2"), 1), (at("%QX1.0"), 0)];
    let mut config = config();
    config.output_defaults = ChannelSet::from_iter([2, 6, 8]);
    let mut rig = Rig::off(config.clone(), script.clone());
    rig.plc.commission(b"app", State::Stopped).unwrap();
    assert_eq!((rig.terminal(0), rig.terminal(4)), (Level::HighZ, Level::Low));
    rig.power_on();
    rig.after(ms(1_499));
    assert_eq!(
        (rig.terminal(2), rig.terminal(6)),
        (Level::HighZ, Level::Low),
        "hardware initialization values"
    );
    rig.after(ms(100));
    let levels = [0, 2, 6, 8].map(|n| rig.terminal(n));
    // Q2 and Q8 have software initialization values, which win over their defaults.
    assert_eq!(levels, [Level::Low, Level::High, Level::High, Level::Low]);
    rig.power_off();
    rig.after(ms(20));
    assert_eq!((rig.plc.state(), rig.terminal(2), rig.terminal(6)), (State::Off, Level::HighZ, Level::Low));

    // controller:OUT-06: in 2014 a controller that stays STOPPED shows its default values.
    let old = Config { profile: Profile::M241_2014, ..config };
    let mut rig = Rig::booted(old, script, State::Stopped);
    rig.after(ms(50));
    assert_eq!([0, 2, 6, 8].map(|n| rig.terminal(n)), [Level::Low, Level::High, Level::High, Level::High]);
}

// controller:FRC-02, controller:FRC-04, controller:FRC-05, controller:FRC-07
#[test]
fn forced_outputs() {
    let mut rig = with(|_| {});
    let q4 = at("%QX0.4");
    rig.to(run_at(ms(55)));
    rig.command(Command::Force { address: q4, value: 0 }).unwrap();
    rig.to(run_at(ms(59)));
    assert_eq!(rig.terminal(4), Level::High, "no cycle has ended yet");
    rig.to(run_at(ms(65)));
    assert_eq!(rig.edges(4).last(), Some(&(run_at(us(60_253)), Level::Low)));
    // It stays in STOPPED, whatever the default value.
    rig.command(Command::Force { address: q4, value: 1 }).unwrap();
    rig.command(Command::Stop).unwrap();
    rig.after(ms(30));
    assert_eq!(rig.terminal(4), Level::High);
    rig.command(Command::Force { address: q4, value: 0 }).unwrap();
    rig.after(ms(21));
    assert_eq!(rig.terminal(4), Level::Low, "the bus cycle goes on in STOPPED");
    rig.command(Command::Run).unwrap();
    rig.after(ms(5));
    rig.command(Command::Unforce(q4)).unwrap();
    rig.after(ms(21));
    assert_eq!(rig.terminal(4), Level::High);
    rig.command(Command::Force { address: q4, value: 1 }).unwrap();
    rig.command(Command::ResetWarm).unwrap();
    rig.after(ms(21));
    assert_eq!(rig.terminal(4), Level::Low, "a reset ends forcing");
    let none = at("%QX1.2");
    assert_eq!(rig.command(Command::Force { address: none, value: 1 }), Err(CommandError::NoChannel(none)));
}

// controller:FRC-05: both tasks write the byte, one of them the output.
#[test]
fn forcing_comes_to_an_output_with_the_task_that_writes_it() {
    let mut config = Config::new(Profile::M241_2014);
    config.tasks.push(task("SLOW", 20, ms(100)));
    let store = |place: &str| vec![(1_000, Act::Store(at(place), 0))];
    let mut rig = Rig::running(config, Script::new(vec![store("%QX0.4"), store("%QX0.5")]));
    rig.to(run_at(ms(110)));
    rig.command(Command::Force { address: at("%QX0.5"), value: 1 }).unwrap();
    rig.to(run_at(ms(190)));
    assert_eq!(rig.terminal(5), Level::Low, "MAST writes another bit of the byte");
    rig.to(run_at(ms(210)));
    assert_eq!(rig.terminal(5), Level::High);
}

// controller:PRIO-04, controller:PRIO-08, io:OUT-06, io:OUT-08
#[test]
fn status_and_rearming_go_with_the_task_that_uses_them() {
    for late in [false, true] {
        let mut config = config();
        (config.rearming, config.minimize_jitter) = (Rearming::Manual, late);
        config.tasks.push(task("OTHER", 0, ms(102)));
        let mut mast = vec![(1_000, Act::Store(at("%QX0.4"), 1))];
        mast.resize(50, (100_000, Act::Nop));
        let other = vec![
            (1_000, Act::Copy(at("%IX2.0"), at("%MX4.0"))),
            (1_000, Act::Copy(at("%MX6.0"), at("%QX2.0"))),
        ];
        let mut rig = Rig::running(config, Script::new(vec![mast, other]));
        rig.to(run_at(ms(50)));
        rig.plc.disturb(rig.now, Disturbance::ShortCircuit { output: 4, on: true }, &mut rig.fx);
        rig.to(run_at(ms(101)));
        assert_eq!((rig.terminal(4), rig.memory("%IX2.0")), (Level::Low, 0), "MAST does not read the status");
        rig.to(run_at(ms(103)));
        assert_eq!(rig.memory("%IX2.0"), 1);
        rig.plc.disturb(rig.now, Disturbance::ShortCircuit { output: 4, on: false }, &mut rig.fx);
        write(&mut rig, "%MX6.0", 1);
        rig.to(run_at(ms(203)));
        assert_eq!(rig.terminal(4), Level::Low);
        // OTHER cuts into a cycle of MAST, whose end leaves the command as it is.
        rig.to(run_at(ms(215)));
        assert_eq!(rig.terminal(4), if late { Level::Low } else { Level::High });
        rig.to(run_at(ms(225)));
        assert_eq!(rig.terminal(4), Level::High);
    }
}

#[test]
fn forced_inputs() {
    let mut rig = with(|_| {});
    rig.command(Command::Force { address: at("%IX0.0"), value: 1 }).unwrap();
    rig.after(ms(20));
    assert_eq!((rig.memory("%IX0.0"), rig.terminal(5)), (1, Level::High));
    rig.command(Command::Unforce(at("%IX0.0"))).unwrap();
    rig.after(ms(20));
    assert_eq!((rig.memory("%IX0.0"), rig.terminal(5)), (0, Level::Low));
}

// controller:TASK-10, io:EIO-01: %I changes only when a cycle reads.
#[test]
fn inputs_are_read_at_the_start_of_cycles() {
    let mut rig = with(|config| config.inputs = vec![InputConfig::filtered(InputFilter::Ms4)]);
    let probe = rig.plc.watch(Probe::Address(signal::Address::bit(signal::Area::Input, 0)));
    rig.to(run_at(ms(61)));
    rig.plc.input(rig.now, Terminal::input(0), Value::from(Level::High));
    rig.to(run_at(ms(90)));
    let changed =
        Effect::Changed { at: run_at(ms(80)), probe, value: Value::Bool(true), cause: Cause::Board };
    assert!(rig.seen.contains(&changed));
    let edge = Effect::Terminal {
        at: run_at(us(80_037)),
        terminal: Terminal::output(5),
        value: Value::Bool(true),
        cause: Cause::Program { task: 0, file: 0, line: 2 },
        early: Span::ZERO,
    };
    assert!(rig.seen.contains(&edge));
}

// controller:PRIO-04, io:EIO-16: the image is shared, a task that uses an input refreshes it for all.
#[test]
fn an_image_changes_during_a_cycle_of_lower_priority() {
    let mut config = config();
    config.inputs = vec![InputConfig::filtered(InputFilter::None)];
    config.tasks.push(task("FAST", 0, ms(1)));
    let slow = vec![
        (400_000, Act::Copy(at("%IX0.0"), at("%MX4.0"))),
        (800_000, Act::Nop),
        (400_000, Act::Copy(at("%IX0.0"), at("%MX6.0"))),
    ];
    let seen = |fast: Act| {
        let script = Script::new(vec![slow.clone(), vec![(10_000, fast)]]);
        let mut rig = Rig::running(config.clone(), script);
        rig.to(run_at(us(100)));
        rig.plc.input(rig.now, Terminal::input(0), Value::from(Level::High));
        rig.to(run_at(ms(5)));
        (rig.memory("%MX4.0"), rig.memory("%MX6.0"))
    };
    assert_eq!(seen(Act::Copy(at("%IX0.0"), at("%MX8.0"))), (0, 1));
    // A task that does not use the input leaves its image alone.
    assert_eq!(seen(Act::Copy(at("%IX0.1"), at("%MX8.0"))), (0, 0));
}
