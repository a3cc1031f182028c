//! The timing diagram of a case.

use super::axis::{Axis, middle};
use super::marks::{self, Rows};
use super::{Canvas, escape, fit, lanes, px};
use crate::show;
use record::{CaseRecord, ClaimRecord, Lane, LaneKind, Verdict};

const WIDTH: f64 = 1_160.0;
const RIGHT: f64 = WIDTH - 14.0;
/// Width of an analog lane's scale.
const SCALE: f64 = 60.0;
/// The most lanes drawn; those that claims look at come first.
const LANES: usize = 24;

/// The diagram as an `svg` element, or nothing when the case has no lanes. `number` makes its IDs unique in
/// the page.
pub(crate) fn diagram(case: &CaseRecord, number: usize) -> Option<String> {
    let chosen = chosen(case);
    if chosen.is_empty() {
        return None;
    }
    let axis = Axis::of(case, gutter(&chosen), RIGHT);
    let mut step_rows = Rows::default();
    let steps = marks::step_flags(case, &axis, &mut step_rows);
    let mut deciding_rows = Rows::default();
    let deciding = marks::deciding_flags(case, &axis, &mut deciding_rows);
    let deciding_top = 2.0 + 16.0 * step_rows.len().max(1) as f64;
    let lanes_top = deciding_top + 18.0 * deciding_rows.len() as f64 + 4.0;

    let mut body = Canvas::default();
    let mut over = Canvas::default();
    let mut y = lanes_top;
    for lane in &chosen {
        y += draw_lane(&mut body, &mut over, case, &axis, number, lane, y);
    }
    let bottom = y;
    let mut ground = Canvas::default();
    for piece in &axis.pieces {
        for tick in piece.ticks(case.start_ns) {
            ground.line("grid", [tick.x, lanes_top], [tick.x, bottom]);
            let half = super::text_width(&tick.label) / 2.0;
            // A label that would run into a break or out of the picture is left out; its line stays.
            if tick.x + half <= piece.x1 + 14.0 && tick.x - half >= piece.x0 - 14.0 {
                ground.text("small mid", tick.x, bottom + 15.0, &tick.label);
            }
        }
        ground.line("axis", [piece.x0, bottom], [piece.x1, bottom]);
    }
    ground.text("small", 0.0, bottom + 15.0, "time from start");
    marks::draw_breaks(&mut over, &axis, lanes_top, bottom);
    for flag in &steps {
        marks::draw_step(&mut over, &axis, flag, 2.0, bottom);
    }
    for (flag, place) in &deciding {
        marks::draw_deciding(&mut over, &axis, &case.claims[*place], flag, (deciding_top, lanes_top, bottom));
    }
    let below = bottom + if axis.pieces.len() > 1 { 34.0 } else { 22.0 };
    let height = below + 2.0 + marks::draw_measurements(&mut over, case, &axis, below);

    let pieces: Vec<String> = axis.pieces.iter().map(|p| cursor_piece(p, case.start_ns)).collect();
    let mut out = Canvas::default();
    let (width, height, top, bottom) = (px(WIDTH), px(height), px(lanes_top), px(bottom));
    out.raw(format_args!(
        r#"<svg class="diagram" viewBox="0 0 {width} {height}" role="img" aria-labelledby="d{number}-t d{number}-d" data-pieces="{}" data-top="{top}" data-bottom="{bottom}">"#,
        pieces.join(";")
    ));
    out.raw(format_args!(r#"<title id="d{number}-t">Timing diagram of {}</title>"#, escape(&case.name)));
    out.raw(format_args!(r#"<desc id="d{number}-d">{}</desc>"#, escape(&described(case, &chosen))));
    out.0.push_str(&ground.0);
    out.0.push_str(&body.0);
    out.0.push_str(&over.0);
    out.0.push_str("</svg>");
    Some(out.0)
}

/// The lanes in the record's order; those with claims first where there are too many to draw.
fn chosen(case: &CaseRecord) -> Vec<&Lane> {
    if case.lanes.len() <= LANES {
        return case.lanes.iter().collect();
    }
    let claimed =
        |lane: &&Lane| case.claims.iter().any(|c| c.signal.as_deref() == Some(lane.signal.as_str()));
    let (with, without): (Vec<&Lane>, Vec<&Lane>) = case.lanes.iter().partition(claimed);
    with.into_iter().chain(without).take(LANES).collect()
}

/// Room for the names to the left of the lanes, and for the scale of an analog lane beside its name.
fn gutter(lanes: &[&Lane]) -> f64 {
    let room =
        |lane: &&Lane| name_width(&lane.signal) + if lane.kind == LaneKind::Analog { SCALE } else { 0.0 };
    lanes.iter().map(room).fold(100.0, f64::max).min(250.0) + 8.0
}

/// Names are set a little larger than other texts.
fn name_width(name: &str) -> f64 {
    super::text_width(name) * 1.12
}

/// Draws one lane from `y` down and returns the height used: tags, then the signal.
fn draw_lane(
    body: &mut Canvas,
    over: &mut Canvas,
    case: &CaseRecord,
    axis: &Axis,
    number: usize,
    lane: &Lane,
    y: f64,
) -> f64 {
    let on_lane = |c: &&(usize, &ClaimRecord)| c.1.signal.as_deref() == Some(lane.signal.as_str());
    let all: Vec<(usize, &ClaimRecord)> = case.claims.iter().enumerate().collect();
    let claims: Vec<(usize, &ClaimRecord)> = all.iter().filter(on_lane).copied().collect();
    let mut tags: Vec<(f64, usize, Verdict)> = Vec::new();
    for (place, claim) in &claims {
        tags.extend(marks::tag_place(axis, claim).map(|x| (x, place + 1, claim.verdict)));
    }
    tags.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut rows = Rows::default();
    let mut placed = Vec::new();
    for (x, tag, verdict) in tags {
        let width = marks::tag_width(tag) + 2.0;
        let x = x.min(RIGHT - width);
        if let Some(row) = rows.place(x, width, 3) {
            placed.push((x, row, tag, verdict));
        }
    }
    let top = y + 4.0 + 16.0 * rows.len() as f64;
    let bottom = top + lanes::height(lane);
    for (_, claim) in &claims {
        marks::draw_window(body, axis, claim, top, bottom);
    }
    lanes::draw(body, axis, lane, top);
    for (x, row, tag, verdict) in placed {
        marks::draw_tag(over, number, tag, verdict, x, y + 3.0 + 16.0 * row as f64);
    }
    for (_, claim) in claims.iter().filter(|(_, c)| c.verdict < Verdict::Inconclusive) {
        if let Some(at) = claim.deciding_ns.map(middle).filter(|t| axis.shows(*t)) {
            let (x, y) = (px(axis.x(at)), px(top + 11.0));
            over.raw(format_args!(
                r#"<circle class="dot {}" cx="{x}" cy="{y}" r="3.2"/>"#,
                marks::class(claim.verdict)
            ));
        }
    }
    let (x, base) = (px(0.0), px(top + lanes::height(lane) / 2.0 + 4.0));
    let scale = if lane.kind == LaneKind::Analog { SCALE } else { 0.0 };
    let room = (axis.first().x0 - 8.0 - scale) / 1.12;
    body.raw(format_args!(
        r#"<text class="name" x="{x}" y="{base}"><title>{}</title>{}</text>"#,
        escape(&lane.signal),
        escape(&fit(&lane.signal, room))
    ));
    bottom + 4.0 - y
}

/// A stretch of the axis for the cursor's script: two instants from start in nanoseconds, two places.
fn cursor_piece(piece: &super::axis::Piece, origin: i64) -> String {
    let (t0, t1) = (piece.t0.saturating_sub(origin), piece.t1.saturating_sub(origin));
    format!("{t0},{t1},{},{}", px(piece.x0), px(piece.x1))
}

/// The diagram in words, for those who cannot see it.
fn described(case: &CaseRecord, lanes: &[&Lane]) -> String {
    let names: Vec<&str> = lanes.iter().map(|lane| lane.signal.as_str()).collect();
    let mut text = format!("Signals: {}.", names.join(", "));
    for (place, claim) in case.claims.iter().enumerate().filter(|(_, c)| c.verdict >= Verdict::Inconclusive) {
        text.push_str(&format!(" Claim {} ({}): {}", place + 1, claim.verdict, claim.name));
        if let Some(at) = claim.deciding_ns {
            text.push_str(&format!(" at {} from start", show::relative(at, case.start_ns)));
        }
        text.push('.');
    }
    let left_out = case.lanes.len() - lanes.len();
    if left_out > 0 {
        text.push_str(&format!(" {left_out} more signals are not drawn."));
    }
    text
}
