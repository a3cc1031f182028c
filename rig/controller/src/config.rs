//! What is configured: reference, tasks, filters, behaviour in stop and at power-on.

use profile::{Filter, MINIMUM_CYCLE, PRIORITIES, Profile, Reference};
use signal::Span;
use std::fmt;

/// The configuration of a controller. The place of a task in `tasks` is its number everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Which documented controller (controller:CONV-01).
    pub profile: Profile,
    /// Which reference of it.
    pub reference: &'static Reference,
    /// The tasks; one of them is MAST (controller:TASK-51).
    pub tasks: Vec<TaskConfig>,
    /// Filter of each embedded input from I0; inputs beyond the list have the default of 4 ms.
    pub filters: Vec<Filter>,
    /// Default value of each embedded output, bit n for Qn (controller:OUT-01).
    pub output_defaults: u32,
    /// Behaviour for outputs in Stop (controller:DEV-10).
    pub outputs_in_stop: OutputsInStop,
    /// What outputs do in HALT.
    pub halt_outputs: HaltOutputs,
    /// Update IO while in stop (controller:STOP-04).
    pub update_io_in_stop: bool,
    /// Starting mode (controller:DEV-10).
    pub starting_mode: StartingMode,
    /// What the time of a task watchdog measures (controller:WD-10).
    pub watchdog_basis: WatchdogBasis,
}

/// One task (controller:TASK-02).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskConfig {
    /// Its name, unique in any case of letters.
    pub name: String,
    /// 0 (highest)...31 (controller:PRIO-01).
    pub priority: u8,
    /// What starts its cycles.
    pub kind: TaskKind,
    /// Its watchdog, where enabled.
    pub watchdog: Option<Watchdog>,
}

/// What starts the cycles of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskKind {
    /// A fixed interval (controller:TASK-10), at least the minimum cycle of 1 us.
    Cyclic {
        /// From one start to the next.
        interval: Span,
    },
}

/// A task watchdog (controller:WD-10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watchdog {
    /// A cycle longer than this is an exception.
    pub time: Span,
    /// Consecutive exceptions that make the application error; 0 acts as 1.
    pub sensitivity: u32,
}

/// Behaviour for outputs in Stop (controller:DEV-10, controller:STOP-03).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OutputsInStop {
    /// Keep current values.
    Keep,
    /// Set all outputs to default, the default.
    #[default]
    Default,
}

/// What outputs do in HALT: the documents grant "Keep current values" to STOPPED only, so both readings can be
/// chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum HaltOutputs {
    /// The same as in STOPPED.
    #[default]
    Configured,
    /// Always the default values.
    Default,
}

/// Starting mode at power-on (controller:DEV-10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StartingMode {
    /// Start as previous state, the default.
    #[default]
    Previous,
    /// Start in stop.
    Stop,
    /// Start in run.
    Run,
}

/// What the time of a task watchdog measures (controller:WD-10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WatchdogBasis {
    /// From the start of the cycle to its end, with the time in which the task was pre-empted.
    #[default]
    Elapsed,
    /// The processor time of the task alone, for comparison.
    Processor,
}

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
    /// More cyclic tasks than the profile allows (controller:TASK-01).
    TooManyCyclic {
        /// Cyclic tasks in the configuration.
        found: usize,
        /// Cyclic tasks allowed.
        most: usize,
    },
    /// Two tasks have one name.
    SameName {
        /// Their places.
        tasks: (usize, usize),
    },
    /// Two tasks have one priority (controller:PRIO-02). Refused in every profile: the 2 ms time slices of the M241
    /// of 2014 are not reproduced.
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
    /// More filters than the reference has inputs.
    Filters {
        /// Filters in the configuration.
        found: usize,
        /// Inputs of the reference.
        inputs: usize,
    },
    /// Default values for outputs that the reference does not have.
    OutputDefaults {
        /// Outputs of the reference.
        outputs: usize,
    },
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
            ConfigError::TooManyCyclic { found, most } => {
                write!(f, "{found} cyclic tasks, the profile allows {most}")
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
            ConfigError::Filters { found, inputs } => write!(f, "{found} filters for {inputs} inputs"),
            ConfigError::OutputDefaults { outputs } => {
                write!(f, "default values for outputs above the reference's {outputs}")
            }
        }
    }
}

impl std::error::Error for ConfigError {}

impl TaskConfig {
    /// The task that exists by itself: MAST, cyclic 20 ms, priority 15, watchdog 100 ms with sensitivity 1
    /// (controller:TASK-50).
    pub fn mast() -> TaskConfig {
        TaskConfig {
            name: "MAST".into(),
            priority: profile::DEFAULT_PRIORITY,
            kind: TaskKind::Cyclic { interval: Span::from_millis(20) },
            watchdog: Some(Watchdog { time: Span::from_millis(100), sensitivity: 1 }),
        }
    }

    /// From one start to the next.
    pub const fn interval(&self) -> Span {
        let TaskKind::Cyclic { interval } = self.kind;
        interval
    }
}

