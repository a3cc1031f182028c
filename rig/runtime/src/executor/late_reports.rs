//! What becomes known only after a case: changes that came before its end and that the board had not reported by then.
//!
//! They are asked for while the outputs still stand as they did, so that nothing of it is what making them safe brought about.

use super::pacing::Pacing;
use super::real_lines::LONGEST_WAIT;
use super::{Executor, RigFault};
use crate::scan_port::ExecutorRole;
use drivers::{BoardEvent, Channel, Origin, TimestampSource};
use signal::{Cause, Span, Time, Value, When};

/// How long an edge that the kernel stamped takes at most until the board reports it.
const DELIVERY: Span = Span::from_millis(10);

impl Executor<'_> {
    /// The case, or its teardown, is over by the plan: waits until it is over however late the rig marked what a window counts from.
    /// Such a window ends as much later, and has to be seen whole.
    pub(super) fn see_all_windows(&mut self) {
        let is_early = self.report.fault.is_some() || self.parts.schedule.ended().is_some();
        if self.parts.clock.is_exact() || is_early {
            return;
        }
        let late = self.parts.recorder.widest_mark().min(self.limits.late);
        self.actual = self.parts.clock.wait_until(self.now.saturating_add(late)).max(self.actual);
    }

    /// Waits until all that came before the end is known, and records it. A case that ended early, or by a fault of the rig, is
    /// made safe at once: its verdict does not depend on more.
    pub(super) fn take_late_reports(&mut self) {
        let no_case = self.live.as_ref().is_some_and(|live| live.role() == ExecutorRole::Rig);
        if no_case || self.report.fault.is_some() || self.parts.schedule.ended().is_some() {
            return;
        }
        let closed = self.board_time();
        let known = self.known_by(closed);
        if known <= closed {
            return;
        }
        let mut events = std::mem::take(&mut self.buffers.polled);
        let mut reached = closed;
        while reached < known && self.report.fault.is_none() {
            reached = match self.reach_late(known) {
                Ok(reached) => reached,
                Err(fault) => {
                    self.report.fault = Some(fault);
                    break;
                }
            };
            events.clear();
            let polled = self.parts.board.poll(reached, &mut events);
            events.iter().for_each(|event| self.record_late(event, closed));
            if let Err(error) = polled {
                self.report.fault.get_or_insert(RigFault::Board { at: reached, error });
            }
        }
        self.board_reached = reached;
        self.buffers.polled = events;
    }

    /// By when every change up to `closed` will have been reported.
    fn known_by(&self, closed: Time) -> Time {
        let held = self.parts.board.reported_by(closed);
        if self.pacing == Pacing::EventDriven {
            return held;
        }
        let channels = self.parts.board.channels().iter().zip(&self.parts.wiring.channels);
        let recorded = channels.filter(|(_, signals)| !signals.is_empty()).map(|(channel, _)| channel);
        let delayed = self.parts.wiring.delays.iter().map(|(earliest, _)| -*earliest).max();
        let slowest = recorded.filter(|channel| channel.senses).map(reported_within).max();
        let slowest = slowest.map(|slowest| slowest + delayed.unwrap_or_default());
        slowest.map_or(held, |slowest| held.max(closed.saturating_add(slowest)))
    }

    /// Time passes on the way to `known`; on wires as far as the guard lets it at a stretch.
    fn reach_late(&mut self, known: Time) -> Result<Time, RigFault> {
        if self.pacing == Pacing::EventDriven {
            return Ok(known);
        }
        let silent = if self.beating { self.beat()? } else { LONGEST_WAIT };
        let due = known.min(self.actual.saturating_add(silent));
        self.actual = self.parts.clock.wait(due).max(self.actual);
        Ok(self.actual)
    }

    /// Records what came before the end, or may have.
    fn record_late(&mut self, event: &BoardEvent, closed: Time) {
        let channel = event.channel();
        let place = usize::from(channel.0);
        let (at, value, cause, origin) = match *event {
            BoardEvent::Changed { at, value, origin, .. }
                if at.earliest.saturating_add(self.parts.wiring.delay_of(channel).0) < closed =>
            {
                let cause = match origin {
                    Origin::Write => self.parts.wiring.writers[place],
                    Origin::Gap(gap) => Cause::Gap(gap),
                    _ => Cause::Board,
                };
                (at, value, cause, origin)
            }
            BoardEvent::Lost { at, .. } if at < closed => {
                (When::exactly(at), Value::Unknown, Cause::Board, Origin::Outside)
            }
            BoardEvent::Dropped { at, count, .. } => return self.report_missed_edges(at, channel, count),
            _ => return,
        };
        for index in 0..self.parts.wiring.channels[place].len() {
            let signal = self.parts.wiring.channels[place][index];
            self.parts.recorder.record(signal, self.seen_by_board(at, channel, origin), value, cause);
        }
    }
}

/// How long a change of a channel on wires takes at most until it is reported.
fn reported_within(channel: &Channel) -> Span {
    match channel.timestamp {
        TimestampSource::Virtual => Span::ZERO,
        TimestampSource::Sampled { period } => period + DELIVERY,
        TimestampSource::Kernel | TimestampSource::Device => channel.resolution + DELIVERY,
    }
}
