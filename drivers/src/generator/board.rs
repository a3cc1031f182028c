//! The generators of a board.

use document::Diagnostic;
use host::monotonic;
use rustix::io::Errno;
use signal::{Span, Time, Value};

use super::device::{Opener, Order};
use super::handle::GeneratorHandle;
use super::spec::{GeneratorKind, GeneratorSpec, GeneratorsSpec, OutputSpec};
use super::stream::Stream;
use super::{Generator, Pwm, pwm, stream};
use crate::adc::Refusal;
use crate::event_collector::EventCollector;
use crate::file::{BoardFile, codes};
use crate::real::RealSpec;
use crate::run_state::{RunState, START};
use crate::thread::not_started;
use crate::{
    Board, BoardContext, BoardError, BoardEvent, Call, Channel, ChannelId, Descriptions, Emission, FaultSet,
    Health, OutputClaim, PulseOutputs, TimestampSource,
};

/// Describes the channels that have outputs of generators.
pub fn describe(file: &BoardFile, spec: &GeneratorsSpec, channels: &mut [Channel]) {
    for output in &spec.outputs {
        let at = usize::from(output.channel.0);
        let known =
            (channels.get_mut(at), file.circuit.channels.get(at), spec.generators.get(output.generator));
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
pub struct Source {
    /// The generator.
    pub generator: Box<dyn Generator>,
    /// What it is.
    pub kind: GeneratorKind,
    /// Its outputs, in the order of their numbers.
    pub outputs: Vec<OutputSpec>,
    /// Opens it again when it was gone; is called on the device's thread.
    pub again: Opener,
}

impl std::fmt::Debug for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Source").field("generator", &self.generator).field("outputs", &self.outputs).finish()
    }
}

/// Generators as a board. A thread of each carries out what it is asked; no call of the board waits for one but its
/// start and its safe state.
#[derive(Debug)]
pub struct GeneratorBoard {
    channels: Vec<Channel>,
    /// The generator behind each channel, and the place of its output there.
    behind: Vec<Option<(u16, u8)>>,
    unresponsive_after: Span,
    reconnect: bool,
    context: BoardContext,
    devices: Vec<GeneratorHandle>,
    /// Claims for whoever makes outputs rest when the rig cannot, until they are asked for.
    held: Vec<OutputClaim>,
    run: RunState,
}

