//! The claim of a step that asks a person: the answer is the one that passes. Every such step makes it without being
//! asked for.

use std::sync::Arc;

use document::Diagnostic;
use signal::{SignalInfo, Value};

use super::StepFacts;
use crate::expect::{Expectation, FilePlace, TraceClaim, known};
use crate::lang::Anchor;
use crate::monitor::{CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals};
use crate::steps::Question;

/// The claim.
#[derive(Clone, Debug)]
struct AnswerClaim {
    step: String,
    question: Question,
}

/// The claim that the step was answered as it wants.
pub(crate) fn implied(step: &StepFacts, question: &Question) -> Expectation {
    Expectation {
        name: question.text.clone(),
        verb: "ask",
        claim: Arc::new(AnswerClaim { step: step.id.clone(), question: question.clone() }),
        place: Some(FilePlace { file: Arc::from(""), span: 0..0, line: step.line }),
    }
}

impl AnswerClaim {
    fn answer(&self, place: usize) -> &str {
        self.question.answers.get(place).map_or("?", String::as_str)
    }
}

impl TraceClaim for AnswerClaim {
    fn expected(&self) -> String {
        format!("{} is answered {}", self.step, self.answer(self.question.pass))
    }

    fn signals(&self) -> Vec<String> {
        vec![format!("answer:{}", self.step)]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        Vec::new()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        known(&self.signals()[0], wiring, out);
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::SEEN
    }

    fn start(&self, _: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        Ok(Box::new(AnswerMonitor { claim: self.clone(), given: None }))
    }
}

/// The judge.
struct AnswerMonitor {
    claim: AnswerClaim,
    given: Option<(TimedValue, Value)>,
}

impl Monitor for AnswerMonitor {
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        self.given.get_or_insert((*seen, seen.value));
    }

    fn finish(self: Box<Self>) -> Finding {
        let Some((seen, value)) = self.given else {
            let reason = String::from("nobody was asked");
            // Neither held nor broken: whoever would have been asked knows nothing of it.
            return Finding {
                observed: reason.clone(),
                reason,
                can_hold: true,
                can_break: true,
                ..Finding::default()
            };
        };
        let given = value.as_int().and_then(|given| usize::try_from(given).ok());
        let right = given == Some(self.claim.question.pass);
        let answer = given.map_or("?", |given| self.claim.answer(given));
        let finding = Finding { can_hold: right, can_break: !right, ..Finding::default() }.decided_by(&seen);
        let reason = if right { String::new() } else { format!("answered {answer}") };
        Finding { observed: format!("answered {answer}"), reason, ..finding }
    }
}
