//! The converters of a board.

use document::Diagnostic;
use signal::{Span, Value};

use super::handle::AdcHandle;
use super::{Adc, AdcKind, AdcSpec, AdcsSpec, SampleSpec, iio, spi};
use crate::channel::{Channel, FaultSet, TimestampSource};
use crate::channel_table::ChannelTable;
use crate::codes;
use crate::context::BoardContext;
use crate::device_board::DeviceBoard;
use crate::device_limits::DeviceLimits;
use crate::refusal::Refusal;
use crate::thread::not_started;

/// Describes the channels that have inputs of converters.
pub fn describe(table: &ChannelTable, spec: &AdcsSpec, channels: &mut [Channel]) {
    for sample in &spec.samples {
        let at = usize::from(sample.channel.0);
        let (Some(channel), Some(known)) = (channels.get_mut(at), table.channels.get(at)) else {
            continue;
        };
        // What comes later than this is reported as a loss.
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

/// Converters as a board: its channels sense and never drive.
pub type AdcBoard = DeviceBoard<AdcHandle>;

impl AdcBoard {
    /// Opens the board's converters.
    ///
    /// # Errors
    /// All that is not there, not free, not permitted or cannot be done, by place.
    pub fn open(
        table: &ChannelTable,
        spec: &AdcsSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<AdcBoard, Vec<Diagnostic>> {
        let (mut sources, mut found) = (Vec::new(), Vec::new());
        for (at, converter) in spec.converters.iter().enumerate() {
            let inputs = spec.inputs_of(at);
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
                Err(refusal) => found.push(refusal.finding(&table.file, converter.place.clone())),
            }
        }
        if !found.is_empty() {
            return Err(found);
        }
        AdcBoard::on(table, spec, limits, context, sources)
            .map_err(|error| not_started(&table.file, "the thread of a converter", &error))
    }

    /// A board of converters that are open.
    ///
    /// # Errors
    /// A thread could not be started.
    pub fn on(
        table: &ChannelTable,
        spec: &AdcsSpec,
        limits: DeviceLimits,
        context: &BoardContext,
        sources: Vec<Source>,
    ) -> std::io::Result<AdcBoard> {
        let mut channels = table.blank();
        describe(table, spec, &mut channels);
        let start = |source: Source| {
            let Source { converter, inputs, period, again } = source;
            AdcHandle::start(converter, again, &inputs, period, limits, context)
        };
        let devices = sources.into_iter().map(start).collect::<Result<_, _>>()?;
        Ok(DeviceBoard::new(channels, limits, context, devices, Vec::new()))
    }
}
