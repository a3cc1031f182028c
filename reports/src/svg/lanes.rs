//! Signals over time: levels, named states, numbers.

use super::axis::Axis;
use super::{Canvas, escape, fit, px, text_width};
use record::{Figure, Lane, LaneKind, LanePoint, LaneValue};

/// Changes closer together than this are drawn as one block.
const DENSE: f64 = 1.6;

/// Height of the lane's own drawing.
pub(super) fn height(lane: &Lane) -> f64 {
    match lane.kind {
        LaneKind::Digital => 22.0,
        LaneKind::State => 22.0,
        LaneKind::Analog => 58.0,
    }
}

/// A stretch of one value, with the places of its beginning (both ends of the interval) and its end.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    /// Where it may begin and where it has certainly begun.
    from: [f64; 2],
    /// Where it may end.
    until: f64,
    value: Option<LaneValue>,
}

/// Either a stretch of one value, or many changes too close together to be told apart.
#[derive(Clone, Copy, Debug)]
enum Part {
    Plain(Stretch),
    Dense { from: f64, until: f64 },
}

/// Draws the lane with its top at `y`.
pub(super) fn draw(canvas: &mut Canvas, axis: &Axis, lane: &Lane, y: f64) {
    match lane.kind {
        LaneKind::Digital => digital(canvas, &parts(axis, lane), y),
        LaneKind::State => state(canvas, &parts(axis, lane), lane, y),
        LaneKind::Analog => analog(canvas, axis, lane, y),
    }
}

fn parts(axis: &Axis, lane: &Lane) -> Vec<Part> {
    let (left, right) = (axis.first().x0, axis.last().x1);
    let mut value = None;
    let mut from = [left, left];
    let mut parts: Vec<Part> = Vec::new();
    let mut close = |from: [f64; 2], until: f64, value: Option<LaneValue>, last: bool| {
        let narrow = until - from[0] < DENSE && !last;
        match parts.last_mut() {
            Some(Part::Dense { until: end, .. }) if narrow => *end = until,
            _ if narrow && until > from[0] => parts.push(Part::Dense { from: from[0], until }),
            _ if until > from[0] => parts.push(Part::Plain(Stretch { from, until, value })),
            _ => {}
        }
    };
    let mut end = right;
    for LanePoint { at: [earliest, latest], value: next } in &lane.points {
        if *latest < axis.first().t0 {
            value = Some(*next);
            continue;
        }
        if *earliest > axis.last().t1 {
            break;
        }
        let place = [axis.x(*earliest), axis.x(*latest)];
        if Some(*next) == value {
            continue;
        }
        close(from, place[0].max(from[0]), value, false);
        (from, value) = ([place[0].max(from[0]), place[1].max(from[0])], Some(*next));
    }
    if let Some(known) = lane.known_until_ns() {
        // Nothing is said of what comes after the excerpt.
        end = axis.x(known).max(from[0]);
    }
    close(from, end, value, true);
    if end < right {
        close([end, end], right, Some(LaneValue::Unknown), true);
    }
    parts
}

fn digital(canvas: &mut Canvas, parts: &[Part], y: f64) {
    let (high, low, mid, size) = (y + 2.0, y + 20.0, y + 11.0, 18.0);
    let mut wire = String::new();
    let mut floating = String::new();
    let mut pen: Option<f64> = None;
    for part in parts {
        let Stretch { from, until, value } = match *part {
            Part::Dense { from, until } => {
                canvas.rect("dense", from, high, until - from, size);
                pen = None;
                continue;
            }
            Part::Plain(stretch) => stretch,
        };
        uncertain_edge(canvas, from, until, high, size);
        let begin = from[1].min(until);
        let level = match value {
            None | Some(LaneValue::Unknown) => {
                canvas.rect("unknown", begin, high, until - begin, size);
                pen = None;
                continue;
            }
            Some(LaneValue::HighZ) => {
                floating.push_str(&format!("M{} {}H{}", px(begin), px(mid), px(until)));
                pen = Some(mid);
                continue;
            }
            Some(LaneValue::Number(n)) => {
                let level = if n != 0.0 { high } else { low };
                if n != 0.0 {
                    canvas.rect("on", begin, high, until - begin, size);
                }
                level
            }
        };
        match pen {
            Some(before) => {
                let (x0, x1) = (px(from[0]), px(begin));
                wire.push_str(&format!("M{x0} {}L{x1} {}H{}", px(before), px(level), px(until)));
            }
            None => wire.push_str(&format!("M{} {}H{}", px(begin), px(level), px(until))),
        }
        pen = Some(level);
    }
    canvas.path("floating", &floating);
    canvas.path("wire", &wire);
}

/// The hatched part of an edge whose instant is known to within an interval only.
fn uncertain_edge(canvas: &mut Canvas, from: [f64; 2], until: f64, top: f64, size: f64) {
    let end = from[1].min(until);
    if end - from[0] >= 1.5 {
        canvas.rect("uncertain", from[0], top, end - from[0], size);
    }
}

