//! The keys of a measurement.

use std::sync::Arc;

use document::{Data, Fields, KeySpec, KeyType};
use record::GuardBand;
use signal::Unit;

use super::gauge::{LimitNumbers, time};
use super::{MeasuredQuantity, Measurement, MeasurementLimits, Statistic, WindowFigure};
use crate::codes;
use crate::expect::band::figure;
use crate::expect::jitter::{COMPARES, GRID, asked};
use crate::expect::profile::ShapedTrain;
use crate::expect::train::TrainLines;
use crate::expect::{LONGER, PlanWindow, ReadContext, literal, position, profile};
use crate::lang::{Anchor, Literal};
use crate::monitor::edges::CountedEdge;

const EDGE_KEYS: &[KeySpec] = &[
    KeySpec::required("signal", KeyType::SignalRef, "The signal that ends the time"),
    KeySpec::optional(
        "edge",
        KeyType::Choice(&["rises", "falls", "changes"]),
        "Which edge; `changes` if left out",
    ),
];

/// The key of the guard band, of a measurement and of a plan.
pub(crate) const GUARD: &str = "guard";

/// Its values.
pub(crate) const GUARDS: &[&str] = &["uncertainty", "none"];

/// What a table says of the guard band.
pub(crate) fn guard(fields: &Fields<'_>) -> Option<GuardBand> {
    Some(match fields.text(GUARD)? {
        "none" => GuardBand::None,
        _ => GuardBand::Uncertainty,
    })
}

/// The keys that are limits.
pub(crate) const LIMITS: [&str; 3] = ["min", "max", "nominal"];

/// The keys of an entry of `measure`.
pub const KEYS: &[KeySpec] = &[
    KeySpec::required("name", KeyType::Text, "The name of the measurement in the report"),
    KeySpec::optional("from", KeyType::Anchor, "The instant at which a time or a window begins"),
    KeySpec::optional(
        "to",
        KeyType::Either(&[KeyType::Anchor, KeyType::Table(EDGE_KEYS)]),
        "The instant, or the first edge after `from`, at which it ends",
    ),
    KeySpec::optional(
        "value-of",
        KeyType::SignalRef,
        "The signal whose value is measured, in place of `from`",
    ),
    KeySpec::optional("when", KeyType::Anchor, "The instant of the value; `end` if left out"),
    KeySpec::optional(
        "frequency-of",
        KeyType::SignalRef,
        "The signal whose mean frequency from `from` until `until` is measured",
    ),
    KeySpec::optional(
        "duty-of",
        KeyType::SignalRef,
        "The signal of which the part of the time in which it is TRUE is measured, over whole cycles",
    ),
    KeySpec::optional("period-of", KeyType::SignalRef, "The signal whose cycles are measured"),
    KeySpec::optional("width-of", KeyType::SignalRef, "The signal whose pulses are measured"),
    KeySpec::optional("speed-of", KeyType::SignalRef, "The count whose change per second is measured"),
    KeySpec::optional("jitter-of", KeyType::SignalRef, "The signal whose jitter is measured"),
    COMPARES,
    GRID,
    KeySpec::optional(
        "position-of",
        KeyType::Table(position::KEYS),
        "The pulse train whose position is measured: by how much it goes forwards from `from` until `until`",
    ),
    KeySpec::optional(
        "profile-of",
        KeyType::Table(profile::KEYS),
        "The pulse train and the shape of its frequency: by how much it is off at most is measured",
    ),
    KeySpec::optional(
        "take",
        KeyType::Choice(Statistic::NAMES),
        "What is taken of several: of values over a window, of periods or of widths",
    ),
    KeySpec::optional(
        "level",
        KeyType::Choice(&["high", "low"]),
        "The level of the pulses of `width-of`; `high` if left out",
    ),
    KeySpec::optional(
        "until",
        KeyType::Anchor,
        "Where a window ends, itself not included; `end` if left out",
    ),
    KeySpec::optional("min", KeyType::Value, "The least value allowed, itself included"),
    KeySpec::optional("max", KeyType::Value, "The greatest value allowed, itself included"),
    KeySpec::optional("nominal", KeyType::Value, "The value wanted, with `tolerance`"),
    KeySpec::optional(
        "tolerance",
        KeyType::Value,
        "How far from `nominal` is allowed, or which part of it, as in \"10 %\"",
    ),
    KeySpec::optional(
        GUARD,
        KeyType::Choice(GUARDS),
        "How its uncertainty counts against the limits: a guard band, or none; as the plan has it if left out",
    ),
    LONGER,
    KeySpec::optional("rows", KeyType::List(&KeyType::Text), "The rows that measure it; all if left out"),
];

