//! Expert functions in the controller: what their outputs show, and who has a say in it.

use crate::support::*;
use expert::{ExpertConfig, FunctionConfig, FunctionKind, FunctionProbe, WaveConfig};
use profile::{BounceFilter, ChannelSet, InputFilter, IoChannel};
use scanrig_controller::*;
use signal::{Address, Area, Level, Span, Time, Value};

/// A PWM on Q0 that I0 may enable, and a generator on Q4, which is no fast output.
fn functions() -> ExpertConfig {
    let pwm = WaveConfig { enable: Some(0), ..WaveConfig::new(0) };
    let generator = WaveConfig::new(4);
    let function = |name: &str, kind| FunctionConfig { name: name.into(), kind };
    ExpertConfig {
        functions: vec![
            function("PWM0", FunctionKind::Pwm(pwm)),
            function("FG0", FunctionKind::Generator(generator)),
        ],
    }
}

/// Once a cycle: 1 kHz with 50 % at Q0, all outputs of the first byte to 1 in the image.
fn script() -> Script {
    Script::new(vec![vec![
        (1_000, Act::Block("PWM_M241", &[(0, 1), (1, 1), (2, 10_000), (3, 50)])),
        (1_000, Act::Store(at("%QB0"), 0xFF)),
        (1_000, Act::Copy(at("%IX0.0"), at("%MX0.0"))),
    ]])
}

fn with(change: impl FnOnce(&mut Config)) -> Rig {
    let mut config = config();
    config.expert = functions();
    change(&mut config);
    Rig::running(config, script())
}

/// The edges at Q`output` from `from` on.
fn edges(rig: &Rig, wanted: usize, from: Time) -> Vec<(Time, Level)> {
    let edge = |effect: &Effect| match *effect {
        Effect::Terminal { at, terminal, value, .. }
            if terminal == Terminal::output(wanted) && at >= from =>
        {
            Some((at, level_of(value)))
        }
        _ => None,
    };
    rig.seen.iter().filter_map(edge).collect()
}

// io:OUT-21, io:HSC-05, io:STD-PWM-01: the block's first call is complete 1 us into the first cycle at 1.5 s.
#[test]
fn a_function_drives_its_output_and_the_image_has_no_say() {
    let mut rig = with(|_| ());
    let begin = rig.now;
    rig.after(Span::from_micros(1_700));
    let us = |us: i64, level| (begin + Span::from_micros(us), level);
    // 2 us after each command (io:STD-OUT-01); Q0 is driven to 0 before.
    let expected = [us(3, Level::High), us(503, Level::Low), us(1003, Level::High), us(1503, Level::Low)];
    assert_eq!(edges(&rig, 0, begin + Span::from_micros(3)), expected);
    assert_eq!(rig.terminal(1), Level::High);
    assert_eq!(rig.terminal(4), Level::Low, "the generator is not enabled, whatever its bit of %Q");
}

#[test]
fn slices_do_not_move_edges() {
    let run = |slices: &[i64]| {
        let mut rig = with(|_| ());
        rig.slices = slices.to_vec();
        rig.after(ms(50));
        edges(&rig, 0, Time::ZERO)
    };
    let whole = run(&[]);
    assert!(whole.len() > 90);
    assert_eq!(run(&[700, 1, 33_333]), whole);
    assert_eq!(run(&[1_000, 250_000]), whole);
}

// io:OUT-19, io:OUT-20
#[test]
fn outputs_of_functions_rest_in_stopped() {
    for (option, rest) in [(OutputsInStop::Keep, Level::Low), (OutputsInStop::Default, Level::High)] {
        for update in [true, false] {
            let mut rig = with(|config| {
                config.outputs_in_stop = option;
                config.update_io_in_stop = update;
                config.output_defaults = ChannelSet::from_iter([0, 4]);
            });
            rig.after(ms(5));
            rig.command(Command::Stop).unwrap();
            let stopped = rig.now + Span::from_micros(300);
            rig.after(ms(60));
            assert_eq!((rig.terminal(0), rig.terminal(4)), (rest, rest), "{option:?}");
            assert_eq!(edges(&rig, 0, stopped), [], "nothing moves any more");
            rig.command(Command::Run).unwrap();
            rig.after(ms(5));
            assert!(edges(&rig, 0, stopped).len() > 6, "it goes on in RUNNING");
            assert_eq!(rig.terminal(4), Level::Low);
        }
    }
}

