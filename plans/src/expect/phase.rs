//! `phase`: how far one periodic signal comes after another, as an angle of the other's cycle.
//!
//! ```toml
//! { phase = { of = "b", reference = "a", is = "90 deg ± 10 deg", from = "run" } }
//! ```
//! Every whole cycle of `reference` in the window is judged: the first edge of `of` at or after its beginning comes at
//! the angle. -10 deg and 350 deg are one. A cycle in which `of` has no edge fails the claim, and so does a window
//! without a whole cycle.

use std::collections::VecDeque;
use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span};

use super::band::{FigureBand, IS_RANGE, shown, spread};
use super::common::{FROM, LONGER, PlanWindow, UNTIL, delay_words, signal};
use super::condition::{MAX, MIN};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::codes;
use crate::lang::Anchor;
use crate::monitor::edges::{CountedEdge, EdgeFinder, LAST};
use crate::monitor::{
    CaseTimeline, Extent, Finding, Monitor, NotJudged, Number, PulseRule, TimedValue, TraceSignals,
    UncertainWindow, distance, slack, widened,
};

/// `phase`.
pub(super) const PHASE: ExpectVerb = ExpectVerb {
    name: "phase",
    doc: "One periodic signal lags another by an angle of the other's cycle, in every cycle of a window",
    keys: &[
        KeySpec::required("of", KeyType::SignalRef, "The signal whose edges are looked for"),
        KeySpec::required("reference", KeyType::SignalRef, "The signal whose cycles they are looked for in")
            .was("behind"),
        IS_RANGE,
        MIN,
        MAX,
        KeySpec::optional(
            "edge",
            KeyType::Choice(&["rises", "falls"]),
            "Which edges of both; `rises` if left out",
        ),
        FROM,
        UNTIL,
        LONGER,
    ],
    read,
};

/// Most edges that wait for those of the other signal. Beyond it the answer is left open.
const MOST: usize = 256;

/// The claim.
#[derive(Clone, Debug)]
struct PhaseClaim {
    of: String,
    reference: String,
    by_falls: bool,
    band: FigureBand,
    between: PlanWindow,
    longer_than: Option<Span>,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let (of, reference) = (signal(fields, "of", cx), signal(fields, "reference", cx));
    let between = PlanWindow::read(fields, cx);
    let band = FigureBand::read(fields, "phase", "deg", cx)?;
    let (of, reference) = (of?, reference?);
    if of == reference {
        let node = fields.get("reference")?;
        cx.out.bad(codes::CLAIM, node, format!("`{of}` is compared with itself"), "name another signal");
        return None;
    }
    let less_than_a_turn = band.limits.min.zip(band.limits.max).is_some_and(|(min, max)| {
        !min.is_below(Number::Int(-360)) && !max.is_above(Number::Int(360)) && distance(min, max) < 360.0
    });
    if !less_than_a_turn {
        let node = ["is", "min", "max"].into_iter().find_map(|key| fields.get(key))?;
        let message =
            "an angle of a cycle lies between -360 deg and 360 deg, and less than a turn is allowed";
        cx.out.bad(codes::CLAIM, node, message, "give both limits, as in is = \"90 deg ± 10 deg\"");
        return None;
    }
    let by_falls = fields.text("edge") == Some("falls");
    let longer_than = fields.duration(LONGER.name);
    Some(Arc::new(PhaseClaim { of, reference, by_falls, band, between: between?, longer_than }))
}

impl TraceClaim for PhaseClaim {
    fn expected(&self) -> String {
        let PhaseClaim { of, reference, band, between, .. } = self;
        format!("`{of}` lags `{reference}` by {band} in every cycle{}", between.words())
    }

