//! What goes to the terminal.

use crate::code_pages;
use crate::exit::ExitStatus;
use crate::line_queue::LineQueue;
use clap::ValueEnum;
use control::RequestFault;
use document::{Diagnostic, SourceFile};
use std::backtrace::{Backtrace, BacktraceStatus};
use std::io::{self, IsTerminal, Write};
use std::sync::OnceLock;
use std::time::Duration;

/// Whether to colour text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ColorChoice {
    /// On a terminal, unless NO_COLOR, CLICOLOR=0 or TERM=dumb forbid it; CLICOLOR_FORCE=1 wants it everywhere.
    #[default]
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// For a person or for a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum OutputFormat {
    /// Columns for a person.
    #[default]
    Table,
    /// JSON for a program.
    Json,
}

/// What the command line says; set once, before anything is printed.
static CHOICE: OnceLock<ColorChoice> = OnceLock::new();

/// Keeps what the command line says about colour.
pub fn choose_color(choice: ColorChoice) {
    // A second call could only come from a second command line, which there is none of.
    let _ = CHOICE.set(choice);
}

/// Whether standard error takes colour.
pub fn color() -> bool {
    takes_color(std::io::stderr().is_terminal())
}

/// Whether standard output takes colour.
pub fn color_out() -> bool {
    takes_color(std::io::stdout().is_terminal())
}

/// Whether a screen takes colour that has some: the command line and NO_COLOR have the last word.
pub fn color_on_screen(has: bool) -> bool {
    match CHOICE.get().copied().unwrap_or_default() {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => has && color_out(),
    }
}

fn takes_color(terminal: bool) -> bool {
    let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    decide(CHOICE.get().copied().unwrap_or_default(), terminal, &variable)
}

/// The rule: what the command line says, then <https://no-color.org>, then <https://bixense.com/clicolors>.
fn decide(choice: ColorChoice, terminal: bool, variable: &dyn Fn(&str) -> Option<String>) -> bool {
    match choice {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto if variable("NO_COLOR").is_some() => false,
        ColorChoice::Auto if variable("CLICOLOR_FORCE").is_some_and(|value| value != "0") => true,
        ColorChoice::Auto => {
            terminal
                && variable("CLICOLOR").is_none_or(|value| value != "0")
                && variable("TERM").is_none_or(|value| value != "dumb")
        }
    }
}

/// The queues of a command that no reader may hold up: standard output, standard error.
static QUEUES: OnceLock<[LineQueue; 2]> = OnceLock::new();

/// How long readers are waited for at the end of such a command, each.
const SETTLE: Duration = Duration::from_secs(1);

/// From now on nothing that is printed waits for its reader, not even the words of a panic: what a pipe or terminal does not
/// take in time is left out and counted. For a command that keeps outputs driven.
///
/// # Errors
/// The machine has no room for two threads.
pub fn never_wait() -> io::Result<()> {
    let queues = [LineQueue::start("output", io::stdout())?, LineQueue::start("errors", io::stderr())?];
    // There is one command, and it asks once.
    let _ = QUEUES.set(queues);
    std::panic::set_hook(Box::new(|panic| {
        let thread = std::thread::current();
        let mut text = format!("thread '{}' {panic}\n", thread.name().unwrap_or("without a name"));
        let trace = Backtrace::capture();
        if trace.status() == BacktraceStatus::Captured {
            text += &format!("{trace}\n");
        }
        print_error(&text);
    }));
    Ok(())
}

/// Waits until what was printed is read, where [`never_wait`] was called: for a second at most.
pub fn settle() {
    for queue in QUEUES.get().into_iter().flatten() {
        // What is left then is nobody's any more.
        let _ = queue.settle(SETTLE);
    }
}

/// Prints on standard error.
fn print_error(text: &str) {
    let _ = ErrorStream.write_all(text.as_bytes());
}

/// Standard error as this command uses it.
#[derive(Clone, Copy, Debug)]
pub struct ErrorStream;

impl Write for ErrorStream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match QUEUES.get() {
            Some([_, errors]) => {
                errors.put(bytes);
                Ok(bytes.len())
            }
            None => io::stderr().write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Prints findings with the lines that they point into, on standard error.
pub fn findings(found: &[Diagnostic], sources: &[SourceFile]) {
    if !found.is_empty() {
        let text = document::render(found, sources, color());
        print_error(&format!("{}\n", text.trim_end()));
    }
}

/// Prints findings that were not printed before: what is wrong with a suite is wrong for each of its plans.
pub fn new_findings(found: &[Diagnostic], shown: &mut Vec<Diagnostic>, sources: &[SourceFile]) {
    let new: Vec<Diagnostic> = found.iter().filter(|one| !shown.contains(one)).cloned().collect();
    findings(&new, sources);
    shown.extend(new);
}

/// Prints what is wrong with the arguments, and returns how the command ends.
pub fn refuse(code: &'static str, message: impl Into<String>, help: &str) -> ExitStatus {
    findings(&[Diagnostic::error(code, message).help(help)], &[]);
    ExitStatus::UserFiles
}

/// Prints why a rig did not do what it was asked for, on standard error. A newer rig may have codes without a page.
pub fn fault(fault: &RequestFault) {
    match code_pages::registered(&fault.code) {
        Some(code) => {
            let found = Diagnostic::error(code, fault.message.as_str());
            let found = if fault.help.is_empty() { found } else { found.help(fault.help.as_str()) };
            findings(&[found], &[]);
        }
        None => error(&format!("{} ({})", fault.message, fault.code)),
    }
}

/// Prints one line on standard error.
pub fn error(text: &str) {
    print_error(&format!("error: {text}\n"));
}

/// Prints a note on standard error.
pub fn note(text: &str) {
    print_error(&format!("note: {text}\n"));
}

/// Prints one line on standard error.
pub fn info(text: &str) {
    print_error(&format!("{text}\n"));
}

/// Prints on standard output; a closed pipe is no fault.
pub fn print(text: &str) {
    match QUEUES.get() {
        Some([output, _]) => output.put(text.as_bytes()),
        None => drop(io::stdout().write_all(text.as_bytes())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn colored(choice: ColorChoice, terminal: bool, set: &[(&str, &str)]) -> bool {
        let variable =
            |name: &str| set.iter().find(|(known, _)| *known == name).map(|(_, v)| (*v).to_owned());
        decide(choice, terminal, &variable)
    }

    #[test]
    fn the_user_decides_about_colour() {
        use ColorChoice::{Always, Auto, Never};
        assert!(colored(Auto, true, &[]) && !colored(Auto, false, &[]));
        assert!(!colored(Auto, true, &[("NO_COLOR", "1")]) && !colored(Auto, true, &[("CLICOLOR", "0")]));
        assert!(!colored(Auto, true, &[("TERM", "dumb")]) && colored(Auto, true, &[("TERM", "xterm")]));
        assert!(colored(Auto, false, &[("CLICOLOR_FORCE", "1")]));
        assert!(!colored(Auto, false, &[("CLICOLOR_FORCE", "0")]));
        assert!(!colored(Auto, false, &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]));
        assert!(colored(Always, false, &[("NO_COLOR", "1")]) && !colored(Never, true, &[]));
    }
}
