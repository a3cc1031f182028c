//! Shapes of a frequency over time as a plan writes them: points, or a move of an axis.

use document::{Data, Fields, KeySpec, KeyType, Node};
use signal::{Quantity, Unit};

use super::ReadContext;
use crate::codes;
use crate::monitor::shape::FrequencyShape;

/// Most points of a shape.
const MOST: usize = 1_000;
/// Straight pieces that a curved part of a ramp is made of. They keep to the curve to within a 16 000th of what it changes.
const CHORDS: u32 = 64;
/// Steps by which the highest velocity of a short move is found.
const HALVINGS: u32 = 100;
/// Most pulses of a move.
const LONGEST: i64 = 4_294_967_295;

const POINT_KEYS: &[KeySpec] = &[
    KeySpec::required("at", KeyType::Duration, "How long after `from`"),
    KeySpec::required(
        "frequency",
        KeyType::Text,
        "The frequency from there on, as in \"20 kHz\"; below 0 backwards",
    ),
    KeySpec::optional(
        "jerk-ratio",
        KeyType::Text,
        "The part of the way from the point before that is curved, as in \"50 %\"; none if left out",
    )
    .was("curved"),
];
const POINT: KeyType = KeyType::Table(POINT_KEYS);

const MOVE_KEYS: &[KeySpec] = &[
    KeySpec::optional(
        "by",
        KeyType::Integer(-LONGEST, LONGEST),
        "How many pulses; below 0 backwards; without an end if left out",
    ),
    KeySpec::required("speed", KeyType::Text, "The velocity that it goes up to, as in \"20 kHz\""),
    KeySpec::required("acceleration", KeyType::Text, "How it gets faster, as in \"200 Hz/ms\""),
    KeySpec::optional("deceleration", KeyType::Text, "How it gets slower; as `acceleration` if left out"),
    KeySpec::optional("start", KeyType::Text, "The velocity that it begins with; 0 Hz if left out"),
    KeySpec::optional("stop", KeyType::Text, "The velocity that it ends with; 0 Hz if left out"),
    KeySpec::optional(
        "jerk-ratio",
        KeyType::Text,
        "The part of each ramp that is curved, as in \"50 %\"; none if left out",
    )
    .was("curved"),
];

/// Points.
pub(crate) const POINTS: KeySpec = KeySpec::optional(
    "points",
    KeyType::List(&POINT),
    "The shape as points that straight lines join; two at one instant are a jump",
);
/// A move.
pub(crate) const MOVE: KeySpec = KeySpec::optional(
    "move",
    KeyType::Table(MOVE_KEYS),
    "The shape as the move of an axis: faster, steady, slower, with an even rate or in S-curves",
);