impl Config {
    /// The defaults of a profile: its default reference, MAST alone, filters of 4 ms, outputs to default in stop,
    /// inputs and outputs updated in stop, start as previous state (controller:DEV-10).
    pub fn new(profile: Profile) -> Config {
        Config {
            profile,
            reference: profile.default_reference(),
            tasks: vec![TaskConfig::mast()],
            filters: Vec::new(),
            output_defaults: 0,
            outputs_in_stop: OutputsInStop::default(),
            halt_outputs: HaltOutputs::default(),
            update_io_in_stop: true,
            starting_mode: StartingMode::default(),
            watchdog_basis: WatchdogBasis::default(),
        }
    }

    /// Place of the task with this name, in any case of letters.
    pub fn task(&self, name: &str) -> Option<usize> {
        self.tasks.iter().position(|task| task.name.eq_ignore_ascii_case(name))
    }

    /// Whether a controller of the profile accepts the configuration.
    ///
    /// # Errors
    /// The first [`ConfigError`].
    pub fn check(&self) -> Result<(), ConfigError> {
        if !self.profile.accepts(self.reference) {
            return Err(ConfigError::Reference);
        }
        if self.task("MAST").is_none() {
            return Err(ConfigError::NoMast);
        }
        let limits = self.profile.task_limits(self.reference);
        let found = self.tasks.len();
        if found > limits.total {
            return Err(ConfigError::TooManyTasks { found, most: limits.total });
        }
        if found > limits.cyclic {
            return Err(ConfigError::TooManyCyclic { found, most: limits.cyclic });
        }
        for (place, task) in self.tasks.iter().enumerate() {
            if !PRIORITIES.contains(&task.priority) {
                return Err(ConfigError::Priority { task: place, priority: task.priority });
            }
            if task.interval() < MINIMUM_CYCLE {
                return Err(ConfigError::Interval { task: place, interval: task.interval() });
            }
            if task.watchdog.is_some_and(|watchdog| watchdog.time <= Span::ZERO) {
                return Err(ConfigError::WatchdogTime { task: place });
            }
            for (other, earlier) in self.tasks[..place].iter().enumerate() {
                if earlier.name.eq_ignore_ascii_case(&task.name) {
                    return Err(ConfigError::SameName { tasks: (other, place) });
                }
                if earlier.priority == task.priority {
                    return Err(ConfigError::SamePriority { tasks: (other, place), priority: task.priority });
                }
            }
        }
        let (inputs, outputs) = (self.reference.input_count(), self.reference.output_count());
        if self.filters.len() > inputs {
            return Err(ConfigError::Filters { found: self.filters.len(), inputs });
        }
        if u64::from(self.output_defaults) >> outputs != 0 {
            return Err(ConfigError::OutputDefaults { outputs });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(change: impl FnOnce(&mut Config)) -> Result<(), ConfigError> {
        let mut config = Config::new(Profile::default());
        change(&mut config);
        config.check()
    }

    fn cyclic(name: &str, priority: u8) -> TaskConfig {
        TaskConfig { name: name.into(), priority, ..TaskConfig::mast() }
    }

    #[test]
    fn defaults_are_accepted() {
        assert!(Profile::ALL.iter().all(|profile| Config::new(*profile).check().is_ok()));
    }

    // controller:TASK-01, controller:TASK-51, controller:PRIO-01, controller:PRIO-02
    #[test]
    fn each_limit_is_refused() {
        assert_eq!(with(|c| c.tasks[0].name = "FAST".into()), Err(ConfigError::NoMast));
        assert_eq!(with(|c| c.tasks[0].name = "mast".into()), Ok(()));
        let many = |c: &mut Config| c.tasks.extend((0..5).map(|n| cyclic(&format!("T{n}"), n)));
        assert_eq!(with(many), Err(ConfigError::TooManyCyclic { found: 6, most: 5 }));
        let old = |c: &mut Config| {
            c.profile = Profile::M241_2014;
            c.tasks.extend((0..4).map(|n| cyclic(&format!("T{n}"), n)));
        };
        assert_eq!(with(old), Err(ConfigError::TooManyCyclic { found: 5, most: 4 }));
        let same = ConfigError::SamePriority { tasks: (0, 1), priority: 15 };
        assert_eq!(with(|c| c.tasks.push(cyclic("B", 15))), Err(same));
        assert_eq!(with(|c| c.tasks.push(cyclic("Mast", 1))), Err(ConfigError::SameName { tasks: (0, 1) }));
        assert_eq!(with(|c| c.tasks[0].priority = 32), Err(ConfigError::Priority { task: 0, priority: 32 }));
        let short = Span::from_nanos(999);
        assert_eq!(
            with(|c| c.tasks[0].kind = TaskKind::Cyclic { interval: short }),
            Err(ConfigError::Interval { task: 0, interval: short })
        );
        assert_eq!(with(|c| c.profile = Profile::M251_2024), Err(ConfigError::Reference));
        assert_eq!(with(|c| c.output_defaults = 1 << 10), Err(ConfigError::OutputDefaults { outputs: 10 }));
        assert_eq!(
            with(|c| c.filters = vec![Filter::None; 15]),
            Err(ConfigError::Filters { found: 15, inputs: 14 })
        );
    }
}
