//! Analogue modules on the expansion bus: words, status bytes, filters, the grid of conversions, outputs.

use crate::support::*;
use profile::{
    AnalogueChannels, AnalogueInputSettings, AnalogueMode, AnalogueOutputSettings, BusWrite,
    ConfiguredModule, Conversion, CountRange, IoChannel, ModuleFamily, ModuleKind, ModuleType, Profile,
};
use scanrig_controller::*;
use signal::{Decimal, Span, Time, Unit, Value};
use std::sync::OnceLock;

fn mode(name: &str, unit: &str, ends: (i128, i128), limits: Option<(i128, i128)>) -> AnalogueMode {
    let hundredths = |number| Some(Decimal::new(number, -2));
    AnalogueMode {
        name: name.into(),
        unit: Unit::new(unit),
        low: Some(Decimal::from(ends.0)),
        high: Some(Decimal::from(ends.1)),
        under_range: limits.and_then(|(under, _)| hundredths(under)),
        over_range: limits.and_then(|(_, over)| hundredths(over)),
        step: (unit == "degC").then(|| Decimal::new(1, -1)),
        extended: false,
        sources: Vec::new(),
    }
}

/// Three inputs of 16 bit, of which a voltage or a current takes 5 ms to be converted and a temperature 50 ms, where conversions
/// take time at all; two outputs of 12 bit.
fn module_type(takes_time: bool) -> &'static ModuleType {
    static MODULES: OnceLock<[ModuleType; 2]> = OnceLock::new();
    let modules = MODULES.get_or_init(|| {
        [false, true].map(|takes_time| {
            let modes = vec![
                mode("0..10 V", "V", (0, 10), Some((-20, 1_020))),
                mode("4..20 mA", "mA", (4, 20), Some((368, 2_032))),
                mode("PT100", "degC", (-200, 850), None),
            ];
            let conversion = |per_channel| {
                takes_time.then(|| Conversion { fixed: ms(1), per_channel: vec![ms(per_channel), ms(2)] })
            };
            let channels = |count, bits, conversions: [Option<Conversion>; 2]| {
                let [conversion, temperature_conversion] = conversions;
                let modes = modes.clone();
                Some(AnalogueChannels { count, bits: Some(bits), modes, conversion, temperature_conversion })
            };
            let mut module = ModuleType::new("TM3TEST", ModuleFamily::Tm3, ModuleKind::Analogue);
            module.id = Some(201);
            module.profiles = vec![Profile::M241_2019];
            module.analogue_inputs = channels(3, 16, [conversion(5), conversion(50)]);
            module.analogue_outputs = channels(2, 12, [None, None]);
            module
        })
    });
    &modules[usize::from(takes_time)]
}

fn input_of(module: &'static ModuleType, mode: &str, filter: Span) -> Option<AnalogueInputSettings<'static>> {
    let mode = module.analogue_inputs.as_ref().unwrap().mode(mode).unwrap();
    let counts = CountRange::new(0, 10_000).unwrap();
    Some(AnalogueInputSettings { counts, filter, ..AnalogueInputSettings::new(mode) })
}

fn output_of(
    module: &'static ModuleType,
    mode: &str,
    fallback: i16,
) -> Option<AnalogueOutputSettings<'static>> {
    let mode = module.analogue_outputs.as_ref().unwrap().mode(mode).unwrap();
    let counts = CountRange::new(0, 10_000).unwrap();
    Some(AnalogueOutputSettings { fallback, ..AnalogueOutputSettings::new(mode, counts) })
}

/// MAST every 20 ms stores this word in the first output; one module, with inputs from %IW2 on, status bytes from %IB10 on, outputs
/// from %QW2 on.
fn rig(module: ConfiguredModule<'static>, word: u64) -> Rig {
    let mut config = config();
    config.tasks = vec![task("MAST", 15, ms(20))];
    config.modules = vec![module];
    Rig::running(config, Script::new(vec![vec![(1_000, Act::Store(at("%QW2"), word))]]))
}