// io:OUT-24, io:OUT-25
#[test]
fn outputs_of_functions_show_defaults_behind_downloads_and_resets() {
    for (command, others) in [
        (Command::Download(b"app".to_vec()), Level::Low),
        (Command::ResetCold, Level::Low),
        (Command::ResetOrigin, Level::HighZ),
    ] {
        let mut rig = with(|config| {
            config.output_defaults = ChannelSet::from_iter([0, 4]);
            config.outputs_in_stop = OutputsInStop::Keep;
        });
        rig.after(ms(5));
        let before = rig.now;
        rig.command(command.clone()).unwrap();
        rig.after(ms(60));
        assert_eq!((rig.terminal(0), rig.terminal(4)), (Level::High, Level::High), "{command:?}");
        assert_eq!(rig.terminal(2), others, "{command:?}");
        let floats = edges(&rig, 0, before).iter().any(|(_, level)| *level == Level::HighZ);
        assert!(!floats, "{command:?}");
    }
}

// io:OUT-21
#[test]
fn outputs_of_functions_cannot_be_forced() {
    let mut rig = with(|_| ());
    let force = |bit| Command::Force { address: Address::bit(Area::Output, bit), value: 1 };
    assert_eq!(rig.command(force(0)), Err(CommandError::ExpertOutput(0)));
    assert_eq!(rig.command(force(4)), Err(CommandError::ExpertOutput(4)));
    assert_eq!(rig.command(force(1)), Ok(()));
}

// io:EIO-12, io:EIO-14, io:STD-IN-03
#[test]
fn inputs_of_functions_have_the_anti_bounce_filter_and_an_image() {
    for bounce in [BounceFilter::default(), BounceFilter::ALL[3]] {
        let mut rig = with(|config| {
            config.inputs = vec![InputConfig { bounce, ..InputConfig::filtered(InputFilter::Ms4) }];
        });
        let filtered = rig.plc.watch(Probe::Input { input: 0, part: InputProbe::Filtered });
        rig.after(ms(3));
        let rise = rig.now;
        rig.plc.input(rise, Terminal::input(0), Value::from(Level::High));
        rig.after(ms(50));
        let at = rig.seen.iter().find_map(|effect| match effect {
            Effect::Changed { at, probe, value: Value::Bool(true), .. } if *probe == filtered => Some(*at),
            _ => None,
        });
        assert_eq!(at, Some(rise + Span::from_micros(2) + bounce.span()));
        assert_eq!(rig.plc.read(&Probe::Address(crate::support::at("%MX0.0"))), Value::Bool(true));
    }
}

// io:OUT-06, io:STD-OUT-02
#[test]
fn protection_switches_the_outputs_of_functions_off() {
    let mut rig = with(|_| ());
    rig.after(ms(5));
    rig.plc.disturb(rig.now, Disturbance::ShortCircuit { output: 0, on: true }, &mut rig.fx);
    let begin = rig.now;
    rig.after(ms(20));
    assert!(edges(&rig, 0, begin).len() < 4, "{:?}", edges(&rig, 0, begin));
    assert_eq!(rig.terminal(0), Level::HighZ);
}

#[test]
fn facts_are_observed_when_they_change() {
    let mut rig = with(|_| ());
    let pulses = rig.plc.watch(Probe::Expert { function: 0, fact: FunctionProbe::Pulses });
    let begin = rig.now;
    rig.after(Span::from_micros(2_500));
    let changes: Vec<_> = rig
        .seen
        .iter()
        .filter_map(|effect| match effect {
            Effect::Changed { at, probe, value, .. } if *probe == pulses => Some((*at - begin, *value)),
            _ => None,
        })
        .collect();
    let us = Span::from_micros;
    assert_eq!(changes, [1, 2, 3].map(|n| (us(1 + (n - 1) * 1_000), Value::Int(n))));
}

