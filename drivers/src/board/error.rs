//! Why a board did not do what it was asked.

use std::fmt;

use crate::bus::BusId;
use crate::channel::{ChannelId, NotEmitted};
use crate::event::LossReason;
use signal::{Span, Time};

/// The call of the operating system that failed on a real board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Call {
    /// Claiming lines or opening the device.
    Open,
    /// Driving lines.
    Write,
    /// Reading lines or events.
    Read,
    /// Changing the device's settings.
    Configure,
}

/// Why a board did not do what it was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BoardError {
    /// [`Board::start`](super::Board::start) was not called yet.
    NotStarted,
    /// Outputs are latched at their safe values until the next start.
    Latched,
    /// The board has no such channel.
    NoChannel(ChannelId),
    /// The board cannot drive this channel.
    NotDriven(ChannelId),
    /// The channel cannot emit such pulses.
    NotEmitted(ChannelId, NotEmitted),
    /// The value does not fit the channel: a level for an analog one, a number for a digital one, not finite.
    BadValue(ChannelId),
    /// This fault cannot be injected on this channel.
    NoSuchFault(ChannelId),
    /// A time of the fault is not above 0, or ends beyond the range of time.
    BadFaultTime(ChannelId),
    /// The channel has as many faults at once as can be.
    TooManyFaults {
        /// Which channel.
        channel: ChannelId,
        /// The limit.
        limit: u8,
    },
    /// A fault on one channel that may not be there together with one on another.
    FaultsApart {
        /// Where it was to be.
        channel: ChannelId,
        /// Where the other one is.
        other: ChannelId,
    },
    /// The call is older than one that was answered already.
    Backwards {
        /// Time of this call.
        now: Time,
        /// Time of the newest call before it.
        last: Time,
    },
    /// More changes in one call, or more on their way through delays, than the board holds: an oscillating
    /// circuit or a delay far longer than the pulses that it carries.
    Storm {
        /// When the limit was reached.
        at: Time,
        /// The limit.
        limit: u32,
    },
    /// The board has no such bus.
    NoBus(BusId),
    /// The frame does not fit the bus: too long, or CAN FD on a bus without it.
    BadFrame(BusId),
    /// The queue of the bus is full: it takes no frame before others are on the bus.
    BusFull(BusId),
    /// The device behind a channel is lost since before the start.
    Lost {
        /// The first of its channels.
        channel: ChannelId,
        /// Why.
        reason: LossReason,
        /// For how long, as far as that is known.
        since: Span,
    },
    /// The device of a bus is lost since before the start.
    BusLost {
        /// Which bus.
        bus: BusId,
        /// Why.
        reason: LossReason,
        /// For how long, as far as that is known.
        since: Span,
    },
    /// A call of the operating system failed.
    Os {
        /// Which one.
        call: Call,
        /// Its error number, as in `errno`.
        code: i32,
    },
}

impl fmt::Display for BoardError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotStarted => write!(f, "the board is not started"),
            Self::Latched => {
                write!(f, "the outputs are latched at their safe values until the board is started again")
            }
            Self::NoChannel(id) => write!(f, "the board has no channel {}", id.0),
            Self::NotDriven(id) => write!(f, "the board cannot drive channel {}", id.0),
            Self::NotEmitted(id, why) => write!(f, "channel {} does not emit this: {why}", id.0),
            Self::BadValue(id) => write!(f, "the value does not fit channel {}", id.0),
            Self::NoSuchFault(id) => write!(f, "this fault cannot be injected on channel {}", id.0),
            Self::BadFaultTime(id) => write!(f, "the times of a fault on channel {} must be above 0", id.0),
            Self::TooManyFaults { channel, limit } => {
                write!(f, "channel {} has {limit} faults already: clear it first", channel.0)
            }
            Self::FaultsApart { channel, other } => {
                write!(f, "channel {} takes no fault while one is on channel {}", channel.0, other.0)
            }
            Self::Backwards { now, last } => write!(f, "a call at {now} comes after one at {last}"),
            Self::Storm { at, limit } => {
                write!(f, "more than {limit} changes at once at {at}: look for wires that oscillate")
            }
            Self::NoBus(id) => write!(f, "the board has no bus {}", id.0),
            Self::BadFrame(id) => write!(f, "bus {} cannot send this", id.0),
            Self::BusFull(id) => write!(f, "the queue of bus {} is full", id.0),
            Self::Lost { channel, reason, since } => {
                write!(f, "channel {} is lost for {since}: its device {reason}", channel.0)
            }
            Self::BusLost { bus, reason, since } => {
                write!(f, "bus {} is lost for {since}: its device {reason}", bus.0)
            }
            Self::Os { call, code } => {
                let call = match call {
                    Call::Open => "claiming the lines",
                    Call::Write => "driving the lines",
                    Call::Read => "reading the lines",
                    Call::Configure => "setting up the device",
                };
                write!(f, "{call} failed with error number {code}")
            }
        }
    }
}

impl std::error::Error for BoardError {}
