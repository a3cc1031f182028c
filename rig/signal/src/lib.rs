//! Time, quantities, values, addresses, events and the trace: the words that every other part speaks.
//!
//! Goals: exact integer time, events that carry how well their instant is known, a trace that is the
//! only ground for a verdict. Not goals: I/O, threads, clocks. Nothing in here reads a clock or opens a file.

mod event;
mod time;
mod value;

pub use event::{Cause, ClockDomain, Event, Kind, Policy, Sampling, SignalId, SignalInfo, When};
pub use time::{ParseTimeError, Span, Time};
pub use value::{Level, Value};
