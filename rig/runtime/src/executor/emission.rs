//! Pulses that the board makes by itself, for steps and for functions of the model. A device takes its time to begin: the end
//! of such a step is its last edge, as far as the board reports its edges.

use super::Executor;
use crate::executor::rig_fault::RigFault;
use crate::wiring::Wiring;
use controller::Terminal;
use drivers::{BoardExt, Channel, ChannelId, Emission, Origin};
use plans::steps::CasePart;
use profile::IoChannel;
use signal::{Cause, Span, Time, Value, When};

/// The embedded outputs of the subject at which a channel makes waves without end.
pub(super) fn offloaded_outputs(wiring: &Wiring, channels: &[Channel]) -> Vec<IoChannel> {
    let makes = |channel: ChannelId| {
        let known = channels.get(usize::from(channel.0));
        known.and_then(|known| known.emits).is_some_and(|emits| emits.endless)
    };
    let outputs = wiring.outputs().filter(|(terminal, channel)| terminal.module == 0 && makes(*channel));
    outputs.map(|(terminal, _)| terminal.channel).collect()
}

/// Pulses of a step that the board reports one by one.
#[derive(Clone, Copy, Debug)]
struct ActiveEmission {
    step: usize,
    channel: ChannelId,
    /// Edges that were not reported yet.
    left: usize,
    /// When the last one was.
    last: When,
    /// The step is over but for them; until when they have to be reported.
    until: Option<Time>,
}

/// The steps whose pulses the board makes and reports: of each channel at most one.
#[derive(Debug)]
pub(super) struct Emissions(Vec<ActiveEmission>);

impl Emissions {
    /// For these channels.
    pub(super) fn new(channels: &[Channel]) -> Emissions {
        Emissions(Vec::with_capacity(channels.iter().filter(|channel| channel.emits.is_some()).count()))
    }

    /// Something else is driven on the channel: what is left of its pulses never comes. Hands back a step that is over
    /// but for these.
    #[inline]
    pub(super) fn stop(&mut self, channel: ChannelId) -> Option<usize> {
        let place = self.0.iter().position(|emitting| emitting.channel == channel)?;
        let ActiveEmission { step, until, .. } = self.0.swap_remove(place);
        until.map(|_| step)
    }

    /// A step is done: when its last edge was, where the board reported.
    #[inline]
    pub(super) fn end(&mut self, step: usize) -> Option<When> {
        let place = self.0.iter().position(|emitting| emitting.step == step)?;
        Some(self.0.swap_remove(place).last)
    }
}

