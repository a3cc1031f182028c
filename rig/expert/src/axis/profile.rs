//! Velocity over time of one motion in one direction (io:STD-PTO-06, io:STD-PTO-07).

use super::ramp::{ProfileSegment, RampRate, SegmentCurve};

/// How velocities change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ramps {
    /// When it gets faster.
    pub rise: RampRate,
    /// When it gets slower.
    pub fall: RampRate,
    /// Part of a ramp that is curved, in percent; 0 for a trapezoid.
    pub jerk_ratio: u8,
}

impl Ramps {
    fn rate(&self, from: i64, to: i64) -> RampRate {
        if to > from { self.rise } else { self.fall }
    }

    fn distance(&self, from: i64, to: i64) -> i128 {
        self.rate(from, to).distance(from, to)
    }

    /// What is covered from one velocity down to the last one before 0.
    pub fn stopping(&self, from: i64, last: i64) -> i128 {
        self.distance(from, last.min(from))
    }
}

/// How a motion begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionBegin {
    /// From rest, with this velocity at most.
    Rest(i64),
    /// On the way, with this velocity.
    Moving(i64),
}

impl MotionBegin {
    /// The velocity with which a motion up to `peak` begins.
    fn velocity(self, peak: i64) -> i64 {
        match self {
            MotionBegin::Rest(first) => first.min(peak),
            MotionBegin::Moving(velocity) => velocity,
        }
    }
}

/// How a motion ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionEnd {
    /// At rest; this is the last velocity, if it was ever above it.
    Rest(i64),
    /// Goes on with this velocity.
    Moving(i64),
}

/// Ramp, steady velocity, ramp.
const MOST: usize = 7;

/// The profile of a motion: the position from its beginning on as a function of time.
#[derive(Clone, Debug)]
pub struct MotionProfile {
    stretches: [ProfileSegment; MOST],
    count: usize,
    /// The stretch that was looked at last: times are asked for in their order.
    current: usize,
}

impl MotionProfile {
    fn new() -> MotionProfile {
        MotionProfile { stretches: [ProfileSegment::NONE; MOST], count: 0, current: 0 }
    }

    /// Covers `distance` from position `origin`; it is long enough to end so.
    pub fn to(
        origin: i128,
        distance: i128,
        begin: MotionBegin,
        cruise: i64,
        end: MotionEnd,
        ramps: &Ramps,
    ) -> MotionProfile {
        let last = |peak: i64| match end {
            MotionEnd::Rest(last) => last.min(peak),
            MotionEnd::Moving(velocity) => velocity.min(peak),
        };
        let covered = |peak: i64| {
            let first = begin.velocity(peak);
            ramps.distance(first, peak) + ramps.distance(peak, last(peak))
        };
        let cruise = cruise.max(1);
        let fits = |peak| covered(peak) <= distance;
        let peak = match begin {
            MotionBegin::Rest(_) => largest(1, cruise, fits),
            MotionBegin::Moving(velocity) if velocity < cruise => largest(velocity, cruise, fits),
            MotionBegin::Moving(_) if fits(cruise) => cruise,
            // There is room for the way down to the last velocity, but not to one below it.
            MotionBegin::Moving(velocity) => last(velocity),
        };
        // A motion that goes on faster than it cruised gains speed at its end, as far as there is room.
        let last = match end {
            MotionEnd::Moving(velocity) if velocity > peak => {
                largest(peak, velocity, |last| covered(peak) + ramps.distance(peak, last) <= distance)
            }
            _ => last(peak),
        };
        let first = begin.velocity(peak);
        let mut profile = MotionProfile::new();
        profile.ramp(origin, first, peak, ramps);
        let left = distance - ramps.distance(first, peak) - ramps.distance(peak, last);
        let time = (left.max(0) / i128::from(peak)).min(i128::from(i64::MAX / 2)) as i64;
        profile.even(origin, peak, time);
        profile.ramp(origin, peak, last, ramps);
        profile
    }

    /// Goes to a velocity above 0 and keeps it.
    pub fn endless(origin: i128, begin: MotionBegin, cruise: i64, ramps: &Ramps) -> MotionProfile {
        let mut profile = MotionProfile::new();
        profile.ramp(origin, begin.velocity(cruise), cruise, ramps);
        profile.even(origin, cruise, i64::MAX - profile.length());
        profile
    }

    /// How long it lasts, in nanoseconds.
    pub fn length(&self) -> i64 {
        self.count.checked_sub(1).map_or(0, |last| {
            let last = &self.stretches[last];
            last.start + last.length
        })
    }

    fn push(&mut self, origin: i128, curve: SegmentCurve, length: i64, from: i64, change: i64) {
        if length > 0 {
            let origin = self.count.checked_sub(1).map_or(origin, |last| self.stretches[last].end);
            self.stretches[self.count] =
                ProfileSegment::new(curve, self.length(), length, origin, from, change);
            self.count += 1;
        }
    }

    fn even(&mut self, origin: i128, velocity: i64, length: i64) {
        self.push(origin, SegmentCurve::Even, length, velocity, 0);
    }

    fn ramp(&mut self, origin: i128, from: i64, to: i64, ramps: &Ramps) {
        let change = to - from;
        let time = ramps.rate(from, to).time(change);
        let curved = (i128::from(time) * i128::from(ramps.jerk_ratio) / 200) as i64;
        if curved == 0 {
            self.push(origin, SegmentCurve::Line, time, from, change);
            return;
        }
        // The steepest rate r holds for time - 2·curved and its half on average for the rest: change = r·(time - curved).
        let part = (i128::from(change) * i128::from(curved) / (2 * i128::from(time - curved))) as i64;
        self.push(origin, SegmentCurve::Rise, curved, from, part);
        self.push(origin, SegmentCurve::Line, time - 2 * curved, from + part, change - 2 * part);
        self.push(origin, SegmentCurve::Fall, curved, to - part, part);
    }

    /// The stretch at a time. Behind the end it is the last one.
    fn at(&self, time: i64) -> Option<&ProfileSegment> {
        let started = self.stretches[..self.count].iter().rposition(|stretch| stretch.start <= time);
        started.map(|place| &self.stretches[place])
    }

    /// The position at a time, held at its end.
    pub fn position(&self, time: i64) -> i128 {
        self.at(time).map_or(0, |stretch| stretch.position((time - stretch.start).min(stretch.length)))
    }

    /// The velocity at a time, held at its end.
    pub fn velocity(&self, time: i64) -> i64 {
        self.at(time).map_or(0, |stretch| stretch.velocity((time - stretch.start).min(stretch.length)))
    }

    /// Whether it gets faster (above 0), slower (below 0) or neither at a time.
    pub fn trend(&self, time: i64) -> i64 {
        self.at(time).map_or(0, ProfileSegment::trend)
    }

    /// When an endless motion has its velocity.
    pub fn steady(&self) -> i64 {
        self.count.checked_sub(1).map_or(0, |last| self.stretches[last].start)
    }

    /// The first nanosecond at which the position is at least `target`; the end where it never is. Targets come in
    /// their order. The result does not depend on `guess`.
    #[inline]
    pub fn reach(&mut self, target: i128, guess: i64) -> i64 {
        while self.current < self.count {
            let stretch = &self.stretches[self.current];
            if stretch.end >= target {
                return stretch.start + stretch.reach(target, guess - stretch.start);
            }
            self.current += 1;
        }
        self.length()
    }
}

/// The largest number between two that is good, where numbers below a good one are; the lower one where none is.
fn largest(mut low: i64, mut high: i64, good: impl Fn(i64) -> bool) -> i64 {
    if good(high) {
        return high;
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if good(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
