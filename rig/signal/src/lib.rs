//! Time, quantities, values, addresses, events and the trace: the words that every other part speaks.
//!
//! Goals: exact integer time, events that carry how well their instant is known, a trace that is the
//! only ground for a verdict. Not goals: I/O, threads, clocks. Nothing in here reads a clock or opens a file.

pub mod address;
pub mod calendar;
mod can;
mod clock_error;
mod coverage;
mod event;
mod image;
mod quantity;
mod random;
mod recording;
mod serial;
mod single;
mod time;
pub mod trace;
mod value;

pub use address::{Address, AddressError, AddressLimits, Area, Size};
pub use can::{BusError, BusState, CanFrame, MAX_CAN_DATA};
pub use clock_error::ClockError;
pub use coverage::Coverage;
pub use event::{
    Cause, ClockDomain, Event, Policy, Sampling, SignalGap, SignalId, SignalInfo, ValueKind, When,
};
pub use image::Image;
pub use quantity::{Decimal, Quantity, QuantityError, QuantityFault, QuantityRange, Unit, is_range};
pub use random::Random;
pub use recording::SignalRecording;
pub use serial::{
    MAX_SERIAL_DATA, Parity, SerialErrors, SerialFlaw, SerialMessage, SerialOutput, SerialSettings,
};
pub use single::of_single;
pub use time::{Span, Time};
pub use trace::{Cursor, Events, EventsBetween, LoadLimits, Spill, Trace, TraceError};
pub use value::{Level, Value};
