//! A safety module: a model of its documented function. It is no safety device.

use super::BusModule;
use crate::memory::Memory;
use crate::module::{IoModule, ModuleChannel, OutputChanges};
use profile::{IoChannel, ModuleAddresses, ModuleType};
use signal::{Address, Cause, Image, Span, Time, Value};

/// The longest that the two safety inputs may differ (rig definition: the documents have no figure).
const SYNCHRONISATION: Span = Span::from_millis(500);

/// Its inputs in the image, in the order of the catalogue. The safety inputs and start have terminals.
const INPUTS: usize = 8;
const FIRST: usize = 2;
const SECOND: usize = 3;
const START: usize = 4;

/// The module. Its output closes with both relays: K1 after a start while the safety inputs are closed, K2 while the controller
/// enables it, too. The output of the image is that condition, the terminal the contact.
#[derive(Debug)]
pub(super) struct SafetyModule {
    channels: Vec<ModuleChannel>,
    /// The first place of its inputs, and that of its output.
    places: (Option<Address>, Option<Address>),
    /// A start counts as it is released, not as it is pressed.
    monitored: bool,
    /// Levels at the terminals: both safety inputs, and start.
    closed: [bool; 2],
    start: bool,
    /// Start was pressed while the safety inputs were closed.
    pressed: bool,
    /// Since when the safety inputs differ.
    differ_since: Option<Time>,
    /// They did for too long; both have to open.
    discrepancy: bool,
    /// The module was started, and nothing opened since.
    started: bool,
    /// The controller enables K2.
    enabled: bool,
    /// The contact as it was reported last, when something last happened to it, and why.
    shown: bool,
    at: Time,
    cause: Cause,
}

impl SafetyModule {
    /// A module of this type, at these places of the images.
    pub(super) fn new(module: &ModuleType, addresses: &ModuleAddresses) -> SafetyModule {
        let inputs = addresses.digital_inputs.into_iter().flat_map(|all| all.iter()).enumerate();
        let outputs = addresses.digital_outputs.into_iter().flat_map(|all| all.iter()).enumerate();
        let inputs = inputs.map(|(n, at)| ModuleChannel::new(IoChannel::Input(n), at));
        let outputs = outputs.map(|(n, at)| ModuleChannel::new(IoChannel::Output(n), at));
        SafetyModule {
            channels: inputs.chain(outputs).collect(),
            places: (
                addresses.digital_inputs.and_then(|all| all.get(0)),
                addresses.digital_outputs.and_then(|all| all.get(0)),
            ),
            monitored: !module.safety.as_ref().is_some_and(|safety| safety.non_monitored_start),
            closed: [false; 2],
            start: false,
            pressed: false,
            differ_since: None,
            discrepancy: false,
            started: false,
            enabled: false,
            shown: false,
            at: Time::ZERO,
            cause: Cause::Controller,
        }
    }

    fn is_closed(&self) -> bool {
        self.closed == [true; 2] && !self.discrepancy
    }

    /// The contacts of its output are closed.
    fn output_closed(&self) -> bool {
        self.started && self.enabled
    }

    /// The safety inputs have changed at `now`.
    fn follow(&mut self, now: Time) {
        self.at = now;
        let [first, second] = self.closed;
        match (first == second, self.differ_since) {
            (true, _) => self.differ_since = None,
            (false, None) => self.differ_since = Some(now),
            (false, Some(_)) => {}
        }
        self.time_out(now);
        if !first && !second {
            self.discrepancy = false;
        }
        if !self.is_closed() {
            (self.started, self.pressed, self.cause) = (false, false, Cause::Board);
        }
        self.try_start();
    }

    /// A start that is not monitored holds for as long as it is pressed.
    fn try_start(&mut self) {
        if !self.monitored && self.start && self.is_closed() {
            (self.started, self.cause) = (true, Cause::Board);
        }
    }

    fn time_out(&mut self, now: Time) {
        if self.deadline() <= now {
            self.at = self.deadline();
            (self.discrepancy, self.started, self.pressed) = (true, false, false);
            self.differ_since = None;
        }
    }

    /// When the safety inputs have differed for too long.
    fn deadline(&self) -> Time {
        self.differ_since.map_or(Time::MAX, |since| since.saturating_add(SYNCHRONISATION))
    }

    /// Its byte of %I.
    fn status(&self) -> [bool; INPUTS] {
        let [first, second] = self.closed;
        let waits = self.is_closed() && !self.started;
        [self.started, self.output_closed(), first, second, self.start, waits, self.discrepancy, true]
    }
}

impl IoModule for SafetyModule {
    fn channels(&self) -> &[ModuleChannel] {
        &self.channels
    }

    fn power_on(&mut self, now: Time) {
        (self.started, self.pressed, self.discrepancy, self.enabled) = (false, false, false, false);
        self.differ_since = None;
        self.follow(now);
    }

    fn power_off(&mut self, _now: Time) {}

    fn set_input(&mut self, now: Time, input: usize, value: Value) {
        // A terminal that nothing drives is open.
        let high = value.as_bool().unwrap_or(false);
        match input {
            FIRST | SECOND => {
                self.closed[input - FIRST] = high;
                self.follow(now);
            }
            START if high != self.start => {
                (self.start, self.at) = (high, now);
                if self.monitored && !high && self.pressed {
                    (self.started, self.cause) = (true, Cause::Board);
                }
                self.pressed = high && self.is_closed() && !self.started;
                self.try_start();
            }
            _ => {}
        }
    }

