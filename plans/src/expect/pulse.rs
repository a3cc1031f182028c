//! `pulse`: how long a signal stays at a level.
//!
//! ```toml
//! { pulse = { signal = "out", level = "high", width = "10 ms ± 0.1 ms", from = "press" } }
//! ```
//! A pulse belongs to the window in which it begins, wherever it ends. No pulse at all fails the claim.

use std::sync::Arc;

use document::{Diagnostic, Fields, KeySpec, KeyType};
use record::Figure;
use signal::{SignalInfo, Span};

use super::common::{
    FROM, LONGER, PlanWindow, SIGNAL, SingleSpan, SpanLimits, UNTIL, delay_words, signal, span_range, spans,
    width,
};
use super::{ClaimDemand, ExpectVerb, ReadContext, TraceClaim};
use crate::lang::Anchor;
use crate::monitor::levels::PulseFinder;
use crate::monitor::pulses::{FigureChain, FirstPulse, Pulse, Spread};
use crate::monitor::{
    CaseTimeline, Finding, Monitor, NotJudged, PulseRule, TimedValue, TraceSignals, UncertainWindow, slack,
};

/// `pulse`.
pub(super) const PULSE: ExpectVerb = ExpectVerb {
    name: "pulse",
    doc: "The first pulse of a window, or every one, has a width within limits",
    keys: &[
        SIGNAL,
        KeySpec::optional(
            "level",
            KeyType::Choice(&["high", "low"]),
            "The level of the pulse; `high` if left out",
        ),
        KeySpec::required(
            "width",
            KeyType::Range,
            "The width that is allowed: \"10 ms ± 0.1 ms\", \"5 ms ..\"",
        ),
        KeySpec::optional("which", KeyType::Choice(&["first", "every"]), "Which pulses; `first` if left out"),
        FROM,
        UNTIL,
        LONGER,
    ],
    read,
};

/// The claim.
#[derive(Clone, Debug)]
struct PulseClaim {
    signal: String,
    high: bool,
    width: SpanLimits,
    every: bool,
    between: PlanWindow,
    longer_than: Option<Span>,
}

fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<Arc<dyn TraceClaim>> {
    let signal = signal(fields, "signal", cx);
    let between = PlanWindow::read(fields, cx);
    let width = spans(fields.get("width")?, "width", SingleSpan::Exactly, cx)?;
    let high = fields.text("level") != Some("low");
    let every = fields.text("which") == Some("every");
    let longer_than = fields.duration(LONGER.name);
    Some(Arc::new(PulseClaim { signal: signal?, high, width, every, between: between?, longer_than }))
}

impl PulseClaim {
    fn noun(&self) -> &'static str {
        if self.high { "pulse" } else { "low pulse" }
    }
}

impl TraceClaim for PulseClaim {
    fn expected(&self) -> String {
        let which = if self.every { "every" } else { "the first" };
        let (width, window) = (span_range(self.width), self.between.words());
        format!("{which} {} of `{}` lasts {width}{window}", self.noun(), self.signal)
    }

    fn signals(&self) -> Vec<String> {
        vec![self.signal.clone()]
    }

    fn anchors(&self) -> Vec<&Anchor> {
        self.between.anchors()
    }

    fn check(&self, wiring: &TraceSignals<'_>, out: &mut Vec<Diagnostic>) {
        super::known(&self.signal, wiring, out);
    }

    fn demands(&self) -> Vec<ClaimDemand<'_>> {
        vec![ClaimDemand::Change(&self.signal), self.between.demand()]
    }

    fn counts(&self) -> Option<f64> {
        Some(0.0)
    }

    fn pulses(&self, _: &SignalInfo) -> PulseRule {
        PulseRule::decides(self.longer_than)
    }

    fn start(&self, scene: &CaseTimeline<'_>) -> Result<Box<dyn Monitor>, NotJudged> {
        let info = scene.signal(&self.signal)?;
        let window = scene.window(&self.between.from, &self.between.until)?;
        let width = scene.clock.spans(self.width);
        let judge = match self.every {
            true => PulseSelection::Every(FigureChain::new(window, width)),
            false => PulseSelection::First(FirstPulse::new(window, width)),
        };
        Ok(Box::new(PulseMonitor {
            claim: PulseClaim { width, ..self.clone() },
            info: info.clone(),
            levels: PulseFinder::new(self.high, slack(info)),
            window,
            judge,
            end: scene.earliest_end(),
        }))
    }
}

