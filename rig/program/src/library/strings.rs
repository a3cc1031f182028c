//! Functions of texts. Positions count from 1; nothing about them can fail: what lies outside of the text is not there.
//!
//! The standard calls positions outside of the text errors. Where the documents of the controllers' Standard library say
//! what happens there (DELETE and REPLACE at 0, INSERT below 0), it happens here too.

use super::Accepts::{AnyInt, AnyText};
use super::{Accepts, Body, Function, Gives, Text, TextCall};
use crate::types::Elementary::Int;

const fn text(
    name: &'static str,
    parameters: &'static [(&'static str, Accepts)],
    gives: Gives,
    body: fn(&mut TextCall<'_>),
) -> Function {
    Function { name, parameters, extensible: false, gives, body: Body::Text(body) }
}

/// A text and how many of its characters.
const PART: &[(&str, Accepts)] = &[("STR", AnyText), ("SIZE", AnyInt)];
/// A text, how many of its characters, and from which one on.
const RANGE: &[(&str, Accepts)] = &[("STR", AnyText), ("LEN", AnyInt), ("POS", AnyInt)];
const TWO: &[(&str, Accepts)] = &[("STR1", AnyText), ("STR2", AnyText)];

/// The functions of the standard, which the controllers' Standard library has for STRING.
pub(super) const FUNCTIONS: &[Function] = &[
    text("LEN", &[("STR", AnyText)], Gives::Exact(Int), |call| {
        call.result = int(first(call).length());
    }),
    text("LEFT", PART, Gives::Text, left),
    text("RIGHT", PART, Gives::Text, right),
    text("MID", RANGE, Gives::Text, mid),
    Function {
        name: "CONCAT",
        parameters: TWO,
        extensible: true,
        gives: Gives::Text,
        body: Body::Text(concat),
    },
    text("INSERT", &[("STR1", AnyText), ("STR2", AnyText), ("POS", AnyInt)], Gives::Text, insert),
    text("DELETE", RANGE, Gives::Text, delete),
    text(
        "REPLACE",
        &[("STR1", AnyText), ("STR2", AnyText), ("L", AnyInt), ("P", AnyInt)],
        Gives::Text,
        replace,
    ),
    text("FIND", TWO, Gives::Exact(Int), find),
];

/// The place of a parameter by the standard's name where that is not ours, or by its number in CONCAT.
pub(super) fn other_name(function: &Function, key: &str) -> Option<usize> {
    let names: &[&str] = match function.name {
        "LEN" => &["IN"],
        "LEFT" | "RIGHT" => &["IN", "L"],
        "MID" | "DELETE" => &["IN", "L", "P"],
        "INSERT" => &["IN1", "IN2", "P"],
        "REPLACE" | "FIND" => &["IN1", "IN2"],
        "CONCAT" => {
            let number = key.strip_prefix("IN").or_else(|| key.strip_prefix("STR"))?;
            return number.parse::<usize>().ok()?.checked_sub(1);
        }
        _ => &[],
    };
    names.iter().position(|name| *name == key)
}

fn first<'a>(call: &TextCall<'a>) -> Text<'a> {
    text_at(call, 0)
}

fn text_at<'a>(call: &TextCall<'a>, place: usize) -> Text<'a> {
    call.texts.get(place).copied().unwrap_or(Text { wide: false, bytes: &[] })
}

fn cell(call: &TextCall<'_>, place: usize) -> i64 {
    super::argument(call.cells, place)
}

/// A length or a position as INT, at most its largest.
fn int(count: usize) -> i64 {
    count.min(i16::MAX as usize) as i64
}

/// A number of characters: none for a negative one.
fn count(number: i64) -> usize {
    usize::try_from(number).unwrap_or(0)
}

/// The places before and after the characters `position` to `position + length - 1`, as far as there are such. Position
/// 0 is one in front of the first character, so one character less is meant.
fn span(length: i64, position: i64, total: usize) -> (usize, usize) {
    let start = count(position.saturating_sub(1)).min(total);
    let end = count(position.saturating_add(length.max(0)).saturating_sub(1)).min(total);
    (start, end.max(start))
}

/// The first SIZE characters.
fn left(call: &mut TextCall<'_>) {
    let size = count(cell(call, 0));
    call.out.clear();
    call.out.extend(first(call).units().take(size));
}

/// The last SIZE characters.
fn right(call: &mut TextCall<'_>) {
    let text = first(call);
    let skip = text.length().saturating_sub(count(cell(call, 0)));
    call.out.clear();
    call.out.extend(text.units().skip(skip));
}

/// LEN characters from POS on. A negative POS gives an empty text.
fn mid(call: &mut TextCall<'_>) {
    let (text, position) = (first(call), cell(call, 1));
    let (start, end) = span(cell(call, 0), position, text.length());
    call.out.clear();
    if position >= 0 {
        call.out.extend(text.units().take(end).skip(start));
    }
}

/// All texts one after the other.
fn concat(call: &mut TextCall<'_>) {
    call.out.clear();
    for text in call.texts {
        call.out.extend(text.units());
    }
}

/// STR1 with STR2 after the character POS: at the start for 0, at the end from the length on. A negative POS leaves
/// STR1 as it is.
fn insert(call: &mut TextCall<'_>) {
    let (text, position) = (first(call), cell(call, 0));
    let inserted = text_at(call, 1);
    call.out.clear();
    call.out.extend(text.units().take(count(position)));
    if position >= 0 {
        call.out.extend(inserted.units());
    }
    call.out.extend(text.units().skip(count(position)));
}

/// STR without LEN characters from POS on. A negative POS leaves STR as it is.
fn delete(call: &mut TextCall<'_>) {
    let (text, position) = (first(call), cell(call, 1));
    let (start, end) = if position < 0 { (0, 0) } else { span(cell(call, 0), position, text.length()) };
    call.out.clear();
    call.out.extend(text.units().take(start));
    call.out.extend(text.units().skip(end));
}

/// STR1 with STR2 in the place of L characters from P on. A negative P leaves STR1 as it is; after the end STR2 is
/// added to it.
fn replace(call: &mut TextCall<'_>) {
    let (text, position) = (first(call), cell(call, 1));
    let by = text_at(call, 1);
    let (start, end) = if position < 0 { (0, 0) } else { span(cell(call, 0), position, text.length()) };
    call.out.clear();
    call.out.extend(text.units().take(start));
    if position >= 0 {
        call.out.extend(by.units());
    }
    call.out.extend(text.units().skip(end));
}

/// The position at which STR2 first begins in STR1; 0 where it does not, and for an empty STR2.
fn find(call: &mut TextCall<'_>) {
    let (text, part) = (first(call), text_at(call, 1));
    let width = if text.wide { 2 } else { 1 };
    let (all, sought) = (text.stored_units(), part.stored_units());
    let found = (!sought.is_empty())
        .then(|| all.windows(sought.len()).step_by(width).position(|window| window == sought))
        .flatten();
    call.result = found.map_or(0, |place| int(place + 1));
}
