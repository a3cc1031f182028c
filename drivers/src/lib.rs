//! Boards: the [`Board`] trait that the simulated and the real boards implement, the simulated board with its
//! wires, plants and faults, wrappers for any board, and the reader of board files.
//!
//! Goals: one way in and out for virtual and real time; every event with how well its instant is known; nothing
//! left driven. Not goals: addresses of the controller beyond their binding to channels, plans, the controller.

mod account;
mod board;
mod bus;
pub mod can;
pub mod circuit;
pub mod convert;
pub mod counter;
pub mod emit;
pub mod file;
pub mod gpio;
mod held;
mod holder;
pub mod inventory;
mod looped;
pub mod plant;
pub mod real;
mod realtime;
pub mod serial;
pub mod sim;
mod surroundings;
mod telling;
mod thread;
pub mod wrap;

pub use board::{
    Board, BoardError, BoardEvent, BoardExt, Buses, Call, Channel, ChannelId, ChannelKind, Descriptions,
    Emission, Emits, Fault, FaultInjection, FaultKind, FaultSet, Health, LossReason, NotEmitted, Origin,
    PulseOutputs, TimestampSource,
};
pub use bus::{Bus, BusError, BusEvent, BusId, BusKind, BusState, Frame, MAX_DATA};
pub use file::{
    Binding, Bite, BoardFile, BoardKind, CODES, ControlSettings, External, GuardSettings, OnDisconnect,
    OnLoss, Subject, SubjectLines, Terminals, UnknownSubject, WatchdogSettings, build, open, read,
};
pub use gpio::GpioBoard;
pub use held::{HeldLines, LineApi};
pub use holder::{Holder, holders};
pub use looped::Loop;
pub use realtime::RealtimeSettings;
pub use sim::{BusSpec, SimulatedBoard};
pub use surroundings::{Keeper, Surroundings};
pub use wrap::{Disturbance, Faulty};
