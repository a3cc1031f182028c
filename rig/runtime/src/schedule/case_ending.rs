//! How a case ended, besides what its claims came to. It stands in the notes of the trace, so that a trace that is judged
//! again comes to the same verdict.

use record::{CaseRecord, Verdict};
use signal::Trace;
use std::fmt;

/// The notes of a trace that say it. Their names and words are part of the format of traces.
const ENDED: &str = "ended";
const UNMET: &str = "unmet";
const FAULT: &str = "trouble";
/// Followed by the state that the controller came into.
const EXCEPTION: &str = "exception:";
/// Followed by the id of a step.
const NOT_REFUSED: &str = "refused:";

/// How a case ended.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CaseEnding {
    /// Why it ended before its end, if it did.
    pub early: Option<EarlyEnd>,
    /// Steps that expect a refusal and were obeyed, by their ids.
    pub not_refused: Vec<(String, NotRefused)>,
    /// Stops of the application by an exception, the first into each state.
    pub exceptions: Vec<StopByException>,
    /// Why this instrument cannot judge the case, as was seen when it had run.
    pub unmet: Option<String>,
    /// A fault of the rig, in words.
    pub fault: Option<String>,
}

/// A stop of the application that nobody commanded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StopByException {
    /// The state that the controller came into: `HALT`, or `EMPTY` after a system error.
    pub state: String,
    /// When, and the cause: `1.1 s after the start: the task watchdog of MAST stopped the application`.
    pub what: String,
}

impl StopByException {
    /// Whether it is among the states that a plan speaks of. On its way into EMPTY the controller boots.
    fn is_expected(&self, states: &[String]) -> bool {
        states.iter().any(|state| *state == self.state || (state == "BOOTING" && self.state == "EMPTY"))
    }
}

/// Why a case ended before its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EarlyEnd {
    /// What a step of the setup waits for did not come.
    SetupStep(String),
    /// The rig had a fault in the setup.
    RigFault,
    /// A claim was lost, and nobody wants to know more.
    Claim,
    /// An alarm was raised that ends the case.
    Alarm,
    /// A device was lost.
    DeviceLost,
    /// Words of a trace that this version does not write.
    Recorded(String),
}

/// What was done although a step expects that it is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NotRefused {
    /// The command was obeyed.
    Command,
    /// The value was written.
    Write,
    /// The file was reached.
    File,
    /// Words of a trace that this version does not write.
    Recorded(String),
}

/// What stands around the id of a step of the setup.
const SETUP_STEP: (&str, &str) = ("step `", "` of the setup never came");

const EARLY: [(EarlyEnd, &str); 4] = [
    (EarlyEnd::RigFault, "the rig had trouble in the setup"),
    (EarlyEnd::Claim, "a claim was lost"),
    (EarlyEnd::Alarm, "an alarm was raised"),
    (EarlyEnd::DeviceLost, "a device was lost"),
];

const DONE: [(NotRefused, &str); 3] = [
    (NotRefused::Command, "the command was obeyed"),
    (NotRefused::Write, "the value was written"),
    (NotRefused::File, "the file was reached"),
];

impl fmt::Display for EarlyEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EarlyEnd::SetupStep(step) => write!(f, "{}{step}{}", SETUP_STEP.0, SETUP_STEP.1),
            EarlyEnd::Recorded(words) => f.write_str(words),
            known => f.write_str(EARLY.iter().find(|(end, _)| end == known).map_or("", |(_, words)| words)),
        }
    }
}

impl EarlyEnd {
    fn parse(words: &str) -> EarlyEnd {
        let step = words.strip_prefix(SETUP_STEP.0).and_then(|rest| rest.strip_suffix(SETUP_STEP.1));
        let known = EARLY.iter().find(|(_, known)| *known == words).map(|(end, _)| end.clone());
        known
            .or(step.map(|step| EarlyEnd::SetupStep(step.to_owned())))
            .unwrap_or(EarlyEnd::Recorded(words.to_owned()))
    }
}

impl fmt::Display for NotRefused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotRefused::Recorded(words) => f.write_str(words),
            known => f.write_str(DONE.iter().find(|(done, _)| done == known).map_or("", |(_, words)| words)),
        }
    }
}

impl NotRefused {
    fn parse(words: &str) -> NotRefused {
        let known = DONE.iter().find(|(_, known)| *known == words).map(|(done, _)| done.clone());
        known.unwrap_or(NotRefused::Recorded(words.to_owned()))
    }
}

impl CaseEnding {
    /// Writes it into the notes of a trace.
    pub fn write_to(&self, trace: &mut Trace) {
        if let Some(early) = &self.early {
            trace.set_note(ENDED, early.to_string());
        }
        for (step, done) in &self.not_refused {
            trace.set_note(&format!("{NOT_REFUSED}{step}"), done.to_string());
        }
        for stop in &self.exceptions {
            trace.set_note(&format!("{EXCEPTION}{}", stop.state), stop.what.clone());
        }
        if let Some(unmet) = &self.unmet {
            trace.set_note(UNMET, unmet.clone());
        }
        if let Some(fault) = &self.fault {
            trace.set_note(FAULT, fault.clone());
        }
    }

