//! What the board saw: into the trace, to the subject's inputs, and to whoever looks.

use super::Executor;
use super::real_lines::InputChange;
use crate::executor::rig_fault::RigFault;
use crate::wiring::WiredInput;
use drivers::{BoardEvent, ChannelKind, LossReason, Origin};
use signal::{Cause, Value, When};

impl Executor<'_> {
    /// What the board saw up to now goes to the trace and to the subject's inputs.
    pub(super) fn poll(&mut self) -> Result<(), RigFault> {
        let mut events = std::mem::take(&mut self.buffers.polled);
        events.clear();
        let now = self.board_time();
        let polled = self.parts.board.poll(now, &mut events);
        self.mark_faults_seen();
        for event in &events {
            self.see(event);
        }
        self.buffers.polled = events;
        polled.map_err(|error| RigFault::Board { at: now, error })?;
        self.poll_buses(now)?;
        // A line may have shown the subject's state.
        self.apply()
    }

    fn see(&mut self, event: &BoardEvent) {
        let channel = event.channel();
        let place = usize::from(channel.0);
        let mut lost = None;
        let (at, value, cause, origin) = match *event {
            BoardEvent::Changed { at, value, origin, .. } => {
                let cause = match origin {
                    Origin::Write => self.parts.wiring.writers[place],
                    Origin::Gap(gap) => Cause::Gap(gap),
                    _ => Cause::Board,
                };
                self.awaited.writes.seen(channel);
                self.awaited.edges.seen(channel);
                self.lines.reached(channel, at.latest, origin);
                self.see_pulse(channel, at, value, origin);
                (at, value, cause, origin)
            }
            BoardEvent::Lost { at, reason, .. } => {
                if reason != LossReason::Injected {
                    self.channel_lost(at, channel, reason);
                }
                lost = Some(reason);
                (When::exactly(at), Value::Unknown, Cause::Board, Origin::Outside)
            }
            BoardEvent::Returned { at, .. } => {
                if let Some(live) = &mut self.live {
                    live.regained(channel);
                }
                return self.channel_returned(at, channel);
            }
            BoardEvent::Dropped { at, count, channel } => {
                return self.report_missed_edges(at, channel, count);
            }
        };
        if self.live.is_some() {
            self.report_channel(channel, self.seen_by_board(at, channel, origin), value, lost);
        }
        for index in 0..self.parts.wiring.channels[place].len() {
            let signal = self.parts.wiring.channels[place][index];
            self.record(signal, self.seen_by_board(at, channel, origin), value, cause);
        }
        if !self.parts.wiring.inputs[place].is_empty() {
            let of_levels = match value {
                Value::Bool(_) => Some(InputChange::Value(value)),
                Value::Int(count) => Some(InputChange::Steps(self.counted_on(channel, count))),
                // Between the two levels of a voltage an input keeps the one that it had.
                Value::Real(volts) | Value::Measured(volts, _) => {
                    profile::input_level(volts).map(|high| InputChange::Value(Value::Bool(high)))
                }
                _ if self.parts.board.channels()[place].kind == ChannelKind::Count => None,
                _ => Some(InputChange::Value(Value::HighZ)),
            };
            for index in 0..self.parts.wiring.inputs[place].len() {
                let WiredInput { terminal, analog } = self.parts.wiring.inputs[place][index];
                let what = if analog { Some(InputChange::Value(value)) } else { of_levels };
                if let Some(what) = what {
                    self.input(channel, at, terminal, what);
                }
            }
        }
    }
}
