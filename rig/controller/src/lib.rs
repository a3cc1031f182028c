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
mod command;
mod config;
mod context;
mod controller;
mod effect;
mod input;
mod log;
mod memory;
mod output;
mod scan;
mod state;
mod store;
mod task;
mod timers;
mod transition;
mod watch;

pub use application::{
    Application, ApplicationFault, FaultClass, LoadError, Loader, Slice, Stop, VariableReset,
};
pub use command::{Channel, Command, Refusal, WriteError};
pub use config::{
    Config, ConfigError, HaltOutputs, OutputsInStop, StartingMode, TaskConfig, TaskKind, Watchdog,
    WatchdogBasis,
};
pub use controller::Controller;
pub use effect::{Effect, Effects, Probe, ProbeId, SystemVariable};
pub use log::Entry;
pub use memory::Memory;
pub use state::State;
pub use store::{APPLICATION_FILE, NonVolatile, RETAIN_FILES, STATE_FILE};
pub use task::{Figure, TaskFigures};
