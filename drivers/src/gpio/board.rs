//! The GPIO lines of a board.

use std::sync::Arc;

use document::Diagnostic;
use host::monotonic;
use rustix::io::Errno;
use signal::{Span, Time, Value};

use super::chip::Running;
use super::device::Device;
use super::edges::Edges;
use super::find::{device, find, find_again, why};
use super::inputs::{Input, Inputs};
use super::lines::{Lines, Masks};
use super::port::Port;
use super::telling::Telling;
use super::v1::PortV1;
use super::v2::PortV2;
use super::{Backend, Drive, Edge, FoundChip, GpioError, GpioSpec};
use crate::file::{BoardFile, codes};
use crate::{
    Board, BoardError, BoardEvent, Call, Channel, ChannelId, Fault, Health, HeldLines, Surroundings,
    TimestampSource,
};

/// How long a start waits for a chip at least: nothing runs yet that it could hold up, and threads are new.
const START: Span = Span::from_secs(2);

/// How much longer than asked for the kernel may debounce: it counts in ticks, of which there are at least 100 a second.
const TICKS: Span = Span::from_millis(20);

/// The line that a channel drives: its chip, its place among the chip's outputs.
type Driven = Option<(u16, u8)>;

/// GPIO lines as a board. The calls of the board never wait for a chip, but for its start and its safe state: a thread
/// of each chip drives and reads it, another one takes its edges.
#[derive(Debug)]
pub struct GpioBoard {
    file: BoardFile,
    spec: GpioSpec,
    surroundings: Surroundings,
    channels: Vec<Channel>,
    drives: Vec<Driven>,
    chips: Vec<Chip>,
    started: bool,
    latched: bool,
    /// The start, until it was told what the lines were then.
    fresh: Option<Time>,
    last: Time,
    ahead: Option<Time>,
    dropped: u64,
}

/// What the threads of a chip do, for somebody who does it in their place.
#[derive(Debug)]
pub struct Served {
    device: Device,
    edges: Edges,
}

impl Served {
    /// One turn of the device: at most one call that sets and one that gets.
    pub fn turn(&mut self) {
        self.device.turn();
    }

    /// Edges as the kernel would tell them.
    pub fn take(&mut self, edges: &[Edge]) {
        self.edges.take(edges);
    }
}

#[derive(Debug)]
struct Chip {
    /// Place in the board file.
    spec: usize,
    device: String,
    port: Arc<dyn Port>,
    lines: Lines,
}

impl GpioBoard {
    /// Finds the board's chips and claims its lines, outputs at their safe values.
    ///
    /// # Errors
    /// All that is not there, not free, not permitted or cannot be done, by place.
    pub fn open(
        file: &BoardFile,
        spec: &GpioSpec,
        surroundings: &Surroundings,
    ) -> Result<GpioBoard, Vec<Diagnostic>> {
        let mut board = GpioBoard::without_chips(file, spec, surroundings);
        for found in find(file, spec)? {
            let place = spec.chips[found.spec].place.clone();
            let at = board.chips.len();
            let claimed = board.claim(found, at).map_err(|(code, message, help)| {
                vec![Diagnostic::error(code, message).at(file.name.clone(), place, "").help(help)]
            })?;
            board.chips.push(claimed);
        }
        Ok(board)
    }

    /// A board of one chip behind any port: for tests without the kernel, and to measure what the board itself takes.
    ///
    /// # Errors
    /// The threads of the chip could not be started.
    pub fn on_port(
        file: &BoardFile,
        spec: &GpioSpec,
        surroundings: &Surroundings,
        found: FoundChip,
        port: Arc<dyn Port>,
    ) -> std::io::Result<GpioBoard> {
        let mut board = GpioBoard::without_chips(file, spec, surroundings);
        let chip = board.work(found, 0, port)?;
        board.chips.push(chip);
        Ok(board)
    }

    /// As [`GpioBoard::on_port`], but without threads: the caller serves the chip. A start or a safe state waits until
    /// it does, on another thread.
    ///
    /// # Errors
    /// The process has no descriptor left.
    pub fn served(
        file: &BoardFile,
        spec: &GpioSpec,
        surroundings: &Surroundings,
        found: FoundChip,
        port: Arc<dyn Port>,
    ) -> std::io::Result<(GpioBoard, Served)> {
        let mut board = GpioBoard::without_chips(file, spec, surroundings);
        let (chip, served) = board.prepare(found, 0, port)?;
        board.chips.push(chip);
        Ok((board, served))
    }

    fn without_chips(file: &BoardFile, spec: &GpioSpec, surroundings: &Surroundings) -> GpioBoard {
        let mut channels = crate::real::blank(file);
        super::describe(file, spec, &mut channels);
        GpioBoard {
            file: file.clone(),
            spec: spec.clone(),
            surroundings: surroundings.clone(),
            channels,
            drives: vec![None; file.circuit.channels.len()],
            chips: Vec::new(),
            started: false,
            latched: false,
            fresh: None,
            last: Time::ZERO,
            ahead: None,
            dropped: 0,
        }
    }

