//! Jitter: how far edges come off an even grid, or how much the lengths of periods differ.
//!
//! Three figures of the field, from the same edges. *Of edges, span*: the width of the narrowest band around an even
//! grid that holds every edge. *Of edges, rms*: the root of the mean square of their distances from the grid that makes
//! it least. *Of periods*: the longest less the shortest, or the standard deviation. A grid of a given period can only
//! be shifted, and the rms of periods is then that of their distances from the given one.
//!
//! Each is a distance to the nearest of a family of grids. So an edge that is known to within `2w` changes the span by
//! at most that, and the rms of all by at most the rms of all `w`: which is how intervals are honoured. Sums are kept in
//! whole numbers, so that nothing is rounded off however long a train is; the figure of edges whose instants are exact is
//! exact, too, or lies between two floats.

use super::edges::{CountedEdge, EdgeFinder};
use super::hull::{HullCorner, HullSide, narrowest};
use super::means::root;
use super::{Number, TimedValue, UncertainWindow};

/// What is compared with the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JitterReference {
    /// The instants of edges.
    Edges,
    /// The lengths of periods.
    Periods,
}

/// The period of a given grid: `nanos / parts` nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Nanoseconds in so many periods.
    pub nanos: u64,
    /// How many.
    pub parts: u64,
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JitterQuery {
    /// Of what.
    pub compared: JitterReference,
    /// The root of the mean square, and not how far from the least to the greatest.
    pub rms: bool,
    /// The grid, where it is given.
    pub grid: Option<Grid>,
}

/// What it came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JitterResult {
    /// Least and greatest jitter of all placements, nanoseconds.
    pub extent: Option<(Number, Number)>,
    /// How many edges lie in the window in every placement, and how many may.
    pub edges: (u64, u64),
    /// Some placement has fewer than three edges in the window.
    pub can_be_missing: bool,
    /// More edges may be hidden where nothing is known, or there were too many to look at each.
    pub doubtful: bool,
    /// Against a given grid: how much a clock whose rate is off makes of it at most, as a time of which it is that part, nanoseconds.
    pub wanders_over: i64,
    /// Of a span: the edge that is latest, or ends the longest period, and the earliest or that of the shortest one.
    pub farthest: Option<(TimedValue, TimedValue)>,
}

/// How far a root that was made of floats may be off, as a part of it.
const ROUNDED: f64 = 1e-14;

/// Fewest edges that have a jitter: any two fit a grid.
const FEWEST: u64 = 3;

/// Sums over many points, for the line that leaves the least squares. All are of whole numbers; `None` once one did not fit.
#[derive(Clone, Copy, Debug)]
struct Sums {
    count: u64,
    n: i128,
    nn: i128,
    x: i128,
    xx: i128,
    nx: i128,
    /// Squares of the widths of intervals.
    ww: i128,
}

impl Sums {
    const NONE: Sums = Sums { count: 0, n: 0, nn: 0, x: 0, xx: 0, nx: 0, ww: 0 };

    fn add(&self, n: i64, x: i128, w: i128) -> Option<Sums> {
        let n = i128::from(n);
        Some(Sums {
            count: self.count + 1,
            n: self.n + n,
            nn: self.nn.checked_add(n * n)?,
            x: self.x.checked_add(x)?,
            xx: self.xx.checked_add(x.checked_mul(x)?)?,
            nx: self.nx.checked_add(x.checked_mul(n)?)?,
            ww: self.ww.checked_add(w.checked_mul(w)?)?,
        })
    }

    /// Sum of the squared distances from 0, from the mean, or from the best line, as a quotient.
    fn squares(&self, asked: &JitterQuery) -> Option<(i128, i128)> {
        let count = i128::from(self.count);
        let spread = |of: i128, sum: i128| count.checked_mul(of)?.checked_sub(sum.checked_mul(sum)?);
        match (asked.compared, asked.grid) {
            (JitterReference::Periods, Some(_)) => Some((self.xx, 1)),
            (JitterReference::Edges, None) => {
                let nn = spread(self.nn, self.n)?;
                if nn == 0 {
                    return Some((0, 1));
                }
                let nx = count.checked_mul(self.nx)?.checked_sub(self.n.checked_mul(self.x)?)?;
                let over = spread(self.xx, self.x)?.checked_mul(nn)?.checked_sub(nx.checked_mul(nx)?)?;
                Some((over, nn.checked_mul(count)?))
            }
            _ => Some((spread(self.xx, self.x)?, count)),
        }
    }

    /// The same of the best line as a float, where the quotient has no room.
    fn about_line(&self) -> Option<f64> {
        let count = i128::from(self.count);
        let xx = count.checked_mul(self.xx)?.checked_sub(self.x.checked_mul(self.x)?)?;
        let nn = count.checked_mul(self.nn)?.checked_sub(self.n.checked_mul(self.n)?)?;
        let nx = count.checked_mul(self.nx)?.checked_sub(self.n.checked_mul(self.x)?)?;
        if nn == 0 {
            return Some(0.0);
        }
        // Most of the slope is taken away in whole numbers: what is left is small, and floats are good enough for it.
        let slope = nx.div_euclid(nn);
        let rest = nx - slope * nn;
        let flat = xx.checked_sub(slope.checked_mul(nx.checked_add(rest)?)?)?;
        Some((flat as f64 - rest as f64 * (rest as f64 / nn as f64)).max(0.0) / count as f64)
    }

