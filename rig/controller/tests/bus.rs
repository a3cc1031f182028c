//! Modules on the expansion bus: the bus cycle, the virtual image, delays.

use crate::support::*;
use profile::{
    BusWrite, ConfiguredModule, DigitalInputs, DigitalOutputs, IoChannel, IoStatus, ModuleFamily, ModuleKind,
    ModuleState, ModuleType, PlcRead, Profile,
};
use scanrig_controller::*;
use signal::{Cause, Span, Value};
use std::sync::OnceLock;

const INPUT_DELAY: i64 = 4_000;
const OUTPUT_DELAY: i64 = 450;

/// Sixteen inputs and sixteen outputs with delays.
fn module() -> ConfiguredModule<'static> {
    static MODULE: OnceLock<ModuleType> = OnceLock::new();
    ConfiguredModule::new(MODULE.get_or_init(|| {
        let mut module = ModuleType::new("TM3TEST", ModuleFamily::Tm3, ModuleKind::Digital);
        module.id = Some(200);
        module.profiles = vec![Profile::M241_2014, Profile::M241_2019, Profile::M251_2024];
        let delay = Some(us(INPUT_DELAY));
        module.digital_inputs =
            Some(DigitalInputs { count: 16, rating: None, on_delay: delay, off_delay: delay });
        let delay = Some(us(OUTPUT_DELAY));
        module.digital_outputs = Some(DigitalOutputs {
            count: 16,
            kind: None,
            rating: None,
            output_current: None,
            common_current: None,
            on_delay: delay,
            off_delay: delay,
        });
        module
    }))
}

/// MAST every 20 ms, FAST every 2 ms before it; two modules, after the embedded bytes: inputs from %IX4.0 and %IX6.0 on, outputs
/// from %QX4.0 and %QX6.0 on.
fn two_tasks() -> Config {
    let mut config = config();
    config.tasks = vec![task("MAST", 15, ms(20)), task("FAST", 1, ms(2))];
    config.modules = vec![module(), module()];
    config
}

fn input(module: usize, input: usize) -> Terminal {
    Terminal { module, channel: IoChannel::Input(input) }
}

/// When the terminal of an output turned, since the start of RUNNING, and to what.
fn edges(rig: &Rig, module: usize, output: usize) -> Vec<(Span, Value)> {
    let wanted = Terminal { module, channel: IoChannel::Output(output) };
    let of = |effect: &Effect| match *effect {
        Effect::Terminal { at, terminal, value, .. } if terminal == wanted => {
            Some((at - run_at(Span::ZERO), value))
        }
        _ => None,
    };
    rig.seen.iter().filter_map(of).collect()
}

// io:ADR-01, io:ADR-05
#[test]
fn modules_have_the_terminals_of_their_addresses() {
    let rig = Rig::running(two_tasks(), Script::new(vec![vec![(1_000, Act::Nop)], vec![(1_000, Act::Nop)]]));
    assert_eq!(rig.plc.terminal(at("%IX4.0")), Some(input(1, 0)));
    assert_eq!(rig.plc.terminal(at("%IX7.7")), Some(input(2, 15)));
    assert_eq!(rig.plc.terminal(at("%IX8.0")), None);
    let output = Terminal { module: 2, channel: IoChannel::Output(3) };
    assert_eq!(rig.plc.terminal(at("%QX6.3")), Some(output));
}

