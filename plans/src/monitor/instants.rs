//! Instants with their intervals, and windows between two of them.
//!
//! All arithmetic is in integer nanoseconds and saturates. An event `e` with the interval `[a, b]` can be
//! placed before a point exactly when the point can be placed at or after [`TimedValue::before`]; it can be placed
//! at or after a point exactly when the point can be placed at or before [`TimedValue::after`]. At one and the same
//! instant the order of the trace decides.

use signal::{Cause, ClockError, Event, Span, Time, Value, When};

/// An event of one watched signal, in the order of the trace, with its interval tightened by its neighbours'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedValue {
    /// Not before this instant, nanoseconds.
    pub a: i64,
    /// Not after this instant, nanoseconds.
    pub b: i64,
    /// Place in the trace.
    pub place: u64,
    /// Place in the trace from which it can have happened: its own, or that of the beginning of a stretch of
    /// which nothing is known.
    pub since: u64,
    /// The value from then on.
    pub value: Value,
    /// Who did it.
    pub cause: Cause,
}

impl TimedValue {
    /// What is known of a signal before its first event: nothing.
    pub const NOTHING: TimedValue = TimedValue {
        a: i64::MIN,
        b: i64::MIN,
        place: 0,
        since: 0,
        value: Value::Unknown,
        cause: Cause::Unknown,
    };

    /// An event at a place of the trace, with the interval `[a, b]`.
    #[inline]
    pub(crate) fn of(event: &Event, a: i64, b: i64, place: u64) -> TimedValue {
        TimedValue { a, b, place, since: place, value: event.value, cause: event.cause }
    }

    /// The earliest placement of `point` that has this event before it.
    #[inline]
    pub fn before(&self, point: &UncertainInstant) -> i64 {
        if self.is(point) {
            return i64::MIN;
        }
        self.a.saturating_add(i64::from(self.since >= point.place))
    }

    /// The latest placement of `point` that has this event at or after it.
    #[inline]
    pub fn after(&self, point: &UncertainInstant) -> i64 {
        if self.is(point) {
            return i64::MIN;
        }
        self.b.saturating_sub(i64::from(self.place < point.place))
    }

    /// Whether the point is this very event, which then comes before it wherever both are placed.
    #[inline]
    fn is(&self, point: &UncertainInstant) -> bool {
        self.place.wrapping_add(1) == point.place && self.since == self.place
    }

    /// The interval as it is recorded.
    pub fn when(&self) -> When {
        When { earliest: Time::from_nanos(self.a), latest: Time::from_nanos(self.b) }
    }
}

/// The number of the event of a point that moves with no other.
pub(crate) const UNLINKED: u32 = u32::MAX;

/// An instant that a claim depends on: an event of the trace, or a distance from one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UncertainInstant {
    /// The earliest placement, nanoseconds.
    pub a: i64,
    /// The latest placement, nanoseconds.
    pub b: i64,
    /// Events at the very same instant come before the point if their place in the trace is below this.
    pub place: u64,
    /// Which event of the trace it depends on, so that two points on one event move together.
    pub base: u32,
    /// Its distance from that event, nanoseconds.
    pub offset: i64,
}

impl UncertainInstant {
    /// The point `offset` from an event of the trace at `at`, with number `base`, recorded at `place`.
    ///
    /// With no offset the order of the trace says what comes before it, the event itself included. With one,
    /// changes at the very instant count as coming at or after it.
    pub fn new(at: When, place: u64, base: u32, offset: Span) -> UncertainInstant {
        let offset = offset.as_nanos();
        UncertainInstant {
            a: at.earliest.as_nanos().saturating_add(offset),
            b: at.latest.as_nanos().saturating_add(offset),
            place: if offset == 0 { place + 1 } else { 0 },
            base,
            offset,
        }
    }