    /// The mean square of points that are known exactly, of which `parts` are a nanosecond; `None` where it has no room.
    fn exact_mean_square(&self, asked: &JitterQuery, parts: u64) -> Option<Number> {
        if self.ww != 0 {
            return None;
        }
        let (over, under) = self.squares(asked)?;
        // All were doubled.
        let scale =
            i128::from(parts).checked_mul(i128::from(parts))?.checked_mul(4 * i128::from(self.count))?;
        let under = under.checked_mul(scale)?;
        let divisor = common_divisor(over, under);
        Some(Number::quotient(over / divisor, u64::try_from(under / divisor).ok()?))
    }
}

/// Of two numbers that are not below 0, one of them above.
const fn common_divisor(mut a: i128, mut b: i128) -> i128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Points that lie in the window, in every placement or in some.
#[derive(Clone, Debug)]
enum Points {
    /// For the root of a mean square; `None` once a sum did not fit.
    Sums(Option<Sums>),
    /// For the span around a grid that can only be shifted, or of periods: greatest and least by their earliest ends, then
    /// by their latest ones.
    Ends([Option<(HullCorner, HullCorner)>; 2]),
    /// For the span around any grid: upper and lower side by earliest ends, then by latest ones.
    Hulls(Box<[(HullSide, HullSide); 2]>),
}

impl Points {
    fn new(asked: &JitterQuery) -> Points {
        let sides = || (HullSide::new(true), HullSide::new(false));
        match (asked.rms, asked.compared, asked.grid) {
            (true, ..) => Points::Sums(Some(Sums::NONE)),
            (false, JitterReference::Edges, None) => Points::Hulls(Box::new([sides(), sides()])),
            (false, ..) => Points::Ends([None; 2]),
        }
    }

    fn add(&mut self, n: i64, (low, high): (i128, i128), seen: &TimedValue) {
        let corners = [low, high].map(|x| HullCorner { n, x, seen: *seen });
        match self {
            // Twice the middle, and the whole width: whole numbers, all doubled.
            Points::Sums(sums) => *sums = sums.and_then(|sums| sums.add(n, low + high, high - low)),
            Points::Ends(ends) => {
                for (end, corner) in ends.iter_mut().zip(corners) {
                    let (most, least) = end.get_or_insert((corner, corner));
                    if corner.x > most.x {
                        *most = corner;
                    }
                    if corner.x < least.x {
                        *least = corner;
                    }
                }
            }
            Points::Hulls(hulls) => {
                for ((upper, lower), corner) in hulls.iter_mut().zip(corners) {
                    upper.add(corner);
                    lower.add(corner);
                }
            }
        }
    }

    /// How far apart the farthest two are at least (`sure`: each as near to the other as it can be), or at most.
    fn span(&self, sure: bool, parts: u64) -> Option<(Number, HullCorner, HullCorner)> {
        // The greatest by its earliest end and the least by its latest one are as near to one another as can be.
        let (top, bottom) = if sure { (0, 1) } else { (1, 0) };
        match self {
            Points::Ends(ends) => {
                let (most, least) = (ends[top]?.0, ends[bottom]?.1);
                Some((Number::quotient((most.x - least.x).max(0), parts), most, least))
            }
            Points::Hulls(hulls) => {
                let (upper, lower) = (&hulls[top].0, &hulls[bottom].1);
                let band = narrowest(upper, lower)?;
                let cut = !sure && (upper.is_full() || lower.is_full());
                let wide = if cut { f64::INFINITY } else { band.0.max(0.0) / parts as f64 };
                Some((Number::Real(wide), band.1, band.2))
            }
            Points::Sums(_) => None,
        }
    }

    /// The root of the sum of squares and that of the squared widths, with their number.
    fn roots(&self, asked: &JitterQuery) -> Option<(f64, f64, u64)> {
        let Points::Sums(Some(sums)) = self else { return None };
        let squares = match (sums.squares(asked), asked.compared, asked.grid) {
            (Some((over, under)), ..) => over as f64 / under as f64,
            (None, JitterReference::Edges, None) => sums.about_line()?,
            _ => return None,
        };
        // All were doubled.
        Some((libm::sqrt(squares) / 2.0, libm::sqrt(sums.ww as f64) / 2.0, sums.count))
    }
}

/// Follows the edges of one kind.
#[derive(Clone, Debug)]
pub struct Jitter {
    asked: JitterQuery,
    window: UncertainWindow,
    finder: EdgeFinder,
    first: Option<TimedValue>,
    last: Option<TimedValue>,
    /// The longest period, nanoseconds.
    longest: i64,
    /// Edges so far.
    number: i64,
    /// The grid that distances are taken from: the given one, or a rough one by the first period.
    grid: Option<Grid>,
    sure: Points,
    all: Points,
    /// How many lie in the window in every placement, and how many may.
    edges: (u64, u64),
    doubtful: bool,
}

