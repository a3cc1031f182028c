//! When the steps of a case come: what depends on other steps is added up, and what cannot be is reported.

use std::collections::BTreeMap;

use document::{Diagnostic, Findings, Node};
use signal::Span;

use super::{PlanStep, StepRepeat, StepTime};
use crate::codes;
use crate::lang::{Anchor, AnchorBase};
use crate::steps::CasePart;
use crate::steps::Stimulus;

/// How long after its last step a case ends where the plan does not say.
pub const AFTER_LAST: Span = Span::from_secs(1);
/// Time for power-on and whatever else no plan adds up.
const ALLOWANCE: i128 = 60_000_000_000;
/// Furthest from its root that a step may lie: 100 years.
const FURTHEST: i128 = 100 * 366 * 86_400 * 1_000_000_000;

/// A step's time as written, with the value that says it.
pub(super) struct WrittenTime<'n> {
    /// The instant of an `at`, or the `from` of a `when`.
    pub(super) anchor: Anchor,
    /// Where it is written; the step's own table where it is left out.
    pub(super) node: &'n Node,
    /// Where the `until` of its `every` is written.
    pub(super) until: Option<&'n Node>,
    /// How much the phase of this case adds, nanoseconds.
    pub(super) phase: i64,
}

/// What is not known before the case runs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum TimeRoot {
    Start,
    Main,
    Teardown,
    /// The step at this place begins.
    Step(usize),
    /// It is done.
    Done(usize),
    /// It comes this time.
    Time(usize, u64),
}

impl TimeRoot {
    /// Its name for messages.
    fn name(self, steps: &[PlanStep]) -> String {
        self.base(&|at| steps[at].id.clone()).to_string()
    }

    fn base(self, id: &dyn Fn(usize) -> String) -> AnchorBase {
        match self {
            TimeRoot::Start => AnchorBase::Start,
            TimeRoot::Main => AnchorBase::Main,
            TimeRoot::Teardown => AnchorBase::Teardown,
            TimeRoot::Step(at) => AnchorBase::Step(id(at)),
            TimeRoot::Done(at) => AnchorBase::StepDone(id(at)),
            TimeRoot::Time(at, n) => AnchorBase::Occurrence { step: id(at), n },
        }
    }
}

/// A place in time: a root that is not known before the case runs, and a distance from it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RootedTime {
    root: TimeRoot,
    nanos: i128,
}

