//! `follows`: one value keeps close to another for the whole of a window.
//!
//! ```toml
//! { follows = { signal = "speed", leader = "set-point", tolerance = "10 rpm", from = "run", within = "50 ms" } }
//! ```
//! `within` is how long the value may lag after: they may be farther apart for so long at a time. Such a time counts from
//! its beginning, before the window too, up to the window's end. The two signals
//! have clocks and channels of their own, so that changes of both that overlap may have come in any order: between
//! them the distance is not known.

use std::collections::VecDeque;
use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span, Value, ValueKind};

use super::common::{FROM, PlanWindow, SIGNAL, UNTIL, signal};
use super::condition::{ValueCondition, literal};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim, keeps};
use crate::codes;
use crate::lang::{Anchor, Literal};
use crate::meaning::{number, what_to_write};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, Number, PulseRule, TimedValue, TraceSignals, Truth,
    UncertainWindow, distance, slack,
};

/// `follows`.
pub(super) const FOLLOWS: ExpectVerb = ExpectVerb {
    name: "follows",
    doc: "One value keeps within a tolerance of another for the whole of a window",
    keys: &[
        SIGNAL,
        KeySpec::required("leader", KeyType::SignalRef, "The signal that it follows"),
        KeySpec::optional("tolerance", KeyType::Value, "How far apart they may be; 0 if left out"),
        KeySpec::optional(
            "within",
            KeyType::Duration,
            "For how long at a time they may be farther apart; 0 if left out",
        ),
        FROM,
        UNTIL,
    ],
    read,
};

/// Most changes that wait for those of the other signal. Beyond it the answer is left open.
const MOST: usize = 256;

/// The claim.
#[derive(Clone, Debug)]
struct Follows {
    signal: String,
    leader: String,
    tolerance: Option<Literal>,
    between: PlanWindow,
    within: Option<Span>,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let (signal, leader) = (signal(fields, "signal", cx), signal(fields, "leader", cx));
    let between = PlanWindow::read(fields, cx);
    let tolerance = match fields.get("tolerance") {
        Some(node) => Some(literal(node, cx)?),
        None => None,
    };
    let (signal, leader) = (signal?, leader?);
    if signal == leader {
        let node = fields.get("leader")?;
        let message = format!("`{signal}` follows itself: the claim can never fail");
        cx.out.bad(codes::CLAIM, node, message, "name another signal");
        return None;
    }
    let within = fields.duration("within").filter(|span| *span != Span::ZERO);
    Some(Arc::new(Follows { signal, leader, tolerance, between: between?, within }))
}

impl Follows {
    fn limit(&self, info: &SignalInfo) -> Result<Number, String> {
        let Some(tolerance) = &self.tolerance else { return Ok(Number::ZERO) };
        match number(tolerance, info)? {
            negative if negative.is_below(Number::ZERO) => {
                Err(format!("a tolerance of {tolerance} can never be met"))
            }
            limit => Ok(limit),
        }
    }

    fn apart(&self) -> String {
        match &self.tolerance {
            Some(tolerance) => format!("more than {tolerance} apart"),
            None => String::from("apart"),
        }
    }
}

impl TraceClaim for Follows {
    fn expected(&self) -> String {
        let how = match &self.tolerance {
            Some(tolerance) => format!(" within {tolerance}"),
            None => String::new(),
        };
        let lag = match self.within {
            Some(lag) => format!(", at most {lag} later"),
            None => String::new(),
        };
        format!("`{}` follows `{}`{how}{lag}{}", self.signal, self.leader, self.between.words())
    }

