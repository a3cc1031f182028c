//! How many edges lie in a window?
//!
//! A placement of the window's beginning decides how many edges come before it, and so does one of its end.
//! The placements with exactly `n` edges before them are an interval: kept for every `n` that is possible at
//! all, which are few, because only edges near an uncertain end of the window are in doubt.

use super::{TimedValue, UncertainInstant, UncertainWindow};

/// Most edges in doubt at one end of a window. Beyond it only bounds of the count are kept, so that a verdict
/// can become inconclusive by it but never wrong.
const MOST: usize = 512;

/// Number of rising and of falling edges.
pub type EdgeCounts = (u64, u64);

/// A way to place one end of the window.
#[derive(Clone, Copy, Debug)]
struct Cut {
    /// Edges before it.
    before: EdgeCounts,
    /// Placements of the end, both included.
    low: i64,
    high: i64,
    /// Places in the trace of the last edge before it and the first one after it.
    last: u64,
    next: u64,
}

/// All ways to place one end of the window.
#[derive(Clone, Debug)]
struct End {
    point: UncertainInstant,
    cuts: Vec<Cut>,
    /// The earliest placement with all edges so far before it.
    left: i64,
    last: u64,
    overflow: bool,
}

impl End {
    fn new(point: UncertainInstant) -> Self {
        End { point, cuts: Vec::new(), left: i64::MIN, last: 0, overflow: false }
    }

    /// All edges so far are before the end and the one whose placement `right` bounds is not.
    fn cut(&mut self, before: EdgeCounts, right: i64, next: u64) {
        let (low, high) = (self.point.a.max(self.left), self.point.b.min(right));
        if low > high {
            return;
        }
        let cut = Cut { before, low, high, last: self.last, next };
        if self.cuts.len() >= MOST {
            // The last one stands for all that were left out: bounds of the count need only the outermost.
            self.overflow = true;
            self.cuts.pop();
        }
        self.cuts.push(cut);
    }

    fn see(&mut self, before: EdgeCounts, seen: &TimedValue) {
        self.cut(before, seen.after(&self.point), seen.place);
        self.left = self.left.max(seen.before(&self.point));
        self.last = seen.place;
    }

    fn is_past(&self) -> bool {
        self.left > self.point.b
    }
}

/// The counter of one window.
#[derive(Clone, Debug)]
pub struct EdgeCounter {
    window: UncertainWindow,
    from: End,
    until: End,
    total: EdgeCounts,
    certain: EdgeCounts,
    hidden: bool,
}

/// What was counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CountResult {
    /// Every pair of rising and falling edges that some placement has, in order; only the outermost if
    /// there are too many.
    pub counts: Vec<EdgeCounts>,
    /// `false` if `counts` gives bounds only.
    pub exact: bool,
    /// More edges may be hidden where nothing is known.
    pub hidden: bool,
}

impl EdgeCounter {
    /// Nothing counted yet.
    pub fn new(window: UncertainWindow) -> Self {
        EdgeCounter {
            window,
            from: End::new(window.from),
            until: End::new(window.until),
            total: (0, 0),
            certain: (0, 0),
            hidden: false,
        }
    }

    /// The window's end is still to come, at `now` or later.
    pub fn advance(&mut self, now: i64) {
        self.window.advance(now);
    }

    /// The next edge.
    #[inline]
    pub fn edge(&mut self, rising: bool, seen: &TimedValue) {
        if self.until.is_past() {
            return;
        }
        self.from.see(self.total, seen);
        self.until.see(self.total, seen);
        let counter = if rising { &mut self.total.0 } else { &mut self.total.1 };
        *counter += 1;
        if self.window.must_hold(seen) {
            let counter = if rising { &mut self.certain.0 } else { &mut self.certain.1 };
            *counter += 1;
        }
    }

    /// A stretch of which nothing is known, any number of edges included.
    pub fn unknown(&mut self, seen: &TimedValue) {
        self.hidden |= self.window.can_hold(seen);
    }

    /// The edges so far that lie in the window in every placement.
    pub fn certain(&self) -> EdgeCounts {
        self.certain
    }

    /// The count when no edge comes any more.
    pub fn finish(mut self) -> CountResult {
        self.from.cut(self.total, i64::MAX, u64::MAX);
        self.until.cut(self.total, i64::MAX, u64::MAX);
        let exact = !self.from.overflow && !self.until.overflow;
        let mut counts = Vec::new();
        for until in &self.until.cuts {
            for from in &self.from.cuts {
                if from.before.0 > until.before.0 || from.before.1 > until.before.1 {
                    break;
                }
                if self.together(from, until) {
                    counts.push((until.before.0 - from.before.0, until.before.1 - from.before.1));
                }
            }
            counts.sort_unstable();
            counts.dedup();
        }
        if !exact {
            counts.extend(self.bounds().into_iter().flatten());
            counts.sort_unstable();
        }
        CountResult { counts, exact, hidden: self.hidden }
    }

    /// The least and the greatest count, each end of the window placed for itself.
    fn bounds(&self) -> Option<[EdgeCounts; 2]> {
        let (from, until) = (&self.from.cuts, &self.until.cuts);
        let (first, last) = (from.first()?.before, from.last()?.before);
        let (least, most) = (until.first()?.before, until.last()?.before);
        let less = |a: EdgeCounts, b: EdgeCounts| (a.0.saturating_sub(b.0), a.1.saturating_sub(b.1));
        Some([less(least, last), less(most, first)])
    }

    /// Whether both ends can be placed so at once.
    fn together(&self, from: &Cut, until: &Cut) -> bool {
        // With edges in between there must be room for them: an edge recorded before the beginning of the
        // window needs a later instant to be in it, one recorded after its end an earlier one.
        let room = if from.before == until.before {
            0
        } else {
            i64::from(from.next < self.window.from.place) + i64::from(until.last >= self.window.until.place)
        };
        match self.window.link {
            Some(length) => {
                let low = from.low.max(until.low.saturating_sub(length));
                low <= from.high.min(until.high.saturating_sub(length)) && length >= room
            }
            None => from.low.saturating_add(room) <= until.high,
        }
    }
}
