//! What replies hold, request by request: the `ok` of a [`crate::Reply`].

use crate::WireValue;
use crate::message::{PlanEvent, Signal, SignalChange};
use serde::{Deserialize, Serialize};

/// The reply to what has nothing to report: `{}`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Done {}

/// The reply to [`crate::RequestOperation::Read`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SignalValues {
    /// The values, in the order of the names.
    pub values: Vec<WireValue>,
}

/// The reply to [`crate::RequestOperation::Subscribe`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Subscribed {
    /// The subscription's number, which its events have.
    pub subscription: u64,
    /// The signals, in the order of the names: their numbers stand in changes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub signals: Vec<Signal>,
    /// Their present values, as far as there are any yet; those of the others come as their first change.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<SignalChange>,
    /// The last lines of the log so far.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub log: Vec<RigLogLine>,
    /// What the case that runs has reported so far.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plan: Vec<PlanEvent>,
}

/// A line of the log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RigLogLine {
    /// When, nanoseconds since the rig began.
    pub at: i64,
    /// The line.
    pub text: String,
}

/// The reply to [`crate::RequestOperation::Plans`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plans {
    /// The cases, as [`crate::RequestOperation::Plan`] takes them.
    pub plans: Vec<String>,
}

/// The reply to [`crate::RequestOperation::Advance`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Advanced {
    /// The instant that was reached, nanoseconds since the rig began.
    pub at: i64,
}
