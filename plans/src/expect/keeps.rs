//! `stays` and `never`: a signal keeps to its values for a whole window, or keeps out of some.
//!
//! ```toml
//! { stays = { signal = "pressure", min = "1 V", max = "5 V", from = "busy + 2 s" } }
//! { never = { all = ["forward", "reverse"] } }
//! ```
//! Overlap is what counts: a value that ends at the very instant at which the window begins is not in it.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span, Value};

use super::common::{FROM, LONGER, PlanWindow, SIGNAL, UNTIL, signal, span_range, width};
use super::condition::{IS, MAX, MIN, ONE_OF, ValueCondition};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::codes;
use crate::lang::Anchor;
use crate::meaning::what_to_write;
use crate::monitor::segments::{Breach, SegmentJudgement, SegmentResult, Weight};
use crate::monitor::{
    CaseTimeline, ClockLimits, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, Truth,
    ValueTest, slack,
};

/// `stays`.
pub(super) const STAYS: ExpectVerb = ExpectVerb {
    name: "stays",
    doc: "A signal has its value, or one within limits, for the whole of a window",
    keys: &[SIGNAL, IS, ONE_OF, MIN, MAX, FROM, UNTIL, LONGER],
    read: |fields, cx| {
        let condition = ValueCondition::read(fields, None, cx);
        let signal = signal(fields, "signal", cx);
        read_window(fields, signal, condition, cx)
    },
};

/// `never`.
pub(super) const NEVER: ExpectVerb = ExpectVerb {
    name: "never",
    doc: "A signal has a value at no time of a window, or several signals are never TRUE together",
    keys: &[
        KeySpec::optional("signal", KeyType::SignalRef, "The signal that is looked at"),
        KeySpec::optional(
            "all",
            KeyType::List(&KeyType::SignalRef),
            "Two or more Boolean signals, in place of `signal`: never all TRUE at once",
        ),
        KeySpec::optional(
            "any-two",
            KeyType::List(&KeyType::SignalRef),
            "Two or more Boolean signals, in place of `signal`: no two of them TRUE at once",
        ),
        IS,
        ONE_OF,
        MIN,
        MAX,
        FROM,
        UNTIL,
        LONGER,
    ],
    read: read_never,
};

/// Most signals of `all`.
const MOST: usize = 16;

/// The claim.
#[derive(Clone, Debug)]
pub(super) struct Keeps {
    pub(super) signals: Vec<String>,
    pub(super) condition: ValueCondition,
    /// The condition is what must not be.
    pub(super) forbidden: bool,
    pub(super) between: PlanWindow,
    pub(super) longer_than: Option<Span>,
}

/// Reads the window of a claim that a signal keeps to a condition.
pub(super) fn read_window(
    fields: &Fields<'_>,
    signal: Option<String>,
    condition: Option<ValueCondition>,
    cx: &mut ReadContext<'_>,
) -> Option<Arc<dyn TraceClaim>> {
    let between = PlanWindow::read(fields, cx);
    let longer_than = fields.duration(LONGER.name);
    let signals = vec![signal?];
    Some(Arc::new(Keeps { signals, condition: condition?, forbidden: false, between: between?, longer_than }))
}

fn read_never(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let condition = ValueCondition::read(fields, Some(ValueCondition::is_true()), cx);
    let given: Vec<&str> = ["signal", "all", "any-two"].into_iter().filter(|key| fields.has(key)).collect();
    let signals = match given.as_slice() {
        ["signal"] => vec![signal(fields, "signal", cx)?],
        [key] => several(fields, key, cx)?,
        _ => {
            let message = "`never` looks at one of `signal`, `all` and `any-two`";
            cx.out.error(codes::CLAIM, cx.place.clone(), message, "give one of them");
            return None;
        }
    };
    if given == ["any-two"] {
        return super::pairs::claim(signals, condition, fields, cx);
    }
    let between = PlanWindow::read(fields, cx);
    let longer_than = fields.duration(LONGER.name);
    Some(Arc::new(Keeps { signals, condition: condition?, forbidden: true, between: between?, longer_than }))
}

