//! The steps that are due, and what they do to subject and board.

use super::Executor;
use crate::executor::operator::{AskError, Operator};
use crate::executor::rig_fault::RigFault;
use crate::executor::stepping::Pause;
use crate::generator::BoardOrder;
use crate::schedule::case_ending::NotRefused;
use crate::schedule::{Act, Due, EndReason, Expected};
use crate::subject::SubjectExt;
use drivers::{BoardExt, ChannelId};
use plans::steps::{CasePart, Question};
use signal::{Cause, SignalId, Time, Value};

impl Executor<'_> {
    /// The steps that are due.
    pub(super) fn steps(&mut self, now: Time) -> Result<(), RigFault> {
        // A wait whose limit is now, while a timer of the controller may still bring what it waits for.
        let mut waits = None;
        while let Some((at, step, due)) = self.parts.schedule.take(now) {
            match due {
                Due::Arm | Due::Begin if self.is_past_end(now) => {}
                Due::Arm => self.parts.schedule.arm(step, now),
                Due::Begin if !self.parts.schedule.begins(step, now) => {}
                Due::Begin => {
                    self.pause(Some(step))?;
                    self.begin_mark(step);
                    self.report_step(step, false);
                    self.parts.schedule.begin(step, now, &self.driven.values);
                }
                Due::Act(act) => self.act(step, act as usize)?,
                Due::Emit(n) => self.emit(step, n)?,
                Due::Done if self.awaits_edges(step) => {}
                Due::Done if self.emits_yet(step) || !self.parts.schedule.is_done(step) => {}
                Due::Done => {
                    self.await_relay(step)?;
                    let done = self.parts.schedule.steps()[step].done;
                    let at = self.awaited.emissions.end(step).unwrap_or_else(|| self.seen(self.now));
                    self.parts.recorder.mark(done, at);
                    self.report_step(step, true);
                    self.parts.schedule.finish(step, now);
                }
                // The step's own claim fails with what was waited for. The case goes on without the step.
                Due::Missed
                    if at == now && self.parts.subject.next_timer().is_some_and(|timer| timer <= now) =>
                {
                    waits = Some((at, step));
                    break;
                }
                Due::Missed => {
                    let missed = self.parts.schedule.miss(step, now);
                    // What the setup prepares is not there: nothing of the steps proper would mean anything.
                    if missed && self.parts.schedule.steps()[step].phase == CasePart::Setup {
                        self.parts.schedule.end_early(EndReason::Missed(step), now);
                    }
                }
                Due::Stop => self.parts.schedule.stop(step, now),
                Due::Main if self.report.fault.is_some() => {
                    self.parts.schedule.end_early(EndReason::RigFault, now)
                }
                Due::Main => {
                    if let Some(mark) = self.parts.wiring.main {
                        self.parts.recorder.mark(mark, self.seen(self.now));
                    }
                    self.parts.schedule.begin_main(now);
                }
            }
        }
        if let Some((at, step)) = waits {
            self.parts.schedule.wait_on(at, step);
        }
        self.over |= self.parts.schedule.is_over_without_end(now);
        Ok(())
    }

    /// Asks whoever goes through the case step by step, before this step or at the instant that was asked for.
    pub(super) fn pause(&mut self, step: Option<usize>) -> Result<(), RigFault> {
        let Some(stepping) = &mut self.stepping else { return Ok(()) };
        let pause = Pause {
            now: self.now,
            start: self.report.start.unwrap_or(self.now),
            step: step.map(|step| self.parts.schedule.steps()[step].id.as_str()),
            trace: self.parts.recorder.trace(),
        };
        if stepping.ask(&pause) { Ok(()) } else { Err(RigFault::Interrupted) }
    }

    /// A step drives a line from now on: whatever went on there is over.
    fn drive(&mut self, channel: ChannelId, value: Value, step: usize) -> Result<(), RigFault> {
        self.parts.schedule.take_over(channel, None);
        self.buffers.writes.clear();
        self.buffers.writes.push((channel, value));
        self.write(step)
    }

    /// The next act of a step's generator, all of its lines at once.
    fn emit(&mut self, step: usize, n: u64) -> Result<(), RigFault> {
        self.buffers.writes.clear();
        let reached = self.pacing.has_wires().then_some(self.actual);
        if reached.is_some() {
            self.note_late_edge(step);
        }
        match self.parts.schedule.emitted(step, n, reached, &mut self.buffers.writes) {
            Some(BoardOrder::Send(bus, frame)) => self.send(step, bus, &frame)?,
            Some(BoardOrder::Emit(channel, emission)) => self.emit_pulses(step, channel, &emission)?,
            None => {}
        }
        self.expect_edges();
        if self.buffers.writes.is_empty() { Ok(()) } else { self.write(step) }
    }

    /// Hands what a step drives to the board.
    fn write(&mut self, step: usize) -> Result<(), RigFault> {
        for write in 0..self.buffers.writes.len() {
            let (channel, value) = self.buffers.writes[write];
            let place = usize::from(channel.0);
            self.parts.wiring.writers[place] = Cause::Step(step as u16);
            self.driven.restore[place] = self.driven.values[place];
            self.driven.values[place] = value;
            self.stop_pulses(channel);
        }
        self.expect_writes();
        let at = self.board_time();
        let written = self.parts.board.write(at, &self.buffers.writes);
        written.map_err(|error| RigFault::Board { at, error })?;
        self.poll()
    }

    /// Notes what was not refused although the step expects it.
    fn answered(&mut self, done: bool, step: usize, expected: Expected, what: NotRefused) {
        let id = &self.parts.schedule.steps()[step].id;
        if !done || expected != Expected::Refused {
            return;
        }
        match self.report.not_refused.iter_mut().find(|(known, _)| known == id) {
            Some((_, last)) => *last = what,
            None => self.report.not_refused.push((id.clone(), what)),
        }
    }

    /// Asks a person. The modelled time stands still meanwhile, on the host's clock too.
    fn ask(&mut self, step: usize, question: &Question, signal: SignalId) -> Result<(), RigFault> {
        let id = self.parts.schedule.steps()[step].id.clone();
        let answer = match (self.parts.operator, self.parts.heartbeat) {
            (Some(operator), Some(_)) => self.ask_alive(operator, &id, question)?,
            (Some(operator), None) => operator.ask(&id, question, self.parts.interrupt),
            (None, _) => Err(AskError::Nobody),
        };
        // A real controller does not wait for the answer.
        if !self.pacing.has_wires() || self.parts.subject.is_model() {
            self.parts.clock.stood_still(self.actual);
        }
        let answer = match answer {
            Ok(answer) if answer < question.answers.len() => answer,
            Ok(_) => return Err(RigFault::Unanswered { step: id, error: AskError::Nobody }),
            Err(AskError::Interrupted) => return Err(RigFault::Interrupted),
            Err(error) => return Err(RigFault::Unanswered { step: id, error }),
        };
        let at = self.seen(self.now);
        self.record(signal, at, Value::Int(answer as i64), Cause::Step(step as u16));
        Ok(())
    }

    /// Asks, and goes on giving signs of life until the answer comes.
    fn ask_alive(
        &mut self,
        operator: &dyn Operator,
        step: &str,
        question: &Question,
    ) -> Result<Result<usize, AskError>, RigFault> {
        let interrupt = self.parts.interrupt;
        std::thread::scope(|scope| {
            let asked = scope.spawn(|| operator.ask(step, question, interrupt));
            while !asked.is_finished() {
                let silent = self.beat().inspect_err(|_| {
                    // The person may take long.
                    let _ = self.parts.board.safe(self.board_time());
                })?;
                let next = self.parts.clock.now().saturating_add(silent);
                self.parts.clock.wait_until(next);
            }
            Ok(asked.join().unwrap_or(Err(AskError::Nobody)))
        })
    }

    /// Sets a parameter of a plant of the board.
    fn set_plant(&mut self, plant: usize, parameter: usize, value: f64) -> Result<(), RigFault> {
        let at = self.board_time();
        let set = self.parts.board.set_parameter(at, plant, parameter, value);
        set.map_err(|error| RigFault::Board { at, error })?;
        self.poll()
    }

    fn act(&mut self, step: usize, place: usize) -> Result<(), RigFault> {
        let act = self.parts.schedule.steps()[step].acts[place].1.clone();
        let (now, at) = (self.now, self.board_time());
        match act {
            Act::Drive(channel, value) => self.drive(channel, value, step)?,
            Act::Restore(channel) => {
                let value = self.driven.restore[usize::from(channel.0)];
                self.drive(channel, value, step)?;
            }
            Act::Command(command, expected) => {
                let answer = self.parts.subject.command(now, &command, &mut self.buffers.effects);
                self.answered(answer.is_ok(), step, expected, NotRefused::Command);
                if let (Err(refusal), Expected::Obeyed) = (answer, expected) {
                    let id = self.parts.schedule.steps()[step].id.clone();
                    self.report.fault.get_or_insert(RigFault::Refused { step: id, refusal });
                }
            }
            Act::Power(on) => self.parts.subject.power(now, on, &mut self.buffers.effects),
            Act::Overload { task, cycle, times } => self.parts.subject.overload(task, cycle, times),
            Act::Disturb(disturbance) => {
                self.parts.subject.disturb(now, disturbance, &mut self.buffers.effects)
            }
            Act::Suspend { task, lasts } => self.parts.subject.suspend(task, now.saturating_add(lasts)),
            Act::SetPlant { plant, parameter, value, for_a_time } => {
                self.plant_settings.set((plant, parameter), step, value, for_a_time);
                self.set_plant(plant, parameter, value)?;
            }
            Act::RestorePlant { plant, parameter, initial } => {
                let value = self.plant_settings.restore((plant, parameter), step, initial);
                value.map_or(Ok(()), |value| self.set_plant(plant, parameter, value))?;
            }
            Act::Fault(fault) => {
                self.parts.board.inject(at, fault).map_err(|error| RigFault::Board { at, error })?;
                self.relay_asked(fault.channel);
                self.poll()?;
            }
            Act::Clear(channel) => {
                self.parts.board.clear_faults(at, channel).map_err(|error| RigFault::Board { at, error })?;
                self.relay_asked(channel);
                self.poll()?;
            }
            Act::Write(probe, value, expected) => {
                let written = self.parts.subject.write(
                    now,
                    &probe,
                    value,
                    Cause::Step(step as u16),
                    &mut self.buffers.effects,
                );
                self.answered(written.is_ok(), step, expected, NotRefused::Write);
                if let (Err(error), Expected::Obeyed) = (written, expected) {
                    let id = self.parts.schedule.steps()[step].id.clone();
                    self.report.fault.get_or_insert(RigFault::NotWritten { step: id, error });
                }
            }
            Act::Ask(question, signal) => self.ask(step, &question, signal)?,
            Act::File(act, expected) => {
                let done = self.parts.subject.file(now, &act, &mut self.buffers.effects);
                self.answered(done.is_ok(), step, expected, NotRefused::File);
                if let (Err(error), Expected::Obeyed) = (done, expected) {
                    let id = self.parts.schedule.steps()[step].id.clone();
                    self.report.fault.get_or_insert(RigFault::File { step: id, error });
                }
            }
        }
        self.apply()?;
        self.end_act(step, place)
    }
}
