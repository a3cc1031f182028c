//! The controller's log in words.

use crate::application::catalogue::Catalogue;
use controller::{FaultClass, InternalError, LogEntry, Overload};

/// A log entry with the names of tasks, functions and sources, as far as they are known.
pub fn show(entry: &LogEntry, names: Option<&Catalogue>) -> String {
    let known = |place: usize| names.and_then(|names| names.task_name(place)).unwrap_or("?");
    let task = |place: usize| known(place).to_owned();
    match *entry {
        LogEntry::State { from, to } => format!("{from} -> {to}"),
        LogEntry::Stopped(cause) => format!("RUNNING left, stop cause {:02X} hex ({cause:?})", cause.code()),
        LogEntry::Boot { row } => format!("boot decision by row {row}"),
        LogEntry::Overrun { task: place, elapsed } => {
            format!("a cycle of {} took {elapsed}, longer than its interval", task(place))
        }
        LogEntry::WatchdogException { task: place, consecutive } => {
            format!("task watchdog exception of {}, {consecutive} in a row", task(place))
        }
        LogEntry::TaskWatchdog { task: place } => {
            format!("the task watchdog of {} stopped the application", task(place))
        }
        LogEntry::SystemWatchdog => {
            String::from("system watchdog: the tasks of priority 0 to 24 took the whole processor")
        }
        LogEntry::Starved { task: place } => {
            format!("system watchdog: {}, the task of the lowest priority, was not executed", task(place))
        }
        LogEntry::Overload(Overload::Tasks) => {
            String::from("system watchdog: the tasks took more than 85 % of the processor")
        }
        LogEntry::Overload(Overload::Freewheeling) => {
            String::from("system watchdog: less than 15 % was left for system processing")
        }
        // The text of the documents (controller:TASK-31).
        LogEntry::TooManyEvents => String::from("ISR Count Exceeded"),
        LogEntry::InternalError(InternalError::HardwareWatchdog) => {
            String::from("internal error: hardware watchdog")
        }
        LogEntry::InternalError(InternalError::Firmware) => {
            String::from("internal error: error of the firmware")
        }
        LogEntry::InternalError(InternalError::FirmwareException) => {
            String::from("internal error: exception of the firmware")
        }
        LogEntry::Warning(warning) => warning.show(known),
        LogEntry::Fault { task: place, fault } => {
            let class = match fault.class {
                FaultClass::Application => "application error",
                FaultClass::System => "system error",
            };
            let (code, file) = (fault.error.code(), names.and_then(|names| names.file_name(fault.file)));
            format!("{class} {code:04X} hex in {} at {}:{}", task(place), file.unwrap_or("?"), fault.line)
        }
        LogEntry::Load(error) => format!("application refused: {error}"),
        LogEntry::OnlineChange { code_only: true } => String::from("online change of code alone"),
        LogEntry::OnlineChange { code_only: false } => String::from("online change of code and variables"),
        LogEntry::ContextInvalid => String::from("the saved context of the remanent variables is not valid"),
        LogEntry::Overdriven { input } => {
            format!("out of specification: I{input} is driven faster than a regular input can follow")
        }
        LogEntry::FunctionOverdriven { function } => {
            let name = names.and_then(|names| names.function_name(function)).unwrap_or("?");
            format!("out of specification: {name} is driven faster than it can count")
        }
        LogEntry::OutboxFull { port, dropped } => {
            format!(
                "{port}: its endpoint sends more than waits there; {dropped} messages were not sent so far"
            )
        }
        LogEntry::PowerCycleDue => String::from("a power cycle is due: the last one was 365 days ago"),
        LogEntry::SupplyLost => String::from("the supply was interrupted"),
        LogEntry::SupplyBack => String::from("the supply came back within the hold-up time"),
    }
}
