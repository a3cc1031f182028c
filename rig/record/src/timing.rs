//! How well the rig itself kept time.

use serde::{Deserialize, Serialize};

/// The most late wake-ups that a case keeps with their instants: those that were latest.
pub const MAX_LATE_WAKES: usize = 32;

/// How well the rig itself kept time. All zero in virtual time.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct RigTiming {
    /// The latest that the rig was after its own schedule, nanoseconds.
    pub late_max_ns: i64,
    /// How often it missed a deadline of its own.
    pub overruns: u64,
    /// Events lost between the board and the trace.
    pub dropped: u64,
    /// How far the application may run ahead of the wall clock, nanoseconds.
    pub horizon_ns: i64,
    /// How its waits ended; nothing in virtual time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wakes: Option<Wakes>,
}

/// How late the waits of a case ended.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Wakes {
    /// Waits that ended because their instant had come.
    pub count: u64,
    /// Those of them that ended later than `late_from_ns`.
    pub late: u64,
    /// From how much on a wake-up counts as late, nanoseconds.
    pub late_from_ns: i64,
    /// Half of them were at most so late, nanoseconds.
    pub p50_ns: i64,
    /// 99 of 100 of them.
    pub p99_ns: i64,
    /// 9 999 of 10 000 of them.
    pub p9999_ns: i64,
    /// The latest of them.
    pub max_ns: i64,
    /// `[up to this late in nanoseconds, so many]`, rising; buckets without any are left out.
    pub histogram: Vec<[u64; 2]>,
    /// The latest of the late ones, at most [`MAX_LATE_WAKES`], by their instants.
    pub latest: Vec<LateWake>,
}

/// A wake-up that was late.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct LateWake {
    /// When it was due, nanoseconds.
    pub at_ns: i64,
    /// How late it was, nanoseconds.
    pub late_ns: i64,
}