fn state(canvas: &mut Canvas, parts: &[Part], lane: &Lane, y: f64) {
    let (top, bottom, mid) = (y + 2.0, y + 20.0, y + 11.0);
    for part in parts {
        let Stretch { from, until, value } = match *part {
            Part::Dense { from, until } => {
                canvas.rect("dense", from, top, until - from, bottom - top);
                continue;
            }
            Part::Plain(stretch) => stretch,
        };
        uncertain_edge(canvas, from, until, top, bottom - top);
        let begin = from[1].min(until);
        let slant = ((until - begin) / 2.0).clamp(0.0, 3.0);
        let text = match value {
            None | Some(LaneValue::Unknown) => {
                canvas.rect("unknown", begin, top, until - begin, bottom - top);
                continue;
            }
            Some(value) => name(lane, value),
        };
        let (x0, x1, x2, x3) = (px(begin), px(begin + slant), px(until - slant), px(until));
        let (top, bottom, mid_px) = (px(top), px(bottom), px(mid));
        canvas.raw(format_args!(
            r#"<path class="box" d="M{x0} {mid_px}L{x1} {top}H{x2}L{x3} {mid_px}L{x2} {bottom}H{x1}Z"><title>{}</title></path>"#,
            escape(&text)
        ));
        let room = until - begin - 8.0;
        if room >= text_width(&text).min(28.0) {
            canvas.text("label mid", (begin + until) / 2.0, mid + 4.0, &fit(&text, room));
        }
    }
}

/// A state's label, or the number.
fn name(lane: &Lane, value: LaneValue) -> String {
    match value {
        LaneValue::Number(n) => {
            let label = lane.labels.iter().find(|(number, _)| *number as f64 == n);
            label.map_or_else(|| Figure::new(n, lane.unit.as_str()).to_string(), |(_, label)| label.clone())
        }
        LaneValue::HighZ => "high impedance".to_owned(),
        LaneValue::Unknown => "unknown".to_owned(),
    }
}

fn analog(canvas: &mut Canvas, axis: &Axis, lane: &Lane, y: f64) {
    let (top, bottom, left, right) = (y + 4.0, y + 54.0, axis.first().x0, axis.last().x1);
    let before = lane.points.iter().rev().find(|p| p.at[1] < axis.first().t0);
    let inside = lane.points.iter().filter(|p| p.at[1] >= axis.first().t0 && p.at[0] <= axis.last().t1);
    let number = |p: &&LanePoint| match p.value {
        LaneValue::Number(n) if n.is_finite() => Some(n),
        _ => None,
    };
    let numbers = before.into_iter().chain(inside.clone()).filter_map(|p| number(&p));
    let (low, high) = numbers.fold((f64::MAX, f64::MIN), |(l, h), n| (l.min(n), h.max(n)));
    if low > high {
        canvas.rect("unknown", left, top, right - left, bottom - top);
        return;
    }
    let scale = |n: f64| {
        if high - low > 0.0 {
            bottom - (bottom - top) * ((n - low) / (high - low))
        } else {
            (top + bottom) / 2.0
        }
    };
    canvas.line("grid", [left, top], [right, top]);
    canvas.line("grid", [left, bottom], [right, bottom]);
    let label = |n: f64| Figure::new(n, lane.unit.as_str()).to_string();
    if high > low {
        canvas.text("small end", left - 6.0, top + 8.0, &label(high));
        canvas.text("small end", left - 6.0, bottom, &label(low));
    } else {
        canvas.text("small end", left - 6.0, (top + bottom) / 2.0 + 4.0, &label(low));
    }
    // Recorded values hold until the next one: steps, not slopes.
    let mut path = String::new();
    let mut pen: Option<[f64; 2]> = before.and_then(|p| number(&p)).map(|n| [left, scale(n)]);
    if let Some([x, y]) = pen {
        path.push_str(&format!("M{} {}", px(x), px(y)));
    }
    for point in inside {
        let x = axis.x(super::axis::middle(point.at));
        match (number(&point), pen) {
            (Some(n), Some([before_x, before_y])) => {
                let to = scale(n);
                if x - before_x >= 0.2 || (to - before_y).abs() >= 0.2 {
                    path.push_str(&format!("H{}V{}", px(x), px(to)));
                    pen = Some([x, to]);
                }
            }
            (Some(n), None) => {
                path.push_str(&format!("M{} {}", px(x), px(scale(n))));
                pen = Some([x, scale(n)]);
            }
            (None, Some(_)) => {
                path.push_str(&format!("H{}", px(x)));
                pen = None;
            }
            (None, None) => {}
        }
    }
    let end = lane.known_until_ns().map_or(right, |known| axis.x(known));
    if pen.is_some_and(|[x, _]| x < end) {
        path.push_str(&format!("H{}", px(end)));
    }
    canvas.path("curve", &path);
    if end < right {
        canvas.rect("unknown", end, top, right - end, bottom - top);
    }
}
