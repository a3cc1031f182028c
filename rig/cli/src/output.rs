//! What goes to the terminal.

use document::{Diagnostic, SourceFile};
use std::io::{IsTerminal, Write};

/// Whether standard error takes colour: a terminal, and the user did not forbid it.
pub fn color() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()) && std::io::stderr().is_terminal()
}

/// Whether standard output takes colour.
pub fn color_out() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()) && std::io::stdout().is_terminal()
}

/// Prints findings with the lines that they point into, on standard error.
pub fn findings(found: &[Diagnostic], sources: &[SourceFile]) {
    if !found.is_empty() {
        let text = document::render(found, sources, color());
        let _ = writeln!(std::io::stderr(), "{}", text.trim_end());
    }
}

/// Prints one line on standard error.
pub fn complain(text: &str) {
    let _ = writeln!(std::io::stderr(), "error: {text}");
}

/// Says something that is no error, on standard error.
pub fn note(text: &str) {
    let _ = writeln!(std::io::stderr(), "note: {text}");
}

/// Prints on standard output; a closed pipe is no fault.
pub fn print(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}
