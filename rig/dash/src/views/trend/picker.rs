//! The list from which the signals of a trend are chosen.

use super::store::{MAX_LINES, TrendLine, TrendStore};
use crate::canvas::{self, Canvas};
use crate::model::RigModel;
use crate::recording::RecordedSignal;
use control::SignalKind;
use ratatui::crossterm::event::{KeyCode, KeyEvent};
use ratatui::style::Style;

/// The list.
#[derive(Debug, Default)]
pub struct Picker {
    filter: String,
    chosen: usize,
    first: usize,
}

/// What can be chosen.
struct SignalChoice {
    track: RecordedSignal,
    /// What else it is called.
    also: String,
}

/// What a key came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PickerResult {
    /// The list stays.
    Open,
    /// It is closed.
    Closed,
    /// There is no room for another signal.
    Full,
}

impl Picker {
    /// A key; every letter narrows the list.
    pub fn key(&mut self, key: KeyEvent, model: &RigModel, store: &mut TrendStore) -> PickerResult {
        match key.code {
            KeyCode::Esc => return PickerResult::Closed,
            KeyCode::Enter => {
                let choices = choices(model, &self.filter);
                let Some(choice) = choices.into_iter().nth(self.chosen) else { return PickerResult::Closed };
                match store.lines.iter().position(|line| line.track.name == choice.track.name) {
                    Some(place) => drop(store.lines.remove(place)),
                    None if store.lines.len() >= MAX_LINES => return PickerResult::Full,
                    None => store.lines.push(TrendLine::new(choice.track)),
                }
            }
            KeyCode::Up => self.chosen = self.chosen.saturating_sub(1),
            KeyCode::Down => self.chosen += 1,
            KeyCode::PageUp => self.chosen = self.chosen.saturating_sub(10),
            KeyCode::PageDown => self.chosen += 10,
            KeyCode::Backspace => {
                self.filter.pop();
                self.chosen = 0;
            }
            KeyCode::Char(letter) => {
                self.filter.push(letter);
                self.chosen = 0;
            }
            _ => {}
        }
        PickerResult::Open
    }

    /// Draws it over the page.
    pub fn draw(&mut self, canvas: &mut Canvas<'_>, model: &RigModel, store: &TrendStore) {
        let width = canvas.width().min(90);
        let (x, height) = ((canvas.width() - width) / 2, canvas.height());
        let mut whole = canvas.part(x, 0, width, height);
        whole.clear();
        let mut list = whole.framed("Signals of the trend: type to find, Enter takes or drops, Esc closes");
        let choices = choices(model, &self.filter);
        self.chosen = self.chosen.min(choices.len().saturating_sub(1));
        list.text(1, 0, &format!("find: {}_", self.filter), canvas::bold());
        let rows = usize::from(list.height().saturating_sub(1));
        self.first = canvas::scrolled(self.first, self.chosen, rows);
        for (row, (place, choice)) in choices.iter().enumerate().skip(self.first).take(rows).enumerate() {
            let y = row as u16 + 1;
            let taken = store.lines.iter().any(|line| line.track.name == choice.track.name);
            list.text(1, y, if taken { "[x]" } else { "[ ]" }, Style::new());
            list.text_in(5, y, 34, &choice.track.name, Style::new());
            list.text(40, y, &choice.also, Style::new());
            if place == self.chosen {
                list.shade(y, canvas::chosen());
            }
        }
        if choices.is_empty() {
            list.text(1, 1, "no signal has this in its name", Style::new());
        }
    }
}

/// Signals whose names hold a text, each name once: those that are called so first, then terminals and lines.
fn choices(model: &RigModel, filter: &str) -> Vec<SignalChoice> {
    let filter = filter.to_lowercase();
    let mut seen = std::collections::BTreeSet::new();
    let mut choices = Vec::new();
    let mut choice = |name: &str, unit: &str, kind: SignalKind, labels: &[(i64, String)], also: String| {
        let wanted = name.to_lowercase().contains(&filter) || also.to_lowercase().contains(&filter);
        if wanted && seen.insert(name.to_owned()) {
            let (name, unit, labels) = (name.to_owned(), unit.to_owned(), labels.to_vec());
            choices.push(SignalChoice { track: RecordedSignal { name, unit, kind, labels }, also });
        }
    };
    for point in &model.description.points {
        let variable = point.variable.as_deref().unwrap_or_default();
        if let Some(image) = &point.image {
            choice(image, "", point.kind, &[], format!("{} {variable}", point.name).trim_end().to_owned());
        }
        if let Some(channel) = &point.channel {
            choice(&channel.name, &channel.unit, point.kind, &[], format!("line at {}", point.name));
        }
    }
    for signal in &model.description.signals {
        choice(&signal.name, &signal.unit, signal.kind, &signal.labels, signal.unit.clone());
    }
    // Any place in memory has an address.
    if filter.starts_with('%')
        && filter.len() > 3
        && !choices.iter().any(|choice| choice.track.name.to_lowercase() == filter)
    {
        let kind = if filter.contains('x') { SignalKind::Bool } else { SignalKind::Int };
        let track =
            RecordedSignal { name: filter.to_uppercase(), unit: String::new(), kind, labels: Vec::new() };
        choices.push(SignalChoice { track, also: "the address as typed".to_owned() });
    }
    // Stable: the rest keeps its order.
    choices.sort_by_key(|choice| choice.track.name.to_lowercase() != filter);
    choices
}
