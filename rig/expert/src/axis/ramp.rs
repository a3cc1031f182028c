//! Stretches of a motion along which the velocity is steady or changes as one curve, in whole numbers.

/// One hertz in units of velocity.
pub const HERTZ: i64 = 1 << 40;

/// One pulse in units of position: a unit of velocity over a nanosecond.
pub const PULSE: i128 = HERTZ as i128 * 1_000_000_000;

/// How fast a velocity changes: by `velocity` units within `nanos`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RampRate {
    velocity: u64,
    nanos: u64,
}

impl RampRate {
    /// So many hertz a millisecond (io:STD-PTO-02).
    pub fn hertz_per_ms(hertz: u32) -> RampRate {
        RampRate { velocity: u64::from(hertz.max(1)) * HERTZ as u64, nanos: 1_000_000 }
    }

    /// From 0 to `velocity` hertz within so many milliseconds (io:STD-PTO-02).
    pub fn within_ms(velocity: u32, ms: u32) -> RampRate {
        RampRate { velocity: u64::from(velocity.max(1)) * HERTZ as u64, nanos: u64::from(ms) * 1_000_000 }
    }

    /// How long a change takes, in whole nanoseconds.
    pub fn time(self, change: i64) -> i64 {
        let time =
            (u128::from(change.unsigned_abs()) * u128::from(self.nanos)).div_ceil(u128::from(self.velocity));
        i64::try_from(time).unwrap_or(i64::MAX)
    }

    /// The velocity after one millisecond from 0: the first or last one where none is configured (io:STD-PTO-06).
    pub fn behind_one_ms(self) -> i64 {
        let velocity = u128::from(self.velocity) * 1_000_000 / u128::from(self.nanos.max(1));
        i64::try_from(velocity).unwrap_or(i64::MAX).max(1)
    }

    /// What is covered while the velocity goes from one value to another, in units of position. The shape of the curve
    /// does not matter, since every shape is as steep in one half as in the other (io:STD-PTO-07).
    pub fn distance(self, from: i64, to: i64) -> i128 {
        (i128::from(from) + i128::from(to)) * i128::from(self.time(to - from)) / 2
    }
}

/// How the velocity goes along a stretch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SegmentCurve {
    /// Steady.
    Even,
    /// Changes at a steady rate.
    Line,
    /// Changes ever faster: the first part of an S-curve.
    Rise,
    /// Changes ever slower: the last part of an S-curve.
    Fall,
}

/// A stretch.
#[derive(Clone, Copy, Debug)]
pub struct ProfileSegment {
    curve: SegmentCurve,
    /// When it begins, in nanoseconds from the beginning of the motion, and how long it lasts.
    pub start: i64,
    pub length: i64,
    /// The position at its beginning, and at its end.
    origin: i128,
    pub end: i128,
    /// The velocity at its beginning, and by how much it changes.
    from: i64,
    change: i64,
    /// 2^(64 + shift) / length, so that no division is needed to say which part of the stretch is over.
    reciprocal: u64,
    shift: u32,
}

impl ProfileSegment {
    pub const NONE: ProfileSegment = ProfileSegment {
        curve: SegmentCurve::Even,
        start: 0,
        length: 0,
        origin: 0,
        end: 0,
        from: 0,
        change: 0,
        reciprocal: 0,
        shift: 0,
    };

    pub fn new(
        curve: SegmentCurve,
        start: i64,
        length: i64,
        origin: i128,
        from: i64,
        change: i64,
    ) -> ProfileSegment {
        let (mut reciprocal, mut shift) = (0, 0);
        if curve != SegmentCurve::Even && length > 0 {
            shift = length.ilog2();
            // Below 2^64 since 2^shift <= length.
            reciprocal = (((1_u128 << (64 + shift)) - 1) / length as u128) as u64;
        }
        let mut it = ProfileSegment { curve, start, length, origin, end: 0, from, change, reciprocal, shift };
        it.end = it.position(length);
        it
    }