// io:BUS-09, controller:PRIO-06, controller:PRIO-07
#[test]
fn the_bus_cycle_alone_exchanges_and_tasks_see_the_virtual_image() {
    let app = Script::new(vec![
        vec![(1_000, Act::Copy(at("%IX4.1"), at("%QX0.0")))],
        vec![(1_000, Act::Copy(at("%IX4.0"), at("%QX6.3")))],
    ]);
    let mut rig = Rig::running(two_tasks(), app);
    rig.to(run_at(ms(61)));
    rig.plc.input(rig.now, input(1, 0), Value::Bool(true));
    rig.plc.input(rig.now, input(1, 1), Value::Bool(true));
    // It has passed its delay at 65 ms; MAST reads at 80 ms, after FAST has begun its cycle of that instant.
    rig.to(run_at(ms(81)));
    assert_eq!((rig.memory("%IX4.0"), rig.memory("%IX4.1")), (0, 1));
    rig.to(run_at(ms(83)));
    assert_eq!((rig.memory("%IX4.0"), rig.memory("%QX6.3")), (1, 1));
    // FAST wrote it at 82 ms: the module has it when MAST ends, 1 us of its own and 1 us of FAST after 100 ms.
    rig.to(run_at(ms(120)));
    assert_eq!(edges(&rig, 2, 3), [(us(100_002 + OUTPUT_DELAY), Value::Bool(true))]);
}

// controller:STOP-04, controller:OUT-02
#[test]
fn in_stopped_each_update_is_a_bus_cycle() {
    let app =
        Script::new(vec![vec![(1_000, Act::Copy(at("%IX4.0"), at("%QX4.0")))], vec![(1_000, Act::Nop)]]);
    let config = Config { outputs_in_stop: OutputsInStop::Keep, ..two_tasks() };
    let mut rig = Rig::running(config, app);
    rig.plc.input(rig.now, input(1, 0), Value::Bool(true));
    rig.after(ms(100));
    rig.command(Command::Stop).unwrap();
    rig.plc.input(rig.now, input(1, 0), Value::Bool(false));
    rig.after(ms(100));
    assert_eq!((rig.memory("%IX4.0"), edges(&rig, 1, 0).len()), (0, 1));
    rig.command(Command::ResetOrigin).unwrap();
    rig.after(ms(100));
    assert_eq!(edges(&rig, 1, 0).last().map(|(_, value)| *value), Some(Value::Bool(false)));
    assert_eq!(
        rig.plc.read(&Probe::Terminal(Terminal { module: 1, channel: IoChannel::Output(0) })),
        Value::Bool(false)
    );
}

// controller:DEV-12: a channel that no task uses is exchanged by the bus cycle task, or by none.
#[test]
fn unused_channels_are_exchanged_as_configured() {
    for (always_update, expected) in [(AlwaysUpdate::Unused, 1), (AlwaysUpdate::Disabled, 0)] {
        let mut config = Config::new(Profile::M251_2024);
        (config.always_update, config.modules) = (always_update, vec![module()]);
        let mut rig = Rig::running(config, Script::new(vec![vec![(1_000, Act::Nop)]]));
        rig.plc.input(rig.now, input(1, 9), Value::Bool(true));
        rig.after(ms(100));
        assert_eq!(rig.memory("%IX1.1"), expected, "{always_update:?}");
    }
}

// Delays are inertial: what is shorter than they are has no effect.
#[test]
fn a_pulse_shorter_than_the_delay_is_not_seen() {
    let app =
        Script::new(vec![vec![(1_000, Act::Copy(at("%IX4.0"), at("%QX4.0")))], vec![(1_000, Act::Nop)]]);
    let mut rig = Rig::running(two_tasks(), app);
    for (level, at) in [(true, 37_000), (false, 37_000 + INPUT_DELAY - 1), (true, 57_000)] {
        rig.to(run_at(us(at)));
        rig.plc.input(rig.now, input(1, 0), Value::Bool(level));
    }
    rig.to(run_at(ms(59)));
    assert_eq!(rig.memory("%IX4.0"), 0);
    rig.to(run_at(ms(79)));
    // 3 ms are too short for the cycle at 60 ms.
    assert_eq!(rig.memory("%IX4.0"), 0);
    rig.to(run_at(ms(81)));
    assert_eq!(rig.memory("%IX4.0"), 1);
}

