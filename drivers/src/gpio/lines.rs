//! One chip as the board follows it: what its lines were driven to, what their edges reported, whether it still answers.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::HostInstant;
use signal::{Span, Time, When};

use super::chip::{ChipWorker, SharedChip};
use super::device::{ChipReport, Image};
use super::inputs::Inputs;
use crate::event_collector::EventCollector;
use crate::{BoardError, BoardEvent, ChannelId, LossReason, Origin};

/// Images of the outputs of a chip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Masks {
    /// Where they are safe.
    pub(super) safe: u64,
    /// Where each is left at when it lets go.
    pub(super) released: u64,
    /// Outputs whose channel has an input, too: that one reports it.
    pub(super) double: u64,
    /// Outputs that nobody wants to see.
    pub(super) unseen: u64,
    /// Outputs that carry pulses.
    pub(super) timed: u64,
}

/// A chip and what is known of its lines. Bits are places in its claim.
#[derive(Debug)]
pub(super) struct Lines {
    pub(super) shared: Arc<SharedChip>,
    pub(super) running: ChipWorker,
    /// The channel of each output.
    pub(super) drives: Vec<ChannelId>,
    inputs: Inputs,
    pub(super) masks: Masks,
    /// How long a call may last.
    limit: Span,
    /// The image that was asked for last, and one to be asked for.
    pub(super) wanted: u64,
    pub(super) next: u64,
    /// Images that were handed to the device, those that it was seen to have taken, and since when the rest is due.
    asked: u64,
    taken: u64,
    owing_since: HostInstant,
    /// The queue to the device was full: the newest image is still to be handed over.
    behind: bool,
    /// The newest image that was handed over, and the outputs that carry pulses of which an edge found no room.
    handed: u64,
    dropped: u64,
    /// What the outputs were driven to last.
    driven: u64,
    pub(super) lost: Option<LossReason>,
    /// Calls that had failed when the run began.
    pub(super) failed: u64,
}

impl Lines {
    pub(super) fn new(
        running: ChipWorker,
        drives: Vec<ChannelId>,
        inputs: Inputs,
        masks: Masks,
        limit: Span,
    ) -> Lines {
        Lines {
            shared: running.shared.clone(),
            running,
            drives,
            inputs,
            masks,
            limit,
            wanted: masks.safe,
            next: masks.safe,
            asked: 0,
            taken: 0,
            owing_since: HostInstant::BOOT,
            behind: false,
            handed: masks.safe,
            dropped: 0,
            driven: masks.safe,
            lost: None,
            failed: 0,
        }
    }

    /// Asks the device to begin again. The number of this beginning.
    pub(super) fn ask_start(&mut self) -> u64 {
        self.shared.latched.store(true, Ordering::Release);
        let start = self.shared.starts.fetch_add(1, Ordering::AcqRel) + 1;
        self.shared.device.ring();
        start
    }

    /// Waits until the device has begun again. FALSE where it does not in time.
    pub(super) fn await_start(&mut self, start: u64, due: HostInstant) -> bool {
        loop {
            while let Ok(report) = self.running.reports.pop() {
                let ChipReport::Started { start: done, before, after, bits, levels } = report else {
                    continue;
                };
                if done != start {
                    continue;
                }
                self.inputs.start(levels, before, after + self.limit);
                (self.driven, self.wanted, self.next) = (bits, bits, bits);
                (self.asked, self.behind, self.lost) =
                    (self.shared.taken.load(Ordering::Acquire), false, None);
                self.taken = self.asked;
                (self.handed, self.dropped) = (bits, 0);
                self.failed = self.shared.failed.load(Ordering::Acquire);
                for overflows in &self.shared.edge_overflows {
                    overflows.store(0, Ordering::Release);
                }
                self.shared.unreported.store(0, Ordering::Release);
                self.shared.latched.store(false, Ordering::Release);
                return true;
            }
            if self.gone() || HostInstant::now() >= due {
                return false;
            }
            self.shared.answer.wait_until(due);
        }
    }

    /// Drives everything safe, for good.
    pub(super) fn ask_safe(&mut self) -> u64 {
        (self.wanted, self.next, self.behind) = (self.masks.safe, self.masks.safe, false);
        self.shared.latched.store(true, Ordering::Release);
        let wanted = self.shared.wanted_safe.fetch_add(1, Ordering::AcqRel) + 1;
        self.shared.device.ring();
        wanted
    }