/// Reads two or more signals, each once.
fn several(fields: &Fields<'_>, key: &str, cx: &mut ReadContext<'_>) -> Option<Vec<String>> {
    let mut signals = Vec::new();
    for node in fields.each(key) {
        let name = cx.names.signal(node, cx.out)?;
        if signals.contains(&name) {
            cx.out.bad(
                codes::CLAIM,
                node,
                format!("`{name}` stands here twice"),
                "name another signal, or remove it",
            );
            return None;
        }
        signals.push(name);
    }
    if !(2..=MOST).contains(&signals.len()) {
        let node = fields.get(key)?;
        let help = "for a single signal, write `signal`";
        cx.out.bad(codes::CLAIM, node, format!("`{key}` takes 2 to {MOST} signals"), help);
        return None;
    }
    Some(signals)
}

impl Keeps {
    fn test(&self, info: &SignalInfo) -> Result<ValueTest, String> {
        let test = self.condition.bind(info)?;
        Ok(if self.forbidden { ValueTest::Not(Box::new(test)) } else { test })
    }

    /// Finds what cannot be judged of one of the signals.
    pub(super) fn check_one(&self, at: usize, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        if let Some(info) = super::known(&self.signals[at], wiring, out) {
            super::meant(self.test(info).map(drop), &what_to_write(info), out);
        }
    }

    /// The judge of a signal that is not in the trace but made of some that are. A stretch of it counts from its beginning
    /// up to the end of the window.
    pub(super) fn start_with(
        &self,
        info: &SignalInfo,
        scene: &CaseTimeline<'_>,
    ) -> Result<Box<dyn Monitor>, NotJudged> {
        let window = scene.window(&self.between.from, &self.between.until)?;
        let (segments, counts_until) = (SegmentJudgement::new(window), (window.until.a, window.until.b));
        let test = self.test(info).map_err(NotJudged::NoMeaning)?;
        let watched = vec![KeptSignal { test, slack: slack(info), info: info.clone() }];
        let open = scene.is_open(&self.between.until);
        let common = Common {
            claim: self.by_clock(scene.clock),
            watched,
            segments,
            open,
            end: scene.earliest_end(),
            counts_until,
            weighs: true,
        };
        Ok(Box::new(SingleSignalMonitor::new(common)))
    }

    /// The claim with its limits as the clock has them.
    fn by_clock(&self, clock: ClockLimits) -> Keeps {
        let most = |span: Span| Span::from_nanos(clock.most(span.as_nanos()));
        Keeps { longer_than: self.longer_than.map(most), ..self.clone() }
    }

    fn subject(&self) -> String {
        let quoted: Vec<String> = self.signals.iter().map(|name| format!("`{name}`")).collect();
        quoted.join(" and ")
    }
}

impl TraceClaim for Keeps {
    fn expected(&self) -> String {
        let (subject, window) = (self.subject(), self.between.words());
        let longer = match self.longer_than {
            Some(span) => format!(" for longer than {span}"),
            None => String::new(),
        };
        match (self.forbidden, self.signals.len()) {
            (false, _) => format!("{subject} stays {}{window}", self.condition),
            (true, 1) => format!("{subject} is never {}{longer}{window}", self.condition),
            (true, _) => format!("{subject} are never all {}{longer}{window}", self.condition),
        }
    }

    fn signals(&self) -> Vec<String> {
        self.signals.clone()
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        for at in 0..self.signals.len() {
            self.check_one(at, wiring, out);
        }
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        let (condition, forbidden) = (&self.condition, self.forbidden);
        // Of several signals it is enough that one keeps out.
        let signal = if let [one] = self.signals.as_slice() { Some(one) } else { None };
        let value = signal.map(|signal| ClaimDemand::Value { signal, condition, forbidden });
        value.into_iter().chain([self.between.demand()]).collect()
    }

