//! `settles`: a value comes into a band in time and stays there, without going too far beyond it before.
//!
//! ```toml
//! { settles = { signal = "speed", is = "1500 rpm ± 10 rpm", from = "go", within = "3 s", overshoot = "5 %" } }
//! ```
//! From `from` + `within` on the value has to keep to the band; a value that is in it all along has settled at once.
//! The overshoot is how far the value goes beyond the middle of the band, seen in the direction from its value at
//! `from`; in per cent it is a part of that step.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{ClockError, SignalInfo, Span, ValueKind};

use super::band::shown;
use super::common::{FROM, LONGER, PlanWindow, SIGNAL, UNTIL, delay_words, signal};
use super::condition::{IS, MAX, MIN, ValueCondition, literal};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::codes;
use crate::lang::{Anchor, Literal};
use crate::meaning::{number, what_to_write};
use crate::monitor::extremes::Extremes;
use crate::monitor::reading::ValueReader;
use crate::monitor::segments::{SegmentJudgement, Weight};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, Number, PulseFilter, PulseRule, TimedValue, TraceSignals,
    Truth, UncertainInstant, ValueTest, distance, slack, widened,
};

/// `settles`.
pub(super) const SETTLES: ExpectVerb = ExpectVerb {
    name: "settles",
    doc: "A value comes into a band in time and stays there, without too much overshoot",
    keys: &[
        SIGNAL,
        IS,
        MIN,
        MAX,
        FROM,
        KeySpec::required(
            "within",
            KeyType::Duration,
            "How long after `from` it has to be in the band for good",
        ),
        KeySpec::optional(
            "overshoot",
            KeyType::Value,
            "How far it may go beyond the middle of the band, or which part of the step from its value at `from`, as \
             in \"5 %\"",
        ),
        UNTIL,
        LONGER,
    ],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct SettlesClaim {
    signal: String,
    band: ValueCondition,
    /// All of it, and from the instant at which the value has to have settled.
    between: PlanWindow,
    settled: Anchor,
    within: Span,
    overshoot: Option<Literal>,
    longer_than: Option<Span>,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "signal", cx);
    let between = PlanWindow::read(fields, cx);
    let band = ValueCondition::read(fields, None, cx);
    let within = fields.duration("within");
    let overshoot = match fields.get("overshoot") {
        Some(node) => Some(literal(node, cx)?),
        None => None,
    };
    let (signal, between, band, within) = (signal?, between?, band?, within?);
    let settled = Anchor {
        base: between.from.base.clone(),
        offset: Span::from_nanos(between.from.offset.as_nanos().saturating_add(within.as_nanos())),
    };
    if settled.base == between.until.base && settled.offset >= between.until.offset {
        let node = fields.get("within")?;
        let message = format!("`until` comes before {within} are over: the claim can never fail");
        cx.out.bad(codes::CLAIM, node, message, "let `until` be later, or shorten `within`");
        return None;
    }
    if let (Some(_), ValueCondition::Within { min: None, .. } | ValueCondition::Within { max: None, .. }) =
        (&overshoot, &band)
    {
        let node = fields.get("overshoot")?;
        let message = "an overshoot counts from the middle of the band, which has one limit only";
        cx.out.bad(codes::CLAIM, node, message, "give both limits, as in is = \"1500 ± 10 rpm\"");
        return None;
    }
    let longer_than = fields.duration(LONGER.name);
    Some(Arc::new(SettlesClaim { signal, band, between, settled, within, overshoot, longer_than }))
}

/// How far beyond the middle a value may go, in the terms of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OvershootLimit {
    middle: Number,
    /// In the unit of the signal, or as a part of the step.
    most: Number,
    part: bool,
}

/// What makes the middle of a sum of two.
const HALF: Number = Number::Real(0.5);