    /// Waits until everything is safe, and until every number of an edge has come or is given up.
    pub(super) fn await_safe(&self, wanted: u64, due: HostInstant) -> bool {
        loop {
            let safe = self.shared.made_safe.load(Ordering::Acquire) >= wanted;
            if safe && self.shared.open.load(Ordering::Acquire) == 0 {
                return true;
            }
            if self.gone() || HostInstant::now() >= due {
                return safe;
            }
            self.shared.answer.wait_until(due);
        }
    }

    pub(super) fn gone(&self) -> bool {
        self.shared.is_gone()
    }

    /// Hands the next image to the device, if it is another one.
    pub(super) fn ask(&mut self, now: HostInstant) {
        if self.next == self.wanted && !self.behind {
            return;
        }
        if self.behind {
            // The image that found no room is replaced: what it turned is driven at one instant with what this one
            // turns, or never.
            let lost = (self.handed ^ self.wanted) | (self.wanted ^ self.next);
            self.dropped |= if self.next == self.wanted { 0 } else { lost & self.masks.timed };
        }
        self.wanted = self.next;
        self.look(now);
        self.behind = self.running.images.push(Image { bits: self.next, asked: now }).is_err();
        if !self.behind {
            self.handed = self.next;
            if self.taken == self.asked {
                self.owing_since = now;
            }
            self.asked += 1;
        }
        self.shared.device.ring();
    }

    /// Looks at what the device has taken: whoever takes something is not silent.
    fn look(&mut self, now: HostInstant) {
        let taken = self.shared.taken.load(Ordering::Acquire);
        if taken != self.taken {
            (self.taken, self.owing_since) = (taken, now);
        }
    }

    /// When the chip counts as silent if it does not answer.
    pub(super) fn overdue(&self) -> Option<HostInstant> {
        if self.lost.is_some() {
            return None;
        }
        let owing =
            Some(self.owing_since).filter(|_| self.shared.taken.load(Ordering::Acquire) != self.asked);
        let called = self.shared.in_call.get();
        let since = match (owing, called) {
            (Some(owing), Some(called)) => owing.min(called),
            (owing, called) => owing.or(called)?,
        };
        Some(since + self.limit)
    }

    /// The levels of all sensed lines as they are.
    pub(super) fn present(&self, at: Time, collector: &mut EventCollector<'_>) {
        let at = When::exactly(at);
        self.inputs.present(at, collector);
        let silent = self.masks.double | self.masks.unseen;
        for (place, channel) in self.drives.iter().enumerate().filter(|(place, _)| silent >> place & 1 == 0) {
            collector.changed(*channel, at, self.driven >> place & 1 == 1, Origin::Write);
        }
    }

    /// Reports what happened up to now.
    pub(super) fn poll(&mut self, collector: &mut EventCollector<'_>) {
        let now = collector.time.stamp(collector.now);
        self.look(now);
        if self.behind {
            self.ask(now);
        }
        // Both queues are in the order of their stamps: what is older comes first.
        loop {
            let report = self.running.reports.peek().ok().copied();
            self.edges(report.map_or(HostInstant::NEVER, |report| stamp_of(&report)).min(now), collector);
            let Some(report) = report else { break };
            if stamp_of(&report) > now {
                collector.ahead(stamp_of(&report));
                break;
            }
            // It is the one that was looked at.
            let _ = self.running.reports.pop();
            self.report(report, collector);
        }
        self.report_edge_overflows(collector);
        self.answers(collector);
    }

    /// Edges up to this stamp.
    fn edges(&mut self, until: HostInstant, collector: &mut EventCollector<'_>) {
        let ready = self.running.notes.slots();
        let Ok(chunk) = self.running.notes.read_chunk(ready) else { return };
        let (first, second) = chunk.as_slices();
        let mut taken = 0;
        for note in first.iter().chain(second) {
            if note.stamp > until {
                collector.ahead(note.stamp);
                break;
            }
            self.inputs.edge(note, self.wanted, collector);
            taken += 1;
        }
        chunk.commit(taken);
    }

    fn report(&mut self, report: ChipReport, collector: &mut EventCollector<'_>) {
        match report {
            ChipReport::Set { before, after, bits } => {
                let at = When::within(collector.time.at(before), collector.time.at(after));
                let mut flips = (bits ^ self.driven) & !self.masks.double & !self.masks.unseen;
                self.driven = bits;
                while flips != 0 {
                    let place = flips.trailing_zeros();
                    flips &= flips - 1;
                    if let Some(channel) = self.drives.get(place as usize) {
                        collector.changed(*channel, at, bits >> place & 1 == 1, Origin::Write);
                    }
                }
            }
            ChipReport::Swallowed { output, count, at } => {
                if let Some(channel) = self.drives.get(usize::from(output)) {
                    collector.dropped(*channel, collector.time.at(at), count);
                }
            }
            ChipReport::Strayed { input, high, at } => self.inputs.stray(input, high, at, collector),
            // Was waited for.
            ChipReport::Started { .. } => {}
        }
    }

