//! What does not come because something that a step waits for did not.

use super::{Due, Schedule, StepAnchor};
use plans::plan::{AFTER_LAST, StepRepeat};
use plans::steps::CasePart;
use signal::Time;
use std::cmp::Reverse;

/// Steps that do not come, and those that are not done though they may come.
#[derive(Debug)]
pub(super) struct NeverComing {
    /// It does not come.
    comes: Vec<bool>,
    /// It is never done: it does not come, a step of its group is never done, or it is repeated up to an instant that does not come.
    done: Vec<bool>,
    /// A step was missed.
    any: bool,
}

impl NeverComing {
    pub(super) fn new(steps: usize) -> NeverComing {
        NeverComing { comes: vec![false; steps], done: vec![false; steps], any: false }
    }

    /// Whether what depends on this instant never comes.
    fn has(&self, anchor: StepAnchor, schedule: &Schedule) -> bool {
        match anchor {
            StepAnchor::Begin(on) | StepAnchor::Time(on, _) | StepAnchor::Pulse(on, _) => self.comes[on],
            StepAnchor::Done(on) => self.done[on],
            StepAnchor::Main => (self.done.iter().zip(&schedule.steps))
                .any(|(never, step)| *never && step.phase == CasePart::Setup),
            StepAnchor::Start | StepAnchor::Teardown | StepAnchor::Never => false,
        }
    }

    /// A step does not come, and with it all that depends on it, by way of others too.
    fn add(&mut self, step: usize, schedule: &Schedule) {
        self.any = true;
        self.comes[step] = true;
        let mut more = true;
        while std::mem::take(&mut more) {
            for place in 0..self.comes.len() {
                let comes = self.comes[place] || self.has(schedule.roots[place], schedule);
                let endless = || {
                    let untils = schedule.progress.untils.iter();
                    untils.filter(|(_, step, _)| *step == place).any(|(root, ..)| self.has(*root, schedule))
                };
                let part = || {
                    (0..self.done.len())
                        .any(|one| self.done[one] && schedule.steps[one].parent == Some(place))
                };
                let done = self.done[place] || comes || endless() || part();
                more |= (comes, done) != (self.comes[place], self.done[place]);
                (self.comes[place], self.done[place]) = (comes, done);
            }
        }
    }
}

impl Schedule {
    /// A step with those that come only after it, by way of others too; after one of the setup all of main.
    pub fn with_those_after(&self, step: usize) -> Vec<usize> {
        let mut never = NeverComing::new(self.steps.len());
        never.add(step, self);
        (0..self.steps.len()).filter(|place| never.comes[*place]).collect()
    }

    /// The step was missed.
    pub(super) fn never_comes(&mut self, step: usize) {
        let mut never = std::mem::replace(&mut self.progress.never, NeverComing::new(0));
        never.add(step, self);
        self.progress.never = never;
    }

    /// Gives a case an end that counts from a step which does not come, once nothing is left that could come: one second after
    /// the last step that was done, as where a plan does not say its end, if that is still to come. TRUE where the case is over now.
    pub fn is_over_without_end(&mut self, now: Time) -> bool {
        let waits =
            self.end.is_some() || self.progress.ended.is_some() || self.progress.phase != CasePart::Main;
        if waits || !self.progress.never.any || !self.is_exhausted() {
            return false;
        }
        let end = self.progress.last_done.map_or(now, |done| done.saturating_add(AFTER_LAST));
        self.end = Some(end.max(now));
        end <= now
    }

    /// Whether nothing of the steps is left that could come, or be done, apart from what goes on without an end.
    fn is_exhausted(&self) -> bool {
        self.is_queue_exhausted()
            && !self.armed.contains(&true)
            && (0..self.steps.len())
                .all(|step| !self.progress.working[step] || self.progress.never.done[step])
    }

    /// Whether nothing of the teardown is left that could come.
    pub fn is_torn_down(&self) -> bool {
        self.is_queue_exhausted()
    }

    /// Whether all that is queued is over already or goes on without an end.
    fn is_queue_exhausted(&self) -> bool {
        self.queue.iter().all(|Reverse((_, _, step, due))| match due {
            // What a step waited for is over when it came, whatever is still queued of it.
            Due::Missed => !self.armed[*step],
            Due::Emit(_) if self.progress.done[*step] => true,
            _ => self.is_repeated_endlessly(*step),
        })
    }

    /// Whether a step that is repeated up to an instant has begun, and the instant does not come.
    fn is_repeated_endlessly(&self, step: usize) -> bool {
        self.progress.never.done[step]
            && self.progress.first[step].is_some()
            && self.progress.until[step].is_none()
            && matches!(self.steps[step].repeat, Some(StepRepeat::Every { until: Some(_), .. }))
    }
}
