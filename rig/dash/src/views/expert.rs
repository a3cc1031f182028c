//! The expert functions with their facts.

use super::{View, ViewRequest};
use crate::canvas::{self, Canvas};
use crate::glyphs::TerminalFeatures;
use crate::model::RigModel;
use crate::show;
use control::{FunctionInfo, Signal};
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyEvent, MouseEvent, MouseEventKind};
use ratatui::layout::Rect;
use ratatui::style::Style;
use std::collections::BTreeMap;

/// The width of a fact: name and value.
const FACT: u16 = 38;

/// The view of the expert functions.
#[derive(Debug, Default)]
pub struct ExpertView {
    shown: bool,
    chosen: usize,
    first: usize,
}

impl View for ExpertView {
    fn name(&self) -> &'static str {
        "Expert"
    }

    fn keys(&self) -> Vec<(&'static str, &'static str)> {
        vec![("Up/Down", "function")]
    }

    fn signals(&self, model: &RigModel) -> Vec<(String, bool)> {
        if !self.shown {
            return Vec::new();
        }
        let functions = &model.description.functions;
        functions.iter().flat_map(|function| &function.signals).map(|name| (name.clone(), false)).collect()
    }

    fn shown(&mut self, shown: bool) {
        self.shown = shown;
    }

    fn draw(&mut self, frame: &mut Frame<'_>, area: Rect, model: &RigModel, features: TerminalFeatures) {
        let mut canvas = Canvas::new(frame, area, features);
        let functions = &model.description.functions;
        if functions.is_empty() {
            canvas.text(
                1,
                0,
                "No expert functions are configured: no counters, no pulse generators.",
                Style::new(),
            );
            return;
        }
        self.chosen = self.chosen.min(functions.len() - 1);
        let columns = (canvas.width() / FACT).max(1);
        let height = |function: &FunctionInfo| 2 + (function.signals.len() as u16).div_ceil(columns);
        // The chosen function is shown whole, as far as there is room.
        self.first = self.first.min(self.chosen);
        while self.first < self.chosen
            && functions[self.first..=self.chosen].iter().map(height).sum::<u16>() > canvas.height() + 1
        {
            self.first += 1;
        }
        let named: BTreeMap<&str, &Signal> =
            model.description.signals.iter().map(|signal| (signal.name.as_str(), signal)).collect();
        let mut y = 0;
        for (place, function) in functions.iter().enumerate().skip(self.first) {
            if y >= canvas.height() {
                break;
            }
            let style = if place == self.chosen { canvas::chosen() } else { canvas::bold() };
            let x = canvas.text(1, y, &format!("{:<8}", function.name), style);
            let x = canvas.text(x + 1, y, &function.kind, Style::new());
            if !function.terminals.is_empty() {
                let dim = canvas.dim();
                canvas.text(x + 2, y, &format!("at {}", function.terminals.join(" ")), dim);
            }
            let rows = (function.signals.len() as u16).div_ceil(columns);
            for (fact, name) in function.signals.iter().enumerate() {
                let (column, row) = (fact as u16 / rows, fact as u16 % rows);
                draw_fact(
                    &mut canvas.part(column * FACT, y + 1 + row, FACT, 1),
                    function,
                    name,
                    model,
                    &named,
                );
            }
            y += rows + 2;
        }
    }

    fn key(&mut self, key: KeyEvent, model: &RigModel) -> Option<Vec<ViewRequest>> {
        let last = model.description.functions.len().saturating_sub(1);
        match key.code {
            KeyCode::Up => self.chosen = self.chosen.saturating_sub(1),
            KeyCode::Down => self.chosen = (self.chosen + 1).min(last),
            KeyCode::Home => self.chosen = 0,
            KeyCode::End => self.chosen = last,
            _ => return None,
        }
        Some(Vec::new())
    }

    fn mouse(&mut self, mouse: MouseEvent, model: &RigModel) -> Vec<ViewRequest> {
        let last = model.description.functions.len().saturating_sub(1);
        match mouse.kind {
            MouseEventKind::ScrollUp => self.chosen = self.chosen.saturating_sub(1),
            MouseEventKind::ScrollDown => self.chosen = (self.chosen + 1).min(last),
            _ => {}
        }
        Vec::new()
    }
}

/// A fact: its name without that of its function, and its value.
fn draw_fact(
    canvas: &mut Canvas<'_>,
    function: &FunctionInfo,
    name: &str,
    model: &RigModel,
    named: &BTreeMap<&str, &Signal>,
) {
    let short =
        name.strip_prefix(function.name.as_str()).map_or(name, |rest| rest.trim_start_matches(['.', ':']));
    canvas.text_in(3, 0, 17, short, Style::new());
    let value = model.values.get(name);
    let text = value.map_or("...".to_owned(), |(_, value)| show::of_signal(*value, named.get(name).copied()));
    canvas.text_in(21, 0, 16, &text, canvas::bold());
}
