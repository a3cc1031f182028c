//! When the steps of a case come: what hangs on other steps is added up, and what cannot be is reported.

use std::collections::BTreeMap;

use document::{Diagnostic, Findings, Node};
use signal::Span;

use super::{Step, StepTime};
use crate::codes;
use crate::lang::{Anchor, Base};
use crate::steps::Stimulus;

/// How long after its last step a case ends where the plan does not say.
const AFTER_LAST: Span = Span::from_secs(1);
/// Time for power-on and whatever else no plan adds up.
const ALLOWANCE: i128 = 60_000_000_000;
/// Furthest from its root that a step may lie: 100 years.
const FURTHEST: i128 = 100 * 366 * 86_400 * 1_000_000_000;

/// A step's time as written, with the value that says it.
pub(super) struct Written<'n> {
    /// The instant of an `at`, or the `from` of a `when`.
    pub(super) anchor: Anchor,
    /// Where it is written; the step's own table where it is left out.
    pub(super) node: &'n Node,
    /// How much the phase of this case adds, nanoseconds.
    pub(super) phase: i64,
}

/// A place in time: a root that is not known before the case runs, and a distance from it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rooted {
    /// Place of the awaited step it hangs on; `None`: `start`.
    root: Option<usize>,
    nanos: i128,
}

#[derive(Clone, Copy, PartialEq)]
enum Mark {
    New,
    Open,
    Done(Option<Rooted>),
}

/// Rewrites the times of `steps` so that every instant hangs on `start` or on an awaited step, and gives the end
/// of the case and the time that it may take. `ends` is what the plan says, with the value that says it.
///
/// `None` after it reported what is wrong.
pub(super) fn settle(
    steps: &mut [Step],
    written: &[Written<'_>],
    ends: Option<(Anchor, &Node)>,
    out: &mut Findings,
) -> Option<(Anchor, Span)> {
    let before = out.errors();
    let places = steps.iter().enumerate().map(|(at, step)| (step.id.as_str(), at)).collect();
    let mut chain = Chain {
        steps: &*steps,
        places,
        written,
        ends: ends.as_ref(),
        marks: vec![Mark::New; steps.len() + 1],
    };
    for at in 0..=steps.len() {
        if at < steps.len() || ends.is_some() {
            chain.follow(at, out);
        }
    }
    if out.errors() > before {
        return None;
    }
    let places: Vec<Option<Rooted>> = (0..=steps.len())
        .map(|at| match chain.marks[at] {
            Mark::Done(place) => place,
            _ => None,
        })
        .collect();
    let end = match &ends {
        Some(_) => places[steps.len()]?,
        None => default_end(steps, &places)?,
    };
    check(steps, written, &places, end, ends.is_some(), out);
    if out.errors() > before {
        return None;
    }
    let ids: Vec<String> = steps.iter().map(|step| step.id.clone()).collect();
    for (at, step) in steps.iter_mut().enumerate() {
        let anchor = to_anchor(places[at]?, &ids);
        match &mut step.when {
            StepTime::At(time) => *time = anchor,
            StepTime::When { from, .. } => {
                *from = Anchor { offset: anchor.offset.max(Span::ZERO), ..anchor };
            }
        }
    }
    Some((to_anchor(end, &ids), allowance(steps, end)))
}

/// The chain of what hangs on what. Every step hangs on exactly one thing, so following is a walk, not a search.
struct Chain<'c, 'n> {
    steps: &'c [Step],
    /// Place of each step by its id.
    places: BTreeMap<&'c str, usize>,
    written: &'c [Written<'n>],
    ends: Option<&'c (Anchor, &'n Node)>,
    /// One for each step, then one for the end.
    marks: Vec<Mark>,
}

