//! Widths of pulses and distances of edges in a window.
//!
//! The first pulse is judged exactly. For all pulses of a window, the ones that lie in it in every placement
//! are judged together exactly (each must leave room for the next); those at an uncertain end of the window
//! are taken one by one, which can only make a verdict inconclusive, never wrong.

use super::{TimedValue, UncertainWindow};

/// A stretch at the wanted level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Its beginning.
    pub start: TimedValue,
    /// Earliest and latest end, nanoseconds.
    pub end: (i64, i64),
    /// `false` if it borders on a stretch of which nothing is known, or is one.
    pub certain: bool,
}

impl Pulse {
    /// Least and greatest width if it begins at `low` at the earliest and `high` at the latest.
    fn width(&self, low: i64, high: i64) -> (i64, i64) {
        (self.end.0.saturating_sub(high).max(0), self.end.1.saturating_sub(low))
    }
}

/// What widths or distances came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Some placement has all that is asked within the limits.
    pub can_hold: bool,
    /// Some placement has one outside the limits.
    pub can_break: bool,
    /// Some placement has nothing to measure in the window.
    pub can_be_missing: bool,
    /// Least and greatest width or distance of all placements, nanoseconds.
    pub extent: Option<(i64, i64)>,
    /// The one farthest outside the limits, or nearest to them.
    pub deciding: Option<DecidingFigure>,
    /// How many are in the window in every placement.
    pub count: u64,
    /// One may be hidden where nothing is known.
    pub doubtful: bool,
}

/// A width or distance that decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecidingFigure {
    /// The event at its end of interest: the beginning of the pulse, the later edge.
    pub seen: TimedValue,
    /// Least and greatest value, nanoseconds.
    pub extent: (i64, i64),
    /// Distance to the nearest limit in the worst placement, nanoseconds; negative outside. `None` where there is no limit.
    pub margin: Option<i64>,
}

impl Spread {
    fn note(&mut self, seen: &TimedValue, extent: (i64, i64), limits: (i64, i64)) {
        self.extent = Some(self.extent.map_or(extent, |old| (old.0.min(extent.0), old.1.max(extent.1))));
        let margin = super::span_margin(extent, limits);
        let nearness = |margin: Option<i64>| margin.unwrap_or(i64::MAX);
        if self.deciding.is_none_or(|old| nearness(margin) < nearness(old.margin)) {
            self.deciding = Some(DecidingFigure { seen: *seen, extent, margin });
        }
    }
}

/// Whether a figure can be within the limits, and whether it can be outside.
fn held(extent: (i64, i64), limits: (i64, i64)) -> (bool, bool) {
    (
        extent.0 <= limits.1 && extent.1 >= limits.0 && limits.0 <= limits.1,
        extent.0 < limits.0 || extent.1 > limits.1,
    )
}

/// The first pulse that begins in the window.
#[derive(Clone, Debug)]
pub struct FirstPulse {
    window: UncertainWindow,
    limits: (i64, i64),
    /// The earliest placement of the window's beginning with all certain pulses so far begun before it.
    left: i64,
    spread: Spread,
    done: bool,
}

impl FirstPulse {
    /// A pulse is wanted with a width within `limits`, both included.
    pub fn new(window: UncertainWindow, limits: (i64, i64)) -> Self {
        FirstPulse { window, limits, left: i64::MIN, spread: Spread::default(), done: false }
    }

    /// The next pulse, once its end is known.
    pub fn see(&mut self, pulse: &Pulse) {
        if self.done {
            return;
        }
        let (window, start) = (&self.window, &pulse.start);
        if pulse.certain {
            self.spread.can_be_missing |= window.fits(self.left, start.after(&window.until));
        }
        let low = window.from.a.max(self.left);
        let high = window.from.b.min(start.after(&window.from));
        // Placements of its beginning with the window's beginning in [low, high].
        let soonest = start.a.max(low.saturating_add(i64::from(start.place < window.from.place)));
        let until = window.link.map_or(window.until.b, |length| high.saturating_add(length));
        let latest = start.b.min(until.saturating_sub(i64::from(start.place >= window.until.place)));
        if low <= high && soonest <= latest {
            let extent = pulse.width(soonest, latest);
            let (can_hold, can_break) = held(extent, self.limits);
            self.spread.can_hold |= can_hold;
            self.spread.can_break |= can_break;
            if pulse.certain {
                self.spread.note(start, extent, self.limits);
                self.spread.count += 1;
            } else {
                self.spread.doubtful = true;
            }
        }
        if pulse.certain {
            self.left = self.left.max(start.before(&window.from));
            self.done = self.left > window.from.b || window.is_past(start);
        }
    }

