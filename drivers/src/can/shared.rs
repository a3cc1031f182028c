//! What the board of a CAN interface and its thread have in common.

use signal::CanFrame;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use host::{AtomicInstant, Bell, HostInstant};
use rustix::event::{EventfdFlags, eventfd};

use crate::{BusError, BusState};

/// What the interface told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Report {
    /// A frame was on the bus between these stamps.
    Frame { earliest: HostInstant, latest: HostInstant, frame: CanFrame, own: bool },
    /// The controller takes part in another way.
    State { at: HostInstant, state: BusState },
    /// Something went wrong on the bus.
    Error { at: HostInstant, error: BusError },
    /// Frames found no room on their way from the kernel or in the controller.
    Dropped { at: HostInstant, count: u32 },
    /// The interface is down, or away.
    Lost { at: HostInstant },
    /// It is back.
    Returned { at: HostInstant },
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
    /// Since when a call is under way.
    pub(super) in_call: AtomicInstant,
    /// There is no interface to talk to, and since when.
    pub(super) gone: AtomicBool,
    pub(super) gone_since: AtomicInstant,
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
            in_call: AtomicInstant::none(),
            gone: AtomicBool::new(false),
            gone_since: AtomicInstant::none(),
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
