//! Why a configuration is not accepted.

use super::{InputFault, RunStopFault};
use crate::event_source::ExternalEventSource;
use expert::ExpertError;
use profile::{MINIMUM_CYCLE, PRIORITIES};
use signal::Span;
use std::fmt;

/// A configuration that no controller of the profile accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConfigError {
    /// The reference belongs to another profile.
    Reference,
    /// No task is named MAST (controller:TASK-51).
    NoMast,
    /// More tasks than the profile allows (controller:TASK-01).
    TooManyTasks {
        /// Tasks in the configuration.
        found: usize,
        /// Tasks allowed.
        most: usize,
    },
    /// More tasks of one kind than the profile allows (controller:TASK-01).
    TooManyOfKind {
        /// The kind in words.
        kind: &'static str,
        /// Tasks of that kind in the configuration.
        found: usize,
        /// Tasks of that kind allowed.
        most: usize,
    },
    /// MAST is neither cyclic nor freewheeling (controller:TASK-50).
    MastKind,
    /// The controller does not have the event of an external event task (controller:TASK-41).
    Event {
        /// Place of the task.
        task: usize,
        /// Its event.
        source: ExternalEventSource,
    },
    /// The input that starts an external event task raises no event (controller:TASK-45).
    NoEvent {
        /// Place of the task.
        task: usize,
        /// Its event.
        source: ExternalEventSource,
    },
    /// The bus cycle task is an event task (controller:PRIO-06, io:EVT-08), or there is no such task.
    BusCycleTask,
    /// The profile does not have this choice of "Always update variables" (controller:DEV-10).
    AlwaysUpdate,
    /// An expert function (io: section 6.2).
    Expert(ExpertError),
    /// Two tasks have one name.
    SameName {
        /// Their places.
        tasks: (usize, usize),
    },
    /// Two tasks have one priority (controller:PRIO-02). The M241 of 2014 accepts it.
    SamePriority {
        /// Their places.
        tasks: (usize, usize),
        /// The priority.
        priority: u8,
    },
    /// A priority above 31 (controller:PRIO-01).
    Priority {
        /// Place of the task.
        task: usize,
        /// Its priority.
        priority: u8,
    },
    /// An interval below the minimum cycle.
    Interval {
        /// Place of the task.
        task: usize,
        /// Its interval.
        interval: Span,
    },
    /// A watchdog time of 0 or less.
    WatchdogTime {
        /// Place of the task.
        task: usize,
    },
    /// Parameters that an input cannot have together.
    Input {
        /// The input: n for In.
        input: usize,
        /// What does not go together.
        fault: InputFault,
    },
    /// An input that cannot be the Run/Stop input.
    RunStopInput {
        /// The input: n for In.
        input: usize,
        /// Why.
        fault: RunStopFault,
    },
    /// Parameters of more inputs than the reference has.
    Inputs {
        /// Inputs in the configuration.
        found: usize,
        /// Inputs of the reference.
        inputs: usize,
    },
    /// Default values for outputs that the reference does not have.
    OutputDefaults {
        /// Outputs of the reference.
        outputs: usize,
    },
    /// An alarm output that the reference does not have (controller:RS-08).
    AlarmOutput {
        /// Outputs of the reference.
        outputs: usize,
    },
    /// An option of embedded outputs for a reference without them (controller:PRIO-08, io:OUT-08).
    NoOutputs,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ConfigError::Reference => f.write_str("the reference belongs to another profile"),
            ConfigError::NoMast => {
                f.write_str("no task is named MAST: the application cannot be built without it")
            }
            ConfigError::TooManyTasks { found, most } => {
                write!(f, "{found} tasks, the profile allows {most}")
            }
            ConfigError::TooManyOfKind { kind, found, most } => {
                write!(f, "{found} {kind} tasks, the profile allows {most}")
            }
            ConfigError::MastKind => f.write_str("MAST is cyclic or freewheeling, not started by events"),
            ConfigError::Event { task, source } => {
                write!(f, "task {task} is started by {source}, an event that the controller does not have")
            }
            ConfigError::NoEvent { task, source } => {
                write!(f, "task {task} is started by {source}, an input without an event")
            }
            ConfigError::BusCycleTask => {
                f.write_str("the bus cycle task is a cyclic or freewheeling task of the application")
            }
            ConfigError::AlwaysUpdate => {
                f.write_str("the profile does not have this choice of \"Always update variables\"")
            }
            ConfigError::Expert(error) => {
                write!(f, "the expert function {}: {error}", error.function + 1)
            }
            ConfigError::SameName { tasks } => write!(f, "tasks {} and {} have one name", tasks.0, tasks.1),
            ConfigError::SamePriority { tasks, priority } => {
                write!(
                    f,
                    "tasks {} and {} both have priority {priority}: give each its own",
                    tasks.0, tasks.1
                )
            }
            ConfigError::Priority { task, priority } => {
                write!(f, "task {task} has priority {priority}: the lowest is {}", PRIORITIES.end())
            }
            ConfigError::Interval { task, interval } => {
                write!(f, "task {task} has an interval of {interval}: the least is {MINIMUM_CYCLE}")
            }
            ConfigError::WatchdogTime { task } => {
                write!(f, "the watchdog time of task {task} is not above 0")
            }
            ConfigError::Input { input, fault } => write!(f, "I{input} {fault}"),
            ConfigError::RunStopInput { input, fault } => {
                write!(f, "I{input} cannot be the Run/Stop input: {fault}")
            }
            ConfigError::Inputs { found, inputs } => {
                write!(f, "parameters of {found} inputs for a reference with {inputs}")
            }
            ConfigError::OutputDefaults { outputs } => {
                write!(f, "default values for outputs above the reference's {outputs}")
            }
            ConfigError::AlarmOutput { outputs } => {
                write!(f, "the alarm output is above the reference's {outputs} outputs")
            }
            ConfigError::NoOutputs => {
                f.write_str("the reference has no embedded outputs to rearm or to write with less jitter")
            }
        }
    }
}

impl std::error::Error for ConfigError {}
