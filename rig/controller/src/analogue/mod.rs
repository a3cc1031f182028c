//! A module of analogue inputs and outputs: on the bus, or a cartridge (io: sections 9 to 11).
//!
//! The channel of the board carries the value in the unit of the mode: volts, milliamperes, degrees Celsius, ohms. Channels that
//! are not used have neither terminal nor part in the exchange.

mod input;
mod output;
mod sampling;
mod scale;

use crate::memory::Memory;
use crate::module::{IoModule, ModuleChannel, OutputChanges};
use input::AnalogueInput;
use output::AnalogueOutput;
use profile::{ChannelAddresses, ChannelStatus, ConfiguredModule, IoChannel, ModuleAddresses};
use sampling::Sampling;
use scale::OutputScale;
use signal::{Address, Image, Time, Value};

/// A channel in use: its number, its word of the image, and its status byte where *Status Enabled* is chosen.
#[derive(Debug)]
struct Used<T> {
    number: usize,
    word: Address,
    status: Option<Address>,
    channel: T,
}

/// The module.
#[derive(Debug)]
pub(crate) struct AnalogueModule {
    channels: Vec<ModuleChannel>,
    inputs: Vec<Used<AnalogueInput>>,
    outputs: Vec<Used<AnalogueOutput>>,
    status: Vec<Address>,
    /// The numbers of its inputs and outputs, used or not.
    counts: (usize, usize),
    /// When the first change of an output is due.
    due: Time,
}

impl AnalogueModule {
    /// The module as it is configured, at these places of the images.
    pub(crate) fn new(configured: &ConfiguredModule<'_>, addresses: &ModuleAddresses) -> AnalogueModule {
        let place = |all: Option<ChannelAddresses>, channel: usize| {
            all.zip(u32::try_from(channel).ok()).and_then(|(all, channel)| all.get(channel))
        };
        let module = configured.module;
        let mut inputs = Vec::new();
        if let Some(channels) = &module.analogue_inputs {
            for (number, sampling) in Sampling::of(channels, configured).into_iter().enumerate() {
                let Some(settings) = configured.input(number) else { continue };
                let Some(word) = place(addresses.analogue_inputs, number) else { continue };
                let status = place(addresses.status, number);
                let channel = AnalogueInput::new(settings, channels.bits, sampling);
                inputs.push(Used { number, word, status, channel });
            }
        }
        let mut channels: Vec<ModuleChannel> =
            inputs.iter().map(|it| ModuleChannel::new(IoChannel::Input(it.number), it.word)).collect();
        let mut outputs = Vec::new();
        let bits = module.analogue_outputs.as_ref().and_then(|channels| channels.bits);
        for number in 0..module.analogue_output_count() as usize {
            let Some(settings) = configured.output(number) else { continue };
            let Some(word) = place(addresses.analogue_outputs, number) else { continue };
            let Some(scale) = OutputScale::new(settings, bits) else { continue };
            let status = place(addresses.status, module.analogue_input_count() as usize + number);
            let default = u64::from(settings.fallback as u16);
            channels.push(ModuleChannel { default, ..ModuleChannel::new(IoChannel::Output(number), word) });
            outputs.push(Used { number, word, status, channel: AnalogueOutput::new(scale) });
        }
        let status = inputs.iter().filter_map(|it| it.status);
        let status = status.chain(outputs.iter().filter_map(|it| it.status)).collect();
        let counts = (module.analogue_input_count() as usize, module.analogue_output_count() as usize);
        AnalogueModule { channels, inputs, outputs, status, counts, due: Time::MAX }
    }

    /// The status bytes of its channels in use (io:DIAG-06).
    pub(crate) fn status_bytes(&self) -> &[Address] {
        &self.status
    }

    /// Everything that it has in the images: the words and status bytes of its channels in use.
    pub(crate) fn places(&self) -> impl Iterator<Item = Address> {
        self.channels.iter().map(|channel| channel.address).chain(self.status.iter().copied())
    }

