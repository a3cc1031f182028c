//! The load of the processor, and when there is too much of it (controller:WD-01, controller:WD-05).
//!
//! The load is evaluated at the ends of slots of [`LOAD_PERIOD`] since RUNNING was entered. An overload begins at the
//! instant from which on the processor time is always more than 85 % of the time that has passed. It is over at the
//! end of a slot at which the load of the window before it is no longer more than 85 %. The window is
//! [`LOAD_WINDOW`], or the longest interval of a cyclic task where that is longer: a load that repeats is measured
//! over its repetition. All of it is whole numbers of nanoseconds and depends on nothing but who had the processor
//! when (docs/decisions/0010-tasks-events-and-load.md).

use super::task::Task;
use crate::config::TaskKind;
use profile::{LOAD_PERIOD, LOAD_WINDOW, OVERLOAD_PERCENT, SYSTEM_WATCHDOG_OVERLOAD};
use signal::{Span, Time};

/// Ends of slots that are remembered: those of the longest overload that may last.
const SLOTS: usize = (SYSTEM_WATCHDOG_OVERLOAD.as_nanos() / LOAD_PERIOD.as_nanos()) as usize + 1;

/// Watches that some of the tasks do not take too much of the processor.
#[derive(Clone, Debug)]
pub(super) struct LoadWatch {
    /// 100 × processor time - 85 × time, since RUNNING was entered: it rises in an overload.
    excess: i128,
    /// Its least value since the overload before, and where it was the last time.
    least: i128,
    since: Time,
    /// The excess at the ends of the last slots, the newest at `newest`.
    ends: [i128; SLOTS],
    newest: usize,
    /// Slots of the window.
    window: usize,
    /// Up to here time is accounted for; the end of the slot under way.
    at: Time,
    slot: Time,
    /// The end of a slot at which the overload had lasted too long; [`Time::MAX`] for none.
    exceeded: Time,
}

impl LoadWatch {
    /// A watch that begins at `now` with a window for tasks of this longest interval.
    pub(super) fn new(now: Time, longest: Span) -> LoadWatch {
        let window = longest.max(LOAD_WINDOW).as_nanos();
        let slots = (window + LOAD_PERIOD.as_nanos() - 1) / LOAD_PERIOD.as_nanos();
        LoadWatch {
            excess: 0,
            least: 0,
            since: now,
            ends: [0; SLOTS],
            newest: 0,
            window: usize::try_from(slots).unwrap_or(SLOTS).min(SLOTS - 1),
            at: now,
            slot: now.saturating_add(LOAD_PERIOD),
            exceeded: Time::MAX,
        }
    }

    /// Time passes to `to`, in which the tasks have the processor or not.
    #[inline]
    pub(super) fn advance(&mut self, to: Time, busy: bool) {
        if busy && self.excess <= self.least {
            (self.least, self.since) = (self.excess, self.at);
        }
        while self.slot <= to {
            self.step(self.slot, busy);
            self.end_slot();
        }
        self.step(to, busy);
    }

    #[inline]
    fn step(&mut self, to: Time, busy: bool) {
        if to > self.at {
            let rate = if busy { 100 - OVERLOAD_PERCENT } else { -OVERLOAD_PERCENT };
            self.excess += i128::from((to - self.at).as_nanos()) * i128::from(rate);
            self.at = to;
        }
    }

    fn end_slot(&mut self) {
        self.newest = (self.newest + 1) % SLOTS;
        self.ends[self.newest] = self.excess;
        let window = Span::from_nanos(LOAD_PERIOD.as_nanos() * self.window as i64);
        let window_start = match self.at - self.since > window {
            true => self.ends[(self.newest + SLOTS - self.window) % SLOTS],
            false => self.least,
        };
        if self.excess <= window_start {
            (self.least, self.since) = (self.excess, self.at);
        }
        let exceeded = self.at - self.since > SYSTEM_WATCHDOG_OVERLOAD;
        self.exceeded = if exceeded { self.at } else { Time::MAX };
        self.slot = self.slot.saturating_add(LOAD_PERIOD);
    }

