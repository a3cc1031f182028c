//! The time axis: which stretches of time are drawn, and where.
//!
//! A diagram shows the instants that the claims speak of. Where they lie in groups far apart (a step, and
//! 100 ms later an edge that has to fall into 0.3 ms), the axis is broken between the groups, so that the
//! small distances can be seen.

use record::{CaseRecord, Verdict};

/// Width of a break in the axis, in user units.
pub(super) const BREAK: f64 = 34.0;
/// Distances that would be drawn narrower than this ask for a break elsewhere.
const LEGIBLE: f64 = 18.0;
/// A gap is broken when it is this many times all others together.
const FAR: i64 = 4;
/// The most breaks of one axis.
const BREAKS: usize = 2;

/// A stretch of time drawn linearly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) t0: i64,
    pub(super) t1: i64,
    pub(super) x0: f64,
    pub(super) x1: f64,
}

/// Stretches of time from left to right, with a break between each two.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) pieces: Vec<Piece>,
}

/// A tick: instant, place and label.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub(super) x: f64,
    pub(super) label: String,
}

impl Axis {
    /// The axis of a case between `left` and `right`.
    pub(super) fn of(case: &CaseRecord, left: f64, right: f64) -> Axis {
        let bounds = extent(case);
        let groups = groups(instants(case), right - left);
        let stretches = stretches(&groups, &intervals(case), bounds);
        let gaps = BREAK * (stretches.len() as f64 - 1.0);
        let weight = |n: usize| 1.0 + n.min(4) as f64;
        let total: f64 = stretches.iter().map(|s| weight(s.2)).sum();
        let mut x = left;
        let pieces = stretches.iter().map(|&(t0, t1, n)| {
            let x0 = x;
            let x1 = x0 + (right - left - gaps) * weight(n) / total;
            x = x1 + BREAK;
            Piece { t0, t1, x0, x1 }
        });
        Axis { pieces: pieces.collect() }
    }

    pub(super) fn first(&self) -> Piece {
        self.pieces.first().copied().unwrap_or(Piece { t0: 0, t1: 1, x0: 0.0, x1: 1.0 })
    }

    pub(super) fn last(&self) -> Piece {
        self.pieces.last().copied().unwrap_or(self.first())
    }

    /// Where an instant is drawn: in a break somewhere within the break, outside at the nearest end.
    pub(super) fn x(&self, t: i64) -> f64 {
        let mut before: Option<Piece> = None;
        for piece in &self.pieces {
            if t < piece.t0 {
                return match before {
                    None => piece.x0,
                    Some(b) => between(t, (b.t1, b.x1), (piece.t0, piece.x0)),
                };
            }
            if t <= piece.t1 {
                return between(t, (piece.t0, piece.x0), (piece.t1, piece.x1));
            }
            before = Some(*piece);
        }
        self.last().x1
    }

    /// Whether an instant lies in a drawn stretch.
    pub(super) fn shows(&self, t: i64) -> bool {
        self.pieces.iter().any(|p| p.t0 <= t && t <= p.t1)
    }

    /// Whether any of `[from, until]` lies between the ends of the axis.
    pub(super) fn overlaps(&self, from: i64, until: i64) -> bool {
        from <= self.last().t1 && until >= self.first().t0
    }
}

impl Piece {
    /// Ticks at round distances from `origin`.
    pub(super) fn ticks(&self, origin: i64) -> Vec<Tick> {
        let width = i128::from(self.t1) - i128::from(self.t0);
        let wanted = ((self.x1 - self.x0) / 110.0).max(1.0) as i128;
        let mut step = 1i128;
        while step * wanted < width {
            // 1, 2, 5, 10, ..: the first digit says which comes next.
            let digit = step / 10i128.pow(step.ilog10());
            step = if digit == 2 { step / 2 * 5 } else { step * 2 };
        }
        let origin = i128::from(origin);
        let (low, high) = (i128::from(self.t0) - origin, i128::from(self.t1) - origin);
        let (unit, name) = unit(step, low.abs().max(high.abs()));
        let mut ticks = Vec::new();
        let mut at = low.div_euclid(step) * step;
        while at <= high && ticks.len() < 40 {
            if at >= low {
                let x = between((at + origin) as i64, (self.t0, self.x0), (self.t1, self.x1));
                ticks.push(Tick { x, label: format!("{} {name}", decimal(at, step, unit)) });
            }
            at += step;
        }
        ticks
    }
}