impl Executor<'_> {
    /// A step drives a channel: whatever the board made there is over.
    #[inline]
    pub(super) fn stop_pulses(&mut self, channel: ChannelId) {
        if let Some(step) = self.awaited.emissions.stop(channel) {
            self.parts.schedule.done_at(step, self.now);
        }
    }

    /// Has the board emit pulses for a step.
    pub(super) fn emit_pulses(
        &mut self,
        step: usize,
        channel: ChannelId,
        emission: &Emission,
    ) -> Result<(), RigFault> {
        let place = usize::from(channel.0);
        self.parts.wiring.writers[place] = Cause::Step(step as u16);
        self.driven.restore[place] = self.driven.values[place];
        self.driven.values[place] = Value::Bool(false);
        self.stop_pulses(channel);
        let at = self.board_time();
        self.parts.board.emit(at, channel, emission).map_err(|error| RigFault::Board { at, error })?;
        let senses = self.parts.board.channels().get(place).is_some_and(|channel| channel.senses);
        if let (Emission::Pulses(edges), true) = (emission, senses) {
            let (left, last, until) = (edges.len(), When::exactly(at), None);
            self.awaited.emissions.0.push(ActiveEmission { step, channel, left, last, until });
        }
        self.poll()
    }

    /// Has the board make the square wave of an output.
    pub(super) fn emit_wave(
        &mut self,
        at: Time,
        output: usize,
        emission: &Emission,
        cause: Cause,
    ) -> Result<(), RigFault> {
        let Some(channel) = self.parts.wiring.channel_of(Terminal::output(output)) else { return Ok(()) };
        self.parts.wiring.writers[usize::from(channel.0)] = cause;
        self.lines.wrote(channel, at, self.actual, Span::ZERO);
        let at = self.board_time();
        self.parts.board.emit(at, channel, emission).map_err(|error| RigFault::Board { at, error })
    }

    /// The program has the period of such a wave begin again, which no device does.
    pub(super) fn cannot_restart_period(&mut self, at: Time, output: usize) {
        if let Some(channel) = self.parts.wiring.channel_of(Terminal::output(output)) {
            self.report.fault.get_or_insert(RigFault::PeriodNotRestarted { at, channel });
        }
    }

    /// A line moved: one of the pulses that the board makes may be reported by that.
    #[inline]
    pub(super) fn see_pulse(&mut self, channel: ChannelId, at: When, value: Value, origin: Origin) {
        if self.awaited.emissions.0.is_empty() || origin != Origin::Write {
            return;
        }
        let reported = |emitting: &&mut ActiveEmission| {
            // The first edge of a pulse rises: what was written before may be reported only now.
            let rises = emitting.left.is_multiple_of(2);
            emitting.channel == channel && emitting.left > 0 && value == Value::Bool(rises)
        };
        let Some(emitting) = self.awaited.emissions.0.iter_mut().find(reported) else { return };
        emitting.left -= 1;
        if emitting.left > 0 {
            return;
        }
        let (step, waited) = (emitting.step, emitting.until.is_some());
        let at = self.seen_by_board(at, channel, origin);
        for emitting in self.awaited.emissions.0.iter_mut().filter(|emitting| emitting.step == step) {
            emitting.last = at;
        }
        if waited {
            self.parts.schedule.done_at(step, self.now);
        }
    }

    /// Whether edges of a step that should be over were not reported yet. They have as long as the rig may be late.
    pub(super) fn emits_yet(&mut self, step: usize) -> bool {
        let of = |emitting: &&mut ActiveEmission| emitting.step == step && emitting.left > 0;
        let Some(emitting) = self.awaited.emissions.0.iter_mut().find(of) else { return false };
        let (now, limit) = (self.now, self.limits.late);
        match emitting.until {
            None => {
                let until = now.saturating_add(limit);
                emitting.until = Some(until);
                self.parts.schedule.done_at(step, until);
                true
            }
            Some(until) if now < until => true,
            Some(_) => {
                let late = self.actual - now + limit;
                // What was not reported by now is not waited for any longer.
                (emitting.left, emitting.last) = (0, When::within(emitting.last.earliest, self.actual));
                self.report.fault.get_or_insert(RigFault::Late { at: now, late, limit });
                false
            }
        }
    }

    /// Whether the case goes on although its end has come: pulses under way are reported when they are over, and claims ask
    /// for all of them. Not where something ended it early.
    #[inline]
    pub(super) fn holds_end(&self) -> bool {
        self.awaited.emissions.0.iter().any(|emitting| emitting.left > 0)
            && self.parts.schedule.ended().is_none()
    }

    /// Whether the end of the case has come, and only waits for pulses: no step comes after it.
    pub(super) fn is_past_end(&self, now: Time) -> bool {
        self.parts.schedule.phase() == CasePart::Main
            && self.parts.schedule.end().is_some_and(|end| now > end)
    }

    /// The case is over: waves without an end of their own end, as they would if the rig drove them.
    pub(super) fn end_waves(&mut self) {
        self.buffers.writes.clear();
        while let Some(write) = self.parts.schedule.end_emission(self.now) {
            self.buffers.writes.push(write);
        }
        if self.buffers.writes.is_empty() {
            return;
        }
        let at = self.board_time();
        if let Err(error) = self.parts.board.write(at, &self.buffers.writes) {
            self.report.fault.get_or_insert(RigFault::Board { at, error });
        }
    }
}