    fn signals(&self) -> Vec<String> {
        vec![self.signal.clone(), self.leader.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        let pair = (super::known(&self.signal, wiring, out), super::known(&self.leader, wiring, out));
        let (Some(info), Some(leader)) = pair else { return };
        super::meant(self.limit(info).map(drop), &what_to_write(info), out);
        if !info.unit.is_empty() && !leader.unit.is_empty() && info.unit != leader.unit {
            let why = format!("`{}` is in {} and `{}` in {}", info.name, info.unit, leader.name, leader.unit);
            super::meant(Err(why), "name two signals of one unit", out);
        }
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        vec![ClaimDemand::Differ(&self.signal, &self.leader), self.between.demand()]
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::breaks(self.within).weighed("within")
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let leader = scene.signal(&self.leader)?;
        let limit = self.limit(info).map_err(NotJudged::NoMeaning)?;
        // The distance as a signal of its own, which must never be too large.
        let mut distance = SignalInfo::exact("distance", ValueKind::State);
        distance.labels = vec![(0, String::from("close")), (1, self.apart())];
        let claim = keeps::Keeps {
            signals: vec![distance.name.clone()],
            condition: ValueCondition::label(&self.apart()),
            forbidden: true,
            between: self.between.clone(),
            longer_than: self.within,
        };
        let inner = claim.start_with(&distance, scene)?;
        Ok(Box::new(FollowsMonitor {
            unit: info.unit.clone(),
            slack: slack(info) + slack(leader),
            limit,
            window: scene.window(&self.between.from, &self.between.until)?,
            sides: [scene.lag(&self.signal), scene.lag(&self.leader)].map(FollowsSide::new),
            waiting: VecDeque::new(),
            inner,
            end: scene.end(),
            within: self.within,
            last: None,
            greatest: None,
            longest: 0,
        }))
    }
}

/// What is known of one of the signals.
struct FollowsSide {
    /// How far after the newest event of the trace one of this signal can begin, nanoseconds.
    lag: i64,
    /// No later event of the signal begins before this.
    reached: i64,
    value: Value,
}

impl FollowsSide {
    fn new(lag: i64) -> FollowsSide {
        FollowsSide { lag, reached: i64::MIN, value: Value::Unknown }
    }
}

/// The judge.
struct FollowsMonitor {
    unit: String,
    slack: f64,
    limit: Number,
    window: UncertainWindow,
    sides: [FollowsSide; 2],
    /// Changes of both signals by their earliest instants.
    waiting: VecDeque<(usize, TimedValue)>,
    /// Judges the distance.
    inner: Box<dyn Monitor>,
    end: i64,
    within: Option<Span>,
    /// How far apart they are since the last change, whether that is close enough, and its earliest instant.
    last: Option<(Option<Number>, Truth, i64)>,
    /// The greatest distance that can lie in the window.
    greatest: Option<Number>,
    /// The longest time at a stretch, nanoseconds, that they can be too far apart in the window.
    longest: i64,
}

impl FollowsMonitor {
    /// Whether two values are close enough, and how far apart.
    fn close(&self, pair: [Value; 2]) -> (Truth, Option<Number>) {
        if pair.iter().any(|value| matches!(value, Value::Unknown)) {
            return (Truth::Unknown, None);
        }
        match (Number::of(pair[0]), Number::of(pair[1])) {
            (Some(a), Some(b)) => {
                let known = pair[0].uncertainty() + pair[1].uncertainty();
                let (apart, truth) = super::equal::close(a, b, self.limit, self.slack + known);
                let known = if known > 0.0 { apart.plus(Number::Real(known)) } else { apart };
                (truth, Some(known))
            }
            _ => (Truth::of(pair[0] == pair[1]), None),
        }
    }

    /// Judges the changes that nothing new can come among.
    fn advance(&mut self, over: bool) {
        while let Some((_, first)) = self.waiting.front() {
            // Changes whose intervals overlap belong together.
            let (start, mut latest, mut count) = (first.a, first.b, 1);
            while let Some((_, next)) = self.waiting.get(count)
                && next.a <= latest
            {
                latest = latest.max(next.b);
                count += 1;
            }
            let reached = self.sides.iter().map(|side| side.reached).min().unwrap_or(i64::MAX);
            if !over && reached <= latest && self.waiting.len() < MOST {
                return;
            }
            self.group(count, (start, latest));
        }
    }

