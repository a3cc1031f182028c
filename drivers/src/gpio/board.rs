//! The GPIO lines of a board.

use std::sync::Arc;

use document::Diagnostic;
use host::HostInstant;
use rustix::io::Errno;
use signal::{Span, Time, Value};

use super::find::find;
use super::lines::Lines;
use super::make::{Chip, Maker, Served};
use super::port::GpioPort;
use super::reconnect::{Reconnected, Reconnector};
use super::{FoundChip, GpioSpec};
use crate::channel_table::ChannelTable;
use crate::event_collector::EventCollector;
use crate::run_state::{RunState, START};
use crate::thread::not_started;
use crate::{
    Board, BoardContext, BoardError, BoardEvent, Call, Channel, ChannelId, Descriptions, DeviceLimits,
    Health, LossReason, OutputClaim,
};

/// The line that a channel drives: its chip, its place among the chip's outputs.
type Driven = Option<(u16, u8)>;

/// GPIO lines as a board. The calls of the board never wait for a chip, but for its start and its safe state: a thread
/// of each chip drives and reads it, another one takes its edges.
#[derive(Debug)]
pub struct GpioBoard {
    maker: Maker,
    drives: Vec<Driven>,
    chips: Vec<Chip>,
    /// Looks for chips that are gone, where the board file wants them back.
    reconnector: Option<Reconnector>,
    run: RunState,
    /// Calls that had failed on chips that were replaced since.
    failed: u64,
}

impl GpioBoard {
    /// Finds the board's chips and claims its lines, outputs at their safe values.
    ///
    /// # Errors
    /// All that is not there, not free, not permitted or cannot be done, by place.
    pub fn open(
        table: &ChannelTable,
        spec: &GpioSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<GpioBoard, Vec<Diagnostic>> {
        let mut board = GpioBoard::without_chips(table, spec, limits, context);
        for found in find(&table.file, spec)? {
            let place = spec.chips[found.spec].place.clone();
            let claimed =
                board.maker.claim(found).map_err(|refusal| vec![refusal.finding(&table.file, place)])?;
            board.add(claimed);
        }
        if limits.reconnect {
            let reconnector = Reconnector::start(board.maker.clone(), &board.chips)
                .map_err(|error| not_started(&table.file, "the thread that opens chips again", &error))?;
            board.reconnector = Some(reconnector);
        }
        Ok(board)
    }

    /// A board of one chip behind any port: for tests without the kernel, and to measure what the board itself takes.
    ///
    /// # Errors
    /// The threads of the chip could not be started.
    pub fn on_port(
        table: &ChannelTable,
        spec: &GpioSpec,
        limits: DeviceLimits,
        context: &BoardContext,
        found: FoundChip,
        port: Arc<dyn GpioPort>,
    ) -> std::io::Result<GpioBoard> {
        let mut board = GpioBoard::without_chips(table, spec, limits, context);
        let chip = board.maker.work(found, port)?;
        board.add(chip);
        Ok(board)
    }

    /// As [`GpioBoard::on_port`], but without threads: the caller serves the chip. A start or a safe state waits until
    /// it does, on another thread.
    ///
    /// # Errors
    /// The process has no descriptor left.
    pub fn served(
        table: &ChannelTable,
        spec: &GpioSpec,
        limits: DeviceLimits,
        context: &BoardContext,
        found: FoundChip,
        port: Arc<dyn GpioPort>,
    ) -> std::io::Result<(GpioBoard, Served)> {
        let mut board = GpioBoard::without_chips(table, spec, limits, context);
        let (chip, served) = board.maker.prepare(found, port)?;
        board.add(chip);
        Ok((board, served))
    }

    fn without_chips(
        table: &ChannelTable,
        spec: &GpioSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> GpioBoard {
        GpioBoard {
            maker: Maker::new(table, spec, limits, context),
            drives: vec![None; table.channels.len()],
            chips: Vec::new(),
            reconnector: None,
            run: RunState::default(),
            failed: 0,
        }
    }

    fn add(&mut self, chip: Chip) {
        self.route(self.chips.len(), &chip);
        self.chips.push(chip);
    }

    /// The lines that the chip at this place drives.
    fn route(&mut self, at: usize, chip: &Chip) {
        for (place, channel) in chip.lines.drives.iter().enumerate() {
            self.drives[usize::from(channel.0)] = Some((at as u16, place as u8));
        }
    }

    /// Puts a chip that is back in the place of the one that went away.
    fn replace(&mut self, Reconnected { at, chip }: Reconnected) -> Chip {
        self.route(at, &chip);
        self.failed += self.chips[at].lines.failures();
        std::mem::replace(&mut self.chips[at], chip)
    }

    /// Takes chips that are back, and says so. What they drove before they drive again.
    fn take_back(&mut self, collector: &mut EventCollector<'_>) {
        while let Some(reconnected) =
            self.reconnector.as_mut().and_then(|reconnector| reconnector.back.pop().ok())
        {
            let at = reconnected.at;
            // What the old one had still to report, its loss included.
            self.chips[at].lines.poll(collector);
            let old = self.replace(reconnected);
            let lines = &mut self.chips[at].lines;
            lines.returned(collector);
            if !self.run.is_latched() {
                lines.follow(&old.lines, collector.time.stamp(collector.now));
            }
            self.done_with(old);
        }
    }

    /// A chip whose threads end by and by.
    fn done_with(&mut self, old: Chip) {
        if let Some(reconnector) = &mut self.reconnector {
            // There is room for more chips than can be on their way.
            let _ = reconnector.old.push(old);
        }
    }

    /// Chips that went away are waited for, where they are wanted back.
    ///
    /// # Errors
    /// One is gone still.
    fn return_lost(&mut self) -> Result<(), BoardError> {
        let due = self.due(START);
        loop {
            while let Some(reconnected) =
                self.reconnector.as_mut().and_then(|reconnector| reconnector.back.pop().ok())
            {
                let old = self.replace(reconnected);
                self.done_with(old);
            }
            let Some(gone) = self.chips.iter().find(|chip| chip.lines.gone()) else { return Ok(()) };
            match &self.reconnector {
                Some(reconnector) if HostInstant::now() < due => reconnector.wait(due),
                _ => return Err(gone.lines.is_lost(LossReason::Gone)),
            }
        }
    }

    /// When a chip that does not answer by then is not waited for any longer; at least so long.
    fn due(&self, least: Span) -> HostInstant {
        HostInstant::now() + self.maker.limits.unresponsive_after.max(least)
    }
}

impl Board for GpioBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.maker.channels
    }

