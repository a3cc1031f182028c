//! Why a board did not do what it was asked.

use thiserror::Error;

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

impl Call {
    /// The call in words, as in `driving the lines`.
    const fn words(self) -> &'static str {
        match self {
            Call::Open => "claiming the lines",
            Call::Write => "driving the lines",
            Call::Read => "reading the lines",
            Call::Configure => "setting up the device",
        }
    }
}

/// Why a board did not do what it was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum BoardError {
    /// [`Board::start`](super::Board::start) was not called yet.
    #[error("the board is not started")]
    NotStarted,
    /// Outputs are latched at their safe values until the next start.
    #[error("the outputs are latched at their safe values until the board is started again")]
    Latched,
    /// The board has no such channel.
    #[error("the board has no channel {}", .0.0)]
    NoChannel(ChannelId),
    /// The board cannot drive this channel.
    #[error("the board cannot drive channel {}", .0.0)]
    NotDriven(ChannelId),
    /// The channel cannot emit such pulses.
    #[error("channel {} does not emit this: {}", .0.0, .1)]
    NotEmitted(ChannelId, #[source] NotEmitted),
    /// The value does not fit the channel: a level for an analog one, a number for a digital one, not finite.
    #[error("the value does not fit channel {}", .0.0)]
    BadValue(ChannelId),
    /// This fault cannot be injected on this channel.
    #[error("this fault cannot be injected on channel {}", .0.0)]
    NoSuchFault(ChannelId),
    /// A time of the fault is not above 0, or ends beyond the range of time.
    #[error("the times of a fault on channel {} must be above 0", .0.0)]
    BadFaultTime(ChannelId),
    /// The channel has as many faults at once as can be.
    #[error("channel {} has {limit} faults already: clear it first", .channel.0)]
    TooManyFaults {
        /// Which channel.
        channel: ChannelId,
        /// The limit.
        limit: u8,
    },
    /// A fault on one channel that may not be there together with one on another.
    #[error("channel {} takes no fault while one is on channel {}", .channel.0, .other.0)]
    FaultsApart {
        /// Where it was to be.
        channel: ChannelId,
        /// Where the other one is.
        other: ChannelId,
    },
    /// The call is older than one that was answered already.
    #[error("a call at {now} comes after one at {last}")]
    Backwards {
        /// Time of this call.
        now: Time,
        /// Time of the newest call before it.
        last: Time,
    },
    /// More changes in one call, or more on their way through delays, than the board holds: an oscillating
    /// circuit or a delay far longer than the pulses that it carries.
    #[error("more than {limit} changes at once at {at}: look for wires that oscillate")]
    Storm {
        /// When the limit was reached.
        at: Time,
        /// The limit.
        limit: u32,
    },
    /// A plant came to its end: [`Board::plant_fault`](super::Board::plant_fault) says which one and why. It is reported once.
    #[error("a plant failed at {0}")]
    PlantFailed(Time),
    /// The board has no such plant.
    #[error("the board has no plant {0}")]
    NoPlant(usize),
    /// The board has no such bus.
    #[error("the board has no bus {}", .0.0)]
    NoBus(BusId),
    /// The frame does not fit the bus: too long, or CAN FD on a bus without it.
    #[error("bus {} cannot send this", .0.0)]
    BadFrame(BusId),
    /// The bus cannot carry bytes in this way.
    #[error("bus {} does not take these settings", .0.0)]
    BadSettings(BusId),
    /// The queue of the bus is full: it takes no frame before others are on the bus.
    #[error("the queue of bus {} is full", .0.0)]
    BusFull(BusId),
    /// The device behind a channel is lost since before the start.
    #[error("channel {} is lost for {since}: its device {reason}", .channel.0)]
    Lost {
        /// The first of its channels.
        channel: ChannelId,
        /// Why.
        reason: LossReason,
        /// For how long, as far as that is known.
        since: Span,
    },
    /// The device of a bus is lost since before the start.
    #[error("bus {} is lost for {since}: its device {reason}", .bus.0)]
    BusLost {
        /// Which bus.
        bus: BusId,
        /// Why.
        reason: LossReason,
        /// For how long, as far as that is known.
        since: Span,
    },
    /// A call of the operating system failed.
    #[error("{} failed with error number {code}", .call.words())]
    Os {
        /// Which one.
        call: Call,
        /// Its error number, as in `errno`.
        code: i32,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::error::Error as _;

    #[test]
    fn an_error_names_its_channel_and_hands_on_what_it_follows_from() {
        let error = BoardError::NotEmitted(ChannelId(3), NotEmitted::Disorder);
        assert_eq!(error.to_string(), "channel 3 does not emit this: its edges are not in order");
        assert_eq!(error.source().map(ToString::to_string), Some(NotEmitted::Disorder.to_string()));
        let error = BoardError::FaultsApart { channel: ChannelId(1), other: ChannelId(2) };
        assert_eq!(error.to_string(), "channel 1 takes no fault while one is on channel 2");
        let error = BoardError::Os { call: Call::Write, code: 5 };
        assert_eq!(error.to_string(), "driving the lines failed with error number 5");
    }
}
