//! The screen: header, tabs, the view, the bottom line, and the dialog over them.

use super::dialog::Dialog;
use super::input::KEYS;
use super::{Shell, menu};
use crate::canvas::{self, Canvas};
use crate::model::RigModel;
use crate::show;
use control::{LedStatus, TimeSource};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};

/// The least that it can be drawn on.
const WIDTH: u16 = 80;
const HEIGHT: u16 = 24;

/// Rows of the header, without its warnings.
const HEADER: u16 = 2;

impl Shell {
    /// Draws everything.
    pub fn draw(&mut self, frame: &mut Frame<'_>) {
        let area = frame.area();
        self.tabs.clear();
        self.choices.clear();
        self.body = Rect::default();
        if area.width < WIDTH || area.height < HEIGHT {
            let mut canvas = Canvas::new(frame, area, self.features);
            let text = format!("{} x {} is too small: {WIDTH} x {HEIGHT} is needed", area.width, area.height);
            canvas.text(0, 0, &text, Style::new());
            for (row, (warning, _)) in self.warnings().into_iter().enumerate() {
                canvas.text(0, row as u16 + 1, &warning, canvas::bold());
            }
            return;
        }
        let warnings = self.warnings();
        let mut canvas = Canvas::new(frame, area, self.features);
        self.draw_header(&mut canvas);
        for (row, (text, style)) in warnings.iter().enumerate() {
            let y = HEADER + row as u16;
            canvas.shade(y, *style);
            canvas.text(1, y, text, *style);
        }
        let tabs = HEADER + warnings.len() as u16;
        self.draw_tabs(&mut canvas, tabs);
        self.draw_bottom(&mut canvas, area.height - 1);
        self.body = Rect::new(area.x, area.y + tabs + 1, area.width, area.height - tabs - 2);
        if let Some(view) = self.views.get_mut(self.at) {
            view.draw(frame, self.body, &self.model, self.features);
        }
        if let Some(dialog) = self.dialog.clone() {
            self.draw_dialog(frame, &dialog);
        }
    }

    /// What makes figures untrustworthy, and what is forced: rows of the header.
    fn warnings(&self) -> Vec<(String, Style)> {
        let alarm = warning(self.features.color, Color::Red);
        let mut rows = Vec::new();
        if let Some(why) = &self.model.gone {
            rows.push((format!("!! No connection: {why}"), alarm));
        }
        let troubles: Vec<&str> = self.model.status.troubles.iter().map(|trouble| &*trouble.text).collect();
        if !troubles.is_empty() {
            rows.push((format!("!! Do not trust figures: {}", troubles.join("; ")), alarm));
        }
        if self.model.status.rig.latched_safe {
            rows.push(("!! Outputs are held at their safe values".to_owned(), alarm));
        }
        if let Some(locked) = &self.model.status.locked {
            let note = if locked.note.is_empty() { String::new() } else { format!(": {}", locked.note) };
            rows.push((format!("Locked by {}{note}", locked.by), warning(self.features.color, Color::Blue)));
        }
        if let Some(plan) = &self.model.status.plan {
            let (place, count) = plan.place;
            let text = format!("Plan {}: case {place} of {count}, {}", plan.name, plan.case);
            rows.push((text, warning(self.features.color, Color::Blue)));
        }
        let forced = &self.model.status.forced;
        if !forced.is_empty() {
            let one = |forced: &control::ForcedPoint| {
                format!("{}={}", forced.address, show::value(forced.value, &[]))
            };
            let all: Vec<String> = forced.iter().map(one).collect();
            let text = format!("FORCED {}: {}", all.len(), all.join("  "));
            rows.push((text, warning(self.features.color, Color::Yellow)));
        }
        rows
    }

