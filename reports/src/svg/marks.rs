//! What is drawn over the lanes: windows and limits of claims, deciding instants, steps, measurements.

use super::axis::{Axis, middle};
use super::{Canvas, px, text_width};
use crate::show;
use record::{CaseRecord, ClaimRecord, Verdict, Window};

/// A row of labels that do not run into each other.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    ends: Vec<f64>,
}

impl Rows {
    /// The first of at most `most` rows with room from `x` on, which is then taken for `width`.
    pub(super) fn place(&mut self, x: f64, width: f64, most: usize) -> Option<usize> {
        let free = self.ends.iter().position(|end| *end <= x);
        let row = match free {
            Some(row) => row,
            None if self.ends.len() < most => {
                self.ends.push(f64::MIN);
                self.ends.len() - 1
            }
            None => return None,
        };
        self.ends[row] = x + width;
        Some(row)
    }

    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }
}

/// A label over the lanes with a line down through them.
#[derive(Clone, Debug)]
pub(super) struct Flag {
    pub(super) x: f64,
    pub(super) label: String,
    /// Row of the label; none when there was no room for it.
    pub(super) row: Option<usize>,
}

/// The steps in view, and the anchors `start` and `end`.
pub(super) fn step_flags(case: &CaseRecord, axis: &Axis, rows: &mut Rows) -> Vec<Flag> {
    let anchors = [("start", case.start_ns), ("end", case.end_ns)].map(|(id, t)| (id.to_owned(), t));
    let steps = case.steps.iter().filter(|s| s.id != "start" && s.id != "end");
    let steps = steps.filter_map(|s| s.at_ns.map(|at| (s.id.clone(), middle(at))));
    let mut all: Vec<(String, i64)> =
        anchors.into_iter().chain(steps).filter(|(_, t)| axis.shows(*t)).collect();
    all.sort_by_key(|(_, t)| *t);
    let right = axis.last().x1;
    let flag = |(label, t): (String, i64)| {
        let (x, width) = (axis.x(t), text_width(&label) + 14.0);
        // A label at the right edge stands to the left of its line.
        let from = if x + width > right { x - width } else { x };
        Flag { x, row: rows.place(from, width, 3), label }
    };
    all.into_iter().map(flag).collect()
}

/// Draws a step's label and its line down to `bottom`.
pub(super) fn draw_step(canvas: &mut Canvas, axis: &Axis, flag: &Flag, top: f64, bottom: f64) {
    let y = top + 16.0 * flag.row.unwrap_or(0) as f64;
    canvas.line("step", [flag.x, y + 3.0], [flag.x, bottom]);
    let (x, y0) = (flag.x, y + 3.0);
    canvas.path("flag", &format!("M{} {}l7 4l-7 4Z", px(x), px(y0)));
    if flag.row.is_some() {
        if x + text_width(&flag.label) + 14.0 > axis.last().x1 {
            canvas.text("label end", x - 4.0, y + 11.0, &flag.label);
        } else {
            canvas.text("label", x + 10.0, y + 11.0, &flag.label);
        }
    }
}

/// The class of a verdict's colour.
pub(super) fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::None => "v-none",
        Verdict::Pass => "v-pass",
        Verdict::Inconclusive => "v-inconclusive",
        Verdict::Fail => "v-fail",
        Verdict::Error => "v-error",
    }
}

/// Shades a claim's window and the limits in it, in the lane between `top` and `bottom`.
pub(super) fn draw_window(canvas: &mut Canvas, axis: &Axis, claim: &ClaimRecord, top: f64, bottom: f64) {
    let Some(Window { from_ns, until_ns, limit_from_ns, limit_until_ns }) = claim.window else { return };
    if !axis.overlaps(from_ns[0], until_ns[1]) && limit_from_ns.is_none() {
        return;
    }
    let (class, height) = (class(claim.verdict), bottom - top);
    let x = |t: i64| axis.x(t);
    let (from, until) = ([x(from_ns[0]), x(from_ns[1])], [x(until_ns[0]), x(until_ns[1])]);
    canvas.rect(&format!("window {class}"), from[0], top, until[1] - from[0], height);
    for [a, b] in [from, until] {
        if b - a >= 1.5 {
            canvas.rect("uncertain", a, top, b - a, height);
        }
    }
    if limit_from_ns.is_none() && limit_until_ns.is_none() {
        return;
    }
    let (a, b) = (limit_from_ns.map_or(from[0], x), limit_until_ns.map_or(until[1], x));
    canvas.rect(&format!("limit {class}"), a, top, (b - a).max(1.0), height);
    for (place, given) in [(a, limit_from_ns), (b, limit_until_ns)] {
        if given.is_some_and(|t| axis.shows(t)) {
            canvas.line(&format!("bound {class}"), [place, top], [place, bottom]);
        }
    }
}

/// Where a claim's number stands: at its limits, else where it was decided, else where its window begins.
pub(super) fn tag_place(axis: &Axis, claim: &ClaimRecord) -> Option<f64> {
    let window = claim.window;
    let limit = window.and_then(|w| w.limit_from_ns.or(w.limit_until_ns));
    let decided = claim.deciding_ns.map(middle).filter(|t| axis.shows(*t));
    let begin = window.filter(|w| axis.overlaps(w.from_ns[0], w.until_ns[1])).map(|w| middle(w.from_ns));
    limit.filter(|t| axis.shows(*t)).or(decided).or(begin).map(|t| axis.x(t))
}

