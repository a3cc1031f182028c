//! Events: what changed, when it can have happened, and who did it.

use std::fmt;

use crate::{Span, Time, Value};

/// The place of a signal in its trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SignalId(pub u32);

/// When something happened: at one instant within `[earliest, latest]`, both ends included.
///
/// A point in virtual time, around the kernel's timestamp on hardware, and (previous sample, this sample]
/// for a line that is only sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct When {
    /// Not before this instant.
    pub earliest: Time,
    /// Not after this instant.
    pub latest: Time,
}

impl When {
    /// Exactly at `at`.
    pub const fn exactly(at: Time) -> Self {
        When { earliest: at, latest: at }
    }

    /// Somewhere within `[earliest, latest]`; the ends are put in order.
    pub fn within(earliest: Time, latest: Time) -> Self {
        When { earliest: earliest.min(latest), latest: earliest.max(latest) }
    }
}

/// Who made a change: the last writer that a failed expectation names.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Cause {
    /// Nobody known.
    #[default]
    Unknown,
    /// The user's program: task by its place, source file by its place, line from 1.
    Program {
        /// Place of the task in the application.
        task: u8,
        /// Place of the source file in the application.
        file: u16,
        /// Line in that file, from 1.
        line: u32,
    },
    /// A step of the plan, by its place.
    Step(u16),
    /// The controller itself: a state change, a fallback, forcing.
    Controller,
    /// The board: a wire, a plant, a device.
    Board,
    /// Nobody: the value is [`Value::Unknown`] from then on, for this reason.
    Gap(SignalGap),
    /// A protocol endpoint at a port of the controller, by the port's number.
    Port(u8),
}

/// Why the value of a signal is not known, though its device is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SignalGap {
    /// A live zero is missing: there is nothing at the end of the wire.
    OpenWire,
    /// More than a sensor gives that works: it says that it fails, or its wire is shorted.
    Failed,
    /// At the lower end of the input's range, where there may be less.
    Below,
    /// At the upper end of the input's range, where there may be more.
    Above,
    /// A command of an output was taken back, or the case ended, within the delay of the output: its edge may have come out.
    Delay,
}

impl SignalGap {
    /// Each of them.
    pub const ALL: [SignalGap; 5] =
        [SignalGap::OpenWire, SignalGap::Failed, SignalGap::Below, SignalGap::Above, SignalGap::Delay];
}

impl fmt::Display for SignalGap {
    /// As a reason: `its wire is open`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SignalGap::OpenWire => "its wire is open",
            SignalGap::Failed => "its sensor fails or its wire is shorted",
            SignalGap::Below => "at the lower end of its range there may be less",
            SignalGap::Above => "at the upper end of its range there may be more",
            SignalGap::Delay => "within the delay of its output an edge may have come out",
        })
    }
}

/// What a signal's values are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ValueKind {
    /// [`Value::Bool`], [`Value::HighZ`] or [`Value::Unknown`].
    Bool,
    /// [`Value::Int`].
    Int,
    /// [`Value::Word`].
    Word,
    /// [`Value::Real`] or [`Value::Measured`].
    Real,
    /// [`Value::Int`] naming a state of [`SignalInfo::labels`].
    State,
    /// A happening without a value of its own (a step of the plan): [`Value::Int`] counting from 1.
    Mark,
}

/// Whose clock stamps a signal's events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ClockDomain {
    /// Modelled time: exact.
    #[default]
    Virtual,
    /// The host's monotonic clock.
    Monotonic,
    /// A device's own clock.
    Device,
}

/// How changes of a signal come to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sampling {
    /// Every edge is seen, stamped to within `resolution` (0 = exactly).
    Edges {
        /// Width of the stamp.
        resolution: Span,
    },
    /// Seen only when sampled, every `period`: shorter pulses can be missed.
    Sampled {
        /// Time between two samples.
        period: Span,
    },
}

/// Which changes of a signal the trace keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Policy {
    /// Every change.
    #[default]
    Changes,
    /// Numbers that moved by more than this since the last kept one; above 0, finite. What the signal is lies within
    /// the band around what the trace says.
    Deadband(f64),
    /// At most one value in this time, which is above 0. A change that comes sooner leaves the value unknown until
    /// the time is over; then the trace has what it is by then.
    AtMostEvery(Span),
}

/// What the trace says of a signal before its first event.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalInfo {
    /// The name that plans use.
    pub name: String,
    /// What its values are.
    pub kind: ValueKind,
    /// Unit of real values, as in `V`; empty for none.
    pub unit: String,
    /// Names of a state's numbers.
    pub labels: Vec<(i64, String)>,
    /// Whose clock stamps it.
    pub clock: ClockDomain,
    /// How changes come to be known.
    pub sampling: Sampling,
    /// The shortest pulse that is certain to be seen (0 = any).
    pub shortest_pulse: Span,
    /// Which changes are kept.
    pub policy: Policy,
}

impl SignalInfo {
    /// A signal of exactly stamped changes in virtual time, all kept.
    pub fn exact(name: impl Into<String>, kind: ValueKind) -> Self {
        SignalInfo {
            name: name.into(),
            kind,
            unit: String::new(),
            labels: Vec::new(),
            clock: ClockDomain::Virtual,
            sampling: Sampling::Edges { resolution: Span::ZERO },
            shortest_pulse: Span::ZERO,
            policy: Policy::Changes,
        }
    }

    /// A value in the words of the user: a state's label, or the number with its unit.
    pub fn show(&self, value: Value) -> String {
        if let (ValueKind::State, Some(n)) = (self.kind, value.as_int())
            && let Some((_, label)) = self.labels.iter().find(|(number, _)| i128::from(*number) == n)
        {
            return label.clone();
        }
        let is_number = !matches!(value, Value::Unknown | Value::HighZ);
        if self.unit.is_empty() || !is_number { value.to_string() } else { format!("{value} {}", self.unit) }
    }
}

/// One change of one signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// Which signal.
    pub signal: SignalId,
    /// When it happened.
    pub at: When,
    /// What it is from then on.
    pub value: Value,
    /// Who did it.
    pub cause: Cause,
}
