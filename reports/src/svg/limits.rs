//! A measured value between its limits.

use super::marks::class;
use super::{Canvas, px};
use crate::show;
use record::MeasurementRecord;

const WIDTH: f64 = 200.0;
const HEIGHT: f64 = 22.0;

/// A bar of the allowed range with the measured interval on it, or nothing when there is no value or no limit.
pub(crate) fn limit_bar(measurement: &MeasurementRecord) -> Option<String> {
    let [low, high] = measurement.value?;
    let (min, max) = show::bounds(measurement);
    let ends: Vec<f64> = [min, max, Some(low), Some(high)].into_iter().flatten().collect();
    if (min.is_none() && max.is_none()) || !ends.iter().all(|n| n.is_finite()) {
        return None;
    }
    let (mut left, mut right) = ends.iter().fold((f64::MAX, f64::MIN), |(l, h), n| (l.min(*n), h.max(*n)));
    if min.is_none() && left > 0.0 {
        // One limit above: the scale begins at 0, so that the distance to the limit means something.
        left = 0.0;
    }
    let room = ((right - left) * 0.12).max(right.abs().max(1e-9) * 1e-6);
    (left, right) = (if left == 0.0 && min.is_none() { 0.0 } else { left - room }, right + room);
    let x = |n: f64| 1.0 + (WIDTH - 2.0) * ((n - left) / (right - left)).clamp(0.0, 1.0);
    let mut out = Canvas::default();
    let limits =
        super::escape(&format!("{} within limits {}", show::value(measurement), show::limits(measurement)));
    let (width, height) = (px(WIDTH), px(HEIGHT));
    out.raw(format_args!(
        r#"<svg class="bar" viewBox="0 0 {width} {height}" role="img" aria-label="{limits}">"#
    ));
    out.line("axis", [1.0, 11.0], [WIDTH - 1.0, 11.0]);
    let (a, b) = (min.map_or(1.0, x), max.map_or(WIDTH - 1.0, x));
    out.rect("allowed", a, 6.0, (b - a).max(1.0), 10.0);
    for place in [min, max].into_iter().flatten().map(x) {
        out.line("limitmark", [place, 3.0], [place, 19.0]);
    }
    let (a, b) = (x(low), x(high));
    let class = class(measurement.verdict);
    if b - a >= 3.0 {
        out.rect(&format!("taken {class}"), a, 8.0, b - a, 6.0);
    } else {
        let (x, y) = (px((a + b) / 2.0), px(11.0));
        out.raw(format_args!(r#"<circle class="taken {class}" cx="{x}" cy="{y}" r="4"/>"#));
    }
    out.0.push_str("</svg>");
    Some(out.0)
}
