//! What can be said of a case before anything moves, beyond what its entries say of themselves: claims that look
//! where nothing can be seen, steps that are cut off, watchdogs that never watch, names that nobody speaks of, a guard band that nothing takes.

use std::collections::BTreeSet;
use std::ops::Range;

use document::{Entry, Findings};
use signal::{SignalInfo, Span, Value, ValueKind};

use super::envelope::ListEntry;
use super::read::PlanDocument;
use super::times::part;
use super::{PlanSettings, PlanStep, StepTime};
use crate::codes;
use crate::expect::{ClaimDemand, Expectation, condition::ValueCondition};
use crate::lang::{Anchor, AnchorBase, Literal};
use crate::measure::{self, Measurement};
use crate::monitor::Truth;
use crate::signals::{SignalBinding, SignalSource, TaskFigure};
use crate::steps::{MAX_SAMPLES, Stimulus, WaveStimulus};

/// The parts of a case that are held against each other.
pub(super) struct CheckedParts<'a> {
    pub(super) steps: &'a [PlanStep],
    pub(super) ends: &'a Anchor,
    /// Whether the plan says where the case ends.
    pub(super) ends_given: bool,
    pub(super) expectations: &'a [Expectation],
    pub(super) measurements: &'a [Measurement],
    pub(super) signals: &'a [SignalBinding],
    pub(super) settings: &'a PlanSettings,
}

/// A place in time: what it depends on that is not known before the case runs, and the distance from it.
#[derive(Clone, Debug, PartialEq)]
struct CheckedTime<'a> {
    /// The id of an awaited step; `None`: `start`.
    root: Option<&'a str>,
    nanos: i128,
}

impl CheckedTime<'_> {
    /// How long after `other`, where both depend on the same.
    fn after(&self, other: &CheckedTime<'_>) -> Option<i128> {
        (self.root == other.root).then(|| self.nanos - other.nanos)
    }
}

/// Looks at a case whose parts were found right.
pub(super) fn case(parts: &CheckedParts<'_>, out: &mut Findings) {
    let end = parts.place(parts.ends);
    for expectation in parts.expectations {
        let Some(place) = &expectation.place else { continue };
        for demand in expectation.claim.demands() {
            if let Some((message, help)) = parts.beyond(&demand, end.as_ref()) {
                out.error(codes::BEYOND_CASE, place.span.clone(), message, help);
                // One is enough: the others say the same of another key.
                break;
            }
        }
        parts.unarmed(expectation, place.span.clone(), out);
    }
    for measurement in parts.measurements {
        let late = measurement.anchors().into_iter().find(|anchor| parts.is_behind(anchor, end.as_ref()));
        if let (Some(anchor), Some(place)) = (late, &measurement.place) {
            let message = format!("`{anchor}` lies after the end of the case: it is never measured");
            out.error(codes::BEYOND_CASE, place.span.clone(), message, LATER);
        }
    }
    if let Some(end) = &end {
        parts.too_many_values(end, out);
        if parts.ends_given {
            parts.cut_off(end, out);
        }
    }
}

/// Says of a name that nothing speaks of it, unless it is there for the trace.
pub(super) fn unused(binding: &SignalBinding, out: &mut Findings) {
    if binding.record {
        return;
    }
    let message = format!("`{}` is bound and never used", binding.name);
    out.warn(
        codes::UNUSED,
        binding.span.clone(),
        message,
        "use it, remove it, or bind it by a table with `record = true` for the trace alone",
    );
}

/// Says of the plan's own `guard = "none"` that no measurement takes it: none has limits and no `guard` of its own.
pub(super) fn guard_of_nothing(document: &PlanDocument, out: &mut Findings) {
    let own = |entry: &&Entry| {
        entry.node.as_text() == Some("none") && document.text.joined.is_first(entry.key_span.start)
    };
    let Some(entry) = document.head.entry(measure::GUARD).filter(own) else { return };
    let takes_it = |one: &ListEntry| {
        let has = |key: &str| one.node.as_table().is_some_and(|table| table.entry(key).is_some());
        measure::LIMITS.iter().any(|key| has(key)) && !has(measure::GUARD)
    };
    let of_groups = document.groups.iter().flat_map(|group| &group.measure);
    if document.measure.iter().chain(of_groups).any(takes_it) {
        return;
    }
    let message = "no measurement takes this `guard`: none has limits and no `guard` of its own";
    let help = "remove it, or measure what is to be accepted by its middle: a table of `measure` with `max`; a claim has no guard band";
    out.warn(codes::GUARD_OF_NOTHING, entry.key_span.clone(), message, help);
}

