//! Limits in a unit that the verb itself has, whatever the signal's is: hertz, per cent, degrees.

use std::fmt;

use document::{Fields, KeySpec, KeyType};
use signal::{SignalInfo, ValueKind};

use super::ReadContext;
use super::condition::ValueCondition;
use crate::codes;
use crate::lang::Literal;
use crate::monitor::{ClockLimits, ClockedFigure, Extent, Number, NumberLimits, ValueTest, distance};

/// The limits of a figure as a range.
pub(super) const IS_RANGE: KeySpec = KeySpec::optional(
    "is",
    KeyType::Range,
    "What is allowed, with its unit: \"50 Hz ± 1 %\", \"49 .. 51 Hz\"",
);

/// Least and greatest figure allowed, both included.
#[derive(Clone, Debug)]
pub(super) struct FigureBand {
    pub(super) limits: NumberLimits,
    pub(super) unit: &'static str,
    /// What no figure of this kind is below or above: a limit there is none.
    natural: NumberLimits,
    words: ValueCondition,
}

/// What a time, a frequency or a jitter is never below, as a number of events.
pub(crate) const NEVER_NEGATIVE: NumberLimits = NumberLimits { min: Some(Number::ZERO), max: None };

/// What a part of the time is never below or above, in per cent.
pub(crate) const WHOLE_PART: NumberLimits =
    NumberLimits { min: Some(Number::ZERO), max: Some(Number::Int(100)) };

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
        let limits = match test {
            ValueTest::OneOf(list) => {
                let only = list.first().copied();
                NumberLimits { min: only, max: only }
            }
            ValueTest::Range { min, max } => NumberLimits { min, max },
            ValueTest::HighZ | ValueTest::Not(_) => return None,
        };
        Some(FigureBand { limits, unit, natural: NumberLimits::default(), words })
    }

    /// The same for a figure that is never outside of these.
    pub(super) fn of_kind(self, natural: NumberLimits) -> FigureBand {
        FigureBand { natural, ..self }
    }

    /// The same of a time, or of what comes in a time, by a clock that may be off.
    pub(super) fn by_clock(self, clock: ClockLimits, figure: ClockedFigure) -> FigureBand {
        FigureBand { limits: clock.figures(self.limits, figure), ..self }
    }

    /// The same of how far edges stand off a grid of true time, which moves by what the clock is off in so many nanoseconds.
    pub(super) fn by_true_grid(self, clock: ClockLimits, wanders_over: i64) -> FigureBand {
        FigureBand { limits: clock.of_true_grid(self.limits, wanders_over), ..self }
    }

    /// Whether a figure of this extent can be inside, and whether it can be outside.
    pub(super) fn hold(&self, extent: Extent) -> (bool, bool) {
        self.limits.hold(extent)
    }

    /// Distance to the nearest limit in the worst case, negative outside; `None` where there is no limit, or the distance is not
    /// known.
    pub(super) fn margin(&self, extent: Extent) -> Option<f64> {
        self.limits.passable(self.natural).margin(extent)
    }

    /// How far outside a figure is that is nowhere inside, and whether it is above.
    pub(super) fn beyond(&self, (low, high): Extent) -> (record::Figure, bool) {
        let above = self.limits.max.filter(|max| low.is_above(*max)).map(|max| distance(max, low));
        let below = || self.limits.min.map_or(0.0, |min| distance(high, min));
        (record::Figure::new(above.unwrap_or_else(below), self.unit), above.is_some())
    }

    /// What is wrong with a figure that is nowhere inside.
    pub(super) fn miss(&self, extent: Extent) -> String {
        let (apart, above) = self.beyond(extent);
        format!("{apart} {}", if above { "too high" } else { "too low" })
    }
}

/// An extent with its unit: `49.9 Hz .. 50.1 Hz`, or one figure.
pub(super) fn shown((low, high): Extent, unit: &str) -> String {
    let figure = |number: Number| match number {
        // No digit of a whole number is left out.
        Number::Int(whole) if unit.is_empty() => whole.to_string(),
        number => record::Figure::new(number.as_real(), unit).to_string(),
    };
    let (first, last) = (figure(low), figure(high));
    if first == last { first } else { format!("{first} .. {last}") }
}

/// How far an extent reaches, if it is no point.
pub(super) fn spread((low, high): Extent, unit: &str) -> Option<record::Figure> {
    let spread = distance(low, high);
    (low.is_below(high) && spread.is_finite()).then(|| record::Figure::new(spread, unit))
}