impl SettlesClaim {
    fn beyond(&self, test: &ValueTest, info: &SignalInfo) -> Result<Option<OvershootLimit>, String> {
        let Some(most) = &self.overshoot else { return Ok(None) };
        let middle = match test {
            ValueTest::Range { min: Some(min), max: Some(max) } => min.plus(*max).times(HALF),
            ValueTest::OneOf(list) if list.len() == 1 => list[0],
            _ => return Err(String::from("an overshoot counts from the middle of a band of numbers")),
        };
        let part = most.quantity().filter(|quantity| quantity.is_part() && info.unit != "%");
        let (most, part) = match part {
            Some(part) => {
                let percent = part.in_unit(&signal::Unit::new("%"));
                (percent.ok_or_else(|| format!("`{most}` is no part"))?.shifted(-2).into(), true)
            }
            None => (number(most, info)?, false),
        };
        if most.is_below(Number::ZERO) {
            return Err(String::from("an overshoot below 0 can never be met"));
        }
        Ok(Some(OvershootLimit { middle, most, part }))
    }

    /// What takes excursions out of the band that do not count out of the signal.
    fn short_excursions(
        &self,
        info: &SignalInfo,
        band: &ValueTest,
        clock: ClockError,
    ) -> Option<PulseFilter> {
        PulseRule::breaks(self.longer_than).of_level(Some(band.clone())).filter(info, 0, clock)
    }

    fn bind(&self, info: &SignalInfo) -> Result<(ValueTest, Option<OvershootLimit>), String> {
        if !is_number(info) {
            return Err(format!("`{}` is no number that could settle", info.name));
        }
        let test = self.band.bind(info)?;
        let beyond = self.beyond(&test, info)?;
        Ok((test, beyond))
    }
}

fn is_number(info: &SignalInfo) -> bool {
    matches!(info.kind, ValueKind::Real | ValueKind::Int | ValueKind::Word)
}

impl TraceClaim for SettlesClaim {
    fn expected(&self) -> String {
        let overshoot = match &self.overshoot {
            Some(most) => format!(", with an overshoot of at most {most}"),
            None => String::new(),
        };
        let until = match self.between.until == Anchor::END {
            true => String::new(),
            false => format!(", until {}", self.between.until),
        };
        let (signal, band, within, from) = (&self.signal, &self.band, self.within, &self.between.from);
        format!("`{signal}` settles to {band} within {within} after {from}{overshoot}{until}")
    }

