//! `profile`: the frequency of a pulse train follows a shape over time.
//!
//! ```toml
//! { profile = { signal = "A", direction = "B", move = { by = 4000, speed = "20 kHz", acceleration = "500 Hz/ms" },
//!     tolerance = "100 Hz", within = "1 ms", from = "go" } }
//! { profile = { signal = "A", points = [{ at = "0 ms", frequency = "1 kHz" }, { at = "1 s", frequency = "5 kHz" }],
//!     tolerance = "50 Hz", from = "go", until = "go + 2 s" } }
//! ```
//! What it means to follow stands in [`crate::monitor::course`]. A window without a count fails the claim.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{Quantity, SignalInfo, Span, Unit};

use super::common::{FROM, LONGER, PlanWindow, UNTIL, count_range, delay_words};
use super::shape::{MOVE, POINTS};
use super::train::{BACKWARDS, DIRECTION, INVERTED, PULSES, QUADRATURE, TrainLines};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim, shape};
use crate::codes;
use crate::lang::Anchor;
use crate::monitor::shape::FrequencyShape;
use crate::monitor::shape_follower::{DecidingStretch, ShapeFollower, ShapeLimits, ShapeResult};
use crate::monitor::track::{PositionTrack, TrackStep};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, Number, PulseRule, TimedValue, TraceSignals, UncertainWindow,
};

/// How far off in time.
const WITHIN: KeySpec = KeySpec::optional(
    "within",
    KeyType::Duration,
    "By how much an instant of the shape may be off; not at all if left out",
);
/// How long a stretch.
const OVER: KeySpec = KeySpec::optional(
    "over",
    KeyType::Duration,
    "The frequency is a mean over stretches at least this long; from each pulse to the next if left out",
);

/// The keys that `profile` and its measurement share.
pub(crate) const KEYS: &[KeySpec] =
    &[PULSES, DIRECTION, INVERTED, BACKWARDS, QUADRATURE, POINTS, MOVE, WITHIN, OVER, LONGER];

/// `profile`.
pub(super) const PROFILE: ExpectVerb = ExpectVerb {
    name: "profile",
    doc: "The frequency of a pulse train follows a shape over time",
    keys: &[
        PULSES,
        DIRECTION,
        INVERTED,
        BACKWARDS,
        QUADRATURE,
        POINTS,
        MOVE,
        KeySpec::required(
            "tolerance",
            KeyType::Text,
            "By how much the frequency may be off, as in \"100 Hz\", or a part of the highest one, as in \"2 %\"",
        ),
        WITHIN,
        OVER,
        FROM,
        UNTIL,
        LONGER,
    ],
    read,
};

/// A train and the shape that it should have.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapedTrain {
    pub(crate) train: TrainLines,
    shape: FrequencyShape,
    within: Span,
    over: Span,
}

impl ShapedTrain {
    /// Reads [`KEYS`].
    pub(crate) fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<ShapedTrain> {
        let train = TrainLines::read(fields, cx);
        let shape = shape::read(fields, cx);
        let duration = |key| fields.duration(key).unwrap_or(Span::ZERO);
        let (within, over) = (duration("within"), duration("over"));
        Some(ShapedTrain { train: train?, shape: shape?, within, over })
    }

    /// Finds what cannot be followed.
    pub(crate) fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        self.train.check(wiring, out);
        let known = wiring.find(&self.train.signal);
        if self.shape.turns() && known.is_some_and(|info| !self.train.is_signed(info)) {
            let message = format!("the shape goes backwards, and `{}` has no direction", self.train.signal);
            let help = "add `direction`, `backwards` or `quadrature`";
            out.push(Diagnostic::error(codes::SHAPE, message).help(help));
        }
    }

    /// Starts following it. `from` is where its shape begins.
    pub(crate) fn follow(
        &self,
        scene: &CaseTimeline<'_>,
        from: &Anchor,
        until: &Anchor,
    ) -> Result<ShapeMeasurement, NotJudged> {
        if !scene.clock.error.is_none() {
            let why =
                "a shape of true time is not held against a clock that may be off: leave `clock-error` out";
            return Err(NotJudged::NoMeaning(why.to_owned()));
        }
        let window = scene.window(from, until)?;
        let info = scene.signal(&self.train.signal)?;
        let held = ShapeLimits {
            shape: self.shape.clone(),
            within: self.within.as_nanos(),
            over: self.over.as_nanos(),
            signed: self.train.is_signed(info),
            coarse: self.train.is_coarse(info),
        };
        let track = self.train.track(scene)?;
        Ok(ShapeMeasurement { track, course: ShapeFollower::new(held, scene.point(from)?, window), window })
    }
}

/// Follows a train along its shape.
#[derive(Debug)]
pub struct ShapeMeasurement {
    track: PositionTrack,
    course: ShapeFollower,
    window: UncertainWindow,
}

impl ShapeMeasurement {
    /// The next event of a line.
    #[inline]
    pub(crate) fn see(&mut self, slot: usize, seen: &TimedValue) {
        let course = &mut self.course;
        self.track.see(slot, seen, |step| taken(course, step));
    }

    /// What it came to, and its window.
    pub(crate) fn finish(mut self) -> (ShapeResult, UncertainWindow) {
        let course = &mut self.course;
        self.track.finish(|step| taken(course, step));
        (self.course.finish(), self.window)
    }
}

fn taken(course: &mut ShapeFollower, step: TrackStep) {
    match step {
        TrackStep::Count(count) => course.see(&count),
        TrackStep::Unknown(seen) => course.unknown(&seen),
    }
}

