//! The one processor and the tasks that share it (controller:TASK-03): who is due, who has it, for how long.
//!
//! The scheduler knows neither memory nor programs. Its owner asks what comes next with [`Scheduler::next_step`], carries
//! it out, and says how much processor time it took.

mod events;
mod load;
mod release;
mod task;
mod time_slice;
mod watchdog;

pub(crate) use release::TaskTrigger;
pub(crate) use watchdog::SystemWatchdog;

pub use load::Overload;
pub use task::{JITTER_BORDERS, JitterCounts, TaskFigure, TaskFigures};

use crate::config::{Config, TaskKind, WatchdogBasis};
use events::{EventQueue, EventRate};
use load::Load;
use profile::{MINIMUM_CYCLE, StopCause};
use signal::{Span, Time};
use task::Task;

/// Processor and tasks. A task's *rank* is its place by priority, the highest first; its *place* is that in the
/// configuration.
#[derive(Clone, Debug)]
pub(crate) struct Scheduler {
    /// By rank.
    tasks: Vec<Task>,
    /// Place of MAST.
    mast: usize,
    basis: WatchdogBasis,
    /// Up to here application code has taken effect.
    at: Time,
    /// An operation is under way since `at` and completes then; it belongs to the task of rank `running`.
    in_flight: Option<Time>,
    /// Rank of the task that ran last.
    running: usize,
    /// Ranks with a release that waits for its cycle, bit 0 the highest priority. There are at most 24 tasks
    /// (controller:TASK-01).
    ready: u32,
    /// Ranks with a cycle under way.
    active: u32,
    /// Ranks that sleep or are suspended.
    held: u32,
    /// A stop waits for the cycles under way.
    stopping: Option<StopCause>,
    /// An online change waits for them.
    changing: bool,
    /// Since when a task is held at a breakpoint, and its place.
    breakpoint: Option<(Time, usize)>,
    /// Controller tasks (priority 0...24) have had the processor without a gap in this time (controller:WD-02).
    busy_since: Time,
    busy_until: Time,
    load: Load,
    /// Events on their way, and how many came.
    events: EventQueue,
    software_rate: EventRate,
    hardware_rate: EventRate,
    /// When the variables are looked at next that start event tasks.
    tick: Time,
}

/// What the processor does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NextStep {
    /// Nothing completes before the end of the span that was given.
    Wait,
    /// A cycle of the task of this rank begins.
    StartCycle(usize),
    /// The cycle of this rank runs up to `cap`, which is the end of its time slice or `end`.
    Execute { rank: usize, cap: Time, end: Time },
}

/// A cycle that ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CycleEnd {
    /// Place of the task.
    pub place: usize,
    /// From start to end.
    pub elapsed: Span,
    /// It took longer than its interval.
    pub overran: bool,
}

impl Scheduler {
    /// The tasks of a configuration that was checked, nothing due.
    pub(crate) fn new(config: &Config) -> Scheduler {
        let mut tasks: Vec<_> =
            config.tasks.iter().enumerate().map(|(place, task)| Task::new(place, task)).collect();
        tasks.sort_by_key(|task| task.priority);
        time_slice::find_peers(&mut tasks);
        Scheduler {
            load: Load::new(Time::MIN, &tasks),
            tasks,
            mast: config.task("MAST").unwrap_or_default(),
            basis: config.watchdog_basis,
            at: Time::MIN,
            in_flight: None,
            running: 0,
            ready: 0,
            active: 0,
            held: 0,
            stopping: None,
            changing: false,
            breakpoint: None,
            busy_since: Time::MIN,
            busy_until: Time::MIN,
            events: EventQueue::new(),
            software_rate: EventRate::new(),
            hardware_rate: EventRate::new(),
            tick: Time::MAX,
        }
    }

    /// Number of tasks.
    pub(crate) fn len(&self) -> usize {
        self.tasks.len()
    }