// io:BUS-02, io:ADR-06
#[test]
fn what_cannot_be_configured_is_refused() {
    static COUNTER: OnceLock<ModuleType> = OnceLock::new();
    let counter = COUNTER.get_or_init(|| {
        let mut module = ModuleType::new("TM3XTEST", ModuleFamily::Tm3, ModuleKind::Expert);
        (module.id, module.profiles) = (Some(201), vec![Profile::M241_2019]);
        module
    });
    let check = |modules: Vec<ConfiguredModule<'static>>| Config { modules, ..config() }.check();
    assert_eq!(check(vec![module(); 7]), Ok(()));
    assert!(matches!(check(vec![module(); 8]), Err(ConfigError::Module(error)) if error.place == 7));
    assert_eq!(
        check(vec![module(), ConfiguredModule::new(counter)]),
        Err(ConfigError::NoModuleModel { place: 1 })
    );
}

/// MAST copies the first input of each of two modules to its first output, and I0 to Q0.
fn copies() -> Script {
    let copy = |from, to| (1_000, Act::Copy(at(from), at(to)));
    Script::new(vec![vec![copy("%IX4.0", "%QX4.0"), copy("%IX6.0", "%QX6.0"), copy("%IX0.0", "%QX0.0")]])
}

/// A rig of two modules in RUNNING for 100 ms whose inputs are on.
fn two_modules(profile: Profile) -> Rig {
    let mut config = Config::new(profile);
    config.tasks = vec![task("MAST", 15, ms(20))];
    config.modules = vec![module(), module()];
    let mut rig = Rig::running(config, copies());
    rig.plc.input(rig.now, input(1, 0), Value::Bool(true));
    rig.plc.input(rig.now, input(2, 0), Value::Bool(true));
    rig.to(run_at(ms(101)));
    rig
}

fn fault(rig: &mut Rig, index: usize, fault: ModuleFault) {
    disturb(rig, Disturbance::Module { index, fault });
}

fn disturb(rig: &mut Rig, disturbance: Disturbance) {
    let mut fx = Effects::new();
    rig.plc.disturb(rig.now, disturbance, &mut fx);
    rig.fx = fx;
}

fn silence(rig: &mut Rig, index: usize, exchanges: Option<u32>) {
    fault(rig, index, ModuleFault::Silent(exchanges));
}

fn states(rig: &Rig) -> [ModuleState; 3] {
    [0, 1, 2].map(|index| rig.plc.module_state(index))
}

const EMPTY: ModuleState = ModuleState::Empty;
const OK: ModuleState = ModuleState::Ok;
const BUS_ERROR: ModuleState = ModuleState::BusError;

/// The bits of TM3 in PLC_R.i_lwSystemFault_1, the status of the expansion modules, and the indicator I/O.
fn shown(rig: &Rig) -> (u64, u64, bool) {
    let word = |variable: PlcRead| rig.plc.read(&Probe::System(variable.into())).as_int().unwrap() as u64;
    let lit = rig.plc.read(&Probe::LedLit(Led::Io)) == Value::Bool(true);
    (word(PlcRead::SystemFault1) & 3, word(PlcRead::IoStatus2), lit)
}

// io:ERR-03: one failed exchange is no error, two in a row are; a good one between them counts from the beginning again.
#[test]
fn two_failures_in_a_row_are_an_error() {
    for (exchanges, error) in [(1, false), (2, true)] {
        let mut rig = two_modules(Profile::M241_2019);
        silence(&mut rig, 1, Some(exchanges));
        rig.to(run_at(ms(139)));
        assert_eq!(states(&rig), [OK, OK, EMPTY]);
        rig.to(run_at(ms(141)));
        assert_eq!(states(&rig)[1], if error { BUS_ERROR } else { OK }, "{exchanges}");
        silence(&mut rig, 1, Some(1));
        rig.to(run_at(ms(201)));
        assert_eq!(states(&rig)[1], if error { BUS_ERROR } else { OK }, "{exchanges}");
    }
}

