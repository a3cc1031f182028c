//! The trend on the screen.

use super::figures::TrendFigures;
use super::lane::{self, LaneWindow};
use super::store::TrendLine;
use super::{TrendCursor, TrendView};
use crate::canvas::{self, Canvas};
use crate::show;
use control::{SignalKind, Value, WireValue};
use ratatui::style::Style;

/// Columns of names and values on the left.
const GUTTER: u16 = 24;

/// From this height on figures of all lines are shown, else of the chosen one.
const TALL: u16 = 36;

/// Draws all of it.
pub fn draw(trend: &mut TrendView, canvas: &mut Canvas<'_>) {
    let (window, fired) = trend.current();
    trend.window = window;
    draw_head(trend, canvas);
    let lines = trend.seen().lines.len();
    if lines == 0 {
        canvas.text(1, 2, "No signals yet. i: choose some.   o: look at a file.", Style::new());
        trend.lanes.clear();
        return;
    }
    trend.chosen = trend.chosen.min(lines - 1);
    let below = if canvas.height() >= TALL { lines as u16 + 3 } else { 2 };
    // The head, the axis, and what is below.
    let height = canvas.height().saturating_sub(2 + below.min(canvas.height() / 2));
    let width = canvas.width().saturating_sub(GUTTER);
    let (rows, between) = lane::heights(&trend.seen().lines, height);
    let gap = u16::from(between);
    // The chosen line is among those that are shown.
    trend.first = trend.first.min(trend.chosen);
    while trend.first < trend.chosen
        && rows[trend.first..=trend.chosen].iter().map(|row| row + gap).sum::<u16>() > height + gap
    {
        trend.first += 1;
    }
    trend.plot = canvas.part(GUTTER, 1, width, height).area();
    let mut lanes = Vec::new();
    let mut y = 1;
    for (place, tall) in rows.iter().enumerate().skip(trend.first) {
        if y + tall > height + 1 {
            break;
        }
        let line = &trend.seen().lines[place];
        let scale = lane::draw(&mut canvas.part(GUTTER, y, width, *tall), line, window);
        draw_gutter(trend, canvas, place, (y, *tall), scale);
        lanes.push((canvas.part(0, y, canvas.width(), *tall).area(), place));
        y += tall + gap;
    }
    trend.lanes = lanes;
    let uprights = [(trend.cursors[0].map(|mark| mark.at), 'A'), (trend.cursors[1].map(|mark| mark.at), 'B')];
    draw_axis(&mut canvas.part(GUTTER, height + 1, width, 1), window);
    for (at, name) in uprights.into_iter().chain([(fired, 'T')]) {
        let Some(at) = at.filter(|at| (window.0..=window.1).contains(at)) else { continue };
        let share = at.saturating_sub(window.0) as f64 / window.1.saturating_sub(window.0).max(1) as f64;
        let column = GUTTER + ((share * f64::from(width)) as u16).min(width.saturating_sub(1));
        for y in 1..=height {
            if canvas.is_empty(column, y) {
                let upright = if canvas.features.utf8 { '┊' } else { ':' };
                canvas.glyph(column, y, upright, canvas.dim());
            }
        }
        canvas.glyph(column, height + 1, name, canvas::chosen());
    }
    draw_readout(trend, &mut canvas.part(0, height + 2, canvas.width(), below));
}

/// What the window is, and what holds it.
fn draw_head(trend: &TrendView, canvas: &mut Canvas<'_>) {
    let (word, style) = match (&trend.file, trend.held) {
        (Some(_), _) => ("FILE", canvas::bold()),
        (None, Some(_)) => ("HELD", canvas::chosen()),
        (None, None) if trend.fired().is_some() => ("TRIG", canvas::chosen()),
        (None, None) => ("LIVE", canvas.good().patch(canvas::bold())),
    };
    let mut x = canvas.text(1, 0, word, style) + 2;
    x = canvas.text(x, 0, &format!("window {}", show::span(trend.base())), Style::new()) + 2;
    if let Some((path, _)) = &trend.file {
        canvas.text(x, 0, &format!("{path}   c: back to the rig"), Style::new());
        return;
    }
    let state = super::state(trend);
    if !state.is_empty() {
        x = canvas.text(x, 0, &format!("trigger {}, {state}", trend.trigger.mode.label()), Style::new()) + 2;
    }
    if trend.missed > 0 {
        canvas.text(x, 0, &format!("!! {} changes were not sent", trend.missed), canvas.alarm());
    }
}

/// A line's name, value and scale.
fn draw_gutter(
    trend: &TrendView,
    canvas: &mut Canvas<'_>,
    place: usize,
    (y, tall): (u16, u16),
    scale: Option<(f64, f64)>,
) {
    let line = &trend.seen().lines[place];
    let at = trend.moving.and_then(|mark| trend.cursors[mark]).map_or(trend.window.1, |mark| mark.at);
    let value = text_of(line, line.at(at.min(trend.seen().now)));
    let chosen = place == trend.chosen;
    if chosen {
        canvas.glyph(0, y, '>', canvas::bold());
    }
    let style = if chosen { canvas::bold() } else { Style::new() };
    if tall == 1 {
        let room = GUTTER - 2 - (value.chars().count() as u16).min(GUTTER - 8);
        canvas.text_in(1, y, room, &line.track.name, style);
        canvas.right(GUTTER - 1, y, &value, Style::new());
        return;
    }
    let dim = canvas.dim();
    canvas.text_in(1, y, GUTTER - 10, &line.track.name, style);
    if let Some((low, high)) = scale {
        canvas.right(GUTTER - 1, y, &show::real(high, 4), dim);
        canvas.right(GUTTER - 1, y + tall - 1, &show::real(low, 4), dim);
    }
    canvas.text_in(2, y + 1, GUTTER - 3, &value, Style::new());
}