    /// The last conversions of its inputs up to `now` -> %I. The only fault of an output is that the module has no supply.
    #[inline]
    pub(crate) fn read(&mut self, now: Time, inputs: &mut Image) {
        let bytes = inputs.bytes_mut();
        for Used { word, status, channel, .. } in &mut self.inputs {
            let converted = channel.read(now);
            let at = word.bit_offset() as usize / 8;
            if let Some(place) = bytes.get_mut(at..at + 2) {
                place.copy_from_slice(&converted.word.to_le_bytes());
            }
            if let Some(place) = status.and_then(|status| bytes.get_mut(status.bit_offset() as usize / 8)) {
                *place = converted.status.code();
            }
        }
        for Used { status, channel, .. } in &mut self.outputs {
            let code = channel.read_status().code();
            if let Some(place) = status.and_then(|status| bytes.get_mut(status.bit_offset() as usize / 8)) {
                *place = code;
            }
        }
    }

    /// The status of a channel, inputs before outputs (plcsystem:FUN-90); none beyond the last one. With status bytes in %I it is the
    /// one that was read last; else the module is asked, and it is that of the last conversion up to `now` (plcsystem:FUN-91).
    pub(crate) fn internal_status(&mut self, now: Time, channel: usize) -> Option<ChannelStatus> {
        let (inputs, outputs) = self.counts;
        let refreshes = self.status.is_empty();
        if channel >= inputs + outputs {
            return None;
        }
        let input = self.inputs.iter_mut().find(|it| it.number == channel);
        let output = self.outputs.iter_mut().find(|it| inputs + it.number == channel);
        Some(match (input, output) {
            (Some(input), _) if refreshes => input.channel.read(now).status,
            (Some(input), _) => input.channel.last_read().status,
            (_, Some(output)) if refreshes => output.channel.read_status(),
            (_, Some(output)) => output.channel.last_status(),
            (None, None) => ChannelStatus::Normal,
        })
    }

    /// Its words of %Q -> terminals at `now`.
    #[inline]
    pub(crate) fn write(&mut self, now: Time, outputs: &Image, memory: &Memory) {
        for Used { word, channel, .. } in &mut self.outputs {
            let bit = word.bit_offset() as usize;
            channel.write(now, outputs.get(*word) as u16 as i16, || memory.writer(bit));
            self.due = self.due.min(channel.due());
        }
    }

    /// Its own supply is there or off from `now` on. As it comes, its inputs begin as at power on, and its outputs with the next word
    /// that is written.
    pub(crate) fn supply(&mut self, now: Time, on: bool) {
        self.inputs.iter_mut().for_each(|it| it.channel.supply(now, on));
        self.each_output(|output| output.supply(now, on));
    }

    /// Its outputs are switched to 0 at `now`, by the module itself.
    pub(crate) fn clear(&mut self, now: Time) {
        self.each_output(|output| output.clear(now));
    }

    fn each_output(&mut self, change: impl Fn(&mut AnalogueOutput)) {
        for Used { channel, .. } in &mut self.outputs {
            change(channel);
            self.due = self.due.min(channel.due());
        }
    }
}

impl IoModule for AnalogueModule {
    fn channels(&self) -> &[ModuleChannel] {
        &self.channels
    }

    fn power_on(&mut self, now: Time) {
        self.inputs.iter_mut().for_each(|input| input.channel.power_on(now));
    }

    // Its outputs are at their hardware initialization values, and inputs are looked at by an exchange alone.
    fn power_off(&mut self, _now: Time) {}

    fn set_input(&mut self, now: Time, input: usize, value: Value) {
        if let Some(input) = self.inputs.iter_mut().find(|it| it.number == input) {
            input.channel.set(now, value);
        }
    }

    fn initialize(&mut self, now: Time) {
        self.each_output(|output| output.initialize(now));
    }

    fn next(&self) -> Time {
        self.due
    }

    fn fire(&mut self, now: Time, changes: &mut OutputChanges<'_>) {
        if self.due > now {
            return;
        }
        self.due = Time::MAX;
        for Used { number, channel, .. } in &mut self.outputs {
            if let Some((value, at, cause)) = channel.take_change(now) {
                changes.push(at, *number, value, cause);
            }
            self.due = self.due.min(channel.due());
        }
    }

    fn output(&self, output: usize) -> Value {
        let found = self.outputs.iter().find(|it| it.number == output);
        found.map_or(Value::Unknown, |it| it.channel.value())
    }
}
