//! How far the readings of a channel may be off, as board files and instrument files say it: one reader for both.

use document::{Data, Fields, Findings, KeySpec, KeyType, Node};
use signal::Coverage;

use super::{codes, number};
use crate::adc::Accuracy;

/// A part of the reading.
pub const OF_VALUE: KeySpec =
    KeySpec::optional("of-value", KeyType::Quantity, "A part of the value, as in \"0.1 %\"; 0");

/// The same for every reading.
pub const PLUS: KeySpec =
    KeySpec::optional("plus", KeyType::Quantity, "In the unit of the channel, the same everywhere; 0");

/// What the figures beside it cover.
pub const COVERAGE: KeySpec = KeySpec::optional(
    "coverage",
    KeyType::Text,
    "What the figures cover: \"limits\" (never passed), a probability as in \"95 %\", or a factor as in \"k = 2\"; \"limits\"",
);

/// The codes under which a file reports what is wrong with such a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AccuracyCodes {
    /// A unit of another kind.
    pub unit: &'static str,
    /// A figure that cannot be.
    pub figure: &'static str,
}

pub(super) const OF_BOARD: AccuracyCodes = AccuracyCodes { unit: codes::UNIT, figure: codes::SCALE };

/// The table `accuracy` of a channel in this unit, all 0 where there is none. `None` where something is wrong with it, which
/// is reported.
pub fn accuracy(fields: &Fields, unit: &str, codes: AccuracyCodes, out: &mut Findings) -> Option<Accuracy> {
    let Some(inner) = fields.inner("accuracy") else { return Some(Accuracy::default()) };
    let percent = |key: &str, out: &mut Findings| match inner.get(key) {
        None => Some(0.0),
        Some(node) => percent(node, codes, out).map(|part| part * 0.01),
    };
    let of_value = percent("of-value", out)?;
    let of_range = percent("of-range", out)?;
    let plus = inner.get("plus").map_or(Some(0.0), |node| width(node, unit, codes, out))?;
    let is_off = of_value > 0.0 || of_range > 0.0 || plus > 0.0;
    covers_something(&inner, is_off, FIGURES_HELP, codes, out)?;
    let covered =
        inner.get("coverage").map_or(Some(Coverage::default()), |node| coverage(node, codes, out))?;
    Some(Accuracy { of_value, of_range, plus, coverage: covered })
}

/// What to write where a table `accuracy` has none of them.
const FIGURES_HELP: &str =
    "write how far off it may be, as in plus = \"10 mV\" or of-value = \"0.1 %\", or remove `coverage`";

/// Refuses the key `coverage` of a table where no error above 0 is stated that it could be of: it was forgotten, and what is exact would be
/// reported as known with a probability. `None` where that is reported.
pub fn covers_something(
    fields: &Fields,
    is_off: bool,
    help: &str,
    codes: AccuracyCodes,
    out: &mut Findings,
) -> Option<()> {
    let Some(entry) = fields.entry("coverage").filter(|_| !is_off) else { return Some(()) };
    out.error(codes.figure, entry.key_span.clone(), "`coverage` is of an error, and there is none", help);
    None
}

/// A part as a number of percent, at least 0. A number alone could be a fraction, too: it is refused.
fn percent(node: &Node, codes: AccuracyCodes, out: &mut Findings) -> Option<f64> {
    let alone = match &node.data {
        Data::Text(text) | Data::Float(text) => text.trim().parse().ok(),
        Data::Integer(number) => Some(*number as f64),
        _ => None,
    };
    if let Some(alone) = alone.filter(|alone: &f64| *alone != 0.0) {
        let help = format!("write \"{alone} %\", or \"{} %\" if {alone} is a fraction", alone * 100.0);
        out.bad(codes.unit, node, "a part has no unit", help);
        return None;
    }
    width(node, "%", codes, out)
}

/// A number in this unit that is a width: at least 0. `None` where it is not, which is reported.
pub fn width(node: &Node, unit: &str, codes: AccuracyCodes, out: &mut Findings) -> Option<f64> {
    let part = quantity(node, unit, codes, out)?;
    if part < 0.0 {
        out.bad(codes.figure, node, "an error is a width", "write a number of at least 0");
    }
    (part >= 0.0).then_some(part)
}

/// A number in this unit. `None` where it is none, which is reported.
pub fn quantity(node: &Node, unit: &str, codes: AccuracyCodes, out: &mut Findings) -> Option<f64> {
    number::quantity_under(node, unit, codes.unit, out)
}

/// What a statement covers. `None` where it does not say so, which is reported.
pub fn coverage(node: &Node, codes: AccuracyCodes, out: &mut Findings) -> Option<Coverage> {
    let read = node.as_text().and_then(Coverage::parse);
    if read.is_none() {
        let help = "write \"limits\" for a bound that is never passed, a probability such as \"95 %\", or a factor such as \"k = 2\"";
        out.bad(codes.figure, node, "this is no coverage", help);
    }
    read
}
