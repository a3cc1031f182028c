//! Limits in a unit that the verb itself has, whatever the signal's is: hertz, per cent, degrees.

use std::fmt;

use document::{Fields, KeySpec, KeyType};
use signal::{SignalInfo, ValueKind};

use super::ReadContext;
use super::condition::ValueCondition;
use crate::codes;
use crate::lang::Literal;
use crate::monitor::{Number, ValueTest};

/// The limits of a figure as a range.
pub(super) const IS_RANGE: KeySpec = KeySpec::optional(
    "is",
    KeyType::Range,
    "What is allowed, with its unit: \"50 Hz ± 1 %\", \"49 .. 51 Hz\"",
);

/// Least and greatest figure allowed, both included.
#[derive(Clone, Debug)]
pub(super) struct FigureBand {
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) unit: &'static str,
    /// What no figure of this kind is below or above: a limit there is none.
    natural: (f64, f64),
    words: ValueCondition,
}

impl fmt::Display for FigureBand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.words.fmt(f)
    }
}

/// What is called a number of this unit, without a signal that has it.
pub(crate) fn figure(name: &str, unit: &str) -> SignalInfo {
    let mut info = SignalInfo::exact(name, ValueKind::Real);
    info.unit = unit.to_owned();
    info
}

impl FigureBand {
    /// Reads `is`, or `min` and `max`. Every number has to have its unit, if there is one: 50 could be hertz or kilohertz.
    pub(super) fn read(
        fields: &Fields<'_>,
        name: &str,
        unit: &'static str,
        cx: &mut ReadContext<'_>,
    ) -> Option<FigureBand> {
        let words = ValueCondition::read(fields, None, cx)?;
        let place = ["is", "min", "max"].into_iter().find_map(|key| fields.get(key))?;
        let limits: Vec<&Literal> = match &words {
            ValueCondition::OneOf(list) => list.iter().collect(),
            ValueCondition::Within { min, max } => min.iter().chain(max).collect(),
            ValueCondition::Near { middle, tolerance } => vec![middle, tolerance],
        };
        let measured = |limit: &&Literal| limit.quantity().is_some_and(|quantity| !quantity.unit.is_none());
        let bound = match unit.is_empty() || limits.iter().all(measured) {
            true => words.bind(&figure(name, unit)),
            false => Err(format!("the {name} has the unit {unit}, and a limit has none")),
        };
        let test = match bound {
            Ok(test) => test,
            Err(why) => {
                let help = match unit {
                    "" => String::from("write a number without a unit"),
                    unit => format!("write it with its unit, as in \"10 {unit}\""),
                };
                cx.out.bad(codes::UNIT, place, why, help);
                return None;
            }
        };
        let (min, max) = match test {
            ValueTest::OneOf(list) => {
                let only = list.first().copied().map(Number::as_real)?;
                (only, only)
            }
            ValueTest::Range { min, max } => {
                (min.map_or(f64::NEG_INFINITY, Number::as_real), max.map_or(f64::INFINITY, Number::as_real))
            }
            ValueTest::HighZ | ValueTest::Not(_) => return None,
        };
        let natural = (f64::NEG_INFINITY, f64::INFINITY);
        Some(FigureBand { min, max, unit, natural, words })
    }

    /// The same for a figure that is never below the first or above the second of these.
    pub(super) fn of_kind(self, natural: (f64, f64)) -> FigureBand {
        FigureBand { natural, ..self }
    }

    /// Whether a figure of this interval can be inside, and whether it can be outside.
    pub(super) fn hold(&self, (low, high): (f64, f64)) -> (bool, bool) {
        (low <= self.max && high >= self.min, !(low >= self.min && high <= self.max))
    }

    /// Distance to the nearest limit in the worst case, negative outside; `None` where there is no limit, or the distance is not
    /// known.
    pub(super) fn margin(&self, (low, high): (f64, f64)) -> Option<f64> {
        let above = (self.min > self.natural.0).then_some(low - self.min);
        let below = (self.max < self.natural.1).then_some(self.max - high);
        above.into_iter().chain(below).reduce(f64::min).filter(|margin| margin.is_finite())
    }

    /// What is wrong with a figure that is nowhere inside.
    pub(super) fn miss(&self, (low, high): (f64, f64)) -> String {
        let (apart, word) = match low > self.max {
            true => (low - self.max, "too high"),
            false => (self.min - high, "too low"),
        };
        format!("{} {word}", record::Figure::new(apart, self.unit))
    }
}

/// An interval with its unit: `49.9 Hz .. 50.1 Hz`, or one figure.
pub(super) fn shown((low, high): (f64, f64), unit: &str) -> String {
    let figure = |value: f64| record::Figure::new(value, unit).to_string();
    if low == high { figure(low) } else { format!("{} .. {}", figure(low), figure(high)) }
}