/// Reads `points` or `move`.
pub(crate) fn read(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<FrequencyShape> {
    match (fields.get("points"), fields.inner("move")) {
        (Some(node), None) => points(node, fields, cx),
        (None, Some(inner)) => a_move(&inner, fields.get("move")?, cx),
        _ if fields.has("points") != fields.has("move") => None,
        (given, _) => {
            let message = match given {
                None => "the profile has no shape",
                Some(_) => "the shape is given in two ways",
            };
            cx.out.error(codes::SHAPE, cx.place.clone(), message, "give `points` or `move`");
            None
        }
    }
}

/// A number in one of some units, each with what one of it is.
fn number(
    fields: &Fields<'_>,
    key: &str,
    units: &[(&str, f64)],
    right: impl Fn(f64) -> bool,
    cx: &mut ReadContext<'_>,
) -> Option<f64> {
    let node = fields.get(key)?;
    let quantity = node.as_text().and_then(|text| Quantity::parse(text).ok());
    let known = |quantity: &Quantity| {
        units.iter().find_map(|(unit, one)| Some(quantity.in_unit(&Unit::new(unit))?.as_f64() * one))
    };
    let number = quantity.as_ref().and_then(known).filter(|number| right(*number));
    if number.is_none() {
        let (noun, example) = match units[0].0 {
            "Hz" => ("frequency that it can have", "20 kHz"),
            "%" => ("part of a ramp", "50 %"),
            _ => ("rate at which a frequency changes", "200 Hz/ms"),
        };
        let message = format!("`{key}` is no {noun}");
        cx.out.bad(codes::SHAPE, node, message, format!("write it as \"{example}\""));
    }
    number
}

const FREQUENCY: &[(&str, f64)] = &[("Hz", 1.0)];
const RATE: &[(&str, f64)] = &[("Hz/ms", 1e3), ("kHz/s", 1e3), ("kHz/ms", 1e6), ("Hz/s", 1.0)];
const PART: &[(&str, f64)] = &[("%", 0.01)];
/// Highest frequency: edges closer than a nanosecond have no order.
const HIGHEST: f64 = 1e9;

fn curved(fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<f64> {
    if !fields.has("jerk-ratio") {
        return Some(0.0);
    }
    number(fields, "jerk-ratio", PART, |part| (0.0..=1.0).contains(&part), cx)
}

fn points(node: &Node, fields: &Fields<'_>, cx: &mut ReadContext<'_>) -> Option<FrequencyShape> {
    let list = fields.each("points");
    if list.is_empty() || list.len() > MOST {
        let message = format!("a shape has 1 to {MOST} points");
        cx.out.bad(codes::SHAPE, node, message, "as in { at = \"10 ms\", frequency = \"20 kHz\" }");
        return None;
    }
    let mut shape = FrequencyShape::default();
    let (mut before, mut same): (Option<(f64, f64)>, u32) = (None, 0);
    for one in list {
        let Data::Table(table) = &one.data else { return None };
        let point = Fields::checked(table, POINT_KEYS);
        let at = point.duration("at")?.as_nanos() as f64;
        let frequency = number(&point, "frequency", FREQUENCY, |hertz| hertz.abs() <= HIGHEST, cx)?;
        let curved = curved(&point, cx)?;
        let (then, last) = before.unwrap_or((0.0, 0.0));
        same = if before.is_some() && at == then { same + 1 } else { 0 };
        if at < then || same > 1 {
            let message = "a point comes before the one in front of it, or is the third at its instant";
            cx.out.bad(
                codes::SHAPE,
                point.get("at")?,
                message,
                "write points in the order of their instants",
            );
            return None;
        }
        match before {
            None => shape.go(at, 0.0, 0.0),
            Some(_) => ramp(&mut shape, at - then, last, frequency, curved),
        }
        before = Some((at, frequency));
    }
    Some(shape.stay(before?.1))
}

/// Adds a change of frequency over a time, a part of which is curved: the rate grows evenly over half of that part and
/// shrinks evenly over the other half (io:STD-PTO-07).
fn ramp(shape: &mut FrequencyShape, length: f64, first: f64, last: f64, curved: f64) {
    let bend = length * curved / 2.0;
    if bend <= 0.0 || length <= 0.0 {
        shape.go(length, first, last);
        return;
    }
    let part = (last - first) * bend / (2.0 * (length - bend));
    let square = |n: u32| {
        let part = f64::from(n) / f64::from(CHORDS);
        part * part
    };
    for n in 0..CHORDS {
        shape.go(bend / f64::from(CHORDS), first + part * square(n), first + part * square(n + 1));
    }
    shape.go(length - 2.0 * bend, first + part, last - part);
    for n in (0..CHORDS).rev() {
        shape.go(bend / f64::from(CHORDS), last - part * square(n + 1), last - part * square(n));
    }
}

fn a_move(fields: &Fields<'_>, node: &Node, cx: &mut ReadContext<'_>) -> Option<FrequencyShape> {
    let above = |hertz: f64| hertz > 0.0 && hertz <= HIGHEST;
    let speed = number(fields, "speed", FREQUENCY, above, cx);
    let rise = number(fields, "acceleration", RATE, |rate| rate > 0.0, cx);
    let fall = match fields.has("deceleration") {
        true => number(fields, "deceleration", RATE, |rate| rate > 0.0, cx),
        false => rise,
    };
    let mut end = |key| match fields.has(key) {
        true => number(fields, key, FREQUENCY, |hertz| (0.0..=HIGHEST).contains(&hertz), cx),
        false => Some(0.0),
    };
    let (start, stop) = (end("start"), end("stop"));
    let curved = curved(fields, cx);
    let (speed, rise, fall, start, stop, curved) = (speed?, rise?, fall?, start?, stop?, curved?);
    const SECOND: f64 = 1e9;
    let mut shape = FrequencyShape::default();
    let Some(by) = fields.integer("by") else {
        if let Some(entry) = ["deceleration", "stop"].into_iter().find_map(|key| fields.entry(key)) {
            let message = format!("a move without an end has no `{}`", entry.key);
            cx.out.error(codes::SHAPE, entry.key_span.clone(), message, "add `by`, or remove it");
            return None;
        }
        let first = start.min(speed);
        ramp(&mut shape, (speed - first) / rise * SECOND, first, speed, curved);
        return Some(shape.stay(speed));
    };
    if by == 0 {
        cx.out.bad(codes::SHAPE, node, "a move by 0 has no shape", "claim that the position stays");
        return None;
    }
    let way = if by < 0 { -1.0 } else { 1.0 };
    let distance = by.unsigned_abs() as f64;
    let ramps = |peak: f64| {
        let (first, last) = (start.min(peak), stop.min(peak));
        (first, last, (peak - first) / rise, (peak - last) / fall)
    };
    let covered = |peak: f64| {
        let (first, last, up, down) = ramps(peak);
        (first + peak) / 2.0 * up + (peak + last) / 2.0 * down
    };
    // The highest velocity from which there is still way enough to slow down.
    let (mut low, mut peak) = (0.0, speed);
    if covered(peak) > distance {
        for _ in 0..HALVINGS {
            let middle = low + (peak - low) / 2.0;
            if covered(middle) <= distance { low = middle } else { peak = middle }
        }
        peak = low;
    }
    let (first, last, up, down) = ramps(peak);
    let steady = ((distance - covered(peak)) / peak).max(0.0);
    ramp(&mut shape, up * SECOND, way * first, way * peak, curved);
    shape.go(steady * SECOND, way * peak, way * peak);
    ramp(&mut shape, down * SECOND, way * peak, way * last, curved);
    Some(shape.stay(0.0))
}