    /// Changes that may have come in any order.
    fn group(&mut self, count: usize, (start, latest): (i64, i64)) {
        let group: Vec<(usize, TimedValue)> = self.waiting.drain(..count).collect();
        let Some((_, last)) = group.last().copied() else { return };
        let mut values = self.sides.each_ref().map(|side| vec![side.value]);
        for (slot, seen) in &group {
            values[*slot].push(seen.value);
            self.sides[*slot].value = seen.value;
        }
        // One change is as exact as it is; several at one instant leave no time in between.
        if count > 1 && start < latest {
            let pairs = values[0].iter().flat_map(|a| values[1].iter().map(move |b| [*a, *b]));
            let all: Vec<(Truth, Option<Number>)> = pairs.map(|pair| self.close(pair)).collect();
            if all.iter().any(|(truth, _)| *truth != Truth::True) {
                let apart = all.iter().filter_map(|(_, apart)| *apart).reduce(Number::most);
                self.add((Truth::Unknown, apart), &TimedValue { a: start, b: start, ..last });
            }
        }
        let close = self.close(self.sides.each_ref().map(|side| side.value));
        let at = if count > 1 { TimedValue { a: latest, b: latest, ..last } } else { last };
        self.add(close, &at);
    }

    /// Hands on how close they are from here on.
    fn add(&mut self, (close, apart): (Truth, Option<Number>), at: &TimedValue) {
        self.until(at.b);
        let value = match close {
            Truth::True => Value::Int(0),
            Truth::False => Value::Int(1),
            Truth::Unknown => Value::Unknown,
        };
        let since = self.last.filter(|(_, before, _)| (*before == Truth::True) == (close == Truth::True));
        self.last = Some((apart, close, since.map_or(at.a, |(.., since)| since)));
        self.inner.feed(0, &TimedValue { value, ..*at });
    }

    /// What they were since the last change lasted until here.
    fn until(&mut self, end: i64) {
        let Some((apart, close, since)) = self.last else { return };
        if !self.window.can_meet(since, end) {
            return;
        }
        if let Some(apart) = apart {
            self.greatest = Some(self.greatest.map_or(apart, |old| old.most(apart)));
        }
        if close != Truth::True {
            let end = end.min(self.window.until.b);
            self.longest = self.longest.max(end.saturating_sub(since));
        }
    }
}

impl Monitor for FollowsMonitor {
    fn feed(&mut self, slot: usize, seen: &TimedValue) {
        for side in &mut self.sides {
            side.reached = side.reached.max(seen.a.saturating_sub(side.lag));
        }
        self.sides[slot].reached = self.sides[slot].reached.max(seen.a);
        let at = self.waiting.partition_point(|(_, other)| other.a <= seen.a);
        self.waiting.insert(at, (slot, *seen));
        self.advance(false);
    }

    fn finish(mut self: Box<Self>) -> Finding {
        self.advance(true);
        self.until(self.end);
        let FollowsMonitor { inner, greatest, longest, within, limit, slack, unit, .. } = *self;
        let mut finding = inner.finish();
        // The words are of a signal that the plan does not have.
        finding.reason = finding.reason.replacen("it was", "they were", 1);
        if let (false, Some(apart)) = (finding.can_break, greatest) {
            let apart = super::band::shown((apart, apart), &unit);
            finding.observed = match within {
                Some(_) if longest > 0 => {
                    format!("at most {apart} apart, too far for at most {}", Span::from_nanos(longest))
                }
                _ => format!("at most {apart} apart"),
            };
        }
        finding.margin = match within {
            Some(within) => Some(Figure::span(Span::from_nanos(within.as_nanos().saturating_sub(longest)))),
            None => greatest.map(|apart| Figure::new(distance(apart, limit) - slack, unit)),
        };
        finding
    }
}