/// The unit of tick labels, nanoseconds and name: small enough for short decimals, large enough for few digits.
fn unit(step: i128, magnitude: i128) -> (i128, &'static str) {
    if magnitude < 1_000 {
        (1, "ns")
    } else if step >= 100_000_000 || magnitude >= 10_000_000_000 {
        (1_000_000_000, "s")
    } else if step >= 10_000 || magnitude >= 100_000_000 {
        (1_000_000, "ms")
    } else if step >= 10 || magnitude >= 100_000 {
        (1_000, "us")
    } else {
        (1, "ns")
    }
}

/// `at` in `unit`, with the decimals that multiples of `step` need.
fn decimal(at: i128, step: i128, unit: i128) -> String {
    let mut decimals = 0;
    while step * 10i128.pow(decimals) % unit != 0 {
        decimals += 1;
    }
    let scaled = (at * 10i128.pow(decimals) / unit).unsigned_abs();
    let sign = if at < 0 { "-" } else { "" };
    let base = 10u128.pow(decimals);
    if decimals == 0 {
        return format!("{sign}{scaled}");
    }
    format!("{sign}{}.{:0width$}", scaled / base, scaled % base, width = decimals as usize)
}

fn between(t: i64, (t0, x0): (i64, f64), (t1, x1): (i64, f64)) -> f64 {
    let width = (t1 as f64 - t0 as f64).max(1.0);
    // The difference first: instants of long traces lose nanoseconds as floats.
    x0 + (x1 - x0) * ((t.saturating_sub(t0)) as f64 / width).clamp(0.0, 1.0)
}

pub(super) fn middle([earliest, latest]: [i64; 2]) -> i64 {
    ((i128::from(earliest) + i128::from(latest)) / 2) as i64
}

/// From the first to the last instant that the case knows of.
fn extent(case: &CaseRecord) -> (i64, i64) {
    let points = case.lanes.iter().flat_map(|lane| lane.points.iter().map(|p| p.at));
    let (mut low, mut high) = (case.start_ns.min(0), case.end_ns.max(case.duration_ns));
    for [earliest, latest] in points {
        low = low.min(earliest);
        high = high.max(latest);
    }
    // No further than the excerpts tell, where they end early.
    let known = case.lanes.iter().filter_map(|lane| lane.until_ns).min();
    let high = known.map_or(high, |known| high.min(known));
    (low, high.max(low.saturating_add(1)))
}