/// How long the processor is taken before the system watchdogs act (controller:WD-00, WD-01).
const SYSTEM_WATCHDOG: Span = Span::from_secs(3);

/// What fixes a claim that looks too late.
const LATER: &str = "let the case end later with `ends`, or count from an earlier instant";

impl CheckedParts<'_> {
    /// Where an instant lies, as far as that is known before the case runs.
    fn place(&self, anchor: &Anchor) -> Option<CheckedTime<'_>> {
        let base = match &anchor.base {
            AnchorBase::Start => CheckedTime { root: None, nanos: 0 },
            AnchorBase::End => return self.place(self.ends).map(|end| end.later(anchor.offset)),
            base => {
                let step = self.steps.iter().find(|step| Some(step.id.as_str()) == base.step())?;
                let begins = match &step.when {
                    StepTime::When { .. } => CheckedTime { root: Some(&step.id), nanos: 0 },
                    StepTime::At(at) => match &at.base {
                        AnchorBase::Start => {
                            CheckedTime { root: None, nanos: i128::from(at.offset.as_nanos()) }
                        }
                        AnchorBase::Step(root) => {
                            CheckedTime { root: Some(root), nanos: i128::from(at.offset.as_nanos()) }
                        }
                        _ => return None,
                    },
                };
                // Of what comes again, or runs a group, only the beginning is known.
                let known = matches!(base, AnchorBase::Step(_) | AnchorBase::Pulse { .. })
                    || step.repeat.is_none() && !matches!(step.stimulus, Stimulus::Run { .. });
                begins.later(known.then(|| part(step, base))?)
            }
        };
        Some(base.later(anchor.offset))
    }

    /// Whether an instant lies after the end of the case whatever happens.
    fn is_behind(&self, anchor: &Anchor, end: Option<&CheckedTime<'_>>) -> bool {
        self.place(anchor).zip(end).and_then(|(at, end)| at.after(end)).is_some_and(|late| late > 0)
    }

    /// Why a claim looks where the case is over.
    fn beyond(
        &self,
        demand: &ClaimDemand<'_>,
        end: Option<&CheckedTime<'_>>,
    ) -> Option<(String, &'static str)> {
        let late = |anchor: &Anchor| self.place(anchor)?.after(end?);
        let span = |nanos: i128| Span::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX));
        match demand {
            ClaimDemand::At(anchor) => late(anchor)
                .filter(|late| *late > 0)
                .map(|by| (format!("`{anchor}` lies {} after the end of the case", span(by)), LATER)),
            ClaimDemand::Delay { from, limits, .. } => {
                let least = late(from)? + i128::from(limits.0.max(0));
                (least > 0).then(|| {
                    let by = span(least);
                    (format!("the case ends {by} before this can happen: the claim can never be met"), LATER)
                })
            }
            ClaimDemand::Window { from, until } => {
                if late(from).is_some_and(|late| late >= 0) {
                    return Some((
                        format!("`{from}` is not before the end of the case: nothing is looked at"),
                        LATER,
                    ));
                }
                if let Some(by) = late(until).filter(|late| *late > 0) {
                    let message = format!(
                        "`{until}` lies {} after the end of the case: what comes then is not seen",
                        span(by)
                    );
                    return Some((message, LATER));
                }
                let length = self.place(until)?.after(&self.place(from)?)?;
                (length <= 0).then(|| {
                    let message =
                        format!("nothing lies between `{from}` and `{until}`: the claim can never fail");
                    (message, "let `until` be later than `from`")
                })
            }
            ClaimDemand::Value { .. } | ClaimDemand::Change(_) | ClaimDemand::Differ(..) => None,
        }
    }

    /// Reports waves without an end of their own that go through too many values up to that of the case. Where another
    /// step drives the same signal, it may end the wave sooner.
    fn too_many_values(&self, end: &CheckedTime<'_>, out: &mut Findings) {
        for step in self.steps {
            let Stimulus::Wave(wave @ WaveStimulus { lasts: None, .. }) = &step.stimulus else { continue };
            let is_other = |other: &&PlanStep| other.id != step.id;
            let drives = |other: &PlanStep| other.stimulus.signals().contains(&wave.signal.as_str());
            if self.steps.iter().filter(is_other).any(drives) {
                continue;
            }
            let begins = Anchor { base: AnchorBase::Step(step.id.clone()), offset: Span::ZERO };
            let Some(length) = self.place(&begins).and_then(|begins| end.after(&begins)) else { continue };
            let values = wave.values_in(length);
            if values > i128::from(MAX_SAMPLES) {
                let message = format!(
                    "the wave of the step `{}` goes through {values} values up to the end of the case; {MAX_SAMPLES} is the most",
                    step.id
                );
                let help =
                    "give it a `duration`, let its values be farther apart, or let the case end sooner";
                out.error(codes::SAMPLES, step.span.clone(), message, help);
            }
        }
    }

    /// Reports steps that are not done when the case ends.
    fn cut_off(&self, end: &CheckedTime<'_>, out: &mut Findings) {
        // A fault may well last to the end; what is to come back, or to be emitted whole, is cut off.
        let whole = |step: &&PlanStep| {
            matches!(
                step.stimulus,
                Stimulus::Pulse { .. }
                    | Stimulus::Train(_)
                    | Stimulus::Encoder(_)
                    | Stimulus::Sequence(_)
                    | Stimulus::PowerCut(_)
            )
        };
        for step in self.steps.iter().filter(whole) {
            let done = Anchor { base: AnchorBase::StepDone(step.id.clone()), offset: Span::ZERO };
            let late = self.place(&done).and_then(|done| done.after(end)).unwrap_or(0);
            if late > 0 {
                let late = Span::from_nanos(i64::try_from(late).unwrap_or(i64::MAX));
                let message = format!("the step `{}` is done {late} after the end of the case", step.id);
                let help = "let the case end later with `ends`, or make the step shorter";
                out.warn(codes::CUT_OFF, step.span.clone(), message, help);
            }
        }
    }

    /// Reports a claim that counts on a watchdog which the settings switch off.
    fn unarmed(&self, expectation: &Expectation, place: Range<usize>, out: &mut Findings) {
        let off = |task: &str| {
            let known = self.settings.tasks.iter().find(|known| known.name.eq_ignore_ascii_case(task));
            known.is_some_and(|task| task.enabled == Some(false))
        };
        let demands = expectation.claim.demands();
        // After that the system watchdog may be it, which nobody switches off.
        let soon = demands.iter().any(|demand| match demand {
            ClaimDemand::Delay { limits, .. } => limits.1 < SYSTEM_WATCHDOG.as_nanos(),
            _ => false,
        });
        for demand in demands {
            let ClaimDemand::Value { signal, condition, forbidden: false } = demand else { continue };
            let bound = self.signals.iter().find(|known| known.name == *signal).map(|known| &known.source);
            let task = match bound {
                Some(SignalSource::Task { task, figure: TaskFigure::Exceptions }) if off(task) => {
                    excludes(condition, signal).then_some(task.as_str())
                }
                None if soon && signal == "state" && is_halt(condition) => self.stalled(&off),
                _ => None,
            };
            if let Some(task) = task {
                let message = format!("this counts on the watchdog of {task}, which is switched off");
                let help = "remove `enabled = false` of the task, or claim that nothing happens";
                out.warn(codes::NEVER_ARMED, place.clone(), message, help);
                return;
            }
        }
    }

    /// The task that the steps keep busy, where all that they keep busy have no watchdog.
    fn stalled(&self, off: &dyn Fn(&str) -> bool) -> Option<&str> {
        let mut busy = self.steps.iter().filter_map(|step| match &step.stimulus {
            Stimulus::Overload { task, .. } | Stimulus::Suspend { task, .. } => Some(task.as_str()),
            _ => None,
        });
        let first = busy.next()?;
        (off(first) && busy.all(off)).then_some(first)
    }
}

