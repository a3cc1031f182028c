//! Durations as people and programs read them.

use host::Histogram;
use record::Durations;
use serde_json::{Value, json};

/// Nanoseconds in microseconds.
pub fn us(nanos: u64) -> f64 {
    nanos as f64 / 1_000.0
}

/// A line for a person.
pub fn line(figure: &Durations) -> String {
    format!(
        "{}: p50 {:.1} us, p99 {:.1} us, p99.99 {:.1} us, max {:.1} us",
        figure.name,
        us(figure.p50_ns),
        us(figure.p99_ns),
        us(figure.p99_99_ns),
        us(figure.max_ns)
    )
}

/// The figures, in microseconds.
pub fn figures(figure: &Durations) -> Value {
    json!({
        "count": figure.count,
        "min_us": us(figure.min_ns),
        "mean_us": us(figure.mean_ns),
        "p50_us": us(figure.p50_ns),
        "p99_us": us(figure.p99_ns),
        "p99_99_us": us(figure.p99_99_ns),
        "max_us": us(figure.max_ns),
    })
}

/// How many durations lie in which microsecond, as `[microsecond, count]`, least first. A class that lies in two is
/// counted in the later one: above 262 us, neighbours are counted together.
pub fn histogram(of: &Histogram) -> Value {
    let mut classes: Vec<(u64, u64)> = Vec::new();
    for (longest, count) in of.buckets() {
        match classes.last_mut() {
            Some((us, counted)) if *us == longest / 1_000 => *counted += count,
            _ => classes.push((longest / 1_000, count)),
        }
    }
    json!(classes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_histogram_counts_by_microseconds() {
        let mut of = Histogram::new();
        [0, 999, 1_000, 1_999, 1_500_000].into_iter().for_each(|nanos| of.note(nanos));
        assert_eq!(histogram(&of), json!([[0, 2], [1, 2], [1500, 1]]));
    }
}
