//! Modules after the embedded I/O: an analogue one, and a digital one with more channels than a word has bits.

use crate::support::*;
use profile::{IoChannel, IoStatus, PlcRead};
use scanrig_controller::*;
use signal::{Address, Cause, Span, Time, Value};

/// From what is at an input to its conversion, and from a command to the output.
const CONVERSION: i64 = 5_000;
const SETTLING: i64 = 2_000;
/// What the output is set to where outputs take their default values.
const DEFAULT: u64 = 17;

/// Two inputs of millivolts at %IW3 and %IW4, an output of millivolts at %QW2.
#[derive(Debug)]
struct Analogue {
    channels: Vec<ModuleChannel>,
    /// By rank and channel.
    shared: Vec<Vec<bool>>,
    terminals: [i64; 2],
    converted: [u64; 2],
    conversion: Time,
    command: u64,
    shown: Option<u64>,
    output_due: Time,
    status: IoStatus,
}

impl Analogue {
    fn boxed(status: IoStatus) -> Box<dyn TaskModule> {
        let channel = |channel, text| ModuleChannel::new(channel, at(text));
        Box::new(Analogue {
            channels: vec![
                channel(IoChannel::Input(0), "%IW3"),
                channel(IoChannel::Input(1), "%IW4"),
                ModuleChannel { default: DEFAULT, ..channel(IoChannel::Output(0), "%QW2") },
            ],
            shared: Vec::new(),
            terminals: [0; 2],
            converted: [0; 2],
            conversion: Time::MAX,
            command: 0,
            shown: None,
            output_due: Time::MAX,
            status,
        })
    }

    fn exchanges(&self, cycle: ExchangeCycle, channel: usize) -> bool {
        cycle.rank.is_none_or(|rank| self.shared[rank][channel])
    }
}

impl IoModule for Analogue {
    fn channels(&self) -> &[ModuleChannel] {
        &self.channels
    }

    fn power_on(&mut self, now: Time) {
        self.converted = [0; 2];
        self.conversion = now + us(CONVERSION);
    }

    fn power_off(&mut self, _now: Time) {
        (self.conversion, self.output_due) = (Time::MAX, Time::MAX);
    }

    fn set_input(&mut self, now: Time, input: usize, value: Value) {
        if let (Some(terminal), Some(number)) = (self.terminals.get_mut(input), value.as_int()) {
            *terminal = number as i64;
            self.conversion = now + us(CONVERSION);
        }
    }

    fn initialize(&mut self, _now: Time) {
        (self.command, self.shown, self.output_due) = (0, None, Time::MAX);
    }

    fn next(&self) -> Time {
        self.conversion.min(self.output_due)
    }

    fn fire(&mut self, now: Time, changes: &mut OutputChanges<'_>) {
        if self.conversion <= now {
            self.conversion = Time::MAX;
            self.converted = self.terminals.map(|number| number as u64 & 0xFFFF);
        }
        if self.output_due <= now {
            changes.push(self.output_due, 0, Value::Int(self.command as i64), Cause::Controller);
            (self.shown, self.output_due) = (Some(self.command), Time::MAX);
        }
    }

    fn output(&self, output: usize) -> Value {
        self.shown.filter(|_| output == 0).map_or(Value::Unknown, |shown| Value::Int(shown as i64))
    }
}

impl TaskModule for Analogue {
    fn share(&mut self, sharing: &Sharing<'_>) {
        let of = |rank: usize| self.channels.iter().map(|it| sharing.exchanges(rank, it.address)).collect();
        self.shared = (0..sharing.tasks()).map(of).collect();
    }

