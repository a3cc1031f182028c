//! Boards: the [`Board`] trait that the simulated and the real boards implement, the simulated board with its
//! wires, plants and faults, wrappers for any board, and the reader of board files.
//!
//! Goals: one way in and out for virtual and real time; every event with how well its instant is known; nothing
//! left driven. Not goals: addresses of the controller beyond their binding to channels, plans, the controller.

mod board;
pub mod circuit;
pub mod file;
pub mod plant;
pub mod sim;
pub mod wrap;

pub use board::{
    Board, BoardError, BoardEvent, Call, Channel, ChannelId, ChannelKind, Fault, FaultKind, FaultSet, Health,
    LossReason, Origin, TimestampSource,
};
pub use file::{Binding, BoardFile, CODES, Subject, Terminals, UnknownSubject, build, read};
pub use sim::SimulatedBoard;
pub use wrap::{Disturbance, Faulty, Traced};