impl Jitter {
    /// Nothing seen yet.
    pub fn new(asked: JitterQuery, edge: CountedEdge, window: UncertainWindow, slack: f64) -> Jitter {
        Jitter {
            asked,
            window,
            finder: EdgeFinder::new(edge, slack),
            first: None,
            last: None,
            longest: 0,
            number: 0,
            grid: asked.grid,
            sure: Points::new(&asked),
            all: Points::new(&asked),
            edges: (0, 0),
            doubtful: false,
        }
    }

    /// The next event.
    #[inline]
    pub fn see(&mut self, seen: &TimedValue) {
        match self.finder.see(seen) {
            Some(found) if found.certain => self.edge(seen),
            Some(found) => self.unknown(&found.seen),
            None => {}
        }
    }

    fn edge(&mut self, seen: &TimedValue) {
        if !self.window.can_hold(seen) {
            return;
        }
        let certain = self.window.must_hold(seen);
        self.edges = (self.edges.0 + u64::from(certain), self.edges.1 + 1);
        let first = *self.first.get_or_insert(*seen);
        let before = self.last.replace(*seen);
        if let (None, Some(before)) = (self.grid, before) {
            let nanos = (seen.a.saturating_sub(before.a)).midpoint(seen.b.saturating_sub(before.b));
            self.grid = Some(Grid { nanos: nanos.unsigned_abs(), parts: 1 });
        }
        // The first edge is where the grid is laid: its distance depends on no period.
        let grid = self.grid.unwrap_or(Grid { nanos: 0, parts: 1 });
        let away = |length: i64, periods: i64| {
            i128::from(length) * i128::from(grid.parts) - i128::from(periods) * i128::from(grid.nanos)
        };
        let (n, extent, certain) = match (self.asked.compared, before) {
            (JitterReference::Edges, _) => {
                let from = |at: i64| away(at.saturating_sub(first.a), self.number);
                (self.number, (from(seen.a), from(seen.b)), certain)
            }
            (JitterReference::Periods, Some(before)) => {
                self.longest = self.longest.max(seen.b.saturating_sub(before.a));
                let least = away(seen.a.saturating_sub(before.b), 1);
                let most = away(seen.b.saturating_sub(before.a), 1);
                (self.number, (least, most), certain && self.window.must_hold(&before))
            }
            (JitterReference::Periods, None) => {
                self.number += 1;
                return;
            }
        };
        self.number += 1;
        self.all.add(n, extent, seen);
        if certain {
            self.sure.add(n, extent, seen);
        }
    }

    fn unknown(&mut self, seen: &TimedValue) {
        self.doubtful |= self.window.can_hold(seen);
    }

    /// Each edge stands off the grid by a part of its time since the first one, each period by a part of itself. Numbers
    /// that lie within a range have a root mean square about their mean of at most half of it.
    fn wanders_over(&self) -> i64 {
        let edges = self.first.zip(self.last).map_or(0, |(first, last)| last.b.saturating_sub(first.a));
        match (self.asked.grid, self.asked.compared, self.asked.rms) {
            (None, ..) => 0,
            (_, JitterReference::Periods, _) => self.longest,
            (_, JitterReference::Edges, false) => edges,
            (_, JitterReference::Edges, true) => edges / 2 + edges % 2,
        }
    }

    /// What it came to when nothing comes any more.
    pub fn finish(mut self) -> JitterResult {
        if let Some(rest) = self.finder.rest() {
            self.unknown(&rest.seen);
        }
        let mut found = JitterResult {
            edges: self.edges,
            can_be_missing: self.edges.0 < FEWEST,
            doubtful: self.doubtful,
            wanders_over: self.wanders_over(),
            ..JitterResult::default()
        };
        if self.edges.1 < FEWEST {
            return found;
        }
        let parts = self.grid.map_or(1, |grid| grid.parts);
        if !self.asked.rms {
            let most = self.all.span(false, parts);
            let least = self.sure.span(true, parts).map_or(Number::ZERO, |band| band.0);
            found.farthest = most.map(|(_, above, below)| (above.seen, below.seen));
            found.extent = most.map(|(most, ..)| (least, most));
            return found;
        }
        if let (Points::Sums(Some(sums)), true) = (&self.all, self.edges.0 == self.edges.1)
            && let Some(square) = sums.exact_mean_square(&self.asked, parts)
        {
            found.extent = Some(root(square));
            return found;
        }
        let Some((all, wide, most)) = self.all.roots(&self.asked) else {
            found.doubtful = true;
            return found;
        };
        // More points have no smaller sum of squares, whichever grid suits them best.
        let (sure, narrow, least) = self.sure.roots(&self.asked).unwrap_or((0.0, 0.0, 0));
        // Each operation may be off by half of the distance to the next float; there are few of them.
        let low = (sure - narrow).max(0.0) / libm::sqrt(most as f64) / parts as f64 * (1.0 - ROUNDED);
        let high = (all + wide) / libm::sqrt(least.max(1) as f64) / parts as f64 * (1.0 + ROUNDED);
        found.extent = Some((Number::Real(low), Number::Real(high)));
        found
    }
}
