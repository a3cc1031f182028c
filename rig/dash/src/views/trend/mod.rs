//! The trend: signals over time, with cursors, a trigger, and files.

mod draw;
mod figures;
mod lane;
mod navigation;
mod picker;
mod store;
mod trigger;
mod trigger_dialog;

use super::{View, ViewRequest};
use crate::canvas::Canvas;
use crate::glyphs::TerminalFeatures;
use crate::model::RigModel;
use crate::recording::TrendFiles;
use control::WireValue;
use picker::{Picker, PickerResult};
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers, MouseButton, MouseEvent, MouseEventKind};
use ratatui::layout::Rect;
use std::rc::Rc;
use store::{TrendPoint, TrendStore};
use trigger::{TrendTrigger, TriggerState};
use trigger_dialog::{TriggerDialog, TriggerDialogResult};

/// Lengths of the window, nanoseconds: 1 ms to 1 h.
const BASES: [i64; 20] = [
    1_000_000,
    2_000_000,
    5_000_000,
    10_000_000,
    20_000_000,
    50_000_000,
    100_000_000,
    200_000_000,
    500_000_000,
    1_000_000_000,
    2_000_000_000,
    5_000_000_000,
    10_000_000_000,
    20_000_000_000,
    60_000_000_000,
    120_000_000_000,
    300_000_000_000,
    600_000_000_000,
    1_800_000_000_000,
    3_600_000_000_000,
];

/// The one to begin with: 10 s.
const FIRST_BASE: usize = 12;

/// What the user is typing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum TrendPrompt {
    #[default]
    Nothing,
    Save,
    Load,
    Scale,
    Level,
}

/// What lies over the plot.
#[derive(Debug)]
enum Overlay {
    Picker(Picker),
    TriggerDialog(TriggerDialog),
}

/// A cursor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct TrendCursor {
    /// Where it stands, nanoseconds.
    at: i64,
    /// How far before it the change may lie that it stands on.
    width: i64,
}

/// The view of the trend.
#[derive(Debug)]
pub struct TrendView {
    files: Rc<dyn TrendFiles>,
    live: TrendStore,
    /// A file that is looked at in place of the rig, with its name.
    file: Option<(String, TrendStore)>,
    /// Place in [`BASES`].
    base: usize,
    /// The end of the window where it stands still.
    held: Option<i64>,
    chosen: usize,
    first: usize,
    cursors: [Option<TrendCursor>; 2],
    /// The cursor that the keys move.
    moving: Option<usize>,
    trigger: TrendTrigger,
    over: Option<Overlay>,
    typing: TrendPrompt,
    /// Changes that the rig could not send.
    missed: u64,
    /// Where the plot and its lanes were drawn, and the window in it.
    plot: Rect,
    window: (i64, i64),
    lanes: Vec<(Rect, usize)>,
}

impl TrendView {
    /// A trend of nothing yet.
    pub fn new(files: Rc<dyn TrendFiles>) -> TrendView {
        TrendView {
            files,
            live: TrendStore::default(),
            file: None,
            base: FIRST_BASE,
            held: None,
            chosen: 0,
            first: 0,
            cursors: [None, None],
            moving: None,
            trigger: TrendTrigger::default(),
            over: None,
            typing: TrendPrompt::Nothing,
            missed: 0,
            plot: Rect::ZERO,
            window: (0, BASES[FIRST_BASE]),
            lanes: Vec::new(),
        }
    }

    fn base(&self) -> i64 {
        BASES[self.base.min(BASES.len() - 1)]
    }

    /// What is shown.
    fn seen(&self) -> &TrendStore {
        self.file.as_ref().map_or(&self.live, |(_, store)| store)
    }

    fn seen_mut(&mut self) -> &mut TrendStore {
        self.file.as_mut().map_or(&mut self.live, |(_, store)| store)
    }

    fn prompt(&mut self, typing: TrendPrompt, ask: String, text: String) -> Vec<ViewRequest> {
        self.typing = typing;
        vec![ViewRequest::Prompt { ask, text }]
    }