    /// The first end of a slot at which the overload has or will have lasted too long if it goes on.
    pub(super) fn due(&self) -> Time {
        if self.exceeded != Time::MAX {
            return self.exceeded;
        }
        let limit = self.since.saturating_add(SYSTEM_WATCHDOG_OVERLOAD);
        if limit < self.slot {
            return self.slot;
        }
        let slots = (limit - self.slot).as_nanos() / LOAD_PERIOD.as_nanos() + 1;
        self.slot.saturating_add(Span::from_nanos(slots * LOAD_PERIOD.as_nanos()))
    }

    /// Whether an overload has lasted too long by the end of a slot up to `now`.
    pub(super) fn exceeded(&self, now: Time) -> bool {
        self.exceeded <= now
    }
}

/// What had too much of the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Overload {
    /// All tasks together (controller:WD-01).
    Tasks,
    /// The freewheeling task and those above it: too little is left for system processing and the tasks below
    /// (controller:WD-05, controller:TASK-22).
    Freewheeling,
}

/// The length of the time over which the load of each task is shown.
const SECOND: Span = Span::from_secs(1);

/// The load of all tasks, and that of each of them as a figure.
#[derive(Clone, Debug)]
pub(super) struct Load {
    tasks: LoadWatch,
    /// Rank of the freewheeling task and the watch for it and those above it.
    freewheeling: Option<(usize, LoadWatch)>,
    at: Time,
    /// The end of the second under way.
    second: Time,
    /// A second ended since that was asked for.
    ended: bool,
}

impl Load {
    /// A load of nothing that begins at `now`, when RUNNING is entered.
    pub(super) fn new(now: Time, tasks: &[Task]) -> Load {
        let intervals = tasks.iter().filter_map(|task| task.interval);
        let longest = intervals.fold(Span::ZERO, Span::max);
        let freewheeling = tasks.iter().position(|task| matches!(task.kind, TaskKind::Freewheeling));
        Load {
            tasks: LoadWatch::new(now, longest),
            // Those of its own priority share its place.
            freewheeling: freewheeling.map(|rank| {
                let last = tasks.iter().rposition(|task| task.priority == tasks[rank].priority);
                (last.unwrap_or(rank), LoadWatch::new(now, longest))
            }),
            at: now,
            second: now.saturating_add(SECOND),
            ended: false,
        }
    }

    /// Time passes to `to`, in which the task of this rank has the processor, or none.
    #[inline]
    pub(super) fn advance(&mut self, to: Time, rank: Option<usize>, tasks: &mut [Task]) {
        if to <= self.at {
            return;
        }
        self.tasks.advance(to, rank.is_some());
        if let Some((last, watch)) = &mut self.freewheeling {
            watch.advance(to, rank.is_some_and(|rank| rank <= *last));
        }
        while self.second <= to {
            self.take(self.second, rank, tasks);
            for task in tasks.iter_mut() {
                task.figures.load = std::mem::take(&mut task.used);
            }
            self.second = self.second.saturating_add(SECOND);
            self.ended = true;
        }
        self.take(to, rank, tasks);
    }

    fn take(&mut self, to: Time, rank: Option<usize>, tasks: &mut [Task]) {
        if let Some(task) = rank.and_then(|rank| tasks.get_mut(rank)) {
            task.used = task.used + (to - self.at);
        }
        self.at = to;
    }

    /// The next instant at which there is something to look at, or the one that was not looked at yet.
    pub(super) fn due(&self) -> Time {
        if self.ended {
            return self.at;
        }
        let due = self.tasks.due().min(self.second);
        self.freewheeling.as_ref().map_or(due, |(_, watch)| due.min(watch.due()))
    }