    /// The part of the stretch that is over `t` nanoseconds after its beginning, in 2^-64.
    #[inline]
    fn part(&self, t: i64) -> u64 {
        ((t as u128 * u128::from(self.reciprocal)) >> self.shift) as u64
    }

    /// The velocity `t` nanoseconds after its beginning.
    #[inline]
    pub fn velocity(&self, t: i64) -> i64 {
        let part = match self.curve {
            SegmentCurve::Even => return self.from,
            SegmentCurve::Line => self.part(t),
            SegmentCurve::Rise => {
                let u = self.part(t);
                times(u, u)
            }
            SegmentCurve::Fall => {
                let rest = u64::MAX - self.part(t);
                u64::MAX - times(rest, rest)
            }
        };
        self.from + ((i128::from(self.change) * i128::from(part)) >> 64) as i64
    }

    /// The position `t` nanoseconds after its beginning.
    #[inline]
    pub fn position(&self, t: i64) -> i128 {
        // The mean velocity up to here is `from` and this part of `change`.
        let part = match self.curve {
            SegmentCurve::Even => return self.origin + i128::from(self.from) * i128::from(t),
            SegmentCurve::Line => self.part(t) / 2,
            SegmentCurve::Rise => {
                let u = self.part(t);
                third(times(u, u))
            }
            SegmentCurve::Fall => {
                let u = self.part(t);
                u - third(times(u, u))
            }
        };
        // 24 of the bits after the point of a velocity are kept: times 2^37 ns, what is cut is nothing.
        let change = (i128::from(self.change) * i128::from(part)) >> 40;
        self.origin + i128::from(self.from) * i128::from(t) + ((change * i128::from(t)) >> 24)
    }

    /// Whether it gets faster (above 0), slower (below 0) or neither.
    pub fn trend(&self) -> i64 {
        self.change.signum()
    }

    /// The first nanosecond after its beginning at which the position is at least `target`, which it is at its end;
    /// the result does not depend on `guess`.
    #[inline]
    pub fn reach(&self, target: i128, guess: i64) -> i64 {
        if self.origin >= target {
            return 0;
        }
        // Newton's method between bounds: below `target` at `low`, not below it at `high`.
        let (mut low, mut high) = (0, self.length);
        let mut t = guess;
        let mut rounds = 0;
        while high - low > 1 {
            t = t.clamp(low + 1, high - 1);
            let gap = target - self.position(t);
            let velocity = self.velocity(t).max(1);
            if gap > 0 {
                low = t;
            } else {
                high = t;
            }
            rounds += 1;
            t = if rounds > NEWTON {
                low + (high - low) / 2
            } else if gap > 0 && gap <= velocity.into() {
                t + 1
            } else if gap <= 0 && gap > (-velocity).into() {
                // Likely the place: the nanosecond before decides.
                t - 1
            } else {
                t.saturating_add(over(gap, velocity))
            };
        }
        high
    }
}

/// Steps of Newton's method before bounds are simply halved.
const NEWTON: u32 = 48;

/// `gap` / `velocity`, rounded up.
#[inline]
fn over(gap: i128, velocity: i64) -> i64 {
    match i64::try_from(gap) {
        Ok(gap) => gap / velocity + i64::from(gap > 0 && gap % velocity != 0),
        Err(_) => {
            let velocity = i128::from(velocity);
            let time = gap / velocity + i128::from(gap > 0 && gap % velocity != 0);
            i64::try_from(time).unwrap_or(i64::MAX)
        }
    }
}

/// The product of two parts in 2^-64.
#[inline]
fn times(a: u64, b: u64) -> u64 {
    ((u128::from(a) * u128::from(b)) >> 64) as u64
}

/// A third of a part in 2^-64.
#[inline]
fn third(a: u64) -> u64 {
    times(a, 0x5555_5555_5555_5555)
}