    /// The tasks' places, by rank.
    pub(crate) fn places(&self) -> impl Iterator<Item = usize> + '_ {
        self.tasks.iter().map(|task| task.place)
    }

    /// Place of the task of this rank.
    #[inline]
    pub(crate) fn place(&self, rank: usize) -> usize {
        self.tasks[rank].place
    }

    /// Whether the task at this place is MAST.
    #[inline]
    pub(crate) const fn is_mast(&self, place: usize) -> bool {
        place == self.mast
    }

    /// The task at this place in the configuration.
    fn task(&self, place: usize) -> Option<&Task> {
        self.tasks.iter().find(|task| task.place == place)
    }

    fn task_mut(&mut self, place: usize) -> Option<&mut Task> {
        self.tasks.iter_mut().find(|task| task.place == place)
    }

    /// The figures of a task by its place.
    pub(crate) fn figures(&self, place: usize) -> Option<TaskFigures> {
        self.task(place).map(|task| task.figures)
    }

    /// How late the cycles of a task began, by its place.
    pub(crate) fn jitter(&self, place: usize) -> Option<&JitterCounts> {
        self.task(place).map(|task| &task.jitter_counts)
    }

    /// The next `times` cycles of a task take `cycle` of processor time at least.
    pub(crate) fn overload(&mut self, place: usize, cycle: Span, times: u32) {
        if let Some(task) = self.task_mut(place) {
            task.overload = (cycle, times);
        }
    }

    /// Up to here application code has taken effect.
    #[inline]
    pub(crate) const fn now(&self) -> Time {
        self.at
    }

    /// The processor idles up to `now`; an operation under way goes on.
    pub(crate) fn idle_until(&mut self, now: Time) {
        if self.in_flight.is_none() {
            self.at = self.at.max(now);
        }
    }

    /// No application code runs up to `now`.
    pub(crate) fn skip_to(&mut self, now: Time) {
        self.at = self.at.max(now);
    }

    /// The processor starts again at `now`; what was under way never completes.
    pub(crate) fn restart_at(&mut self, now: Time) {
        self.at = now;
    }

    /// Whether a task wants the processor or an operation is under way.
    #[inline]
    pub(crate) fn is_computing(&self) -> bool {
        self.runnable() != 0 || self.in_flight.is_some()
    }

    /// Whether no task wants the processor.
    #[inline]
    pub(crate) fn is_idle(&self) -> bool {
        self.runnable() == 0
    }

    /// Whether no cycle is under way.
    #[inline]
    pub(crate) const fn is_between_cycles(&self) -> bool {
        self.active == 0
    }

    /// A stop that waits for the cycles under way.
    #[inline]
    pub(crate) const fn stopping(&self) -> Option<StopCause> {
        self.stopping
    }

    /// No new cycle starts; the stop comes with the end of those under way.
    pub(crate) fn stop_after_cycles(&mut self, cause: StopCause) {
        self.stopping = Some(cause);
    }

    /// No new cycle starts while an online change waits for those under way.
    pub(crate) fn set_changing(&mut self, changing: bool) {
        self.changing = changing;
    }

    /// Execution ends where it is.
    pub(crate) fn abort_cycles(&mut self) {
        (self.breakpoint, self.changing) = (None, false);
        (self.ready, self.active, self.held) = (0, 0, 0);
        (self.in_flight, self.stopping) = (None, None);
        (self.events, self.software_rate, self.hardware_rate) =
            (EventQueue::new(), EventRate::new(), EventRate::new());
    }

    /// A new application was loaded: figures start again, intervals are the configured ones.
    pub(crate) fn begin_application(&mut self) {
        self.tasks.iter_mut().for_each(Task::begin_application);
    }

    /// Ranks that want the processor.
    #[inline]
    fn runnable(&self) -> u32 {
        let wanted =
            if self.stopping.is_none() && !self.changing { self.active | self.ready } else { self.active };
        wanted & !self.held
    }

    /// What the processor does next, up to `end`.
    #[inline]
    pub(crate) fn next_step(&mut self, end: Time) -> NextStep {
        let runnable = self.runnable();
        if runnable == 0 {
            self.at = end;
            return NextStep::Wait;
        }
        let chosen = self.chosen(runnable);
        // controller:TASK-03: pre-emption waits for the operation under way.
        let (rank, cap) = match self.in_flight {
            Some(until) if self.running != chosen => (self.running, until),
            _ => (chosen, end),
        };
        if cap > end {
            return NextStep::Wait;
        }
        let end = cap;
        let cap = if rank == chosen { self.start_time_slice(rank, cap) } else { cap };
        self.running = rank;
        if self.tasks[rank].foreground() && self.at > self.busy_until {
            (self.busy_since, self.busy_until) = (self.at, self.at);
        }
        if self.active >> rank & 1 == 0 {
            NextStep::StartCycle(rank)
        } else {
            NextStep::Execute { rank, cap, end }
        }
    }

    /// Begins a cycle.
    pub(crate) fn start_cycle(&mut self, rank: usize) {
        self.ready &= !(1 << rank);
        self.active |= 1 << rank;
        self.tasks[rank].start(self.at, MINIMUM_CYCLE);
    }

    /// Uses up to `cap` what a cycle takes after the program's last operation: whether that is all of it. `None` where
    /// the program is not done.
    #[inline]
    pub(crate) fn run_rest(&mut self, rank: usize, cap: Time) -> Option<bool> {
        let rest = self.tasks[rank].cycle.rest?;
        let used = rest.min(cap - self.at);
        self.tasks[rank].cycle.rest = Some(rest - used);
        self.pass(rank, used);
        Some(used == rest)
    }

    /// The program's part of a cycle is done: whether the cycle has taken the time that it takes at least.
    pub(crate) fn is_cycle_over(&mut self, rank: usize) -> bool {
        let cycle = &mut self.tasks[rank].cycle;
        if cycle.used < cycle.least {
            cycle.rest = Some(cycle.least - cycle.used);
            return false;
        }
        true
    }

    /// Operations of a task that took this long are complete, and none is under way.
    #[inline]
    pub(crate) fn complete(&mut self, rank: usize, used: Span) {
        self.in_flight = None;
        self.pass(rank, used);
    }

    /// An operation of the running task is under way, and takes this long: when it completes.
    #[inline]
    pub(crate) fn begin_operation(&mut self, takes: Span) -> Time {
        // At least a nanosecond, so that a cost of 0 cannot hold up the time.
        let until = self.at.saturating_add(takes.max(Span::from_nanos(1)));
        self.in_flight = Some(until);
        until
    }

    /// Ends a cycle. A freewheeling task's pause begins.
    pub(crate) fn end_cycle(&mut self, rank: usize) -> CycleEnd {
        let task = &mut self.tasks[rank];
        let elapsed = task.end(self.at);
        let end = CycleEnd { place: task.place, elapsed, overran: task.overran(elapsed) };
        if matches!(task.kind, TaskKind::Freewheeling) {
            self.pause(rank, elapsed);
        }
        self.end_time_slice(rank);
        self.active &= !(1 << rank);
        end
    }

    /// Processor time passes for a task.
    #[inline]
    fn pass(&mut self, rank: usize, used: Span) {
        self.load.advance(self.at, None, &mut self.tasks);
        self.at += used;
        self.load.advance(self.at, Some(rank), &mut self.tasks);
        self.use_time_slice(rank, used);
        let task = &mut self.tasks[rank];
        task.cycle.used = task.cycle.used + used;
        task.waits_since = self.at;
        if task.foreground() {
            self.busy_until = self.at;
        }
    }

    /// The task at this place stands before a statement with a breakpoint.
    pub(crate) fn hold_at_breakpoint(&mut self, place: usize) {
        self.breakpoint = Some((self.at, place));
    }

    /// Place of the task that is held at a breakpoint.
    pub(crate) fn at_breakpoint(&self) -> Option<usize> {
        self.breakpoint.map(|(_, place)| place)
    }

    /// The tasks go on at `now` in the middle of their cycles, as if no time had passed for them; whether they were held
    /// at a breakpoint.
    pub(crate) fn resume(&mut self, now: Time) -> bool {
        let Some((since, _)) = self.breakpoint.take() else { return false };
        let by = now - since;
        for task in &mut self.tasks {
            task.postpone(by);
        }
        // MAX stays MAX.
        self.tick = self.tick.saturating_add(by);
        self.busy_since = self.busy_since.saturating_add(by);
        self.busy_until = self.busy_until.saturating_add(by);
        // The processor had nothing to do.
        self.load.advance(now, None, &mut self.tasks);
        true
    }
}
