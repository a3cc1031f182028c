//! The controller's log: a bounded ring of facts (controller:NV-09).

use crate::{ApplicationFault, LoadError, State};
use profile::StopCause;
use signal::{Span, Time};
use std::collections::VecDeque;

/// Entries kept; older ones are dropped and counted.
const KEPT: usize = 256;

/// What a log entry says. Tasks are named by their places in the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// The state changed.
    State {
        /// The state that was left.
        from: State,
        /// The new state.
        to: State,
    },
    /// RUNNING was left.
    Stopped(StopCause),
    /// The boot decision, by the row that decided (controller:RB-02).
    Boot {
        /// Number of the row.
        row: u8,
    },
    /// A cycle took longer than its interval (controller:TASK-11, controller:TASK-12).
    Overrun {
        /// The task.
        task: usize,
        /// From the start of the cycle to its end.
        elapsed: Span,
    },
    /// A cycle took longer than the watchdog allows (controller:WD-10).
    WatchdogException {
        /// The task.
        task: usize,
        /// Exceptions in a row, with this one.
        consecutive: u32,
    },
    /// The task watchdog stopped the application (controller:WD-04).
    TaskWatchdog {
        /// The task.
        task: usize,
    },
    /// Tasks of priority 0...24 took the whole processor (controller:WD-02).
    SystemWatchdog,
    /// The application failed.
    Fault {
        /// The task.
        task: usize,
        /// What happened and where.
        fault: ApplicationFault,
    },
    /// An application was not valid.
    Load(LoadError),
    /// Two tasks write outputs of one byte (controller:PRIO-05, M241 of 2014 only).
    SharedOutputByte {
        /// Byte of %Q.
        byte: u32,
        /// The tasks.
        tasks: (usize, usize),
    },
    /// The saved context of the remanent variables was not valid (controller:STATE-10).
    ContextInvalid,
    /// The supply was interrupted.
    SupplyLost,
    /// The supply came back within the hold-up time (controller:HW-08, controller:HW-09).
    SupplyBack,
}

/// The newest entries, oldest first.
#[derive(Clone, Debug)]
pub struct Log {
    entries: VecDeque<(Time, Entry)>,
    dropped: u64,
}

impl Log {
    pub(crate) fn new() -> Log {
        Log { entries: VecDeque::with_capacity(KEPT), dropped: 0 }
    }

    pub(crate) fn push(&mut self, at: Time, entry: Entry) {
        if self.entries.len() == KEPT {
            self.entries.pop_front();
            self.dropped += 1;
        }
        self.entries.push_back((at, entry));
    }

    /// The entries that are kept, oldest first.
    pub fn entries(&self) -> impl Iterator<Item = (Time, Entry)> + '_ {
        self.entries.iter().copied()
    }

    /// How many older entries were dropped.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }
}
