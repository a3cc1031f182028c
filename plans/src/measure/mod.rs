//! Measurements: how long something took, or how large it was, against limits if it has any.
//!
//! ```toml
//! measure = [
//!   { name = "reflex latency", from = "train.pulse[1000]", to = { signal = "out", edge = "rises" }, max = "6 us" },
//!   { name = "supply", value-of = "u24", when = "busy", nominal = "24 V", tolerance = "1.2 V" },
//! ]
//! ```
//! A measurement that was never taken never passes. One without limits that was taken has no verdict.

mod gauge;
mod read;

use std::sync::Arc;

use document::Diagnostic;
use record::{MeasurementRecord, Verdict};

use crate::expect::Place;
use crate::judge::{NotJudged, Scene, Wiring};
use crate::lang::{Anchor, Literal};

pub use gauge::Gauge;
pub use read::{KEYS, read};

/// What is measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// The time from one instant to another.
    Between {
        /// Where it begins.
        from: Anchor,
        /// Where it ends.
        to: Anchor,
    },
    /// The time from an instant to the first such edge at or after it.
    ToEdge {
        /// Where it begins.
        from: Anchor,
        /// The signal.
        signal: String,
        /// Which edge.
        edge: crate::judge::edges::Edge,
    },
    /// The value of a signal at an instant.
    Value {
        /// The signal.
        signal: String,
        /// The instant.
        when: Anchor,
    },
}

/// Limits of a measurement, as written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// The least value allowed.
    pub min: Option<Literal>,
    /// The greatest value allowed.
    pub max: Option<Literal>,
    /// The value wanted, and how far from it is allowed.
    pub nominal: Option<(Literal, Literal)>,
}

/// A measurement of one case.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Its name.
    pub name: String,
    /// What is measured.
    pub quantity: Quantity,
    /// What it should be.
    pub limits: Arc<Limits>,
    /// Where it stands; `None` for a measurement that is in no plan file.
    pub place: Option<Place>,
}

impl Measurement {
    /// The instants that it hangs on.
    pub fn anchors(&self) -> Vec<&Anchor> {
        match &self.quantity {
            Quantity::Between { from, to } => vec![from, to],
            Quantity::ToEdge { from, .. } => vec![from],
            Quantity::Value { when, .. } => vec![when],
        }
    }

    /// The signals that it looks at.
    pub fn signals(&self) -> Vec<String> {
        match &self.quantity {
            Quantity::Between { .. } => Vec::new(),
            Quantity::ToEdge { signal, .. } | Quantity::Value { signal, .. } => vec![signal.clone()],
        }
    }

    /// Finds what cannot be measured with these signals.
    pub fn check(&self, wiring: &Wiring<'_>, out: &mut Vec<Diagnostic>) {
        let mut info = gauge::time();
        if let Some(name) = self.signals().first() {
            let Some(known) = crate::expect::known(name, wiring, out) else { return };
            if matches!(self.quantity, Quantity::Value { .. }) {
                info = known.clone();
            }
        }
        crate::expect::meant(gauge::Bounds::new(&self.limits, &info).map(drop), out);
    }

    /// Starts measuring.
    ///
    /// # Errors
    /// [`NotJudged`] if an instant never came.
    pub fn start(&self, scene: &Scene<'_>) -> Result<Gauge, NotJudged> {
        Gauge::new(self, scene)
    }

    pub(crate) fn line(&self) -> u32 {
        self.place.as_ref().map_or(0, |place| place.line)
    }

    /// The record of a measurement that was never taken.
    pub fn untaken(&self, why: &str) -> MeasurementRecord {
        MeasurementRecord {
            name: self.name.clone(),
            verdict: Verdict::Inconclusive,
            reason: why.to_owned(),
            signal: self.signals().into_iter().next(),
            line: self.line(),
            ..MeasurementRecord::default()
        }
    }
}
