//! Faults that a relay puts on a wire take their time: the mark of such a step is the fault itself, as far as it is known
//! when it came.

use super::Executor;
use crate::executor::rig_fault::RigFault;
use crate::schedule::Act;
use drivers::{BoardExt, ChannelId, Origin};
use signal::{Span, Time, When};

/// A step whose relay moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct RelayMark {
    step: usize,
    channel: ChannelId,
    /// When it began; `None` until the board was asked.
    asked: Option<Time>,
}

/// The steps whose marks wait for relays.
#[derive(Debug, Default)]
pub(super) struct RelayMarks(Vec<RelayMark>);

impl RelayMarks {
    /// For steps on so many channels.
    pub(super) fn new(channels: usize) -> RelayMarks {
        RelayMarks(Vec::with_capacity(channels))
    }
}

impl Executor<'_> {
    /// Whether the mark of a step that begins waits for a relay.
    pub(super) fn waits_for_relay(&mut self, step: usize) -> bool {
        let put = |(after, act): &(Span, Act)| match act {
            Act::Fault(fault) if *after == Span::ZERO => Some(fault.channel),
            Act::Clear(channel) if *after == Span::ZERO => Some(*channel),
            _ => None,
        };
        let channel = self.parts.schedule.steps()[step].acts.iter().find_map(put);
        let Some(channel) =
            channel.filter(|channel| self.parts.board.fault_switching_time(*channel) > Span::ZERO)
        else {
            return false;
        };
        // What went before on this wire will never be seen apart from what comes now.
        self.mark_pending_faults(|moving| moving.channel == channel || moving.step == step);
        self.awaited.relays.0.push(RelayMark { step, channel, asked: None });
        true
    }

    /// The board was asked for what a step does to a channel.
    pub(super) fn relay_asked(&mut self, channel: ChannelId) {
        let now = self.now;
        if let Some(moving) = self.awaited.relays.0.iter_mut().find(|moving| moving.channel == channel) {
            moving.asked.get_or_insert(now);
        }
    }

    /// Marks the steps whose faults came. What the lines reported of them is recorded after the marks.
    pub(super) fn mark_faults_seen(&mut self) {
        for place in (0..self.awaited.relays.0.len()).rev() {
            let RelayMark { step, channel, asked: Some(asked) } = self.awaited.relays.0[place] else {
                continue;
            };
            if let Some(came) = self.parts.board.fault_settled_at(channel) {
                let came = self.seen_by_board(came, channel, Origin::Outside);
                self.awaited.relays.0.remove(place);
                self.mark_fault(step, When::within(came.earliest.max(asked), came.latest.max(asked)));
            }
        }
    }

    /// Marks these steps, whose faults came at some time up to now.
    pub(super) fn mark_pending_faults(&mut self, of: impl Fn(RelayMark) -> bool) {
        for place in (0..self.awaited.relays.0.len()).rev() {
            let moving = self.awaited.relays.0[place];
            if of(moving) {
                self.awaited.relays.0.remove(place);
                self.mark_fault(moving.step, When::within(moving.asked.unwrap_or(self.now), self.actual));
            }
        }
    }

    fn mark_fault(&mut self, step: usize, at: When) {
        let mark = self.parts.schedule.steps()[step].mark;
        self.parts.recorder.mark(mark, at);
    }

    /// A step is over: its fault has come, or comes within what a device may take.
    pub(super) fn await_relay(&mut self, step: usize) -> Result<(), RigFault> {
        let began = self.actual;
        let limit = began.saturating_add(self.limits.late);
        while self.awaited.relays.0.iter().any(|moving| moving.step == step) && self.report.fault.is_none() {
            let next = self.parts.board.next_event().unwrap_or(limit).min(limit);
            self.actual = self.parts.clock.wait(next).max(self.actual);
            self.poll()?;
            if self.actual >= limit && self.awaited.relays.0.iter().any(|moving| moving.step == step) {
                let late = self.actual - began;
                self.report.fault.get_or_insert(RigFault::Late { at: began, late, limit: self.limits.late });
            }
        }
        self.mark_pending_faults(|moving| moving.step == step);
        Ok(())
    }
}