fn set(rig: &mut Rig, input: usize, value: Value) {
    rig.plc.input(rig.now, Terminal { module: 1, channel: IoChannel::Input(input) }, value);
}

/// What the terminal of an output showed, and when, since the power came on.
fn shown(rig: &Rig, output: usize) -> Vec<(Span, Value)> {
    let wanted = Terminal { module: 1, channel: IoChannel::Output(output) };
    let of = |effect: &Effect| match *effect {
        Effect::Terminal { at, terminal, value, .. } if terminal == wanted => {
            Some((at - run_at(Span::ZERO), value))
        }
        _ => None,
    };
    rig.seen.iter().filter_map(of).collect()
}

fn silence(rig: &mut Rig, exchanges: Option<u32>) {
    let fault = ModuleFault::Silent(exchanges);
    rig.plc.disturb(rig.now, Disturbance::Module { index: 0, fault }, &mut Effects::new());
}

// io:ADR-05, io:DIAG-06
#[test]
fn inputs_are_words_with_their_status() {
    let module = module_type(false);
    let inputs = ["0..10 V", "4..20 mA", "PT100"].map(|mode| input_of(module, mode, Span::ZERO));
    let mut rig = rig(ConfiguredModule { inputs: inputs.to_vec(), ..ConfiguredModule::new(module) }, 0);
    let words = |rig: &Rig| ["%IW2", "%IW3", "%IW4"].map(|at| rig.memory(at) as u16 as i16);
    let status = |rig: &Rig| ["%IB10", "%IB11", "%IB12"].map(|at| rig.memory(at));
    rig.after(ms(40));
    // Nothing is connected: no voltage, an open loop, an open sensor.
    assert_eq!((words(&rig), status(&rig)), ([0, -200, 8_500], [0, 6, 5]));
    set(&mut rig, 0, Value::Real(5.0));
    set(&mut rig, 1, Value::Measured(12.0, 0.01));
    set(&mut rig, 2, Value::Real(-40.05));
    rig.after(ms(40));
    assert_eq!((words(&rig), status(&rig)), ([5_000, 5_000, -401], [0, 0, 0]));
    set(&mut rig, 0, Value::Real(11.0));
    set(&mut rig, 1, Value::HighZ);
    set(&mut rig, 2, Value::HighZ);
    rig.after(ms(40));
    assert_eq!((words(&rig), status(&rig)), ([10_200, -200, 8_500], [5, 6, 5]));
    // A line that is not known keeps its value, and so it is with what is no number.
    set(&mut rig, 0, Value::Real(2.5));
    set(&mut rig, 0, Value::Unknown);
    set(&mut rig, 0, Value::Real(f64::NAN));
    rig.after(ms(40));
    assert_eq!((words(&rig)[0], status(&rig)[0]), (2_500, 0));
}

// io:DIAG-06: without Status Enabled there are no status bytes, and a channel that is not used is at 0.
#[test]
fn what_is_not_used_is_not_there() {
    let module = module_type(false);
    let inputs = vec![None, input_of(module, "0..10 V", Span::ZERO)];
    let configured = ConfiguredModule { inputs, status_enabled: false, ..ConfiguredModule::new(module) };
    let mut rig = rig(configured, 5_000);
    for input in 0..3 {
        set(&mut rig, input, Value::Real(20.0));
    }
    rig.after(ms(40));
    let words = ["%IW2", "%IW3", "%IW4"].map(|at| rig.memory(at));
    assert_eq!((words, rig.memory("%IB11")), ([0, 10_200, 0], 0));
    assert_eq!(rig.plc.terminal(at("%IW2")), None);
    assert_eq!(rig.plc.terminal(at("%IW3")), Some(Terminal { module: 1, channel: IoChannel::Input(1) }));
    assert_eq!(shown(&rig, 0), []);
}

