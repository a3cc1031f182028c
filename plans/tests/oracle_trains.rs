//! The judge of pulse trains against an oracle that tries every placement of every edge: jitter.
//!
//! A verdict may never contradict the oracle, and where all instants are exact it must be the oracle's. A measured
//! interval has to hold what is measured in every placement.

use proptest::prelude::*;
use signal::ValueKind;

use crate::oracle_values::{ORIGIN, Raw, apart_from_the_step, judged, line, placements, raw, rises};

/// From the greatest to the least.
fn span(all: &[f64]) -> f64 {
    all.iter().copied().fold(f64::MIN, f64::max) - all.iter().copied().fold(f64::MAX, f64::min)
}

/// Distances of edges from a grid of this period that begins at 0.
fn away(edges: &[i64], period: f64) -> Vec<f64> {
    edges.iter().enumerate().map(|(n, at)| *at as f64 - n as f64 * period).collect()
}

fn root_of_mean_square(all: &[f64]) -> f64 {
    (all.iter().map(|one| one * one).sum::<f64>() / all.len() as f64).sqrt()
}

fn about_the_mean(all: &[f64]) -> Vec<f64> {
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    all.iter().map(|one| one - mean).collect()
}

/// The narrowest band: its slope is that of the way between some two edges.
fn narrowest(edges: &[i64]) -> f64 {
    let mut least = f64::INFINITY;
    for (i, first) in edges.iter().enumerate() {
        for (j, second) in edges.iter().enumerate().skip(i + 1) {
            least = least.min(span(&away(edges, (second - first) as f64 / (j - i) as f64)));
        }
    }
    least
}

/// What is left beside the straight line of least squares, by its formula.
fn least_squares(edges: &[i64]) -> f64 {
    let x = about_the_mean(&edges.iter().map(|at| *at as f64).collect::<Vec<_>>());
    let n = about_the_mean(&(0..edges.len()).map(|n| n as f64).collect::<Vec<_>>());
    let slope = x.iter().zip(&n).map(|(x, n)| x * n).sum::<f64>() / n.iter().map(|n| n * n).sum::<f64>();
    root_of_mean_square(&x.iter().zip(&n).map(|(x, n)| x - slope * n).collect::<Vec<_>>())
}

/// What is measured, and what it is of some edges.
type Figure = (&'static str, fn(&[i64]) -> f64);

const FIGURES: [Figure; 6] = [
    ("", narrowest),
    (r#", take = "rms""#, least_squares),
    (r#", grid = "5 ns""#, |edges| span(&away(edges, 5.0))),
    (r#", take = "rms", grid = "300 MHz""#, |edges| {
        root_of_mean_square(&about_the_mean(&away(edges, 10.0 / 3.0)))
    }),
    (r#", compares = "periods""#, |edges| span(&periods(edges))),
    (r#", compares = "periods", take = "rms""#, |edges| {
        root_of_mean_square(&about_the_mean(&periods(edges)))
    }),
];

fn periods(edges: &[i64]) -> Vec<f64> {
    edges.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// The measured interval holds the jitter of every placement.
    #[test]
    fn jitter(q in line(2, 9), step in (0i64..4, 0i64..3), which in 0usize..6, exact: bool) {
        let mut raw = raw(&[(q, 2)], step, exact);
        // Falling edges matter to nothing here: exact ones leave fewer placements.
        for event in &mut raw {
            if event.signal == 0 && event.value == 0 {
                event.a = event.b;
            }
        }
        prop_assume!(apart_from_the_step(&raw));
        let (keys, figure) = FIGURES[which];
        let text = format!(r#"{{ name = "n", jitter-of = "q", from = "a"{keys} }}"#);
        let Some([low, high]) = judged(&raw, &text, ValueKind::Bool).measurements[0].value else { return Ok(()) };
        let mut wrong = None;
        placements(&raw, |line, _, a| {
            let edges = rises(line, a);
            if edges.len() < 3 {
                return;
            }
            let value = figure(&edges);
            if value < low - 1e-9 || value > high + 1e-9 {
                wrong = Some((value, low, high));
            }
        });
        prop_assert!(wrong.is_none(), "{wrong:?}: {text} {raw:?}");
        prop_assert!(!exact || high - low < 1e-9, "{low} {high}: {text} {raw:?}");
    }

    /// Many edges, far from the origin and with a mean period that is nothing like the first one.
    #[test]
    fn jitter_of_many(gaps in prop::collection::vec(2i64..2_000, 3..200), which in 0usize..6) {
        let mut raw = vec![Raw { signal: 0, a: 0, b: 0, value: 0 }, Raw { signal: 2, a: 1, b: 1, value: 1 }];
        let mut at = 10 * ORIGIN;
        let mut edges = Vec::new();
        for gap in gaps {
            edges.push(at);
            raw.push(Raw { signal: 0, a: at, b: at, value: 1 });
            raw.push(Raw { signal: 0, a: at + 1, b: at + 1, value: 0 });
            at += gap;
        }
        let (keys, figure) = FIGURES[which];
        let text = format!(r#"{{ name = "n", jitter-of = "q", from = "a"{keys} }}"#);
        let outcome = crate::oracle_values::judged_until(&raw, &text, ValueKind::Bool, at + 10);
        let [low, high] = outcome.measurements[0].value.unwrap();
        let value = figure(&edges);
        prop_assert!((low - value).abs() < 1e-6 && (high - value).abs() < 1e-6, "{low} .. {high} and not {value}: {text}");
    }
}