    fn signals(&self) -> Vec<String> {
        vec![self.of.clone(), self.reference.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        super::known(&self.of, wiring, out);
        super::known(&self.reference, wiring, out);
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        vec![
            ClaimDemand::Differ(&self.of, &self.reference),
            ClaimDemand::Change(&self.of),
            ClaimDemand::Change(&self.reference),
            self.between.demand(),
        ]
    }

    fn counts(&self) -> Option<f64> {
        Some(0.0)
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::decides(self.longer_than)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let window = scene.window(&self.between.from, &self.between.until)?;
        let side = |name: &String| {
            let info = scene.signal(name)?.clone();
            let edge = if self.by_falls { CountedEdge::Falls } else { CountedEdge::Rises };
            let finder = EdgeFinder::new(edge, slack(&info));
            let (lag, edges, unknown) = (scene.lag(name), VecDeque::new(), VecDeque::new());
            Ok(PhaseSignal { info, finder, lag, edges, unknown, reached: i64::MIN })
        };
        let (of, reference) = (side(&self.of)?, side(&self.reference)?);
        let answer = PhaseResult::default();
        Ok(Box::new(PhaseMonitor { claim: self.clone(), window, of, reference, answer }))
    }
}

/// One of the signals.
struct PhaseSignal {
    info: SignalInfo,
    finder: EdgeFinder,
    /// How far after the newest event of the trace one of this signal can begin, nanoseconds.
    lag: i64,
    edges: VecDeque<TimedValue>,
    /// Stretches of which nothing is known that are over, from their earliest beginning to their latest end.
    unknown: VecDeque<(i64, i64)>,
    /// No later event of the signal begins before this.
    reached: i64,
}

impl PhaseSignal {
    /// A stretch of which nothing is known is over. The oldest ones are taken together where there are too many.
    fn known_again(&mut self, stretch: &TimedValue) {
        self.unknown.push_back((stretch.a, stretch.b));
        if self.unknown.len() > MOST
            && let (Some(first), Some(second)) = (self.unknown.pop_front(), self.unknown.front_mut())
        {
            second.0 = second.0.min(first.0);
        }
    }

    /// Whether its edges between these instants may not all be known. It has been followed up to the later one.
    fn is_unknown(&self, (from, until): (i64, i64)) -> bool {
        let lasts = self.finder.rest().map(|rest| (rest.seen.a, i64::MAX));
        self.unknown.iter().copied().chain(lasts).any(|(begin, end)| begin < until && end > from)
    }
}

/// What the cycles came to so far.
#[derive(Default)]
struct PhaseResult {
    cycles: u64,
    wrong: bool,
    open: bool,
    doubtful: bool,
    /// Least and greatest angle.
    extent: Option<Extent>,
    /// The cycle farthest outside, or nearest to a limit.
    deciding: Option<(f64, Extent, TimedValue)>,
    /// The beginning of a cycle in which nothing came.
    empty: Option<TimedValue>,
}

/// The judge.
struct PhaseMonitor {
    claim: PhaseClaim,
    window: UncertainWindow,
    of: PhaseSignal,
    reference: PhaseSignal,
    answer: PhaseResult,
}

/// The turn in which the edge of a cycle is looked for: half a turn to either side of the middle of the limits, so
/// that one that comes a little early is not taken for that of the cycle before.
struct PhaseTurn {
    /// Earliest and latest beginning and end, nanoseconds.
    begin: (i64, i64),
    end: (i64, i64),
    /// Least and greatest length of the cycle.
    length: (i64, i64),
}

impl PhaseTurn {
    fn of(start: &TimedValue, end: &TimedValue, band: &FigureBand) -> PhaseTurn {
        let length = (end.a.saturating_sub(start.b).max(1), end.b.saturating_sub(start.a).max(1));
        // Both limits are there: the reader wants them.
        let end = |limit: Option<Number>| limit.map_or(0.0, Number::as_real);
        let shift = (end(band.limits.min) + end(band.limits.max)) / 720.0 - 0.5;
        let shifts = [shift * length.0 as f64, shift * length.1 as f64];
        // Whole nanoseconds, to the safe side.
        let least = libm::floor(shifts[0].min(shifts[1])) as i64;
        let most = libm::ceil(shifts[0].max(shifts[1])) as i64;
        let begin = (start.a.saturating_add(least), start.b.saturating_add(most));
        let end = (begin.0.saturating_add(length.0), begin.1.saturating_add(length.1));
        PhaseTurn { begin, end, length }
    }

    /// Least and greatest angle of an edge after the beginning of the cycle.
    fn angle(&self, start: &TimedValue, edge: &TimedValue) -> (f64, f64) {
        let delay = (edge.a.saturating_sub(start.b), edge.b.saturating_sub(start.a));
        let angle = |delay: i64, length: i64| delay as f64 * 360.0 / length as f64;
        let both = |delay: i64| (angle(delay, self.length.0), angle(delay, self.length.1));
        let (low, high) = (both(delay.0), both(delay.1));
        (low.0.min(low.1), high.0.max(high.1))
    }
}

impl PhaseMonitor {
    /// Judges the cycles that nothing new can come into.
    fn advance(&mut self, over: bool) {
        while let (Some(start), Some(end)) = (self.reference.edges.front(), self.reference.edges.get(1)) {
            let (start, end) = (*start, *end);
            let turn = PhaseTurn::of(&start, &end, &self.claim.band);
            if !over && self.of.reached <= turn.end.1 {
                break;
            }
            self.cycle(&start, &end, &turn);
            self.reference.edges.pop_front();
        }
    }

