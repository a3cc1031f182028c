//! The keys of a measurement.

use std::sync::Arc;

use document::{Data, Fields, KeySpec, KeyType};

use super::gauge::{Bounds, time};
use super::{Limits, Measurement, Quantity};
use crate::codes;
use crate::expect::{Context, literal};
use crate::judge::edges::Edge;
use crate::lang::{Anchor, Literal};

const EDGE_KEYS: &[KeySpec] = &[
    KeySpec::required("signal", KeyType::SignalRef, "The signal that ends the time"),
    KeySpec::optional(
        "edge",
        KeyType::Choice(&["rises", "falls", "changes"]),
        "Which edge; `changes` if left out",
    ),
];

/// The keys of an entry of `measure`.
pub const KEYS: &[KeySpec] = &[
    KeySpec::required("name", KeyType::Text, "The name of the measurement in the report"),
    KeySpec::optional("from", KeyType::Anchor, "The instant at which a time begins"),
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
    KeySpec::optional("min", KeyType::Value, "The least value allowed, itself included"),
    KeySpec::optional("max", KeyType::Value, "The greatest value allowed, itself included"),
    KeySpec::optional("nominal", KeyType::Value, "The value wanted, with `tolerance`"),
    KeySpec::optional(
        "tolerance",
        KeyType::Value,
        "How far from `nominal` is allowed, or which part of it, as in \"10 %\"",
    ),
    KeySpec::optional("rows", KeyType::List(&KeyType::Text), "The rows that measure it; all if left out"),
];

/// Makes a measurement of a table that was held against [`KEYS`]. `rows` is the plan reader's. The caller
/// fills in where it stands.
pub fn read(fields: &Fields<'_>, cx: &mut Context<'_>) -> Option<Measurement> {
    let quantity = quantity(fields, cx);
    let limits = limits(fields, cx);
    let (quantity, limits) = (quantity?, limits?);
    if !matches!(quantity, Quantity::Value { .. }) {
        for key in ["min", "max", "nominal", "tolerance"] {
            let Some(node) = fields.get(key) else { continue };
            let limit = Literal::of(node).ok().and_then(|limit| limit.quantity());
            let timed = |limit: signal::Quantity| limit.is_time() || (key == "tolerance" && limit.is_part());
            if !limit.is_some_and(timed) {
                let message = format!("`{key}` limits a time and is no duration");
                cx.out.bad(codes::UNIT, node, message, "write it with a unit, as in \"6 us\"");
                return None;
            }
        }
        // A time is known to be one without any signal, so its limits are checked here.
        if let Err(why) = Bounds::new(&limits, &time()) {
            cx.out.error(codes::UNIT, cx.place.clone(), why, "write durations with a unit, as in \"6 us\"");
            return None;
        }
    }
    Some(Measurement {
        name: fields.text("name")?.to_owned(),
        quantity,
        limits: Arc::new(limits),
        place: None,
    })
}

fn quantity(fields: &Fields<'_>, cx: &mut Context<'_>) -> Option<Quantity> {
    let time = fields.has("from") || fields.has("to");
    if time == fields.has("value-of") {
        let message = "a measurement is a time with `from` and `to`, or a value with `value-of`";
        cx.out.error(codes::CLAIM, cx.place.clone(), message, "give one of them");
        return None;
    }
    if !time {
        let (signal, at) = cx.names.at_value(fields.get("value-of")?, cx.out)?;
        let when = match fields.get("when") {
            Some(node) => cx.names.anchor(node, cx.out)?,
            None => at.unwrap_or(Anchor::END),
        };
        return Some(Quantity::Value { signal, when });
    }
    if let Some(node) = fields.get("when") {
        cx.out.bad(codes::CLAIM, node, "`when` has no meaning for a time", "use `from` and `to`");
        return None;
    }
    let from = match fields.get("from") {
        Some(node) => cx.names.anchor(node, cx.out)?,
        None if fields.has("from") => return None,
        None => Anchor::START,
    };
    let Some(to) = fields.get("to") else {
        if !fields.has("to") {
            let message = "the time has no end: `to` is missing";
            cx.out.error(codes::MISSING_KEY, cx.place.clone(), message, "add `to`");
        }
        return None;
    };
    if let Data::Table(_) = to.data {
        let inner = fields.inner("to")?;
        let signal = cx.names.signal(inner.get("signal")?, cx.out)?;
        let edge = match inner.text("edge") {
            Some("rises") => Edge::Rises,
            Some("falls") => Edge::Falls,
            _ => Edge::Changes,
        };
        return Some(Quantity::ToEdge { from, signal, edge });
    }
    let to = cx.names.anchor(to, cx.out)?;
    Some(Quantity::Between { from, to })
}

fn limits(fields: &Fields<'_>, cx: &mut Context<'_>) -> Option<Limits> {
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
    Some(Limits { min, max, nominal })
}
