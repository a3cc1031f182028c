//! The steps that are due, and what they do to subject and board.

use super::Executor;
use crate::schedule::{Act, Due, Expected};
use crate::trouble::Trouble;
use drivers::ChannelId;
use signal::{Cause, Time, Value};

impl Executor<'_> {
    /// The steps that are due.
    pub(super) fn steps(&mut self, now: Time) -> Result<(), Trouble> {
        while let Some((_, step, due)) = self.schedule.take(now) {
            match due {
                Due::Arm => self.schedule.arm(step, now),
                Due::Begin => {
                    let mark = self.schedule.steps()[step].mark;
                    self.recorder.mark(mark, self.seen(self.now));
                    self.schedule.begin(step, now);
                }
                Due::Act(act) => self.act(step, act as usize)?,
                Due::Edge(n, rising) => {
                    if let Some(work) = &self.schedule.steps()[step].train {
                        let channel = work.channel;
                        self.drive(channel, Value::Bool(rising), step)?;
                    }
                    self.schedule.emitted(step, n, rising);
                }
                Due::Done => {
                    let done = self.schedule.steps()[step].done;
                    self.recorder.mark(done, self.seen(self.now));
                    self.schedule.finish(step, now);
                }
                // The step's own claim fails with what was waited for. The case goes on without the step, unless
                // its end hangs on it.
                Due::Missed => {
                    let missed = self.schedule.miss(step);
                    self.over |= missed && self.schedule.is_exhausted();
                }
            }
        }
        Ok(())
    }

    fn drive(&mut self, channel: ChannelId, value: Value, step: usize) -> Result<(), Trouble> {
        self.wiring.writers[usize::from(channel.0)] = Cause::Step(step as u16);
        self.restore[usize::from(channel.0)] = self.driven[usize::from(channel.0)];
        self.driven[usize::from(channel.0)] = value;
        let at = self.board_time();
        let written = self.board.write(at, &[(channel, value)]);
        written.map_err(|error| Trouble::Board { at, error })?;
        self.poll()
    }

    /// Notes what was not refused although the step expects it.
    fn answered(&mut self, done: bool, step: usize, expected: Expected, what: &str) {
        if done && expected == Expected::Refused {
            let note = format!("refused:{}", self.schedule.steps()[step].id);
            self.recorder.trace_mut().set_note(&note, what.into());
        }
    }

    fn act(&mut self, step: usize, place: usize) -> Result<(), Trouble> {
        let act = self.schedule.steps()[step].acts[place].1.clone();
        let (now, at) = (self.now, self.board_time());
        match act {
            Act::Drive(channel, value) => self.drive(channel, value, step)?,
            Act::Restore(channel) => {
                let value = self.restore[usize::from(channel.0)];
                self.drive(channel, value, step)?;
            }
            Act::Command(command, expected) => {
                let answer = self.subject.command(now, &command, &mut self.effects);
                let id = || self.schedule.steps()[step].id.clone();
                match (answer, expected) {
                    (Err(refusal), Expected::Obeyed) => {
                        self.ran.trouble.get_or_insert(Trouble::Refused { step: id(), refusal });
                    }
                    (Ok(()), Expected::Refused) => {
                        let note = format!("refused:{}", id());
                        self.recorder.trace_mut().set_note(&note, "the command was obeyed".into());
                    }
                    _ => {}
                }
            }
            Act::Power(on) => self.subject.power(now, on, &mut self.effects),
            Act::Overload { task, cycle, times } => self.subject.overload(task, cycle, times),
            Act::Disturb(disturbance) => self.subject.disturb(now, disturbance, &mut self.effects),
            Act::Suspend { task, lasts } => self.subject.suspend(task, now.saturating_add(lasts)),
            Act::Fault(fault) => {
                self.board.inject(at, fault).map_err(|error| Trouble::Board { at, error })?;
                self.poll()?;
            }
            Act::Clear(channel) => {
                self.board.clear(at, channel).map_err(|error| Trouble::Board { at, error })?;
                self.poll()?;
            }
            Act::Write(probe, value, expected) => {
                let written =
                    self.subject.write(now, &probe, value, Cause::Step(step as u16), &mut self.effects);
                self.answered(written.is_ok(), step, expected, "the value was written");
                if let (Err(error), Expected::Obeyed) = (written, expected) {
                    let id = self.schedule.steps()[step].id.clone();
                    self.ran.trouble.get_or_insert(Trouble::NotWritten { step: id, error });
                }
            }
            Act::File(act, expected) => {
                let done = self.subject.file(now, &act, &mut self.effects);
                self.answered(done.is_ok(), step, expected, "the file was reached");
                if let (Err(error), Expected::Obeyed) = (done, expected) {
                    let id = self.schedule.steps()[step].id.clone();
                    self.ran.trouble.get_or_insert(Trouble::File { step: id, error });
                }
            }
        }
        self.apply()
    }
}