    /// Claims a chip's lines and starts its threads; `at` is its place among the chips. On failure the code, the words
    /// and what mends it.
    fn claim(&mut self, found: FoundChip, at: usize) -> Result<Chip, (&'static str, String, String)> {
        let path = &found.info.path;
        let claimed: Result<Arc<dyn Port>, GpioError> = match found.backend {
            Backend::V2 => PortV2::claim(path, &self.spec.consumer, &found.claim)
                .map(|port| Arc::new(port) as Arc<dyn Port>),
            Backend::V1 => PortV1::claim(path, &self.spec.consumer, &found.claim)
                .map(|port| Arc::new(port) as Arc<dyn Port>),
        };
        let port = claimed.map_err(|error| refused(&found, &error))?;
        self.work(found, at, port).map_err(|error| {
            let help = String::from("the machine has no room for another thread: see `ulimit -u`");
            (codes::HOST, format!("the threads of a chip cannot be started: {error}"), help)
        })
    }

    fn work(&mut self, found: FoundChip, at: usize, port: Arc<dyn Port>) -> std::io::Result<Chip> {
        let name = found.info.name.clone();
        let (mut chip, Served { device, edges }) = self.prepare(found, at, port)?;
        chip.lines.running.start(&name, device, edges, self.surroundings.realtime)?;
        Ok(chip)
    }

    fn prepare(
        &mut self,
        found: FoundChip,
        at: usize,
        port: Arc<dyn Port>,
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
        for (place, channel) in found.drives.iter().enumerate() {
            self.drives[usize::from(channel.0)] = Some((at as u16, place as u8));
        }
        for (channel, line) in found.senses.iter().zip(&found.claim.inputs) {
            self.stamped(*channel, found.backend, Span::from_micros(i64::from(line.debounce_us)));
        }
        for channel in found.drives.iter().filter(|channel| !found.senses.contains(channel)) {
            self.channels[usize::from(channel.0)].resolution = self.surroundings.resolution;
        }
        let senses = |channel: &ChannelId| self.channels[usize::from(channel.0)].senses;
        let masked = |yes: &dyn Fn(&ChannelId) -> bool| {
            let places = found.drives.iter().enumerate();
            places.fold(0u64, |bits, (place, channel)| bits | u64::from(yes(channel)) << place)
        };
        let double = masked(&|channel| found.senses.contains(channel));
        let masks = Masks { safe, released, double, unseen: masked(&|channel| !senses(channel)) };
        let inputs = found.senses.iter().map(|channel| Input {
            channel: *channel,
            resolution: self.channels[usize::from(channel.0)].resolution,
            senses: senses(channel),
            output: found.drives.iter().position(|other| other == channel).map(|place| place as u8),
        });
        let inputs = Inputs::new(inputs.collect());
        let limit = self.spec.silent_after.as_nanos();
        let (running, of_device, edges) = Running::new(port.clone(), safe, &self.surroundings.bell, limit)?;
        let device = device(&found.info);
        let lines = Lines::new(running, found.drives, inputs, masks, limit);
        Ok((Chip { spec: found.spec, device, port, lines }, Served { device: of_device, edges }))
    }

    /// What the events of an input are worth.
    fn stamped(&mut self, channel: ChannelId, backend: Backend, debounce: Span) {
        let channel = &mut self.channels[usize::from(channel.0)];
        channel.resolution = self.surroundings.resolution;
        if debounce > Span::ZERO {
            channel.resolution = channel.resolution + debounce + TICKS;
        }
        if backend == Backend::V1 {
            // The kernel stamps the edges, but may lose some without a sign: no more is certain than of a line that is
            // looked at now and then.
            channel.timestamp = TimestampSource::Sampled { period: channel.resolution };
            channel.shortest_pulse = self.spec.silent_after;
        }
    }

    fn check_time(&mut self, now: Time) -> Result<(), BoardError> {
        if !self.started {
            return Err(BoardError::NotStarted);
        }
        if now < self.last {
            return Err(BoardError::Backwards { now, last: self.last });
        }
        self.last = now;
        Ok(())
    }

    /// Chips that went away are looked for again.
    fn return_lost(&mut self) -> Result<(), BoardError> {
        for at in 0..self.chips.len() {
            if !self.chips[at].lines.gone() {
                continue;
            }
            let found = find_again(&self.file, &self.spec, self.chips[at].spec);
            let chip = found.and_then(|found| self.claim(found, at).ok());
            let code = Errno::NODEV.raw_os_error();
            self.chips[at] = chip.ok_or(BoardError::Os { call: Call::Open, code })?;
        }
        Ok(())
    }

    /// When a chip that does not answer by then is not waited for any longer; at least so long.
    fn due(&self, least: Span) -> i64 {
        monotonic().saturating_add(self.spec.silent_after.max(least).as_nanos())
    }
}