// io:ERR-02, io:ERR-04, io:ERR-06, io:ERR-08, io:ERR-18
#[test]
fn active_handling_switches_the_bus_off() {
    let mut rig = two_modules(Profile::M241_2019);
    assert_eq!(shown(&rig), (3, u64::from(IoStatus::Ok.code()), false));
    silence(&mut rig, 1, None);
    rig.to(run_at(ms(139)));
    assert_eq!((rig.memory("%QX4.0"), edges(&rig, 1, 0).len()), (1, 1));
    rig.to(run_at(ms(150)));
    assert_eq!((states(&rig), rig.plc.state()), ([OK, BUS_ERROR, EMPTY], State::Running));
    assert_eq!(shown(&rig), (0, u64::from(IoStatus::BusError.code()), true));
    // The healthy module, too: its output is 0 in the memory and at the terminal, and its input reads 0.
    assert_eq!((rig.memory("%QX4.0"), rig.memory("%IX4.0")), (0, 0));
    assert_eq!(edges(&rig, 1, 0).last(), Some(&(us(140_000 + OUTPUT_DELAY), Value::Bool(false))));
    assert_eq!(edges(&rig, 2, 0).last(), Some(&(us(140_000 + OUTPUT_DELAY), Value::Bool(false))));
    // Embedded inputs and outputs go on, and the cause alone brings nothing back.
    silence(&mut rig, 1, Some(0));
    rig.plc.input(rig.now, Terminal::input(0), Value::Bool(true));
    rig.after(ms(200));
    assert_eq!((rig.memory("%QX0.0"), rig.memory("%QX4.0"), states(&rig)[1]), (1, 0, BUS_ERROR));
}

// io:ERR-07
#[test]
fn what_starts_the_bus_again() {
    for cause_gone in [true, false] {
        let mut rig = two_modules(Profile::M241_2019);
        silence(&mut rig, 1, None);
        rig.after(ms(100));
        if cause_gone {
            silence(&mut rig, 1, Some(0));
        }
        rig.command(Command::ResetWarm).unwrap();
        rig.command(Command::Run).unwrap();
        rig.after(ms(100));
        let expected = if cause_gone { (1, OK, 3) } else { (0, BUS_ERROR, 0) };
        assert_eq!((rig.memory("%QX4.0"), states(&rig)[1], shown(&rig).0), expected, "{cause_gone}");
    }
}

// io:ERR-09, io:ERR-10, io:ERR-13, io:ERR-14: the controller of 2014 goes on with the others.
#[test]
fn passive_handling_goes_on_with_the_others() {
    let mut rig = two_modules(Profile::M241_2014);
    silence(&mut rig, 1, None);
    rig.to(run_at(ms(150)));
    assert_eq!((states(&rig), shown(&rig).0), ([OK, BUS_ERROR, EMPTY], 0));
    rig.plc.input(rig.now, input(1, 0), Value::Bool(false));
    rig.plc.input(rig.now, input(2, 0), Value::Bool(false));
    rig.to(run_at(ms(10_119)));
    // The input of the silent module is as it was last read, its terminal keeps what it had.
    assert_eq!((rig.memory("%QX4.0"), rig.memory("%IX6.0"), rig.memory("%QX6.0")), (0, 1, 1));
    assert_eq!(edges(&rig, 2, 0).len(), 1);
    rig.to(run_at(ms(10_130)));
    // 10 s after the first exchange that failed.
    assert_eq!(edges(&rig, 2, 0).last(), Some(&(us(10_120_000 + OUTPUT_DELAY), Value::Bool(false))));
    silence(&mut rig, 1, Some(0));
    rig.after(ms(100));
    assert_eq!((states(&rig)[1], rig.memory("%IX6.0"), shown(&rig).0), (OK, 0, 3));
}

fn command(rig: &mut Rig, variable: BusWrite, value: u64) {
    let mut fx = Effects::new();
    let probe = Probe::System(variable.into());
    rig.plc.write(rig.now, &probe, Value::Word(value), Cause::Unknown, &mut fx).unwrap();
}