/// Makes a measurement of a table that was held against [`KEYS`]. `rows` is the plan reader's; so is `default`, the
/// guard band of those that name none. The caller fills in where it stands.
pub fn read(fields: &Fields<'_>, default: GuardBand, cx: &mut ReadContext<'_>) -> Option<Measurement> {
    let quantity = quantity(fields, cx);
    let limits = limits(fields, cx);
    let (quantity, limits) = (quantity?, limits?);
    if limits == MeasurementLimits::default() {
        lacks(fields, &[GUARD], "a measurement without limits", cx)?;
    }
    let own = match &quantity {
        MeasuredQuantity::Value { .. } => None,
        MeasuredQuantity::Between { .. } | MeasuredQuantity::ToEdge { .. } => Some("ns"),
        MeasuredQuantity::Over { figure, .. } => figure.own_unit(),
        MeasuredQuantity::Position { .. } => None,
        MeasuredQuantity::Profile { .. } => Some("Hz"),
    };
    if let Some(unit) = own {
        has_units(fields, unit, cx)?;
        // Its unit is known without any signal, so the limits are checked here.
        let info = if unit == "ns" { time() } else { figure(&quantity.to_string(), unit) };
        if let Err(why) = LimitNumbers::new(&limits, &info) {
            let help = format!("write limits with a unit, as in \"{}\"", example(unit));
            cx.out.error(codes::UNIT, cx.place.clone(), why, help);
            return None;
        }
    }
    Some(Measurement {
        name: fields.text("name")?.to_owned(),
        quantity,
        limits: Arc::new(limits),
        guard: guard(fields).unwrap_or(default),
        longer_than: fields.duration(LONGER.name),
        place: None,
    })
}

/// A limit as it should be written.
fn example(unit: &str) -> &'static str {
    match unit {
        "Hz" => "50 Hz",
        "%" => "50 %",
        _ => "6 us",
    }
}

/// Reports a limit without the unit that the measurement has: 50 could be hertz or kilohertz.
fn has_units(fields: &Fields<'_>, unit: &str, cx: &mut ReadContext<'_>) -> Option<()> {
    for key in ["min", "max", "nominal", "tolerance"] {
        let Some(node) = fields.get(key) else { continue };
        let limit = Literal::of(node).ok().and_then(|limit| limit.quantity());
        let meant = |limit: signal::Quantity| {
            limit.in_unit(&Unit::new(unit)).is_some() || (key == "tolerance" && limit.is_part())
        };
        if !limit.is_some_and(meant) {
            let message = match unit {
                "ns" => format!("`{key}` limits a time and is no duration"),
                unit => format!("`{key}` limits a figure in {unit} and is none"),
            };
            let help = format!("write it with a unit, as in \"{}\"", example(unit));
            cx.out.bad(codes::UNIT, node, message, help);
            return None;
        }
    }
    Some(())
}

/// The keys that name what is measured of a signal.
const OF: &[&str] = &[
    "value-of",
    "frequency-of",
    "duty-of",
    "period-of",
    "width-of",
    "speed-of",
    "jitter-of",
    "position-of",
    "profile-of",
];