// A lag of the first order: after 9 ms of 100 ms 8.6069 % of a step are there, after 29 ms 25.1736 %.
#[test]
fn a_filter_is_a_lag_of_the_first_order() {
    let module = module_type(false);
    let inputs = vec![input_of(module, "0..10 V", ms(100))];
    let mut rig = rig(ConfiguredModule { inputs, ..ConfiguredModule::new(module) }, 0);
    rig.to(run_at(ms(31)));
    set(&mut rig, 0, Value::Real(10.0));
    let mut seen = Vec::new();
    for at in [41, 61, 5_021] {
        rig.to(run_at(ms(at)));
        seen.push(rig.memory("%IW2"));
    }
    assert_eq!(seen, [861, 2_517, 10_000]);
    // A second change begins where the first has come to: 10 V (1 - e^-1) after 100 ms.
    set(&mut rig, 0, Value::Real(0.0));
    rig.to(run_at(ms(5_121)));
    set(&mut rig, 0, Value::Real(10.0));
    rig.to(run_at(ms(5_221)));
    // At 5220 ms: 10 V (1 - (1 - e^-1) e^-0.99) = 7.6512 V.
    assert_eq!(rig.memory("%IW2"), 7_651);
}

// Conversions take 1 ms, and 5 ms, 5 ms and 50 ms of the channels: the second one is converted 11 ms after power-on and then every
// 61 ms.
#[test]
fn an_input_is_as_old_as_its_last_conversion() {
    let module = module_type(true);
    let inputs = ["0..10 V", "0..10 V", "PT100"].map(|mode| input_of(module, mode, Span::ZERO));
    let configured = ConfiguredModule { inputs: inputs.to_vec(), ..ConfiguredModule::new(module) };
    let mut rig = rig(configured, 0);
    let powered = run_at(Span::ZERO).as_nanos() - BOOT.as_nanos();
    // Conversions of the second input around 100 ms of RUNNING.
    let (first, round) = (powered + 11_000_000, 61_000_000);
    let turn = (run_at(ms(100)).as_nanos() - first) / round + 1;
    let conversion = Time::from_nanos(first + turn * round);
    rig.to(conversion);
    // What comes at the very instant of a conversion is converted at the next one.
    set(&mut rig, 1, Value::Real(4.0));
    let next = conversion.saturating_add(Span::from_nanos(round));
    let mut seen = Vec::new();
    while rig.now < next.saturating_add(ms(20)) {
        rig.after(ms(1));
        seen.push((rig.now, rig.memory("%IW3")));
    }
    let changed = seen.iter().find(|(_, word)| *word == 4_000).map(|(at, _)| *at).unwrap();
    assert!(changed > next && changed <= next.saturating_add(ms(21)), "{changed} {next}");
    // What is gone before the next conversion was never there.
    rig.to(next.saturating_add(Span::from_nanos(round + 1)));
    set(&mut rig, 1, Value::Real(9.0));
    rig.after(ms(50));
    set(&mut rig, 1, Value::Real(4.0));
    rig.after(ms(60));
    assert_eq!(rig.memory("%IW3"), 4_000);
}

// controller:OUT-02, controller:STOP-03
#[test]
fn outputs_show_nothing_then_their_words_then_their_fallback() {
    let module = module_type(false);
    let outputs = vec![output_of(module, "0..10 V", 2_500), output_of(module, "4..20 mA", 0)];
    let mut rig = rig(ConfiguredModule { outputs, ..ConfiguredModule::new(module) }, 5_000);
    assert_eq!(
        rig.plc.read(&Probe::Terminal(Terminal { module: 1, channel: IoChannel::Output(7) })),
        Value::Unknown
    );
    rig.after(ms(30));
    assert_eq!(shown(&rig, 0).last(), Some(&(us(1), Value::Real(5.001_221_001))));
    assert_eq!(shown(&rig, 1).last().map(|(_, value)| *value), Some(Value::Real(4.0)));
    rig.command(Command::Stop).unwrap();
    rig.after(ms(30));
    assert_eq!(rig.memory("%QW2"), 2_500);
    assert_eq!(shown(&rig, 0).last().map(|(_, value)| *value), Some(Value::Real(2.500_610_501)));
    rig.command(Command::ResetOrigin).unwrap();
    rig.after(ms(30));
    assert_eq!(shown(&rig, 1).last().map(|(_, value)| *value), Some(Value::HighZ));
}