/// What a refused claim means.
fn refused(found: &FoundChip, error: &GpioError) -> (&'static str, String, String) {
    if error.code != Errno::BUSY.raw_os_error() {
        let (code, help) = why(error);
        return (code, error.to_string(), help);
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
    (codes::BUSY, message, String::from("end that program or driver, or take another line"))
}

impl Board for GpioBoard {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Waits for the chips, as long as one may be silent or two seconds.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.started = false;
        self.return_lost()?;
        let starts: Vec<u64> = self.chips.iter_mut().map(|chip| chip.lines.ask_start()).collect();
        let due = self.due(START);
        for (chip, start) in self.chips.iter_mut().zip(starts) {
            if !chip.lines.await_start(start, due) {
                let gone = chip.lines.gone();
                let code = if gone { Errno::NODEV } else { Errno::TIMEDOUT }.raw_os_error();
                return Err(BoardError::Os { call: Call::Write, code });
            }
        }
        (self.started, self.latched, self.fresh) = (true, false, Some(now));
        (self.last, self.ahead, self.dropped) = (now, None, 0);
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.check_time(now)?;
        if self.latched {
            return Err(BoardError::Latched);
        }
        for chip in &mut self.chips {
            chip.lines.next = chip.lines.wanted;
        }
        for (channel, value) in writes {
            let known = self.drives.get(usize::from(channel.0)).ok_or(BoardError::NoChannel(*channel))?;
            let (chip, place) = known.ok_or(BoardError::NotDriven(*channel))?;
            let lines = &mut self.chips[usize::from(chip)].lines;
            let bit = 1u64 << place;
            let high = match value {
                Value::Bool(high) => *high,
                Value::HighZ => lines.masks.released & bit != 0,
                _ => return Err(BoardError::BadValue(*channel)),
            };
            lines.next = if high { lines.next | bit } else { lines.next & !bit };
        }
        let now = self.surroundings.time.stamp(now);
        for chip in &mut self.chips {
            chip.lines.ask(now);
        }
        Ok(())
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.check_time(now)?;
        let mut telling = Telling::new(out, &self.surroundings.time, now);
        if let Some(start) = self.fresh.take() {
            for chip in &self.chips {
                chip.lines.present(start, &mut telling);
            }
        }
        for chip in &mut self.chips {
            chip.lines.poll(&mut telling);
        }
        self.dropped += telling.dropped;
        self.ahead = telling.ahead;
        telling.sort();
        Ok(())
    }

    /// What lies ahead of the last poll, and when a chip that owes an answer counts as lost.
    fn next_event(&self) -> Option<Time> {
        if !self.started {
            return None;
        }
        let silent = self.chips.iter().filter_map(|chip| chip.lines.overdue()).min();
        let silent = silent.map(|stamp| self.surroundings.time.at(stamp.saturating_add(1)));
        [self.fresh, self.ahead, silent].into_iter().flatten().min()
    }

    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError> {
        self.check_time(now)?;
        Err(BoardError::NoSuchFault(fault.channel))
    }

    fn clear(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError> {
        self.check_time(now)?;
        let known = usize::from(channel.0) < self.channels.len();
        if known { Ok(()) } else { Err(BoardError::NoChannel(channel)) }
    }

    /// Waits for the chips, at most as long as one may be silent. A chip that hangs is made safe as soon as its call
    /// ends.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.latched = true;
        self.last = self.last.max(now);
        let wanted: Vec<u64> = self.chips.iter_mut().map(|chip| chip.lines.ask_safe()).collect();
        let due = self.due(Span::ZERO);
        let mut outcome = Ok(());
        for (chip, wanted) in self.chips.iter().zip(wanted) {
            if !chip.lines.await_safe(wanted, due) && !chip.lines.drives.is_empty() {
                let code = if chip.lines.gone() { Errno::NODEV } else { Errno::TIMEDOUT }.raw_os_error();
                outcome = outcome.and(Err(BoardError::Os { call: Call::Write, code }));
            }
        }
        outcome
    }

    fn health(&self) -> Health {
        use std::sync::atomic::Ordering::Acquire;
        let lines = || self.chips.iter().map(|chip| &chip.lines);
        Health {
            lost: lines().map(Lines::lost_channels).sum(),
            dropped: self.dropped
                + lines().map(|lines| u64::from(lines.shared.open.load(Acquire))).sum::<u64>(),
            failed_calls: lines().map(|lines| lines.shared.failed.load(Acquire) - lines.failed).sum(),
            latched_safe: self.latched,
            ..Health::default()
        }
    }

    fn held(&self) -> Result<Vec<HeldLines>, BoardError> {
        let mut all = Vec::new();
        for chip in &self.chips {
            let held = chip.port.held(&chip.device);
            all.extend(held.map_err(|error| BoardError::Os {
                call: Call::Configure,
                code: error.raw_os_error().unwrap_or(0),
            })?);
        }
        Ok(all)
    }
}
