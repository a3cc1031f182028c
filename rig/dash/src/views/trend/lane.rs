//! A line's lane: levels and states in one row, numbers as a curve.

use super::figures::{Bin, bins};
use super::store::TrendLine;
use crate::canvas::{self, Canvas};
use crate::show;
use control::{SignalKind, Value, WireValue};
use ratatui::style::Style;

/// What is shown of time: from, to, nanoseconds.
pub type LaneWindow = (i64, i64);

/// The least rows of a curve.
const CURVE: u16 = 3;

/// Whether a line is drawn as a curve.
pub fn curved(line: &TrendLine) -> bool {
    !matches!(line.track.kind, SignalKind::Bool | SignalKind::State)
}

/// Rows of each line from `first` on, as far as they fit into `height`, and whether rows lie between them.
pub fn heights(lines: &[TrendLine], height: u16) -> (Vec<u16>, bool) {
    let curves = lines.iter().filter(|line| curved(line)).count() as u16;
    let flat = lines.len() as u16 - curves;
    for between in [1, 0] {
        let taken = flat + (flat + curves) * between;
        let each = height.saturating_sub(taken).checked_div(curves).unwrap_or(CURVE);
        if (each >= CURVE && taken <= height) || between == 0 {
            let each = each.max(CURVE);
            let rows = lines.iter().map(|line| if curved(line) { each } else { 1 }).collect();
            return (rows, between == 1);
        }
    }
    (Vec::new(), false)
}

/// Draws a line into its lane.
pub fn draw(canvas: &mut Canvas<'_>, line: &TrendLine, window: LaneWindow) -> Option<(f64, f64)> {
    match line.track.kind {
        SignalKind::Bool => draw_levels(canvas, line, window),
        SignalKind::State => draw_states(canvas, line, window),
        _ => return draw_curve(canvas, line, window),
    }
    None
}

fn draw_levels(canvas: &mut Canvas<'_>, line: &TrendLine, (from, to): LaneWindow) {
    let width = usize::from(canvas.width());
    let [high, low, both, open] =
        if canvas.features.utf8 { ['▀', '▁', '│', '╌'] } else { ['"', '_', '|', '~'] };
    for (x, bin) in bins(line, from, to, width).iter().enumerate() {
        let glyph = match (bin.range, bin.high_z) {
            (Some((low, high)), open) if low != high || open => both,
            (Some((0.0, _)), _) => low,
            (Some(_), _) => high,
            (None, true) => open,
            (None, false) => continue,
        };
        let style = if glyph == low { canvas.dim() } else { canvas.good() };
        canvas.glyph(x as u16, 0, glyph, style);
    }
}

fn draw_states(canvas: &mut Canvas<'_>, line: &TrendLine, (from, to): LaneWindow) {
    let width = usize::from(canvas.width());
    let [edge, fill] = if canvas.features.utf8 { ['│', '╌'] } else { ['|', '-'] };
    let bins = bins(line, from, to, width);
    let mut x = 0;
    while x < width {
        // A piece without a change in it: the name of the value at its beginning, as far as there is room.
        let end = (x + 1..width).find(|x| bins[*x].changes > 0).unwrap_or(width);
        let at = from.saturating_add(span_of((from, to), x as u16 + 1, width as u16)) - 1;
        let value = line.at(at);
        if value != Value::Unknown {
            for column in x..end {
                canvas.glyph(column as u16, 0, fill, canvas.dim());
            }
            let text = show::value(WireValue(value), &line.track.labels);
            canvas.text_in(x as u16 + 1, 0, (end - x - 1) as u16, &text, Style::new());
        }
        if bins[x].changes > 0 {
            canvas.glyph(x as u16, 0, edge, canvas::bold());
        }
        x = end;
    }
}

/// The time from the beginning of a window to the left edge of a column.
pub fn span_of((from, to): LaneWindow, column: u16, width: u16) -> i64 {
    let base = i128::from(to.saturating_sub(from));
    (base * i128::from(column) / i128::from(width.max(1))) as i64
}