/// Which pulses are judged.
enum PulseSelection {
    First(FirstPulse),
    Every(FigureChain),
}

/// The judge.
struct PulseMonitor {
    claim: PulseClaim,
    info: SignalInfo,
    levels: PulseFinder,
    window: UncertainWindow,
    judge: PulseSelection,
    end: i64,
}

impl PulseMonitor {
    fn pulse(&mut self, pulse: &Pulse) {
        match &mut self.judge {
            PulseSelection::First(first) => first.see(pulse),
            PulseSelection::Every(chain) if pulse.certain => chain.pulse(pulse),
            PulseSelection::Every(chain) => chain.unknown(&pulse.start),
        }
    }
}

impl Monitor for PulseMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        if let Some(pulse) = self.levels.see(seen) {
            self.pulse(&pulse);
        }
    }

    fn finish(mut self: Box<Self>) -> Finding {
        if let Some(pulse) = self.levels.rest(self.end) {
            self.pulse(&pulse);
        }
        let end = self.end;
        let (claim, window, info) = (self.claim, self.window, self.info);
        let spread = match self.judge {
            PulseSelection::First(first) => first.finish(),
            PulseSelection::Every(chain) => chain.finish(),
        };
        finding(&claim, &spread, &window, &info, end)
    }
}

fn finding(
    claim: &PulseClaim,
    spread: &Spread,
    window: &UncertainWindow,
    info: &SignalInfo,
    end: i64,
) -> Finding {
    let mut finding = Finding {
        can_hold: spread.can_hold,
        can_break: spread.can_break || spread.can_be_missing,
        beyond_help: claim.every && spread.deciding.is_some_and(|found| found.extent.1 < claim.width.0),
        window: Some(window.shown()),
        ..Finding::default()
    };
    let noun = claim.noun();
    let Some(deciding) = spread.deciding else {
        finding.observed = format!("no {noun} began{}", claim.between.words());
        finding.reason = match spread.doubtful {
            true => format!("`{}` is not known for a part of the window", info.name),
            false => format!("there was no {noun}"),
        };
        return finding;
    };
    let delay =
        (deciding.seen.a.saturating_sub(window.from.b), deciding.seen.b.saturating_sub(window.from.a));
    let unfinished = deciding.extent.1 >= i64::MAX.saturating_sub(end);
    let lasting = match unfinished {
        true => format!("at least {}, until the end", Span::from_nanos(deciding.extent.0)),
        false => span_range(deciding.extent),
    };
    finding.observed = format!("a {noun} of {lasting}, {}", delay_words(delay, &claim.between.from));
    let margin = deciding.margin.filter(|_| !unfinished);
    finding.margin = margin.map(|margin| Figure::span(Span::from_nanos(margin)));
    finding.uncertainty = width(deciding.extent).filter(|_| !unfinished);
    finding.reason = match (spread.can_hold, spread.doubtful) {
        (false, _) if deciding.extent.1 < claim.width.0 => {
            format!("{} too short", Span::from_nanos(claim.width.0 - deciding.extent.1))
        }
        (false, _) if deciding.extent.0 > claim.width.1 => {
            format!("{} too long", Span::from_nanos(deciding.extent.0 - claim.width.1))
        }
        (false, _) => String::from("outside the limits in every placement"),
        (true, true) => format!("`{}` is not known for a part of the window", info.name),
        (true, false) if unfinished => String::from("the case ended within the pulse"),
        (true, false) => {
            String::from("the uncertainty of the instants reaches over a limit of the width or of the window")
        }
    };
    finding.decided_by(&deciding.seen)
}