impl Chain<'_, '_> {
    /// Settles what stands at `first` and all that it hangs on.
    fn follow(&mut self, first: usize, out: &mut Findings) {
        let mut path: Vec<usize> = Vec::new();
        let mut at = first;
        let mut place = loop {
            match self.marks[at] {
                Mark::Done(place) => break place,
                Mark::Open => {
                    self.report_cycle(&path, at, out);
                    break None;
                }
                Mark::New => {}
            }
            self.marks[at] = Mark::Open;
            path.push(at);
            match self.base_of(at, out) {
                Ok(Some(next)) => at = next,
                Ok(None) => break Some(Rooted { root: None, nanos: 0 }),
                Err(()) => break None,
            }
        };
        // The base's own place, then what each link of the walk adds on the way back.
        while let Some(at) = path.pop() {
            place = place.and_then(|base| self.add(base, at));
            if place.is_some_and(|place| place.nanos.abs() > FURTHEST) {
                let node = self.node(at);
                out.bad(codes::STEP_TIME, node, "the instant is further than 100 years away", "");
                place = None;
            }
            self.marks[at] = Mark::Done(place);
        }
    }

    fn anchor(&self, at: usize) -> Option<&Anchor> {
        match self.written.get(at) {
            Some(written) => Some(&written.anchor),
            None => self.ends.map(|(anchor, _)| anchor),
        }
    }

    fn node(&self, at: usize) -> &Node {
        match (self.written.get(at), self.ends) {
            (Some(written), _) => written.node,
            (None, Some((_, node))) => node,
            // The end is followed only where the plan says it.
            (None, None) => self.written[0].node,
        }
    }

    /// What the instant at `at` hangs on: a step, the end, or nothing for `start`.
    fn base_of(&self, at: usize, out: &mut Findings) -> Result<Option<usize>, ()> {
        let Some(anchor) = self.anchor(at) else { return Err(()) };
        match (&anchor.base, anchor.base.step()) {
            (Base::End, _) if self.ends.is_some() => Ok(Some(self.steps.len())),
            (Base::End, _) => {
                let help = "say when the case ends, as in ends = \"start + 10 s\"";
                out.bad(codes::STEP_CYCLE, self.node(at), "the end of the case hangs on its steps", help);
                Err(())
            }
            // Unknown steps were reported when the text was read.
            (_, Some(id)) => self.places.get(id).copied().map(Some).ok_or(()),
            _ => Ok(None),
        }
    }

    /// The place of `at` when its base stands at `base`.
    fn add(&self, base: Rooted, at: usize) -> Option<Rooted> {
        let anchor = self.anchor(at)?;
        let mut place = base;
        if let Some(step) = anchor.base.step().and_then(|id| self.places.get(id).copied()) {
            // An awaited step is a root of its own.
            if matches!(self.steps[step].when, StepTime::When { .. }) {
                place = Rooted { root: Some(step), nanos: 0 };
            }
            place.nanos += i128::from(part(&self.steps[step].stimulus, &anchor.base).as_nanos());
        }
        place.nanos += i128::from(anchor.offset.as_nanos());
        place.nanos += self.written.get(at).map_or(0, |written| i128::from(written.phase));
        Some(place)
    }

    fn report_cycle(&self, path: &[usize], at: usize, out: &mut Findings) {
        let from = path.iter().position(|one| *one == at).unwrap_or(0);
        let name = |at: usize| self.steps.get(at).map_or("end", |step| step.id.as_str());
        let ring: Vec<&str> = path[from..].iter().take(8).map(|one| name(*one)).collect();
        let message = match ring.as_slice() {
            [one] => format!("`{one}` hangs on itself"),
            _ => format!("these hang on each other: {}", ring.join(", ")),
        };
        let mut found = Diagnostic::error(codes::STEP_CYCLE, message)
            .help("let one of them count from `start`, or from a step outside the circle");
        for one in path[from..].iter().take(8) {
            let what = format!("`{}` hangs on this", name(*one));
            found = found.at(out.file().to_owned(), self.node(*one).span.clone(), what);
        }
        out.push(found);
    }
}

