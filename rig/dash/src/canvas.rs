//! A part of the screen that can be written to without fear of its edges.

use crate::glyphs::TerminalFeatures;
use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};

/// A part of the screen. Its first column and row are 0; whatever lies outside is not drawn.
#[derive(Debug)]
pub struct Canvas<'a> {
    buffer: &'a mut Buffer,
    area: Rect,
    /// What may be drawn with.
    pub features: TerminalFeatures,
}

impl<'a> Canvas<'a> {
    /// The part of a frame.
    pub fn new(frame: &'a mut Frame<'_>, area: Rect, features: TerminalFeatures) -> Canvas<'a> {
        let buffer = frame.buffer_mut();
        let area = area.intersection(buffer.area);
        Canvas { buffer, area, features }
    }

    /// A part of this one.
    pub fn part(&mut self, x: u16, y: u16, width: u16, height: u16) -> Canvas<'_> {
        let wanted = Rect::new(self.area.x.saturating_add(x), self.area.y.saturating_add(y), width, height);
        Canvas { area: wanted.intersection(self.area), buffer: self.buffer, features: self.features }
    }

    /// Columns.
    pub fn width(&self) -> u16 {
        self.area.width
    }

    /// Rows.
    pub fn height(&self) -> u16 {
        self.area.height
    }

    /// The place on the screen.
    pub fn area(&self) -> Rect {
        self.area
    }

    /// Writes a text; the column after it.
    pub fn text(&mut self, x: u16, y: u16, text: &str, style: Style) -> u16 {
        self.text_in(x, y, self.area.width.saturating_sub(x), text, style)
    }

    /// Writes at most so many columns of a text; the column after it. What is cut off ends with `~`.
    pub fn text_in(&mut self, x: u16, y: u16, width: u16, text: &str, style: Style) -> u16 {
        let width = width.min(self.area.width.saturating_sub(x));
        if width == 0 || y >= self.area.height {
            return x;
        }
        let (left, top) = (self.area.x + x, self.area.y + y);
        let (end, _) = self.buffer.set_stringn(left, top, text, usize::from(width), style);
        let full = end == left + width;
        if full && text.chars().count() > usize::from(width) {
            self.glyph(x + width - 1, y, '~', style);
        }
        end - self.area.x
    }

    /// Writes a text that ends before a column.
    pub fn right(&mut self, end: u16, y: u16, text: &str, style: Style) {
        let length = u16::try_from(text.chars().count()).unwrap_or(u16::MAX);
        self.text_in(end.saturating_sub(length), y, length.min(end), text, style);
    }

    /// Writes one character.
    pub fn glyph(&mut self, x: u16, y: u16, glyph: char, style: Style) {
        if x < self.area.width
            && y < self.area.height
            && let Some(cell) = self.buffer.cell_mut((self.area.x + x, self.area.y + y))
        {
            cell.set_char(glyph).set_style(style);
        }
    }

    /// Whether nothing is written at a place.
    pub fn is_empty(&self, x: u16, y: u16) -> bool {
        let cell = self.buffer.cell((self.area.x + x, self.area.y + y));
        cell.is_some_and(|cell| cell.symbol() == " ")
    }

    /// Gives a row another style.
    pub fn shade(&mut self, y: u16, style: Style) {
        if y < self.area.height {
            self.buffer.set_style(Rect::new(self.area.x, self.area.y + y, self.area.width, 1), style);
        }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        for y in 0..self.area.height {
            for x in 0..self.area.width {
                if let Some(cell) = self.buffer.cell_mut((self.area.x + x, self.area.y + y)) {
                    cell.reset();
                }
            }
        }
    }

    /// A horizontal line with a title.
    pub fn rule(&mut self, y: u16, title: &str) {
        let line = if self.features.utf8 { '─' } else { '-' };
        for x in 0..self.area.width {
            self.glyph(x, y, line, self.dim());
        }
        if !title.is_empty() {
            self.text(2, y, &format!(" {title} "), bold());
        }
    }

    /// A frame around it, with a title; the part inside.
    pub fn framed(&mut self, title: &str) -> Canvas<'_> {
        let (right, bottom) = (self.width().saturating_sub(1), self.height().saturating_sub(1));
        let [flat, upright, corners @ ..] = if self.features.utf8 {
            ['─', '│', '┌', '┐', '└', '┘']
        } else {
            ['-', '|', '+', '+', '+', '+']
        };
        for x in 1..right {
            self.glyph(x, 0, flat, Style::new());
            self.glyph(x, bottom, flat, Style::new());
        }
        for y in 1..bottom {
            self.glyph(0, y, upright, Style::new());
            self.glyph(right, y, upright, Style::new());
        }
        for (corner, (x, y)) in corners.into_iter().zip([(0, 0), (right, 0), (0, bottom), (right, bottom)]) {
            self.glyph(x, y, corner, Style::new());
        }
        self.text_in(2, 0, right.saturating_sub(3), &format!(" {title} "), bold());
        self.part(1, 1, right.saturating_sub(1), bottom.saturating_sub(1))
    }

    /// A bar of a share of its width, with a mark where a limit lies.
    pub fn bar(&mut self, x: u16, y: u16, width: u16, share: f64, limit: Option<f64>, style: Style) {
        const EIGHTHS: [char; 8] = [' ', '▏', '▎', '▍', '▌', '▋', '▊', '▉'];
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
        let eighths = (share * f64::from(width) * 8.0).round() as u32;
        let (full, rest) = (eighths / 8, eighths as usize % 8);
        for column in 0..width {
            let glyph = match (u32::from(column).cmp(&full), self.features.utf8) {
                (std::cmp::Ordering::Less, true) => '█',
                (std::cmp::Ordering::Less, false) => '#',
                (std::cmp::Ordering::Equal, true) if rest > 0 => EIGHTHS[rest],
                (std::cmp::Ordering::Equal, false) if rest > 3 => '#',
                (_, true) => '·',
                (_, false) => '.',
            };
            self.glyph(x + column, y, glyph, style);
        }
        if let Some(limit) = limit.filter(|limit| (0.0..=1.0).contains(limit)) {
            let column = ((limit * f64::from(width)) as u16).min(width.saturating_sub(1));
            let mark = if self.features.utf8 { '┃' } else { '|' };
            self.glyph(x + column, y, mark, bold());
        }
    }

    /// A colour, where there are some.
    pub fn tint(&self, color: Color) -> Style {
        if self.features.color { Style::new().fg(color) } else { Style::new() }
    }

    /// What is of less weight.
    pub fn dim(&self) -> Style {
        self.tint(Color::DarkGray)
    }

    /// What goes well.
    pub fn good(&self) -> Style {
        self.tint(Color::Green)
    }

    /// What has to be seen.
    pub fn alarm(&self) -> Style {
        self.tint(Color::Red).add_modifier(Modifier::BOLD)
    }
}