    fn signals(&self) -> Vec<String> {
        vec![self.signal.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        vec![&self.between.from, &self.settled, &self.between.until]
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        if let Some(info) = super::known(&self.signal, wiring, out) {
            let help = match is_number(info) {
                true => what_to_write(info),
                false => String::from("name a number; of a line claim `becomes`, and `stays` from then on"),
            };
            super::meant(self.bind(info).map(drop), &help, out);
        }
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        vec![self.between.demand(), ClaimDemand::At(&self.settled)]
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::breaks(self.longer_than).weighed(LONGER.name)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let (test, beyond) = self.bind(info).map_err(NotJudged::NoMeaning)?;
        let whole = scene.window(&self.between.from, &self.between.until)?;
        let rest = scene.window(&self.settled, &self.between.until)?;
        Ok(Box::new(SettlesMonitor {
            claim: self.clone(),
            info: info.clone(),
            beyond,
            from: scene.point(&self.between.from)?,
            reader: ValueReader::new(scene.point(&self.between.from)?),
            segments: SegmentJudgement::new(rest),
            short: self.short_excursions(info, &test, scene.clock.error),
            extremes: Extremes::new(whole),
            class: Truth::Unknown,
            entered: None,
            open: scene.is_open(&self.between.until),
            end: scene.earliest_end(),
            test,
        }))
    }
}

/// The judge.
struct SettlesMonitor {
    claim: SettlesClaim,
    info: SignalInfo,
    test: ValueTest,
    beyond: Option<OvershootLimit>,
    from: UncertainInstant,
    reader: ValueReader,
    /// Whether it keeps to the band from the instant on at which it has to have settled.
    segments: SegmentJudgement,
    /// Takes the short excursions out of what is judged there.
    short: Option<PulseFilter>,
    extremes: Extremes,
    class: Truth,
    /// The last time that it came into the band.
    entered: Option<TimedValue>,
    open: bool,
    end: i64,
}

impl Monitor for SettlesMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        if self.open {
            self.segments.advance(seen.a);
            self.extremes.advance(seen.a);
        }
        match self.short.take() {
            Some(mut short) => {
                short.see(seen, &mut |seen| self.keep(seen));
                self.short = Some(short);
            }
            None => self.keep(seen),
        }
        self.reader.see(seen);
        self.extremes.see(seen);
    }

    fn lost(&mut self, now: i64) -> bool {
        // Whether what is held back is short shows later: until then it may have settled.
        if self.short.is_some() {
            return false;
        }
        if self.open {
            self.segments.advance(now);
        }
        self.segments.lost(now)
    }

    fn finish(mut self: Box<Self>) -> Finding {
        if let Some(short) = self.short.take() {
            short.finish(self.end, &mut |seen| self.keep(seen));
        }
        let kept = self.segments.finish();
        let overshoot = self.overshoot();
        let mut finding = Finding {
            can_hold: kept.can_hold && overshoot.as_ref().is_none_or(|over| over.can_hold),
            can_break: kept.can_break || overshoot.as_ref().is_some_and(|over| over.can_break),
            window: Some(self.window()),
            bounds: self.test.bounds(),
            ..Finding::default()
        };
        let (settled, delay) = self.settled();
        finding.observed = match &overshoot {
            Some(over) => format!("{settled}; {}", over.words),
            None => settled,
        };
        let by_overshoot = overshoot
            .as_ref()
            .filter(|over| over.can_break && if finding.can_hold { !kept.can_break } else { kept.can_hold });
        let unknown = kept.worst.is_some_and(|breach| breach.weight == Weight::Unknown);
        let delay = delay.filter(|_| !unknown);
        let in_time = delay.map(|delay| self.claim.within.as_nanos().saturating_sub(delay.1));
        finding.margin = match by_overshoot {
            Some(over) => over.margin.clone(),
            None => in_time.map(|margin| Figure::span(Span::from_nanos(margin))),
        };
        finding.uncertainty = delay.and_then(super::common::width);
        finding.reason = match (by_overshoot, kept.worst) {
            (Some(over), _) => over.reason.clone(),
            (_, Some(breach)) if unknown => super::common::unclear(&self.info, breach.value, "the window"),
            (_, Some(_)) if !kept.can_hold && in_time.is_some_and(|margin| margin < 0) => {
                format!("{} too late", Span::from_nanos(in_time.unwrap_or_default().saturating_neg()))
            }
            (_, Some(breach)) if !kept.can_hold => {
                format!("it was {} after {}", self.info.show(breach.value), self.claim.settled)
            }
            (_, Some(_)) => String::from("the uncertainty of the instants reaches over the limit"),
            (_, None) => String::new(),
        };
        if let Some(peak) = by_overshoot.and_then(|over| over.peak) {
            return finding.decided_by(&peak);
        }
        match (kept.worst, self.entered) {
            (Some(breach), _) if !unknown => {
                finding.deciding = Some(crate::monitor::clipped(breach.value_start.0, breach.value_start.1));
                finding.cause = Some(breach.cause);
                finding
            }
            (_, Some(seen)) => finding.decided_by(&seen),
            _ => finding,
        }
    }
}

/// What the overshoot came to.
struct Overshoot {
    can_hold: bool,
    can_break: bool,
    words: String,
    reason: String,
    margin: Option<Figure>,
    /// The value that lies farthest beyond.
    peak: Option<TimedValue>,
}

impl SettlesMonitor {
    /// The value from here on, as far as it counts.
    fn keep(&mut self, seen: &TimedValue) {
        let class = self.test.holds(seen.value, slack(&self.info));
        let inside = seen.b < self.segments.window().until.a;
        if class != self.class && inside {
            self.entered = (class == Truth::True && seen.b > self.from.a).then_some(*seen);
        }
        if inside {
            self.class = class;
        }
        self.segments.change(class, seen);
    }

