//! The expert functions of the controller: fast counters, pulse train outputs, pulse width modulation, frequency
//! generators. Edges in, effects out, beside the scan (io: sections 6, 7, 8 and 17).
//!
//! Time is an argument. [`ExpertFunctions`] takes the edges at the input terminals with their instants, calls of function blocks
//! and the controller's state, and hands back what its outputs are commanded and which events it raises, each with its
//! instant. Nothing ticks: [`ExpertFunctions::next`] says when something happens by itself.
//!
//! Goals: exact to the edge, whatever the profile and however the time is cut; tens of millions of edges a second; no
//! allocation after [`ExpertFunctions::new`]. Not goals: images, tasks and states of the controller (they are the crate
//! `controller`'s, which owns an `ExpertFunctions`), wires, the language of the blocks' caller.

mod assignment;
mod axis;
mod blocks;
mod config;
mod counter;
mod effect;
mod filter;
mod function_probe;
mod functions;
mod line_events;
mod operation;
mod wave;

pub use assignment::{ChannelRole, ExpertError, ExpertFault, ExpertWarning, ReservedChannels};
pub use axis::{
    AxisConfig, AxisFault, AxisParameterError, AxisRole, AxisState, DriveInput, PulseOutput, RampUnit,
};
pub use blocks::{BLOCKS, BlockCall, BlockPinKind, BlockPins, BlockType, PinType, ValueType};
pub use config::{ExpertConfig, FunctionConfig, FunctionKind};
pub use counter::{
    CaptureInput, CounterConfig, CounterFault, CounterKind, CounterMode, CounterRole, LimitsMode,
    PeriodMeasurement, PhaseMode, Reflex, SyncInput, Threshold, ThresholdEvent,
};
pub use effect::{ExpertEffect, ExpertEffects};
pub use filter::InputConditions;
pub use function_probe::FunctionProbe;
pub use functions::{ExpertFunctions, InputEdge};
pub use line_events::{LineEvents, RECORD};
pub use operation::ExpertOperation;
pub use wave::{WaveConfig, WaveRole};
