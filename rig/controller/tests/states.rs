//! Boot, commands and what they do to variables and memory.

use crate::support::*;
use profile::{PlcRead, Profile};
use scanrig_controller::*;
use signal::{Cause, Value};

/// Plain, RETAIN and PERSISTENT counters, %MW5, %MW1500, and a variable AT %MW7.
fn counters() -> Script {
    let mut script = Script::new(vec![vec![
        (1_000, Act::Add(0, 1)),
        (1_000, Act::Add(1, 1)),
        (1_000, Act::Add(2, 1)),
        (1_000, Act::Store(at("%MW5"), 55)),
        (1_000, Act::Store(at("%MW7"), 77)),
        (1_000, Act::Store(at("%MW1500"), 99)),
    ]]);
    script.variables = vec![(0, Keep::Plain), (0, Keep::Retain), (0, Keep::Persistent)];
    script.located = vec![(at("%MW7"), 3)];
    script
}

fn values(rig: &Rig) -> ([i64; 3], [u64; 3]) {
    ([0, 1, 2].map(|n| rig.variable(n)), ["%MW5", "%MW7", "%MW1500"].map(|text| rig.memory(text)))
}

fn booted(mode: StartingMode, left: State) -> Rig {
    Rig::booted(Config { starting_mode: mode, ..config() }, counters(), left)
}

fn row(rig: &Rig) -> u8 {
    let boot = |entry| if let LogEntry::Boot { row } = entry { Some(row) } else { None };
    rig.log().into_iter().filter_map(boot).next_back().unwrap()
}

// controller:RB-02, controller:TR-01, controller:TR-06, controller:TR-07
#[test]
fn boots_by_the_rows() {
    use StartingMode as Mode;
    for (mode, left, state, number) in [
        (Mode::Stop, State::Running, State::Stopped, 5),
        (Mode::Run, State::Halt, State::Stopped, 6),
        (Mode::Run, State::Stopped, State::Running, 8),
        (Mode::Run, State::Empty, State::Running, 8),
        (Mode::Previous, State::Halt, State::Stopped, 11),
        (Mode::Previous, State::Stopped, State::Stopped, 11),
        (Mode::Previous, State::Running, State::Running, 15),
    ] {
        let rig = booted(mode, left);
        assert_eq!((rig.plc.state(), row(&rig)), (state, number), "{mode:?} from {left}");
        let cause = if left == State::Running { 0x0F } else { 0 };
        assert_eq!(rig.system(PlcRead::LastStopCause), cause);
        assert_eq!(rig.system(PlcRead::BootProjectStatus), 0xFFFF);
        let states: Vec<_> = rig.states().into_iter().map(|it| it.1).collect();
        assert_eq!(states, [State::Booting, state]);
    }
}

// controller:TR-04
#[test]
fn without_a_valid_application_it_is_empty() {
    for file in [None, Some(&b"garbage"[..])] {
        let mut rig = Rig::off(config(), counters());
        if let Some(bytes) = file {
            rig.files.write(APPLICATION_FILE, bytes);
        }
        rig.power_on();
        assert_eq!(
            rig.plc.read(&Probe::System(PlcRead::Status.into())),
            Value::Unknown,
            "nothing answers in BOOTING"
        );
        rig.after(ms(1_600));
        assert_eq!((rig.plc.state(), row(&rig)), (State::Empty, 3));
        assert_eq!(rig.system(PlcRead::BootProjectStatus), 0);
        // controller:TR-26, controller:TR-28
        assert_eq!(rig.command(Command::Stop), Ok(()));
        assert_eq!(rig.command(Command::Run), Err(CommandError::State(State::Empty)));
        assert_eq!(rig.command(Command::ResetCold), Err(CommandError::State(State::Empty)));
        assert_eq!(rig.command(Command::Download(b"app".to_vec())), Ok(()));
        assert_eq!(rig.plc.state(), State::Stopped);
    }
}

