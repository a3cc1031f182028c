//! How a case comes through its parts, and steps that come more than once.
//!
//! Setup, main, teardown: main waits until every step of the setup is done; the teardown waits for the end, however that
//! came about. Steps of a group are steps like others; the one that runs the group is done when all of them are.

use super::never::NeverComing;
use super::{Due, PlannedStep, Schedule, StepAnchor};
use crate::generator::StimulusGenerator;
use crate::schedule::case_ending::EarlyEnd;
use drivers::ChannelId;
use plans::plan::StepRepeat;
use plans::steps::CasePart;
use signal::{Span, Time, Value};
use std::collections::BTreeMap;

/// Why a case ends before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndReason {
    /// What a step of the setup waits for did not come.
    Missed(usize),
    /// The rig has trouble.
    RigFault,
    /// A claim is lost, and nobody wants to know more.
    Claim,
    /// An alarm was raised that ends the case.
    Alarm,
    /// A device was lost.
    Lost,
}

/// Where the case is, and where its steps are.
#[derive(Debug)]
pub(super) struct ScheduleProgress {
    pub(super) phase: CasePart,
    pub(super) ended: Option<EndReason>,
    /// When each step began first.
    pub(super) first: Vec<Option<Time>>,
    /// How many times each came.
    times: Vec<u64>,
    /// When the last step was done that is.
    pub(super) last_done: Option<Time>,
    /// It has begun, or is about to, and is not done.
    pub(super) working: Vec<bool>,
    /// It comes no more.
    stopped: Vec<bool>,
    /// From when on it comes no more, where that is known.
    pub(super) until: Vec<Option<Time>>,
    /// It is done, with every time that it comes.
    pub(super) done: Vec<bool>,
    /// The steps of its group that are not done.
    open: Vec<usize>,
    /// The steps of the setup that are not done.
    setup: usize,
    /// What steps of main would do if main had begun.
    held: Vec<(usize, Due)>,
    /// What the steps depend on that come up to an instant, with the distance from it.
    pub(super) untils: Vec<(StepAnchor, usize, Span)>,
    /// What was missed, with what depends on it.
    pub(super) never: NeverComing,
}

impl ScheduleProgress {
    pub(super) fn new(steps: &[PlannedStep], places: &BTreeMap<&str, usize>) -> ScheduleProgress {
        let count = steps.len();
        let mut open = vec![0; count];
        for parent in steps.iter().filter_map(|step| step.parent) {
            open[parent] += 1;
        }
        let untils = steps.iter().enumerate().filter_map(|(step, planned)| match &planned.repeat {
            Some(StepRepeat::Every { until: Some(until), .. }) => {
                Some((StepAnchor::of(&until.base, places), step, until.offset))
            }
            _ => None,
        });
        ScheduleProgress {
            phase: CasePart::Setup,
            ended: None,
            first: vec![None; count],
            times: vec![0; count],
            last_done: None,
            working: vec![false; count],
            stopped: vec![false; count],
            until: vec![None; count],
            done: vec![false; count],
            setup: steps.iter().filter(|step| step.phase == CasePart::Setup).count(),
            held: Vec::with_capacity(count),
            untils: untils.collect(),
            never: NeverComing::new(count),
            open,
        }
    }
}

impl Schedule {
    /// The part of the case that is under way.
    pub fn phase(&self) -> CasePart {
        self.progress.phase
    }

    /// Why the case ends early, if it does.
    pub fn ended(&self) -> Option<EndReason> {
        self.progress.ended
    }

    /// The same for the trace and the record.
    pub fn early_end(&self) -> Option<EarlyEnd> {
        Some(match self.ended()? {
            EndReason::Missed(step) => EarlyEnd::SetupStep(self.steps[step].id.clone()),
            EndReason::RigFault => EarlyEnd::RigFault,
            EndReason::Claim => EarlyEnd::Claim,
            EndReason::Alarm => EarlyEnd::Alarm,
            EndReason::Lost => EarlyEnd::DeviceLost,
        })
    }

    /// The case ends now, whatever of it is left: no further step of it comes, and the teardown is next. Where it has
    /// ended already this says nothing new.
    pub fn end_early(&mut self, reason: EndReason, now: Time) {
        if self.progress.phase == CasePart::Teardown || self.progress.ended.is_some() {
            return;
        }
        self.progress.ended = Some(reason);
        self.end = Some(now);
        self.clear();
    }

    /// The case is over and its teardown begins. FALSE where it has none.
    pub fn begin_teardown(&mut self, now: Time) -> bool {
        self.clear();
        self.progress.phase = CasePart::Teardown;
        self.anchor_reached(StepAnchor::Teardown, now);
        self.steps.iter().any(|step| step.phase == CasePart::Teardown)
    }

    /// The setup is done and main begins.
    pub fn begin_main(&mut self, now: Time) {
        self.progress.phase = CasePart::Main;
        self.end = self.end.map(|end| end.max(now));
        for place in 0..self.progress.held.len() {
            let (step, due) = self.progress.held[place];
            self.put(now, step, due);
        }
        self.progress.held.clear();
        self.anchor_reached(StepAnchor::Main, now);
    }

