//! A line that is being typed.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

/// The most characters of a line.
const LONGEST: usize = 240;

/// A line that is being typed, and the place in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Editor {
    line: Vec<char>,
    at: usize,
    /// It is still what it began with: what is typed first takes its place.
    proposed: bool,
}

/// What a key did to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EditResult {
    /// It goes on.
    Editing,
    /// It is as the user wants it.
    Accepted,
    /// It is not wanted.
    Cancelled,
}

impl Editor {
    /// A line with a text to begin with, and the place after it. What is typed first takes the text's place; who moves
    /// or deletes first edits it.
    pub fn new(text: &str) -> Editor {
        let mut editor = Editor::default();
        editor.insert(text);
        editor.proposed = !editor.line.is_empty();
        editor
    }

    /// Whether what is typed next takes the place of the text.
    pub fn is_proposed(&self) -> bool {
        self.proposed
    }

    /// The line.
    pub fn text(&self) -> String {
        self.line.iter().collect()
    }

    /// What of it fits into some columns, and the column of the place.
    pub fn window(&self, width: usize) -> (String, usize) {
        let first = (self.at + 1).saturating_sub(width);
        (self.line.iter().skip(first).take(width).collect(), self.at - first)
    }

    /// Puts a text in at the place: what is pasted comes so, too. Line ends and other controls are left out.
    pub fn insert(&mut self, text: &str) {
        if std::mem::take(&mut self.proposed) {
            self.line.clear();
            self.at = 0;
        }
        for character in text.chars().filter(|character| !character.is_control()) {
            if self.line.len() == LONGEST {
                return;
            }
            self.line.insert(self.at, character);
            self.at += 1;
        }
    }

    /// A key, as shells take them.
    pub fn key(&mut self, key: KeyEvent) -> EditResult {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        self.proposed &= !control && matches!(key.code, KeyCode::Char(_));
        match key.code {
            KeyCode::Enter => return EditResult::Accepted,
            KeyCode::Esc => return EditResult::Cancelled,
            KeyCode::Char('c' | 'g') if control => return EditResult::Cancelled,
            KeyCode::Char('a') if control => self.at = 0,
            KeyCode::Char('e') if control => self.at = self.line.len(),
            KeyCode::Char('u') if control => drop(self.line.drain(..std::mem::take(&mut self.at))),
            KeyCode::Char('k') if control => self.line.truncate(self.at),
            KeyCode::Char('w') if control => {
                let word = self.line[..self.at].iter().rev().skip_while(|c| **c == ' ');
                let word = word.skip_while(|c| **c != ' ').count();
                self.line.drain(word..self.at);
                self.at = word;
            }
            KeyCode::Char(_) if control => {}
            KeyCode::Char(character) => self.insert(character.encode_utf8(&mut [0; 4])),
            KeyCode::Backspace if self.at > 0 => {
                self.at -= 1;
                self.line.remove(self.at);
            }
            KeyCode::Delete if self.at < self.line.len() => drop(self.line.remove(self.at)),
            KeyCode::Left => self.at = self.at.saturating_sub(1),
            KeyCode::Right => self.at = (self.at + 1).min(self.line.len()),
            KeyCode::Home => self.at = 0,
            KeyCode::End => self.at = self.line.len(),
            _ => {}
        }
        EditResult::Editing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(editor: &mut Editor, keys: &[(KeyCode, bool)]) -> EditResult {
        let mut edited = EditResult::Editing;
        for (code, control) in keys {
            let modifiers = if *control { KeyModifiers::CONTROL } else { KeyModifiers::NONE };
            edited = editor.key(KeyEvent::new(*code, modifiers));
        }
        edited
    }

    #[test]
    fn lines_are_edited_as_in_a_shell() {
        use KeyCode::{Backspace, Char, Delete, End, Enter, Home, Left};
        let mut editor = Editor::new("motor one=1");
        press(&mut editor, &[(Left, false), (Backspace, false), (Char(':'), false)]);
        assert_eq!(editor.text(), "motor one:1");
        press(&mut editor, &[(Char('w'), true)]);
        assert_eq!(editor.text(), "motor 1");
        press(&mut editor, &[(Home, false), (Delete, false), (End, false), (Char('ü'), false)]);
        assert_eq!(editor.text(), "otor 1ü");
        press(&mut editor, &[(Left, false), (Char('u'), true)]);
        assert_eq!(editor.text(), "ü");
        assert_eq!(press(&mut editor, &[(Enter, false)]), EditResult::Accepted);
        assert_eq!(press(&mut editor, &[(Char('c'), true)]), EditResult::Cancelled);
    }

    #[test]
    fn a_proposal_is_taken_replaced_or_edited() {
        let mut taken = Editor::new("TRUE");
        assert_eq!(
            (press(&mut taken, &[(KeyCode::Enter, false)]), taken.text()),
            (EditResult::Accepted, "TRUE".to_owned())
        );
        let mut replaced = Editor::new("TRUE");
        press(&mut replaced, &[(KeyCode::Char('1'), false), (KeyCode::Char('2'), false)]);
        assert_eq!(replaced.text(), "12");
        let mut edited = Editor::new("trend.vcd");
        press(&mut edited, &[(KeyCode::Home, false), (KeyCode::Char('a'), false)]);
        assert_eq!(edited.text(), "atrend.vcd");
    }

    #[test]
    fn what_is_pasted_has_no_ends_and_an_end() {
        let mut editor = Editor::new("a\nb\x1b[2J\tc");
        assert_eq!(editor.text(), "ab[2Jc");
        press(&mut editor, &[(KeyCode::End, false)]);
        editor.insert(&"x".repeat(10_000));
        assert_eq!(editor.text().chars().count(), LONGEST);
        let (seen, at) = editor.window(10);
        assert_eq!((seen.as_str(), at), ("xxxxxxxxx", 9));
    }
}
