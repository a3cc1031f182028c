//! The run-time state of a task and its figures.

use super::release::TaskTrigger;
use super::time_slice::TimeSlice;
use crate::config::{TaskConfig, TaskKind, TaskWatchdog};
use crate::event_source::ExternalEventSource;
use profile::{SHORT_INTERVAL, SHORT_INTERVAL_TOLERANCE};
use signal::{Span, Time, Value};

/// What a task did since its application was loaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TaskFigures {
    /// Cycles that ended.
    pub cycles: u64,
    /// Processor time of the last cycle, without the time in which it was pre-empted.
    pub last: Span,
    /// Least processor time of a cycle; 0 before the first one.
    pub min: Span,
    /// Most processor time of a cycle.
    pub max: Span,
    /// Processor time of all cycles that ended.
    pub total: Span,
    /// From start to end of the last cycle, with the time in which it was pre-empted.
    pub elapsed: Span,
    /// Cycles that took longer than the interval, from start to end.
    pub overruns: u64,
    /// Releases and events that were lost because one was already waiting (controller:TASK-11).
    pub lost: u64,
    /// Watchdog exceptions (controller:WD-10).
    pub exceptions: u64,
    /// From the release of the last cycle to its start.
    pub jitter: Span,
    /// Least time from a release to the start of its cycle; 0 before the first one.
    pub min_jitter: Span,
    /// Most time from a release to the start of its cycle.
    pub max_jitter: Span,
    /// Cycles that began.
    pub starts: u64,
    /// Processor time in the last whole second since RUNNING was entered.
    pub load: Span,
}

/// The borders of [`JitterCounts`], in nanoseconds: 1, 2 and 5 of each decade from a microsecond to a second.
pub const JITTER_BORDERS: [i64; 19] = [
    1_000,
    2_000,
    5_000,
    10_000,
    20_000,
    50_000,
    100_000,
    200_000,
    500_000,
    1_000_000,
    2_000_000,
    5_000_000,
    10_000_000,
    20_000_000,
    50_000_000,
    100_000_000,
    200_000_000,
    500_000_000,
    1_000_000_000,
];

/// How many cycles of a task began how long after their release: up to each of [`JITTER_BORDERS`], and beyond the last.
pub type JitterCounts = [u64; JITTER_BORDERS.len() + 1];

/// One figure of [`TaskFigures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TaskFigure {
    /// Cycles that ended.
    Cycles,
    /// Processor time of the last cycle in nanoseconds.
    Last,
    /// Least processor time of a cycle in nanoseconds.
    Min,
    /// Most processor time of a cycle in nanoseconds.
    Max,
    /// From start to end of the last cycle in nanoseconds.
    Elapsed,
    /// Cycles that took longer than the interval.
    Overruns,
    /// Lost releases.
    Lost,
    /// Watchdog exceptions.
    Exceptions,
    /// Mean processor time of a cycle in nanoseconds.
    Mean,
    /// From the release of the last cycle to its start in nanoseconds.
    Jitter,
    /// Least of these times.
    MinJitter,
    /// Most of these times.
    MaxJitter,
    /// Share of the processor in the last whole second, in per cent.
    Load,
}

impl TaskFigures {
    /// Mean processor time of a cycle; 0 before the first one.
    pub fn mean(&self) -> Span {
        let cycles = i64::try_from(self.cycles).unwrap_or(i64::MAX).max(1);
        Span::from_nanos(self.total.as_nanos() / cycles)
    }