    fn draw_header(&self, canvas: &mut Canvas<'_>) {
        let (model, status) = (&self.model, &self.model.status);
        let untrusted = model.gone.is_some() || !status.troubles.is_empty();
        let board = model.description.board.rsplit('/').next().unwrap_or_default();
        let mut x = canvas.text_in(1, 0, 18, board, canvas::bold()) + 1;
        x = canvas.text(x, 0, &model.description.reference, Style::new()) + 2;
        let state = if status.state.is_empty() { "?" } else { &status.state };
        x = canvas.text(x, 0, &format!(" {state} "), canvas::chosen()) + 2;
        if status.power {
            canvas.text(x, 0, if status.switch { "switch RUN" } else { "switch STOP" }, Style::new());
        } else if !status.state.is_empty() {
            canvas.text(x, 0, "SUPPLY OFF", canvas::bold());
        }
        let stepped = if model.description.clock == TimeSource::Stepped { " stepped" } else { "" };
        let figures =
            format!("load {}  {} s{stepped}", show::per_mille(status.load), show::seconds(model.now, 1));
        canvas.right(canvas.width() - 1, 0, &figures, Style::new());
        let mut x = 1;
        for led in &status.leds {
            x = draw_led(canvas, x, led, model) + 2;
        }
        let many = if status.clients == 1 { "" } else { "s" };
        let clients = format!("{} client{many}", status.clients);
        canvas.right(canvas.width() - 1, 1, &clients, canvas.dim());
        if untrusted && self.features.color {
            for y in 0..HEADER {
                canvas.shade(y, Style::new().bg(Color::Red).fg(Color::White));
            }
        }
    }

    fn draw_tabs(&mut self, canvas: &mut Canvas<'_>, y: u16) {
        canvas.rule(y, "");
        let mut x = 1;
        for (place, view) in self.views.iter().enumerate() {
            let style = if place == self.at { canvas::chosen() } else { Style::new() };
            let end = canvas.text(x, y, &format!(" {} {} ", place + 1, view.name()), style);
            self.tabs.push(Rect::new(canvas.area().x + x, canvas.area().y + y, end - x, 1));
            x = end + 1;
        }
    }

    fn draw_bottom(&self, canvas: &mut Canvas<'_>, y: u16) {
        if let Some(note) = &self.note {
            let style = if note.bad { warning(self.features.color, Color::Red) } else { canvas::bold() };
            canvas.text(1, y, if note.bad { "!!" } else { "" }, style);
            canvas.text(if note.bad { 4 } else { 1 }, y, &note.text, style);
            return;
        }
        let rest = [(":", "commands"), ("?", "help"), ("q", "leave")];
        let width: usize = rest.iter().map(|(key, does)| key.len() + does.len() + 3).sum();
        let begin = canvas.width() - width as u16;
        let mut x = begin;
        for (key, does) in rest {
            x = canvas.text(x, y, key, canvas::bold()) + 1;
            x = canvas.text(x, y, does, canvas.dim()) + 2;
        }
        let mut x = 1;
        for (key, does) in self.views.get(self.at).map(|view| view.keys()).unwrap_or_default() {
            // What has no room stands in the help.
            let width = (key.chars().count() + does.chars().count() + 1) as u16;
            if x + width >= begin {
                break;
            }
            x = canvas.text(x, y, key, canvas::bold()) + 1;
            x = canvas.text(x, y, does, canvas.dim()) + 2;
        }
    }

    fn draw_dialog(&mut self, frame: &mut Frame<'_>, dialog: &Dialog) {
        let area = frame.area();
        match dialog {
            Dialog::Prompt { ask, editor, .. } => self.draw_prompt(frame, ask, editor),
            Dialog::Help => {
                let view_keys = self.views.get(self.at).map(|view| view.keys()).unwrap_or_default();
                let mut canvas = Canvas::new(frame, area, self.features);
                let rows = (KEYS.len() + view_keys.len() + 3) as u16;
                let mut canvas = window(&mut canvas, 76, rows);
                let mut canvas = canvas.framed(&format!("Help: {}", self.views[self.at].name()));
                for (row, (key, does)) in view_keys.iter().chain([&("", "")]).chain(&KEYS).enumerate() {
                    canvas.text(1, row as u16, key, canvas::bold());
                    canvas.text(14, row as u16, does, Style::new());
                }
            }
            Dialog::Menu { chosen } => {
                let entries: Vec<String> =
                    menu::entries(&self.model).into_iter().map(|(label, _)| label.to_owned()).collect();
                self.draw_choices(frame, "Commands", &[], &entries, *chosen);
            }
            Dialog::Confirm { question, .. } => {
                let answers = ["y  yes".to_owned(), "n  no".to_owned()];
                self.draw_choices(frame, "Sure?", &lines(question, 60), &answers, usize::MAX);
            }
            Dialog::Leave { chosen } => {
                let forced = &self.model.status.forced;
                let mut text = Vec::new();
                if self.owns_rig {
                    text.push("The rig was started with this dashboard.".to_owned());
                    text.push("It ends with it; outputs become safe.".to_owned());
                } else if !forced.is_empty() {
                    text.push(format!("Forced: {}", forced.len()));
                }
                let answers: Vec<String> =
                    self.leave_choices().iter().map(|(key, label, _)| format!("{key}  {label}")).collect();
                self.draw_choices(frame, "Leave", &text, &answers, *chosen);
            }
        }
    }

