//! What a plan that runs has reported, case by case.

use control::{Measured, PlanEvent};

/// The course of a plan.
#[derive(Debug, Default)]
pub struct PlanProgress<'a> {
    /// Its cases, in their order.
    pub cases: Vec<CaseProgress<'a>>,
    /// The verdict of all, and where the report is.
    pub over: Option<(&'a str, Option<&'a str>)>,
}

/// A case.
#[derive(Debug)]
pub struct CaseProgress<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its place from 1, and how many there are.
    pub place: (u32, u32),
    /// Its steps: name and what they do.
    pub steps: &'a [(String, String)],
    /// Its claims: name and what they ask.
    pub claims: &'a [(String, String)],
    /// What was reported until it was over.
    events: &'a [PlanEvent],
    /// How it ended.
    pub end: Option<CaseOutcome<'a>>,
}

/// How a case ended.
#[derive(Debug)]
pub struct CaseOutcome<'a> {
    /// The verdict's word.
    pub verdict: &'a str,
    /// Why.
    pub reason: &'a str,
    /// Verdicts of its claims, with the reason.
    pub claims: &'a [(String, String, String)],
    /// Its measurements.
    pub measured: &'a [Measured],
}

/// How far a step is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StepProgress {
    /// It has not begun.
    #[default]
    Pending,
    /// It began then, nanoseconds in the case.
    Started(i64),
    /// It was done then.
    Done(i64),
}

impl<'a> PlanProgress<'a> {
    /// Reads what was reported. What does not belong to a case is passed over.
    pub fn of(events: &'a [PlanEvent]) -> PlanProgress<'a> {
        let mut course = PlanProgress::default();
        for (at, event) in events.iter().enumerate() {
            match event {
                PlanEvent::Case { name, place, steps, claims } => {
                    course.cases.push(CaseProgress {
                        name,
                        place: *place,
                        steps,
                        claims,
                        events: &events[at + 1..],
                        end: None,
                    });
                }
                PlanEvent::Step { .. } => {}
                PlanEvent::Verdict { name, verdict, reason, claims, measured } => {
                    let open = course.cases.last_mut().filter(|case| case.end.is_none() && case.name == name);
                    if let Some(case) = open {
                        case.end = Some(CaseOutcome { verdict, reason, claims, measured });
                    }
                }
                PlanEvent::Over { verdict, report } => course.over = Some((verdict, report.as_deref())),
            }
        }
        course
    }

    /// How many cases ended with each verdict, in the order in which the verdicts came first.
    pub fn tally(&self) -> Vec<(&'a str, usize)> {
        let mut tally: Vec<(&str, usize)> = Vec::new();
        for end in self.cases.iter().filter_map(|case| case.end.as_ref()) {
            match tally.iter_mut().find(|(verdict, _)| *verdict == end.verdict) {
                Some((_, count)) => *count += 1,
                None => tally.push((end.verdict, 1)),
            }
        }
        tally
    }
}

impl CaseProgress<'_> {
    /// How far its steps are.
    pub fn progress(&self) -> Vec<StepProgress> {
        let mut progress = vec![StepProgress::Pending; self.steps.len()];
        for event in self.events {
            match event {
                PlanEvent::Step { step, at, done } => {
                    if let Some(step) = progress.get_mut(*step as usize) {
                        *step = if *done { StepProgress::Done(*at) } else { StepProgress::Started(*at) };
                    }
                }
                _ => break,
            }
        }
        progress
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(name: &str, place: u32) -> PlanEvent {
        let steps = vec![("a".to_owned(), String::new()), ("b".to_owned(), String::new())];
        PlanEvent::Case { name: name.to_owned(), place: (place, 2), steps, claims: Vec::new() }
    }

    fn verdict(name: &str, verdict: &str) -> PlanEvent {
        let (name, verdict, reason) = (name.to_owned(), verdict.to_owned(), String::new());
        PlanEvent::Verdict { name, verdict, reason, claims: Vec::new(), measured: Vec::new() }
    }

    #[test]
    fn steps_belong_to_the_case_that_runs() {
        let events = [
            PlanEvent::Step { step: 0, at: 1, done: true },
            case("one", 1),
            PlanEvent::Step { step: 1, at: 5, done: false },
            PlanEvent::Step { step: 7, at: 6, done: true },
            verdict("other", "fail"),
            verdict("one", "pass"),
            case("two", 2),
            PlanEvent::Step { step: 0, at: 9, done: true },
        ];
        let course = PlanProgress::of(&events);
        assert_eq!(course.cases[0].progress(), [StepProgress::Pending, StepProgress::Started(5)]);
        assert_eq!(course.cases[1].progress(), [StepProgress::Done(9), StepProgress::Pending]);
        assert_eq!(course.cases[0].end.as_ref().map(|end| end.verdict), Some("pass"));
        assert!(course.cases[1].end.is_none() && course.over.is_none());
        assert_eq!(course.tally(), [("pass", 1)]);
    }
}