    fn pulses(&self, info: &SignalInfo) -> PulseRule {
        let rule = PulseRule::breaks(self.longer_than);
        match self.signals.len() {
            1 => rule.of_level(self.test(info).ok()),
            // Of several signals it is the time together that counts.
            _ => rule.weighed(LONGER.name),
        }
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let window = scene.window(&self.between.from, &self.between.until)?;
        let mut watched = Vec::new();
        for name in &self.signals {
            let info = scene.signal(name)?;
            let test = self.test(info).map_err(NotJudged::NoMeaning)?;
            watched.push(KeptSignal { test, slack: slack(info), info: info.clone() });
        }
        let open = scene.is_open(&self.between.until);
        let segments = SegmentJudgement::new(window);
        let common = Common {
            claim: self.by_clock(scene.clock),
            watched,
            segments,
            open,
            end: scene.earliest_end(),
            counts_until: (i64::MAX, i64::MAX),
            weighs: self.signals.len() > 1,
        };
        if self.signals.len() > 1 {
            let lags = self.signals.iter().map(|name| scene.lag(name)).collect();
            return Ok(super::together::start(common, lags));
        }
        Ok(Box::new(SingleSignalMonitor::new(common)))
    }
}

/// A signal with its condition: what it has to keep to.
pub(super) struct KeptSignal {
    pub(super) test: ValueTest,
    pub(super) slack: f64,
    pub(super) info: SignalInfo,
}

/// What the judges of one and of several signals share.
pub(super) struct Common {
    pub(super) claim: Keeps,
    pub(super) watched: Vec<KeptSignal>,
    pub(super) segments: SegmentJudgement,
    /// The end of the window is still to come.
    pub(super) open: bool,
    /// The end of the case: what lasts until then has no known width.
    pub(super) end: i64,
    /// Up to when the width of a forbidden stretch counts, at the earliest and at the latest; `i64::MAX` where all of it does.
    pub(super) counts_until: (i64, i64),
    /// Forbidden stretches are held against the shortest that counts here; else short ones were taken out before.
    pub(super) weighs: bool,
}

impl Common {
    /// What a forbidden stretch counts for, by its width.
    pub(super) fn weigh(&self, class: Truth, start: &TimedValue, end: (i64, i64)) -> Truth {
        let Some(longer) = self.claim.longer_than.filter(|_| self.weighs) else { return class };
        let end = (end.0.min(self.counts_until.0), end.1.min(self.counts_until.1));
        let width = (end.0.saturating_sub(start.b).max(0), end.1.saturating_sub(start.a));
        match class {
            _ if width.1 <= longer.as_nanos() => Truth::True,
            Truth::False if width.0 <= longer.as_nanos() => Truth::Unknown,
            class => class,
        }
    }

    /// What is fed at `now` comes before an end of the window that is still to come.
    #[inline]
    pub(super) fn advance(&mut self, now: i64) {
        if self.open {
            self.segments.advance(now);
        }
    }

    pub(super) fn lost(&mut self, now: i64) -> bool {
        self.advance(now);
        self.segments.lost(now)
    }

    /// The finding, with how far the values kept inside their limits.
    pub(super) fn finding(&mut self, extreme: Option<(f64, TimedValue)>) -> Finding {
        let kept = self.segments.finish();
        let mut finding = Finding {
            can_hold: kept.can_hold,
            can_break: kept.can_break,
            window: Some(self.segments.window().shown()),
            bounds: self.bounds(),
            ..Finding::default()
        };
        finding.observed = self.observed(&kept);
        finding.reason = self.reason(&kept);
        finding.margin = self.margin(&kept, extreme);
        if let Some(breach) = kept.worst {
            let (a, b) = breach.value_start;
            finding.deciding = Some(crate::monitor::clipped(a, b));
            finding.cause = Some(breach.cause);
            finding.uncertainty = width(breach.value_start);
        } else if let Some((_, seen)) = extreme {
            let (a, b) = self.segments.inside((seen.a, seen.b));
            finding = finding.decided_by(&TimedValue { a, b, ..seen });
        }
        if let (Some((_, seen)), [one]) = (extreme, self.watched.as_slice()) {
            let known = super::common::within(seen.value.uncertainty(), one.slack, &one.info);
            finding.uncertainty = known.or(finding.uncertainty);
        }
        finding
    }

