//! The person at the terminal, who answers what steps ask.

use crate::output;
use crate::typed_lines::{TypedLine, TypedLines};
use plans::steps::Question;
use runtime::{AskError, Operator};
use std::io::{IsTerminal, Write};
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

/// Somebody at the terminal.
#[derive(Debug, Default)]
pub struct TerminalOperator {
    /// The lines that are typed, once somebody was asked.
    lines: Mutex<Option<TypedLines>>,
}

impl TerminalOperator {
    /// Somebody who can be asked.
    pub fn if_present() -> Option<TerminalOperator> {
        is_present().then(TerminalOperator::default)
    }
}

/// Whether there is somebody who can be asked: standard input and standard error are a terminal, and no CI runs this.
pub fn is_present() -> bool {
    let watched = std::env::var_os("CI").is_none_or(|ci| ci.is_empty() || ci == "false");
    watched && std::io::stdin().is_terminal() && std::io::stderr().is_terminal()
}

/// The answer that a line gives: itself in any case of letters, its number, or a beginning that no other has.
fn chosen(line: &str, answers: &[String]) -> Option<usize> {
    let line = line.trim();
    let number = line.parse::<usize>().ok().filter(|n| (1..=answers.len()).contains(n));
    if let Some(number) = number {
        return Some(number - 1);
    }
    if let Some(whole) = answers.iter().position(|answer| answer.to_lowercase() == line.to_lowercase()) {
        return Some(whole);
    }
    let begins = |answer: &String| answer.to_lowercase().starts_with(&line.to_lowercase());
    let mut begun = answers.iter().enumerate().filter(|(_, answer)| !line.is_empty() && begins(answer));
    match (begun.next(), begun.next()) {
        (Some((one, _)), None) => Some(one),
        _ => None,
    }
}

impl Operator for TerminalOperator {
    fn ask(&self, step: &str, question: &Question, interrupt: &AtomicBool) -> Result<usize, AskError> {
        let mut kept = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.is_none() {
            *kept = TypedLines::start().ok();
        }
        let Some(lines) = kept.as_ref() else { return Err(AskError::Nobody) };
        // What was typed before the question is no answer to it.
        lines.forget_waiting();
        let mut text = format!("\n{step}: {}\n", question.text);
        if let Some(photo) = &question.photo {
            text.push_str(&format!("  see {photo}\n"));
        }
        for (place, answer) in question.answers.iter().enumerate() {
            text.push_str(&format!("  {} {answer}\n", place + 1));
        }
        let mut out = std::io::stderr();
        let _ = out.write_all(output::harmless(&text).as_bytes());
        loop {
            let _ = out.write_all(b"> ");
            let _ = out.flush();
            let line = match lines.next(interrupt) {
                TypedLine::Line(line) => line,
                TypedLine::Interrupted => return Err(AskError::Interrupted),
                TypedLine::End | TypedLine::Failed(_) => return Err(AskError::Nobody),
            };
            match chosen(&line, &question.answers) {
                Some(answer) => return Ok(answer),
                None => {
                    output::info(&format!("answer one of: {}", question.answers.join(", ")));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::chosen;

    #[test]
    fn an_answer_is_taken_as_people_type_it() {
        let answers: Vec<String> = ["green", "grey", "red"].map(str::to_owned).to_vec();
        for (line, place) in [("green", 0), (" GREY ", 1), ("r", 2), ("3", 2), ("gree", 0)] {
            assert_eq!(chosen(line, &answers), Some(place), "{line}");
        }
        for line in ["", "gr", "4", "0", "blue"] {
            assert_eq!(chosen(line, &answers), None, "{line}");
        }
    }
}