    fn sample(&mut self, _now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> bool {
        let mut changed = false;
        for input in (0..2).filter(|input| self.exchanges(cycle, *input)) {
            let address = self.channels[input].address;
            changed |= memory.load(address) != self.converted[input];
            memory.set_cause(Cause::Board);
            memory.store(address, self.converted[input]);
        }
        changed
    }

    fn drive(&mut self, now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> Written {
        let command = memory.load(self.channels[2].address);
        if self.exchanges(cycle, 2) && command != self.command {
            (self.command, self.output_due) = (command, now + us(SETTLING));
        }
        Written::default()
    }

    fn status(&self) -> IoStatus {
        self.status
    }
}

/// Forty inputs from %IX8.0 on, without delay.
#[derive(Debug)]
struct Digital {
    channels: Vec<ModuleChannel>,
    levels: Vec<bool>,
    shared: Vec<Vec<bool>>,
}

impl IoModule for Digital {
    fn channels(&self) -> &[ModuleChannel] {
        &self.channels
    }

    fn power_on(&mut self, _now: Time) {}

    fn power_off(&mut self, _now: Time) {}

    fn set_input(&mut self, _now: Time, input: usize, value: Value) {
        if let Some(level) = self.levels.get_mut(input) {
            *level = value.as_bool().unwrap_or(false);
        }
    }

    fn initialize(&mut self, _: Time) {}

    fn next(&self) -> Time {
        Time::MAX
    }

    fn fire(&mut self, _: Time, _: &mut OutputChanges<'_>) {}

    fn output(&self, _: usize) -> Value {
        Value::Unknown
    }
}

impl TaskModule for Digital {
    fn share(&mut self, sharing: &Sharing<'_>) {
        let of = |rank: usize| self.channels.iter().map(|it| sharing.exchanges(rank, it.address)).collect();
        self.shared = (0..sharing.tasks()).map(of).collect();
    }

    fn sample(&mut self, _now: Time, cycle: ExchangeCycle, memory: &mut Memory) -> bool {
        let mut changed = false;
        for (n, channel) in self.channels.iter().enumerate() {
            if cycle.rank.is_none_or(|rank| self.shared[rank][n]) {
                changed |= memory.load(channel.address) != u64::from(self.levels[n]);
                memory.store(channel.address, self.levels[n].into());
            }
        }
        changed
    }

    fn drive(&mut self, _: Time, _: ExchangeCycle, _: &mut Memory) -> Written {
        Written::default()
    }

    fn status(&self) -> IoStatus {
        IoStatus::Ok
    }
}

/// The output of the analogue module, where it is module 1.
const OUTPUT: Probe = Probe::Terminal(Terminal { module: 1, channel: IoChannel::Output(0) });

/// MAST copies %IW3 to %QW2 and nothing else.
fn copying() -> Script {
    Script::new(vec![vec![(1_000, Act::Copy(at("%IW3"), at("%QW2")))]])
}

fn input(module: usize, input: usize) -> Terminal {
    Terminal { module, channel: IoChannel::Input(input) }
}

#[test]
fn an_analogue_value_goes_through_the_images() {
    let mut rig = Rig::running_with(config(), copying(), vec![Analogue::boxed(IoStatus::Ok)]);
    let output = Terminal { module: 1, channel: IoChannel::Output(0) };
    assert_eq!(rig.plc.terminal(at("%IW3")), Some(input(1, 0)));
    assert_eq!(rig.plc.terminal(at("%QW2")), Some(output));
    assert_eq!(rig.plc.terminal(at("%IW5")), None);
    rig.to(run_at(ms(61)));
    rig.plc.input(rig.now, input(1, 0), Value::Int(4_711));
    // Converted at 66 ms, read at 80 ms, written a microsecond later, shown after the settling time.
    rig.to(run_at(ms(79)));
    assert_eq!(rig.memory("%IW3"), 0);
    rig.to(run_at(ms(90)));
    assert_eq!(rig.memory("%IW3"), 4_711);
    let shown = Effect::Terminal {
        at: run_at(us(80_001 + SETTLING)),
        terminal: output,
        value: Value::Int(4_711),
        cause: Cause::Controller,
        early: Span::ZERO,
    };
    assert!(rig.seen.contains(&shown), "{:?}", rig.seen);
    assert_eq!(rig.plc.read(&Probe::Terminal(output)), Value::Int(4_711));
}

// controller:PRIO-04, controller:DEV-12: what no task uses belongs to the bus cycle task, or to nobody.
#[test]
fn an_unused_channel_is_exchanged_as_configured() {
    for (always_update, expected) in [(AlwaysUpdate::Unused, 12), (AlwaysUpdate::Disabled, 0)] {
        let mut config = Config::new(profile::Profile::M251_2024);
        config.always_update = always_update;
        let mut rig = Rig::running_with(config, copying(), vec![Analogue::boxed(IoStatus::Ok)]);
        rig.plc.input(rig.now, input(1, 1), Value::Int(12));
        rig.after(ms(50));
        assert_eq!(rig.memory("%IW4"), expected, "{always_update:?}");
    }
}

// controller:SYS-06
#[test]
fn a_module_that_is_not_in_order_shows_in_the_status_of_expansion_modules() {
    for status in [IoStatus::Ok, IoStatus::ConfigurationFault] {
        let rig = Rig::running_with(config(), copying(), vec![Analogue::boxed(status)]);
        let shown = rig.plc.read(&Probe::System(PlcRead::IoStatus2.into()));
        assert_eq!(shown, Value::Word(u64::from(status.code())));
    }
}

#[test]
fn a_module_has_any_number_of_channels() {
    let place = |n: usize| Address::bit(signal::Area::Input, 64 + n as u32);
    let channels = (0..40).map(|n| ModuleChannel::new(IoChannel::Input(n), place(n))).collect();
    let module = Digital { channels, levels: vec![false; 40], shared: Vec::new() };
    let script = Script::new(vec![vec![(1_000, Act::Copy(at("%IX12.7"), at("%MX2.0")))]]);
    let modules: Vec<Box<dyn TaskModule>> = vec![Analogue::boxed(IoStatus::Ok), Box::new(module)];
    let mut rig = Rig::running_with(config(), script, modules);
    assert_eq!(rig.plc.terminal(at("%IX12.7")), Some(input(2, 39)));
    rig.plc.input(rig.now, input(2, 39), Value::Bool(true));
    rig.after(ms(50));
    assert_eq!(rig.memory("%MX2.0"), 1);
}

// controller:STOP-03, controller:STOP-04
#[test]
fn outputs_of_a_module_fall_back_as_the_embedded_ones_do() {
    let default = Value::Int(DEFAULT as i64);
    for (outputs_in_stop, expected) in [
        // Set to the default at each update, or left as they are in %Q.
        (OutputsInStop::Default, [default, default]),
        (OutputsInStop::Keep, [Value::Int(4_711), Value::Int(99)]),
    ] {
        let config = Config { outputs_in_stop, update_io_in_stop: true, ..config() };
        let mut rig = Rig::running_with(config, copying(), vec![Analogue::boxed(IoStatus::Ok)]);
        rig.plc.input(rig.now, input(1, 0), Value::Int(4_711));
        rig.after(ms(100));
        rig.command(Command::Stop).unwrap();
        rig.after(ms(100));
        let stopped = rig.plc.read(&OUTPUT);
        let (now, at) = (rig.now, Probe::Address(at("%QW2")));
        rig.plc.write(now, &at, Value::Int(99), Cause::Unknown, &mut Effects::new()).unwrap();
        rig.after(ms(100));
        assert_eq!([stopped, rig.plc.read(&OUTPUT)], expected, "{outputs_in_stop:?}");
    }
}

#[test]
fn a_module_without_supply_does_nothing() {
    let config = config();
    let hold_up = config.profile.hold_up();
    let mut rig = Rig::running_with(config, copying(), vec![Analogue::boxed(IoStatus::Ok)]);
    rig.after(ms(100));
    rig.power_off();
    rig.after(hold_up + us(-CONVERSION / 2));
    // Its conversion would end after the supply is gone.
    rig.plc.input(rig.now, input(1, 0), Value::Int(4_711));
    rig.after(us(CONVERSION / 2 + 100));
    assert_eq!((rig.plc.state(), rig.plc.next_timer()), (State::Off, None));
}

// controller:SYS-06
#[test]
fn modules_are_not_initialised_without_an_application() {
    let mut rig = Rig::running_with(config(), copying(), vec![Analogue::boxed(IoStatus::Ok)]);
    rig.command(Command::ResetOrigin).unwrap();
    rig.after(ms(100));
    assert_eq!(rig.plc.state(), State::Empty);
    let shown = rig.plc.read(&Probe::System(PlcRead::IoStatus2.into()));
    assert_eq!(shown, Value::Word(u64::from(IoStatus::NotInitialised.code())));
}
