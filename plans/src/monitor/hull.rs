//! The straight line that comes nearest to many points, in the sense that the farthest of them is as near as can be.
//!
//! Only corners of the convex hull can be farthest from a line, whatever its slope, and a hull of very many points has
//! few corners: so the points themselves need not be kept.

use super::TimedValue;

/// Most corners of one side of a hull. Points of a grid of whole numbers have this many only where they bend all along.
const MOST: usize = 8_192;

/// A point: the number of an edge, and its distance from a rough grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HullCorner {
    pub(super) n: i64,
    pub(super) x: i128,
    pub(super) seen: TimedValue,
}

/// One side of a hull: its corners from left to right.
#[derive(Clone, Debug)]
pub(super) struct HullSide {
    upper: bool,
    corners: Vec<HullCorner>,
    full: bool,
}

impl HullSide {
    pub(super) fn new(upper: bool) -> HullSide {
        HullSide { upper, corners: Vec::new(), full: false }
    }

    /// The next point, farther right than all before.
    pub(super) fn add(&mut self, corner: HullCorner) {
        while let [.., before, last] = self.corners.as_slice() {
            let turn = (last.x - before.x) * i128::from(corner.n - before.n)
                - (corner.x - before.x) * i128::from(last.n - before.n);
            let stays = if self.upper { turn > 0 } else { turn < 0 };
            if stays {
                break;
            }
            self.corners.pop();
        }
        if self.corners.len() < MOST {
            self.corners.push(corner);
        } else {
            self.full = true;
        }
    }

    /// Points were left out.
    pub(super) fn is_full(&self) -> bool {
        self.full
    }

    /// The corner farthest above (of an upper side) or below a line of this slope, `rise / run`.
    fn farthest(&self, rise: i128, run: i64) -> Option<&HullCorner> {
        let height = |corner: &HullCorner| corner.x * i128::from(run) - rise * i128::from(corner.n);
        // Along a side the height grows up to the farthest corner and then shrinks.
        let (mut low, mut high) = (0, self.corners.len().checked_sub(1)?);
        while low < high {
            let middle = (low + high) / 2;
            let grows = height(&self.corners[middle + 1]) - height(&self.corners[middle]);
            if if self.upper { grows > 0 } else { grows < 0 } {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        self.corners.get(low)
    }

    /// The slopes of its edges.
    fn slopes(&self) -> impl Iterator<Item = (i128, i64)> {
        self.corners.windows(2).map(|pair| (pair[1].x - pair[0].x, pair[1].n - pair[0].n))
    }
}

/// How far the points reach to both sides of the line that suits them best: the width of the narrowest band between two
/// parallel lines, as a distance of `x`, with a corner at either border. Below 0 where every point of `upper` can lie
/// below every one of `lower`.
pub(super) fn narrowest(upper: &HullSide, lower: &HullSide) -> Option<(f64, HullCorner, HullCorner)> {
    // The width is a convex function of the slope that bends at the slopes of edges, so its least value is at one.
    let slopes = upper.slopes().chain(lower.slopes()).chain((upper.corners.len() == 1).then_some((0, 1)));
    slopes.filter_map(|(rise, run)| width(upper, lower, rise, run)).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// The same between lines of a given slope.
fn width(upper: &HullSide, lower: &HullSide, rise: i128, run: i64) -> Option<(f64, HullCorner, HullCorner)> {
    let (above, below) = (upper.farthest(rise, run)?, lower.farthest(rise, run)?);
    let height = |corner: &HullCorner| corner.x * i128::from(run) - rise * i128::from(corner.n);
    Some(((height(above) - height(below)) as f64 / run as f64, *above, *below))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(points: &[i128], upper: bool) -> HullSide {
        let mut side = HullSide::new(upper);
        for (n, x) in (0_i64..).zip(points) {
            side.add(HullCorner { n, x: *x, seen: TimedValue::NOTHING });
        }
        side
    }

    fn band(points: &[i128]) -> f64 {
        narrowest(&side(points, true), &side(points, false)).unwrap().0
    }

    #[test]
    fn points_on_a_line_need_no_band() {
        assert_eq!(band(&[0, 7, 14, 21]), 0.0);
        assert_eq!(band(&[0, 7]), 0.0);
    }

    #[test]
    fn the_band_is_the_narrowest_of_all_slopes() {
        // From the first to the last point: 3 above. Along the second edge to the last: less.
        assert_eq!(band(&[0, 3, 0]), 3.0);
        assert_eq!(band(&[0, 3, 0, 3]), 3.0);
        assert_eq!(band(&[0, 0, 4]), 2.0);
    }

    #[test]
    fn no_slope_gives_less() {
        let mut chance = signal::Random::new(7);
        for _ in 0..200 {
            let points: Vec<i128> = (0..9).map(|_| i128::from(chance.below(20))).collect();
            let best = band(&points);
            for fine in -4_000_i32..=4_000 {
                let slope = f64::from(fine) / 200.0;
                let heights = || points.iter().enumerate().map(|(n, x)| *x as f64 - slope * n as f64);
                let width = heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min);
                assert!(best <= width + 1e-9, "{points:?}: {best} and not {width} at {slope}");
            }
        }
    }
}