impl CheckedTime<'_> {
    fn later(mut self, by: Span) -> Self {
        self.nanos += i128::from(by.as_nanos());
        self
    }
}

/// Whether the condition wants something else than 0.
fn excludes(condition: &ValueCondition, name: &str) -> bool {
    let info = SignalInfo::exact(name, ValueKind::Int);
    condition.bind(&info).is_ok_and(|test| test.holds(Value::Int(0), 0.0) == Truth::False)
}

fn is_halt(condition: &ValueCondition) -> bool {
    let ValueCondition::OneOf(list) = condition else { return false };
    matches!(list.as_slice(), [Literal::Label(label)] if label.eq_ignore_ascii_case("HALT"))
}

/// The names that no case speaks of, once every case said which ones it does not.
#[derive(Debug, Default)]
pub(super) struct Unspoken {
    names: Option<BTreeSet<String>>,
}

impl Unspoken {
    /// A case that leaves these aside.
    pub(super) fn case(&mut self, names: &[String]) {
        match &mut self.names {
            Some(known) => known.retain(|name| names.contains(name)),
            None => self.names = Some(names.iter().cloned().collect()),
        }
    }

    /// Reports what is left.
    pub(super) fn report(&self, signals: &[SignalBinding], out: &mut Findings) {
        let Some(names) = &self.names else { return };
        signals
            .iter()
            .filter(|binding| names.contains(&binding.name))
            .for_each(|binding| unused(binding, out));
    }
}
