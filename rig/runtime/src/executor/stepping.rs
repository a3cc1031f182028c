//! Going through a case step by step: somebody is asked before each step of the plan, and at instants of their choice.
//!
//! The modelled time stands still meanwhile, and nothing of it shows in the trace.

use signal::{Time, Trace};

/// Where a case stands still.
#[derive(Clone, Copy, Debug)]
pub struct Pause<'a> {
    /// The instant.
    pub now: Time,
    /// The plan's `start`.
    pub start: Time,
    /// Id of the step that comes next at this instant; nothing at an instant that was asked for.
    pub step: Option<&'a str>,
    /// What happened so far.
    pub trace: &'a Trace,
}

/// How a case goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepTarget {
    /// To the next step of the plan.
    Next,
    /// To this instant.
    Until(Time),
    /// To its end.
    ToEnd,
    /// Not at all: the outputs are made safe.
    Quit,
}

/// Is asked how a case goes on.
pub trait Stepper {
    /// The case stands still.
    fn pause(&mut self, pause: &Pause<'_>) -> StepTarget;
}

/// A stepper with what it said last.
pub(crate) struct Stepping<'a> {
    stepper: &'a mut dyn Stepper,
    go: StepTarget,
}

impl<'a> Stepping<'a> {
    pub(crate) fn new(stepper: &'a mut dyn Stepper) -> Stepping<'a> {
        Stepping { stepper, go: StepTarget::Next }
    }

    /// The instant that was asked for; now, where the rest of this instant is still to be looked after.
    pub(crate) fn wake(&self, now: Time) -> Time {
        match self.go {
            StepTarget::Until(at) => at.max(now),
            _ => Time::MAX,
        }
    }

    /// Asks, if this is where to stand still. FALSE where the case is not to go on.
    pub(crate) fn ask(&mut self, pause: &Pause<'_>) -> bool {
        let here = match self.go {
            StepTarget::Next => pause.step.is_some(),
            StepTarget::Until(at) => pause.now >= at,
            StepTarget::ToEnd => false,
            StepTarget::Quit => return false,
        };
        if here {
            self.go = self.stepper.pause(pause);
        }
        self.go != StepTarget::Quit
    }
}
