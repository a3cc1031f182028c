//! How far a clock may be off, as board files and instrument files say it: one reader for both.

use document::{Data, Fields, Findings, Node};
use signal::{ClockError, Coverage, Quantity, Unit};

use super::accuracy::{AccuracyCodes, coverage};
use super::codes;

/// The clock that stamps what a board sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BoardClock {
    /// How far its rate may be off.
    pub error: ClockError,
    /// What that covers.
    pub coverage: Coverage,
}

const CODES: AccuracyCodes = AccuracyCodes { unit: codes::CLOCK, figure: codes::CLOCK };

/// What the table `board` says of the clock. What is wrong with it is reported.
pub(super) fn of_board(board: &Fields, out: &mut Findings) -> BoardClock {
    let read = board.get("clock-error").map(|node| clock_error(node, codes::CLOCK, out));
    let covered = board.get("clock-coverage");
    let is_right = read.is_none_or(|error| error == Some(ClockError::NONE));
    if let Some(node) = covered.filter(|_| is_right) {
        let help = "add `clock-error`, as in clock-error = \"25 ppm\", or remove it";
        out.bad(codes::CLOCK, node, "no error of a clock is there that it covers", help);
    }
    let coverage = covered.and_then(|node| coverage(node, CODES, out)).unwrap_or_default();
    BoardClock { error: read.flatten().unwrap_or_default(), coverage }
}

/// The key `clock-error` of a device that has a clock of its own. What is wrong with it is reported.
pub(super) fn of_device(fields: &Fields, out: &mut Findings) -> ClockError {
    fields.get("clock-error").and_then(|node| clock_error(node, codes::CLOCK, out)).unwrap_or_default()
}

/// A part of the time, rounded up; 0 needs no unit. `None` where it is none, which is reported under this code.
pub fn clock_error(node: &Node, code: &'static str, out: &mut Findings) -> Option<ClockError> {
    let is_zero = match &node.data {
        Data::Integer(number) => *number == 0,
        Data::Text(text) | Data::Float(text) => text.trim().parse::<f64>() == Ok(0.0),
        _ => false,
    };
    if is_zero {
        return Some(ClockError::NONE);
    }
    let help = "write how far the rate may be off, from 0 to 10 %, as in \"25 ppm\"";
    let text = node.as_text().unwrap_or_default();
    let part = Quantity::parse(text).ok().and_then(|read| read.in_unit(&Unit::new("ppm")));
    let Some(ppm) = part else {
        out.bad(code, node, "this is no part of the time", help);
        return None;
    };
    let parts = ppm.shifted(6);
    let parts = match parts.as_whole() {
        _ if parts.is_negative() => None,
        Some(whole) => u64::try_from(whole).ok(),
        // Finer than is counted: the next greater part.
        None => Some((parts.as_f64().floor() as u64).saturating_add(1)),
    };
    let error = parts.and_then(ClockError::from_parts);
    if error.is_none() {
        out.bad(code, node, format!("no clock is off by {text}"), help);
    }
    error
}