fn quantity(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<MeasuredQuantity> {
    let given: Vec<&str> = OF.iter().copied().filter(|key| fields.has(key)).collect();
    match given.as_slice() {
        [] if fields.has("from") || fields.has("to") => {
            lacks(fields, &["when", "take", "level", "until", "compares", "grid"], "a time", cx)
                .and_then(|()| time_between(fields, cx))
        }
        ["value-of"] if !fields.has("take") => {
            let others = ["from", "to", "until", "level", "compares", "grid", LONGER.name];
            lacks(fields, &others, "a value at an instant", cx)?;
            let (signal, at) = cx.names.at_value(fields.get("value-of")?, cx.out)?;
            let when = match fields.get("when") {
                Some(node) => cx.names.anchor(node, cx.out)?,
                None => at.unwrap_or(Anchor::END),
            };
            Some(MeasuredQuantity::Value { signal, when })
        }
        [key @ ("position-of" | "profile-of")] => train(fields, key, cx),
        [key] => over(fields, key, cx),
        _ => {
            let message = "a measurement is a time with `from` and `to`, or of one signal";
            let help = format!("give `to`, or one of `{}`", OF.join("`, `"));
            cx.out.error(codes::CLAIM, cx.place.clone(), message, help);
            None
        }
    }
}

/// Reports keys that say nothing of this kind of measurement.
fn lacks(fields: &Fields<'_>, keys: &[&str], what: &str, cx: &mut ReadContext<'_>) -> Option<()> {
    let key = keys.iter().find(|key| fields.has(key));
    let Some(key) = key else { return Some(()) };
    let place = fields.entry(key)?.key_span.clone();
    let help = match *key {
        "from" | "until" => "a value over a window says with `take` what is taken of it",
        "pulses-longer-than" => "of a pulse train it stands among the keys of its lines; else leave it out",
        _ => "leave it out",
    };
    cx.out.error(codes::MEASURE, place, format!("`{key}` has no meaning for {what}"), help);
    None
}

/// Reads what is measured of a pulse train.
fn train(fields: &Fields<'_>, key: &str, cx: &mut ReadContext<'_>) -> Option<MeasuredQuantity> {
    let what = if key == "position-of" { "a position" } else { "a profile" };
    lacks(fields, &["to", "when", "take", "level", "compares", "grid", LONGER.name], what, cx)?;
    let inner = fields.inner(key)?;
    let place = std::mem::replace(&mut cx.place, fields.get(key)?.span.clone());
    let quantity = match key {
        "position-of" => {
            TrainLines::read(&inner, cx).zip(PlanWindow::read(fields, cx)).map(|(train, between)| {
                MeasuredQuantity::Position { train, from: between.from, until: between.until }
            })
        }
        _ => ShapedTrain::read(&inner, cx).zip(PlanWindow::read(fields, cx)).map(|(shaped, between)| {
            MeasuredQuantity::Profile { shaped: Box::new(shaped), from: between.from, until: between.until }
        }),
    };
    cx.place = place;
    quantity
}

/// Reads what is measured over a window.
fn over(fields: &Fields<'_>, key: &str, cx: &mut ReadContext<'_>) -> Option<MeasuredQuantity> {
    let what = match key {
        "value-of" => "a value over a window",
        "frequency-of" => "a frequency",
        "duty-of" => "a duty",
        "period-of" => "a period",
        "speed-of" => "a speed",
        "jitter-of" => "a jitter",
        _ => "a width",
    };
    lacks(fields, &["to", "when"], what, cx)?;
    let takes: &[Statistic] = match key {
        "value-of" => &[Statistic::Min, Statistic::Max, Statistic::Mean, Statistic::Rms, Statistic::Span],
        "period-of" => &[Statistic::Mean, Statistic::Min, Statistic::Max, Statistic::Span],
        "width-of" => &[Statistic::First, Statistic::Mean, Statistic::Min, Statistic::Max, Statistic::Span],
        "jitter-of" => &[Statistic::Span, Statistic::Rms],
        _ => &[],
    };
    if key != "width-of" {
        lacks(fields, &["level"], what, cx)?;
    }
    if key != "jitter-of" {
        lacks(fields, &["compares", "grid"], what, cx)?;
    }
    if key == "speed-of" {
        lacks(fields, &[LONGER.name], what, cx)?;
    }
    if takes.is_empty() {
        lacks(fields, &["take"], what, cx)?;
    }
    let take = match fields.text("take").and_then(Statistic::find) {
        Some(take) if takes.contains(&take) => take,
        Some(_) => {
            let node = fields.get("take")?;
            let place =
                |take: &Statistic| Statistic::ALL.iter().position(|known| known == take).unwrap_or_default();
            let names: Vec<&str> = takes.iter().map(|take| Statistic::NAMES[place(take)]).collect();
            let help = format!("one of {}", names.join(", "));
            cx.out.bad(codes::MEASURE, node, format!("{what} has no such figure"), help);
            return None;
        }
        None => takes.first().copied().unwrap_or(Statistic::Mean),
    };
    let figure = match key {
        "frequency-of" => WindowFigure::Frequency,
        "duty-of" => WindowFigure::Duty,
        "period-of" => WindowFigure::Period(take),
        "speed-of" => WindowFigure::Speed,
        "jitter-of" => WindowFigure::Jitter(asked(fields, cx)?),
        "width-of" => WindowFigure::Width { high: fields.text("level") != Some("low"), take },
        _ => WindowFigure::Value(take),
    };
    let signal = cx.names.signal(fields.get(key)?, cx.out);
    let between = PlanWindow::read(fields, cx)?;
    Some(MeasuredQuantity::Over { signal: signal?, from: between.from, until: between.until, figure })
}

/// Reads a time with its two ends.
fn time_between(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<MeasuredQuantity> {
    let from = match fields.get("from") {
        Some(node) => cx.names.anchor(node, cx.out)?,
        None if fields.has("from") => return None,
        None => cx.names.begin(),
    };
    let Some(to) = fields.get("to") else {
        if !fields.has("to") {
            let message = "the time has no end: `to` is missing";
            cx.out.error(codes::MISSING_KEY, cx.place.clone(), message, "add `to`");
        }
        return None;
    };
    let Data::Table(_) = to.data else {
        lacks(fields, &[LONGER.name], "a time between two instants", cx)?;
        let to = cx.names.anchor(to, cx.out)?;
        return Some(MeasuredQuantity::Between { from, to });
    };
    let inner = fields.inner("to")?;
    let signal = cx.names.signal(inner.get("signal")?, cx.out)?;
    let edge = match inner.text("edge") {
        Some("rises") => CountedEdge::Rises,
        Some("falls") => CountedEdge::Falls,
        _ => CountedEdge::Changes,
    };
    Some(MeasuredQuantity::ToEdge { from, signal, edge })
}

fn limits(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<MeasurementLimits> {
    let mut read = |key| match fields.get(key) {
        Some(node) => literal(node, cx).map(Some),
        None if fields.has(key) => None,
        None => Some(None),
    };
    let (min, max) = (read("min")?, read("max")?);
    let nominal = match (read("nominal")?, read("tolerance")?) {
        (Some(nominal), Some(tolerance)) => Some((nominal, tolerance)),
        (None, None) => None,
        _ => {
            let message = "`nominal` and `tolerance` go together";
            cx.out.error(codes::CLAIM, cx.place.clone(), message, "give both or neither");
            return None;
        }
    };
    if nominal.is_some() && (min.is_some() || max.is_some()) {
        let message = "the limits are given in two ways";
        let help = "give `min` and `max`, or `nominal` and `tolerance`";
        cx.out.error(codes::CLAIM, cx.place.clone(), message, help);
        return None;
    }
    Some(MeasurementLimits { min, max, nominal })
}
