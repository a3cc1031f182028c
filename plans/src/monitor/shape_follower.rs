//! How closely counts follow a frequency over time.
//!
//! The claim after the figure: there is a frequency that keeps to the shape, to within a tolerance, and that makes just
//! these counts, one for each whole turn of its phase. From one count to the next a phase goes exactly one turn on. So
//! under the upper border of the band there must be room for the counts that came, and under the lower one for no
//! more; between a stretch's counts and what no count cut off lies less than one turn. The figure is the least tolerance
//! with which that holds for every stretch, in the best and in the worst placement of all instants.

use super::shape::{BandBorder, FrequencyShape, ShapeBand};
use super::track::PositionChange;
use super::{TimedValue, UncertainInstant, UncertainWindow};

/// What a course is held against.
#[derive(Clone, Debug)]
pub struct ShapeLimits {
    /// The frequency over time, from the window's beginning on.
    pub shape: FrequencyShape,
    /// By how much its instants may be off, nanoseconds.
    pub within: i64,
    /// Shortest stretch that is judged, nanoseconds; from each count to the next if 0.
    pub over: i64,
    /// Counts have a direction.
    pub signed: bool,
    /// The position is read from time to time, so that it may be off by one.
    pub coarse: bool,
}

/// A stretch that decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecidingStretch {
    /// The count that begins it, or `None` for the window's beginning.
    pub from: Option<TimedValue>,
    /// The count that ends it, or `None` for the window's end.
    pub until: Option<TimedValue>,
    /// Its length and its beginning after that of the shape, nanoseconds.
    pub length: f64,
    /// See `length`.
    pub begins: f64,
    /// Counts in it, in their direction.
    pub counts: u64,
    /// They go backwards.
    pub backwards: bool,
    /// Too many of them came, and not too few.
    pub many: bool,
    /// How many there may be at most, or have to be at least, without any tolerance of the frequency.
    pub due: f64,
}

/// What it came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeResult {
    /// The least tolerance that is needed, hertz: in the best placement, and in the worst one.
    pub needed: (f64, f64),
    /// The stretches that need it.
    pub deciding: [Option<DecidingStretch>; 2],
    /// Counts of the window in every placement, and in some.
    pub counts: (u64, u64),
    /// More may be hidden where nothing is known.
    pub doubtful: bool,
}

/// What has to hold of a stretch.
#[derive(Clone, Copy, Debug)]
struct StretchDemand {
    ends: (Option<TimedValue>, Option<TimedValue>),
    extent: (f64, f64),
    border: BandBorder,
    backwards: bool,
    /// At most so many pulses are due, or at least so many have room.
    limit: f64,
    /// Counts that came.
    counts: u64,
}

const BEST: usize = 0;
const WORST: usize = 1;

/// Most steps towards a tolerance.
const STEPS: usize = 64;

/// Counts since the one that began a stretch.
#[derive(Clone, Copy, Debug)]
struct CountStretch {
    begin: TimedValue,
    up: DirectionCounts,
    down: DirectionCounts,
    /// What began it may have come before or after another count.
    tangled: bool,
    /// It is long enough, but what would have ended it may have come before or after another count.
    overdue: bool,
}

/// Counts of one direction in a stretch.
#[derive(Clone, Copy, Debug)]
struct DirectionCounts {
    least: u64,
    most: u64,
    /// All counts, the beginning one among them, certainly (or possibly) have this direction.
    pure: bool,
    perhaps: bool,
}

impl DirectionCounts {
    fn new(own: (u64, u64), other: (u64, u64), blurred: bool) -> DirectionCounts {
        let pure = own.0 > 0 && other.1 == 0 && !blurred;
        DirectionCounts { least: 0, most: 0, pure, perhaps: own.1 > 0 && other.0 == 0 }
    }

    fn add(&mut self, own: (u64, u64), other: (u64, u64), blurred: bool) {
        self.least += own.0;
        self.most += own.1;
        self.pure &= other.1 == 0 && !blurred;
        self.perhaps &= other.0 == 0;
    }
}

