//! The generators of a board.

use document::Diagnostic;
use signal::{Span, Value};

use super::handle::GeneratorHandle;
use super::spec::{GeneratorKind, GeneratorSpec, GeneratorsSpec, OutputSpec};
use super::stream::Stream;
use super::{Generator, Pwm, pwm, stream};
use crate::channel::{Channel, ChannelId, FaultSet, TimestampSource};
use crate::channel_table::ChannelTable;
use crate::codes;
use crate::context::BoardContext;
use crate::device_board::{DeviceBoard, Reopen, all_opened};
use crate::device_limits::DeviceLimits;
use crate::refusal::Refusal;
use crate::thread::not_started;

/// Describes the channels that have outputs of generators.
pub fn describe(table: &ChannelTable, spec: &GeneratorsSpec, channels: &mut [Channel]) {
    for output in &spec.outputs {
        let at = usize::from(output.channel.0);
        let known = (channels.get_mut(at), table.channels.get(at), spec.generators.get(output.generator));
        let (Some(channel), Some(known), Some(generator)) = known else { continue };
        let emits = generator.kind.emits();
        let is_stream = matches!(generator.kind, GeneratorKind::Stream(_));
        *channel = Channel {
            name: known.name.clone(),
            kind: known.kind.clone(),
            // A stream keeps no level but that at rest.
            drives: !is_stream,
            senses: known.senses,
            timestamp: TimestampSource::Device,
            resolution: emits.resolution,
            // What was sent is known to the bit.
            shortest_pulse: if is_stream { emits.shortest } else { Span::MAX },
            deadband: 0.0,
            max_pulse_hz: 0,
            emits: Some(emits),
            counts_hz: None,
            faults: FaultSet::NONE,
            safe: Value::Bool(output.safe),
        };
    }
}

/// Opens a generator for these outputs, all of them at rest.
///
/// # Errors
/// It is not there, not free, not permitted, or does not do what the file says.
pub fn open(generator: &GeneratorSpec, outputs: &[OutputSpec]) -> Result<Box<dyn Generator>, Refusal> {
    Ok(match (&generator.kind, outputs) {
        (GeneratorKind::Stream(spec), [output, ..]) => Box::new(Stream::open(spec, output)?),
        (GeneratorKind::Stream(_), []) => {
            let message = format!("no channel takes the pulses of `{}`", generator.name);
            return Err(Refusal::new(codes::OUTPUT, message, "name it as `generator` of a channel"));
        }
        (GeneratorKind::Pwm(spec), _) => Box::new(Pwm::open(spec, outputs)?),
    })
}

/// What is behind each of these outputs, in words. Nothing is set up, and nothing is kept.
///
/// # Errors
/// As [`open`], as far as that can be seen.
pub fn look(generator: &GeneratorSpec, outputs: &[OutputSpec]) -> Result<Vec<String>, Refusal> {
    match &generator.kind {
        GeneratorKind::Stream(spec) => {
            stream::look(spec)?;
            let words = format!("emits pulses by {} at {} Hz, free", spec.path.display(), spec.clock.hz());
            Ok(outputs.iter().map(|_| words.clone()).collect())
        }
        GeneratorKind::Pwm(spec) => {
            let chip = pwm::look(spec, outputs)?;
            let words =
                |output: &OutputSpec| format!("emits waves by output {} of {chip}, free", output.output);
            Ok(outputs.iter().map(words).collect())
        }
    }
}

/// A generator with the outputs that it was opened for, and how it is opened again.
#[derive(Debug)]
pub struct GeneratorSource {
    /// The generator.
    pub generator: Box<dyn Generator>,
    /// What it is.
    pub kind: GeneratorKind,
    /// Its outputs, in the order of their numbers.
    pub outputs: Vec<OutputSpec>,
    /// How it is opened again.
    pub reopen: Reopen<dyn Generator>,
}

/// Generators as a board: its channels keep levels and emit pulses.
pub type GeneratorBoard = DeviceBoard<GeneratorHandle>;

impl GeneratorBoard {
    /// Opens the board's generators, outputs at rest.
    ///
    /// # Errors
    /// All that is not there, not free, not permitted or cannot be done, by place.
    pub fn open(
        table: &ChannelTable,
        spec: &GeneratorsSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<GeneratorBoard, Vec<Diagnostic>> {
        let source = |(spec, outputs): (&GeneratorSpec, Vec<OutputSpec>)| {
            let source = open(spec, &outputs).map(|generator| {
                let reopen = reopen(spec.clone(), outputs.clone(), context.clone(), generator.device());
                GeneratorSource { generator, kind: spec.kind.clone(), outputs, reopen }
            });
            (spec.place.clone(), source)
        };
        let sources = all_opened(&table.file, spec.used().map(source))?;
        GeneratorBoard::on(table, spec, limits, context, sources)
            .map_err(|error| not_started(&table.file, "the thread of a generator", &error))
    }

    /// A board of generators that are open.
    ///
    /// # Errors
    /// A thread could not be started, or there is no descriptor left.
    pub fn on(
        table: &ChannelTable,
        spec: &GeneratorsSpec,
        limits: DeviceLimits,
        context: &BoardContext,
        sources: Vec<GeneratorSource>,
    ) -> std::io::Result<GeneratorBoard> {
        let mut channels = table.blank();
        describe(table, spec, &mut channels);
        let senses = |channel: ChannelId| channels.get(usize::from(channel.0)).is_some_and(|of| of.senses);
        let (mut devices, mut claims) = (Vec::with_capacity(sources.len()), Vec::new());
        for source in sources {
            claims.extend(source.generator.output_claims()?);
            devices.push(GeneratorHandle::start(source, senses, limits, context)?);
        }
        Ok(DeviceBoard::new(channels, limits, context, devices, claims))
    }
}

/// How a generator is opened when it is there again: guarded as before, then handed over.
fn reopen(
    generator: GeneratorSpec,
    outputs: Vec<OutputSpec>,
    at: BoardContext,
    device: &str,
) -> Reopen<dyn Generator> {
    let device = device.to_owned();
    Reopen::new(move || {
        let opened = open(&generator, &outputs).ok()?;
        let claims = opened.output_claims().ok()?;
        // A board without a guard has nobody to ask, and not everything needs one.
        if let Some(output_guard) = at.output_guard.as_ref().filter(|_| !claims.is_empty()) {
            output_guard.upgrade()?.replace(&device, claims).ok()?;
        }
        Some(opened)
    })
}