/// The numbers at the bottom and the top of a curve.
fn scale_of(line: &TrendLine, bins: &[Bin]) -> Option<(f64, f64)> {
    if line.scale.is_some() {
        return line.scale;
    }
    let ranges = bins.iter().filter_map(|bin| bin.range);
    let (low, high) = ranges.reduce(|(low, high), (from, to)| (low.min(from), high.max(to)))?;
    if low < high {
        return Some((low, high));
    }
    // A number that does not change lies in the middle.
    let around = if low == 0.0 { 1.0 } else { low.abs() / 2.0 };
    Some((low - around, high + around))
}

fn draw_curve(canvas: &mut Canvas<'_>, line: &TrendLine, (from, to): LaneWindow) -> Option<(f64, f64)> {
    let (width, height) = (usize::from(canvas.width()), usize::from(canvas.height()));
    if width == 0 || height == 0 {
        return line.scale;
    }
    let bins = bins(line, from, to, width * 2);
    let scale = scale_of(line, &bins)?;
    let (across, up) = if canvas.features.utf8 { (2, 4) } else { (1, 3) };
    let dots = height * up;
    // Rows of dots from the top.
    let row = |number: f64| {
        let share = ((number - scale.0) / (scale.1 - scale.0)).clamp(0.0, 1.0);
        dots - 1 - (share * (dots - 1) as f64).round() as usize
    };
    let style = canvas.tint(ratatui::style::Color::Cyan);
    for x in 0..width {
        let parts: Vec<Option<(usize, usize)>> = bins[x * 2..x * 2 + 2]
            .chunks(2 / across)
            .map(|part| {
                let ranges = part.iter().filter_map(|bin| bin.range);
                let range = ranges.reduce(|(low, high), (from, to)| (low.min(from), high.max(to)));
                // What lies beyond a scale that the user gave is drawn at its edge.
                range.map(|(low, high)| (row(high), row(low)))
            })
            .collect();
        for y in 0..height {
            let (top, bottom) = (y * up, y * up + up - 1);
            let glyph = if across == 2 { braille(&parts, top) } else { letter(parts[0], top, bottom) };
            if let Some(glyph) = glyph {
                canvas.glyph(x as u16, y as u16, glyph, style);
            }
        }
    }
    Some(scale)
}

/// The braille character of two columns of four dots.
fn braille(parts: &[Option<(usize, usize)>], top: usize) -> Option<char> {
    /// Bits of the dots from the top, left and right.
    const DOTS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];
    let mut bits = 0;
    for (column, part) in DOTS.iter().zip(parts) {
        for (dot, bit) in column.iter().enumerate() {
            if part.is_some_and(|(high, low)| (high..=low).contains(&(top + dot))) {
                bits |= bit;
            }
        }
    }
    if bits == 0 { None } else { char::from_u32(0x2800 + bits) }
}

/// The letter of three dots one above the other.
fn letter(part: Option<(usize, usize)>, top: usize, bottom: usize) -> Option<char> {
    let (high, low) = part?;
    if high > bottom || low < top {
        return None;
    }
    Some(match (high.max(top) - top, low.min(bottom) - top) {
        (0, 0) => '\'',
        (1, 1) => '-',
        (2, 2) => '.',
        _ => '|',
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_say_where_in_a_row() {
        assert_eq!(letter(Some((3, 3)), 3, 5), Some('\''));
        assert_eq!(letter(Some((5, 5)), 3, 5), Some('.'));
        assert_eq!(letter(Some((1, 4)), 3, 5), Some('|'));
        assert_eq!(letter(Some((6, 8)), 3, 5), None);
        assert_eq!(letter(None, 3, 5), None);
    }

    #[test]
    fn dots_are_set_from_the_top() {
        assert_eq!(braille(&[Some((0, 0)), None], 0), Some('⠁'));
        assert_eq!(braille(&[Some((4, 7)), Some((7, 7))], 4), Some('⣇'));
        assert_eq!(braille(&[None, Some((9, 9))], 4), None);
    }

    #[test]
    fn the_last_nanosecond_of_a_window_is_in_its_last_column() {
        assert_eq!(span_of((0, i64::MAX), 7, 7), i64::MAX);
        assert_eq!(span_of((10, 110), 1, 4), 25);
    }
}