    /// Between the cursors where both stand, else all that there is.
    fn save(&self, path: &str) -> ViewRequest {
        let store = self.seen();
        let (from, to) = match self.cursors {
            [Some(a), Some(b)] if a.at != b.at => (a.at.min(b.at), a.at.max(b.at)),
            _ => (store.begin(), store.now),
        };
        let recording = store.recording(from, to);
        let (changes, signals) = (recording.samples.len(), recording.tracks.len());
        match self.files.save(path, &recording) {
            Ok(()) => ViewRequest::Message(format!("{path}: {changes} changes of {signals} signals.")),
            Err(fault) => ViewRequest::Fault(fault),
        }
    }

    fn load(&mut self, path: &str) -> ViewRequest {
        match self.files.load(path) {
            Err(fault) => ViewRequest::Fault(fault),
            Ok(recording) => {
                let (from, to) = recording.span;
                let (store, left) = TrendStore::of(recording);
                let fits = BASES.iter().position(|base| *base >= to.saturating_sub(from));
                self.base = fits.unwrap_or(BASES.len() - 1);
                self.held = Some(from.saturating_add(self.base()));
                self.cursors = [None, None];
                self.moving = None;
                self.chosen = 0;
                let signals = store.lines.len();
                self.file = Some((path.to_owned(), store));
                let rest =
                    if left > 0 { format!(" {left} changes are left out: no room.") } else { String::new() };
                ViewRequest::Message(format!(
                    "{path}: {signals} signals over {}.{rest}",
                    crate::show::span(to - from)
                ))
            }
        }
    }

    /// Back from a file to the rig.
    fn close(&mut self) {
        self.file = None;
        self.cursors = [None, None];
        self.moving = None;
        self.release();
    }

    fn scale(&mut self, text: &str) -> Option<ViewRequest> {
        let place = self.chosen;
        let line = self.seen_mut().lines.get_mut(place)?;
        if text.is_empty() || text == "auto" {
            line.scale = None;
            return None;
        }
        let bounds = text.split_once("..").and_then(|(low, high)| {
            Some((low.trim().parse::<f64>().ok()?, high.trim().parse::<f64>().ok()?))
        });
        match bounds.filter(|(low, high)| low.is_finite() && high.is_finite() && low < high) {
            Some(bounds) => {
                line.scale = Some(bounds);
                None
            }
            None => {
                Some(ViewRequest::Message(format!("`{text}` is no scale: write it as in 0 .. 10, or auto.")))
            }
        }
    }

    /// A key while something lies over the plot.
    fn key_over(&mut self, key: KeyEvent, model: &RigModel) -> Vec<ViewRequest> {
        match self.over.take() {
            None => Vec::new(),
            Some(Overlay::Picker(mut picker)) => {
                let picked = picker.key(key, model, &mut self.live);
                self.chosen = self.chosen.min(self.live.lines.len().saturating_sub(1));
                if picked != PickerResult::Closed {
                    self.over = Some(Overlay::Picker(picker));
                }
                match picked {
                    PickerResult::Full => vec![ViewRequest::Message(format!(
                        "A trend has at most {} signals.",
                        store::MAX_LINES
                    ))],
                    _ => Vec::new(),
                }
            }
            Some(Overlay::TriggerDialog(mut setting)) => match setting.key(key, &self.live) {
                TriggerDialogResult::Closed => Vec::new(),
                TriggerDialogResult::Open => {
                    self.over = Some(Overlay::TriggerDialog(setting));
                    Vec::new()
                }
                TriggerDialogResult::EditLevel => {
                    let level = setting.trigger.level.to_string();
                    self.over = Some(Overlay::TriggerDialog(setting));
                    self.prompt(TrendPrompt::Level, "Level: ".to_owned(), level)
                }
                TriggerDialogResult::Accepted => {
                    self.trigger = setting.trigger;
                    self.arm();
                    Vec::new()
                }
            },
        }
    }

    fn arm(&mut self) {
        self.trigger.arm(self.live.now);
        self.release();
    }

