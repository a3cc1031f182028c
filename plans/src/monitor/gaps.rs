//! The longest time without an event, over a whole window.
//!
//! Events that lie in the window in every placement are judged together exactly: each has to come within the limit after
//! the one before, wherever that was placed. Those at an uncertain end of the window may be there or not, which can only
//! make a verdict inconclusive, never wrong.

use super::{TimedValue, UncertainWindow};

/// Follows the events of a window.
#[derive(Clone, Debug)]
pub struct Gaps {
    window: UncertainWindow,
    limit: i64,
    /// Placements of the last event, or of the window's beginning, that leave every gap before it within the limit.
    reach: (i64, i64),
    feasible: bool,
    can_break: bool,
    doubtful: bool,
    /// Some event may be in the window or not.
    uncertain: bool,
    /// The last event that is in the window for certain, or its beginning.
    last: (i64, i64),
    last_seen: Option<TimedValue>,
    longest: (i64, i64),
    after: Option<TimedValue>,
}

/// What the gaps came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapResult {
    /// Some placement has no longer gap than the limit.
    pub can_hold: bool,
    /// Some placement has one.
    pub can_break: bool,
    /// Events may be hidden where nothing is known.
    pub doubtful: bool,
    /// Least and greatest length of the longest gap, nanoseconds.
    pub longest: (i64, i64),
    /// The longest that is allowed, nanoseconds.
    pub limit: i64,
    /// The event in front of it; `None`: the beginning of the window.
    pub after: Option<TimedValue>,
}

impl Gaps {
    /// No event yet; `limit` in nanoseconds.
    pub fn new(window: UncertainWindow, limit: i64) -> Gaps {
        let from = (window.from.a, window.from.b);
        Gaps {
            window,
            limit,
            reach: from,
            feasible: true,
            can_break: false,
            doubtful: false,
            uncertain: false,
            last: from,
            last_seen: None,
            longest: (0, 0),
            after: None,
        }
    }

    /// The window's end is still to come, at `now` or later.
    pub fn advance(&mut self, now: i64) {
        self.window.advance(now);
    }

    /// The next event.
    pub fn frame(&mut self, seen: &TimedValue) {
        if !self.window.can_hold(seen) {
            return;
        }
        let farthest = seen.b.min(self.reach.1.saturating_add(self.limit));
        if !self.window.must_hold(seen) {
            self.uncertain = true;
            // It helps where it is there, and does no harm where it is not.
            if farthest >= seen.a {
                self.reach.1 = self.reach.1.max(farthest);
            }
            return;
        }
        self.reach = (self.reach.0.max(seen.a), farthest);
        self.feasible &= self.reach.0 <= self.reach.1;
        self.close((seen.a, seen.b));
        self.last = (seen.a.max(self.last.0), seen.b);
        self.last_seen = Some(*seen);
    }

    /// A stretch of which nothing is known, any number of events included.
    pub fn unknown(&mut self, seen: &TimedValue) {
        if self.window.can_hold(seen) {
            self.doubtful = true;
            if self.reach.1.saturating_add(self.limit) >= seen.a {
                self.reach.1 = self.reach.1.max(seen.b);
            }
        }
    }

    /// A gap ends in this interval.
    fn close(&mut self, end: (i64, i64)) {
        let gap = (end.0.saturating_sub(self.last.1).max(0), end.1.saturating_sub(self.last.0));
        self.can_break |= gap.1 > self.limit;
        if gap.1 > self.longest.1 {
            self.after = self.last_seen;
        }
        self.longest = (self.longest.0.max(gap.0), self.longest.1.max(gap.1));
    }

    /// Whether no placement can be right whatever comes.
    pub fn lost(&self) -> bool {
        !self.feasible
    }

    /// The judgement when nothing comes any more.
    pub fn finish(mut self) -> GapResult {
        let until = (self.window.until.a, self.window.until.b);
        // Both ends may depend on one instant: then the window has one length.
        let whole = self.window.link.filter(|_| self.last_seen.is_none());
        match whole {
            Some(length) => {
                let from = self.last.0;
                self.last = (from, from);
                self.close((from.saturating_add(length), from.saturating_add(length)));
                self.feasible &= self.doubtful || self.uncertain || length <= self.limit;
            }
            None => self.close(until),
        }
        let can_hold = self.feasible && until.0 <= self.reach.1.saturating_add(self.limit);
        GapResult {
            can_hold,
            can_break: self.can_break,
            doubtful: self.doubtful,
            longest: self.longest,
            limit: self.limit,
            after: self.after,
        }
    }
}