    /// When it came into the band for good, in words and as a delay.
    fn settled(&self) -> (String, Option<(i64, i64)>) {
        let from = &self.claim.between.from;
        match (self.class, self.entered) {
            (Truth::True, Some(seen)) => {
                let delay = (seen.a.saturating_sub(self.from.b).max(0), seen.b.saturating_sub(self.from.a));
                (format!("settled {}", delay_words(delay, from)), Some(delay))
            }
            (Truth::True, None) => (format!("it was within {} all along", self.claim.band), Some((0, 0))),
            (Truth::False, _) => (format!("it did not settle to {}", self.claim.band), None),
            (Truth::Unknown, _) => (String::from("the value is not known at the end"), None),
        }
    }

    fn overshoot(&self) -> Option<Overshoot> {
        let beyond = self.beyond?;
        let unit = &self.info.unit;
        let slack = Number::Real(slack(&self.info));
        let mut over = Overshoot {
            can_hold: false,
            can_break: false,
            words: String::new(),
            reason: String::new(),
            margin: None,
            peak: None,
        };
        let extremes = self.extremes.clone().finish();
        let mut extent = None;
        let mut worst: Option<f64> = None;
        for first in self.reader.clone().finish() {
            let begun = Number::of(first.seen.value).filter(|value| value.as_real().is_finite());
            // Without a step nothing says which way is beyond.
            let known = Number::Real(first.seen.value.uncertainty());
            let clear = begun.filter(|begun| begun.apart(beyond.middle).is_above(known));
            let Some((begun, extremes)) = clear.zip(extremes.as_ref()) else {
                over.can_hold = true;
                over.can_break = true;
                continue;
            };
            let (step, upwards) = (begun.apart(beyond.middle), begun.is_below(beyond.middle));
            let (low, high) = (step.minus(known), step.plus(known));
            over.peak = Some(if upwards { extremes.at.1 } else { extremes.at.0 });
            let (certain, possible) = match upwards {
                true => (extremes.most.0.minus(beyond.middle), extremes.most.1.minus(beyond.middle)),
                false => (beyond.middle.minus(extremes.least.1), beyond.middle.minus(extremes.least.0)),
            };
            let (least, most) =
                (certain.minus(slack).most(Number::ZERO), possible.plus(slack).most(Number::ZERO));
            let allowed = |step: Number| if beyond.part { step.times(beyond.most) } else { beyond.most };
            over.can_hold |= !least.is_above(allowed(high)) || extremes.unknown;
            over.can_break |= most.is_above(allowed(low)) || extremes.unknown;
            let margin = distance(most, allowed(low));
            worst = Some(worst.map_or(margin, |old| old.min(margin)));
            let figure = match beyond.part {
                true => {
                    let part = |of: Number, step: Number| Number::Real(of.as_real() * 100.0 / step.as_real());
                    (part(least, high), part(most, low))
                }
                false => (least, most),
            };
            extent = Some(widened(extent, figure));
        }
        let unit_of_figure = if beyond.part { "%" } else { unit.as_str() };
        over.margin = worst.map(|worst| Figure::new(worst, unit.clone()));
        (over.words, over.reason) = match extent {
            Some(extent) => {
                let overshoot = format!("overshoot {}", shown(extent, unit_of_figure));
                (overshoot.clone(), format!("{overshoot}, with {} allowed", self.allowed()))
            }
            None => (
                String::from("overshoot not known"),
                format!("`{}` has no known step that an overshoot could be seen against", self.info.name),
            ),
        };
        Some(over)
    }

    fn allowed(&self) -> String {
        self.claim.overshoot.as_ref().map_or_else(String::new, ToString::to_string)
    }

    /// The window with the instant at which it has to have settled.
    fn window(&self) -> record::Window {
        let rest = self.segments.window();
        record::Window {
            from_ns: [self.from.a, self.from.b],
            until_ns: [rest.until.a, rest.until.b],
            limit_from_ns: None,
            limit_until_ns: Some(rest.from.b),
        }
    }
}