impl CountStretch {
    fn new(count: &PositionChange) -> CountStretch {
        CountStretch {
            begin: count.seen,
            up: DirectionCounts::new(count.up, count.down, count.blurred),
            down: DirectionCounts::new(count.down, count.up, count.blurred),
            tangled: count.blurred,
            overdue: false,
        }
    }

    /// The stretch that begins with a count, or with the one before where it is not known which of them came later.
    fn after(count: &PositionChange, before: Option<&CountStretch>) -> CountStretch {
        let mut stretch = CountStretch::new(count);
        if let Some(before) = before.filter(|before| before.begin.b >= count.seen.a) {
            stretch.begin.b = stretch.begin.b.max(before.begin.b);
            for (own, other) in [(&mut stretch.up, &before.up), (&mut stretch.down, &before.down)] {
                own.pure &= other.pure;
                own.perhaps |= other.perhaps;
            }
        }
        stretch
    }

    fn add(&mut self, count: &PositionChange) {
        self.up.add(count.up, count.down, count.blurred);
        self.down.add(count.down, count.up, count.blurred);
    }
}

/// A count that ends a stretch, or in its place the one that may come before it: of either direction, then.
fn either(count: &PositionChange) -> PositionChange {
    match count.blurred {
        true => {
            let most = (0, count.up.1.max(count.down.1));
            PositionChange { up: most, down: most, ..*count }
        }
        false => *count,
    }
}

/// The last count of a direction, or one that may be.
#[derive(Clone, Copy, Debug)]
struct LastCount {
    begin: TimedValue,
    /// The earliest end of those that certainly came after it.
    after: Option<TimedValue>,
}

impl LastCount {
    /// Follows the last count of a direction; and gives it where this one may be the next of all, and of its direction.
    fn next(last: &mut Option<LastCount>, own: (u64, u64), seen: &TimedValue) -> Option<TimedValue> {
        let before = |one: &TimedValue, other: &TimedValue| {
            one.b < other.a || one.b == other.a && one.place < other.place
        };
        if own.1 > 0 {
            let old = last.replace(LastCount { begin: *seen, after: None })?;
            return old.after.is_none_or(|after| !before(&after, seen)).then_some(old.begin);
        }
        if let Some(last) = last.as_mut().filter(|last| before(&last.begin, seen)) {
            last.after = Some(match last.after {
                Some(after) if (after.b, after.place) <= (seen.b, seen.place) => after,
                _ => *seen,
            });
        }
        None
    }
}

/// Follows the counts.
#[derive(Clone, Debug)]
pub struct ShapeFollower {
    held: ShapeLimits,
    window: UncertainWindow,
    origin: UncertainInstant,
    bands: [ShapeBand; 2],
    open: [Option<CountStretch>; 2],
    /// The stretch that the last count begins.
    last: Option<CountStretch>,
    /// The last counts up and down.
    lone: [Option<LastCount>; 2],
    /// The first count that may lie in the window, and the first that certainly does.
    first: [Option<TimedValue>; 2],
    found: ShapeResult,
    /// Which count begins a longer stretch, or ends the last one, is not certain.
    ragged: bool,
}

impl ShapeFollower {
    /// Nothing seen yet. The shape begins at `origin`.
    pub fn new(held: ShapeLimits, origin: UncertainInstant, window: UncertainWindow) -> ShapeFollower {
        let spread = origin.b.saturating_sub(origin.a) as f64 / 2.0;
        let within = held.within as f64;
        let bands = [held.shape.band(within + spread), held.shape.band(within - spread)];
        let first = [None; 2];
        ShapeFollower {
            held,
            window,
            origin,
            bands,
            open: [None; 2],
            last: None,
            lone: [None; 2],
            first,
            found: ShapeResult::default(),
            ragged: false,
        }
    }

    /// Nanoseconds after the beginning of the shape, in the middle of where it may lie.
    fn nanos_after_beginning(&self, at: i64) -> f64 {
        let spread = self.origin.b.saturating_sub(self.origin.a);
        at.saturating_sub(self.origin.a) as f64 - spread as f64 / 2.0
    }

