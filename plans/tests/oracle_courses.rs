//! The judge of pulse trains with a position against an oracle that tries every placement: `position` and `profile`.
//!
//! The oracle of a profile adds up its shape in small steps and knows nothing of straight pieces.

use proptest::prelude::*;
use signal::ValueKind;

use crate::oracle_values::{ORIGIN, Placed, Raw, apart_from_the_step, judged, line, placements, raw};

/// The end of a case of the oracle.
const END: i64 = 60;
/// Steps in a nanosecond.
const FINE: i64 = 48;

/// A way to carry counts: the keys, and the counts that come of two lines, `None` where their order is not known.
type Way = (&'static str, fn(&Placed, &Placed) -> Option<Vec<(i64, i64)>>);

const WAYS: [Way; 4] = [
    (r#"signal = "q""#, |q, _| Some(rising(q).into_iter().map(|at| (at, 1)).collect())),
    (r#"signal = "q", direction = "r""#, |q, r| {
        let level = |at: i64| r.iter().rev().find(|change| change.0 < at).map(|change| change.1);
        let sure = |at: &i64| r.iter().all(|change| change.0 != *at);
        let edges = rising(q);
        edges
            .iter()
            .all(sure)
            .then(|| edges.iter().map(|at| (*at, if level(*at) == Some(1) { 1 } else { -1 })).collect())
    }),
    (r#"signal = "q", down = "r""#, |q, r| {
        let ups = rising(q).into_iter().map(|at| (at, 1));
        let mut all: Vec<(i64, i64)> = ups.chain(rising(r).into_iter().map(|at| (at, -1))).collect();
        all.sort_unstable();
        all.windows(2).all(|pair| pair[0].0 != pair[1].0).then_some(all)
    }),
    (r#"signal = "q", quadrature = "r""#, |q, r| {
        let mut all: Vec<(i64, usize, i64)> =
            q.iter().skip(1).map(|change| (change.0, 0, change.1)).collect();
        all.extend(r.iter().skip(1).map(|change| (change.0, 1, change.1)));
        all.sort_unstable();
        if all.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return None;
        }
        // The four states in their order forwards.
        let ring = [(0, 0), (1, 0), (1, 1), (0, 1)];
        let place = |levels: [i64; 2]| ring.iter().position(|one| *one == (levels[0], levels[1]));
        let mut levels = [q[0].1, r[0].1];
        let mut counts = Vec::new();
        for (at, line, value) in all {
            let before = place(levels)?;
            levels[line] = value;
            counts.push((at, if place(levels)? == (before + 1) % 4 { 1 } else { -1 }));
        }
        Some(counts)
    }),
];

fn rising(line: &Placed) -> Vec<i64> {
    line.windows(2).filter(|pair| pair[0].1 == 0 && pair[1].1 == 1).map(|pair| pair[1].0).collect()
}

/// A shape: its points in nanoseconds and megahertz.
type Points = Vec<(i64, i64)>;

fn shape(turning: bool) -> impl Strategy<Value = Points> {
    let low = if turning { -300_i64 } else { 0 };
    prop::collection::vec((1i64..12, low..300), 1..4).prop_map(|steps| {
        let mut at = 0;
        let mut points = Vec::new();
        for (step, height) in steps {
            points.push((at, height));
            at += step;
        }
        points
    })
}

/// The shape at a step after its beginning, in pulses a nanosecond.
fn at(points: &Points, step: f64) -> f64 {
    let t = step / FINE as f64;
    if t < points[0].0 as f64 {
        return 0.0;
    }
    let height = |n: i64| n as f64 / 1e3;
    for pair in points.windows(2) {
        let ((a, low), (b, high)) = (pair[0], pair[1]);
        if t < b as f64 {
            return height(low) + (height(high) - height(low)) * (t - a as f64) / (b - a) as f64;
        }
    }
    height(points[points.len() - 1].1)
}

/// Sums under the borders of the band from the beginning of the case up to each nanosecond.
struct Borders {
    least: [Vec<f64>; 2],
    most: [Vec<f64>; 2],
}

