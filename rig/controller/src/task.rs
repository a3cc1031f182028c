//! The run-time state of a task and its figures.

use crate::TaskConfig;
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
    /// Releases that were lost because one was already waiting (controller:TASK-11).
    pub lost: u64,
    /// Watchdog exceptions (controller:WD-10).
    pub exceptions: u64,
}

/// One figure of [`TaskFigures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Figure {
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
}

impl TaskFigures {
    /// Mean processor time of a cycle; 0 before the first one.
    pub fn mean(&self) -> Span {
        let cycles = i64::try_from(self.cycles).unwrap_or(i64::MAX).max(1);
        Span::from_nanos(self.total.as_nanos() / cycles)
    }

    /// One of the figures as a value: a count, or nanoseconds.
    pub(crate) fn get(&self, figure: Figure) -> Value {
        let count = |n: u64| Value::Int(i64::try_from(n).unwrap_or(i64::MAX));
        match figure {
            Figure::Cycles => count(self.cycles),
            Figure::Last => Value::Int(self.last.as_nanos()),
            Figure::Min => Value::Int(self.min.as_nanos()),
            Figure::Max => Value::Int(self.max.as_nanos()),
            Figure::Elapsed => Value::Int(self.elapsed.as_nanos()),
            Figure::Overruns => count(self.overruns),
            Figure::Lost => count(self.lost),
            Figure::Exceptions => count(self.exceptions),
        }
    }
}

/// The marks that a task's watchdog watches in each cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Marks {
    /// A cycle still under way at this time is an exception.
    pub exception: Span,
    /// A cycle still under way at this time stops the application by itself: time × sensitivity.
    pub trip: Span,
    /// Consecutive exceptions that stop the application, at least 1.
    pub sensitivity: u32,
}

/// The cycle under way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cycle {
    pub start: Time,
    /// Processor time so far.
    pub used: Span,
    /// Processor time that the cycle takes at least.
    pub least: Span,
    /// Processor time still to pass behind the program's last operation, once that is done.
    pub rest: Option<Span>,
    /// Whether the exception of this cycle is counted.
    pub excepted: bool,
}

/// A task at run time.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    /// Place in the configuration, which is its number for the application.
    pub place: usize,
    pub priority: u8,
    pub interval: Span,
    pub marks: Option<Marks>,
    pub next_release: Time,
    pub cycle: Cycle,
    /// Exceptions in a row.
    pub consecutive: u32,
    /// The next cycles take at least this long.
    pub overload: (Span, u32),
    pub figures: TaskFigures,
}

impl Task {
    pub(crate) fn new(place: usize, config: &TaskConfig) -> Task {
        let interval = config.interval();
        let marks = config.watchdog.map(|watchdog| {
            let sensitivity = watchdog.sensitivity.max(1);
            // controller:TASK-12: a short interval has a limit of its own.
            let short = interval + SHORT_INTERVAL_TOLERANCE;
            let exception = if interval < SHORT_INTERVAL { watchdog.time.min(short) } else { watchdog.time };
            let trip = Span::from_nanos(watchdog.time.as_nanos().saturating_mul(i64::from(sensitivity)));
            Marks { exception, trip, sensitivity }
        });
        Task {
            place,
            priority: config.priority,
            interval,
            marks,
            next_release: Time::MAX,
            cycle: Cycle::default(),
            consecutive: 0,
            overload: (Span::ZERO, 0),
            figures: TaskFigures::default(),
        }
    }

    /// Whether it is a controller task, not a background one (controller:PRIO-03).
    pub(crate) fn foreground(&self) -> bool {
        profile::FOREGROUND_PRIORITIES.contains(&self.priority)
    }

    /// The next mark of the cycle under way.
    pub(crate) fn mark(&self) -> Option<Span> {
        self.marks.map(|marks| if self.cycle.excepted { marks.trip } else { marks.exception })
    }

    /// Starts a cycle at `now` that takes at least `least` of processor time.
    pub(crate) fn start(&mut self, now: Time, least: Span) {
        let (overload, times) = self.overload;
        let least = if times > 0 { overload.max(least) } else { least };
        self.overload.1 = times.saturating_sub(1);
        self.cycle = Cycle { start: now, used: Span::ZERO, least, rest: None, excepted: false };
    }

    /// Ends the cycle at `now`; its time from start to end.
    pub(crate) fn end(&mut self, now: Time) -> Span {
        let elapsed = now - self.cycle.start;
        if !self.cycle.excepted {
            self.consecutive = 0;
        }
        let (used, figures) = (self.cycle.used, &mut self.figures);
        figures.min = if figures.cycles == 0 { used } else { figures.min.min(used) };
        figures.max = figures.max.max(used);
        figures.total = figures.total + used;
        (figures.last, figures.elapsed) = (used, elapsed);
        figures.cycles += 1;
        figures.overruns += u64::from(elapsed > self.interval);
        elapsed
    }
}
