//! Plans that run.

use serde::{Deserialize, Serialize};

/// The plan that runs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlanStatus {
    /// What was asked for.
    pub name: String,
    /// The case that runs.
    pub case: String,
    /// Its place among all cases, from 1, and how many there are.
    pub place: (u32, u32),
}

impl PlanStatus {
    /// Of a case that begins, by its name and its place.
    pub fn of(case: &str, place: (u32, u32)) -> PlanStatus {
        let name = case.split('[').next().unwrap_or_default().to_owned();
        PlanStatus { name, case: case.to_owned(), place }
    }
}

/// What a plan that runs reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "plan", rename_all = "kebab-case")]
pub enum PlanEvent {
    /// A case begins.
    Case {
        /// Its name.
        name: String,
        /// Its place among all cases, from 1, and how many there are.
        place: (u32, u32),
        /// Its steps: name and what they do.
        steps: Vec<(String, String)>,
        /// Its claims and measurements: name and what they ask.
        claims: Vec<(String, String)>,
    },
    /// A step began or is done.
    Step {
        /// Its place in the case.
        step: u32,
        /// The instant in the case, nanoseconds.
        at: i64,
        /// It is done.
        done: bool,
    },
    /// A case is over.
    Verdict {
        /// Its name.
        name: String,
        /// The verdict's word.
        verdict: String,
        /// Why.
        reason: String,
        /// Verdicts of its claims, with the reason.
        claims: Vec<(String, String, String)>,
        /// Its measurements.
        measured: Vec<Measured>,
    },
    /// All cases are over.
    Over {
        /// The verdict of all.
        verdict: String,
        /// Where the report is, if one was written.
        report: Option<String>,
    },
}

/// A measurement against its limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Its name.
    pub name: String,
    /// What was measured, from where to where; none if it was not.
    pub value: Option<(f64, f64)>,
    /// The lower limit.
    pub low: Option<f64>,
    /// The upper limit.
    pub high: Option<f64>,
    /// The unit.
    pub unit: String,
    /// The verdict's word.
    pub verdict: String,
}