/// A value with its unit.
fn text_of(line: &TrendLine, value: Value) -> String {
    show::with_unit(WireValue(value), &line.track.labels, &line.track.unit)
}

/// Instants below the plot, in seconds since the rig began.
fn draw_axis(canvas: &mut Canvas<'_>, (from, to): LaneWindow) {
    let base = to.saturating_sub(from).max(1);
    let width = i64::from(canvas.width().max(1));
    let line = if canvas.features.utf8 { '─' } else { '-' };
    for x in 0..canvas.width() {
        canvas.glyph(x, 0, line, canvas.dim());
    }
    // A tick every 14 columns or more, at a round instant.
    let least = base.saturating_mul(14) / width;
    let powers = std::iter::successors(Some(1_i64), |power| power.checked_mul(10));
    let mut steps = powers.flat_map(|power| [1, 2, 5].map(|n| power.saturating_mul(n)));
    let Some(step) = steps.find(|step| *step >= least.max(1)) else { return };
    let places = 9_usize.saturating_sub(step.ilog10() as usize);
    let first =
        from.div_euclid(step).saturating_add(i64::from(from.rem_euclid(step) > 0)).saturating_mul(step);
    for tick in
        std::iter::successors(Some(first), |tick| tick.checked_add(step)).take_while(|tick| *tick <= to)
    {
        let x = (i128::from(tick - from) * i128::from(width) / i128::from(base)) as u16;
        let x = x.min(canvas.width().saturating_sub(1));
        canvas.glyph(x, 0, if canvas.features.utf8 { '┴' } else { '+' }, Style::new());
        let text = format!("{} s", show::seconds(tick, places));
        // A part of a number would be another number.
        if usize::from(canvas.width() - x) > text.len() {
            canvas.text(x + 1, 0, &text, Style::new());
        }
    }
}

/// The cursors, and what lies between them.
fn draw_readout(trend: &TrendView, canvas: &mut Canvas<'_>) {
    let [a, b] = trend.cursors;
    let mut x = 1;
    for (name, mark) in [("A", a), ("B", b)] {
        if let Some(mark) = mark {
            x = canvas.text(x, 0, &format!("{name} {} s", show::seconds(mark.at, 9)), Style::new()) + 3;
        }
    }
    if let (Some(a), Some(b)) = (a, b) {
        let between = b.at.saturating_sub(a.at);
        x = canvas.text(
            x,
            0,
            &format!("B-A {}{}", control::Span::from_nanos(between), uncertain(a, b)),
            canvas::bold(),
        ) + 3;
        if between != 0 {
            let rate = 1e9 / between.unsigned_abs() as f64;
            canvas.text(x, 0, &format!("1/(B-A) {} Hz", show::real(rate, 6)), Style::new());
        }
    } else if trend.cursors == [None, None] {
        let dim = canvas.dim();
        canvas.text(1, 0, "a, b: cursors; e: next edge.  Figures below are of the window.", dim);
    }
    let lines = &trend.seen().lines;
    if canvas.height() > 2 {
        for (row, line) in lines.iter().enumerate() {
            let style = if row == trend.chosen { canvas::bold() } else { Style::new() };
            draw_figures(trend, canvas, row as u16 + 2, line, style);
        }
    } else if let Some(line) = lines.get(trend.chosen) {
        draw_figures(trend, canvas, 1, line, Style::new());
    }
}

/// How far the distance of two cursors may be wrong.
fn uncertain(a: TrendCursor, b: TrendCursor) -> String {
    // Each stands on the latest instant of its change.
    let width = a.width.max(b.width);
    if width > 0 { format!(" +-{}", show::span(width)) } else { String::new() }
}

/// Figures of a line: at the cursors, and between them or in the window.
fn draw_figures(trend: &TrendView, canvas: &mut Canvas<'_>, y: u16, line: &TrendLine, style: Style) {
    let [a, b] = trend.cursors;
    let now = trend.seen().now;
    let (from, to) = match (a, b) {
        (Some(a), Some(b)) => (a.at.min(b.at), a.at.max(b.at)),
        _ => (trend.window.0, trend.window.1.min(now)),
    };
    let figures = TrendFigures::of(line, from, to);
    let mut parts = Vec::new();
    for (name, mark) in [("A", a), ("B", b)] {
        if let Some(mark) = mark {
            parts.push(format!("{name} {}", text_of(line, line.at(mark.at))));
        }
    }
    let number = |number: f64| show::real(number, 5);
    match line.track.kind {
        SignalKind::Bool => {
            parts.push(format!("rises {} falls {}", figures.rises, figures.falls));
            if let Some(mean) = figures.mean {
                parts.push(format!("TRUE {} %", show::real(mean * 100.0, 4)));
            }
        }
        SignalKind::State => {}
        _ => {
            if let (Some(a), Some(b)) = (a, b)
                && let (Some(from), Some(to)) = (line.at(a.at).as_real(), line.at(b.at).as_real())
            {
                parts.push(format!("B-A {}", number(to - from)));
            }
            if let Some((low, high)) = figures.range {
                parts.push(format!("min {} max {}", number(low), number(high)));
            }
            if let Some(mean) = figures.mean {
                parts.push(format!("mean {}", number(mean)));
            }
        }
    }
    canvas.text_in(1, y, 16, &line.track.name, style);
    canvas.text(18, y, &parts.join("  "), style);
}
