//! From what a count shows now and then, and what its device reported meanwhile, to a count that never wraps.

use std::collections::VecDeque;

use host::{CounterEvent, CounterEventKind, HostInstant};
use signal::Span;

use super::CounterSpec;

/// What a count showed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CounterReading {
    /// The instants between which it was read: the earlier one.
    pub before: HostInstant,
    /// The later one.
    pub after: HostInstant,
    /// The number.
    pub value: u64,
}

/// The ways that a count goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Up alone.
    Up,
    /// Down alone.
    Down,
    /// Both.
    Both,
}

/// What became known of a count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountStep {
    /// It came to be so after this instant.
    pub from: HostInstant,
    /// And not after this one.
    pub to: HostInstant,
    /// How far it has counted since the beginning.
    pub total: i64,
    /// Whether it may have counted more or less than this: it may have wrapped unseen, or moved faster than it can.
    pub doubtful: bool,
}

/// What was known last.
#[derive(Clone, Copy, Debug)]
struct Last {
    value: u64,
    total: i128,
    /// The earliest instant at which it can have been so.
    since: HostInstant,
    /// The latest one.
    until: HostInstant,
}

/// Follows one count.
///
/// By readings alone the count is taken to have moved by less than half its range between two of them, or by less than its
/// whole range where it goes one way. Where the device reports its wraps by events they decide: then a reading is held back
/// until the next one, since the event of a wrap that the reading saw comes after it.
#[derive(Debug)]
pub struct Follower {
    range: i128,
    way: Way,
    /// Counts a second that the file promises not to be exceeded.
    promised: Option<u64>,
    /// Whether the device reports wraps.
    reports_wraps: bool,
    /// The longest time between two readings in which nothing goes unseen.
    unseen: Span,
    /// Whether events are to come, and whether each count has one.
    events: bool,
    steps: bool,
    /// How long before its stamp a count may have happened.
    resolution: Span,
    turns: i128,
    /// What the count showed in the beginning, and when that was.
    first: u64,
    since: HostInstant,
    last: Option<Last>,
    /// The next wrap to be reported has been seen in a reading.
    foreseen: bool,
    held: Option<CounterReading>,
    waiting: VecDeque<CounterEvent>,
    /// The most events that wait for the next reading.
    most: usize,
}

impl Follower {
    /// Follows the count of a counter with this ceiling. Readings are at most `apart` apart where none is late, and events
    /// are stamped at most `resolution` late.
    pub fn new(spec: &CounterSpec, ceiling: u64, apart: Span, resolution: Span) -> Follower {
        let range = i128::from(ceiling) + 1;
        let reports_wraps = spec.reports_wraps();
        let wraps = if reports_wraps { Span::MAX } else { unseen(ceiling, spec.way(), spec.fastest()) };
        Follower {
            range,
            way: spec.way(),
            promised: spec.counts_hz,
            reports_wraps,
            unseen: wraps.min(apart),
            events: !spec.events.is_empty(),
            steps: spec.reports_steps(),
            resolution,
            turns: 0,
            first: 0,
            since: HostInstant::BOOT,
            last: None,
            foreseen: false,
            held: None,
            waiting: VecDeque::with_capacity(2 * spec.buffer as usize),
            most: spec.buffer as usize,
        }
    }

    /// Begins again, from what comes next.
    pub fn begin(&mut self) {
        (self.last, self.held) = (None, None);
        self.waiting.clear();
    }

    /// The instant from which it counts, once there is one.
    pub fn since(&self) -> Option<HostInstant> {
        self.last.as_ref().map(|_| self.since)
    }

    /// Takes a reading, and the events that were there after it. What becomes known goes to `tell`, in order.
    pub fn take(
        &mut self,
        reading: CounterReading,
        events: &[CounterEvent],
        tell: &mut impl FnMut(CountStep),
    ) {
        if self.last.is_none() {
            self.start(reading, events);
            return;
        }
        if !self.events {
            self.read(reading, tell);
            return;
        }
        self.waiting.extend(events);
        let Some(held) = self.held.replace(reading) else { return };
        while let Some(event) = self.waiting.front().copied() {
            // Stamps that lie ahead of the clock do not pile up.
            if event.stamp > held.before && self.waiting.len() <= self.most {
                break;
            }
            self.waiting.pop_front();
            self.event(event, tell);
        }
        self.read(held, tell);
    }

