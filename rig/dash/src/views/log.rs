//! What the rig said.

use super::{View, ViewRequest};
use crate::canvas::{self, Canvas};
use crate::glyphs::TerminalFeatures;
use crate::model::RigModel;
use crate::show;
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyEvent, MouseEvent, MouseEventKind};
use ratatui::layout::Rect;
use ratatui::style::Style;

/// Rows that a turn of the wheel moves.
const WHEEL: usize = 3;

/// The log. It follows its end until somebody goes up.
#[derive(Debug, Default)]
pub struct LogView {
    /// Lines between the last one shown and the end.
    back: usize,
    /// Only lines with this in them.
    filter: String,
    /// The lines that were there when `back` was counted: new ones do not move what somebody reads.
    known: usize,
    rows: usize,
}

impl LogView {
    fn up(&mut self, rows: usize) {
        self.back = self.back.saturating_add(rows);
    }

    fn down(&mut self, rows: usize) {
        self.back = self.back.saturating_sub(rows);
    }
}

impl View for LogView {
    fn name(&self) -> &'static str {
        "Log"
    }

    fn keys(&self) -> Vec<(&'static str, &'static str)> {
        vec![("Up/Down/PgUp/PgDn", "scroll"), ("End", "follow"), ("/", "filter")]
    }

    fn signals(&self, _model: &RigModel) -> Vec<(String, bool)> {
        Vec::new()
    }

    fn draw(&mut self, frame: &mut Frame<'_>, area: Rect, model: &RigModel, features: TerminalFeatures) {
        let mut canvas = Canvas::new(frame, area, features);
        let wanted = self.filter.to_lowercase();
        let lines: Vec<&(i64, String)> =
            model.log.iter().filter(|(_, text)| text.to_lowercase().contains(&wanted)).collect();
        if self.back > 0 {
            self.back += lines.len().saturating_sub(self.known);
        }
        self.known = lines.len();
        let head = u16::from(!self.filter.is_empty());
        self.rows = usize::from(canvas.height() - head.min(canvas.height()));
        self.back = self.back.min(lines.len().saturating_sub(self.rows));
        if head > 0 {
            let text = format!("filter: {}   {} of {} lines", self.filter, lines.len(), model.log.len());
            canvas.text(1, 0, &text, canvas::bold());
        }
        if lines.is_empty() {
            canvas.text(1, head, "Nothing yet.", canvas.dim());
        }
        let end = lines.len() - self.back;
        let first = end.saturating_sub(self.rows);
        for (row, (at, text)) in lines[first..end].iter().enumerate() {
            let y = head + row as u16;
            canvas.right(14, y, &show::seconds(*at, 3), canvas.dim());
            canvas.text(16, y, text, Style::new());
        }
        if self.back > 0 {
            canvas.right(
                area.width - 1,
                area.height - 1,
                &format!(" {} more below ", self.back),
                canvas::chosen(),
            );
        }
    }

    fn key(&mut self, key: KeyEvent, _model: &RigModel) -> Option<Vec<ViewRequest>> {
        match key.code {
            KeyCode::Up => self.up(1),
            KeyCode::Down => self.down(1),
            KeyCode::PageUp => self.up(self.rows.max(1)),
            KeyCode::PageDown => self.down(self.rows.max(1)),
            KeyCode::Home => self.back = usize::MAX,
            KeyCode::End => self.back = 0,
            KeyCode::Char('/') => {
                return Some(vec![ViewRequest::Prompt {
                    ask: "Lines with".to_owned(),
                    text: self.filter.clone(),
                }]);
            }
            KeyCode::Esc if !self.filter.is_empty() => self.filter.clear(),
            _ => return None,
        }
        Some(Vec::new())
    }

    fn mouse(&mut self, mouse: MouseEvent, _model: &RigModel) -> Vec<ViewRequest> {
        match mouse.kind {
            MouseEventKind::ScrollUp => self.up(WHEEL),
            MouseEventKind::ScrollDown => self.down(WHEEL),
            _ => {}
        }
        Vec::new()
    }

    fn typed(&mut self, text: &str, _model: &RigModel) -> Vec<ViewRequest> {
        self.filter = text.trim().to_owned();
        self.back = 0;
        Vec::new()
    }
}