    /// The next count.
    pub fn see(&mut self, count: &PositionChange) {
        let seen = &count.seen;
        if !self.window.can_hold(seen) {
            return;
        }
        let certain = self.window.must_hold(seen);
        self.ragged |= !certain && self.held.over > 0;
        self.found.counts.1 += count.up.1.max(count.down.1);
        self.first[BEST].get_or_insert(*seen);
        if certain {
            self.found.counts.0 += count.up.0.max(count.down.0);
            self.first[WORST].get_or_insert(*seen);
        }
        let begun = CountStretch::after(count, self.last.as_ref());
        let tangled = self.held.over == 0 && (count.blurred || self.last.is_some_and(|last| last.tangled));
        self.last = Some(begun);
        self.see_lone(count, tangled);
        for side in [BEST, WORST] {
            // In the best case only what certainly lies in the window has to fit, in the worst one whatever may.
            if side == BEST && !certain {
                continue;
            }
            let Some(mut stretch) = self.open[side] else {
                self.open[side] = Some(begun);
                self.ragged |= count.blurred && self.held.over > 0;
                continue;
            };
            if self.held.over == 0 {
                stretch.add(&either(count));
                self.judge(side, &stretch, seen, tangled);
                stretch = begun;
            } else {
                stretch.add(count);
                // What lies in a stretch is certain only if its ends are.
                stretch.overdue |= seen.a.saturating_sub(stretch.begin.b) >= self.held.over;
                if stretch.overdue && !count.blurred {
                    self.judge(side, &stretch, seen, false);
                    stretch = begun;
                }
            }
            self.open[side] = Some(stretch);
        }
    }

    /// Between two counts of a direction of which one may be the next after the other there has to be room for a turn,
    /// whatever may have come between them instead.
    fn see_lone(&mut self, count: &PositionChange, tangled: bool) {
        for (way, own) in [count.up, count.down].into_iter().enumerate() {
            let begin = LastCount::next(&mut self.lone[way], own, &count.seen);
            let Some(begin) = begin.filter(|_| tangled && (way == 0 || self.held.signed)) else { continue };
            let demand = StretchDemand {
                ends: (Some(begin), Some(count.seen)),
                extent: (self.nanos_after_beginning(begin.b), self.nanos_after_beginning(count.seen.a)),
                border: BandBorder::Most,
                backwards: way > 0,
                limit: 1.0,
                counts: 1,
            };
            self.hold(WORST, &demand);
        }
    }

    /// A stretch of which nothing is known. One that cannot lie in the window leaves it as it is, its last stretch too.
    pub fn unknown(&mut self, seen: &TimedValue) {
        if self.window.can_hold(seen) {
            self.found.doubtful = true;
            (self.open, self.last, self.lone) = ([None; 2], None, [None; 2]);
        }
    }

    fn judge(&mut self, side: usize, stretch: &CountStretch, end: &TimedValue, tangled: bool) {
        let short = (self.nanos_after_beginning(stretch.begin.b), self.nanos_after_beginning(end.a));
        let long = (self.nanos_after_beginning(stretch.begin.a), self.nanos_after_beginning(end.b));
        let ends = (Some(stretch.begin), Some(*end));
        for (backwards, heap) in [(false, &stretch.up), (true, &stretch.down)] {
            if backwards && !self.held.signed {
                continue;
            }
            let coarse = u64::from(self.held.coarse);
            let DirectionCounts { least, most, pure, perhaps } = *heap;
            // What counts, and how many pulses may be due at most and must have room at least. Where all counts can be of
            // one direction they are as many as there can be, and not off by one.
            let ((came, due), (passed, room)) = match side {
                BEST if pure => ((most, most), (least, least)),
                BEST => ((most, most + 1), (least, least.saturating_sub(1))),
                _ if perhaps => ((most, most.min(least + 1)), (most, most)),
                _ => ((least, least + 1), (most, most.saturating_sub(1))),
            };
            let (inside, around) = if side == BEST { (short, long) } else { (long, short) };
            let demand = StretchDemand {
                ends,
                extent: inside,
                border: BandBorder::Least,
                backwards,
                limit: (due + coarse) as f64,
                counts: came,
            };
            self.hold(side, &demand);
            if room > coarse && !(side == WORST && tangled) {
                let limit = (room - coarse) as f64;
                let demand = StretchDemand {
                    extent: around,
                    border: BandBorder::Most,
                    limit,
                    counts: passed,
                    ..demand
                };
                self.hold(side, &demand);
            }
        }
    }