// io:EIO-12: the level at power-on is an edge for the functions as for the filters.
#[test]
fn levels_at_power_on_reach_the_functions() {
    let mut config = config();
    config.expert = functions();
    let enabled = Act::Block("PWM_M241", &[(0, 1), (5, 1), (2, 10_000), (3, 50)]);
    let mut rig = Rig::off(config, Script::new(vec![vec![(1_000, enabled)]]));
    rig.plc.commission(b"app", State::Running).unwrap();
    rig.plc.input(rig.now, Terminal::input(0), Value::from(Level::High));
    rig.power_on();
    rig.after(BOOT);
    rig.settle();
    let begin = rig.now;
    rig.after(ms(10));
    assert!(edges(&rig, 0, begin).len() > 15, "EN is 1");
    rig.power_off();
    rig.after(Span::from_secs(1));
    assert_eq!(rig.plc.state(), State::Off);
    rig.plc.input(rig.now, Terminal::input(0), Value::from(Level::Low));
    rig.power_on();
    rig.after(BOOT);
    rig.settle();
    let again = rig.now;
    rig.after(ms(10));
    assert!(edges(&rig, 0, again + ms(1)).is_empty(), "EN is 0");
}

/// What Q0 was commanded, waves and levels.
fn shown(rig: &Rig, from: Time) -> Vec<(Time, &'static str)> {
    let what = |effect: &Effect| match *effect {
        Effect::Terminal { at, terminal, value, .. } if terminal == Terminal::output(0) && at >= from => {
            Some((
                at,
                match level_of(value) {
                    Level::Low => "0",
                    Level::High => "1",
                    Level::HighZ => "Z",
                },
            ))
        }
        Effect::Wave { at, output: 0, period, high, .. } if at >= from => {
            assert_eq!((period, high), (ms(1), us(500)));
            Some((at, "pulses"))
        }
        _ => None,
    };
    rig.seen.iter().filter_map(what).collect()
}

// io:OUT-19, io:OUT-20, io:OUT-06: whoever makes the pulses of an output hears of all that ends them.
#[test]
fn an_output_whose_pulses_somebody_else_makes_follows_state_protection_and_supply() {
    let mut config = config();
    config.expert = functions();
    let mut rig = Rig::off(config, script());
    rig.plc.commission(b"app", State::Running).unwrap();
    rig.plc.offload_pulses(&[IoChannel::Output(0)]);
    rig.power_on();
    let begin = run_at(Span::ZERO);
    rig.to(begin + ms(50));
    assert_eq!(shown(&rig, begin), [(begin + us(3), "pulses")]);
    assert_eq!(rig.plc.read(&Probe::Terminal(Terminal::output(0))), Value::Unknown);
    let mut at = rig.now;
    rig.plc.disturb(at, Disturbance::IoSupply(false), &mut rig.fx);
    rig.after(ms(10));
    rig.plc.disturb(rig.now, Disturbance::IoSupply(true), &mut rig.fx);
    rig.after(ms(10));
    let back = at + ms(10) + us(2);
    assert_eq!(shown(&rig, at), [(at, "Z"), (back, "pulses")]);
    at = rig.now;
    rig.command(Command::Stop).unwrap();
    rig.after(ms(30));
    assert_eq!(shown(&rig, at).iter().map(|(_, what)| *what).collect::<Vec<_>>(), ["0"]);
    at = rig.now;
    rig.command(Command::Run).unwrap();
    rig.after(ms(30));
    assert_eq!(shown(&rig, at).iter().map(|(_, what)| *what).collect::<Vec<_>>(), ["pulses"]);
    // It stays so over a power cycle.
    at = rig.now;
    rig.power_off();
    rig.after(ms(500));
    rig.power_on();
    rig.after(Span::from_secs(3));
    assert_eq!(shown(&rig, at).last().map(|(_, what)| *what), Some("pulses"));
}