    /// One of the figures as a value: a count, nanoseconds, or per cent.
    pub(crate) fn get(&self, figure: TaskFigure) -> Value {
        let count = |n: u64| Value::Int(i64::try_from(n).unwrap_or(i64::MAX));
        match figure {
            TaskFigure::Cycles => count(self.cycles),
            TaskFigure::Last => Value::Int(self.last.as_nanos()),
            TaskFigure::Min => Value::Int(self.min.as_nanos()),
            TaskFigure::Max => Value::Int(self.max.as_nanos()),
            TaskFigure::Elapsed => Value::Int(self.elapsed.as_nanos()),
            TaskFigure::Overruns => count(self.overruns),
            TaskFigure::Lost => count(self.lost),
            TaskFigure::Exceptions => count(self.exceptions),
            TaskFigure::Mean => Value::Int(self.mean().as_nanos()),
            TaskFigure::Jitter => Value::Int(self.jitter.as_nanos()),
            TaskFigure::MinJitter => Value::Int(self.min_jitter.as_nanos()),
            TaskFigure::MaxJitter => Value::Int(self.max_jitter.as_nanos()),
            // Whole numbers of nanoseconds below 2^53: the quotient is the same on every host.
            TaskFigure::Load => Value::Real(self.load.as_nanos() as f64 / 10_000_000.0),
        }
    }
}

/// The marks that a task's watchdog watches in each cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct WatchdogLimits {
    /// A cycle still under way at this time is an exception.
    pub exception: Span,
    /// A cycle still under way at this time stops the application by itself: time × sensitivity.
    pub trip: Span,
    /// Consecutive exceptions that stop the application, at least 1.
    pub sensitivity: u32,
}

/// The cycle under way.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cycle {
    pub start: Time,
    /// Processor time so far.
    pub used: Span,
    /// Processor time that the cycle takes at least.
    pub least: Span,
    /// Processor time still to pass after the program's last operation, once that is done.
    pub rest: Option<Span>,
    /// Whether the exception of this cycle is counted.
    pub excepted: bool,
    /// The interval and the marks that hold for this cycle.
    pub interval: Option<Span>,
    pub marks: Option<WatchdogLimits>,
}

/// A task at run time.
#[derive(Clone, Debug)]
pub(super) struct Task {
    /// Place in the configuration, which is its number for the application.
    pub place: usize,
    pub priority: u8,
    /// Ranks of this priority, its own among them.
    pub peers: u32,
    /// Whose turn it is, at the first of them.
    pub turn: TimeSlice,
    pub kind: TaskKind,
    /// The event of an external event task.
    pub source: Option<ExternalEventSource>,
    /// What starts an event task, once the application is there, and what it showed last.
    pub trigger: Option<TaskTrigger>,
    pub trigger_was: bool,
    /// Interval of a cyclic task: the one that holds, and the one from the next release on.
    pub interval: Option<Span>,
    pub set_interval: Option<Span>,
    watchdog: Option<TaskWatchdog>,
    pub next_release: Time,
    /// Since when the cycle that waits, or the one under way, was due.
    pub due: Time,
    /// When it had the processor last, or became due after that.
    pub waits_since: Time,
    /// It does not want the processor until then (controller:TASK-52).
    pub sleeps_until: Time,
    /// It does not get the processor until then.
    pub suspended_until: Time,
    pub cycle: Cycle,
    /// Exceptions in a row.
    pub consecutive: u32,
    /// The next cycles take at least this long.
    pub overload: (Span, u32),
    /// Processor time in the second under way.
    pub used: Span,
    pub figures: TaskFigures,
    pub jitter_counts: JitterCounts,
}

impl Task {
    pub(super) fn new(place: usize, config: &TaskConfig) -> Task {
        Task {
            place,
            priority: config.priority,
            peers: 0,
            turn: TimeSlice::NONE,
            kind: config.kind.clone(),
            source: match config.kind {
                TaskKind::ExternalEvent { source } => Some(source),
                _ => None,
            },
            trigger: None,
            trigger_was: false,
            interval: config.interval(),
            set_interval: config.interval(),
            watchdog: config.watchdog,
            next_release: Time::MAX,
            due: Time::MIN,
            waits_since: Time::MIN,
            sleeps_until: Time::MIN,
            suspended_until: Time::MIN,
            cycle: Cycle::default(),
            consecutive: 0,
            overload: (Span::ZERO, 0),
            used: Span::ZERO,
            figures: TaskFigures::default(),
            jitter_counts: JitterCounts::default(),
        }
    }