    /// A stretch in which nothing but these counts came, and less than one more.
    fn gap(
        &mut self,
        side: usize,
        ends: (Option<TimedValue>, Option<TimedValue>),
        extent: (f64, f64),
        counts: (u64, u64),
    ) {
        let loose = 1 + u64::from(self.held.coarse);
        for (backwards, counts) in [(false, counts.0), (true, counts.1)] {
            if !backwards || self.held.signed {
                let (border, limit) = (BandBorder::Least, (counts + loose) as f64);
                self.hold(side, &StretchDemand { ends, extent, border, backwards, limit, counts });
            }
        }
    }

    /// Raises the tolerance until no more pulses are due in a time than its limit, or until that many have room in it.
    fn hold(&mut self, side: usize, demand: &StretchDemand) {
        let needed = if side == BEST { &mut self.found.needed.0 } else { &mut self.found.needed.1 };
        let band = &self.bands[side];
        let StretchDemand { extent, border, backwards, limit, .. } = *demand;
        let many = border == BandBorder::Most;
        let wrong = |tolerance: f64| {
            let (pulses, slope) = band.pulses(border, backwards, tolerance, extent);
            (if many { limit - pulses } else { pulses - limit }, slope)
        };
        let (mut off, mut slope) = wrong(*needed);
        if off <= 0.0 {
            return;
        }
        let length = extent.1 - extent.0;
        let mut tolerance = *needed;
        // The area bends one way only, so that Newton's steps come down upon the answer.
        for _ in 0..STEPS {
            let next = match slope > 0.0 {
                true => tolerance + off / slope,
                false if many && length > 0.0 => self.held.shape.highest() + limit * 1e9 / length,
                false => f64::INFINITY,
            };
            let done = next == tolerance || !next.is_finite();
            tolerance = next;
            if done {
                break;
            }
            (off, slope) = wrong(tolerance);
        }
        *needed = needed.max(tolerance);
        let (due, _) = band.pulses(border, backwards, 0.0, extent);
        let (from, until) = demand.ends;
        let (begins, counts) = (extent.0, demand.counts);
        self.found.deciding[side] =
            Some(DecidingStretch { from, until, length, begins, counts, backwards, many, due });
    }

    /// What it came to when nothing comes any more.
    pub fn finish(mut self) -> ShapeResult {
        let (begin, end) = (self.window.from, self.window.until);
        for side in [BEST, WORST] {
            let (from, until) = match side {
                BEST => (begin.b, end.a),
                _ => (begin.a, end.b),
            };
            let (from, until) = (self.nanos_after_beginning(from), self.nanos_after_beginning(until));
            // What is not known may hold anything: nothing is due up to it.
            if self.found.doubtful {
                continue;
            }
            let first = self.first[side];
            let to_first = first
                .map_or(until, |seen| self.nanos_after_beginning(if side == BEST { seen.a } else { seen.b }));
            // What a number had counted when it was first read came before.
            if first.is_none() || !self.held.coarse {
                self.gap(side, (None, first), (from, to_first), (0, 0));
            }
            // In the best case what may lie in the window does, so the last stretch is that of the other side.
            let Some(stretch) = self.open[1 - side].or(self.open[side]) else { continue };
            let counts = match side {
                BEST => (stretch.up.most, stretch.down.most),
                _ => (stretch.up.least, stretch.down.least),
            };
            let last =
                self.nanos_after_beginning(if side == BEST { stretch.begin.b } else { stretch.begin.a });
            self.gap(side, (Some(stretch.begin), None), (last, until), counts);
        }
        self.ragged |= self.open.iter().flatten().any(|stretch| stretch.overdue);
        self.found.doubtful |= self.ragged;
        self.found
    }
}