    fn draw_choices(
        &mut self,
        frame: &mut Frame<'_>,
        title: &str,
        text: &[String],
        choices: &[String],
        chosen: usize,
    ) {
        let widest = text.iter().chain(choices).map(|line| line.chars().count()).max().unwrap_or(0);
        let width = (widest.max(title.len() + 2) + 4) as u16;
        let gap = u16::from(!text.is_empty());
        let height = (text.len() + choices.len()) as u16 + gap + 2;
        let area = frame.area();
        let mut canvas = Canvas::new(frame, area, self.features);
        let mut canvas = window(&mut canvas, width, height);
        let mut canvas = canvas.framed(title);
        for (row, line) in text.iter().enumerate() {
            canvas.text(1, row as u16, line, Style::new());
        }
        for (place, line) in choices.iter().enumerate() {
            let y = text.len() as u16 + gap + place as u16;
            canvas.text(1, y, line, Style::new());
            if place == chosen {
                canvas.shade(y, canvas::chosen());
            }
            self.choices.push(Rect::new(canvas.area().x, canvas.area().y + y, canvas.width(), 1));
        }
    }

    fn draw_prompt(&self, frame: &mut Frame<'_>, ask: &str, editor: &crate::editor::Editor) {
        let area = frame.area();
        let y = area.height - 1;
        let mut canvas = Canvas::new(frame, area, self.features);
        let mut canvas = canvas.part(0, y, area.width, 1);
        canvas.clear();
        let x = canvas.text_in(1, 0, area.width / 2, &format!("{ask}:"), canvas::bold()) + 1;
        let (text, at) = editor.window(usize::from(area.width - x - 1));
        let style = if editor.is_proposed() { canvas::chosen() } else { Style::new() };
        canvas.text(x, 0, &text, style);
        frame.set_cursor_position((area.x + x + at as u16, area.y + y));
    }
}

/// A part in the middle that nothing else is drawn in.
fn window<'a>(canvas: &'a mut Canvas<'_>, width: u16, height: u16) -> Canvas<'a> {
    let (width, height) = (width.min(canvas.width()), height.min(canvas.height()));
    let (x, y) = ((canvas.width() - width) / 2, (canvas.height() - height) / 2);
    let mut part = canvas.part(x, y, width, height);
    part.clear();
    part
}

/// A row that has to be seen, with and without colours.
fn warning(color: bool, of: Color) -> Style {
    if !color {
        return Style::new().add_modifier(Modifier::BOLD | Modifier::REVERSED);
    }
    let text = if of == Color::Yellow { Color::Black } else { Color::White };
    Style::new().bg(of).fg(text).add_modifier(Modifier::BOLD)
}

/// An indicator with its name; the column after it.
fn draw_led(canvas: &mut Canvas<'_>, x: u16, led: &LedStatus, model: &RigModel) -> u16 {
    let lit = match (led.pattern.as_str(), led.times) {
        ("off", _) => false,
        (_, Some((on, off))) if on > 0 && off > 0 => {
            (model.now - led.since).rem_euclid(on.saturating_add(off).max(1)) < on
        }
        _ => true,
    };
    let color = if led.name.starts_with("ERR") { Color::Red } else { Color::Green };
    let x = canvas.text(x, 1, &led.name, Style::new()) + 1;
    let glyph = if lit { canvas.features.or("●", "(*)") } else { canvas.features.or("○", "( )") };
    let style = if lit { canvas.tint(color).add_modifier(Modifier::BOLD) } else { Style::new() };
    canvas.text(x, 1, glyph, style)
}

/// A text in lines of at most so many characters.
fn lines(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
