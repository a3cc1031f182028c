//! The converters of a board.

use document::Diagnostic;
use host::monotonic;
use signal::{Span, Time, Value};

use super::handle::AdcHandle;
use super::{Adc, AdcKind, AdcSpec, AdcsSpec, Refusal, SampleSpec, iio, spi};
use crate::event_collector::EventCollector;
use crate::file::{BoardFile, codes};
use crate::real::RealSpec;
use crate::run_state::{RunState, START, drives_none};
use crate::thread::not_started;
use crate::{
    Board, BoardContext, BoardError, BoardEvent, Channel, ChannelId, Descriptions, FaultSet, Health,
    TimestampSource,
};

/// Describes the channels that have inputs of converters.
pub fn describe(file: &BoardFile, spec: &AdcsSpec, channels: &mut [Channel]) {
    for sample in &spec.samples {
        let at = usize::from(sample.channel.0);
        let (Some(channel), Some(known)) = (channels.get_mut(at), file.circuit.channels.get(at)) else {
            continue;
        };
        // What comes later than this is told as a loss.
        let apart = spec.converters.get(sample.converter).map_or(Span::ZERO, AdcSpec::longest);
        *channel = Channel {
            name: known.name.clone(),
            kind: known.kind.clone(),
            drives: false,
            senses: known.senses,
            timestamp: TimestampSource::Sampled { period: apart },
            resolution: apart,
            shortest_pulse: apart,
            deadband: sample.scale.deadband,
            max_pulse_hz: 0,
            emits: None,
            counts_hz: None,
            faults: FaultSet::NONE,
            safe: Value::HighZ,
        };
    }
}

/// Opens a converter for these inputs: the readings number them as they are here.
///
/// # Errors
/// It is not there, not free, not permitted, or not what the file says.
pub fn open(converter: &AdcSpec, inputs: &[SampleSpec]) -> Result<Box<dyn Adc>, Refusal> {
    let opened = match &converter.kind {
        AdcKind::Spi(spec) => spi::open(converter, spec, inputs),
        AdcKind::Iio(spec) => iio::open(converter, spec, inputs),
    }?;
    for (input, sample) in (0u16..).zip(inputs) {
        if sample.scale.accuracy.of_range > 0.0 && opened.resolution(input).range.is_none() {
            let message = format!("{} does not tell the range of this input", opened.device());
            let help = "say in `accuracy` by `plus` how far off it may be, in the unit of the channel";
            return Err(Refusal::new(codes::CONVERTER_VALUE, message, help).at(sample.accuracy_place.clone()));
        }
    }
    Ok(opened)
}

/// A converter with the inputs that it was opened for, and how it is opened again.
pub struct Source {
    /// The converter.
    pub converter: Box<dyn Adc>,
    /// Its inputs, in the order of its readings.
    pub inputs: Vec<SampleSpec>,
    /// Time between two readings of an input.
    pub period: Span,
    /// Opens it again when it was gone; is called on the device's thread.
    pub again: Box<dyn FnMut() -> Option<Box<dyn Adc>> + Send>,
}

impl std::fmt::Debug for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Source").field("converter", &self.converter).field("inputs", &self.inputs).finish()
    }
}

/// Converters as a board: its channels sense and never drive. A thread of each converter reads it; no call of the board
/// waits for one but its start.
#[derive(Debug)]
pub struct AdcBoard {
    channels: Vec<Channel>,
    unresponsive_after: Span,
    reconnect: bool,
    context: BoardContext,
    devices: Vec<AdcHandle>,
    run: RunState,
}

impl AdcBoard {
    /// Opens the board's converters.
    ///
    /// # Errors
    /// All that is not there, not free, not permitted or cannot be done, by place.
    pub fn open(
        file: &BoardFile,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<AdcBoard, Vec<Diagnostic>> {
        let (mut sources, mut found) = (Vec::new(), Vec::new());
        for (at, converter) in spec.converters.converters.iter().enumerate() {
            let inputs = spec.converters.inputs_of(at);
            // A converter that no channel uses may be missing.
            if inputs.is_empty() {
                continue;
            }
            match open(converter, &inputs) {
                Ok(opened) => {
                    let (of, at) = (converter.clone(), inputs.clone());
                    let again = Box::new(move || open(&of, &at).ok());
                    sources.push(Source { converter: opened, inputs, period: converter.period, again });
                }
                Err(refusal) => found.push(refusal.finding(&file.name, converter.place.clone())),
            }
        }
        if !found.is_empty() {
            return Err(found);
        }
        AdcBoard::on(file, spec, context, sources)
            .map_err(|error| not_started(file, "the thread of a converter", &error))
    }

    /// A board of converters that are open.
    ///
    /// # Errors
    /// A thread could not be started.
    pub fn on(
        file: &BoardFile,
        spec: &RealSpec,
        context: &BoardContext,
        sources: Vec<Source>,
    ) -> std::io::Result<AdcBoard> {
        let mut channels = crate::real::blank(file);
        describe(file, &spec.converters, &mut channels);
        let start = |source: Source| {
            let Source { converter, inputs, period, again } = source;
            let limits = (spec.unresponsive_after, spec.reconnect);
            AdcHandle::start(converter, again, &inputs, period, limits, (&context.bell, context.realtime))
        };
        Ok(AdcBoard {
            channels,
            unresponsive_after: spec.unresponsive_after,
            reconnect: spec.reconnect,
            context: context.clone(),
            devices: sources.into_iter().map(start).collect::<Result<_, _>>()?,
            run: RunState::default(),
        })
    }
}

impl Board for AdcBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Waits until every input was read, as long as a converter may be silent or two seconds.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.end();
        let starts: Vec<u64> = self.devices.iter_mut().map(AdcHandle::ask_start).collect();
        let due = monotonic().saturating_add(self.unresponsive_after.max(START).as_nanos());
        for (device, start) in self.devices.iter_mut().zip(starts) {
            if !device.await_start(start, due, self.reconnect) {
                return Err(device.is_lost());
            }
        }
        self.run.begin(now);
        self.run.owes_start();
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        drives_none(&self.channels, writes)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let mut collector = EventCollector::new(out, &self.context.time, now);
        if let Some(start) = self.run.take_fresh() {
            self.devices.iter().for_each(|device| device.present(start, &mut collector));
        }
        for device in &mut self.devices {
            device.poll(&mut collector);
        }
        self.run.told(collector);
        Ok(())
    }

    /// What lies ahead of the last poll, and when a converter that owes an answer counts as lost.
    fn next_event(&self) -> Option<Time> {
        let owed = self.devices.iter().filter_map(AdcHandle::overdue);
        self.run.next_event(&self.context.time, owed)
    }

    /// Nothing is driven: the converters rest until the next start.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.latch(now);
        self.devices.iter().for_each(AdcHandle::rest);
        Ok(())
    }

    fn health(&self) -> Health {
        Health {
            lost: self.devices.iter().map(AdcHandle::lost_channels).sum(),
            dropped: self.run.dropped(),
            failed_calls: self.devices.iter().map(AdcHandle::failed_calls).sum(),
            latched_safe: self.run.is_latched(),
            ..Health::default()
        }
    }

    fn descriptions(&self) -> Option<&dyn Descriptions> {
        Some(self)
    }
}

impl Descriptions for AdcBoard {
    fn device(&self, channel: ChannelId) -> Option<&str> {
        let mut devices = self.devices.iter();
        devices.find(|device| device.channels.contains(&channel)).map(|device| device.device.as_str())
    }

    fn noise(&self, channel: ChannelId) -> Option<f64> {
        self.devices.iter().find_map(|device| device.noise(channel))
    }
}