    /// The values that one signal may have.
    fn bounds(&self) -> Option<record::Bounds> {
        match self.watched.as_slice() {
            [one] if !self.claim.forbidden => one.test.bounds(),
            _ => None,
        }
    }

    fn show(&self, value: Value) -> String {
        match self.watched.as_slice() {
            [one] => one.info.show(value),
            _ => format!("all {}", self.claim.condition),
        }
    }

    fn were(&self) -> &'static str {
        if self.watched.len() > 1 { "they were" } else { "it was" }
    }

    fn observed(&self, kept: &SegmentResult) -> String {
        match kept.worst {
            None if self.claim.forbidden => String::from("it did not happen"),
            None => format!("it stayed {}", self.claim.condition),
            Some(Breach { weight: Weight::Unknown, value, .. }) if value.uncertainty() == 0.0 => {
                String::from("the value is not known throughout")
            }
            Some(breach) => {
                let lasting = lasts(breach.value_start, breach.value_end);
                let all = match breach.value_end == breach.end {
                    true => String::new(),
                    false => format!("; out of range {}", lasts(breach.value_start, breach.end)),
                };
                let from = &self.claim.between.from;
                let point = &self.segments.window().from;
                let (first, last) = breach.value_start;
                let delay = (first.saturating_sub(point.b), last.saturating_sub(point.a));
                let when = match delay.1 {
                    0 => format!("{from} on"),
                    _ => super::common::delay_words(delay, from),
                };
                format!("{} {lasting}, from {when}{all}", self.show(breach.value))
            }
        }
    }

    fn reason(&self, kept: &SegmentResult) -> String {
        match kept.worst {
            Some(breach) if !kept.can_hold => {
                format!("{} {} inside the window", self.were(), self.show(breach.value))
            }
            Some(Breach { weight: Weight::Unknown, value, .. }) => match value.uncertainty() > 0.0 {
                true => format!("it was {}: a limit lies within its uncertainty", self.show(value)),
                false => String::from("the value is not known for a part of the window"),
            },
            Some(breach) => format!(
                "whether {} {} inside the window lies within the uncertainty of the instants",
                self.were(),
                self.show(breach.value)
            ),
            None => String::new(),
        }
    }

    /// In values where the condition has limits, else in time: how far off forbidden values kept, or for
    /// how long one lay in the window.
    fn margin(&self, kept: &SegmentResult, extreme: Option<(f64, TimedValue)>) -> Option<Figure> {
        if let (Some((margin, _)), [one]) = (extreme, self.watched.as_slice()) {
            return Some(Figure::new(margin, one.info.unit.clone()));
        }
        let window = self.segments.window();
        let nanos = match kept.worst {
            Some(Breach { weight: Weight::Unknown, .. }) => return None,
            Some(breach) => {
                let inside =
                    breach.end.1.min(window.until.b).saturating_sub(breach.start.0.max(window.from.a));
                inside.max(0).saturating_neg()
            }
            None => kept.distance?,
        };
        Some(Figure::span(Span::from_nanos(nanos)))
    }
}

/// How long something lasts.
fn lasts(start: (i64, i64), end: (i64, i64)) -> String {
    let least = end.0.saturating_sub(start.1).max(0);
    let most = end.1.saturating_sub(start.0);
    match end {
        (i64::MAX, _) => String::from("until the end"),
        (_, i64::MAX) => format!("for {} or longer", Span::from_nanos(least)),
        _ => format!("for {}", span_range((least, most))),
    }
}

