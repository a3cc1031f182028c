//! How the chips of a board are set to work: when it is opened, and when one that went away is there again.

use std::sync::Arc;

use rustix::io::Errno;
use signal::Span;

use super::chip::ChipWorker;
use super::device::ChipThread;
use super::edges::Edges;
use super::find::{device, refused};
use super::inputs::{Input, Inputs};
use super::lines::{Lines, Masks};
use super::pace::PulsePace;
use super::port::GpioPort;
use super::v1::PortV1;
use super::v2::PortV2;
use super::{Backend, Drive, Edge, FoundChip, GpioError, GpioSpec};
use crate::channel_table::ChannelTable;
use crate::codes;
use crate::refusal::Refusal;
use crate::{BoardContext, Channel, ChannelId, DeviceLimits, TimestampSource};

/// How much longer than asked for the kernel may debounce: it counts in ticks, of which there are at least 100 a second.
const TICKS: Span = Span::from_millis(20);

/// What the threads of a chip do, for somebody who does it in their place.
#[derive(Debug)]
pub struct Served {
    device: ChipThread,
    edges: Edges,
}

impl Served {
    /// One turn of the device: at most one call that sets and one that gets.
    pub fn turn(&mut self) {
        self.device.turn();
    }

    /// Edges as the kernel would report them.
    pub fn take(&mut self, edges: &[Edge]) {
        self.edges.take(edges);
    }
}

/// A chip at work.
#[derive(Debug)]
pub(super) struct Chip {
    /// Place in the board file.
    pub(super) spec: usize,
    /// What messages call it.
    pub(super) device: String,
    pub(super) port: Arc<dyn GpioPort>,
    pub(super) lines: Lines,
}

/// Makes the chips of a board.
#[derive(Clone, Debug)]
pub(super) struct Maker {
    /// Name of the board file.
    pub(super) file: String,
    pub(super) spec: GpioSpec,
    pub(super) limits: DeviceLimits,
    pub(super) context: BoardContext,
    /// The channels, as exact as the chips that were made allow.
    pub(super) channels: Vec<Channel>,
}

impl Maker {
    pub(super) fn new(
        table: &ChannelTable,
        spec: &GpioSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Maker {
        let mut channels = table.blank();
        super::describe(table, spec, &mut channels);
        Maker { file: table.file.clone(), spec: spec.clone(), limits, context: context.clone(), channels }
    }

    /// Claims a chip's lines and starts its threads.
    ///
    /// # Errors
    /// Why they cannot be had.
    pub(super) fn claim(&mut self, found: FoundChip) -> Result<Chip, Refusal> {
        let path = &found.info.path;
        let claimed: Result<Arc<dyn GpioPort>, GpioError> = match found.backend {
            Backend::V2 => PortV2::claim(path, &self.spec.consumer, &found.claim)
                .map(|port| Arc::new(port) as Arc<dyn GpioPort>),
            Backend::V1 => PortV1::claim(path, &self.spec.consumer, &found.claim)
                .map(|port| Arc::new(port) as Arc<dyn GpioPort>),
        };
        let port = claimed.map_err(|error| not_claimed(&found, &error))?;
        self.work(found, port).map_err(|error| {
            let help = "the machine has no room for another thread: see `ulimit -u`";
            Refusal::new(codes::HOST, format!("the threads of a chip cannot be started: {error}"), help)
        })
    }

    pub(super) fn work(&mut self, found: FoundChip, port: Arc<dyn GpioPort>) -> std::io::Result<Chip> {
        let name = found.info.name.clone();
        let (mut chip, Served { device, edges }) = self.prepare(found, port)?;
        chip.lines.running.start(&name, device, edges, self.context.realtime)?;
        Ok(chip)
    }

    pub(super) fn prepare(
        &mut self,
        found: FoundChip,
        port: Arc<dyn GpioPort>,
    ) -> std::io::Result<(Chip, Served)> {
        let outputs = || found.claim.outputs.iter().enumerate();
        let safe = outputs().fold(0u64, |bits, (place, line)| bits | u64::from(line.safe) << place);
        // A line that lets go is where its pull takes it.
        let released = outputs().fold(0u64, |bits, (place, line)| {
            let level = match line.drive {
                Drive::PushPull => false,
                Drive::OpenDrain => !line.active_low,
                Drive::OpenSource => line.active_low,
            };
            bits | u64::from(level) << place
        });
        for (channel, line) in found.senses.iter().zip(&found.claim.inputs) {
            self.stamped(*channel, found.backend, Span::from_micros(i64::from(line.debounce_us)));
        }
        for channel in found.drives.iter().filter(|channel| !found.senses.contains(channel)) {
            self.channels[usize::from(channel.0)].resolution = self.context.resolution;
        }
        let senses = |channel: &ChannelId| self.channels[usize::from(channel.0)].senses;
        let masked = |yes: &dyn Fn(&ChannelId) -> bool| {
            let places = found.drives.iter().enumerate();
            places.fold(0u64, |bits, (place, channel)| bits | u64::from(yes(channel)) << place)
        };
        let double = masked(&|channel| found.senses.contains(channel));
        let promised = |channel: &ChannelId| self.channels[usize::from(channel.0)].max_pulse_hz;
        let pace = PulsePace::new(found.drives.iter().map(promised));
        let unseen = masked(&|channel| !senses(channel));
        let masks = Masks { safe, released, double, unseen, timed: pace.timed() };
        let inputs = found.senses.iter().map(|channel| Input {
            channel: *channel,
            resolution: self.channels[usize::from(channel.0)].resolution,
            senses: senses(channel),
            output: found.drives.iter().position(|other| other == channel).map(|place| place as u8),
        });
        let inputs = Inputs::new(inputs.collect());
        let limit = self.limits.unresponsive_after;
        let (running, of_device, edges) =
            ChipWorker::new(port.clone(), safe, pace, &self.context.bell, limit)?;
        let device = device(&found.info);
        let lines = Lines::new(running, found.drives, inputs, masks, limit);
        Ok((Chip { spec: found.spec, device, port, lines }, Served { device: of_device, edges }))
    }

    /// What the events of an input are worth.
    fn stamped(&mut self, channel: ChannelId, backend: Backend, debounce: Span) {
        let channel = &mut self.channels[usize::from(channel.0)];
        channel.resolution = self.context.resolution;
        if debounce > Span::ZERO {
            channel.resolution = channel.resolution + debounce + TICKS;
        }
        if backend == Backend::V1 {
            // The kernel stamps the edges, but may lose some without a sign: no more is certain than of a line that is
            // looked at now and then.
            channel.timestamp = TimestampSource::Sampled { period: channel.resolution };
            channel.shortest_pulse = self.limits.unresponsive_after;
        }
    }
}

/// What a refused claim means.
fn not_claimed(found: &FoundChip, error: &GpioError) -> Refusal {
    if error.errno != Errno::BUSY {
        return refused(error);
    }
    // Somebody was quicker than this rig since the lines were looked at.
    let lines = super::look(&found.info.path).map(|info| info.lines).unwrap_or_default();
    let own = found.claim.outputs.iter().chain(&found.claim.inputs);
    let mut busy =
        own.filter_map(|line| lines.iter().find(|other| other.number == line.number && other.used));
    let message = match busy.next() {
        Some(line) => {
            let holder = line.holder().unwrap_or("somebody");
            format!("line {} of {} is held by {holder}", line.number, found.info.path.display())
        }
        None => format!("lines of {} were held by somebody else a moment ago", found.info.path.display()),
    };
    Refusal::new(codes::BUSY, message, "end that program or driver, or take another line")
}