impl GeneratorBoard {
    /// Opens the board's generators, outputs at rest.
    ///
    /// # Errors
    /// All that is not there, not free, not permitted or cannot be done, by place.
    pub fn open(
        file: &BoardFile,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<GeneratorBoard, Vec<Diagnostic>> {
        let (mut sources, mut found) = (Vec::new(), Vec::new());
        for (at, generator) in spec.generators.generators.iter().enumerate() {
            let outputs = spec.generators.outputs_of(at);
            // A generator that no channel uses may be missing.
            if outputs.is_empty() {
                continue;
            }
            match open(generator, &outputs) {
                Ok(opened) => {
                    let again = again(generator.clone(), outputs.clone(), context.clone(), opened.device());
                    sources.push(Source { generator: opened, kind: generator.kind.clone(), outputs, again });
                }
                Err(refusal) => found.push(refusal.finding(&file.name, generator.place.clone())),
            }
        }
        if !found.is_empty() {
            return Err(found);
        }
        GeneratorBoard::on(file, spec, context, sources)
            .map_err(|error| not_started(file, "the thread of a generator", &error))
    }

    /// A board of generators that are open.
    ///
    /// # Errors
    /// A thread could not be started, or there is no descriptor left.
    pub fn on(
        file: &BoardFile,
        spec: &RealSpec,
        context: &BoardContext,
        sources: Vec<Source>,
    ) -> std::io::Result<GeneratorBoard> {
        let mut channels = crate::real::blank(file);
        describe(file, &spec.generators, &mut channels);
        let mut board = GeneratorBoard {
            behind: vec![None; channels.len()],
            channels,
            unresponsive_after: spec.unresponsive_after,
            reconnect: spec.reconnect,
            context: context.clone(),
            devices: Vec::with_capacity(sources.len()),
            held: Vec::new(),
            run: RunState::default(),
        };
        for (device, source) in sources.into_iter().enumerate() {
            for (output, of) in source.outputs.iter().enumerate() {
                if let Some(behind) = board.behind.get_mut(usize::from(of.channel.0)) {
                    *behind = Some((device as u16, output as u8));
                }
            }
            board.held.extend(source.generator.held()?);
            let senses =
                |channel: ChannelId| board.channels.get(usize::from(channel.0)).is_some_and(|of| of.senses);
            let limits = (spec.unresponsive_after, spec.reconnect);
            let around = (&context.bell, context.realtime);
            let handle = GeneratorHandle::start(source, senses, limits, around)?;
            board.devices.push(handle);
        }
        Ok(board)
    }

    /// The device and the output behind a channel.
    fn output(&self, channel: ChannelId) -> Result<(usize, u8), BoardError> {
        let behind = self.behind.get(usize::from(channel.0)).ok_or(BoardError::NoChannel(channel))?;
        behind.map(|(device, output)| (usize::from(device), output)).ok_or(BoardError::NotDriven(channel))
    }
}

/// How a generator is opened when it is there again: guarded as before, then handed over.
fn again(generator: GeneratorSpec, outputs: Vec<OutputSpec>, at: BoardContext, device: &str) -> Opener {
    let device = device.to_owned();
    Box::new(move || {
        let opened = open(&generator, &outputs).ok()?;
        let held = opened.held().ok()?;
        // A board without a guard has nobody to ask, and not everything needs one.
        if let Some(output_guard) = at.output_guard.as_ref().filter(|_| !held.is_empty()) {
            output_guard.upgrade()?.replace(&device, held).ok()?;
        }
        Some(opened)
    })
}

impl Board for GeneratorBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Waits until all is at rest: for pulses that are under way, and as long as a generator may be silent or two
    /// seconds.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.end();
        let requests: Vec<u64> = self.devices.iter_mut().map(GeneratorHandle::ask_rest).collect();
        let due = monotonic().saturating_add(self.unresponsive_after.max(START).as_nanos());
        for (device, request) in self.devices.iter_mut().zip(requests) {
            if !device.await_rest(request, due, self.reconnect) {
                return Err(device.is_lost());
            }
            device.begin();
        }
        self.run.begin(now);
        self.run.owes_start();
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        for (channel, value) in writes {
            let (device, output) = self.output(*channel)?;
            self.devices[device].takes(output, *value)?;
        }
        for (channel, value) in writes {
            let (device, output) = self.output(*channel)?;
            self.devices[device].write(output, *value)?;
        }
        Ok(())
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let mut collector = EventCollector::new(out, &self.context.time, now);
        if let Some(start) = self.run.take_fresh() {
            self.devices.iter().for_each(|device| device.present(start, &mut collector));
        }
        let mut more = false;
        for device in &mut self.devices {
            more |= device.poll(self.run.is_latched(), &mut collector);
        }
        if more {
            collector.goes_on();
            self.context.bell.ring();
        }
        self.run.told(collector);
        Ok(())
    }

    /// What lies ahead of the last poll or was left to the next, and when a generator that owes an answer counts as lost.
    fn next_event(&self) -> Option<Time> {
        let owed = self.devices.iter().filter_map(GeneratorHandle::overdue);
        self.run.next_event(&self.context.time, owed)
    }

    /// Waits for the generators, as long as one may be silent. Pulses that are under way then cannot be called back: they
    /// end at rest by themselves. One that hangs is brought to rest as soon as its call ends.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.latch(now);
        let requests: Vec<u64> = self.devices.iter_mut().map(GeneratorHandle::ask_rest).collect();
        let due = monotonic().saturating_add(self.unresponsive_after.as_nanos());
        let mut outcome = Ok(());
        for (device, request) in self.devices.iter().zip(requests) {
            if !device.await_safe(request, due) {
                let code = if device.is_gone() { Errno::NODEV } else { Errno::TIMEDOUT }.raw_os_error();
                outcome = outcome.and(Err(BoardError::Os { call: Call::Write, code }));
            }
        }
        outcome
    }

    fn health(&self) -> Health {
        Health {
            lost: self.devices.iter().map(GeneratorHandle::lost_channels).sum(),
            dropped: self.run.dropped(),
            failed_calls: self.devices.iter().map(GeneratorHandle::failed_calls).sum(),
            latched_safe: self.run.is_latched(),
            ..Health::default()
        }
    }

    fn output_claims(&self) -> Result<Vec<OutputClaim>, BoardError> {
        let copy = |held: &OutputClaim| {
            let claim = held.claim.try_clone()?;
            Ok(OutputClaim {
                device: held.device.clone(),
                claim,
                api: held.api,
                mask: held.mask,
                safe: held.safe,
            })
        };
        let refused = |error: std::io::Error| BoardError::Os {
            call: Call::Open,
            code: error.raw_os_error().unwrap_or(Errno::MFILE.raw_os_error()),
        };
        self.held.iter().map(copy).collect::<std::io::Result<_>>().map_err(refused)
    }

    fn pulse_outputs(&mut self) -> Option<&mut dyn PulseOutputs> {
        Some(self)
    }

    fn descriptions(&self) -> Option<&dyn Descriptions> {
        Some(self)
    }
}

impl PulseOutputs for GeneratorBoard {
    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
        let (device, output) = self.output(channel)?;
        if let Some(emits) = &self.channels[usize::from(channel.0)].emits {
            emits.check(emission).map_err(|why| BoardError::NotEmitted(channel, why))?;
        }
        let order = match emission {
            Emission::Square { period, high } => Order::Square { period: *period, high: *high },
            Emission::Pulses(edges) => Order::Pulses(edges.clone()),
        };
        self.devices[device].emit(output, order)
    }
}

impl Descriptions for GeneratorBoard {
    fn device(&self, channel: ChannelId) -> Option<&str> {
        let mine = |device: &&GeneratorHandle| device.outputs.iter().any(|output| output.channel == channel);
        self.devices.iter().find(mine).map(|device| device.device.as_str())
    }

    fn noise(&self, _channel: ChannelId) -> Option<f64> {
        None
    }
}
