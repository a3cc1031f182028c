//! The logic controller as a pure model: memory, tasks, watchdogs, states, inputs and outputs.
//!
//! Time is an argument and everything that happens is handed back as an [`Effect`]. The caller owns the clock: it
//! asks [`Controller::next_timer`] when something is due, lets application code run up to that instant with
//! [`Controller::run`], and then lets the timers act with [`Controller::fire`]. How finely the caller slices time
//! never shows in the results.
//!
//! Goals: the documented behaviour to the nanosecond of modelled time, the same on every host; no allocation inside
//! a scan. Not goals: clocks, threads, files, wires, the language of the application (see [`Application`]).

mod analogue;
mod application;
mod boot;
mod bus;
mod cartridge;
mod clocks;
mod command;
mod config;
mod controller;
mod effect;
mod endpoint;
mod event_source;
mod external;
mod files;
mod first_cycle;
mod io;
mod last_state;
mod led;
mod location;
mod log;
mod memory;
mod module;
mod modules;
mod ports;
mod power;
mod probe;
mod probes;
mod register_access;
mod registers;
mod relocation;
mod remanent;
mod rtc;
mod scheduler;
mod state;
mod store;
mod system;
mod system_log;
mod system_words;
mod terminal;

pub use application::{
    Application, ApplicationFault, FaultClass, LoadError, Loader, Slice, SliceEnd, SystemCall, VariableReset,
};
pub use bus::{BusStart, ConfiguredPosition, ExtraModules, ForcedPlaces, PositionState, compare_modules};
pub use command::{Command, CommandError, DeviceReset, WriteError};
pub use config::{
    AlwaysUpdate, BusCycle, Config, ConfigError, HaltOutputs, InputConfig, InputFault, OutputsInStop,
    Rearming, RelocationConfig, RelocationPart, RunStopFault, StartingMode, TaskConfig, TaskKind,
    TaskWatchdog, Warning, WatchdogBasis, is_module_modelled,
};
pub use controller::{Controller, FrontPanel};
pub use effect::{Effect, Effects};
pub use endpoint::{
    Endpoint, OUTBOX_MESSAGES, OutboxFull, PortEvent, PortLife, PortMessage, PortOutbox, SerialBytes,
};
pub use event_source::ExternalEventSource;
pub use external::{Disturbance, FAULT_BITS, InternalError, ModuleFault};
pub use files::{FileError, FileProbe, FileUser, LONGEST_PATH};
pub use io::ForcedChannels;
pub use led::{Led, LedPattern};
pub use location::{ExtentStart, RegisterFormat, VariableLocation};
pub use log::LogEntry;
pub use memory::Memory;
pub use module::{ExchangeCycle, IoModule, ModuleChannel, OutputChanges, Sharing, TaskModule, Written};
pub use ports::PortStatus;
pub use probe::{InputProbe, OutputState, Probe, ProbeId, RegisterProbe};
pub use register_access::{Identification, RegisterAccess};
pub use registers::RegisterError;
pub use relocation::RelocationRow;
pub use rtc::{RTC_BAD_DRIFT, RTC_OK, Rtc};
pub use scheduler::{JITTER_BORDERS, JitterCounts, Overload, TaskFigure, TaskFigures};
pub use state::State;
pub use store::{
    APPLICATION_FILE, CERTIFICATES_FOLDER, DATES_FILE, NonVolatile, POST_CONFIGURATION_FILE, RETAIN_FILES,
    RETAIN_MAP, RIGHTS_FILE, STATE_FILE,
};
pub use terminal::Terminal;
