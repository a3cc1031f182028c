//! The converters of a board.

use document::Diagnostic;
use signal::{Span, Value};

use super::handle::AdcHandle;
use super::{Adc, AdcKind, AdcSpec, AdcsSpec, SampleSpec, iio, spi};
use crate::channel::{Channel, FaultSet, TimestampSource};
use crate::channel_table::ChannelTable;
use crate::codes;
use crate::context::BoardContext;
use crate::device_board::{DeviceBoard, Reopen, all_opened};
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
#[derive(Debug)]
pub struct AdcSource {
    /// The converter.
    pub converter: Box<dyn Adc>,
    /// Its inputs, in the order of its readings.
    pub inputs: Vec<SampleSpec>,
    /// Time between two readings of an input.
    pub period: Span,
    /// How it is opened again.
    pub reopen: Reopen<dyn Adc>,
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
        let source = |(spec, inputs): (&AdcSpec, Vec<SampleSpec>)| {
            let source = open(spec, &inputs).map(|converter| {
                let (of, at) = (spec.clone(), inputs.clone());
                let reopen = Reopen::new(move || open(&of, &at).ok());
                AdcSource { converter, inputs, period: spec.period, reopen }
            });
            (spec.place.clone(), source)
        };
        let sources = all_opened(&table.file, spec.used().map(source))?;
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
        sources: Vec<AdcSource>,
    ) -> std::io::Result<AdcBoard> {
        let mut channels = table.blank();
        describe(table, spec, &mut channels);
        let start = |source: AdcSource| AdcHandle::start(source, limits, context);
        let devices = sources.into_iter().map(start).collect::<Result<_, _>>()?;
        Ok(DeviceBoard::new(channels, limits, context, devices, Vec::new()))
    }
}
