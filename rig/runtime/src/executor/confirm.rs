//! What a step drives on real lines, and when it was driven. Devices take their time, and what a real controller does
//! about a line counts from the line: so the mark of a step that drives lines ends when they were seen driven.

use super::Executor;
use crate::executor::rig_fault::RigFault;
use crate::schedule::Act;
use controller::Command;
use drivers::{Channel, ChannelId};
use signal::{Span, Value};

/// The writes that were asked for and not seen yet.
#[derive(Debug, Default)]
pub(super) struct PendingWrites {
    channels: Vec<ChannelId>,
    /// What each channel was driven to last.
    last: Vec<Value>,
    /// The step whose mark waits for them.
    step: Option<usize>,
}

impl PendingWrites {
    /// For these channels, which are as safe has them.
    pub(super) fn new(channels: &[Channel]) -> PendingWrites {
        PendingWrites {
            channels: Vec::with_capacity(channels.len()),
            last: channels.iter().map(|channel| channel.safe).collect(),
            step: None,
        }
    }

    /// A change of this channel was seen.
    #[inline]
    pub(super) fn seen(&mut self, channel: ChannelId) {
        if self.channels.is_empty() {
            return;
        }
        self.channels.retain(|awaited| *awaited != channel);
    }
}

impl Executor<'_> {
    /// Whether what is driven is waited for: a controller that the rig plays is computed meanwhile.
    fn awaits_lines(&self) -> bool {
        self.pacing.has_wires() && !self.parts.subject.is_model()
    }

    /// These writes are about to be made.
    pub(super) fn expect_writes(&mut self) {
        if !self.awaits_lines() {
            return;
        }
        for (channel, value) in &self.buffers.writes {
            let place = usize::from(channel.0);
            let Some(last) = self.awaited.writes.last.get_mut(place) else { continue };
            let seen = self.parts.board.channels().get(place).is_some_and(|channel| channel.senses);
            if std::mem::replace(last, *value) != *value
                && seen
                && !self.awaited.writes.channels.contains(channel)
            {
                self.awaited.writes.channels.push(*channel);
            }
        }
    }

    /// A step begins: it is marked now, or where it drives lines, when they were driven.
    pub(super) fn begin_mark(&mut self, step: usize) {
        let drives = |(after, act): &(Span, Act)| {
            *after == Span::ZERO
                && matches!(act, Act::Drive(..) | Act::Power(_) | Act::Command(Command::Switch(_), _))
        };
        self.awaited.writes.channels.clear();
        if self.waits_for_relay(step) {
            return;
        }
        if self.awaits_lines() && self.parts.schedule.steps()[step].acts.iter().any(drives) {
            self.awaited.writes.step = Some(step);
        } else {
            self.mark_step(step);
        }
    }

    fn mark_step(&mut self, step: usize) {
        let mark = self.parts.schedule.steps()[step].mark;
        self.parts.recorder.mark(mark, self.seen(self.now));
    }

    /// An act of a step is done: waits until its lines were driven.
    pub(super) fn end_act(&mut self, step: usize, place: usize) -> Result<(), RigFault> {
        if !self.awaits_lines() {
            return Ok(());
        }
        let began = self.actual;
        let limit = began.saturating_add(self.limits.late);
        while !self.awaited.writes.channels.is_empty() && self.report.fault.is_none() {
            self.actual = self.parts.clock.wait(limit).max(self.actual);
            self.poll()?;
            if self.actual >= limit && !self.awaited.writes.channels.is_empty() {
                let late = self.actual - began;
                self.report.fault.get_or_insert(RigFault::Late { at: began, late, limit: self.limits.late });
            }
        }
        let acts = &self.parts.schedule.steps()[step].acts;
        let last = acts.get(place + 1).is_none_or(|(after, _)| *after > Span::ZERO);
        if self.awaited.writes.step == Some(step) && last {
            self.awaited.writes.step = None;
            self.mark_step(step);
        }
        Ok(())
    }
}