/// The instants that the claims and measurements speak of; of those without a pass where there are any, so
/// that a failure is what the diagram shows.
fn instants(case: &CaseRecord) -> Vec<i64> {
    let bad = |verdict: Verdict| verdict >= Verdict::Inconclusive;
    let any_bad =
        case.claims.iter().any(|c| bad(c.verdict)) || case.measurements.iter().any(|m| bad(m.verdict));
    let mut all = Vec::new();
    for claim in case.claims.iter().filter(|c| !any_bad || bad(c.verdict)) {
        all.extend(claim.deciding_ns.map(middle));
        if let Some(window) = claim.window {
            all.extend([window.limit_from_ns, window.limit_until_ns].into_iter().flatten());
            all.extend([middle(window.from_ns), middle(window.until_ns)]);
        }
    }
    for m in case.measurements.iter().filter(|m| !any_bad || bad(m.verdict)) {
        all.extend(m.from_ns.into_iter().chain(m.to_ns).map(middle));
    }
    // The ends of the case are where windows end that say nothing of a particular instant.
    all.retain(|&t| t > case.start_ns && t < case.end_ns);
    let steps = case.steps.iter().filter_map(|s| s.at_ns.map(middle));
    let steps = steps.filter(|&t| t > case.start_ns && t < case.end_ns);
    if any_bad {
        // The step that led to the failure.
        if let Some(&first) = all.iter().min() {
            all.extend(steps.filter(|&t| t <= first).max());
        }
    } else {
        all.extend(steps);
    }
    if all.is_empty() {
        all.extend([case.start_ns, case.end_ns]);
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// Cuts the instants into groups where a gap dwarfs everything else and hides it.
fn groups(instants: Vec<i64>, width: f64) -> Vec<Vec<i64>> {
    let mut groups = vec![instants];
    for _ in 0..BREAKS {
        let gaps = groups.iter().enumerate().flat_map(|(place, group)| {
            group
                .windows(2)
                .enumerate()
                .map(move |(at, pair)| (pair[1].saturating_sub(pair[0]), place, at + 1))
        });
        let Some((largest, place, at)) = gaps.max_by_key(|gap| gap.0) else { break };
        let all = groups.iter().flat_map(|g| g.windows(2).map(|p| p[1].saturating_sub(p[0])));
        let (sum, least) =
            all.fold((0i64, i64::MAX), |(sum, least), gap| (sum.saturating_add(gap), least.min(gap)));
        let rest = sum.saturating_sub(largest);
        let hidden = least as f64 * width < LEGIBLE * sum as f64;
        if rest == 0 || !hidden || largest / FAR < rest {
            break;
        }
        let tail = groups[place].split_off(at);
        groups.insert(place + 1, tail);
    }
    groups
}

/// The intervals in which the instants lie.
fn intervals(case: &CaseRecord) -> Vec<[i64; 2]> {
    let claims = case.claims.iter().filter_map(|c| c.deciding_ns);
    let measured = case.measurements.iter().flat_map(|m| m.from_ns.into_iter().chain(m.to_ns));
    claims.chain(measured).filter(|[earliest, latest]| earliest < latest).collect()
}

/// Each group with room around it and around the intervals of its instants, and how many instants it holds;
/// groups that touch become one.
fn stretches(groups: &[Vec<i64>], intervals: &[[i64; 2]], (low, high): (i64, i64)) -> Vec<(i64, i64, usize)> {
    let ends =
        |group: &Vec<i64>| (group.first().copied().unwrap_or(low), group.last().copied().unwrap_or(high));
    let widest = groups.iter().map(|g| ends(g).1.saturating_sub(ends(g).0)).max().unwrap_or(0);
    let alone = if widest > 0 { widest / 3 } else { (high.saturating_sub(low) / 20).max(1_000) };
    let mut out: Vec<(i64, i64, usize)> = Vec::new();
    for group in groups {
        let (mut first, mut last) = ends(group);
        for [earliest, latest] in intervals.iter().filter(|i| group.binary_search(&middle(**i)).is_ok()) {
            (first, last) = (first.min(*earliest), last.max(*latest));
        }
        let width = last.saturating_sub(first);
        let room = if width > 0 { (width / 7).max(1) } else { alone.max(1) };
        let t0 = first.saturating_sub(room).max(low.min(first));
        let t1 = last.saturating_add(room).min(high.max(last)).max(t0.saturating_add(1));
        match out.last_mut() {
            Some(before) if t0 <= before.1.saturating_add(room) => {
                before.1 = before.1.max(t1);
                before.2 += group.len();
            }
            _ => out.push((t0, t1, group.len())),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn a_far_step_is_broken_off_so_that_the_limits_can_be_seen() {
        let got = groups(vec![1_000 * MS, 1_100 * MS, 1_100 * MS + 200_000, 1_100 * MS + 300_000], 900.0);
        assert_eq!(got.iter().map(Vec::len).collect::<Vec<_>>(), [1, 3]);
        // Two instants alone, or distances that can be seen anyway, need no break.
        assert_eq!(groups(vec![0, 100 * MS], 900.0).len(), 1);
        assert_eq!(groups(vec![0, 100 * MS, 110 * MS], 900.0).len(), 1);
    }

    #[test]
    fn ticks_are_round_and_short() {
        let labels = |t0, t1, origin| {
            let piece = Piece { t0, t1, x0: 0.0, x1: 500.0 };
            piece.ticks(origin).into_iter().map(|t| t.label).collect::<Vec<_>>()
        };
        assert_eq!(labels(0, 2_000 * MS, 0), ["0.0 s", "0.5 s", "1.0 s", "1.5 s", "2.0 s"]);
        assert_eq!(
            labels(1_100 * MS, 1_100 * MS + 400_000, 1_000 * MS),
            ["100.0 ms", "100.1 ms", "100.2 ms", "100.3 ms", "100.4 ms"]
        );
        assert_eq!(labels(-20, 30, 0), ["-20 ns", "0 ns", "20 ns"]);
    }

    proptest! {
        #[test]
        fn places_keep_the_order_of_time(
            mut times in prop::collection::vec(any::<i64>(), 1..8),
            probes in prop::collection::vec(any::<i64>(), 2),
            start in any::<i64>(), end in any::<i64>(),
        ) {
            let steps = times.iter().map(|&t| record::StepRecord { at_ns: Some([t, t]), ..Default::default() });
            let (start_ns, end_ns) = (start.min(end), start.max(end));
            let case = CaseRecord { steps: steps.collect(), start_ns, end_ns, ..CaseRecord::default() };
            let axis = Axis::of(&case, 100.0, 900.0);
            times.extend(probes);
            times.sort_unstable();
            let places: Vec<f64> = times.iter().map(|&t| axis.x(t)).collect();
            prop_assert!(places.windows(2).all(|p| p[0] <= p[1]), "{places:?}");
            prop_assert!(places.iter().all(|x| (99.9..=900.1).contains(x)));
            for piece in &axis.pieces {
                prop_assert!(piece.t0 < piece.t1 || piece.t1 == i64::MAX);
                piece.ticks(start_ns);
            }
        }
    }
}