    fn cycle(&mut self, start: &TimedValue, end: &TimedValue, turn: &PhaseTurn) {
        if !self.window.can_hold(start) || !self.window.can_hold(end) {
            return;
        }
        let certain = self.window.must_hold(start) && self.window.must_hold(end);
        // The turn may reach out of the window.
        self.answer.doubtful |= self.of.is_unknown((turn.begin.0, turn.end.1));
        // Each edge that can be the first one of the turn.
        let mut left = turn.begin.0;
        let (mut can_hold, mut can_break, mut is_there) = (false, false, false);
        let mut some = false;
        for edge in &self.of.edges {
            if edge.a >= turn.end.1 {
                break;
            }
            if left > turn.begin.1.min(edge.b) {
                continue;
            }
            some = true;
            let angle = turn.angle(start, edge);
            let extent = (Number::Real(angle.0), Number::Real(angle.1));
            let (holds, breaks) = self.claim.band.hold(extent);
            can_hold |= holds;
            can_break |= breaks;
            self.answer.extent = Some(widened(self.answer.extent, extent));
            let margin = self.claim.band.margin(extent).unwrap_or(f64::INFINITY);
            if self.answer.deciding.is_none_or(|(least, ..)| margin < least) {
                self.answer.deciding = Some((margin, extent, *edge));
            }
            left = edge.a.saturating_add(1);
            if edge.a >= turn.begin.1 {
                is_there = edge.b < turn.end.0;
                break;
            }
        }
        if !some {
            self.answer.empty.get_or_insert(*start);
        }
        self.answer.cycles += u64::from(certain);
        self.answer.open |= can_break || !is_there;
        self.answer.wrong |= certain && !can_hold;
    }

    fn unknown(&mut self, seen: &TimedValue) {
        self.answer.doubtful |= self.window.can_hold(seen);
    }
}

impl Monitor for PhaseMonitor {
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        for side in [&mut self.of, &mut self.reference] {
            side.reached = side.reached.max(seen.a.saturating_sub(side.lag));
        }
        let side = if slot == 0 { &mut self.of } else { &mut self.reference };
        side.reached = side.reached.max(seen.a);
        match side.finder.see(seen) {
            Some(found) if found.certain => {
                side.edges.push_back(*seen);
                if side.edges.len() > MOST {
                    let oldest = side.edges.pop_front().map_or(i64::MIN, |edge| edge.b);
                    let waiting = self.reference.edges.front().map_or(i64::MAX, |start| start.a);
                    // An edge that lies well before every cycle that waits is none of theirs.
                    self.answer.doubtful |= slot == 1 || waiting <= oldest;
                }
                self.advance(false);
            }
            Some(found) => {
                side.known_again(&found.seen);
                self.unknown(&found.seen);
            }
            None => {}
        }
    }

    fn finish(mut self: Box<Self>) -> Finding {
        for rest in [self.of.finder.rest(), self.reference.finder.rest()].into_iter().flatten() {
            self.unknown(&TimedValue { place: LAST, ..rest.seen });
        }
        self.advance(true);
        let PhaseMonitor { claim, window, of, answer, .. } = *self;
        let open = answer.doubtful;
        let none = answer.cycles == 0;
        let mut finding = Finding {
            can_hold: open || !answer.wrong && answer.extent.is_some(),
            can_break: open || answer.open || none,
            window: Some(window.shown()),
            ..Finding::default()
        };
        let unclear = match answer.doubtful {
            true => String::from("a signal is not known for a part of the window"),
            false => String::from("the uncertainty of the instants reaches over a limit"),
        };
        finding.observed = match answer.extent {
            Some(extent) => format!("{} over {} cycles", shown(extent, "deg"), answer.cycles),
            None if none => format!("no whole cycle of `{}`{}", claim.reference, claim.between.words()),
            None => format!("`{}` came in no cycle", claim.of),
        };
        let words = |seen: &TimedValue| {
            let from = &window.from;
            delay_words((seen.a.saturating_sub(from.b), seen.b.saturating_sub(from.a)), &claim.between.from)
        };
        finding.reason = match (finding.can_hold, answer.empty, answer.deciding) {
            (true, ..) => unclear,
            (false, Some(start), _) => {
                format!("`{}` did not come in the cycle that began {}", of.info.name, words(&start))
            }
            (false, None, Some((_, extent, seen))) => {
                format!("it lagged by {}, {}", shown(extent, "deg"), words(&seen))
            }
            (false, None, None) => String::from("there is no cycle to judge"),
        };
        if let Some((margin, extent, seen)) = answer.deciding.filter(|_| answer.empty.is_none()) {
            finding.margin = Some(Figure::new(margin, "deg"));
            finding.uncertainty = spread(extent, "deg");
            finding = finding.decided_by(&seen);
        }
        finding
    }
}