/// The judge of one signal.
struct SingleSignalMonitor {
    common: Common,
    last: Option<TimedValue>,
    /// The value of the window that is nearest to a limit, or farthest outside.
    extreme: Option<(f64, TimedValue)>,
    /// With `pulses-longer-than`: the stretch that is open, whose width decides.
    run: Option<Run>,
}

/// A stretch without an instant at which the value is known to be allowed. Where it is not known it may be
/// forbidden, so that all of the stretch can be one pulse.
struct Run {
    /// Whether the value is forbidden or not known at the moment, and since when.
    piece: (Truth, TimedValue),
    /// The beginning of the pieces before that were not reported yet.
    unreported: Option<TimedValue>,
    /// A piece that was reported is longer than what does not matter.
    long: bool,
}

impl SingleSignalMonitor {
    fn new(mut common: Common) -> SingleSignalMonitor {
        let mut run = None;
        if common.claim.longer_than.is_some() {
            // What was there when the signal was first known may have begun long before.
            run = Some(Run { piece: (Truth::Unknown, TimedValue::NOTHING), unreported: None, long: false });
            common.segments.change(Truth::True, &TimedValue::NOTHING);
        }
        SingleSignalMonitor { common, last: None, extreme: None, run }
    }

    /// The last value lasted until here.
    fn extent(&mut self, end: i64) {
        let Some(last) = self.last else { return };
        let watched = &self.common.watched[0];
        let Some(margin) = watched.test.margin(last.value) else { return };
        let margin = margin - watched.slack;
        let nearer = self.extreme.is_none_or(|(least, _)| margin < least);
        if nearer && self.common.segments.window().can_meet(last.a, end) {
            self.extreme = Some((margin, last));
        }
    }

    /// The value is no longer what it was: a forbidden piece that is long enough by itself is reported.
    fn end_piece(&mut self, end: (i64, i64)) {
        let Some(run) = &mut self.run else { return };
        let (class, start) = run.piece;
        if class == Truth::Unknown || self.common.weigh(class, &start, end) != Truth::False {
            run.unreported.get_or_insert(start);
            return;
        }
        if let Some(unreported) = run.unreported.take() {
            self.common.segments.segment(Truth::Unknown, &unreported, (start.a, start.b));
        }
        self.common.segments.segment(Truth::False, &start, end);
        run.long = true;
    }

    fn end_run(&mut self, end: (i64, i64)) {
        self.end_piece(end);
        let Some(Run { unreported: Some(unreported), long, .. }) = self.run.take() else { return };
        if long || self.common.weigh(Truth::Unknown, &unreported, end) != Truth::True {
            self.common.segments.segment(Truth::Unknown, &unreported, end);
        }
    }
}

impl Monitor for SingleSignalMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        self.common.advance(seen.a);
        let watched = &self.common.watched[0];
        let class = watched.test.holds(seen.value, watched.slack);
        if matches!(watched.test, ValueTest::Range { .. }) {
            self.extent(seen.b);
            self.last = Some(*seen);
        }
        if self.common.claim.longer_than.is_none() {
            self.common.segments.change(class, seen);
            return;
        }
        if class == Truth::True {
            self.end_run((seen.a, seen.b));
        } else if self.run.as_ref().is_none_or(|run| run.piece.0 != class) {
            self.end_piece((seen.a, seen.b));
            match &mut self.run {
                Some(run) => run.piece = (class, *seen),
                None => self.run = Some(Run { piece: (class, *seen), unreported: None, long: false }),
            }
        }
    }

    fn lost(&mut self, now: i64) -> bool {
        self.common.lost(now)
    }

    fn finish(mut self: Box<Self>) -> Finding {
        self.extent(i64::MAX);
        self.end_run((self.common.end, i64::MAX));
        let extreme = self.extreme;
        self.common.finding(extreme)
    }
}
