//! What the board of a CAN interface and its thread have in common.

use signal::{CanFrame, Span};
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use host::{AtomicInstant, HostInstant, Realtime};
use rustix::event::{EventfdFlags, eventfd};

use crate::{BusError, BusState};

/// Reports on their way to the board: a second of a busy bus.
pub(super) const REPORTS: usize = 8_192;

/// How the thread of an interface works.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThreadConfig {
    /// How long before its stamp a frame may have ended.
    pub(super) resolution: Span,
    /// How long a call may last.
    pub(super) limit: Span,
    /// How long the end of the thread is waited for.
    pub(super) patience: Span,
    /// An interface that went away is opened again.
    pub(super) reconnect: bool,
    /// How the thread runs.
    pub(super) realtime: Realtime,
}

/// What the interface reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CanReport {
    /// A frame was on the bus between these stamps.
    Frame { earliest: HostInstant, latest: HostInstant, frame: CanFrame, own: bool },
    /// The controller takes part in another way.
    State { at: HostInstant, state: BusState },
    /// Something went wrong on the bus.
    Error { at: HostInstant, error: BusError },
    /// Frames found no room on their way from the kernel or in the controller.
    Dropped { at: HostInstant, count: u32 },
    /// It was down or away, and is back.
    Returned { at: HostInstant },
    /// What was before is forgotten, for this start; or frames of before still wait for the bus.
    Started { start: u64, state: BusState, waiting: bool },
}

/// What board and thread share.
#[derive(Debug)]
pub(super) struct SharedCan {
    /// Nothing is sent, whatever is asked.
    pub(super) latched: AtomicBool,
    /// Number of starts asked for.
    pub(super) starts: AtomicU64,
    /// Number of times that something was asked, and of those that the thread has seen to.
    pub(super) asked: AtomicU64,
    pub(super) heard: AtomicU64,
    /// Since when a call is under way.
    pub(super) in_call: AtomicInstant,
    /// Wakes the thread.
    pub(super) wake: OwnedFd,
}

impl SharedCan {
    /// Of a thread that sends nothing before its first start.
    pub(super) fn new() -> std::io::Result<SharedCan> {
        Ok(SharedCan {
            latched: AtomicBool::new(true),
            starts: AtomicU64::new(0),
            asked: AtomicU64::new(0),
            heard: AtomicU64::new(0),
            in_call: AtomicInstant::none(),
            wake: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
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
