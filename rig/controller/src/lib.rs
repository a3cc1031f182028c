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
mod context;
mod controller;
mod debug;
mod edges;
mod effect;
mod event;
mod exchange;
mod external;
mod files;
mod forcing;
mod front;
mod functions;
mod input;
mod led;
mod load;
mod log;
mod memory;
mod output;
mod plc_w;
mod previous;
mod protection;
mod registers;
mod release;
mod relocation;
mod rtc;

mod scan;
mod service;
mod startup;
mod state;
mod store;
mod system;
mod system_log;
mod task;
mod timers;
mod transition;
mod turn;
mod warnings;
mod watch;
mod watchdog;

pub use application::{
    Application, ApplicationFault, FaultClass, LoadError, Loader, Service, Slice, Stop, VariableReset,
};
pub use commands::{Channel, Command, DeviceReset, Refusal, WriteError};
pub use config::{
    AlwaysUpdate, BusCycle, Config, ConfigError, HaltOutputs, OutputsInStop, Rearming, StartingMode,
    TaskConfig, TaskKind, Watchdog, WatchdogBasis,
};
pub use controller::Controller;
pub use effect::{Effect, Effects, OutputState, Probe, ProbeId};
pub use event::EventSource;
pub use external::{Disturbance, FAULT_BITS};
pub use files::{FileError, FileFact, FileUser, LONGEST_PATH};
pub use front::Front;
pub use input::{InputConfig, InputFault, InputPart, RunStopFault};
pub use led::{Led, LedPattern};
pub use load::Overload;
pub use log::Entry;
pub use memory::Memory;
pub use registers::{RegisterError, RegisterFact};
pub use relocation::{Form, Located, Part, Relocation, Row};
pub use rtc::{RTC_BAD_DRIFT, RTC_OK, Rtc};
pub use state::State;
pub use store::{
    APPLICATION_FILE, CERTIFICATES_FOLDER, DATES_FILE, NonVolatile, POST_CONFIGURATION_FILE, RETAIN_FILES,
    RETAIN_MAP, RIGHTS_FILE, STATE_FILE,
};
pub use system::{SystemType, SystemVariable};
pub use task::{Figure, JITTER_BORDERS, JitterCounts, TaskFigures};
pub use warnings::Warning;