    /// The same where the clock that stamped the event may be off: the distance from it is true time. Two points on one event no
    /// longer have an exact distance then.
    #[must_use]
    pub fn by_clock(self, error: ClockError) -> UncertainInstant {
        let off = error.of_true(Span::from_nanos(self.offset)).as_nanos();
        if off == 0 {
            return self;
        }
        UncertainInstant {
            a: self.a.saturating_sub(off),
            b: self.b.saturating_add(off),
            base: UNLINKED,
            ..self
        }
    }

    /// The same instant for reading a value: with an offset, a change at the very instant has happened.
    pub fn for_reading(self) -> UncertainInstant {
        UncertainInstant { place: if self.offset == 0 { self.place } else { u64::MAX }, ..self }
    }

    /// The interval.
    pub fn when(&self) -> When {
        When { earliest: Time::from_nanos(self.a), latest: Time::from_nanos(self.b) }
    }

    /// The distance from `self` to `other` where both depend on one event.
    pub fn link(&self, other: &UncertainInstant) -> Option<i64> {
        (self.base == other.base && self.base != UNLINKED).then(|| other.offset.saturating_sub(self.offset))
    }
}

/// A window `[from, until)` whose ends may be uncertain. Only placements with `from <= until` count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UncertainWindow {
    /// Where it begins.
    pub from: UncertainInstant,
    /// Where it ends.
    pub until: UncertainInstant,
    /// Its length where both ends depend on one event.
    pub link: Option<i64>,
}

impl UncertainWindow {
    /// The window between two points, or `None` if it has no length in any placement.
    pub fn new(mut from: UncertainInstant, mut until: UncertainInstant) -> Option<UncertainWindow> {
        let link = from.link(&until);
        if link.is_none() {
            from.b = from.b.min(until.b);
            until.a = until.a.max(from.a);
        }
        let longest = link.unwrap_or_else(|| until.b.saturating_sub(from.a));
        (longest > 0).then_some(UncertainWindow { from, until, link })
    }

    /// The window's end is still to come: what is fed at `now` comes before it.
    pub fn advance(&mut self, now: i64) {
        self.until.a = self.until.a.max(now.min(self.until.b));
    }

    /// Whether the window can be placed with its beginning at or after `left` and its end at or before `right`.
    pub fn fits(&self, left: i64, right: i64) -> bool {
        let from = self.from.a.max(left);
        match self.link {
            Some(length) => from <= self.from.b.min(right.saturating_sub(length)),
            None => from <= self.from.b && self.until.a.max(from) <= self.until.b.min(right),
        }
    }

    /// Whether something that lasts from `start` at the earliest to `end` at the latest can lie in it.
    pub fn can_meet(&self, start: i64, end: i64) -> bool {
        let earliest = match self.link {
            Some(length) => self.from.a.max(start.saturating_sub(length).saturating_add(1)),
            None if start >= self.until.b => return false,
            None => self.from.a,
        };
        earliest <= self.from.b.min(end.saturating_sub(1))
    }

    /// Whether something that begins at `start` at the latest and ends at `end` at the earliest lies in it
    /// in every placement.
    pub fn must_meet(&self, start: i64, end: i64) -> bool {
        start < self.until.a && end > self.from.b
    }

    /// Whether an event can be placed in it.
    pub fn can_hold(&self, seen: &TimedValue) -> bool {
        let (latest_from, earliest_until) = (seen.after(&self.from), seen.before(&self.until));
        match self.link {
            Some(length) => {
                self.from.a.max(earliest_until.saturating_sub(length)) <= self.from.b.min(latest_from)
            }
            None => self.from.a <= latest_from && earliest_until <= self.until.b,
        }
    }

    /// Whether an event lies in it in every placement.
    pub fn must_hold(&self, seen: &TimedValue) -> bool {
        let latest = seen.b.saturating_add(i64::from(seen.place >= self.until.place));
        let earliest = seen.a.saturating_sub(i64::from(seen.place < self.from.place));
        !seen.is(&self.from) && earliest >= self.from.b && (latest <= self.until.a || seen.is(&self.until))
    }

    /// Whether an event comes after it in every placement, and all later ones with it.
    pub fn is_past(&self, seen: &TimedValue) -> bool {
        seen.before(&self.until) > self.until.b
    }
}
