//! The logic controller as a pure model: memory, tasks, watchdogs, states, inputs and outputs.
//!
//! Time is an argument and everything that happens is handed back as an [`Effect`]. The caller owns the clock: it
//! asks [`Controller::next_timer`] when something is due, lets application code run up to that instant with
//! [`Controller::run`], and then lets the timers act with [`Controller::fire`]. How finely the caller slices time
//! never shows in the results.
//!
//! Goals: the documented behaviour to the nanosecond of modelled time, the same on every host; no allocation inside
//! a scan. Not goals: clocks, threads, files, wires, the language of the application (see [`Application`]).

mod application;
mod boot;
mod change;
mod clocks;
mod commands;
mod config;
mod controller;
mod debug;
mod edges;
mod effect;
mod event;
mod exchange;
mod external;
mod files;
mod forcing;
mod front_panel;
mod functions;
mod input;
mod last_state;
mod led;
mod load;
mod log;
mod memory;
mod output;
mod plc_w;
mod protection;
mod registers;
mod release;
mod relocation;
mod remanent;
mod rtc;

mod scan;
mod service;
mod startup;
mod state;
mod store;
mod system;
mod system_log;
mod task;
mod time_slice;
mod timers;
mod transition;
mod warnings;
mod watch;
mod watchdog;

pub use application::{
    Application, ApplicationFault, FaultClass, LoadError, Loader, Slice, SliceEnd, SystemCall, VariableReset,
};
pub use commands::{Channel, Command, CommandError, DeviceReset, WriteError};
pub use config::{
    AlwaysUpdate, BusCycle, Config, ConfigError, HaltOutputs, OutputsInStop, Rearming, StartingMode,
    TaskConfig, TaskKind, Watchdog, WatchdogBasis,
};
pub use controller::Controller;
pub use effect::{Effect, Effects, OutputState, Probe, ProbeId};
pub use event::EventSource;
pub use external::{Disturbance, FAULT_BITS};
pub use files::{FileError, FileProbe, FileUser, LONGEST_PATH};
pub use front_panel::FrontPanel;
pub use input::{InputConfig, InputFault, InputProbe, RunStopFault};
pub use led::{Led, LedPattern};
pub use load::Overload;
pub use log::LogEntry;
pub use memory::Memory;
pub use registers::{RegisterError, RegisterProbe};
pub use relocation::{RegisterFormat, RelocationConfig, RelocationPart, RelocationRow, VariableLocation};
pub use rtc::{RTC_BAD_DRIFT, RTC_OK, Rtc};
pub use state::State;
pub use store::{
    APPLICATION_FILE, CERTIFICATES_FOLDER, DATES_FILE, NonVolatile, POST_CONFIGURATION_FILE, RETAIN_FILES,
    RETAIN_MAP, RIGHTS_FILE, STATE_FILE,
};
pub use system::{SystemType, SystemVariable};
pub use task::{JITTER_BORDERS, JitterCounts, TaskFigure, TaskFigures};
pub use warnings::Warning;
