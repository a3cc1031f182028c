//! Alarms: a condition that lasted too long ends the case, or fails it at its end.
//!
//! ```toml
//! alarms = [{ name = "over-pressure", when = { signal = "pressure", above = "6 bar" }, delay = "100 ms", hysteresis = "0.2 bar" }]
//! ```
//! A [`AlarmRule`] says of each value whether the condition holds; a [`AlarmWatch`] follows it while the case runs; the claim
//! of the alarm follows it again in the recorded trace, and decides. What counts is the time from `start` to `end`.

mod monitor;
mod rule;
mod watch;

use std::sync::Arc;

use document::Diagnostic;
use record::ClaimOrigin;
use signal::{SignalInfo, Span};

use crate::expect::GlobalCheck;
use crate::expect::{Expectation, FilePlace, TraceClaim, condition::ValueCondition, known, meant};
use crate::lang::{Anchor, Literal};
use crate::meaning::{exact, what_to_write};
use crate::monitor::{
    CaseTimeline, Monitor, NotJudged, Number, PulseRule, TraceSignals, UncertainWindow, slack,
};

pub use rule::{AlarmRule, ConditionState};
pub use watch::AlarmWatch;

/// The verb under which an alarm stands in the record.
pub(crate) const VERB: &str = "alarm";

/// What the value of an alarm's signal is held against, as written.
#[derive(Clone, Debug, PartialEq)]
pub enum AlarmCondition {
    /// It is above this.
    Above(Literal),
    /// It is below this.
    Below(Literal),
    /// It is this.
    Is(Literal),
}

/// An alarm of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Alarm {
    /// Its name; `alarm:<name>` is its signal in the trace.
    pub name: String,
    /// The signal that it watches, all of whose changes are recorded.
    pub signal: String,
    /// What must not last.
    pub condition: AlarmCondition,
    /// How long it may last: an alarm is raised when it lasted that long.
    pub delay: Span,
    /// How far after the limit the value has to come back before the condition is over.
    pub hysteresis: Option<Literal>,
    /// Whether the case ends when it is raised.
    pub ends: bool,
    /// Where it stands.
    pub place: FilePlace,
    /// Which kind of file that is.
    pub origin: ClaimOrigin,
}

impl Alarm {
    /// The condition in the terms of its signal.
    ///
    /// # Errors
    /// Why it means nothing for this signal, one sentence.
    pub fn rule(&self, info: &SignalInfo) -> Result<AlarmRule, String> {
        let (limit, above) = match &self.condition {
            AlarmCondition::Is(literal) => {
                let wanted = ValueCondition::OneOf(vec![literal.clone()]);
                return Ok(AlarmRule::is(wanted.bind(info)?, slack(info)));
            }
            AlarmCondition::Above(limit) => (limit, true),
            AlarmCondition::Below(limit) => (limit, false),
        };
        let on = exact(limit, info)?;
        let band = match &self.hysteresis {
            Some(band) => exact(band, info)?,
            None => return Ok(AlarmRule::limit(above, Number::from(on), Number::from(on), slack(info))),
        };
        let off = if above { on.minus(band) } else { on.plus(band) };
        let off = off.ok_or("the hysteresis has too many digits")?;
        Ok(AlarmRule::limit(above, Number::from(on), Number::from(off), slack(info)))
    }

    /// What is looked at while the case runs.
    ///
    /// # Errors
    /// As [`Alarm::rule`].
    pub fn watch(&self, info: &SignalInfo) -> Result<AlarmWatch, String> {
        Ok(AlarmWatch::new(self.rule(info)?, self.delay))
    }

    /// The condition in words: `pressure above 6 bar`.
    fn words(&self) -> String {
        match &self.condition {
            AlarmCondition::Above(limit) => format!("above {limit}"),
            AlarmCondition::Below(limit) => format!("below {limit}"),
            AlarmCondition::Is(value) => value.to_string(),
        }
    }

    /// The claim that the alarm is not raised.
    pub(crate) fn global_check(self: &Arc<Alarm>) -> GlobalCheck {
        let expectation = Expectation {
            name: self.name.clone(),
            verb: VERB,
            claim: Arc::clone(self) as Arc<dyn TraceClaim>,
            place: Some(self.place.clone()),
        };
        GlobalCheck { expectation, origin: self.origin }
    }
}

impl TraceClaim for Alarm {
    fn expected(&self) -> String {
        let lasts = match self.delay {
            Span::ZERO => String::new(),
            delay => format!(" for {delay}"),
        };
        format!("`{}` is not {}{lasts}", self.signal, self.words())
    }

    fn signals(&self) -> Vec<String> {
        vec![self.signal.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        vec![&Anchor::START, &Anchor::END]
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        if let Some(info) = known(&self.signal, wiring, out) {
            meant(self.rule(info).map(drop), &what_to_write(info), out);
        }
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::breaks(Some(self.delay)).weighed("delay")
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let window = match scene.window(&Anchor::START, &Anchor::END) {
            // An alarm without a delay can end a case where it begins.
            Err(NotJudged::EmptyWindow(_)) => {
                let (from, until) = (scene.point(&Anchor::START)?, scene.point(&Anchor::END)?);
                UncertainWindow { from, until, link: None }
            }
            window => window?,
        };
        let rule = self.rule(info).map_err(NotJudged::NoMeaning)?;
        Ok(Box::new(monitor::AlarmMonitor::new(self, rule, info, window, scene.is_open(&Anchor::END))))
    }
}
