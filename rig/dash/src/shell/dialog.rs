//! Dialogs: shown over the view until they are answered.

use super::Shell;
use super::menu::{self, MenuAction};
use crate::editor::{EditResult, Editor};
use control::{Forces, RequestOperation};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

/// Whom a line is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PromptTarget {
    /// The view at this place.
    View(usize),
    /// The lock: why it is locked.
    Lock,
}

/// What is shown over the view until it is answered.
#[derive(Clone, Debug)]
pub(super) enum Dialog {
    /// Keys and what they do.
    Help,
    /// The commands.
    Menu {
        /// The place of the chosen one.
        chosen: usize,
    },
    /// A question; yes asks the rig.
    Confirm { question: String, ask: RequestOperation },
    /// A line that is typed.
    Prompt { ask: String, editor: Editor, target: PromptTarget },
    /// What becomes of forces, before the end.
    Leave { chosen: usize },
}

/// What can be chosen before the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LeaveChoice {
    With(Forces),
    Stay,
}

impl Dialog {
    pub fn confirm(question: String, ask: RequestOperation) -> Dialog {
        Dialog::Confirm { question, ask }
    }

    pub fn prompt(ask: String, text: &str, view: usize) -> Dialog {
        Dialog::Prompt { ask, editor: Editor::new(text), target: PromptTarget::View(view) }
    }
}

impl Shell {
    /// What can be chosen before the end, with its key.
    pub(super) fn leave_choices(&self) -> Vec<(char, String, LeaveChoice)> {
        let end = if self.owns_rig { " and end the rig" } else { "" };
        let stay = ('s', "Stay".to_owned(), LeaveChoice::Stay);
        if self.owns_rig || self.model.status.forced.is_empty() {
            // A rig that ends drives everything to its safe value; forces end with it.
            return vec![('l', format!("Leave{end}"), LeaveChoice::With(Forces::Keep)), stay];
        }
        vec![
            ('k', "Keep the forces and leave".to_owned(), LeaveChoice::With(Forces::Keep)),
            ('r', "Release all forces and leave".to_owned(), LeaveChoice::With(Forces::Release)),
            stay,
        ]
    }

    /// The user wants to leave.
    pub(super) fn start_leaving(&mut self) {
        if self.model.gone.is_none() && (self.owns_rig || !self.model.status.forced.is_empty()) {
            self.dialog = Some(Dialog::Leave { chosen: 0 });
        } else {
            self.leave(Forces::Keep);
        }
    }

    /// How many things can be chosen in the dialog that is shown.
    fn choices_of(&self, dialog: &Dialog) -> usize {
        match dialog {
            Dialog::Menu { .. } => menu::entries(&self.model).len(),
            Dialog::Leave { .. } => self.leave_choices().len(),
            Dialog::Confirm { .. } => 2,
            Dialog::Help | Dialog::Prompt { .. } => 0,
        }
    }

    /// A key, while a dialog is shown.
    pub(super) fn dialog_key(&mut self, mut dialog: Dialog, key: KeyEvent) {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        if let Dialog::Prompt { ask, mut editor, target } = dialog {
            match editor.key(key) {
                EditResult::Editing => self.dialog = Some(Dialog::Prompt { ask, editor, target }),
                EditResult::Accepted => self.typed(&editor.text(), target),
                EditResult::Cancelled => {}
            }
            return;
        }
        let cancel = key.code == KeyCode::Esc || (control && key.code == KeyCode::Char('c'));
        if cancel || (matches!(dialog, Dialog::Help) && !control) {
            return;
        }
        let count = self.choices_of(&dialog);
        let choice = match (&mut dialog, key.code) {
            (Dialog::Confirm { .. }, KeyCode::Char('y' | 'Y')) => Some(0),
            (Dialog::Confirm { .. }, KeyCode::Char('n' | 'N')) => Some(1),
            (Dialog::Leave { .. }, KeyCode::Char(typed)) => {
                self.leave_choices().iter().position(|(key, ..)| *key == typed.to_ascii_lowercase())
            }
            (Dialog::Menu { .. }, KeyCode::Char(':' | 'q')) => return,
            (Dialog::Menu { chosen } | Dialog::Leave { chosen }, code) => {
                match code {
                    KeyCode::Up | KeyCode::BackTab => *chosen = (*chosen + count - 1) % count.max(1),
                    KeyCode::Down | KeyCode::Tab => *chosen = (*chosen + 1) % count.max(1),
                    KeyCode::Home => *chosen = 0,
                    KeyCode::End => *chosen = count.saturating_sub(1),
                    _ => {}
                }
                (code == KeyCode::Enter).then_some(*chosen)
            }
            _ => None,
        };
        match choice {
            Some(choice) => self.choose(dialog, choice),
            None => self.dialog = Some(dialog),
        }
    }

    /// Something was chosen in a dialog.
    pub(super) fn choose(&mut self, dialog: Dialog, choice: usize) {
        match dialog {
            Dialog::Confirm { ask, .. } if choice == 0 => self.request_for_user(ask),
            Dialog::Leave { .. } => match self.leave_choices().get(choice) {
                Some((_, _, LeaveChoice::With(forces))) => self.leave(*forces),
                Some((_, _, LeaveChoice::Stay)) | None => {}
            },
            Dialog::Menu { .. } => match menu::entries(&self.model).into_iter().nth(choice) {
                Some((_, MenuAction::Confirmed(ask))) => {
                    let question = menu::question(&ask, &self.model);
                    self.dialog = Some(Dialog::confirm(question, ask));
                }
                Some((_, MenuAction::Immediate(ask))) => self.request_for_user(ask),
                Some((_, MenuAction::Lock)) => {
                    let ask = "Lock the rig, because".to_owned();
                    self.dialog =
                        Some(Dialog::Prompt { ask, editor: Editor::default(), target: PromptTarget::Lock });
                }
                None => {}
            },
            _ => {}
        }
    }

    fn typed(&mut self, text: &str, target: PromptTarget) {
        match target {
            PromptTarget::Lock => {
                self.request_for_user(RequestOperation::Lock { note: text.trim().to_owned() })
            }
            PromptTarget::View(view) => {
                if let Some(view) = self.views.get_mut(view) {
                    let requests_of_view = view.typed(text, &self.model);
                    self.carry_out(requests_of_view);
                }
            }
        }
    }
}
