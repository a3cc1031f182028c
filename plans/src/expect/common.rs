//! What several verbs share: keys, windows, ranges and words.

use document::{Fields, KeySpec, KeyType, Node};
use signal::{Decimal, QuantityError, QuantityFault, QuantityRange, SignalInfo, Span, Value, is_range};

use super::{ClaimDemand, ReadContext};
use crate::codes;
use crate::lang::Anchor;

/// The signal that a verb looks at.
pub(super) const SIGNAL: KeySpec =
    KeySpec::required("signal", KeyType::SignalRef, "The signal that is looked at");
/// Where a window begins.
pub(super) const FROM: KeySpec =
    KeySpec::optional("from", KeyType::Anchor, "Where looking begins; `start` if left out");
/// Where a window ends.
pub(super) const UNTIL: KeySpec =
    KeySpec::optional("until", KeyType::Anchor, "Where looking ends, itself not included; `end` if left out");
/// The instant at which a value counts.
pub(super) const WHEN: KeySpec =
    KeySpec::optional("when", KeyType::Anchor, "The instant that counts; `end` if left out");
/// The pulses that count.
pub(crate) const LONGER: KeySpec = KeySpec::optional(
    "pulses-longer-than",
    KeyType::Duration,
    "Only pulses longer than this count, of either level; a channel that is sampled needs it where short ones that go unseen \
     could matter",
);

/// A window of the plan.
#[derive(Clone, Debug)]
pub(crate) struct PlanWindow {
    pub(crate) from: Anchor,
    pub(crate) until: Anchor,
}

impl PlanWindow {
    /// Reads `from` and `until`.
    pub(crate) fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<PlanWindow> {
        let from = anchor(fields, "from", Anchor::START, cx);
        let until = anchor(fields, "until", Anchor::END, cx);
        let (from, until) = (from?, until?);
        if from.base == until.base && from.offset >= until.offset {
            let node = fields.get("until").or_else(|| fields.get("from"))?;
            let message = format!("nothing lies between `{from}` and `{until}`: the claim can never fail");
            cx.out.bad(codes::CLAIM, node, message, "let `until` be later than `from`");
            return None;
        }
        Some(PlanWindow { from, until })
    }

    pub(super) fn anchors(&self) -> Vec<&Anchor> {
        vec![&self.from, &self.until]
    }

    /// That the claim looks between the two.
    pub(super) fn demand(&self) -> ClaimDemand<'_> {
        ClaimDemand::Window { from: &self.from, until: &self.until }
    }

    /// ` from busy until end`; empty for the whole case.
    pub(super) fn words(&self) -> String {
        match (self.from == Anchor::START, self.until == Anchor::END) {
            (true, true) => String::new(),
            (false, true) => format!(" from {}", self.from),
            (true, false) => format!(" until {}", self.until),
            (false, false) => format!(" from {} until {}", self.from, self.until),
        }
    }
}

/// Reads an instant, or takes the default if the key is left out.
pub(super) fn anchor(
    fields: &Fields<'_>,
    key: &str,
    default: Anchor,
    cx: &mut ReadContext<'_>,
) -> Option<Anchor> {
    match fields.get(key) {
        Some(node) => cx.names.anchor(node, cx.out),
        None if fields.has(key) => None,
        // In a group counting begins where the group is run.
        None if default == Anchor::START => Some(cx.names.begin()),
        None => Some(default),
    }
}

/// Reads the name of a signal.
pub(super) fn signal(fields: &Fields<'_>, key: &str, cx: &mut ReadContext<'_>) -> Option<String> {
    cx.names.signal(fields.get(key)?, cx.out)
}

/// Least and greatest number or duration, both included.
pub(crate) type SpanLimits = (i64, i64);

/// How a range of durations without `..` is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SingleSpan {
    /// As the greatest: `within = "5 ms"`.
    Most,
    /// As the only one: `is = "5 ms"`.
    Exactly,
}

/// Reads a range of durations such as `100 ms .. 100.3 ms`, `.. 5 ms`, `5 ms ..` or `10 ms ± 1 ms`.
pub(super) fn spans(
    node: &Node,
    key: &str,
    single: SingleSpan,
    cx: &mut ReadContext<'_>,
) -> Option<SpanLimits> {
    let Some(text) = node.as_text() else {
        let help = "durations need a unit: write \"100 ms .. 100.3 ms\"";
        cx.out.bad(
            codes::WRONG_TYPE,
            node,
            format!("`{key}` is {}, not a range of durations", node.kind()),
            help,
        );
        return None;
    };
    match Span::parse_range(text) {
        Ok((_, most)) if single == SingleSpan::Most && !is_range(text) => Some((0, most.as_nanos())),
        Ok((least, most)) => Some((least.as_nanos(), most.as_nanos())),
        Err(error) => {
            let help = "write \"100 ms .. 100.3 ms\", \".. 5 ms\", \"5 ms ..\" or \"10 ms ± 1 ms\"";
            bad_range(node, key, "range of durations", error, help, cx);
            None
        }
    }
}