/// Draws a claim's number with its sign, linked to its row of the table.
pub(super) fn draw_tag(canvas: &mut Canvas, case: usize, number: usize, verdict: Verdict, x: f64, y: f64) {
    let text = format!("{number} {}", show::sign(verdict));
    let (width, class) = (tag_width(number), class(verdict));
    canvas.raw(format_args!(r##"<a href="#c{case}-{number}">"##));
    canvas.raw(format_args!(
        r#"<rect class="tag {class}" x="{}" y="{}" width="{}" height="14" rx="3"/>"#,
        px(x),
        px(y),
        px(width)
    ));
    canvas.text(&format!("tagtext mid {class}"), x + width / 2.0, y + 10.7, &text);
    canvas.raw(format_args!("</a>"));
}

pub(super) fn tag_width(number: usize) -> f64 {
    text_width(&format!("{number} x")) + 8.0
}

/// The instants at which claims that did not pass were decided.
pub(super) fn deciding_flags(case: &CaseRecord, axis: &Axis, rows: &mut Rows) -> Vec<(Flag, usize)> {
    let mut flags = Vec::new();
    let mut bad: Vec<(usize, &ClaimRecord, [i64; 2])> = case
        .claims
        .iter()
        .enumerate()
        .filter(|(_, c)| c.verdict >= Verdict::Inconclusive)
        .filter_map(|(place, c)| c.deciding_ns.map(|at| (place, c, at)))
        .filter(|(.., at)| axis.shows(middle(*at)))
        .collect();
    bad.sort_by_key(|(.., at)| middle(*at));
    for (place, claim, at) in bad {
        let label =
            format!("{} {}  {}", place + 1, show::sign(claim.verdict), show::relative(at, case.start_ns));
        let (x, width) = (axis.x(middle(at)), text_width(&label) + 16.0);
        let from = label_left(axis, x, width);
        flags.push((Flag { x, row: rows.place(from, width, 4), label }, place));
    }
    flags
}

/// The left edge of a label centred at `x`, held inside the axis.
fn label_left(axis: &Axis, x: f64, width: f64) -> f64 {
    (x - width / 2.0).min(axis.last().x1 - width).max(axis.first().x0)
}

/// Draws the line of a deciding instant, its interval, and its label.
pub(super) fn draw_deciding(
    canvas: &mut Canvas,
    axis: &Axis,
    claim: &ClaimRecord,
    flag: &Flag,
    (top, lanes, bottom): (f64, f64, f64),
) {
    let class = class(claim.verdict);
    if let Some([earliest, latest]) = claim.deciding_ns {
        let (a, b) = (axis.x(earliest), axis.x(latest));
        if b - a >= 1.5 {
            canvas.rect("uncertain", a, lanes, b - a, bottom - lanes);
        }
    }
    let y = top + 18.0 * flag.row.unwrap_or(0) as f64;
    canvas.line(&format!("deciding {class}"), [flag.x, y + 14.0], [flag.x, bottom]);
    if flag.row.is_some() {
        let width = text_width(&flag.label) + 10.0;
        let left = label_left(axis, flag.x, width);
        canvas.raw(format_args!(
            r#"<rect class="tag {class}" x="{}" y="{}" width="{}" height="15" rx="3"/>"#,
            px(left),
            px(y),
            px(width)
        ));
        canvas.text(&format!("tagtext mid {class}"), left + width / 2.0, y + 11.3, &flag.label);
    }
}

/// Measurements between two instants in view, as dimension lines from `top` down; returns the height used.
pub(super) fn draw_measurements(canvas: &mut Canvas, case: &CaseRecord, axis: &Axis, top: f64) -> f64 {
    let mut y = top;
    let between = case.measurements.iter().filter_map(|m| Some((m, middle(m.from_ns?), middle(m.to_ns?))));
    for (m, from, to) in between.filter(|(_, f, t)| f != t && axis.overlaps(*f.min(t), *f.max(t))).take(6) {
        let (a, b) = (axis.x(from.min(to)), axis.x(from.max(to)));
        let mid = y + 9.0;
        let class = class(m.verdict);
        canvas.line(&format!("dimension {class}"), [a, mid], [b, mid]);
        let (left, right, up, down) = (px(a), px(b), px(mid - 4.0), px(mid + 4.0));
        canvas.path(&format!("dimension {class}"), &format!("M{left} {up}V{down}M{right} {up}V{down}"));
        let text = format!("{} {} = {}", show::sign(m.verdict), m.name, show::value(m));
        if b + text_width(&text) + 8.0 < axis.last().x1 {
            canvas.text("label", b + 6.0, mid + 4.0, &text);
        } else if a - text_width(&text) - 8.0 > axis.first().x0 {
            canvas.text("label end", a - 6.0, mid + 4.0, &text);
        } else {
            y += 13.0;
            canvas.text("label mid", (a + b) / 2.0, mid + 15.0, &text);
        }
        y += 18.0;
    }
    y - top
}

/// Blank strips over the lanes where the axis is broken, with the time that is left out below the ticks.
pub(super) fn draw_breaks(canvas: &mut Canvas, axis: &Axis, top: f64, bottom: f64) {
    for pair in axis.pieces.windows(2) {
        let (a, b) = (pair[0].x1, pair[1].x0);
        canvas.rect("break", a + 2.0, top, b - a - 4.0, bottom - top);
        let mut wave = String::new();
        for x in [a + 2.0, b - 2.0] {
            wave.push_str(&format!("M{} {}", px(x), px(top)));
            let mut y = top;
            let mut side = 4.0;
            while y < bottom {
                let step = (bottom - y).min(10.0);
                wave.push_str(&format!("q{} {} 0 {}", px(side), px(step / 2.0), px(step)));
                side = -side;
                y += step;
            }
        }
        canvas.path("wave", &wave);
        let left_out = show::rounded(pair[1].t0.saturating_sub(pair[0].t1));
        canvas.text("small mid", (a + b) / 2.0, bottom + 28.0, &format!("{left_out} left out"));
    }
}
