//! How a rig is: reported again and again.

use crate::WireValue;
use crate::message::PlanStatus;
use serde::{Deserialize, Serialize};

/// How a rig is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The instant that it is of, nanoseconds since the rig began.
    pub at: i64,
    /// The controller's state by its documented name.
    pub state: String,
    /// Its indicators, as they are on its front.
    pub leds: Vec<LedStatus>,
    /// Where the Run/Stop switch stands: TRUE for Run.
    pub switch: bool,
    /// It has its supply.
    pub power: bool,
    /// Its tasks, in the order of the description.
    pub tasks: Vec<TaskStatus>,
    /// Load of its processor in the last second, per mille.
    pub load: u32,
    /// What is forced.
    pub forced: Vec<ForcedPoint>,
    /// The points, in the order of the description.
    pub points: Vec<PointStatus>,
    /// The devices, in the order of the description.
    pub devices: Vec<DeviceStatus>,
    /// The buses, in the order of the description.
    pub buses: Vec<BusStatus>,
    /// The expansion modules, in the order of the description: the name of the state of each, as in `TM3_OK`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modules: Vec<String>,
    /// What the rig says of itself.
    pub rig: RigStatus,
    /// Why figures cannot be trusted; empty where they can.
    pub troubles: Vec<StatusWarning>,
    /// It is locked.
    pub locked: Option<Locked>,
    /// A plan runs.
    pub plan: Option<PlanStatus>,
    /// Who is connected.
    pub clients: u32,
}

/// An indicator.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LedStatus {
    /// Its name, as in `RUN`.
    pub name: String,
    /// What it shows: `off`, `on`, `fast-flash`, `regular-flash`, `single-flash`.
    pub pattern: String,
    /// Its times lit and dark where it flashes, nanoseconds.
    pub times: Option<(i64, i64)>,
    /// Since when it shows that: a flash begins lit.
    pub since: i64,
}

/// How a task is. Times are nanoseconds of modelled time.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TaskStatus {
    /// Cycles that ended.
    pub cycles: u64,
    /// Processor time of the last cycle, the least, the mean and the greatest.
    pub last: i64,
    /// See `last`.
    pub min: i64,
    /// See `last`.
    pub mean: i64,
    /// See `last`.
    pub max: i64,
    /// From a release to the start of its cycle: the last, the least, the greatest.
    pub jitter: i64,
    /// See `jitter`.
    pub jitter_min: i64,
    /// See `jitter`.
    pub jitter_max: i64,
    /// How often a jitter was how great: each upper border in nanoseconds, with its count; borders rise.
    pub jitter_counts: Vec<(i64, u64)>,
    /// Processor time in the last second, per mille.
    pub load: u32,
    /// Cycles that took longer than the interval.
    pub overruns: u64,
    /// Releases that were lost.
    pub lost: u64,
    /// Watchdog exceptions.
    pub watchdogs: u64,
}

/// A forced point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForcedPoint {
    /// Its address.
    pub address: String,
    /// Its value.
    pub value: WireValue,
    /// The name of the client that forced it, if that is still connected.
    pub by: Option<String>,
}

/// How a point is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointStatus {
    /// Rising edges of its line since the rig began.
    pub rising: u64,
    /// Falling edges.
    pub falling: u64,
    /// Its channel is lost.
    pub lost: bool,
}

/// How a device is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeviceStatus {
    /// It works; else `why` says more.
    pub sound: bool,
    /// Why it does not, or did not until then.
    pub why: String,
}

/// How a bus is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BusStatus {
    /// `error-active`, `error-passive`, `bus-off`; `open` for a serial line, or `lost`.
    pub state: String,
    /// Frames or bytes that were received.
    pub received: u64,
    /// Frames or bytes that were sent.
    pub sent: u64,
    /// Errors.
    pub errors: u64,
    /// What is known to have been missed.
    pub dropped: u64,
}

/// What a rig says of itself. Times are nanoseconds on the host's clock.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RigStatus {
    /// How late it was at worst.
    pub late_max: i64,
    /// How late outputs were at worst.
    pub late_outputs: i64,
    /// How often a wake-up was how late: each upper border with its count; borders rise.
    pub late_counts: Vec<(i64, u64)>,
    /// Its own deadlines that it missed.
    pub overruns: u64,
    /// Events that boards missed.
    pub dropped: u64,
    /// Changes that were reported to no client, because they came faster than they could be taken.
    pub untold: u64,
    /// Its threads have real-time priority.
    pub realtime: bool,
    /// Outputs are at their safe values and stay there.
    pub latched_safe: bool,
}

/// Why figures cannot be trusted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StatusWarning {
    /// One word: `no-realtime`, `throttled`, `dropped`, `overrun`, `lost`, `untold`.
    pub kind: String,
    /// A sentence.
    pub text: String,
}

/// A lock.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Locked {
    /// Who locked it.
    pub by: String,
    /// Why.
    pub note: String,
}