// controller:STATE-10, controller:DL-03, controller:SYS-02
#[test]
fn an_invalid_context_ends_stopped() {
    // An application placed by file: nothing was saved for it.
    let mut rig = Rig::off(Config { starting_mode: StartingMode::Run, ..config() }, counters());
    rig.files.write(APPLICATION_FILE, b"app");
    rig.power_on();
    rig.after(ms(1_600));
    assert_eq!((rig.plc.state(), row(&rig)), (State::Stopped, 4));
    assert_eq!(rig.system(PlcRead::LastStopCause), 0x0D);
    // It has a context from now on.
    rig.power_off();
    rig.after(ms(10));
    rig.power_on();
    rig.after(ms(1_600));
    assert_eq!((rig.plc.state(), row(&rig)), (State::Running, 8));

    // Another application placed over a running one.
    rig.files.write(APPLICATION_FILE, b"other");
    rig.power_off();
    rig.after(ms(10));
    rig.power_on();
    rig.after(ms(1_600));
    assert_eq!((rig.plc.state(), row(&rig)), (State::Stopped, 4));
    assert_eq!(rig.system(PlcRead::LastStopCause), 0x0E);
    // controller:REM-02 note 2: both have the persistent variable.
    assert_eq!(values(&rig), ([0, 0, 6], [0, 3, 0]));

    // Both images damaged.
    for name in RETAIN_FILES {
        rig.files.write(name, b"damaged");
    }
    rig.power_off();
    rig.after(ms(10));
    rig.power_on();
    rig.after(ms(1_600));
    assert_eq!((rig.plc.state(), rig.system(PlcRead::LastStopCause)), (State::Stopped, 0x0D));
}

// controller:RW-01, controller:RC-01, controller:REM-02, controller:REM-03, controller:RW-02
#[test]
fn resets_keep_what_the_table_says() {
    for (command, expected) in
        [(Command::ResetWarm, ([0, 3, 3], [55, 3, 0])), (Command::ResetCold, ([0, 0, 3], [55, 3, 0]))]
    {
        let mut rig = booted(StartingMode::Previous, State::Running);
        rig.after(ms(50));
        assert_eq!(values(&rig), ([3, 3, 3], [55, 77, 99]));
        assert_eq!(rig.command(command.clone()), Ok(()));
        assert_eq!((rig.plc.state(), rig.system(PlcRead::LastStopCause)), (State::Stopped, 2));
        assert_eq!(values(&rig), expected, "{command:?}");
        // The context of the reset is what a power cycle brings back.
        rig.after(ms(10));
        rig.power_off();
        rig.after(ms(10));
        rig.power_on();
        rig.after(ms(1_600));
        assert_eq!((rig.plc.state(), values(&rig)), (State::Stopped, expected));
        // plcsystem:PLCR-02
        assert_eq!(rig.system(PlcRead::LastStopCause), 2);
    }
}

// controller:DL-02, controller:DL-04, controller:TR-16
#[test]
fn downloads() {
    let mut rig = booted(StartingMode::Previous, State::Running);
    rig.after(ms(50));
    assert_eq!(rig.command(Command::Download(b"app".to_vec())), Ok(()));
    assert_eq!((rig.plc.state(), values(&rig)), (State::Stopped, ([0, 0, 3], [55, 3, 0])));
    assert_eq!(rig.command(Command::Run), Ok(()));
    rig.after(ms(30));
    assert_eq!(rig.command(Command::Download(b"other".to_vec())), Ok(()));
    assert_eq!((rig.plc.state(), values(&rig)), (State::Stopped, ([0, 0, 5], [55, 3, 0])));
    rig.after(ms(3));
    assert_eq!(rig.files.read(APPLICATION_FILE).as_deref(), Some(&b"other"[..]));
    let refused = Err(CommandError::Application(LoadError::Bundle));
    assert_eq!(rig.command(Command::Download(b"garbage".to_vec())), refused);
    assert_eq!(rig.plc.state(), State::Empty);
    assert_eq!(rig.plc.read(&Probe::Variable(0)), Value::Unknown);
    rig.power_off();
    assert_eq!(rig.command(Command::Download(b"app".to_vec())), Ok(()), "within the hold-up time");
    rig.after(ms(5));
    assert_eq!(rig.command(Command::Download(b"app".to_vec())), Err(CommandError::State(State::Off)));
}

// controller:TR-08, controller:TR-09, controller:TR-24, controller:CMD-03
#[test]
fn run_and_stop() {
    let mut rig = booted(StartingMode::Previous, State::Running);
    rig.after(ms(50));
    assert_eq!(rig.command(Command::Run), Err(CommandError::State(State::Running)));
    // In the middle of a cycle: it is finished first.
    rig.to(run_at(us(60_002)));
    assert_eq!(rig.command(Command::Stop), Ok(()));
    assert_eq!(rig.plc.state(), State::Running);
    assert_eq!(rig.command(Command::Stop), Err(CommandError::Stopping));
    rig.after(ms(30));
    assert_eq!(rig.states().last(), Some(&(run_at(us(60_006)), State::Stopped)));
    assert_eq!(rig.system(PlcRead::LastStopCause), 4);
    assert_eq!(values(&rig).0, [4, 4, 4]);
    assert_eq!(rig.command(Command::Stop), Err(CommandError::State(State::Stopped)));
    // Variables go on where they were; the first cycle starts with RUNNING.
    let now = rig.now;
    assert_eq!(rig.command(Command::Run), Ok(()));
    rig.after(us(7));
    assert_eq!(values(&rig).0, [5, 5, 5]);
    let cycles = rig.trail.lock().unwrap().clone();
    assert_eq!(cycles.iter().rfind(|it| it.2 == "start"), Some(&(0, now, "start")));
    rig.plc.overload(0, ms(200), 1);
    rig.after(ms(200));
    assert_eq!(rig.plc.state(), State::Halt);
    for command in [Command::Run, Command::Stop] {
        assert_eq!(rig.command(command), Err(CommandError::State(State::Halt)));
    }
    assert_eq!(rig.command(Command::ResetWarm), Ok(()));
    assert_eq!(rig.system(PlcRead::LastApplicationError), 0);
    assert_eq!(rig.command(Command::Run), Ok(()));
}