/// Titles.
pub fn bold() -> Style {
    Style::new().add_modifier(Modifier::BOLD)
}

/// What is chosen.
pub fn chosen() -> Style {
    Style::new().add_modifier(Modifier::REVERSED)
}

/// A column of a table.
#[derive(Clone, Copy, Debug)]
pub struct CanvasColumn {
    /// Its title.
    pub title: &'static str,
    /// Its width.
    pub width: u16,
    /// Numbers end at its right edge.
    pub right: bool,
    /// It is shown where the table is at least so wide.
    pub from: u16,
}

/// A column.
pub const fn column(title: &'static str, width: u16, right: bool, from: u16) -> CanvasColumn {
    CanvasColumn { title, width, right, from }
}

/// Writes the titles of a table.
pub fn titles(canvas: &mut Canvas<'_>, y: u16, columns: &[CanvasColumn]) {
    cells(canvas, y, columns, columns.iter().map(|column| column.title.to_owned()), bold());
}

/// Writes a row of a table, with a space between two columns.
pub fn cells(
    canvas: &mut Canvas<'_>,
    y: u16,
    columns: &[CanvasColumn],
    texts: impl IntoIterator<Item = String>,
    style: Style,
) {
    let mut x = 1;
    for (column, text) in columns.iter().zip(texts) {
        if canvas.width() < column.from {
            continue;
        }
        if column.right {
            let short: String = text.chars().take(usize::from(column.width)).collect();
            canvas.right(x + column.width, y, &short, style);
        } else {
            canvas.text_in(x, y, column.width, &text, style);
        }
        x += column.width + 1;
    }
}

/// The first row of a list that is shown so that the chosen one is among `height`.
pub fn scrolled(first: usize, chosen: usize, height: usize) -> usize {
    if chosen < first { chosen } else { first.max((chosen + 1).saturating_sub(height)) }
}