impl RootedTime {
    fn later(self, nanos: i128) -> RootedTime {
        RootedTime { nanos: self.nanos + nanos, ..self }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum VisitMark {
    New,
    Open,
    Done(Option<RootedTime>),
}

/// The times of a case.
pub(super) struct CaseTimes {
    /// Its end.
    pub(super) ends: Anchor,
    /// Place of the step that it counts from.
    pub(super) ends_from: Option<usize>,
    /// The time that it may take.
    pub(super) allowance: Span,
    /// The time that its teardown may take.
    pub(super) teardown: Span,
}

/// Rewrites the times of `steps` so that every instant depends on `start`, `main`, `teardown` or on a step of which
/// nobody knows beforehand when it comes, and gives the end of the case and the time that it may take. `ends` is what
/// the plan says, with the value that says it.
///
/// `None` after it reported what is wrong.
pub(super) fn resolve(
    steps: &mut [PlanStep],
    written: &[WrittenTime<'_>],
    ends: Option<(Anchor, &Node)>,
    out: &mut Findings,
) -> Option<CaseTimes> {
    let before = out.errors();
    let places = steps.iter().enumerate().map(|(at, step)| (step.id.as_str(), at)).collect();
    let mut chain = TimeChain {
        steps: &*steps,
        places,
        written,
        ends: ends.as_ref(),
        marks: vec![VisitMark::New; steps.len() + 1],
        setup: steps.iter().any(|step| step.part == CasePart::Setup),
    };
    for at in 0..=steps.len() {
        if at < steps.len() || ends.is_some() {
            chain.follow(at, out);
        }
    }
    if out.errors() > before {
        return None;
    }
    let places: Vec<Option<RootedTime>> = (0..=steps.len())
        .map(|at| match chain.marks[at] {
            VisitMark::Done(place) => place,
            _ => None,
        })
        .collect();
    let untils = chain.untils(&places, out);
    if out.errors() > before {
        return None;
    }
    let main = if chain.setup { TimeRoot::Main } else { TimeRoot::Start };
    let end = match &ends {
        Some(_) => places[steps.len()]?,
        None => default_end(steps, &places, &untils, main)?,
    };
    check(steps, written, &places, end, ends.is_some(), out);
    if out.errors() > before {
        return None;
    }
    let teardown = allowance(steps, &places, &untils, CasePart::Teardown);
    let main = allowance(steps, &places, &untils, CasePart::Main);
    let ids: Vec<String> = steps.iter().map(|step| step.id.clone()).collect();
    let mut base_of = |at: usize| chain.base_of(at, out).ok().flatten().filter(|base| *base < ids.len());
    let bases: Vec<Option<usize>> = (0..=ids.len()).map(&mut base_of).collect();
    let until_bases: Vec<Option<usize>> = (0..ids.len()).map(|at| chain.until_base(at, out)).collect();
    // An end that the plan does not say comes after the last step.
    let ends_from = match ends.is_some() {
        true => bases[ids.len()],
        false => (0..ids.len())
            .filter(|at| steps[*at].part == CasePart::Main)
            .filter(|at| places[*at].is_some_and(|place| place.root == end.root))
            .max_by_key(|at| places[*at].map(|place| place.nanos)),
    };
    for (at, step) in steps.iter_mut().enumerate() {
        let anchor = to_anchor(places[at]?, &ids);
        (step.counts_from, step.until_from) = (bases[at], until_bases[at]);
        match &mut step.when {
            StepTime::At(time) => *time = anchor,
            StepTime::When { from, .. } => {
                *from = Anchor { offset: anchor.offset.max(Span::ZERO), ..anchor };
            }
        }
        if let (Some(StepRepeat::Every { until: Some(until), .. }), Some(place)) =
            (&mut step.repeat, untils[at])
        {
            *until = to_anchor(place, &ids);
        }
    }
    let allowance = main + Span::from_nanos(i64::try_from(end.nanos.max(0)).unwrap_or(i64::MAX));
    Some(CaseTimes { ends: to_anchor(end, &ids), ends_from, allowance, teardown })
}

/// The chain of what depends on what. Every step depends on exactly one thing, so following is a walk, not a search.
struct TimeChain<'c, 'n> {
    steps: &'c [PlanStep],
    /// Place of each step by its id.
    places: BTreeMap<&'c str, usize>,
    written: &'c [WrittenTime<'n>],
    ends: Option<&'c (Anchor, &'n Node)>,
    /// One for each step, then one for the end.
    marks: Vec<VisitMark>,
    /// Whether the case has a setup.
    setup: bool,
}

impl TimeChain<'_, '_> {
    /// Settles what stands at `first` and all that it depends on.
    fn follow(&mut self, first: usize, out: &mut Findings) {
        let mut path: Vec<usize> = Vec::new();
        let mut at = first;
        let mut place = loop {
            match self.marks[at] {
                VisitMark::Done(place) => break place,
                VisitMark::Open => {
                    self.report_cycle(&path, at, out);
                    break None;
                }
                VisitMark::New => {}
            }
            self.marks[at] = VisitMark::Open;
            path.push(at);
            match self.base_of(at, out) {
                Ok(Some(next)) => at = next,
                Ok(None) => break Some(self.fixed(at)),
                Err(()) => break None,
            }
        };
        // The base's own place, then what each link of the walk adds on the way back.
        while let Some(at) = path.pop() {
            place = place.and_then(|base| self.add(base, at));
            if place.is_some_and(|place| place.nanos.abs() > FURTHEST) {
                let node = self.node(at);
                out.bad(
                    codes::STEP_TIME,
                    node,
                    "the instant is further than 100 years away",
                    "write an earlier one",
                );
                place = None;
            }
            self.marks[at] = VisitMark::Done(place);
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

    /// The part of the case that a place belongs to; the end of the case belongs to the steps proper.
    fn part(&self, at: usize) -> CasePart {
        self.steps.get(at).map_or(CasePart::Main, |step| step.part)
    }

    /// Where an instant stands that depends on no step.
    fn fixed(&self, at: usize) -> RootedTime {
        let root = match self.anchor(at).map(|anchor| &anchor.base) {
            Some(AnchorBase::Main) if self.setup => TimeRoot::Main,
            Some(AnchorBase::Teardown) => TimeRoot::Teardown,
            _ => TimeRoot::Start,
        };
        RootedTime { root, nanos: 0 }
    }

    /// What the instant at `at` depends on: a step, the end, or nothing for `start` and the like.
    fn base_of(&self, at: usize, out: &mut Findings) -> Result<Option<usize>, ()> {
        let Some(anchor) = self.anchor(at) else { return Err(()) };
        self.base_in(&anchor.base, self.part(at), self.node(at), out)
    }

    /// What a base is to something of a part of the case; reports what it cannot depend on.
    fn base_in(
        &self,
        base: &AnchorBase,
        part: CasePart,
        node: &Node,
        out: &mut Findings,
    ) -> Result<Option<usize>, ()> {
        let step = base.step().map(|id| self.places.get(id).copied());
        let of = step.flatten().map(|step| self.steps[step].part);
        let possible = match (part, base, of) {
            (CasePart::Setup, AnchorBase::Start, _)
            | (CasePart::Main, AnchorBase::Start | AnchorBase::Main | AnchorBase::End, _) => true,
            (CasePart::Teardown, AnchorBase::Teardown, _) => true,
            (CasePart::Main, _, Some(of)) => of != CasePart::Teardown,
            (part, _, Some(of)) => of == part,
            // Unknown steps were reported when the text was read.
            (.., None) => step.is_some(),
        };
        if !possible {
            let (message, help) = match part {
                CasePart::Setup => (
                    "the setup depends on what comes after it",
                    "count from `start` or from a step of the setup",
                ),
                CasePart::Main => (
                    "the steps of the case depend on its teardown",
                    "count from `start`, `main` or from a step of the case",
                ),
                CasePart::Teardown => (
                    "the teardown depends on a step that may never have come",
                    "count from `teardown` or from a step of the teardown",
                ),
            };
            out.bad(codes::PHASE, node, message, help);
            return Err(());
        }
        match (base, step) {
            (AnchorBase::End, _) if self.ends.is_some() => Ok(Some(self.steps.len())),
            (AnchorBase::End, _) => {
                let help = "say when the case ends, as in ends = \"start + 10 s\"";
                out.bad(codes::STEP_CYCLE, node, "the end of the case depends on its steps", help);
                Err(())
            }
            (_, Some(step)) => step.map(Some).ok_or(()),
            _ => Ok(None),
        }
    }

    /// The place of `at` when its base stands at `base`.
    fn add(&self, base: RootedTime, at: usize) -> Option<RootedTime> {
        let place = self.from(base, self.anchor(at)?);
        Some(place.later(self.written.get(at).map_or(0, |written| i128::from(written.phase))))
    }

    /// The place of an instant when its base stands at `base`.
    fn from(&self, base: RootedTime, anchor: &Anchor) -> RootedTime {
        let mut place = base;
        if let Some(at) = anchor.base.step().and_then(|id| self.places.get(id).copied()) {
            let step = &self.steps[at];
            let waits = matches!(step.when, StepTime::When { .. });
            // What nobody knows beforehand is a root of its own.
            let root = match (&anchor.base, &step.repeat) {
                (
                    AnchorBase::Occurrence { n, .. },
                    Some(StepRepeat::Each { .. } | StepRepeat::Every { until: Some(_), .. }),
                ) => Some(TimeRoot::Time(at, *n)),
                (
                    AnchorBase::StepDone(_),
                    Some(StepRepeat::Each { .. } | StepRepeat::Every { until: Some(_), .. }),
                ) => Some(TimeRoot::Done(at)),
                (AnchorBase::StepDone(_), _) if matches!(step.stimulus, Stimulus::Run { .. }) => {
                    Some(TimeRoot::Done(at))
                }
                _ if waits => Some(TimeRoot::Step(at)),
                _ => None,
            };
            let parted = !matches!(root, Some(TimeRoot::Done(_) | TimeRoot::Time(..)));
            if let Some(root) = root {
                place = RootedTime { root, nanos: 0 };
            }
            if parted {
                place.nanos += i128::from(part(step, &anchor.base).as_nanos());
            }
        }
        place.later(i128::from(anchor.offset.as_nanos()))
    }

    /// Where the steps that come up to an instant end.
    fn untils(&self, places: &[Option<RootedTime>], out: &mut Findings) -> Vec<Option<RootedTime>> {
        let mut untils = vec![None; self.steps.len()];
        for (at, step) in self.steps.iter().enumerate() {
            let Some(StepRepeat::Every { until: Some(until), period, .. }) = &step.repeat else { continue };
            let node = self.written[at].until.unwrap_or(self.written[at].node);
            if until.base.step() == Some(step.id.as_str()) {
                out.bad(
                    codes::STEP_CYCLE,
                    node,
                    "the step comes until it has come",
                    "count from something else",
                );
                continue;
            }
            let Ok(base) = self.base_in(&until.base, step.part, node, out) else { continue };
            let fixed = match until.base {
                AnchorBase::Main if self.setup => TimeRoot::Main,
                AnchorBase::Teardown => TimeRoot::Teardown,
                _ => TimeRoot::Start,
            };
            let base = base.map_or(Some(RootedTime { root: fixed, nanos: 0 }), |base| places[base]);
            let Some(place) = base.map(|base| self.from(base, until)) else { continue };
            untils[at] = Some(place);
            let Some(from) = places[at].filter(|from| from.root == place.root) else { continue };
            let times = (place.nanos - from.nanos) / i128::from(period.as_nanos().max(1));
            let most = i128::from(step.repeat.as_ref().map_or(0, StepRepeat::times));
            if place.nanos <= from.nanos {
                let message = "the step would never come: `until` is not later than `at`";
                out.bad(
                    codes::REPEAT,
                    node,
                    message,
                    "write an `until` after `at`, as in until = \"start + 10 s\"",
                );
            } else if times >= most {
                let message = format!("the step would come {times} times; {most} is the most");
                out.bad(codes::REPEAT, node, message, "a train has many pulses");
            }
        }
        untils
    }

    /// The step that the `until` of a repetition counts from.
    fn until_base(&self, at: usize, out: &mut Findings) -> Option<usize> {
        let step = &self.steps[at];
        let Some(StepRepeat::Every { until: Some(until), .. }) = &step.repeat else { return None };
        let node = self.written[at].until.unwrap_or(self.written[at].node);
        self.base_in(&until.base, step.part, node, out).ok().flatten().filter(|base| *base < self.steps.len())
    }

    fn report_cycle(&self, path: &[usize], at: usize, out: &mut Findings) {
        let from = path.iter().position(|one| *one == at).unwrap_or(0);
        let name = |at: usize| self.steps.get(at).map_or("end", |step| step.id.as_str());
        let ring: Vec<&str> = path[from..].iter().take(8).map(|one| name(*one)).collect();
        let message = match ring.as_slice() {
            [one] => format!("`{one}` depends on itself"),
            _ => format!("these depend on each other: {}", ring.join(", ")),
        };
        let mut found = Diagnostic::error(codes::STEP_CYCLE, message)
            .help("let one of them count from `start`, or from a step outside the circle");
        for one in path[from..].iter().take(8) {
            let what = format!("`{}` depends on this", name(*one));
            found = found.at(out.file().to_owned(), self.node(*one).span.clone(), what);
        }
        out.push(found);
    }
}

/// How long after its step the named part of it is.
pub(super) fn part(step: &PlanStep, base: &AnchorBase) -> Span {
    match (base, &step.stimulus) {
        (AnchorBase::StepDone(_), _) => lasts(step),
        (AnchorBase::Pulse { n, .. }, Stimulus::Train(train)) => {
            train.rises(u32::try_from(*n).unwrap_or(u32::MAX))
        }
        (AnchorBase::Occurrence { n, .. }, _) => {
            step.repeat.as_ref().and_then(|repeat| repeat.after(*n)).unwrap_or(Span::ZERO)
        }
        _ => Span::ZERO,
    }
}

/// How long after its beginning a step is done, with every time that it comes, as far as that is known.
fn lasts(step: &PlanStep) -> Span {
    let again = step.repeat.as_ref().and_then(|repeat| repeat.after(repeat.times())).unwrap_or(Span::ZERO);
    again + step.stimulus.duration()
}

/// When a step is done at the latest, as far as that is known before the case runs.
fn done(
    at: usize,
    step: &PlanStep,
    places: &[Option<RootedTime>],
    untils: &[Option<RootedTime>],
) -> Option<RootedTime> {
    let duration = i128::from(step.stimulus.duration().as_nanos());
    let place = places[at]?;
    Some(match (&step.when, &step.repeat) {
        (StepTime::When { within, .. }, Some(StepRepeat::Each { .. })) => {
            place.later(i128::from(within.as_nanos()) + duration)
        }
        (StepTime::When { .. }, _) => RootedTime { root: TimeRoot::Step(at), nanos: duration },
        (StepTime::At(_), Some(StepRepeat::Every { until: Some(_), .. })) => untils[at]?.later(duration),
        (StepTime::At(_), _) => place.later(i128::from(lasts(step).as_nanos())),
    })
}

/// One second after the step that ends last, as far as that is known before the case runs.
fn default_end(
    steps: &[PlanStep],
    places: &[Option<RootedTime>],
    untils: &[Option<RootedTime>],
    main: TimeRoot,
) -> Option<RootedTime> {
    let after = i128::from(AFTER_LAST.as_nanos());
    let mut proper = steps.iter().enumerate().filter(|(_, step)| step.part == CasePart::Main);
    let Some((last, step)) = proper.clone().next_back() else {
        return Some(RootedTime { root: main, nanos: after });
    };
    let mut end = done(last, step, places, untils)?;
    let first = proper.try_fold(end, |end: RootedTime, (at, step)| {
        let other = done(at, step, places, untils)?;
        Some(if other.root == end.root && other.nanos > end.nanos { other } else { end })
    });
    end = first?;
    Some(end.later(after))
}

/// Reports steps before what they depend on and after the end.
fn check(
    steps: &[PlanStep],
    written: &[WrittenTime<'_>],
    places: &[Option<RootedTime>],
    end: RootedTime,
    ends_given: bool,
    out: &mut Findings,
) {
    // The setup lasts this long at least.
    let setup = steps.iter().zip(places).filter(|(step, _)| step.part == CasePart::Setup);
    let setup = setup.filter_map(|(step, place)| {
        let waits = matches!(step.when, StepTime::When { .. });
        let place = (*place)?;
        (place.root == TimeRoot::Start && !waits).then(|| place.nanos + i128::from(lasts(step).as_nanos()))
    });
    let setup = setup.max().unwrap_or(0);
    for (at, step) in steps.iter().enumerate() {
        let Some(place) = places[at] else { continue };
        let waits = matches!(step.when, StepTime::When { .. });
        let least = if step.part == CasePart::Main && place.root == TimeRoot::Start { setup } else { 0 };
        // Waiting may begin before anything happens.
        if place.nanos < least && !waits {
            let root = if least > 0 { "main".to_owned() } else { place.root.name(steps) };
            let early = Span::from_nanos(i64::try_from(least - place.nanos).unwrap_or(i64::MAX));
            let message = format!("the step `{}` would come {early} before `{root}`", step.id);
            let help = match place.root {
                TimeRoot::Start if least > 0 => "the steps wait for the setup: count from `main`",
                TimeRoot::Start => "the case's stimuli begin at `start`",
                TimeRoot::Main | TimeRoot::Teardown => "count forwards",
                _ => "nobody knows beforehand when it happens: count forwards from it",
            };
            out.bad(codes::STEP_BEFORE, written[at].node, message, help);
        } else if ends_given
            && step.part == CasePart::Main
            && place.root == end.root
            && place.nanos > end.nanos
        {
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

fn to_anchor(place: RootedTime, ids: &[String]) -> Anchor {
    let base = place.root.base(&|at| ids[at].clone());
    // Held within 100 years above.
    Anchor { base, offset: Span::from_nanos(i64::try_from(place.nanos).unwrap_or(i64::MAX)) }
}

/// The longest that the teardown can take when every wait takes as long as it may, or what stands before it apart from
/// the end itself.
fn allowance(
    steps: &[PlanStep],
    places: &[Option<RootedTime>],
    untils: &[Option<RootedTime>],
    part: CasePart,
) -> Span {
    let mut nanos = ALLOWANCE;
    for (at, step) in steps.iter().enumerate() {
        if (step.part == CasePart::Teardown) != (part == CasePart::Teardown) {
            continue;
        }
        let place = places[at].map_or(0, |place| place.nanos.max(0));
        nanos += i128::from(lasts(step).as_nanos());
        nanos += untils[at].map_or(0, |until| until.nanos.max(0));
        if let StepTime::When { within, .. } = &step.when {
            nanos += i128::from(within.as_nanos()) + place;
        } else if part == CasePart::Teardown || step.part == CasePart::Setup {
            nanos += place;
        }
    }
    Span::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
}