    fn remove(&mut self) {
        let place = self.chosen;
        if self.file.is_none() && place < self.live.lines.len() {
            self.live.lines.remove(place);
            self.chosen = place.min(self.live.lines.len().saturating_sub(1));
        }
    }
}

impl View for TrendView {
    fn name(&self) -> &'static str {
        "Trend"
    }

    fn keys(&self) -> Vec<(&'static str, &'static str)> {
        let mut keys = vec![("i", "signals"), ("+/-", "time"), ("Space", "hold"), ("a/b", "cursors")];
        if self.moving.is_some() {
            keys.push(("e/E", "next/last edge"));
        }
        keys.extend([("t", "trigger"), ("s", "save"), ("o", "load"), ("y", "scale")]);
        if self.file.is_some() {
            keys.push(("c", "close file"));
        }
        keys
    }

    fn signals(&self, _model: &RigModel) -> Vec<(String, bool)> {
        self.live.lines.iter().map(|line| (line.track.name.clone(), true)).collect()
    }

    fn changed(&mut self, name: &str, when: (i64, i64), value: WireValue) {
        let point = TrendPoint { earliest: when.0, at: when.1, value: value.0 };
        let Some(line) = self.live.lines.iter().find(|line| line.track.name == name) else { return };
        // A trigger whose window is over makes room for the next one first.
        let base = self.base();
        self.trigger.advance_to(point.at, base);
        self.trigger.observe(name, line.last(), &point);
        let held = self.held.filter(|_| self.file.is_none()).map(|end| end.saturating_sub(base));
        let keep = [held, self.trigger.keeps(&self.live, base)].into_iter().flatten().min();
        self.live.push(name, point, keep);
    }

    fn reconnected(&mut self) {
        self.live.gap();
    }

    fn missed(&mut self, changes: u64) {
        self.missed = self.missed.saturating_add(changes);
    }

    fn draw(&mut self, frame: &mut Frame<'_>, area: Rect, model: &RigModel, features: TerminalFeatures) {
        self.live.until(model.now);
        let base = self.base();
        self.trigger.advance_to(self.live.now, base);
        let mut canvas = Canvas::new(frame, area, features);
        draw::draw(self, &mut canvas);
        match &mut self.over {
            Some(Overlay::Picker(picker)) => picker.draw(&mut canvas, model, &self.live),
            Some(Overlay::TriggerDialog(setting)) => setting.draw(&mut canvas, &self.live),
            None => {}
        }
    }

    fn key(&mut self, key: KeyEvent, model: &RigModel) -> Option<Vec<ViewRequest>> {
        if self.over.is_some() {
            return Some(self.key_over(key, model));
        }
        let far = if key.modifiers.intersects(KeyModifiers::SHIFT | KeyModifiers::CONTROL) { 10 } else { 1 };
        let canvas = i64::from(self.plot.width.max(2) / 2);
        match key.code {
            KeyCode::Char('i') | KeyCode::Insert if self.file.is_none() => {
                self.over = Some(Overlay::Picker(Picker::default()));
            }
            KeyCode::Delete => self.remove(),
            KeyCode::Char('+' | '=') => self.zoom(false),
            KeyCode::Char('-') => self.zoom(true),
            KeyCode::Char(' ') if self.held.is_some() => self.release(),
            KeyCode::Char(' ') => self.hold(),
            KeyCode::Char('a') => self.cursor(0),
            KeyCode::Char('b') => self.cursor(1),
            KeyCode::Char('e') => self.jump(true),
            KeyCode::Char('E') => self.jump(false),
            KeyCode::Esc if self.moving.is_some() || self.cursors != [None, None] => {
                self.cursors = [None, None];
                self.moving = None;
            }
            KeyCode::Left => self.shift(-far),
            KeyCode::Right => self.shift(far),
            KeyCode::PageUp => self.shift(-canvas),
            KeyCode::PageDown => self.shift(canvas),
            KeyCode::End => self.release(),
            KeyCode::Up => self.chosen = self.chosen.saturating_sub(1),
            KeyCode::Down => {
                self.chosen = (self.chosen + 1).min(self.seen().lines.len().saturating_sub(1));
            }
            KeyCode::Char('t') if self.file.is_none() => {
                let line = self.live.lines.get(self.chosen).map(|line| line.track.name.as_str());
                self.over = Some(Overlay::TriggerDialog(TriggerDialog::new(&self.trigger, line)));
            }
            // Once more what was waited for.
            KeyCode::Char('T') if self.file.is_none() => self.arm(),
            KeyCode::Char('y') => {
                let ask = "Scale of the chosen signal (0 .. 10, or auto): ".to_owned();
                return Some(self.prompt(TrendPrompt::Scale, ask, String::new()));
            }
            KeyCode::Char('s') => {
                let extensions = self.files.extensions().join(" or ");
                let first = self.files.extensions().first().copied().unwrap_or_default();
                let text = format!("trend.{first}");
                return Some(self.prompt(TrendPrompt::Save, format!("Save as ({extensions}): "), text));
            }
            KeyCode::Char('o') => {
                return Some(self.prompt(TrendPrompt::Load, "Look at file: ".to_owned(), String::new()));
            }
            KeyCode::Char('c') if self.file.is_some() => self.close(),
            _ => return None,
        }
        Some(Vec::new())
    }

    fn mouse(&mut self, mouse: MouseEvent, _model: &RigModel) -> Vec<ViewRequest> {
        let spot = (mouse.column, mouse.row).into();
        match mouse.kind {
            MouseEventKind::Down(button) | MouseEventKind::Drag(button) => {
                if let Some((_, line)) = self.lanes.iter().find(|(lane, _)| lane.contains(spot)) {
                    self.chosen = *line;
                }
                if self.over.is_none() && self.plot.contains(spot) {
                    self.hold();
                    let column = mouse.column - self.plot.x;
                    let at =
                        self.window.0.saturating_add(lane::span_of(self.window, column, self.plot.width));
                    self.put(usize::from(button == MouseButton::Right), TrendCursor { at, width: 0 });
                }
            }
            MouseEventKind::ScrollUp => self.zoom(false),
            MouseEventKind::ScrollDown => self.zoom(true),
            _ => {}
        }
        Vec::new()
    }

    fn typed(&mut self, text: &str, _model: &RigModel) -> Vec<ViewRequest> {
        let text = text.trim();
        match std::mem::take(&mut self.typing) {
            TrendPrompt::Nothing => Vec::new(),
            TrendPrompt::Save if text.is_empty() => Vec::new(),
            TrendPrompt::Save => vec![self.save(text)],
            TrendPrompt::Load if text.is_empty() => Vec::new(),
            TrendPrompt::Load => vec![self.load(text)],
            TrendPrompt::Scale => self.scale(text).into_iter().collect(),
            TrendPrompt::Level => match (text.parse::<f64>(), &mut self.over) {
                (Ok(level), Some(Overlay::TriggerDialog(setting))) if level.is_finite() => {
                    setting.trigger.level = level;
                    Vec::new()
                }
                _ => vec![ViewRequest::Message(format!("`{text}` is not a number."))],
            },
        }
    }
}

/// How it stands, in words.
fn state(trend: &TrendView) -> String {
    let trigger = &trend.trigger;
    let what = match trend.live.lines.iter().find(|line| line.track.name == trigger.signal) {
        Some(line) if lane::curved(line) && trigger.edge != trigger::TriggerEdge::Change => {
            format!("{} {} {}", trigger.signal, trigger.edge.label(), crate::show::real(trigger.level, 6))
        }
        Some(_) => format!("{} {}", trigger.signal, trigger.edge.label()),
        None => "no signal".to_owned(),
    };
    match trigger.state() {
        TriggerState::Off => String::new(),
        TriggerState::Armed => format!("waits: {what}"),
        TriggerState::Fired => format!("triggered: {what}"),
        TriggerState::Done => format!("done: {what} (T: again)"),
    }
}
