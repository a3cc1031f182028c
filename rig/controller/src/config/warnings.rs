//! What a controller accepts of a configuration with a warning.

use super::{Config, TaskConfig, TaskKind};
use crate::event_source::ExternalEventSource;
use profile::{ModuleKind, Profile};
use signal::Span;
use std::fmt;

/// Something in a configuration that is accepted and should not be. Tasks are named by their places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warning {
    /// Two tasks have one priority: they run in turn (controller:PRIO-02, M241 of 2014).
    SamePriority {
        /// The tasks.
        tasks: (usize, usize),
        /// The priority.
        priority: u8,
    },
    /// Their watchdogs let the tasks above a freewheeling one take more than half of the processor, which leaves
    /// less than 15 % for system processing (controller:TASK-23, controller:TASK-22).
    LongTasks {
        /// The freewheeling task.
        task: usize,
    },
    /// An input raises events that has no Event parameter: the 2014 document names it as an advanced input
    /// (controller:TASK-45, io:EVT-03).
    InputAlias {
        /// The task that it starts.
        task: usize,
        /// The input.
        input: usize,
    },
    /// A task waits for the event of an input whose Event parameter is No (controller:TASK-45).
    NoInputEvent {
        /// The task.
        task: usize,
        /// The input.
        input: usize,
    },
    /// A safety module may be missing on the bus: that is a decision about a risk (io:OPT-07).
    OptionalSafety {
        /// Its place in the list of modules, from 0.
        place: usize,
    },
    /// Two tasks write outputs of one byte, which the M241 of 2014 takes with a warning (controller:PRIO-05, io:EIO-17).
    SharedOutputByte {
        /// Byte of %Q.
        byte: u32,
        /// The tasks.
        tasks: (usize, usize),
    },
}

impl Warning {
    /// The warning with the names of the tasks.
    pub fn show<'a>(&self, name: impl Fn(usize) -> &'a str) -> String {
        match *self {
            Warning::SamePriority { tasks: (first, second), priority } => format!(
                "the tasks {} and {} both have priority {priority}: they take the processor in turn, {} each",
                name(first),
                name(second),
                profile::TIME_SLICE
            ),
            Warning::LongTasks { task } => format!(
                "tasks of higher priority than the freewheeling task {} may take more than half of the processor",
                name(task)
            ),
            Warning::InputAlias { task, input } => {
                format!(
                    "the event of {} comes from input I{input}, an alias of the 2014 document",
                    name(task)
                )
            }
            Warning::NoInputEvent { task, input } => {
                format!("{} waits for the event of I{input}, which raises none: set its `event`", name(task))
            }
            Warning::OptionalSafety { place } => format!(
                "module {} of the list is a safety module and optional: whether it may be missing is a decision about a risk",
                place + 1
            ),
            Warning::SharedOutputByte { byte, tasks: (first, second) } => {
                format!("outputs of %QB{byte} are written by {} and by {}", name(first), name(second))
            }
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.show(|_| "of the configuration"))
    }
}

impl Config {
    /// What is accepted with a warning, of a configuration that was checked.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut found = Vec::new();
        for (place, task) in self.tasks.iter().enumerate() {
            let other = self.tasks[..place].iter().position(|other| other.priority == task.priority);
            if let Some(other) = other {
                found.push(Warning::SamePriority { tasks: (other, place), priority: task.priority });
            }
            match task.kind {
                TaskKind::Freewheeling if self.may_be_long(task) => {
                    found.push(Warning::LongTasks { task: place });
                }
                TaskKind::ExternalEvent { source: ExternalEventSource::Input(input) }
                    if self.profile == Profile::M241_2014 && input >= 8 =>
                {
                    found.push(Warning::InputAlias { task: place, input });
                }
                TaskKind::ExternalEvent { source: ExternalEventSource::Input(input) }
                    if input < self.reference.fast_inputs
                        && self.inputs.get(input).is_none_or(|own| own.event.is_none()) =>
                {
                    found.push(Warning::NoInputEvent { task: place, input });
                }
                _ => {}
            }
        }
        for (place, one) in self.modules.iter().enumerate() {
            if one.optional && one.module.kind == ModuleKind::Safety {
                found.push(Warning::OptionalSafety { place });
            }
        }
        found
    }

    /// Whether the cyclic tasks above a freewheeling one may take more than half of the processor before their
    /// watchdogs stop them.
    fn may_be_long(&self, freewheeling: &TaskConfig) -> bool {
        let above = self.tasks.iter().filter(|task| task.priority < freewheeling.priority);
        let shares = above.filter_map(|task| {
            let interval = task.interval()?;
            let most = task.watchdog.map_or(Span::MAX, |watchdog| watchdog.time).min(interval);
            Some(i128::from(most.as_nanos()) * 1_000_000 / i128::from(interval.as_nanos().max(1)))
        });
        shares.sum::<i128>() > 500_000
    }
}
