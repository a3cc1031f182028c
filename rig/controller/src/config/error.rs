//! Why a configuration is not accepted.

use super::{InputFault, RunStopFault};
use crate::event_source::ExternalEventSource;
use expert::ExpertError;
use profile::{CompositionError, ImageFull, MINIMUM_CYCLE, PRIORITIES};
use signal::Span;
use thiserror::Error;

/// A configuration that no controller of the profile accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ConfigError {
    /// The reference belongs to another profile.
    #[error("the reference belongs to another profile")]
    Reference,
    /// No task is named MAST (controller:TASK-51).
    #[error("no task is named MAST: the application cannot be built without it")]
    NoMast,
    /// More tasks than the profile allows (controller:TASK-01).
    #[error("{found} tasks, the profile allows {most}")]
    TooManyTasks {
        /// Tasks in the configuration.
        found: usize,
        /// Tasks allowed.
        most: usize,
    },
    /// More tasks of one kind than the profile allows (controller:TASK-01).
    #[error("{found} {kind} tasks, the profile allows {most}")]
    TooManyOfKind {
        /// The kind in words.
        kind: &'static str,
        /// Tasks of that kind in the configuration.
        found: usize,
        /// Tasks of that kind allowed.
        most: usize,
    },
    /// MAST is neither cyclic nor freewheeling (controller:TASK-50).
    #[error("MAST is cyclic or freewheeling, not started by events")]
    MastKind,
    /// The controller does not have the event of an external event task (controller:TASK-41).
    #[error("task {task} is started by {event}, an event that the controller does not have")]
    Event {
        /// Place of the task.
        task: usize,
        /// Its event.
        event: ExternalEventSource,
    },
    /// What would raise the event of an external event task is not configured to: an input (controller:TASK-45), or the
    /// CANopen manager (controller:TASK-42).
    #[error("task {task} is started by {event}, an event that nothing is configured to raise")]
    NoEvent {
        /// Place of the task.
        task: usize,
        /// Its event.
        event: ExternalEventSource,
    },
    /// The bus cycle task is an event task (controller:PRIO-06, io:EVT-08), or there is no such task.
    #[error("the bus cycle task is a cyclic or freewheeling task of the application")]
    BusCycleTask,
    /// The profile does not have this choice of "Always update variables" (controller:DEV-10).
    #[error("the profile does not have this choice of \"Always update variables\"")]
    AlwaysUpdate,
    /// A module that cannot be where it is (io: sections 9, 10 and 12).
    #[error("{0}")]
    Module(CompositionError),
    /// A module that the rig has no model of yet.
    #[error("module {} of the list has no model yet", place + 1)]
    NoModuleModel {
        /// Its place in the list.
        place: usize,
    },
    /// The images have no room for the modules (io:ADR-06).
    #[error("{0}")]
    ImageFull(ImageFull),
    /// An expert function (io: section 6.2).
    #[error("the expert function {}: {}", .0.function + 1, .0)]
    Expert(#[source] ExpertError),
    /// Two tasks have one name.
    #[error("tasks {} and {} have one name", tasks.0, tasks.1)]
    SameName {
        /// Their places.
        tasks: (usize, usize),
    },
    /// Two tasks have one priority (controller:PRIO-02). The M241 of 2014 accepts it.
    #[error("tasks {} and {} both have priority {priority}: give each its own", tasks.0, tasks.1)]
    SamePriority {
        /// Their places.
        tasks: (usize, usize),
        /// The priority.
        priority: u8,
    },
    /// A priority above 31 (controller:PRIO-01).
    #[error("task {task} has priority {priority}: the lowest is {}", PRIORITIES.end())]
    Priority {
        /// Place of the task.
        task: usize,
        /// Its priority.
        priority: u8,
    },
    /// An interval below the minimum cycle.
    #[error("task {task} has an interval of {interval}: the least is {MINIMUM_CYCLE}")]
    Interval {
        /// Place of the task.
        task: usize,
        /// Its interval.
        interval: Span,
    },
    /// A watchdog time of 0 or less.
    #[error("the watchdog time of task {task} is not above 0")]
    WatchdogTime {
        /// Place of the task.
        task: usize,
    },
    /// Parameters that an input cannot have together.
    #[error("I{input} {fault}")]
    Input {
        /// The input: n for In.
        input: usize,
        /// What does not go together.
        #[source]
        fault: InputFault,
    },
    /// An input that cannot be the Run/Stop input.
    #[error("I{input} cannot be the Run/Stop input: {fault}")]
    RunStopInput {
        /// The input: n for In.
        input: usize,
        /// Why.
        #[source]
        fault: RunStopFault,
    },
    /// Parameters of more inputs than the reference has.
    #[error("parameters of {found} inputs for a reference with {inputs}")]
    Inputs {
        /// Inputs in the configuration.
        found: usize,
        /// Inputs of the reference.
        inputs: usize,
    },
    /// Default values for outputs that the reference does not have.
    #[error("default values for outputs above the reference's {outputs}")]
    OutputDefaults {
        /// Outputs of the reference.
        outputs: usize,
    },
    /// An alarm output that the reference does not have (controller:RS-08).
    #[error("the alarm output is above the reference's {outputs} outputs")]
    AlarmOutput {
        /// Outputs of the reference.
        outputs: usize,
    },
    /// An option of embedded outputs for a reference without them (controller:PRIO-08, io:OUT-08).
    #[error("the reference has no embedded outputs to rearm or to write with less jitter")]
    NoOutputs,
    /// SYNC of a CANopen manager on a reference without a CAN port (controller:HW-02, controller:HW-04).
    #[error("the reference has no CAN port: no CANopen manager of it produces or consumes SYNC")]
    NoCan,
}