    /// What found no room on its way.
    fn report_edge_overflows(&mut self, collector: &mut EventCollector<'_>) {
        let dropped = std::mem::take(&mut self.dropped);
        for (_, channel) in self.drives.iter().enumerate().filter(|(place, _)| dropped >> place & 1 == 1) {
            collector.dropped(*channel, collector.now, 1);
        }
        if self.shared.overflowed.swap(false, Ordering::AcqRel) {
            for (place, channel) in self.inputs.channels().enumerate() {
                let count = self.shared.edge_overflows[place].swap(0, Ordering::AcqRel);
                collector.dropped(channel, collector.now, count);
            }
        }
        if self.shared.unreported.load(Ordering::Relaxed) > 0 {
            let count = u32::try_from(self.shared.unreported.swap(0, Ordering::AcqRel)).unwrap_or(u32::MAX);
            for channel in &self.drives {
                collector.dropped(*channel, collector.now, count);
            }
        }
    }

    /// Whether the chip still answers.
    fn answers(&mut self, collector: &mut EventCollector<'_>) {
        let now = collector.time.stamp(collector.now);
        let reason = match (self.gone(), self.lost) {
            (true, _) => Some(LossReason::Gone),
            (false, Some(_)) => {
                // It was silent. It answers again when no call is under way and nothing is due.
                let silent = self.taken != self.asked || self.shared.in_call.get().is_some();
                silent.then_some(LossReason::Unresponsive)
            }
            (false, None) => self.overdue().is_some_and(|due| due < now).then_some(LossReason::Unresponsive),
        };
        if reason == self.lost {
            return;
        }
        self.lost = reason;
        let at = collector.now;
        let Some(reason) = reason else { return self.returned(collector) };
        for channel in self.channels() {
            collector.report(BoardEvent::Lost { channel, at, reason });
        }
    }

    /// The chip is back, and these are its levels.
    pub(super) fn returned(&self, collector: &mut EventCollector<'_>) {
        let at = collector.now;
        for channel in self.channels() {
            collector.report(BoardEvent::Returned { channel, at });
        }
        self.present(at, collector);
    }

    /// Drives what the chip in whose place this one comes was asked to drive.
    pub(super) fn follow(&mut self, old: &Lines, now: HostInstant) {
        self.next = self.wanted;
        for (place, channel) in self.drives.iter().enumerate() {
            if let Some(before) = old.drives.iter().position(|other| other == channel) {
                let bit = 1u64 << place;
                let high = old.wanted >> before & 1 == 1;
                self.next = if high { self.next | bit } else { self.next & !bit };
            }
        }
        self.ask(now);
    }

    /// Its channels, each once.
    pub(super) fn channels(&self) -> impl Iterator<Item = ChannelId> + '_ {
        let outputs = self.drives.iter().enumerate().filter(|(place, _)| self.masks.double >> place & 1 == 0);
        self.inputs.channels().chain(outputs.map(|(_, channel)| *channel))
    }

    /// Calls that failed since the run began.
    pub(super) fn failures(&self) -> u64 {
        self.shared.failed.load(Ordering::Acquire).saturating_sub(self.failed)
    }

    /// What a start says that does not find the chip, or gets no answer of it.
    pub(super) fn is_lost(&self, reason: LossReason) -> BoardError {
        let since =
            self.shared.gone_at.get().or_else(|| self.overdue()).unwrap_or_else(HostInstant::now).elapsed();
        let channel = self.channels().next().unwrap_or(ChannelId(0));
        BoardError::Lost { channel, reason, since }
    }

    /// Channels that are lost with the chip.
    pub(super) fn lost_channels(&self) -> u32 {
        let outputs = self.drives.len() as u32 - self.masks.double.count_ones();
        if self.lost.is_some() { self.inputs.len() as u32 + outputs } else { 0 }
    }
}

fn stamp_of(report: &ChipReport) -> HostInstant {
    match *report {
        ChipReport::Set { after, .. } | ChipReport::Started { after, .. } => after,
        ChipReport::Swallowed { at, .. } | ChipReport::Strayed { at, .. } => at,
    }
}
