//! How a task is configured (controller:TASK-02).

use crate::event_source::ExternalEventSource;
use signal::Span;

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
    pub watchdog: Option<TaskWatchdog>,
}

/// What starts the cycles of a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TaskKind {
    /// A fixed interval (controller:TASK-10), at least the minimum cycle of 1 us.
    Cyclic {
        /// From one start to the next.
        interval: Span,
    },
    /// The end of a pause after the cycle before, whose length depends on that cycle's (controller:TASK-20).
    Freewheeling,
    /// A Boolean variable that becomes TRUE (controller:TASK-30).
    Event {
        /// Its path, or the address of a bit.
        trigger: String,
    },
    /// An event of the hardware (controller:TASK-40).
    ExternalEvent {
        /// The event.
        source: ExternalEventSource,
    },
}

/// A task watchdog (controller:WD-10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TaskWatchdog {
    /// A cycle longer than this is an exception.
    pub time: Span,
    /// Consecutive exceptions that make the application error; 0 acts as 1.
    pub sensitivity: u32,
}

impl TaskConfig {
    /// The task that exists by itself: MAST, cyclic 20 ms, priority 15, watchdog 100 ms with sensitivity 1
    /// (controller:TASK-50).
    pub fn mast() -> TaskConfig {
        TaskConfig {
            name: "MAST".into(),
            priority: profile::DEFAULT_PRIORITY,
            kind: TaskKind::Cyclic { interval: Span::from_millis(20) },
            watchdog: Some(TaskWatchdog { time: Span::from_millis(100), sensitivity: 1 }),
        }
    }

    /// Whether its cycles begin without an event.
    pub(super) fn runs_by_itself(&self) -> bool {
        matches!(self.kind, TaskKind::Cyclic { .. } | TaskKind::Freewheeling)
    }

    /// From one start to the next, of a cyclic task.
    pub const fn interval(&self) -> Option<Span> {
        match self.kind {
            TaskKind::Cyclic { interval } => Some(interval),
            _ => None,
        }
    }
}
