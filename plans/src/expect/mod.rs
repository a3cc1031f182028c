//! Expectations: what a plan claims of its trace, one file for each verb.
//!
//! A verb is a table of keys, a reader and a [`TraceClaim`]; [`VERBS`] lists them all, and nothing outside this
//! folder knows any of them by name. How to add one: `docs/add-an-expectation.md`.

pub(crate) mod band;
mod becomes;
mod common;
pub(crate) mod condition;
mod demand;
mod edges;
mod entry;
mod equal;
mod first_edge;
mod follows;
mod frames;
pub(crate) mod happens;
mod indicator;
pub(crate) mod jitter;
mod keeps;
mod order;
mod pairs;
mod period;
mod phase;
pub(crate) mod position;
pub(crate) mod profile;
mod pulse;
mod rate;
mod settles;
mod shape;
pub(crate) mod speed;
mod state;
mod task;
mod together;
pub(crate) mod train;
mod value;

use std::fmt::{self, Debug};
use std::ops::Range;
use std::sync::Arc;

use document::{Diagnostic, Fields, Findings, KeySpec};
use record::ClaimOrigin;
use signal::SignalInfo;

use crate::codes;
use crate::lang::{Anchor, PlanNames};
use crate::monitor::{CaseTimeline, Monitor, NotJudged, PulseRule, TraceSignals};

pub use demand::ClaimDemand;

pub(crate) use common::{LONGER, PlanWindow, delay_words, span_range, unclear};
pub(crate) use condition::literal;

/// A verb of `expect`: `{ falls = { signal = ... } }`.
#[derive(Debug)]
pub struct ExpectVerb {
    /// The verb as written.
    pub name: &'static str,
    /// What it claims, one sentence, for the schema and the manual.
    pub doc: &'static str,
    /// Its keys.
    pub keys: &'static [KeySpec],
    /// Makes the claim of a table that was held against `keys`. `None` after it reported what is wrong.
    pub read: fn(&Fields<'_>, &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>>,
}

/// Where a reader reports, and the plan around it.
pub struct ReadContext<'a> {
    /// The findings so far.
    pub out: &'a mut Findings,
    /// The names of the plan.
    pub names: &'a dyn PlanNames,
    /// Where the verb's table stands.
    pub place: Range<usize>,
}

impl fmt::Debug for ReadContext<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Context").field("place", &self.place).finish_non_exhaustive()
    }
}

/// An expectation of one case.
#[derive(Clone, Debug)]
pub struct Expectation {
    /// The name that the plan gives it, empty for none: the claim's own words serve then.
    pub name: String,
    /// The verb.
    pub verb: &'static str,
    /// What it claims.
    pub claim: Arc<dyn TraceClaim>,
    /// Where it stands; `None` for a claim that is in no plan file.
    pub place: Option<FilePlace>,
}

/// An invariant or an alarm: a claim that holds in every case that its file covers.
#[derive(Clone, Debug)]
pub struct GlobalCheck {
    /// The claim.
    pub expectation: Expectation,
    /// The kind of file that it stands in.
    pub origin: ClaimOrigin,
}

/// Where an expectation or a measurement stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilePlace {
    /// Name of the plan file; empty where only the line is known.
    pub file: Arc<str>,
    /// Bytes of the file.
    pub span: Range<usize>,
    /// Line of the file, from 1.
    pub line: u32,
}

/// What a verb claims of a trace. It is plain data; judging is done by the [`Monitor`] that it starts.
pub trait TraceClaim: Debug + Send + Sync {
    /// The claim in words: `lamp falls 100 ms .. 100.3 ms after busy`.
    fn expected(&self) -> String;
    /// The signals that it looks at. The place in this list is the `slot` of [`Monitor::feed`].
    fn signals(&self) -> Vec<String>;
    /// The instants that it depends on.
    fn anchors(&self) -> Vec<&Anchor>;
    /// Finds what cannot be judged with these signals at all (a label that the state does not have).
    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>);
    /// What it demands, as far as that can be held against plan and bench before anything moves.
    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        Vec::new()
    }
    /// Of a claim for which every pulse of its signals counts: how fast they have to be in Hz for it to hold, at least; 0
    /// where it says nothing of that.
    fn counts(&self) -> Option<f64> {
        None
    }
    /// Whether it looks as far as the case goes, unless what it wants comes before.
    fn is_open_ended(&self) -> bool {
        false
    }
    /// How it looks at the pulses of one of its signals: what those that nobody saw could do to its answer.
    fn pulses(&self, info: &SignalInfo) -> PulseRule;
    /// Starts judging; every instant that the claim depends on is known by now, or known not to have come.
    ///
    /// # Errors
    /// [`NotJudged`] when it depends on an instant that never came or on a window that is empty.
    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged>;
}

/// Every verb, in the order of the manual.
pub static VERBS: &[&ExpectVerb] = &[
    &first_edge::RISES,
    &first_edge::FALLS,
    &first_edge::CHANGES,
    &becomes::BECOMES,
    &keeps::STAYS,
    &keeps::NEVER,
    &edges::EDGES,
    &pulse::PULSE,
    &period::PERIOD,
    &rate::FREQUENCY,
    &rate::DUTY,
    &jitter::JITTER,
    &phase::PHASE,
    &position::POSITION,
    &profile::PROFILE,
    &speed::SPEED,
    &settles::SETTLES,
    &follows::FOLLOWS,
    &frames::FRAMES,
    &state::STATE,
    &indicator::LED,
    &entry::LOG,
    &task::TASK,
    &value::VALUE,
    &equal::EQUAL,
    &order::ORDER,
    &happens::HAPPENS,
];

/// The verb of this name.
pub fn verb(name: &str) -> Option<&'static ExpectVerb> {
    VERBS.iter().copied().find(|verb| verb.name == name)
}

/// The signal of this name, or a finding that the trace does not have it.
pub(crate) fn known<'a>(
    name: &str,
    wiring: &TraceSignals<'a>,
    out: &mut Vec<Diagnostic>,
) -> Option<&'a SignalInfo> {
    let found = wiring.find(name);
    if found.is_none() {
        let names = wiring.signals.iter().map(|info| info.name.as_str());
        let help = match document::suggest(name, names) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => String::from("bind it under `signals`, or use a variable's path"),
        };
        let message = format!("the trace has no signal `{name}`");
        out.push(Diagnostic::error(codes::NOT_IN_TRACE, message).help(help));
    }
    found
}

/// Keeps why a value means nothing for its signal, with what to write in its place.
pub(crate) fn meant(result: Result<(), String>, help: &str, out: &mut Vec<Diagnostic>) {
    if let Err(why) = result {
        out.push(Diagnostic::error(codes::MEANING, why).help(help));
    }
}