/// The claim.
#[derive(Clone, Debug)]
struct ProfileClaim {
    shaped: ShapedTrain,
    tolerance: f64,
    between: PlanWindow,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let shaped = ShapedTrain::read(fields, cx);
    let between = PlanWindow::read(fields, cx);
    let shaped = shaped?;
    let node = fields.get("tolerance")?;
    let quantity = node.as_text().and_then(|text| Quantity::parse(text).ok());
    let tolerance = quantity.and_then(|quantity| match quantity.is_part() {
        true => Some(quantity.in_unit(&Unit::new("%"))?.as_f64() / 100.0 * shaped.shape.highest()),
        false => Some(quantity.in_unit(&Unit::new("Hz"))?.as_f64()),
    });
    let Some(tolerance) = tolerance.filter(|tolerance| *tolerance > 0.0) else {
        let message = "`tolerance` is no tolerance of a frequency";
        let help = "a frequency above 0, as in \"100 Hz\", or a part of the highest one, as in \"2 %\"";
        cx.out.bad(codes::SHAPE, node, message, help);
        return None;
    };
    if tolerance >= shaped.shape.highest() {
        let message = "no pulse at all would be within the tolerance";
        cx.out.bad(codes::CLAIM, node, message, "give it less than the highest frequency of the shape");
        return None;
    }
    Some(Arc::new(ProfileClaim { shaped, tolerance, between: between? }))
}

impl TraceClaim for ProfileClaim {
    fn expected(&self) -> String {
        let within = match self.shaped.within {
            Span::ZERO => String::new(),
            within => format!(" and {within}"),
        };
        let tolerance = Figure::new(self.tolerance, "Hz");
        let train = self.shaped.train.words();
        format!(
            "the frequency of {train} follows its shape to within {tolerance}{within}{}",
            self.between.words()
        )
    }

    fn signals(&self) -> Vec<String> {
        self.shaped.train.signals()
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        self.shaped.check(wiring, out);
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        let mut demands = self.shaped.train.demands();
        demands.extend([ClaimDemand::Change(&self.shaped.train.signal), self.between.demand()]);
        demands
    }

    fn counts(&self) -> Option<f64> {
        Some(0.0)
    }

    fn pulses(&self, info: &SignalInfo) -> PulseRule {
        self.shaped.train.pulses(info)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let following = self.shaped.follow(scene, &self.between.from, &self.between.until)?;
        Ok(Box::new(ProfileMonitor { claim: self.clone(), following }))
    }
}

/// The judge.
struct ProfileMonitor {
    claim: ProfileClaim,
    following: ShapeMeasurement,
}

impl Monitor for ProfileMonitor {
    #[inline]
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        self.following.see(slot, seen);
    }

    fn finish(self: Box<Self>) -> Finding {
        let ProfileMonitor { claim, following } = *self;
        let (found, window) = following.finish();
        let open = found.doubtful;
        let (best, worst) = found.needed;
        let none = found.counts.1 == 0;
        let mut finding = Finding {
            can_hold: open || best <= claim.tolerance && !none,
            can_break: open || worst > claim.tolerance || found.counts.0 == 0,
            window: Some(window.shown()),
            ..Finding::default()
        };
        let counts = count_range(found.counts);
        let noun = if found.counts.1 == 1 { "count" } else { "counts" };
        finding.observed = match none {
            true => format!("no count{}", claim.between.words()),
            false => format!("{} over {counts} {noun}", off((best, worst))),
        };
        let deciding = if finding.can_hold { found.deciding[1] } else { found.deciding[0] };
        finding.reason = match (finding.can_hold, deciding) {
            (true, _) if found.doubtful => String::from("a signal is not known for a part of the window"),
            (true, _) => String::from("the uncertainty of the instants reaches over a limit"),
            (false, _) if none => String::from("nothing counted in the window"),
            (false, Some(deciding)) => words(&deciding, &claim.between.from),
            (false, None) => String::new(),
        };
        if none {
            return finding;
        }
        if worst.is_finite() {
            finding.margin = Some(Figure::new(claim.tolerance - worst, "Hz"));
        }
        let spread = worst - best;
        finding.uncertainty = (spread > 0.0 && spread.is_finite()).then(|| Figure::new(spread, "Hz"));
        match deciding.and_then(|deciding| deciding.until.or(deciding.from)) {
            Some(seen) => finding.decided_by(&seen),
            None => finding,
        }
    }
}

/// `12 Hz off`, `at least 12 Hz off`, `12 Hz .. 30 Hz off`.
fn off((best, worst): (f64, f64)) -> String {
    match worst.is_finite() {
        true => format!("{} off", super::band::shown((Number::Real(best), Number::Real(worst)), "Hz")),
        false => format!("at least {} off", Figure::new(best, "Hz")),
    }
}

/// `3 counts in 1 ms (3000 Hz) from 20 ms after go on, at most 2.1 (2100 Hz) by the shape`.
fn words(deciding: &DecidingStretch, from: &Anchor) -> String {
    let DecidingStretch { length, begins, counts, many, due, .. } = *deciding;
    let noun = if counts == 1 { "count" } else { "counts" };
    let way = if deciding.backwards { " backwards" } else { "" };
    let span = |nanos: f64| Span::from_nanos(libm::round(nanos) as i64);
    let rate = |counts: f64| Figure::new(libm::round(counts / length * 1e12) / 1e3, "Hz");
    let begin = span(begins).as_nanos();
    let due = libm::round(due * 1e3) / 1e3;
    let (bound, lone) = if many { ("at most", "") } else { ("at least", "only ") };
    format!(
        "{lone}{counts} {noun}{way} in {} ({}) from {} on, {bound} {due} ({}) by the shape",
        span(length),
        rate(counts as f64),
        delay_words((begin, begin), from),
        rate(due),
    )
}
