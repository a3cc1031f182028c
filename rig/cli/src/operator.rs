//! The person at the terminal, who answers what steps ask.

use plans::steps::Question;
use runtime::{AskError, Operator};
use std::io::{BufRead, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Mutex, PoisonError, mpsc};
use std::time::Duration;

/// How long an interrupt may go unseen while somebody thinks.
const INTERRUPT_POLL: Duration = Duration::from_millis(100);

/// Somebody at the terminal.
#[derive(Debug, Default)]
pub struct TerminalOperator {
    /// The lines that are typed, once somebody was asked.
    lines: Mutex<Option<Receiver<String>>>,
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

/// Reads lines beside the run, so that waiting for one can end without one.
fn lines() -> Receiver<String> {
    let (send, receive) = mpsc::channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            let Ok(line) = line else { return };
            if send.send(line).is_err() {
                return;
            }
        }
    });
    receive
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
        let lines = kept.get_or_insert_with(lines);
        // What was typed before the question is no answer to it.
        while lines.try_recv().is_ok() {}
        let mut text = format!("\n{step}: {}\n", question.text);
        if let Some(photo) = &question.photo {
            text.push_str(&format!("  see {photo}\n"));
        }
        for (place, answer) in question.answers.iter().enumerate() {
            text.push_str(&format!("  {} {answer}\n", place + 1));
        }
        let mut out = std::io::stderr();
        let _ = out.write_all(text.as_bytes());
        loop {
            let _ = out.write_all(b"> ");
            let _ = out.flush();
            let line = loop {
                if interrupt.load(Ordering::Relaxed) {
                    return Err(AskError::Interrupted);
                }
                match lines.recv_timeout(INTERRUPT_POLL) {
                    Ok(line) => break line,
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => return Err(AskError::Nobody),
                }
            };
            match chosen(&line, &question.answers) {
                Some(answer) => return Ok(answer),
                None => {
                    let _ = writeln!(out, "answer one of: {}", question.answers.join(", "));
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
