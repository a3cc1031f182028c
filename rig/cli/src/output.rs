//! What goes to the terminal.

use crate::code_pages;
use crate::exit::ExitStatus;
use crate::output_queues::{OutputQueues, Stream};
use clap::ValueEnum;
use control::RequestFault;
use document::{Diagnostic, SourceFile};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::backtrace::{Backtrace, BacktraceStatus};
use std::borrow::Cow;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

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

/// The queues of a command that prints through threads of their own.
static QUEUES: OnceLock<OutputQueues> = OnceLock::new();

/// From now on nothing that is printed waits for its reader, not even the words of a panic: what a pipe or terminal does not
/// take in time is left out and counted. For a command that keeps outputs driven.
///
/// # Errors
/// The machine has no room for two threads.
pub fn never_wait() -> io::Result<()> {
    // A stream that is closed is no fault: what goes there is lost.
    let queues = OutputQueues::start(None, |stream, text| drop(write_to(stream, text)), || {})?;
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

/// Whether whoever read standard output has closed it.
static UNREAD: AtomicBool = AtomicBool::new(false);

/// Whether whoever read standard output has closed it, as far as a [`wait_until`] found.
pub fn is_unread() -> bool {
    UNREAD.load(Ordering::Relaxed)
}

/// Whether standard output is a pipe that nobody reads any more.
fn is_closed() -> bool {
    let out = io::stdout();
    let mut polled = [PollFd::new(&out, PollFlags::empty())];
    let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
    poll(&mut polled, Some(&at_once)).is_ok() && polled[0].revents().contains(PollFlags::ERR)
}

/// From now on a reader of what is printed is waited for until an interrupt, and for a second after it. A terminal is
/// written to at once: an interrupt that is typed there empties it. With `ends_unread` a reader that closes its pipe is an interrupt.
///
/// # Errors
/// The machine has no room for two threads.
pub fn wait_until(interrupt: &'static AtomicBool, ends_unread: bool) -> io::Result<()> {
    let closed = move || {
        if ends_unread {
            UNREAD.store(true, Ordering::Relaxed);
            interrupt.store(true, Ordering::Relaxed);
        }
    };
    let write = move |stream, text: &[u8]| {
        let written = write_to(stream, text);
        // Nothing can be reported of what standard error does not take.
        if stream == Stream::Output {
            if matches!(&written, Err(error) if error.kind() == ErrorKind::BrokenPipe) {
                closed();
            }
            keep_fault(written);
        }
    };
    // A case may print nothing for hours.
    let idle = move || {
        if is_closed() {
            closed();
        }
    };
    let queues = OutputQueues::start(Some(interrupt), write, idle)?;
    // There is one command, and it asks once.
    let _ = QUEUES.set(queues);
    Ok(())
}

fn write_to(stream: Stream, text: &[u8]) -> io::Result<()> {
    match stream {
        Stream::Output => {
            let mut out = io::stdout();
            out.write_all(text).and_then(|()| out.flush())
        }
        Stream::Errors => io::stderr().write_all(text),
    }
}

/// The queues, where a text for this stream goes through them.
fn queues_of(stream: Stream) -> Option<&'static OutputQueues> {
    let is_terminal = || match stream {
        Stream::Output => io::stdout().is_terminal(),
        Stream::Errors => io::stderr().is_terminal(),
    };
    QUEUES.get().filter(|queues| !(queues.wait_for_readers() && is_terminal()))
}

/// Prints on standard error.
fn print_error(text: &str) {
    // Nothing can be reported of what standard error does not take.
    let _ = ErrorStream.write_all(harmless(text).as_bytes());
}

/// Standard error as this command uses it.
#[derive(Clone, Copy, Debug)]
pub struct ErrorStream;

impl Write for ErrorStream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let Some(queues) = queues_of(Stream::Errors) else { return io::stderr().write(bytes) };
        queues.put(Stream::Errors, bytes);
        Ok(bytes.len())
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

/// Prints on standard output; a closed pipe is no fault. What cannot be written otherwise [`finish`] reports.
pub fn print(text: &str) {
    let text = harmless(text);
    match queues_of(Stream::Output) {
        Some(queues) => queues.put(Stream::Output, text.as_bytes()),
        None => keep_fault(io::stdout().write_all(text.as_bytes())),
    }
}