    /// The judgement when no pulse comes any more.
    pub fn finish(mut self) -> Spread {
        self.spread.can_be_missing |= !self.done && self.window.fits(self.left, i64::MAX);
        self.spread
    }
}

/// A chain of figures that all must be within the limits: the widths of all pulses that begin in the window,
/// or the distances of successive edges in it.
#[derive(Clone, Debug)]
pub struct FigureChain {
    window: UncertainWindow,
    limits: (i64, i64),
    spread: Spread,
    /// The chain so far can be placed within the limits.
    feasible: bool,
    /// Placements of the last event of the chain that leave all before it within the limits.
    last: Option<(i64, i64)>,
    /// The last edge, for distances.
    edge: Option<TimedValue>,
    possible: bool,
}

impl FigureChain {
    /// Nothing in it yet.
    pub fn new(window: UncertainWindow, limits: (i64, i64)) -> Self {
        FigureChain {
            window,
            limits,
            spread: Spread::default(),
            feasible: true,
            last: None,
            edge: None,
            possible: false,
        }
    }

    /// The window's end is still to come, at `now` or later.
    pub fn advance(&mut self, now: i64) {
        self.window.advance(now);
    }

    /// The next pulse, once its end is known.
    pub fn pulse(&mut self, pulse: &Pulse) {
        if !self.window.can_hold(&pulse.start) {
            return;
        }
        let extent = pulse.width(pulse.start.a, pulse.start.b);
        let (can_hold, can_break) = held(extent, self.limits);
        self.spread.can_break |= can_break;
        self.possible |= can_hold;
        if !pulse.certain {
            self.spread.doubtful = true;
            return;
        }
        self.spread.note(&pulse.start, extent, self.limits);
        if !self.window.must_hold(&pulse.start) {
            return;
        }
        self.spread.count += 1;
        let low = pulse.start.a.max(self.last.map_or(i64::MIN, |last| last.0));
        let end = (
            pulse.end.0.max(low.saturating_add(self.limits.0)),
            pulse.end.1.min(pulse.start.b.saturating_add(self.limits.1)),
        );
        self.feasible &= low <= pulse.start.b && end.0 <= end.1;
        self.last = Some(end);
    }

    /// The next edge.
    pub fn edge(&mut self, seen: &TimedValue) {
        if !self.window.can_hold(seen) {
            return;
        }
        let inside = self.window.must_hold(seen);
        if let Some(before) = self.edge.replace(*seen) {
            let extent = (seen.a.saturating_sub(before.b).max(0), seen.b.saturating_sub(before.a));
            let (can_hold, can_break) = held(extent, self.limits);
            self.spread.can_break |= can_break;
            self.possible |= can_hold;
            self.spread.note(seen, extent, self.limits);
        }
        if !inside {
            return;
        }
        let reach = match self.last {
            Some(last) => {
                self.spread.count += 1;
                let low = seen.a.max(last.0.saturating_add(self.limits.0));
                (low, seen.b.min(last.1.saturating_add(self.limits.1)))
            }
            None => (seen.a, seen.b),
        };
        self.feasible &= reach.0 <= reach.1;
        self.last = Some(reach);
    }

    /// A stretch of which nothing is known, which may hold anything.
    pub fn unknown(&mut self, seen: &TimedValue) {
        if self.window.can_hold(seen) {
            self.spread.doubtful = true;
            self.spread.can_break = true;
            self.possible = true;
            // What is after it has no known distance from what was before it.
            self.last = None;
            self.edge = None;
        }
    }

    /// Whether no placement can be right whatever comes.
    pub fn lost(&self) -> bool {
        !self.feasible
    }

    /// The judgement when nothing comes any more.
    pub fn finish(mut self) -> Spread {
        let some = self.spread.count > 0;
        self.spread.can_be_missing = !some;
        self.spread.can_hold = self.feasible && (some || self.possible);
        self.spread
    }
}
