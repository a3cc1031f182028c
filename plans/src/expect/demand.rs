//! What a claim demands, in the few words that can be held against the plan and the bench before anything moves.

use super::condition::ValueCondition;
use crate::lang::Anchor;

/// A demand of a claim. What a claim does not say here is not looked at before the case runs.
#[derive(Clone, Debug)]
pub enum ClaimDemand<'a> {
    /// A signal has a value, throughout or at an instant; or, if it is forbidden, has not.
    Value {
        /// The signal.
        signal: &'a str,
        /// The value.
        condition: &'a ValueCondition,
        /// It is what must not be.
        forbidden: bool,
    },
    /// A signal changes from one thing to another.
    Change(&'a str),
    /// Two signals are held against each other at the same instants: where both show one thing, the claim says nothing.
    Differ(&'a str, &'a str),
    /// The claim looks from an instant up to another.
    Window {
        /// Where it begins.
        from: &'a Anchor,
        /// Where it ends.
        until: &'a Anchor,
    },
    /// The claim looks at an instant.
    At(&'a Anchor),
    /// Something comes after an instant, not sooner and not later than these, nanoseconds.
    Delay {
        /// The instant.
        from: &'a Anchor,
        /// Least and greatest delay, both included.
        limits: (i64, i64),
        /// The signal whose change it is.
        signal: &'a str,
    },
}