// controller:RS-06, controller:RS-07, controller:RS-10
#[test]
fn the_switch() {
    let mut rig = booted(StartingMode::Previous, State::Running);
    rig.after(ms(5));
    assert_eq!(rig.command(Command::Switch(false)), Ok(()));
    assert_eq!((rig.plc.state(), rig.system(PlcRead::LastStopCause)), (State::Stopped, 0x0C));
    assert_eq!(rig.command(Command::Run), Err(CommandError::SwitchAtStop));
    assert_eq!(rig.command(Command::Switch(true)), Ok(()));
    assert_eq!(rig.plc.state(), State::Running);
    rig.command(Command::Switch(false)).unwrap();
    rig.power_off();
    rig.after(ms(10));
    rig.power_on();
    rig.after(ms(1_600));
    assert_eq!(rig.plc.state(), State::Stopped);
}

// controller:HW-08, controller:HW-09, controller:TR-21
#[test]
fn the_hold_up_time() {
    let m251 =
        Config { profile: Profile::M251_2024, reference: Profile::M251_2024.default_reference(), ..config() };
    for (config, hold_up) in [(config(), 4), (m251, 10)] {
        let mut rig = Rig::running(config, counters());
        rig.to(run_at(ms(100)));
        rig.power_off();
        rig.after(ms(hold_up));
        rig.power_on();
        rig.after(ms(100));
        assert_eq!(rig.plc.state(), State::Running, "an interruption as long as the hold-up time");
        let now = rig.now;
        rig.power_off();
        rig.after(ms(hold_up + 1));
        assert_eq!(rig.states().last(), Some(&(now + ms(hold_up), State::Off)));
        assert_eq!(rig.plc.read(&Probe::Variable(0)), Value::Unknown);
    }
}

// controller:PRIO-05
#[test]
fn outputs_of_one_byte_in_two_tasks() {
    let mut script = counters();
    script.tasks =
        vec![vec![(1_000, Act::Store(at("%QX0.4"), 1))], vec![(1_000, Act::Store(at("%QX0.5"), 1))]];
    let mut two = config();
    two.tasks.push(task("SLOW", 20, ms(50)));
    let mut rig = Rig::off(two.clone(), script.clone());
    let error = LoadError::SharedOutputByte { byte: 0, tasks: (0, 1) };
    assert_eq!(rig.plc.commission(b"app", State::Running), Err(error));
    let rig = Rig::running(Config { profile: Profile::M241_2014, ..two }, script);
    assert!(rig.log().contains(&LogEntry::Warning(Warning::SharedOutputByte { byte: 0, tasks: (0, 1) })));
}

#[test]
fn writes_reach_variables_and_memory() {
    let mut rig = booted(StartingMode::Stop, State::Stopped);
    let probe = rig.plc.watch(Probe::Variable(1));
    assert_eq!(rig.plc.watch(Probe::Variable(1)), probe);
    let step = Cause::Step(4);
    rig.plc.write(rig.now, &Probe::Variable(1), Value::Int(41), step, &mut rig.fx).unwrap();
    rig.plc.write(rig.now, &Probe::Address(at("%MW20")), Value::Word(7), step, &mut rig.fx).unwrap();
    assert_eq!(rig.fx.list, [Effect::Changed { at: rig.now, probe, value: Value::Int(41), cause: step }]);
    let refused = rig.plc.write(rig.now, &Probe::State, Value::Int(1), step, &mut rig.fx);
    assert_eq!(refused, Err(WriteError::ReadOnly));
    // What was written in STOPPED is part of the context.
    rig.after(ms(5));
    rig.power_off();
    rig.after(ms(10));
    rig.power_on();
    rig.after(ms(1_600));
    assert_eq!((rig.variable(1), rig.memory("%MW20")), (41, 7));
}