    /// A new application was loaded: figures start again, the interval is the configured one.
    pub(super) fn begin_application(&mut self) {
        self.figures = TaskFigures::default();
        self.jitter_counts = JitterCounts::default();
        self.consecutive = 0;
        if let TaskKind::Cyclic { interval } = self.kind {
            (self.interval, self.set_interval) = (Some(interval), Some(interval));
        }
    }

    /// RUNNING is entered: nothing is due yet.
    pub(super) fn begin_running(&mut self) {
        self.interval = self.set_interval;
        self.next_release = Time::MAX;
        self.consecutive = 0;
        self.used = Span::ZERO;
        self.turn = TimeSlice::NONE;
        (self.sleeps_until, self.suspended_until) = (Time::MIN, Time::MIN);
    }

    /// When it neither sleeps nor is held back.
    pub(super) fn held_until(&self) -> Time {
        self.sleeps_until.max(self.suspended_until)
    }

    /// Whether it is a controller task, not a background one (controller:PRIO-03).
    pub(super) fn foreground(&self) -> bool {
        profile::FOREGROUND_PRIORITIES.contains(&self.priority)
    }

    /// The marks of its watchdog at its present interval.
    fn marks(&self) -> Option<WatchdogLimits> {
        self.watchdog.map(|watchdog| {
            let sensitivity = watchdog.sensitivity.max(1);
            // controller:TASK-12: a short interval has a limit of its own.
            let exception = match self.interval {
                Some(interval) if interval < SHORT_INTERVAL => {
                    watchdog.time.min(interval + SHORT_INTERVAL_TOLERANCE)
                }
                _ => watchdog.time,
            };
            let trip = Span::from_nanos(watchdog.time.as_nanos().saturating_mul(i64::from(sensitivity)));
            WatchdogLimits { exception, trip, sensitivity }
        })
    }

    /// The next mark of the cycle under way.
    pub(super) fn mark(&self) -> Option<Span> {
        self.cycle.marks.map(|marks| if self.cycle.excepted { marks.trip } else { marks.exception })
    }

    /// Starts a cycle at `now` that takes at least `least` of processor time.
    pub(super) fn start(&mut self, now: Time, least: Span) {
        let (overload, times) = self.overload;
        let least = if times > 0 { overload.max(least) } else { least };
        self.overload.1 = times.saturating_sub(1);
        let (jitter, figures) = (now - self.due, &mut self.figures);
        figures.min_jitter = if figures.starts == 0 { jitter } else { figures.min_jitter.min(jitter) };
        figures.max_jitter = figures.max_jitter.max(jitter);
        figures.jitter = jitter;
        figures.starts += 1;
        self.jitter_counts[JITTER_BORDERS.partition_point(|border| *border < jitter.as_nanos())] += 1;
        self.cycle = Cycle {
            start: now,
            used: Span::ZERO,
            least,
            rest: None,
            excepted: false,
            interval: self.interval,
            marks: self.marks(),
        };
    }

    /// Whether a cycle of this length is longer than its interval.
    pub(super) fn overran(&self, elapsed: Span) -> bool {
        self.cycle.interval.is_some_and(|interval| elapsed > interval)
    }

    /// What it waits for comes later by this, and its cycle began later.
    pub(super) fn postpone(&mut self, by: Span) {
        let times = [
            &mut self.next_release,
            &mut self.cycle.start,
            &mut self.due,
            &mut self.waits_since,
            &mut self.sleeps_until,
            &mut self.suspended_until,
        ];
        for time in times {
            *time = time.saturating_add(by);
        }
    }

    /// Ends the cycle at `now`; its time from start to end.
    pub(super) fn end(&mut self, now: Time) -> Span {
        let elapsed = now - self.cycle.start;
        if !self.cycle.excepted {
            self.consecutive = 0;
        }
        let over = self.overran(elapsed);
        let (used, figures) = (self.cycle.used, &mut self.figures);
        figures.min = if figures.cycles == 0 { used } else { figures.min.min(used) };
        figures.max = figures.max.max(used);
        figures.total = figures.total + used;
        (figures.last, figures.elapsed) = (used, elapsed);
        figures.cycles += 1;
        figures.overruns += u64::from(over);
        elapsed
    }
}