    fn initialize(&mut self, now: Time) {
        self.at = now;
        (self.started, self.pressed, self.enabled, self.cause) = (false, false, false, Cause::Controller);
    }

    fn next(&self) -> Time {
        if self.output_closed() == self.shown { self.deadline() } else { self.at }
    }

    fn fire(&mut self, now: Time, changes: &mut OutputChanges<'_>) {
        self.time_out(now);
        let closed = self.output_closed();
        if std::mem::replace(&mut self.shown, closed) != closed {
            changes.push(self.at, 0, Value::Bool(closed), self.cause);
        }
    }

    fn output(&self, output: usize) -> Value {
        if output == 0 { Value::Bool(self.shown) } else { Value::Unknown }
    }
}

impl BusModule for SafetyModule {
    fn read(&mut self, now: Time, inputs: &mut Image) {
        self.time_out(now);
        let Some(first) = self.places.0 else { return };
        let levels = self.status();
        let byte = levels.iter().enumerate().fold(0, |byte, (bit, on)| byte | u8::from(*on) << bit);
        if let Some(place) = inputs.bytes_mut().get_mut(first.bit_offset() as usize / 8) {
            *place = byte;
        }
    }

    fn write(&mut self, now: Time, outputs: &Image, memory: &Memory) {
        let Some(place) = self.places.1 else { return };
        let enabled = outputs.get(place) != 0;
        if enabled != self.enabled {
            (self.enabled, self.at) = (enabled, now);
            self.cause = memory.writer(place.bit_offset() as usize);
        }
    }

    // A bus that is silent enables nothing.
    fn clear(&mut self, now: Time) {
        (self.enabled, self.at, self.cause) = (false, now, Cause::Controller);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use profile::{ConfiguredModule, ModuleFamily, ModuleKind, Profile, SafetyFunction};

    const S1: usize = FIRST;
    const S2: usize = SECOND;

    fn module(non_monitored_start: bool) -> SafetyModule {
        let mut module = ModuleType::new("TM3TEST", ModuleFamily::Tm3, ModuleKind::Safety);
        module.id = Some(1);
        module.safety =
            Some(SafetyFunction { functions: 1, category: 3, inputs: vec![2], non_monitored_start });
        let digital = profile::DigitalInputs { count: 8, rating: None, on_delay: None, off_delay: None };
        module.digital_inputs = Some(digital);
        module.digital_outputs = Some(profile::DigitalOutputs {
            count: 1,
            kind: None,
            rating: None,
            output_current: None,
            common_current: None,
            on_delay: None,
            off_delay: None,
        });
        let configured = ConfiguredModule::new(&module);
        let reference = Profile::M251_2024.default_reference();
        let places = reference.module_addresses(&[configured]).unwrap();
        let mut safety = SafetyModule::new(&module, &places[0]);
        safety.power_on(Time::ZERO);
        safety.enabled = true;
        safety
    }

    fn at(millis: i64) -> Time {
        Time::ZERO + Span::from_millis(millis)
    }

    fn set(safety: &mut SafetyModule, millis: i64, input: usize, high: bool) {
        safety.time_out(at(millis));
        safety.set_input(at(millis), input, Value::Bool(high));
    }

    fn both(safety: &mut SafetyModule, millis: i64, high: bool) {
        for input in [S1, S2] {
            set(safety, millis, input, high);
        }
    }

    #[test]
    fn a_start_counts_as_it_is_pressed_or_released() {
        for (non_monitored, pressed) in [(true, true), (false, false)] {
            let mut safety = module(non_monitored);
            both(&mut safety, 1, true);
            assert!(!safety.output_closed());
            set(&mut safety, 2, START, true);
            assert_eq!(safety.output_closed(), pressed);
            set(&mut safety, 3, START, false);
            assert!(safety.output_closed());
            set(&mut safety, 4, S2, false);
            assert!(!safety.output_closed());
            set(&mut safety, 5, S2, true);
            assert!(!safety.output_closed(), "it has to be started again");
        }
    }

    #[test]
    fn a_monitored_start_that_was_pressed_before_is_none() {
        let mut safety = module(false);
        set(&mut safety, 1, START, true);
        both(&mut safety, 2, true);
        set(&mut safety, 3, START, false);
        assert!(!safety.output_closed());
    }

    #[test]
    fn inputs_that_differ_for_too_long_have_to_open_both() {
        let mut safety = module(true);
        set(&mut safety, 0, START, true);
        set(&mut safety, 0, S1, true);
        set(&mut safety, 499, S2, true);
        assert!(safety.output_closed());
        set(&mut safety, 1_000, S1, false);
        set(&mut safety, 1_500, S1, true);
        assert_eq!((safety.discrepancy, safety.output_closed()), (true, false));
        both(&mut safety, 1_600, false);
        both(&mut safety, 1_700, true);
        assert_eq!((safety.discrepancy, safety.output_closed()), (false, true));
    }

    #[test]
    fn the_controller_enables_the_second_relay_alone() {
        let mut safety = module(true);
        set(&mut safety, 0, START, true);
        both(&mut safety, 1, true);
        safety.clear(at(2));
        assert_eq!(safety.status()[..2], [true, false]);
    }
}
