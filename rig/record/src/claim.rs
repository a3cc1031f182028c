//! What was claimed of a case and what was measured in it.

use crate::{Figure, Verdict};
use serde::{Deserialize, Serialize};

/// When a claim looks at its signal. Each end is itself known to within an interval where it depends on an
/// event; `limit_...` is the allowed part of the window where the claim has one (`within = "a .. b"`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Window {
    /// `[earliest, latest]` of the beginning, nanoseconds.
    pub from_ns: [i64; 2],
    /// `[earliest, latest]` of the end, nanoseconds.
    pub until_ns: [i64; 2],
    /// The earliest instant allowed, nanoseconds.
    pub limit_from_ns: Option<i64>,
    /// The latest instant allowed, nanoseconds.
    pub limit_until_ns: Option<i64>,
}

/// The values that a claim allows, in the unit of its signal, both ends included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// The least value allowed.
    #[serde(default, with = "crate::number::option")]
    pub min: Option<f64>,
    /// The greatest value allowed.
    #[serde(default, with = "crate::number::option")]
    pub max: Option<f64>,
}

/// One expectation, judged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ClaimRecord {
    /// The expectation's own name, or what it says in short; unique in its case is not required.
    pub name: String,
    /// Its verb: `falls`, `state`, `value`.
    pub verb: String,
    /// What it came to.
    pub verdict: Verdict,
    /// Why, in one sentence; empty for a plain pass.
    pub reason: String,
    /// What was expected: `falls 100 ms .. 100.3 ms after busy`.
    pub expected: String,
    /// What was observed: `fell 100.2 ms after busy`.
    pub observed: String,
    /// Distance to the nearest limit in the worst placement; negative where it is exceeded.
    pub margin: Option<Figure>,
    /// How well the deciding figure is known (the full width).
    pub uncertainty: Option<Figure>,
    /// When the claim looks.
    pub window: Option<Window>,
    /// The values that it allows, where it has limits for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounds: Option<Bounds>,
    /// `[earliest, latest]` of the instant that decided, nanoseconds.
    pub deciding_ns: Option<[i64; 2]>,
    /// The signal that is the evidence.
    pub signal: Option<String>,
    /// Who made the deciding change: `MAST lamp.st:12`, `step busy`, `controller`.
    pub last_writer: Option<String>,
    /// On failure, what came closest to what was wanted.
    pub nearest_miss: Option<String>,
    /// Line of the file that it stands in, from 1; 0 where it stands in none.
    pub line: u32,
    /// The file that it stands in, where that is not the plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place_file: Option<String>,
    /// The kind of that file.
    #[serde(default, skip_serializing_if = "ClaimOrigin::is_plan")]
    pub origin: ClaimOrigin,
    /// It is an invariant or an alarm: it is claimed of every case and not of this one alone.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub guard: bool,
}

/// The kind of file that a claim stands in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ClaimOrigin {
    /// The plan, or a file that it includes.
    #[default]
    Plan,
    /// A suite file.
    Suite,
    /// A board file.
    Board,
}

impl ClaimOrigin {
    fn is_plan(&self) -> bool {
        *self == ClaimOrigin::Plan
    }
}

/// How the uncertainty of a measured value counts against its limits (ISO 14253-1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GuardBand {
    /// As a guard band on both sides of each limit: a value conforms where all of its interval does, it does not where
    /// none of it does, and between them that is open.
    #[default]
    Uncertainty,
    /// Not at all, which is simple acceptance: the middle of the interval is held against the limits as if it were exact.
    None,
}

impl GuardBand {
    /// Whether a verdict proves what it says.
    pub fn is_uncertainty(&self) -> bool {
        *self == GuardBand::Uncertainty
    }
}

/// One measurement, judged against its limits if it has any.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MeasurementRecord {
    /// Name in the plan.
    pub name: String,
    /// What is measured, in words: `mean of `pressure` from press until end`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub what: String,
    /// The value lies within `[low, high]`, in `unit`; nothing when it was never taken.
    #[serde(with = "crate::number::interval")]
    pub value: Option<[f64; 2]>,
    /// What the interval of the value covers: `limits` where it holds the value of every placement, so that it is never
    /// passed; else the statements of uncertainty that took part and are no bounds, as in `95 %` or `95 %, k = 2`. Empty in
    /// records of a rig that did not say it.
    pub coverage: String,
    /// Unit of all numbers of this measurement; durations are in `ns`.
    pub unit: String,
    /// Least value allowed.
    #[serde(with = "crate::number::option")]
    pub min: Option<f64>,
    /// Greatest value allowed.
    #[serde(with = "crate::number::option")]
    pub max: Option<f64>,
    /// Value wanted, where limits were given as nominal and tolerance.
    #[serde(with = "crate::number::option")]
    pub nominal: Option<f64>,
    /// Allowed distance from `nominal`.
    #[serde(with = "crate::number::option")]
    pub tolerance: Option<f64>,
    /// How the uncertainty of the value counts against the limits.
    #[serde(skip_serializing_if = "GuardBand::is_uncertainty")]
    pub guard_band: GuardBand,
    /// Without a guard band: the middle alone decides, for a limit lies within the interval of the value. The reason has the words.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub by_middle: bool,
    /// What it came to; [`Verdict::None`] for a measurement without limits that was taken.
    pub verdict: Verdict,
    /// Why, in one sentence; empty for a plain pass.
    pub reason: String,
    /// Distance to the nearest limit in the worst placement, without a guard band that of the middle of the value;
    /// negative where it is exceeded.
    pub margin: Option<Figure>,
    /// `[earliest, latest]` of the first instant it was taken between, nanoseconds.
    pub from_ns: Option<[i64; 2]>,
    /// `[earliest, latest]` of the second instant, nanoseconds.
    pub to_ns: Option<[i64; 2]>,
    /// The signal that it was taken from.
    pub signal: Option<String>,
    /// Line of the plan, from 1; 0 where it is not in the plan.
    pub line: u32,
}
