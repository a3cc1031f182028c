//! What the controller writes into its log (controller:NV-09). Keeping the entries is left to whoever takes the effects.

use crate::{ApplicationFault, InternalError, LoadError, Overload, State, Warning};
use profile::StopCause;
use signal::Span;

/// What a log entry says. Tasks are named by their places in the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogEntry {
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
    /// The task of the lowest priority waited too long for the processor (controller:WD-03).
    Starved {
        /// The task.
        task: usize,
    },
    /// Tasks took too much of the processor (controller:WD-01, controller:WD-05).
    Overload(Overload),
    /// More events than the controller takes (controller:WD-06).
    TooManyEvents,
    /// The controller itself is in error (controller:ERR-01, controller:WD-14).
    InternalError(InternalError),
    /// Something in the configuration is accepted with a warning.
    Warning(Warning),
    /// The application failed.
    Fault {
        /// The task.
        task: usize,
        /// What happened and where.
        fault: ApplicationFault,
    },
    /// An application was not valid.
    Load(LoadError),
    /// Another application took over while the controller went on (controller:TR-17).
    OnlineChange {
        /// Only code differs, no variable.
        code_only: bool,
    },
    /// The saved context of the remanent variables was not valid (controller:STATE-10).
    ContextInvalid,
    /// An input is driven faster than the profile allows: not the controller's entry but the rig's (io:REF-03).
    Overdriven {
        /// The input: n for In.
        input: usize,
    },
    /// Edges come faster than an expert function can take them: not the controller's entry but the rig's
    /// (io:STD-HSC-16).
    FunctionOverdriven {
        /// The function, by its place in the configuration.
        function: usize,
    },
    /// An endpoint had more to send than its port has room for: not the controller's entry but the rig's.
    OutboxFull {
        /// The port's name.
        port: &'static str,
        /// Messages of this port that were not sent so far for this reason.
        dropped: u64,
    },
    /// The last power cycle is longer ago than the documents allow (controller:RB-05).
    PowerCycleDue,
    /// The supply was interrupted.
    SupplyLost,
    /// The supply came back within the hold-up time (controller:HW-08, controller:HW-09).
    SupplyBack,
}