    /// Finds where to begin: at the first reading, but after a wrap that was reported meanwhile, since nobody knows whether that
    /// reading had seen it.
    fn start(&mut self, reading: CounterReading, events: &[CounterEvent]) {
        if !self.reports_wraps {
            self.held = self.events.then_some(reading);
            self.base(reading.value, reading.before);
            return;
        }
        self.waiting.extend(events);
        let Some(first) = self.held.replace(reading) else { return };
        self.waiting.retain(|event| event.stamp > first.before);
        let place = self.waiting.iter().rposition(|event| self.wrap(*event) != 0);
        match place.and_then(|place| self.waiting.drain(..=place).next_back()) {
            Some(wrap) => self.base(wrap.count, wrap.stamp),
            None => self.base(first.value, first.before),
        }
    }

    fn base(&mut self, value: u64, since: HostInstant) {
        (self.turns, self.first, self.foreseen, self.since) = (0, value, false, since);
        self.last = Some(Last { value, total: 0, since, until: since });
    }

    fn read(&mut self, reading: CounterReading, tell: &mut impl FnMut(CountStep)) {
        let Some(last) = self.last else { return };
        let total = self.total(last, reading.value);
        self.known(last.since.min(reading.after), reading.before, reading.after, reading.value, total, tell);
    }

    fn event(&mut self, event: CounterEvent, tell: &mut impl FnMut(CountStep)) {
        let Some(last) = self.last else { return };
        let total = match self.wrap(event) {
            0 => self.total(last, event.count),
            _ if std::mem::take(&mut self.foreseen) => self.by_turns(event.count),
            wrap => {
                self.turns += wrap;
                self.by_turns(event.count)
            }
        };
        let since = match self.steps {
            true => last.since.max(event.stamp - self.resolution),
            false => last.since,
        };
        self.known(since.min(event.stamp), event.stamp, event.stamp, event.count, total, tell);
    }

    /// What a wrap does to the turns; 0 for other events.
    fn wrap(&self, event: CounterEvent) -> i128 {
        match event.kind {
            CounterEventKind::Overflow => 1,
            CounterEventKind::Underflow => -1,
            CounterEventKind::OverflowUnderflow if i128::from(event.count) * 2 < self.range => 1,
            CounterEventKind::OverflowUnderflow => -1,
            _ => 0,
        }
    }

    fn by_turns(&self, value: u64) -> i128 {
        self.turns * self.range + i128::from(value) - i128::from(self.first)
    }

    /// How far a count has counted that shows this.
    fn total(&mut self, last: Last, value: u64) -> i128 {
        if !self.reports_wraps {
            return last.total + self.moved(last.value, value);
        }
        let plain = self.by_turns(value);
        let next = match self.foreseen {
            true => None,
            false => self.waiting.iter().map(|event| self.wrap(*event)).find(|wrap| *wrap != 0),
        };
        let Some(wrap) = next else { return plain };
        let beyond = plain + wrap * self.range;
        let (near, far) = (plain - last.total, beyond - last.total);
        let is_beyond = match self.way {
            Way::Up => near < 0,
            Way::Down => near > 0,
            Way::Both => far.abs() < near.abs(),
        };
        if !is_beyond {
            return plain;
        }
        self.turns += wrap;
        self.foreseen = true;
        beyond
    }

    /// The way from one number to another, which is the shorter one.
    fn moved(&self, from: u64, to: u64) -> i128 {
        let up = (i128::from(to) - i128::from(from)).rem_euclid(self.range);
        match self.way {
            Way::Down if up != 0 => up - self.range,
            Way::Both if up * 2 > self.range => up - self.range,
            _ => up,
        }
    }

    fn known(
        &mut self,
        from: HostInstant,
        since: HostInstant,
        to: HostInstant,
        value: u64,
        total: i128,
        tell: &mut impl FnMut(CountStep),
    ) {
        let Some(last) = self.last else { return };
        // An event that is stamped while a reading was made is reported after it: no step ends before the one before it.
        let until = to.max(last.until);
        self.last = Some(Last { value, total, since, until });
        let apart = to - last.since;
        let too_far = |promised: u64| {
            // The nanosecond in which it began counts whole.
            (total - last.total).abs()
                > i128::from(promised) * i128::from(apart.as_nanos()) / 1_000_000_000 + 1
        };
        let doubtful = apart > self.unseen || self.promised.is_some_and(too_far);
        if total != last.total || doubtful {
            let limit = |total: i128| total.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64;
            tell(CountStep { from, to: until, total: limit(total), doubtful });
        }
    }
}

/// The longest time in which a count with this ceiling cannot move so far that its way is not known any more.
pub(super) fn unseen(ceiling: u64, way: Way, fastest: u64) -> Span {
    let range = i128::from(ceiling) + 1;
    let certain = if way == Way::Both { (range - 1) / 2 } else { range - 1 };
    let nanos = certain * 1_000_000_000 / i128::from(fastest.max(1));
    Span::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX))
}
