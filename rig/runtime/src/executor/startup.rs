//! What comes before a case: the subject gets its program and its supply, and comes into the state that the case begins
//! in.

use super::Executor;
use crate::executor::rig_fault::RigFault;
use crate::subject::SubjectExt;
use controller::{Command, State};
use signal::{Cause, Span, Time, Value, When};

impl Executor<'_> {
    /// Brings the subject into the state in which the case begins.
    pub(super) fn prelude(&mut self) -> Result<(), RigFault> {
        self.parts.clock.begin();
        self.parts.board.start(Time::ZERO).map_err(|error| self.not_started(error))?;
        if self.pacing.has_wires() {
            // Devices take the time that they take.
            self.actual = self.parts.clock.now();
            self.now = self.actual;
        }
        let power_on = self.now;
        self.show_counts();
        self.show_initial()?;
        let initial = self.limits.initial;
        if initial != State::Off {
            self.parts.subject.power(power_on, true, &mut self.buffers.effects);
            self.apply()?;
        }
        if self.parts.subject.is_model() {
            // A controller that loads its program takes the host's time, and none of its own.
            self.parts.clock.stood_still(self.actual);
        }
        self.load()?;
        if let Some(heartbeat) = self.parts.heartbeat {
            heartbeat.begin().map_err(|error| self.unguarded(&error))?;
            self.beating = true;
        }
        let limit = self.loaded + self.parts.subject.startup_limit();
        let mut commanded = false;
        loop {
            let state = self.parts.subject.state();
            if state == initial {
                break;
            }
            let settled = matches!(state, State::Stopped | State::Running | State::Empty);
            if settled && !commanded {
                commanded = true;
                let command = if initial == State::Running { Command::Run } else { Command::Stop };
                let at = self.now;
                self.parts
                    .subject
                    .command(at, &command, &mut self.buffers.effects)
                    .map_err(|refusal| RigFault::Startup { state, refusal: Some(refusal) })?;
                self.apply()?;
                continue;
            }
            if self.now > limit || !self.turn(limit + Span::from_secs(1))? {
                return Err(RigFault::Startup { state, refusal: None });
            }
        }
        self.report.start = Some(self.now);
        let mut at = self.seen(self.now);
        if let Some((earliest, state)) = self.parts.subject.begin() {
            // However uncertain the start is, the subject has this state by then.
            at.earliest = earliest.min(at.earliest);
            if let Some(signal) = self.parts.wiring.state {
                let before = When::exactly(at.earliest.saturating_add(Span::from_nanos(-1)));
                self.parts.recorder.record(signal, before, state, Cause::Controller);
            }
        }
        if let Some(mark) = self.parts.wiring.start {
            self.parts.recorder.mark(mark, at);
        }
        self.parts.schedule.start(self.now);
        self.arm();
        Ok(())
    }

    /// The subject gets its program: on the host's clock time passes meanwhile, and it is not the case's.
    fn load(&mut self) -> Result<(), RigFault> {
        self.parts.subject.load(self.parts.interrupt).map_err(RigFault::Hook)?;
        self.now = self.now.max(self.parts.clock.now());
        self.actual = self.actual.max(self.now);
        self.loaded = self.now;
        self.poll()?;
        self.parts.subject.loaded(self.now, &mut self.buffers.effects);
        self.apply()
    }

    /// What every observed probe shows before anything happens.
    fn show_initial(&mut self) -> Result<(), RigFault> {
        if let Some(signal) = self.parts.wiring.state {
            let state = Value::Int(self.parts.subject.state().number());
            self.parts.recorder.record(signal, When::exactly(self.now), state, Cause::Controller);
        }
        self.buffers.writes.clear();
        for (terminal, channel) in self.parts.wiring.outputs() {
            self.buffers.writes.push((channel, self.parts.subject.output(terminal)));
        }
        for (channel, _) in &self.buffers.writes {
            self.parts.wiring.writers[usize::from(channel.0)] = Cause::Controller;
        }
        let at = self.board_time();
        let written = self.parts.board.write(at, &self.buffers.writes);
        written.map_err(|error| RigFault::Board { at, error })?;
        self.poll()
    }
}