// io:ERR-09, plcsystem:TM3V-03: as the controller of 2014, by command.
#[test]
fn passive_handling_is_commanded() {
    let mut rig = two_modules(Profile::M241_2019);
    command(&mut rig, BusWrite::ErrorPassive, 1);
    silence(&mut rig, 1, None);
    rig.to(run_at(ms(200)));
    assert_eq!((states(&rig), rig.memory("%QX4.0"), shown(&rig).0), ([OK, BUS_ERROR, EMPTY], 1, 0));
    // Active handling again: the bus goes off with the next exchange that fails.
    command(&mut rig, BusWrite::ErrorPassive, 0);
    rig.after(ms(30));
    assert_eq!((states(&rig), rig.memory("%QX4.0")), ([OK, BUS_ERROR, EMPTY], 0));
    // A reset forgets the command.
    command(&mut rig, BusWrite::ErrorPassive, 1);
    rig.command(Command::ResetWarm).unwrap();
    assert_eq!(rig.plc.read(&Probe::System(BusWrite::ErrorPassive.into())), Value::Word(0));
}

// io:ERR-16, io:ERR-17
#[test]
fn the_bus_restarts_by_an_edge_under_active_handling_with_the_cause_gone() {
    for (cause_gone, passive, before, restarts) in
        [(true, 0, 0, true), (false, 0, 0, false), (true, 1, 0, false), (true, 0, 1, false)]
    {
        let mut rig = two_modules(Profile::M241_2019);
        command(&mut rig, BusWrite::Restart, before);
        silence(&mut rig, 1, None);
        rig.to(run_at(ms(200)));
        assert_eq!(rig.memory("%QX4.0"), 0);
        if cause_gone {
            silence(&mut rig, 1, Some(0));
        }
        command(&mut rig, BusWrite::ErrorPassive, passive);
        command(&mut rig, BusWrite::Restart, 1);
        rig.after(ms(60));
        assert_eq!(rig.plc.state(), State::Running);
        let expected = if restarts { (1, OK, 3) } else { (0, BUS_ERROR, 0) };
        let found = (rig.memory("%QX4.0"), states(&rig)[1], shown(&rig).0);
        assert_eq!(found, expected, "{cause_gone} {passive} {before}");
    }
}

// io:OPT-03: an optional module that was missing is neither read nor written until the bus is started again.
#[test]
fn a_missing_optional_module_that_comes_back_waits_for_a_start() {
    let mut config = config();
    config.tasks = vec![task("MAST", 15, ms(20))];
    config.modules = vec![module(), ConfiguredModule { optional: true, ..module() }];
    let write = Act::Store(at("%QX6.0"), 1);
    let mut rig = Rig::running(config, Script::new(vec![vec![(1_000, write)]]));
    let reset = |rig: &mut Rig| {
        rig.command(Command::ResetWarm).unwrap();
        rig.command(Command::Run).unwrap();
        rig.after(ms(100));
    };
    silence(&mut rig, 1, None);
    reset(&mut rig);
    assert_eq!(states(&rig), [OK, ModuleState::MissingOptional, EMPTY]);
    silence(&mut rig, 1, Some(0));
    rig.after(ms(100));
    let output = Probe::Terminal(Terminal { module: 2, channel: IoChannel::Output(0) });
    assert_eq!((states(&rig)[1], rig.plc.read(&output)), (ModuleState::MissingOptional, Value::Bool(false)));
    reset(&mut rig);
    assert_eq!((states(&rig)[1], rig.plc.read(&output)), (OK, Value::Bool(true)));
}

/// Another module, of this ID code.
fn other(id: u8) -> &'static ModuleType {
    let mut other = module().module.clone();
    other.id = Some(id);
    Box::leak(Box::new(other))
}

