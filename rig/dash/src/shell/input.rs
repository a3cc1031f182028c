//! Keys and the mouse.

use super::dialog::Dialog;
use super::{LoopCommand, Shell};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers, MouseButton, MouseEvent, MouseEventKind};
use ratatui::layout::{Position, Rect};

/// The keys that mean the same in every view, as help shows them.
pub(super) const KEYS: [(&str, &str); 8] = [
    ("1..9", "a view; Tab and Shift-Tab the next one and the one before"),
    (": F2", "commands: run, stop, resets, switch, supply, release all, lock"),
    ("? F1", "this help"),
    ("q", "leave; what happens to forces is asked"),
    ("Ctrl-l", "redraw everything"),
    ("Ctrl-z", "stop the dashboard for a while; the rig goes on"),
    ("Esc", "close the dialog"),
    ("mouse", "tabs, rows, entries of menus"),
];

impl Shell {
    /// A key.
    pub fn key(&mut self, key: KeyEvent) {
        self.note = None;
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        match key.code {
            KeyCode::Char('z') if control => self.loop_commands.push(LoopCommand::Suspend),
            KeyCode::Char('l') if control => self.loop_commands.push(LoopCommand::Redraw),
            _ => match self.dialog.take() {
                Some(dialog) => self.dialog_key(dialog, key),
                None if control && key.code == KeyCode::Char('c') => self.start_leaving(),
                None => self.view_key(key),
            },
        }
        self.refresh_subscriptions();
    }

    fn view_key(&mut self, key: KeyEvent) {
        let requests_of_view = self.views.get_mut(self.at).and_then(|view| view.key(key, &self.model));
        if let Some(requests_of_view) = requests_of_view {
            self.carry_out(requests_of_view);
            return;
        }
        let count = self.views.len().max(1);
        match key.code {
            KeyCode::Char('q') => self.start_leaving(),
            KeyCode::Char('?') | KeyCode::F(1) => self.dialog = Some(Dialog::Help),
            KeyCode::Char(':') | KeyCode::F(2) => self.dialog = Some(Dialog::Menu { chosen: 0 }),
            KeyCode::Tab => self.show((self.at + 1) % count),
            KeyCode::BackTab => self.show((self.at + count - 1) % count),
            KeyCode::Char(digit @ '1'..='9') => self.show(digit as usize - '1' as usize),
            _ => {}
        }
    }

    /// Text that was pasted.
    pub fn paste(&mut self, text: &str) {
        if let Some(Dialog::Prompt { editor, .. }) = &mut self.dialog {
            editor.insert(text);
        }
    }

    /// The mouse.
    pub fn mouse(&mut self, mouse: MouseEvent) {
        let at = Position::new(mouse.column, mouse.row);
        let pressed = mouse.kind == MouseEventKind::Down(MouseButton::Left);
        let hit = |areas: &[Rect]| areas.iter().position(|area| area.contains(at));
        if let Some(dialog) = self.dialog.take() {
            match (pressed, hit(&self.choices), &dialog) {
                (true, Some(choice), _) => self.choose(dialog, choice),
                (true, None, Dialog::Help) => {}
                _ => self.dialog = Some(dialog),
            }
        } else if let (true, Some(tab)) = (pressed, hit(&self.tabs)) {
            self.note = None;
            self.show(tab);
        } else if self.body.contains(at) {
            if pressed {
                self.note = None;
            }
            if let Some(view) = self.views.get_mut(self.at) {
                let requests_of_view = view.mouse(mouse, &self.model);
                self.carry_out(requests_of_view);
            }
        }
        self.refresh_subscriptions();
    }
}
