//! Stops of the application that nobody asked for: into HALT, or by a system error into EMPTY.

use crate::application::catalogue::Catalogue;
use crate::schedule::case_ending::StopByException;
use crate::subject::log;
use controller::{LogEntry, State};
use profile::StopCause;
use signal::Time;

/// A stop by an exception.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExceptionStop {
    /// When.
    pub at: Time,
    /// [`State::Halt`], or [`State::Empty`] where the controller boots by itself into it.
    pub state: State,
    /// What stopped it, where the controller said so.
    pub cause: Option<LogEntry>,
}

impl ExceptionStop {
    /// In words, by the case's own time, which began at `start`.
    pub fn noted(&self, start: Option<Time>, names: Option<&Catalogue>) -> StopByException {
        let when = match start {
            Some(start) if self.at >= start => format!("{} after the start", self.at - start),
            _ => String::from("before the start"),
        };
        let cause = self.cause.map_or_else(String::new, |cause| format!(": {}", log::show(&cause, names)));
        StopByException { state: self.state.name().to_owned(), what: format!("{when}{cause}") }
    }
}

/// Follows the controller's log and states.
#[derive(Debug, Default)]
pub(super) struct ExceptionWatch {
    /// The last entry that can be the cause of an exception.
    cause: Option<LogEntry>,
    /// The application was stopped by an exception, and the state that follows is not known yet.
    stopped: bool,
}

impl ExceptionWatch {
    /// The controller logs something.
    pub(super) fn log(&mut self, entry: &LogEntry) {
        match entry {
            LogEntry::Fault { .. }
            | LogEntry::TaskWatchdog { .. }
            | LogEntry::SystemWatchdog
            | LogEntry::Starved { .. }
            | LogEntry::Overload(_)
            | LogEntry::TooManyEvents
            | LogEntry::InternalError(_) => self.cause = Some(*entry),
            LogEntry::Stopped(cause) => {
                self.stopped = matches!(cause, StopCause::Exception | StopCause::HardwareWatchdog);
            }
            _ => {}
        }
    }

    /// The controller changes its state; whether that is a stop by an exception.
    pub(super) fn state(&mut self, at: Time, state: State) -> Option<ExceptionStop> {
        let cause = self.cause.take();
        // An internal error is a step of the plan, which asked for what it leads to.
        let is_asked_for = matches!(cause, Some(LogEntry::InternalError(_)));
        if !std::mem::take(&mut self.stopped) || is_asked_for {
            return None;
        }
        let state = if state == State::Halt { State::Halt } else { State::Empty };
        Some(ExceptionStop { at, state, cause })
    }
}
