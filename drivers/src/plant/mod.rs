//! Plants: what the controller's outputs act on and its inputs come from.

mod lag;

use std::fmt;

use signal::{Time, Value};

pub use lag::Lag;

/// A model of a process in closed form between two changes of its inputs: it never ticks.
///
/// Times never go backwards. Inputs and outputs are counted from 0 in the order of the plant's own description.
pub trait Plant: Send + fmt::Debug {
    /// Back to the initial state, with every input undriven.
    fn start(&mut self, now: Time);

    /// From `now` on an input has this value. What was due at `now` stays due; what the input brings about comes
    /// later than `now`.
    fn input(&mut self, now: Time, port: usize, value: Value);

    /// When an output will next change if no input does; after a call of [`Plant::advance`] later than its `now`.
    fn next_event(&self) -> Option<Time>;

    /// Brings the outputs to what they are at `now`.
    fn advance(&mut self, now: Time);

    /// The outputs as of the last start or advance.
    fn outputs(&self) -> &[Value];
}