    /// Nothing that was to come comes any more.
    fn clear(&mut self) {
        self.queue.clear();
        self.drivers.fill(None);
        self.armed.fill(false);
        self.progress.held.clear();
    }

    /// The first part of the case begins.
    pub(super) fn begin_first_phase(&mut self) {
        self.progress.phase = if self.progress.setup > 0 { CasePart::Setup } else { CasePart::Main };
    }

    /// Whether a step belongs to a part of the case that can still come.
    pub(super) fn may_come(&self, step: usize) -> bool {
        self.steps[step].phase >= self.progress.phase
    }

    /// Keeps what a step of main would do while the setup is under way.
    pub(super) fn is_held(&mut self, step: usize, due: Due) -> bool {
        let early = self.progress.phase == CasePart::Setup
            && matches!(due, Due::Arm | Due::Begin)
            && self.steps[step].phase == CasePart::Main;
        if early {
            self.progress.held.push((step, due));
        }
        early
    }

    /// Whether a step that is due begins: one that comes again may have come for the last time.
    pub fn begins(&self, step: usize, now: Time) -> bool {
        !self.progress.stopped[step] && self.progress.until[step].is_none_or(|until| now < until)
    }

    /// What this step waits for happened. TRUE where it is to begin.
    pub(super) fn reacts(&mut self, step: usize) -> bool {
        match &self.steps[step].repeat {
            Some(StepRepeat::Each { .. }) if self.progress.working[step] => return false,
            Some(StepRepeat::Each { .. }) => {}
            _ => self.armed[step] = false,
        }
        self.progress.working[step] = true;
        true
    }

    /// A step that was missed: TRUE where it came before, and only listens no longer.
    pub(super) fn has_come(&mut self, step: usize, now: Time) -> bool {
        let come = self.progress.times[step] > 0 || self.progress.working[step];
        if come {
            self.stop(step, now);
        }
        come
    }

    /// A step comes no more.
    pub fn stop(&mut self, step: usize, now: Time) {
        if !std::mem::replace(&mut self.progress.stopped[step], true)
            && !self.progress.working[step]
            && self.progress.times[step] > 0
        {
            self.put(now, step, Due::Done);
        }
    }

    /// Counts that a step comes.
    pub(super) fn count(&mut self, step: usize, now: Time) -> u64 {
        self.progress.first[step].get_or_insert(now);
        self.progress.working[step] = true;
        self.progress.times[step] += 1;
        let n = self.progress.times[step];
        match &self.steps[step].repeat {
            Some(StepRepeat::Each { times }) if n < *times => {}
            _ => self.armed[step] = false,
        }
        n
    }

    /// Queues the next time of a step that comes every so often.
    pub(super) fn again(&mut self, step: usize, n: u64, now: Time) {
        if let Some(StepRepeat::Every { period, times, .. }) = self.steps[step].repeat
            && n < times
        {
            self.put(now.saturating_add(period), step, Due::Begin);
        }
    }

    /// Whether the step runs a group that has steps: it is done when these are.
    pub(super) fn runs(&self, step: usize) -> bool {
        self.progress.open[step] > 0
    }

    /// One time of a step is done. TRUE where that was the last one.
    pub fn is_done(&mut self, step: usize) -> bool {
        self.progress.working[step] = false;
        let last = match &self.steps[step].repeat {
            None => true,
            Some(repeat) => self.progress.stopped[step] || self.progress.times[step] >= repeat.times(),
        };
        // Of two times that touch each other the end of the first may come after the beginning of the last.
        last && !std::mem::replace(&mut self.progress.done[step], true)
    }

    /// Looks again at this instant whether a step is done.
    pub fn done_at(&mut self, step: usize, at: Time) {
        self.put(at, step, Due::Done);
    }

    /// Ends the next of the waves without end that the board makes for steps: its channel, with the level that it has now.
    pub fn end_emission(&mut self, now: Time) -> Option<(ChannelId, Value)> {
        for (step, planned) in self.steps.iter().enumerate() {
            let Some(StimulusGenerator::Emitted(emitted)) = &planned.generator else { continue };
            let running = &mut self.running[step];
            if let Some(begun) = self.begun[step]
                && emitted.is_endless()
                && running.act == 1
                && !running.stopped
            {
                running.stopped = true;
                return Some((emitted.channel, emitted.level(now - begun)));
            }
        }
        None
    }

    /// Informs those who wait for it that a step is done.
    pub(super) fn close(&mut self, step: usize, now: Time) {
        if let Some(parent) = self.steps[step].parent {
            self.progress.open[parent] -= 1;
            if self.progress.open[parent] == 0 {
                self.put(now, parent, Due::Done);
            }
        }
        if self.steps[step].phase == CasePart::Setup {
            self.progress.setup -= 1;
            if self.progress.setup == 0 {
                self.put(now, step, Due::Main);
            }
        }
    }

    /// An instant came up to which steps come.
    pub(super) fn stops(&mut self, root: StepAnchor, now: Time) {
        for place in 0..self.progress.untils.len() {
            let (of, step, offset) = self.progress.untils[place];
            if of == root && self.may_come(step) {
                let at = now.saturating_add(offset).max(now);
                self.progress.until[step] = Some(at);
                self.put(at, step, Due::Stop);
            }
        }
    }
}