// io:OPT-06, io:OPT-07, io:ERR-01: what is fitted is not what is configured.
#[test]
fn what_is_fitted_is_compared_at_the_start() {
    let own = module().module;
    let status = |status: IoStatus| u64::from(status.code());
    for (fitted, expected, shown_as) in [
        (vec![own, own], [OK, OK, EMPTY], (3, status(IoStatus::Ok), false)),
        (
            vec![own, other(201)],
            [OK, ModuleState::ConfigurationError, EMPTY],
            (0, status(IoStatus::ConfigurationFault), true),
        ),
        (vec![own, own, own], [OK, OK, EMPTY], (0, status(IoStatus::ConfigurationFault), true)),
        (vec![own], [OK, BUS_ERROR, EMPTY], (0, status(IoStatus::BusError), true)),
    ] {
        let mut config = config();
        config.tasks = vec![task("MAST", 15, ms(20))];
        (config.modules, config.fitted) = (vec![module(), module()], Some(fitted));
        let mut rig = Rig::running(config, copies());
        rig.plc.input(rig.now, input(1, 0), Value::Bool(true));
        rig.after(ms(100));
        assert_eq!((states(&rig), shown(&rig)), (expected, shown_as));
        assert_eq!(rig.memory("%IX4.0"), u64::from(!shown_as.2));
    }
}

// A module that is pulled takes the one after it along, at once; under passive handling both are driven again when it is back.
#[test]
fn a_pulled_module_ends_the_chain() {
    let mut rig = two_modules(Profile::M241_2014);
    let output = |rig: &Rig, module| {
        rig.plc.read(&Probe::Terminal(Terminal { module, channel: IoChannel::Output(0) }))
    };
    assert_eq!([1, 2].map(|module| output(&rig, module)), [Value::Bool(true); 2]);
    fault(&mut rig, 0, ModuleFault::Pulled(true));
    rig.after(ms(1));
    assert_eq!([1, 2].map(|module| output(&rig, module)), [Value::Bool(false); 2]);
    rig.after(ms(50));
    assert_eq!(states(&rig), [BUS_ERROR, BUS_ERROR, EMPTY]);
    fault(&mut rig, 0, ModuleFault::Pulled(false));
    rig.after(ms(60));
    assert_eq!(states(&rig), [OK, OK, EMPTY]);
    assert_eq!([1, 2].map(|module| output(&rig, module)), [Value::Bool(true); 2]);
}

// io:ERR-15: the module beside the disturbing one is in error and driven all the same.
#[test]
fn a_disturbed_module_is_in_error_and_exchanged() {
    let mut rig = two_modules(Profile::M241_2014);
    fault(&mut rig, 1, ModuleFault::Disturbs(true));
    rig.after(ms(60));
    assert_eq!(states(&rig), [BUS_ERROR, BUS_ERROR, EMPTY]);
    rig.plc.input(rig.now, input(1, 0), Value::Bool(false));
    rig.after(ms(60));
    assert_eq!((rig.memory("%IX4.0"), rig.memory("%QX4.0")), (0, 0));
}

// io:HW-04: without its supply the bus has a state of its own.
#[test]
fn a_bus_without_supply_reaches_nothing() {
    let mut rig = two_modules(Profile::M241_2019);
    let state = |rig: &Rig| rig.plc.read(&Probe::System(PlcRead::Tm3BusState.into()));
    disturb(&mut rig, Disturbance::BusSupply(false));
    assert_eq!(state(&rig), Value::Word(4));
    rig.after(ms(60));
    assert_eq!(states(&rig), [BUS_ERROR, BUS_ERROR, EMPTY]);
    disturb(&mut rig, Disturbance::BusSupply(true));
    rig.after(ms(60));
    assert_eq!((state(&rig), states(&rig)[0]), (Value::Word(3), BUS_ERROR));
    rig.command(Command::ResetWarm).unwrap();
    assert_eq!(states(&rig), [OK, OK, EMPTY]);
}