    /// Waits for the chips, as long as one may be silent or two seconds.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.end();
        self.return_lost()?;
        let starts: Vec<u64> = self.chips.iter_mut().map(|chip| chip.lines.ask_start()).collect();
        let due = self.due(START);
        for (chip, start) in self.chips.iter_mut().zip(starts) {
            if !chip.lines.await_start(start, due) {
                let reason = if chip.lines.gone() { LossReason::Gone } else { LossReason::Unresponsive };
                return Err(chip.lines.is_lost(reason));
            }
        }
        self.run.begin(now);
        self.run.start_unreported();
        self.failed = 0;
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.run.drive_at(now)?;
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
        let now = self.maker.context.time.stamp(now);
        for chip in &mut self.chips {
            chip.lines.ask(now);
        }
        Ok(())
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let time = self.maker.context.time.clone();
        let mut collector = EventCollector::new(out, &time, now);
        if let Some(start) = self.run.take_fresh() {
            for chip in &self.chips {
                chip.lines.present(start, &mut collector);
            }
        }
        self.take_back(&mut collector);
        for chip in &mut self.chips {
            chip.lines.poll(&mut collector);
        }
        self.run.polled(collector);
        Ok(())
    }

    /// What lies ahead of the last poll, and when a chip whose answer is due counts as lost.
    fn next_event(&self) -> Option<Time> {
        let deadlines = self.chips.iter().filter_map(|chip| chip.lines.overdue());
        self.run.next_event(&self.maker.context.time, deadlines)
    }

    /// Waits for the chips, at most as long as one may be silent. A chip that hangs is made safe as soon as its call
    /// ends.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.latch(now);
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
            dropped: self.run.dropped()
                + lines().map(|lines| u64::from(lines.shared.open.load(Acquire))).sum::<u64>(),
            failed_calls: self.failed + lines().map(Lines::failures).sum::<u64>(),
            latched_safe: self.run.is_latched(),
            ..Health::default()
        }
    }

    fn output_claims(&self) -> Result<Vec<OutputClaim>, BoardError> {
        let mut all = Vec::new();
        for chip in &self.chips {
            let held = chip.port.output_claims(&chip.device);
            all.extend(held.map_err(|error| BoardError::Os {
                call: Call::Configure,
                code: error.raw_os_error().unwrap_or(0),
            })?);
        }
        Ok(all)
    }

    fn descriptions(&self) -> Option<&dyn Descriptions> {
        Some(self)
    }
}

impl Descriptions for GpioBoard {
    fn device(&self, channel: ChannelId) -> Option<&str> {
        let serves = |chip: &&Chip| chip.lines.channels().any(|other| other == channel);
        self.chips.iter().find(serves).map(|chip| chip.device.as_str())
    }

    fn device_kind(&self, channel: ChannelId) -> Option<&'static str> {
        self.device(channel).map(|_| "gpio")
    }

    fn noise(&self, _channel: ChannelId) -> Option<f64> {
        None
    }
}