/// Prints a piece of what goes on and on; `false` where nobody reads it any more.
pub fn print_piece(text: &str) -> bool {
    let mut out = std::io::stdout();
    let written = out.write_all(harmless(text).as_bytes()).and_then(|()| out.flush());
    let open = !matches!(&written, Err(error) if error.kind() == ErrorKind::BrokenPipe);
    keep_fault(written);
    open
}

/// The first fault of standard output, a closed pipe apart.
static LOST: OnceLock<String> = OnceLock::new();

fn keep_fault(written: std::io::Result<()>) {
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
    {
        // Later ones follow from it.
        let _ = LOST.set(error.to_string());
    }
}

/// How the command ends: with an error of its own where standard output did not take all that was printed, whatever it
/// came to otherwise.
pub fn finish(exit: ExitStatus) -> ExitStatus {
    match QUEUES.get() {
        Some(queues) => queues.settle(),
        None => keep_fault(io::stdout().flush()),
    }
    let Some(why) = LOST.get() else { return exit };
    let found = Diagnostic::error("R0232", format!("standard output cannot be written: {why}"));
    findings(&[found.help("make room, or write it elsewhere: what was printed is not whole")], &[]);
    if let Some(queues) = QUEUES.get() {
        queues.settle();
    }
    match exit {
        ExitStatus::Interrupted | ExitStatus::Unread => exit,
        _ => ExitStatus::Error,
    }
}

/// A text without what a terminal acts on: names of files, cases and signals may hold control characters, and marks that
/// turn the direction of writing. They are written as JSON writes them, so that JSON stays what it is. Colours and bold
/// type, which the rig itself writes, stay.
pub fn harmless(text: &str) -> Cow<'_, str> {
    let acts = |c: char| {
        c.is_control() && !matches!(c, '\n' | '\t')
            || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        if let Some(length) = style(rest) {
            shown.push_str(&rest[..length]);
            rest = &rest[length..];
            continue;
        }
        match acts(first) {
            true => shown.push_str(&format!("\\u{:04x}", u32::from(first))),
            false => shown.push(first),
        }
        rest = &rest[first.len_utf8()..];
    }
    Cow::Owned(shown)
}

/// The length of the sequence for colour or bold type that a text begins with.
fn style(text: &str) -> Option<usize> {
    let inner = text.strip_prefix("\u{1b}[")?;
    let end = inner.find('m').filter(|end| *end <= 16)?;
    let mut numbers = inner[..end].split(';');
    // Nothing that hides text: no inverse, no concealed, no background.
    let is_style = |number: &str| match number {
        "" | "0" | "1" | "2" | "4" | "22" | "39" => true,
        number => number.parse().is_ok_and(|number: u8| matches!(number, 30..=37 | 90..=97)),
    };
    let is_right = match inner[..end].strip_prefix("38;5;") {
        Some(number) => number.parse::<u8>().is_ok(),
        None => numbers.all(is_style),
    };
    is_right.then_some("\u{1b}[".len() + end + 1)
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
    fn a_name_cannot_act_on_the_terminal() {
        assert_eq!(harmless("lamp\u{1b}]0;title\u{7}\n\tx"), "lamp\\u001b]0;title\\u0007\n\tx");
        assert_eq!(harmless("a\u{9b}2J\r\u{202e}b\u{7f}"), "a\\u009b2J\\u000d\\u202eb\\u007f");
        assert_eq!(
            harmless("\u{1b}[8mhidden\u{1b}[7m\u{1b}[2J\u{1b}[38;2;0m"),
            "\\u001b[8mhidden\\u001b[7m\\u001b[2J\\u001b[38;2;0m"
        );
        for own in ["\u{1b}[32mPASS\u{1b}[0m", "\u{1b}[1m\u{1b}[91merror\u{1b}[0m", "\u{1b}[38;5;9mx\u{1b}[m"]
        {
            assert_eq!(harmless(own), own);
        }
        let name = format!("{}\n", serde_json::json!({ "case": "a\u{9b}b\u{1b}" }));
        let read: serde_json::Value = serde_json::from_str(&harmless(&name)).unwrap();
        assert_eq!(read["case"], "a\u{9b}b\u{1b}");
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