    /// Whether a second ended since the last call.
    pub(super) fn take_second(&mut self) -> bool {
        std::mem::take(&mut self.ended)
    }

    /// What had too much of the processor for too long by `now`.
    pub(super) fn exceeded(&self, now: Time) -> Option<Overload> {
        if self.freewheeling.as_ref().is_some_and(|(_, watch)| watch.exceeded(now)) {
            return Some(Overload::Freewheeling);
        }
        self.tasks.exceeded(now).then_some(Overload::Tasks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ms(n: i64) -> Span {
        Span::from_millis(n)
    }

    /// When the watch trips, if ever, under pieces of time with and without load, in microseconds.
    fn trips(longest: Span, pieces: impl IntoIterator<Item = (i64, bool)>, slice: i64) -> Option<i64> {
        let mut watch = LoadWatch::new(Time::ZERO, longest);
        let mut now = 0;
        for (length, busy) in pieces {
            let end = now + length;
            while now < end {
                let due = (watch.due() - Time::ZERO).as_nanos() / 1_000;
                now = end.min(due).min(now + slice);
                let at = Time::from_nanos(now * 1_000);
                watch.advance(at, busy);
                if now == due && watch.exceeded(at) {
                    return Some(now);
                }
            }
        }
        None
    }

    /// Cycles of 20 ms with `busy` microseconds of load each.
    fn cycles(count: usize, busy: i64) -> impl Iterator<Item = (i64, bool)> {
        (0..count).flat_map(move |_| [(busy, true), (20_000 - busy, false)])
    }

    const WHOLE: i64 = i64::MAX / 2;

    // controller:WD-01, controller:WD-13
    #[test]
    fn trips_after_three_seconds_above_85_percent() {
        let mast = ms(20);
        assert_eq!(trips(mast, [(10_000_000, true)], WHOLE), Some(3_010_000));
        assert_eq!(trips(mast, cycles(500, 17_200), WHOLE), Some(3_010_000));
        assert_eq!(trips(mast, cycles(500, 17_001), WHOLE), Some(3_010_000));
        assert_eq!(trips(mast, cycles(3_000, 17_000), WHOLE), None);
        assert_eq!(trips(mast, cycles(3_000, 16_800), WHOLE), None);
        assert_eq!(trips(mast, cycles(145, 17_200).chain(cycles(3_000, 0)), WHOLE), None);
        assert_eq!(trips(mast, cycles(145, 20_000).chain(cycles(3_000, 16_800)), WHOLE), None);
        // 60 s at 84 %, 2.9 s at 86 %, and 84 % again: never. A little more than 3 s at 86 %: at once then.
        let base = || cycles(3_000, 16_800);
        assert_eq!(trips(mast, base().chain(cycles(145, 17_200)).chain(base()), WHOLE), None);
        assert_eq!(trips(mast, base().chain(cycles(151, 17_200)).chain(base()), WHOLE), Some(63_010_000));
        // Load that begins in the middle of a slot.
        let late = [(1_004_999, false), (5_000_000, true)];
        assert_eq!(trips(mast, late, WHOLE), Some(4_010_000));
        // A load that repeats every second is seen as a whole.
        let slow = || (0..20).flat_map(|_| [(860_000, true), (140_000, false)]);
        assert_eq!(trips(ms(1_000), slow(), WHOLE), Some(3_010_000));
        let less = (0..20).flat_map(|_| [(840_000, true), (160_000, false)]);
        assert_eq!(trips(ms(1_000), less, WHOLE), None);
    }

    proptest! {
        #[test]
        fn slices_never_show(pieces in proptest::collection::vec((1i64..40_000, any::<bool>()), 300..600), slice in 1i64..50_000) {
            let load = || pieces.iter().map(|(length, busy)| (if *busy { length * 6 } else { *length }, *busy));
            prop_assert_eq!(trips(ms(20), load(), slice), trips(ms(20), load(), WHOLE));
        }
    }
}
