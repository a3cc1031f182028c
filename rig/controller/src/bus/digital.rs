//! A module of digital inputs and outputs.

use super::BusModule;
use crate::io::input::channel::InputChannel;
use crate::io::output::{OutputStage, Outputs};
use crate::memory::Memory;
use crate::module::{IoModule, ModuleChannel, OutputChanges};
use profile::{ChannelAddresses, ChannelSet, IoChannel, ModuleAddresses, ModuleType};
use signal::{Image, Span, Time, Value};

/// The module. It has at most 32 channels of a kind.
#[derive(Debug)]
pub(super) struct DigitalModule {
    channels: Vec<ModuleChannel>,
    inputs: Vec<InputChannel>,
    /// The levels behind the delays of the inputs, as far as they were looked at.
    levels: ChannelSet,
    /// Inputs whose level may turn without a change at the terminal.
    moving: ChannelSet,
    /// The inputs and the outputs that what is fitted has.
    fitted: (ChannelSet, ChannelSet),
    /// The first byte of %I, and how many there are.
    input_bytes: (usize, usize),
    outputs: Outputs,
    /// The first byte of %Q, and how many there are.
    output_bytes: (usize, usize),
    /// The outputs are transistors, which switch a supply of their own.
    has_own_supply: bool,
    /// That supply is there.
    is_supplied: bool,
}

/// The first byte of channels, and how many bytes they have.
fn bytes(addresses: Option<ChannelAddresses>) -> (usize, usize) {
    let first = addresses.and_then(|all| all.get(0));
    let count = addresses.map_or(0, |all| all.count() as usize);
    (first.map_or(0, |address| address.bit_offset() as usize / 8), count.div_ceil(8))
}

/// The delay of the inputs of a module, and the stages of its outputs.
fn figures(module: &ModuleType) -> (Span, OutputStage) {
    let delay = module.digital_inputs.as_ref().and_then(|inputs| inputs.on_delay).unwrap_or(Span::ZERO);
    let (on_delay, off_delay) = match &module.digital_outputs {
        Some(outputs) => (outputs.on_delay.unwrap_or_default(), outputs.off_delay.unwrap_or_default()),
        None => (Span::ZERO, Span::ZERO),
    };
    // Without an application relays are open and transistors at 0 V (controller:OUT-02). Delays are maxima.
    (delay, OutputStage { on_delay, off_delay, at_most: true, floats: false })
}

impl DigitalModule {
    /// The module of this number, of such a type, at these places of the images.
    pub(super) fn new(
        number: usize,
        module: &ModuleType,
        addresses: &ModuleAddresses,
        worst_case: bool,
    ) -> DigitalModule {
        let each = |all: Option<ChannelAddresses>| all.into_iter().flat_map(|all| all.iter()).enumerate();
        let inputs =
            each(addresses.digital_inputs).map(|(n, at)| ModuleChannel::new(IoChannel::Input(n), at));
        let outputs =
            each(addresses.digital_outputs).map(|(n, at)| ModuleChannel::new(IoChannel::Output(n), at));
        let (delay, stage) = figures(module);
        let output_bytes = bytes(addresses.digital_outputs);
        let stages = (0..module.digital_output_count()).map(|_| stage);
        DigitalModule {
            channels: inputs.chain(outputs).collect(),
            inputs: (0..module.digital_input_count()).map(|_| InputChannel::unfiltered(delay)).collect(),
            levels: ChannelSet::EMPTY,
            moving: ChannelSet::EMPTY,
            fitted: (ChannelSet::ALL, ChannelSet::ALL),
            input_bytes: bytes(addresses.digital_inputs),
            outputs: Outputs::new(number, output_bytes.0 * 8, stages, worst_case),
            output_bytes,
            has_own_supply: module.has_own_supply(),
            is_supplied: true,
        }
    }

    /// Whether the outputs have what they switch.
    fn drives(&self) -> bool {
        self.is_supplied || !self.has_own_supply
    }

    /// Brings an input to `now`.
    fn advance(&mut self, input: usize, now: Time) {
        let Some(channel) = self.inputs.get_mut(input) else { return };
        channel.advance(now, |_, _| {});
        self.levels.set(input, channel.out());
        self.moving.set(input, channel.moves());
    }
}

impl IoModule for DigitalModule {
    fn channels(&self) -> &[ModuleChannel] {
        &self.channels
    }

    fn power_on(&mut self, now: Time) {
        for (input, channel) in self.inputs.iter_mut().enumerate() {
            channel.power_on(now);
            self.levels.remove(input);
            self.moving.insert(input);
        }
    }

    // Its outputs are at their hardware initialization values, and inputs are looked at by a bus cycle alone.
    fn power_off(&mut self, _now: Time) {}

    fn set_input(&mut self, now: Time, input: usize, value: Value) {
        self.advance(input, now);
        // A terminal that nothing drives is at 0.
        let high = value.as_bool().unwrap_or(false);
        if self.inputs.get_mut(input).is_some_and(|channel| channel.set(now, high)) {
            self.moving.insert(input);
        }
    }

    fn initialize(&mut self, now: Time) {
        self.outputs.initialize(now);
    }

    fn next(&self) -> Time {
        self.outputs.next()
    }

    fn fire(&mut self, now: Time, changes: &mut OutputChanges<'_>) {
        self.outputs.fire(now, |effect| changes.report(effect));
    }

    fn output(&self, output: usize) -> Value {
        self.outputs.level(output).map_or(Value::Unknown, Value::from)
    }
}

impl BusModule for DigitalModule {
    #[inline]
    fn read(&mut self, now: Time, inputs: &mut Image) {
        for input in self.moving {
            self.advance(input, now);
        }
        let (first, count) = self.input_bytes;
        let levels = (self.levels & self.fitted.0).to_image();
        if let Some(bytes) = inputs.bytes_mut().get_mut(first..first + count) {
            bytes.iter_mut().zip(levels).for_each(|(byte, level)| *byte = level);
        }
    }

    #[inline]
    fn write(&mut self, now: Time, outputs: &Image, memory: &Memory) {
        let (first, count) = self.output_bytes;
        let mut word = [0; 4];
        if let Some(bytes) = outputs.bytes().get(first..first + count) {
            word.iter_mut().zip(bytes).for_each(|(to, byte)| *to = *byte);
        }
        let driven = if self.drives() { self.fitted.1 } else { ChannelSet::EMPTY };
        self.outputs.drive(now, ChannelSet::from_image(word) & driven, ChannelSet::ALL, memory);
    }

    /// Outputs without a supply are at 0 at once, and follow the next exchange as it is there again.
    fn supply(&mut self, now: Time, on: bool) {
        self.is_supplied = on;
        if !self.drives() {
            self.outputs.initialize(now);
        }
    }

    fn clear(&mut self, now: Time) {
        self.outputs.command(now, ChannelSet::EMPTY, ChannelSet::ALL);
    }
    fn fit(&mut self, module: &ModuleType) {
        let (delay, stage) = figures(module);
        let first = |count: u32| ChannelSet::first(count as usize);
        self.fitted = (first(module.digital_input_count()), first(module.digital_output_count()));
        for input in &mut self.inputs {
            input.set_delay(delay);
        }
        self.moving = ChannelSet::first(self.inputs.len());
        self.outputs.set_delays(stage);
        self.has_own_supply = module.has_own_supply();
    }
}