    /// What [`CaseEnding::write_to`] wrote, steps by their ids.
    pub fn read_from(trace: &Trace) -> CaseEnding {
        let steps = trace.notes().filter_map(|(key, words)| {
            Some((key.strip_prefix(NOT_REFUSED)?.to_owned(), NotRefused::parse(words)))
        });
        let exceptions = trace.notes().filter_map(|(key, what)| {
            let state = key.strip_prefix(EXCEPTION)?.to_owned();
            Some(StopByException { state, what: what.to_owned() })
        });
        CaseEnding {
            exceptions: exceptions.collect(),
            early: trace.note(ENDED).map(EarlyEnd::parse),
            not_refused: steps.collect(),
            unmet: trace.note(UNMET).map(str::to_owned),
            fault: trace.note(FAULT).map(str::to_owned),
        }
    }

    /// Puts it into a record that has the verdict of the claims: a fault of the rig goes before what the instrument lacks,
    /// and that before the claims. An exception that leaves RUNNING fails the case, unless the state that it leads to is one that
    /// the plan speaks of ([`plans::Case::expected_states`]): whatever else holds, it held for a controller that did nothing.
    pub fn judge(&self, record: &mut CaseRecord, expected_states: &[String]) {
        record.ended = self.early.as_ref().map_or_else(String::new, EarlyEnd::to_string);
        // By its id: the notes of a trace do not keep the order in which they were written.
        if let Some((step, done)) = self.not_refused.iter().min_by(|a, b| a.0.cmp(&b.0)) {
            record.verdict = record.verdict.max(Verdict::Fail);
            if record.reason.is_empty() {
                record.reason = format!("step `{step}` expects a refusal: {done}");
            }
        }
        if let Some(stop) = self.exceptions.iter().find(|stop| !stop.is_expected(expected_states)) {
            record.verdict = record.verdict.max(Verdict::Fail);
            record.exception = format!("the controller went into {} by itself, {}", stop.state, stop.what);
            record.reason.clone_from(&record.exception);
        }
        if let Some(unmet) = &self.unmet {
            record.verdict = Verdict::Inconclusive;
            record.reason.clone_from(unmet);
        }
        if let Some(fault) = &self.fault {
            record.verdict = Verdict::Error;
            record.reason.clone_from(fault);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reread(ending: &CaseEnding) -> CaseEnding {
        let mut trace = Trace::new();
        ending.write_to(&mut trace);
        CaseEnding::read_from(&trace)
    }

    #[test]
    fn what_was_written_is_read_back() {
        let step = EarlyEnd::SetupStep("a `b` of the setup never came".into());
        let other = EarlyEnd::Recorded("words of another version".into());
        for early in EARLY.into_iter().map(|(end, _)| end).chain([step, other]) {
            let ending = CaseEnding { early: Some(early), ..CaseEnding::default() };
            assert_eq!(reread(&ending), ending);
        }
        let done = DONE.into_iter().map(|(done, _)| done).chain([NotRefused::Recorded("it was done".into())]);
        let ending = CaseEnding {
            not_refused: ["a", "b", "c", "d"].map(String::from).into_iter().zip(done).collect(),
            exceptions: vec![StopByException { state: "HALT".into(), what: "1 s after the start".into() }],
            unmet: Some("late".into()),
            fault: Some("lost".into()),
            ..CaseEnding::default()
        };
        assert_eq!(reread(&ending), ending);
        assert_eq!(reread(&CaseEnding::default()), CaseEnding::default());
    }

    #[test]
    fn a_stop_that_no_plan_speaks_of_fails_the_case() {
        let stop =
            |state: &str| StopByException { state: state.into(), what: "1 s after the start: why".into() };
        let judged = |stops: &[StopByException], expected: &[&str], claims: Verdict| {
            let mut record =
                CaseRecord { verdict: claims, reason: "a claim".into(), ..CaseRecord::default() };
            let ending = CaseEnding { exceptions: stops.to_vec(), ..CaseEnding::default() };
            ending.judge(&mut record, &expected.iter().map(|state| (*state).to_owned()).collect::<Vec<_>>());
            (record.verdict, record.reason)
        };
        let failed = |state| {
            (Verdict::Fail, format!("the controller went into {state} by itself, 1 s after the start: why"))
        };
        let passed = (Verdict::Pass, String::from("a claim"));
        assert_eq!(judged(&[stop("HALT")], &["RUNNING"], Verdict::Pass), failed("HALT"));
        assert_eq!(judged(&[stop("HALT")], &[], Verdict::Inconclusive), failed("HALT"));
        assert_eq!(judged(&[stop("HALT")], &["RUNNING", "HALT"], Verdict::Pass), passed);
        assert_eq!(judged(&[stop("EMPTY")], &["BOOTING"], Verdict::Pass), passed);
        assert_eq!(judged(&[stop("HALT"), stop("EMPTY")], &["HALT"], Verdict::Pass), failed("EMPTY"));
    }

    #[test]
    fn a_fault_goes_before_what_is_unmet_and_that_before_the_claims() {
        let judged = |ending: &CaseEnding| {
            let mut record = CaseRecord { verdict: Verdict::Pass, ..CaseRecord::default() };
            ending.judge(&mut record, &[]);
            (record.verdict, record.reason)
        };
        let obeyed = |step: &str| (step.into(), NotRefused::Command);
        let mut ending =
            CaseEnding { not_refused: vec![obeyed("set"), obeyed("go")], ..CaseEnding::default() };
        let reason = String::from("step `go` expects a refusal: the command was obeyed");
        assert_eq!(judged(&ending), (Verdict::Fail, reason));
        ending.unmet = Some("late".into());
        assert_eq!(judged(&ending), (Verdict::Inconclusive, "late".into()));
        ending.fault = Some("lost".into());
        assert_eq!(judged(&ending), (Verdict::Error, "lost".into()));
    }
}
