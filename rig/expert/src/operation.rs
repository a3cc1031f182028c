//! What the controller lets its functions do.

/// What the controller lets its functions do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExpertOperation {
    /// The application is RUNNING, at a breakpoint too (io:STD-PTO-13).
    Running,
    /// STOPPED or HALT: counters stop, pulses end (io:OUT-19, io:OUT-20).
    Stopped,
    /// No application, or no power.
    Off,
}
