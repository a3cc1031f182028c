//! Boards: the [`Board`] trait that the simulated and the real boards implement, the simulated board with its
//! wires, plants and faults, wrappers for any board, and the reader of board files.
//!
//! Goals: one way in and out for virtual and real time; every event with how well its instant is known; nothing
//! left driven. Not goals: addresses of the controller beyond their binding to channels, plans, the controller.

pub mod adc;
mod board;
mod bus;
pub mod can;
mod channel;
mod channel_table;
pub mod circuit;
mod codes;
mod context;
pub mod counter;
pub mod counting;
mod course;
mod device_board;
mod device_file;
mod device_limits;
mod event;
mod event_collector;
pub mod file;
pub mod generator;
mod gone;
pub mod gpio;
mod holder;
pub mod inventory;
mod loopback;
pub mod measure;
mod number;
mod output_claim;
pub mod plant;
pub mod real;
mod realtime;
mod refusal;
mod run_state;
mod sampled;
pub mod sensor;
pub mod serial;
pub mod sim;
mod thread;
pub mod wrap;

pub use board::{
    Board, BoardError, BoardExt, Buses, Call, Descriptions, FaultInjection, PlantParameters, PulseOutputs,
};
pub use bus::{Bus, BusEvent, BusId, BusKind};
pub use channel::{
    Channel, ChannelId, ChannelKind, Emission, Fault, FaultKind, FaultSet, NotEmitted, PulseCapability,
    TimestampSource,
};
pub use channel_table::ChannelTable;
pub use circuit::{BusSpec, PlantFault};
pub use context::{BoardContext, OutputGuard};
pub use course::Course;
pub use device_board::Reopen;
pub use device_limits::DeviceLimits;
pub use event::{BoardEvent, Health, LossReason, Origin};
pub use file::{
    Binding, Bite, BoardFile, BoardKind, CODES, ControlSettings, External, GuardSettings, OnDisconnect,
    OnLoss, PortBinding, Subject, SubjectLines, SubjectPort, SubjectPortKind, Terminals, UnknownSubject,
    WatchdogSettings, build, open, read, read_with_programs,
};
pub use gpio::GpioBoard;
pub use holder::{Holder, holders};
pub use loopback::LoopbackPair;
pub use output_claim::{LineApi, OutputClaim};
pub use realtime::RealtimeSettings;
pub use refusal::Refusal;
pub use signal::{BusError, BusState};
pub use sim::SimulatedBoard;
pub use wrap::{Disturbance, Faulty};
