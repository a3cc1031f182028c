//! Does a signal keep out of its forbidden values for a whole window?
//!
//! The signal's life is cut into segments: allowed, forbidden, unknown. Neighbouring forbidden segments are
//! one. The claim can break if some forbidden or unknown segment can meet the window; it can hold if the
//! window can be placed wholly between two forbidden segments. Because the intervals of one signal never run
//! backwards (see the orderer), both questions are answered exactly by looking at each segment once.

use signal::{Cause, Value};

use super::{TimedValue, Truth, UncertainWindow};

/// The segment that speaks most clearly against the claim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breach {
    /// Earliest and latest beginning, nanoseconds.
    pub start: (i64, i64),
    /// Earliest and latest end, nanoseconds; `i64::MAX` for one that lasts.
    pub end: (i64, i64),
    /// The value with which it began, or which it had come to when the window began.
    pub value: Value,
    /// Earliest and latest instant from which it had this value in the window, nanoseconds.
    pub value_start: (i64, i64),
    /// Earliest and latest end of that value, which another one of the segment may follow.
    pub value_end: (i64, i64),
    /// Who began it.
    pub cause: Cause,
    /// How clearly it speaks.
    pub weight: Weight,
}

/// How clearly a segment speaks against a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weight {
    /// Its value is not known, and it can lie in the window.
    Unknown,
    /// It is forbidden and can lie in the window.
    Possible,
    /// It is forbidden and lies in the window in every placement.
    Certain,
}

/// The judgement on one window.
#[derive(Clone, Debug)]
pub struct SegmentJudgement {
    window: UncertainWindow,
    class: Truth,
    since: TimedValue,
    /// The value that the segment is shown by: of those that it has in the window the first.
    shown: TimedValue,
    /// When that value gave way to another one of it.
    second: Option<(i64, i64)>,
    /// The earliest end of the last forbidden segment.
    free_from: i64,
    can_hold: bool,
    doomed: bool,
    worst: Option<Breach>,
    /// The least distance of a forbidden segment that keeps out of the window, nanoseconds.
    distance: Option<i64>,
}

impl SegmentJudgement {
    /// Nothing is known yet: the signal's value is unknown until its first event.
    pub fn new(window: UncertainWindow) -> Self {
        SegmentJudgement {
            window,
            class: Truth::Unknown,
            since: TimedValue::NOTHING,
            shown: TimedValue::NOTHING,
            second: None,
            free_from: i64::MIN,
            can_hold: false,
            doomed: false,
            worst: None,
            distance: None,
        }
    }

    /// The next event, and whether its value is allowed.
    #[inline]
    pub fn change(&mut self, class: Truth, seen: &TimedValue) {
        if class == self.class {
            if class == Truth::False && seen.b <= self.window.from.a {
                self.shown = *seen;
            } else if class == Truth::False && self.second.is_none() && seen.value != self.shown.value {
                self.second = Some((seen.a, seen.b));
            }
            return;
        }
        self.close((seen.a, seen.b));
        if class == Truth::False {
            self.can_hold |= self.window.fits(self.free_from, seen.b);
        }
        self.class = class;
        self.since = *seen;
        self.shown = *seen;
        self.second = None;
    }

    /// A forbidden or unknown segment with ends that depend on different signals, in the order of beginnings.
    pub fn segment(&mut self, class: Truth, start: &TimedValue, end: (i64, i64)) {
        self.change(class, start);
        let over = TimedValue { a: end.0, b: end.1, value: Value::Unknown, cause: Cause::Unknown, ..*start };
        self.change(Truth::True, &over);
    }

    /// A forbidden or unknown stretch that stands for itself: stretches may come in any order and overlap.
    /// It decides only where it meets the window in every placement.
    pub fn stray(&mut self, class: Truth, start: &TimedValue, end: (i64, i64)) {
        if !self.window.can_meet(start.a, end.1) {
            return;
        }
        let weight = match class {
            Truth::False if self.window.must_meet(start.b, end.0) => Weight::Certain,
            _ if matches!(start.value, Value::Unknown) => Weight::Unknown,
            _ => Weight::Possible,
        };
        self.doomed |= weight == Weight::Certain;
        if self.worst.is_none_or(|worst| weight > worst.weight) {
            let (value, cause, value_start) = (start.value, start.cause, self.inside((start.a, start.b)));
            let start = (start.a, start.b);
            self.worst = Some(Breach { start, end, value, value_start, value_end: end, cause, weight });
        }
    }

    /// Whether something forbidden that began at `start` at the latest and lasts at `now` decides.
    pub fn would_lose(&self, start: i64, now: i64) -> bool {
        self.window.must_meet(start, now)
    }

    /// An instant as far as it lies in the window: not before its beginning.
    pub fn inside(&self, at: (i64, i64)) -> (i64, i64) {
        (at.0.max(self.window.from.a), at.1.max(self.window.from.a))
    }

    fn close(&mut self, end: (i64, i64)) {
        if self.class == Truth::True {
            return;
        }
        let start = (self.since.a, self.since.b);
        if self.class == Truth::False {
            self.free_from = end.0;
        }
        if self.window.can_meet(start.0, end.1) {
            let weight = match self.class {
                Truth::False if self.window.must_meet(start.1, end.0) => Weight::Certain,
                Truth::False => Weight::Possible,
                _ => Weight::Unknown,
            };
            if self.worst.is_none_or(|worst| weight > worst.weight) {
                let (value, cause) = (self.shown.value, self.shown.cause);
                let value_start = self.inside((self.shown.a, self.shown.b));
                let value_end = self.second.unwrap_or(end);
                self.worst = Some(Breach { start, end, value, value_start, value_end, cause, weight });
            }
        } else if self.class == Truth::False {
            let before = self.window.from.a.saturating_sub(end.1);
            let after = start.0.saturating_sub(self.window.until.b);
            let apart = before.max(after).max(0);
            self.distance = Some(self.distance.map_or(apart, |least| least.min(apart)));
        }
    }

    /// Whether the claim is lost whatever comes, as far as is known at `now`: an open segment lasts at least
    /// until then.
    pub fn lost(&self, now: i64) -> bool {
        let open = self.class == Truth::False && self.window.must_meet(self.since.b, now);
        open || self.worst.is_some_and(|worst| worst.weight == Weight::Certain)
    }

    /// The window's end is still to come, at `now` or later.
    pub fn advance(&mut self, now: i64) {
        self.window.advance(now);
    }

    /// The judgement when nothing comes any more.
    pub fn finish(&mut self) -> SegmentResult {
        self.close((i64::MAX, i64::MAX));
        if self.class != Truth::False {
            self.can_hold |= self.window.fits(self.free_from, i64::MAX);
        }
        SegmentResult {
            can_hold: self.can_hold && !self.doomed,
            can_break: self.worst.is_some(),
            worst: self.worst,
            distance: self.distance,
        }
    }

    /// The window.
    pub fn window(&self) -> &UncertainWindow {
        &self.window
    }
}

/// Whether a signal kept out of its forbidden values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentResult {
    /// Some placement keeps it out.
    pub can_hold: bool,
    /// Some placement has it inside.
    pub can_break: bool,
    /// What speaks most clearly against it, the first of its kind.
    pub worst: Option<Breach>,
    /// The distance of the nearest forbidden segment that certainly keeps out of the window, nanoseconds.
    pub distance: Option<i64>,
}