/// How long after its step the named part of a stimulus is.
fn part(stimulus: &Stimulus, base: &Base) -> Span {
    match (base, stimulus) {
        (Base::StepDone(_), stimulus) => stimulus.duration(),
        (Base::Pulse { n, .. }, Stimulus::Train(train)) => train.rises(u32::try_from(*n).unwrap_or(u32::MAX)),
        _ => Span::ZERO,
    }
}

/// One second after the step that ends last, as far as that is known before the case runs.
fn default_end(steps: &[Step], places: &[Option<Rooted>]) -> Option<Rooted> {
    let done = |at: usize| -> Option<Rooted> {
        let lasts = i128::from(steps[at].stimulus.duration().as_nanos());
        match steps[at].when {
            StepTime::At(_) => places[at].map(|place| Rooted { nanos: place.nanos + lasts, ..place }),
            StepTime::When { .. } => Some(Rooted { root: Some(at), nanos: lasts }),
        }
    };
    let Some(last) = steps.len().checked_sub(1) else {
        return Some(Rooted { root: None, nanos: i128::from(AFTER_LAST.as_nanos()) });
    };
    let mut end = done(last)?;
    for at in 0..last {
        let other = done(at)?;
        if other.root == end.root && other.nanos > end.nanos {
            end = other;
        }
    }
    Some(Rooted { nanos: end.nanos + i128::from(AFTER_LAST.as_nanos()), ..end })
}

/// Reports steps before what they hang on and behind the end.
fn check(
    steps: &[Step],
    written: &[Written<'_>],
    places: &[Option<Rooted>],
    end: Rooted,
    ends_given: bool,
    out: &mut Findings,
) {
    for (at, step) in steps.iter().enumerate() {
        let Some(place) = places[at] else { continue };
        // Waiting may begin before anything happens.
        if place.nanos < 0 && matches!(step.when, StepTime::At(_)) {
            let root = place.root.map_or("start", |root| steps[root].id.as_str());
            let early = Span::from_nanos(i64::try_from(-place.nanos).unwrap_or(i64::MAX));
            let message = format!("the step `{}` would come {early} before `{root}`", step.id);
            let help = match place.root {
                None => "the case's stimuli begin at `start`",
                Some(_) => "nobody knows beforehand when it happens: count forwards from it",
            };
            out.bad(codes::STEP_BEFORE, written[at].node, message, help);
        } else if ends_given && place.root == end.root && place.nanos > end.nanos {
            let late = Span::from_nanos(i64::try_from(place.nanos - end.nanos).unwrap_or(i64::MAX));
            let message = format!("the step `{}` comes {late} after the end of the case", step.id);
            out.bad(codes::STEP_AFTER_END, written[at].node, message, "let the case end later: see `ends`");
        }
    }
    if end.nanos < 0 {
        let message = "the case would end before it begins";
        let place = written.first().map_or(0..0, |written| written.node.span.clone());
        out.error(codes::STEP_AFTER_END, place, message, "let `ends` count forwards");
    }
}

fn to_anchor(place: Rooted, ids: &[String]) -> Anchor {
    let base = place.root.map_or(Base::Start, |root| Base::Step(ids[root].clone()));
    // Held within 100 years above.
    Anchor { base, offset: Span::from_nanos(i64::try_from(place.nanos).unwrap_or(i64::MAX)) }
}

/// The longest that a case can take when every wait takes as long as it may.
fn allowance(steps: &[Step], end: Rooted) -> Span {
    let mut nanos = ALLOWANCE + end.nanos.max(0);
    for step in steps {
        nanos += i128::from(step.stimulus.duration().as_nanos());
        if let StepTime::When { within, from, .. } = &step.when {
            nanos += i128::from(within.as_nanos()) + i128::from(from.offset.as_nanos().max(0));
        }
    }
    Span::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
}
