//! What the board saw: into the trace, to the subject's inputs, and to whoever looks.

use super::Executor;
use super::real_lines::{Arrival, InputChange};
use crate::executor::rig_fault::RigFault;
use crate::wiring::WiredInput;
use controller::{Effect, Effects, Terminal};
use drivers::{BoardEvent, ChannelKind, LossReason, Origin};
use signal::{Cause, SignalGap, Span, Time, Value, When};

impl Executor<'_> {
    /// What the board saw up to now goes to the trace and to the subject's inputs.
    pub(super) fn poll(&mut self) -> Result<(), RigFault> {
        let mut events = std::mem::take(&mut self.buffers.polled);
        events.clear();
        let now = self.board_time();
        let polled = self.parts.board.poll(now, &mut events);
        self.mark_faults_seen();
        self.see_polled_ahead();
        for event in &events {
            self.see(event);
            self.lead_to_inputs(event, Arrival::AtOnce);
        }
        self.buffers.polled = events;
        polled.map_err(|error| RigFault::Board { at: now, error })?;
        self.poll_buses(now)?;
        // A line may have shown the subject's state.
        self.apply()
    }

    /// An output may have left its level in a way that the model does not have, `left` before `at`, and come back `back` before
    /// `at` or later, or not at all where another level follows at `at`. Only the trace has it: what the rig does goes by the
    /// model.
    pub(super) fn record_unsettled(&mut self, at: Time, terminal: Terminal, left: Span, back: Option<Span>) {
        let Some(channel) = self.parts.wiring.channel_of(terminal) else { return };
        let place = usize::from(channel.0);
        let (left, back) = (at.saturating_add(-left), back.map(|back| at.saturating_add(-back)));
        for signal in &self.parts.wiring.channels[place] {
            let before = self.parts.recorder.trace().last(*signal).map(|event| event.value);
            let Some(value) = before.filter(|value| *value != Value::Unknown) else { continue };
            let cause = Cause::Gap(SignalGap::Delay);
            self.parts.recorder.record(*signal, When::exactly(left), Value::Unknown, cause);
            if let Some(back) = back {
                let cause = self.parts.wiring.writers[place];
                self.parts.recorder.record(*signal, When::within(back, at), value, cause);
            }
        }
    }

    /// At the end of the case: edges that are still to come in the model may be there already.
    pub(super) fn record_unsettled_at_end(&mut self) {
        let mut effects = Effects::default();
        self.parts.subject.report_unsettled(self.now, &mut effects);
        for effect in effects.list {
            if let Effect::Unsettled { at, terminal, left, back } = effect {
                self.record_unsettled(at, terminal, left, back);
            }
        }
    }

    /// What the board reports goes to the trace, to what waits for it and to whoever looks.
    pub(super) fn see(&mut self, event: &BoardEvent) {
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
    }

    /// What the board reports goes to the subject's inputs on that channel.
    pub(super) fn lead_to_inputs(&mut self, event: &BoardEvent, arrival: Arrival) {
        let channel = event.channel();
        let place = usize::from(channel.0);
        let (at, value) = match *event {
            BoardEvent::Changed { at, value, .. } => (at, value),
            BoardEvent::Lost { at, .. } => (When::exactly(at), Value::Unknown),
            BoardEvent::Returned { .. } | BoardEvent::Dropped { .. } => return,
        };
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
                let WiredInput { terminal, analog, sensor } = self.parts.wiring.inputs[place][index];
                let what = match (sensor, value.as_real()) {
                    (Some(curve), Some(shown)) => {
                        Some(InputChange::Value(Value::Real(curve.temperature(shown))))
                    }
                    _ if analog => Some(InputChange::Value(value)),
                    _ => of_levels,
                };
                if let Some(what) = what {
                    self.input(channel, at, terminal, what, arrival);
                }
            }
        }
    }
}