impl Borders {
    fn new(points: &Points, within: i64, tolerance: f64, begin: i64) -> Borders {
        let values: Vec<f64> = (0..(END + 40) * FINE)
            .map(|step| at(points, (step - (begin + 20) * FINE) as f64 + 0.5))
            .collect();
        let reach = (within * FINE) as usize;
        let mut sums = [0.0_f64; 4];
        let mut columns: [Vec<f64>; 4] = [const { Vec::new() }; 4];
        for middle in (20 * FINE) as usize..((END + 20) * FINE) as usize {
            if middle % FINE as usize == 0 {
                columns.iter_mut().zip(sums).for_each(|(column, sum)| column.push(sum));
            }
            let near = &values[middle - reach..=middle + reach];
            let least = near.iter().copied().fold(f64::INFINITY, f64::min);
            let most = near.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let heights = [least - tolerance, -most - tolerance, most + tolerance, -least + tolerance];
            sums.iter_mut().zip(heights).for_each(|(sum, height)| *sum += height.max(0.0) / FINE as f64);
        }
        columns.iter_mut().zip(sums).for_each(|(column, sum)| column.push(sum));
        let [up, down, most_up, most_down] = columns;
        Borders { least: [up, down], most: [most_up, most_down] }
    }

    /// By how many pulses the counts of a case are off at worst; at most 0 where they follow.
    fn off(&self, counts: &[(i64, i64)], begin: i64, over: i64, signed: bool) -> f64 {
        let inside: Vec<(i64, i64)> = counts.iter().copied().filter(|count| count.0 >= begin).collect();
        let ways = if signed { 0..2 } else { 0..1 };
        let mut worst = f64::NEG_INFINITY;
        let under = |sums: &Vec<f64>, from: i64, until: i64| sums[until as usize] - sums[from as usize];
        for way in ways {
            let sign = if way == 0 { 1 } else { -1 };
            let own = |part: &[(i64, i64)]| part.iter().filter(|count| count.1 == sign).count() as f64;
            let Some(first) = inside.first() else {
                worst = worst.max(under(&self.least[way], begin, END) - 1.0);
                continue;
            };
            worst = worst.max(under(&self.least[way], begin, first.0) - 1.0);
            let mut open = 0;
            for next in 1..inside.len() {
                if inside[next].0 - inside[open].0 < over {
                    continue;
                }
                let part = &inside[open..=next];
                let pure = part.iter().all(|count| count.1 == sign);
                let loose = if pure { 0.0 } else { 1.0 };
                let (from, until, came) = (inside[open].0, inside[next].0, own(&part[1..]));
                worst = worst.max(under(&self.least[way], from, until) - came - loose);
                if came > loose {
                    worst = worst.max(came - loose - under(&self.most[way], from, until));
                }
                open = next;
            }
            let came = own(&inside[open + 1..]);
            worst = worst.max(under(&self.least[way], inside[open].0, END) - came - 1.0);
        }
        worst
    }
}

fn exactly(raw: &mut [Raw], signal: u32) {
    for event in raw.iter_mut().filter(|event| event.signal == signal) {
        event.a = event.b;
    }
}