/// Reports what is wrong with a range.
pub(super) fn bad_range(
    node: &Node,
    key: &str,
    kind: &str,
    error: QuantityError,
    help: &str,
    cx: &mut ReadContext<'_>,
) {
    if error.fault == QuantityFault::Reversed {
        let message = format!("`{key}` is empty: its end lies before its beginning");
        cx.out.bad(codes::CLAIM, node, message, "write the smaller one first");
        return;
    }
    let rest = node.as_text().and_then(|text| text.get(error.at..)).unwrap_or_default();
    let length = rest.find(char::is_whitespace).unwrap_or(rest.len());
    let message = format!("`{key}` does not read as a {kind}: {error}");
    cx.out.bad_inside(codes::UNREADABLE, node, Some(error.at..error.at + length), message, help);
}

/// Reads a number of events: `1`, `"2 .. 5"`, `"3 .."`.
pub(super) fn counts(node: &Node, key: &str, cx: &mut ReadContext<'_>) -> Option<(u64, u64)> {
    let count = |number: Decimal| u64::try_from(number.as_whole()?).ok();
    let range = match &node.data {
        document::Data::Integer(n) => u64::try_from(*n).ok().map(|n| (n, n)),
        document::Data::Text(text) => QuantityRange::parse(text).ok().and_then(|range| {
            let ends = [&range.min, &range.max];
            if ends.into_iter().flatten().any(|end| !end.unit.is_none()) {
                return None;
            }
            let least = range.min.map_or(Some(0), |end| count(end.number));
            least.zip(range.max.map_or(Some(u64::MAX), |end| count(end.number)))
        }),
        _ => None,
    };
    if range.is_none() {
        let message = format!("`{key}` is no number of edges");
        cx.out.bad(
            codes::UNREADABLE,
            node,
            message,
            "write a number such as 1, or a range such as \"1 .. 3\"",
        );
    }
    range
}

/// `100 ms .. 100.3 ms`, or a single duration, or an open range.
pub(crate) fn span_range(limits: SpanLimits) -> String {
    let show = Span::from_nanos;
    match limits {
        (least, most) if least == most => show(least).to_string(),
        (0, i64::MAX) => String::from("any time"),
        (least, i64::MAX) => format!("at least {}", show(least)),
        (i64::MIN, most) => format!("at most {}", show(most)),
        (least, most) => format!("{} .. {}", show(least), show(most)),
    }
}

/// `3`, `2 .. 5`, `at least 2`.
pub(super) fn count_range(limits: (u64, u64)) -> String {
    match limits {
        (least, most) if least == most => least.to_string(),
        (least, u64::MAX) => format!("at least {least}"),
        (least, most) => format!("{least} .. {most}"),
    }
}

/// `100.2 ms after busy`, `3 ms before busy`, `at busy`; an interval where the delay is not exact.
pub(crate) fn delay_words(delay: (i64, i64), anchor: &Anchor) -> String {
    match delay {
        (0, 0) => format!("at {anchor}"),
        (least, most) if most <= 0 && least < 0 && most != i64::MIN => {
            let back = (most.saturating_neg(), least.saturating_neg());
            format!("{} before {anchor}", span_range(back))
        }
        (least, most) if least < 0 && least != i64::MIN => {
            format!("{} before to {} after {anchor}", Span::from_nanos(-least), Span::from_nanos(most))
        }
        delay => format!("{} after {anchor}", span_range(delay)),
    }
}

/// How far inside its limits a number of events is in the worst placement; as of a time, 0 is no least limit.
pub(super) fn count_margin(seen: (u64, u64), limits: (u64, u64)) -> Option<f64> {
    let above = (limits.0 > 0).then_some(seen.0 as f64 - limits.0 as f64);
    let below = (limits.1 < u64::MAX).then_some(limits.1 as f64 - seen.1 as f64);
    above.into_iter().chain(below).reduce(f64::min)
}

/// How wide an interval is, if it is not a point.
pub(super) fn width(interval: (i64, i64)) -> Option<record::Figure> {
    let width = interval.1.saturating_sub(interval.0);
    (width > 0).then(|| record::Figure::span(Span::from_nanos(width)))
}

/// That what a signal had was no evidence, in words for a reason: it was not known, or too near to a limit.
pub(crate) fn unclear(info: &SignalInfo, value: Value, whole: &str) -> String {
    match value {
        Value::Measured(..) => {
            format!("`{}` was {}: a limit lies within its uncertainty", info.name, info.show(value))
        }
        _ => format!("`{}` is not known for a part of {whole}", info.name),
    }
}

/// How wide the interval of a number is that was measured: what it is uncertain by, and the deadband that it is kept
/// with. `None` for a number that is exact, or only kept with a deadband.
pub(super) fn within(uncertainty: f64, slack: f64, info: &SignalInfo) -> Option<record::Figure> {
    (uncertainty > 0.0).then(|| record::Figure::new(2.0 * (uncertainty + slack), info.unit.clone()))
}