// io:ERR-06, io:ERR-10: no voltage and no current, whatever the words are.
#[test]
fn outputs_of_a_silent_module_are_off() {
    let module = module_type(false);
    let outputs = vec![output_of(module, "0..10 V", 0), output_of(module, "4..20 mA", 0)];
    let configured = ConfiguredModule { outputs, ..ConfiguredModule::new(module) };
    let mut active = rig(configured.clone(), 5_000);
    active.to(run_at(ms(10)));
    silence(&mut active, None);
    active.to(run_at(ms(50)));
    assert_eq!(shown(&active, 1).last(), Some(&(ms(40), Value::Real(0.0))));
    assert_eq!((shown(&active, 0).last(), active.memory("%QW2")), (Some(&(ms(40), Value::Real(0.0))), 0));
    let mut passive = rig(configured, 5_000);
    let mut fx = Effects::new();
    let probe = Probe::System(BusWrite::ErrorPassive.into());
    passive.plc.write(passive.now, &probe, Value::Word(1), signal::Cause::Unknown, &mut fx).unwrap();
    passive.to(run_at(ms(10)));
    silence(&mut passive, None);
    passive.to(run_at(ms(10_019)));
    assert_eq!(shown(&passive, 1).last().map(|(_, value)| *value), Some(Value::Real(4.0)));
    passive.to(run_at(ms(10_030)));
    assert_eq!(shown(&passive, 1).last(), Some(&(ms(10_020), Value::Real(0.0))));
    assert_eq!(passive.memory("%QW2"), 5_000);
    silence(&mut passive, Some(0));
    passive.after(ms(40));
    assert_eq!(shown(&passive, 0).last().map(|(_, value)| *value), Some(Value::Real(5.001_221_001)));
}

/// What is not there drives nothing, whatever becomes of the bus.
#[test]
fn outputs_of_a_pulled_module_stay_undriven() {
    let module = module_type(false);
    let outputs = vec![output_of(module, "0..10 V", 0), output_of(module, "4..20 mA", 0)];
    let configured = ConfiguredModule { outputs, ..ConfiguredModule::new(module) };
    for passive in [0, 1] {
        let mut rig = rig(configured.clone(), 5_000);
        let mut fx = Effects::new();
        let probe = Probe::System(BusWrite::ErrorPassive.into());
        rig.plc.write(rig.now, &probe, Value::Word(passive), signal::Cause::Unknown, &mut fx).unwrap();
        rig.to(run_at(ms(10)));
        let pull = |rig: &mut Rig, pulled| {
            let what = Disturbance::Module { index: 0, fault: ModuleFault::Pulled(pulled) };
            rig.plc.disturb(rig.now, what, &mut Effects::new());
        };
        pull(&mut rig, true);
        rig.to(run_at(ms(12_000)));
        for output in [0, 1] {
            assert_eq!(shown(&rig, output).last(), Some(&(ms(10), Value::HighZ)), "{passive} {output}");
        }
        pull(&mut rig, false);
        rig.command(Command::ResetWarm).unwrap();
        rig.after(ms(5_000));
        rig.command(Command::Run).unwrap();
        rig.after(ms(100));
        assert_eq!(
            shown(&rig, 0).last().map(|(_, value)| *value),
            Some(Value::Real(5.001_221_001)),
            "{passive}"
        );
    }
}
