//! What the board of a CAN interface and its thread have in common.

use signal::CanFrame;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

use host::Bell;
use rustix::event::{EventfdFlags, eventfd};

use crate::{BusError, BusState};

/// What the interface told; stamps are of the monotonic clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Report {
    /// A frame was on the bus between these stamps.
    Frame { earliest: i64, latest: i64, frame: CanFrame, own: bool },
    /// The controller takes part in another way.
    State { at: i64, state: BusState },
    /// Something went wrong on the bus.
    Error { at: i64, error: BusError },
    /// Frames found no room on their way from the kernel or in the controller.
    Dropped { at: i64, count: u32 },
    /// The interface is down, or away.
    Lost { at: i64 },
    /// It is back.
    Returned { at: i64 },
    /// What was before is forgotten, for this start; or frames of before still wait for the bus.
    Started { start: u64, state: BusState, waiting: bool },
}

/// What board and thread share.
#[derive(Debug)]
pub(super) struct Shared {
    /// Nothing is sent, whatever is asked.
    pub(super) latched: AtomicBool,
    /// Number of starts asked for.
    pub(super) starts: AtomicU64,
    /// Number of times that something was asked, and of those that the thread has seen to.
    pub(super) asked: AtomicU64,
    pub(super) heard: AtomicU64,
    /// The stamp since when a call is under way; 0 for none.
    pub(super) in_call: AtomicI64,
    /// There is no interface to talk to, and since when: a stamp.
    pub(super) gone: AtomicBool,
    pub(super) gone_since: AtomicI64,
    /// Calls that failed, frames that could not be sent among them.
    pub(super) failed: AtomicU64,
    /// Reports that found no room.
    pub(super) spilled: AtomicU64,
    /// The thread is to end, and has ended.
    pub(super) stop: AtomicBool,
    pub(super) ended: AtomicBool,
    /// Wakes the thread.
    pub(super) wake: OwnedFd,
    /// Wakes whoever waits for the thread.
    pub(super) answer: Bell,
}

impl Shared {
    /// Of a thread that sends nothing before its first start.
    pub(super) fn new() -> std::io::Result<Shared> {
        Ok(Shared {
            latched: AtomicBool::new(true),
            starts: AtomicU64::new(0),
            asked: AtomicU64::new(0),
            heard: AtomicU64::new(0),
            in_call: AtomicI64::new(0),
            gone: AtomicBool::new(false),
            gone_since: AtomicI64::new(0),
            failed: AtomicU64::new(0),
            spilled: AtomicU64::new(0),
            stop: AtomicBool::new(false),
            ended: AtomicBool::new(false),
            wake: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
            answer: Bell::new(),
        })
    }

    /// Something is asked of the thread.
    pub(super) fn ask(&self) -> u64 {
        let asked = self.asked.fetch_add(1, Ordering::AcqRel) + 1;
        // A counter takes eight bytes; it cannot be full.
        let _ = rustix::io::write(&self.wake, &1u64.to_ne_bytes());
        asked
    }
}
