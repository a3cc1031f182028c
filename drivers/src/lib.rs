//! Boards: the [`Board`] trait that the simulated and the real boards implement, the simulated board with its
//! wires, plants and faults, wrappers for any board, and the reader of board files.
//!
//! Goals: one way in and out for virtual and real time; every event with how well its instant is known; nothing
//! left driven. Not goals: addresses of the controller beyond their binding to channels, plans, the controller.

pub mod adc;
mod board;
mod bus;
pub mod can;
pub mod circuit;
mod context;
pub mod counter;
mod event_collector;
pub mod file;
pub mod generator;
pub mod gpio;
mod holder;
pub mod inventory;
mod loopback;
mod output_claim;
pub mod plant;
pub mod real;
mod realtime;
mod run_state;
pub mod serial;
pub mod sim;
mod thread;
pub mod wrap;

pub use board::{
    Board, BoardError, BoardEvent, BoardExt, Buses, Call, Channel, ChannelId, ChannelKind, Descriptions,
    Emission, Fault, FaultInjection, FaultKind, FaultSet, Health, LossReason, NotEmitted, Origin,
    PulseCapability, PulseOutputs, TimestampSource,
};
pub use bus::{Bus, BusError, BusEvent, BusId, BusKind, BusState, Frame, MAX_DATA};
pub use context::{BoardContext, OutputGuard};
pub use file::{
    Binding, Bite, BoardFile, BoardKind, CODES, ControlSettings, External, GuardSettings, OnDisconnect,
    OnLoss, Subject, SubjectLines, Terminals, UnknownSubject, WatchdogSettings, build, open, read,
};
pub use gpio::GpioBoard;
pub use holder::{Holder, holders};
pub use loopback::LoopbackPair;
pub use output_claim::{LineApi, OutputClaim};
pub use realtime::RealtimeSettings;
pub use sim::{BusSpec, SimulatedBoard};
pub use wrap::{Disturbance, Faulty};
