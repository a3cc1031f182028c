//! The table in which the trigger is set.

use super::store::TrendStore;
use super::trigger::{TrendTrigger, TriggerEdge, TriggerMode};
use crate::canvas::{self, Canvas};
use crate::show;
use control::SignalKind;
use ratatui::crossterm::event::{KeyCode, KeyEvent};
use ratatui::style::Style;

/// Rows of the table.
const ROWS: usize = 5;

/// The row of the level.
const LEVEL: usize = 3;

/// The table.
#[derive(Clone, Debug, PartialEq)]
pub struct TriggerDialog {
    /// What it makes.
    pub trigger: TrendTrigger,
    row: usize,
}

/// What a key came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TriggerDialogResult {
    /// The table stays.
    Open,
    /// It is closed and nothing is changed.
    Closed,
    /// The trigger is to be used.
    Accepted,
    /// The user types the level.
    EditLevel,
}

impl TriggerDialog {
    /// Begins with what is, and a signal if there is none yet.
    pub fn new(trigger: &TrendTrigger, signal: Option<&str>) -> TriggerDialog {
        let mut trigger = trigger.clone();
        if trigger.signal.is_empty() {
            trigger.signal = signal.unwrap_or_default().to_owned();
        }
        TriggerDialog { trigger, row: 0 }
    }

    /// A key.
    pub fn key(&mut self, key: KeyEvent, store: &TrendStore) -> TriggerDialogResult {
        match key.code {
            KeyCode::Esc => return TriggerDialogResult::Closed,
            KeyCode::Enter if self.row == LEVEL => return TriggerDialogResult::EditLevel,
            KeyCode::Enter => return TriggerDialogResult::Accepted,
            KeyCode::Up => self.row = self.row.saturating_sub(1),
            KeyCode::Down => self.row = (self.row + 1).min(ROWS - 1),
            KeyCode::Left => self.turn(false, store),
            KeyCode::Right => self.turn(true, store),
            _ => {}
        }
        TriggerDialogResult::Open
    }

    fn turn(&mut self, on: bool, store: &TrendStore) {
        let trigger = &mut self.trigger;
        match self.row {
            0 => trigger.mode = neighbour(&TriggerMode::ALL, trigger.mode, on),
            1 => {
                let names: Vec<&str> = store.lines.iter().map(|line| line.track.name.as_str()).collect();
                if !names.is_empty() {
                    trigger.signal = neighbour(&names, trigger.signal.as_str(), on).to_owned();
                }
            }
            2 => trigger.edge = neighbour(&TriggerEdge::ALL, trigger.edge, on),
            4 => {
                trigger.before = if on { (trigger.before + 10).min(90) } else { trigger.before.max(10) - 10 }
            }
            _ => {}
        }
    }

    /// Draws it over the page.
    pub fn draw(&self, canvas: &mut Canvas<'_>, store: &TrendStore) {
        let width = canvas.width().min(58);
        let x = (canvas.width() - width) / 2;
        let height = (ROWS as u16 + 4).min(canvas.height());
        let y = (canvas.height() - height) / 2;
        let mut whole = canvas.part(x, y, width, height);
        whole.clear();
        let mut table = whole.framed("Trigger");
        let trigger = &self.trigger;
        let line = store.lines.iter().find(|line| line.track.name == trigger.signal);
        let level = match line {
            Some(line) if line.track.kind == SignalKind::Bool => "of numbers only".to_owned(),
            Some(line) => format!("{} {}", show::real(trigger.level, 9), line.track.unit),
            None => show::real(trigger.level, 9),
        };
        let rows: [(&str, String); ROWS] = [
            ("Mode", trigger.mode.label().to_owned()),
            ("Signal", if line.is_some() { trigger.signal.clone() } else { "none".to_owned() }),
            ("When it", trigger.edge.label().to_owned()),
            ("Level", level),
            ("Before", format!("{} % of the window", trigger.before)),
        ];
        for (row, (name, value)) in rows.iter().enumerate() {
            table.text(1, row as u16, &format!("{name:<9}< {value} >"), Style::new());
            if row == self.row {
                table.shade(row as u16, canvas::chosen());
            }
        }
        let help = if self.row == LEVEL {
            "Enter: type the level   Esc: leave it"
        } else {
            "Left/Right: change   Enter: arm   Esc: leave it"
        };
        let dim = table.dim();
        table.text(1, ROWS as u16 + 1, help, dim);
    }
}

/// The neighbour of one among several; the first one where it is not among them.
fn neighbour<T: Copy + PartialEq>(all: &[T], one: T, on: bool) -> T {
    let place = all.iter().position(|other| *other == one);
    let next = place.map_or(0, |place| (if on { place + 1 } else { place + all.len() - 1 }) % all.len());
    all[next]
}