/// Within the greatest measured distance every placement follows its shape, and below the least one none does.
fn profile_of(
    raw: &[Raw],
    which: usize,
    within: i64,
    over: i64,
    points: Points,
    exact: bool,
) -> Result<(), TestCaseError> {
    let (keys, counts) = WAYS[which];
    // Which counts end a stretch is settled by what is certain, and not by each placement again.
    let over = if exact { over } else { 0 };
    let signed = which > 0;
    let points: Points = match signed {
        true => points,
        false => points.into_iter().map(|(at, height)| (at, height.abs())).collect(),
    };
    let listed: Vec<String> = points
        .iter()
        .map(|(at, height)| format!(r#"{{ at = "{at} ns", frequency = "{height} MHz" }}"#))
        .collect();
    let text = format!(
        r#"{{ name = "n", from = "a", profile-of = {{ {keys}, points = [{}], within = "{within} ns", over = "{over} ns" }} }}"#,
        listed.join(", ")
    );
    let taken = judged(raw, &text, ValueKind::Bool).measurements.remove(0);
    let Some([low, high]) = taken.value else { return Ok(()) };
    let open = taken.reason.contains("not known");
    let gigahertz = |hertz: f64| if hertz.is_finite() { hertz / 1e9 } else { 1e9 };
    let mut known: Vec<(i64, Borders, Borders)> = Vec::new();
    let (mut wrong, mut some) = (None, false);
    placements(raw, |q, r, a| {
        let Some(counts) = counts(q, r) else { return };
        some = true;
        if !known.iter().any(|(begin, ..)| *begin == a) {
            let borders = |tolerance| Borders::new(&points, within, gigahertz(tolerance), a);
            known.push((a, borders(low), borders(high)));
        }
        let (_, least, most) = known.iter().find(|(begin, ..)| *begin == a).unwrap();
        let off = most.off(&counts, a, over, signed);
        if off > 0.02 && high.is_finite() && !open {
            wrong = Some(("off by more", off, counts.clone(), a));
        }
        let off = least.off(&counts, a, over, signed);
        if low > 0.0 && off < -0.02 && !open {
            wrong = Some(("off by less", off, counts, a));
        }
    });
    prop_assert!(wrong.is_none(), "{wrong:?}: {low} .. {high}: {text} {raw:?}");
    prop_assert!(!exact || !some || open || low == high, "{low} .. {high}: {text} {raw:?}");
    Ok(())
}

/// Two counts backwards with one forwards before, between or after them: the former may follow each other at once.
#[test]
fn a_count_between_that_need_not_be_there() {
    let event = |signal, a, b, value| Raw { signal, a, b, value };
    let backwards = [(12, 1), (13, 0), (15, 1)].map(|(at, value)| event(1, at, at, value));
    let mut raw = vec![event(0, 0, 0, 0), event(1, 0, 0, 0), event(2, ORIGIN, ORIGIN, 1)];
    raw.extend(backwards);
    raw.push(event(0, 14, 16, 1));
    profile_of(&raw, 2, 0, 0, vec![(0, 0)], false).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    /// The measured interval holds the position of every placement.
    #[test]
    fn positions(q in line(2, 6), r in line(2, 5), step in (0i64..6, 0i64..3), which in 0usize..4, exact: bool) {
        let raw = raw(&[(q, 2), (r, 2)], step, exact);
        prop_assume!(apart_from_the_step(&raw));
        let (keys, counts) = WAYS[which];
        let text = format!(r#"{{ name = "n", position-of = {{ {keys} }}, from = "a" }}"#);
        let [low, high] = judged(&raw, &text, ValueKind::Bool).measurements[0].value.unwrap();
        let (mut wrong, mut some) = (None, false);
        placements(&raw, |q, r, a| {
            let Some(counts) = counts(q, r) else { return };
            some = true;
            let position: i64 = counts.iter().filter(|count| count.0 >= a).map(|count| count.1).sum();
            if (position as f64) < low || (position as f64) > high {
                wrong = Some(position);
            }
        });
        prop_assert!(wrong.is_none(), "{wrong:?} and not {low} .. {high}: {text} {raw:?}");
        prop_assert!(!exact || !some || low == high, "{low} .. {high}: {text} {raw:?}");
    }

    /// Within the greatest measured distance every placement follows its shape, and below the least one none does.
    #[test]
    fn profiles(
        q in line(2, 6), r in line(2, 4), step in (0i64..6, 0i64..3), which in 0usize..4,
        within in 0i64..4, over in 0i64..9, points in shape(true), exact: bool,
    ) {
        let mut raw = raw(&[(q, 2), (r, 2)], step, exact);
        exactly(&mut raw, 1);
        prop_assume!(apart_from_the_step(&raw));
        profile_of(&raw, which, within, over, points, exact)?;
    }
}
