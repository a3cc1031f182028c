//! Whole cycles of a signal in a window: how many there are, how long they last together, how much of that the
//! signal is TRUE.
//!
//! A cycle lasts from one edge to the next of its kind. The cycles of a window lie between the first and the last
//! edge in it. Which edges these are depends on where an uncertain end of the window lies, so that a few may be:
//! each pair of them is a [`CycleSpan`]. With exact instants there is one pair.

use super::edges::{CountedEdge, EdgeFinder};
use super::{Extent, Number, TimedValue, UncertainWindow};

/// Most edges that may be the first one, or the last one, of a window. Beyond it the answer is left open.
const MOST: usize = 64;

/// Nanoseconds of a second.
const NANOS: i128 = 1_000_000_000;

/// An edge with all that lies before it.
#[derive(Clone, Copy, Debug)]
struct EdgeMark {
    /// Edges of its kind before it.
    number: u64,
    seen: TimedValue,
    /// Least and greatest time that the signal was TRUE from the first edge of all up to this one, nanoseconds.
    high: (i64, i64),
}

/// The cycles between two edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleSpan {
    /// How many.
    pub cycles: u64,
    /// Least and greatest length of all together, nanoseconds; the least may be 0 where edges are uncertain.
    pub length: (i64, i64),
    /// Least and greatest time of it in which the signal is TRUE, nanoseconds.
    pub high: (i64, i64),
}

impl CycleSpan {
    /// Least and greatest mean frequency, in hertz.
    pub(crate) fn rate(&self) -> Extent {
        let cycles = i128::from(self.cycles) * NANOS;
        let rate = |length: i64| Number::quotient(cycles, u64::try_from(length).unwrap_or(0));
        (rate(self.length.1), rate(self.length.0))
    }

    /// Least and greatest mean length of a cycle, in nanoseconds.
    pub(crate) fn period(&self) -> Extent {
        let mean = |length: i64| Number::quotient(i128::from(length.max(0)), self.cycles);
        (mean(self.length.0), mean(self.length.1))
    }

    /// Least and greatest part of the time in which the signal is TRUE, in per cent.
    pub(crate) fn duty(&self) -> Extent {
        let whole = Number::Int(100);
        let part = |high: i64, length: i64| match u64::try_from(length) {
            Ok(length @ 1..) => Number::quotient(i128::from(high.max(0)) * 100, length).least(whole),
            _ => whole,
        };
        let least = if self.length.1 > 0 { part(self.high.0, self.length.1) } else { Number::ZERO };
        (least, part(self.high.1, self.length.0))
    }
}

/// What lies in a window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CycleResult {
    /// Every pair of a first and a last edge that some placement has, in order.
    pub stretches: Vec<CycleSpan>,
    /// Some placement has fewer than two edges in the window.
    pub can_be_missing: bool,
    /// More edges may be hidden where nothing is known, or there were too many to look at each.
    pub doubtful: bool,
    /// The last edge of the window.
    pub last: Option<TimedValue>,
}

/// Follows the edges of one kind.
#[derive(Clone, Debug)]
pub struct Cycles {
    window: UncertainWindow,
    rises: EdgeFinder,
    falls: EdgeFinder,
    /// Edges that begin a cycle are falling ones.
    by_falls: bool,
    number: u64,
    high: (i64, i64),
    /// Since when the signal is TRUE.
    high_since: Option<(i64, i64)>,
    /// The earliest placement of the window's beginning with all edges so far before it.
    left: i64,
    firsts: Vec<EdgeMark>,
    lasts: Vec<EdgeMark>,
    before: Option<EdgeMark>,
    doubtful: bool,
}

impl Cycles {
    /// Nothing seen yet; cycles begin with rising edges, or with falling ones.
    pub fn new(window: UncertainWindow, by_falls: bool, slack: f64) -> Cycles {
        Cycles {
            window,
            rises: EdgeFinder::new(CountedEdge::Rises, slack),
            falls: EdgeFinder::new(CountedEdge::Falls, slack),
            by_falls,
            number: 0,
            high: (0, 0),
            high_since: None,
            left: i64::MIN,
            firsts: Vec::new(),
            lasts: Vec::new(),
            before: None,
            doubtful: false,
        }
    }

    /// The next event.
    #[inline]
    pub fn see(&mut self, seen: &TimedValue) {
        let (rose, fell) = (self.rises.see(seen), self.falls.see(seen));
        if let Some(found) = rose.or(fell).filter(|found| !found.certain) {
            self.unknown(&found.seen);
            return;
        }
        // The time that ends here belongs to the cycles before this edge.
        if fell.is_some()
            && let Some(since) = self.high_since.take()
        {
            self.high.0 = self.high.0.saturating_add(seen.a.saturating_sub(since.1).max(0));
            self.high.1 = self.high.1.saturating_add(seen.b.saturating_sub(since.0));
        }
        if rose.is_some() {
            self.high_since = Some((seen.a, seen.b));
        }
        if if self.by_falls { fell.is_some() } else { rose.is_some() } {
            self.edge(seen);
        }
    }

    fn edge(&mut self, seen: &TimedValue) {
        let mark = EdgeMark { number: self.number, seen: *seen, high: self.high };
        self.number += 1;
        let low = self.window.from.a.max(self.left);
        if low <= self.window.from.b.min(seen.after(&self.window.from)) {
            self.keep(mark, true);
        }
        self.left = self.left.max(seen.before(&self.window.from));
        self.end_before(seen.after(&self.window.until));
        self.before = Some(mark);
    }

    /// The edge before this instant is the last one of those windows that end up to then.
    fn end_before(&mut self, right: i64) {
        let Some(mark) = self.before else { return };
        let low = mark.seen.before(&self.window.until).max(self.window.until.a);
        if low <= self.window.until.b.min(right) {
            self.keep(mark, false);
        }
    }

    fn keep(&mut self, mark: EdgeMark, first: bool) {
        let list = if first { &mut self.firsts } else { &mut self.lasts };
        if list.len() < MOST {
            list.push(mark);
        } else {
            self.doubtful = true;
        }
    }

    fn unknown(&mut self, seen: &TimedValue) {
        self.doubtful |= self.window.can_hold(seen);
        self.high_since = None;
    }

    /// What lies in the window when nothing comes any more.
    pub fn finish(mut self) -> CycleResult {
        if let Some(rest) = self.rises.rest() {
            self.unknown(&rest.seen);
        }
        self.end_before(i64::MAX);
        let none_behind = self.window.from.a.max(self.left) <= self.window.from.b;
        let mut found = CycleResult {
            can_be_missing: none_behind || self.firsts.is_empty() || self.lasts.is_empty(),
            doubtful: self.doubtful,
            last: self.lasts.last().map(|mark| mark.seen),
            ..CycleResult::default()
        };
        for first in &self.firsts {
            for last in &self.lasts {
                if last.number <= first.number {
                    found.can_be_missing = true;
                    continue;
                }
                found.stretches.push(CycleSpan {
                    cycles: last.number - first.number,
                    length: (
                        last.seen.a.saturating_sub(first.seen.b),
                        last.seen.b.saturating_sub(first.seen.a),
                    ),
                    high: (
                        last.high.0.saturating_sub(first.high.0),
                        last.high.1.saturating_sub(first.high.1),
                    ),
                });
            }
        }
        found
    }
}
