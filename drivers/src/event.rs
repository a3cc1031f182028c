//! What a board has to report, and how it fares.

use std::fmt;

use crate::channel::ChannelId;
use signal::{SignalGap, Time, Value, When};

/// Who made a line change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Origin {
    /// [`Board::write`](crate::Board::write) on this very channel; at the start, the safe value.
    Write,
    /// A wire from another channel.
    Wire,
    /// A plant.
    Plant,
    /// A fault that came or went on this channel.
    Fault,
    /// The world outside: all that a real board can say.
    Outside,
    /// Nobody: the value is [`Value::Unknown`] from then on, for this reason.
    Gap(SignalGap),
}

/// Why a device is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LossReason {
    /// A fault that was asked for: no trouble of the rig.
    Injected,
    /// The device was unplugged or its driver unbound.
    Gone,
    /// The device does not answer any more.
    Unresponsive,
}

impl fmt::Display for LossReason {
    /// What became of the device, as in `it is gone`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            LossReason::Injected => "is cut off, as asked",
            LossReason::Gone => "is gone",
            LossReason::Unresponsive => "does not answer",
        })
    }
}

/// What a board has to report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardEvent {
    /// A line has another value.
    Changed {
        /// Which channel.
        channel: ChannelId,
        /// When it happened.
        at: When,
        /// What it is from then on. [`Value::HighZ`] only on channels without a pull.
        value: Value,
        /// Who did it.
        origin: Origin,
    },
    /// The device behind a channel is gone: its value is [`Value::Unknown`] until it returns. A device of many
    /// channels reports each of them.
    Lost {
        /// Which channel.
        channel: ChannelId,
        /// When it was noticed.
        at: Time,
        /// Why.
        reason: LossReason,
    },
    /// The device behind a channel is back; a `Changed` with its present value follows.
    Returned {
        /// Which channel.
        channel: ChannelId,
        /// When it was noticed.
        at: Time,
    },
    /// Events of a channel were lost (a full kernel buffer, a gap in sequence numbers) before this place in the
    /// stream: no verdict that rests on this channel around `at` holds.
    Dropped {
        /// Which channel.
        channel: ChannelId,
        /// When the loss was noticed.
        at: Time,
        /// How many events, at least.
        count: u32,
    },
}

impl BoardEvent {
    /// The channel that it concerns.
    pub fn channel(&self) -> ChannelId {
        match *self {
            BoardEvent::Changed { channel, .. }
            | BoardEvent::Lost { channel, .. }
            | BoardEvent::Returned { channel, .. }
            | BoardEvent::Dropped { channel, .. } => channel,
        }
    }

    /// The earliest instant at which it can have happened.
    pub fn earliest(&self) -> Time {
        match *self {
            BoardEvent::Changed { at, .. } => at.earliest,
            other => other.latest(),
        }
    }

    /// The latest instant at which it can have happened: what poll orders by.
    pub fn latest(&self) -> Time {
        match *self {
            BoardEvent::Changed { at, .. } => at.latest,
            BoardEvent::Lost { at, .. }
            | BoardEvent::Returned { at, .. }
            | BoardEvent::Dropped { at, .. } => at,
        }
    }
}

/// The state of a board, counted since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Health {
    /// Channels that are lost now through an injected fault: no trouble of the rig.
    pub lost_on_purpose: u32,
    /// Channels that are lost now by themselves: the rig's error.
    pub lost: u32,
    /// Events that the board knows to have missed.
    pub dropped: u64,
    /// Times that two drivers began to pull one line both ways.
    pub contentions: u64,
    /// Calls that failed.
    pub failed_calls: u64,
    /// Whether the outputs are latched at their safe values.
    pub latched_safe: bool,
}

impl Health {
    /// What two parts of a board have to say together.
    #[must_use]
    pub fn and(self, other: Health) -> Health {
        Health {
            lost_on_purpose: self.lost_on_purpose + other.lost_on_purpose,
            lost: self.lost + other.lost,
            dropped: self.dropped + other.dropped,
            contentions: self.contentions + other.contentions,
            failed_calls: self.failed_calls + other.failed_calls,
            latched_safe: self.latched_safe || other.latched_safe,
        }
    }

    /// Whether verdicts can rest on this board: nothing missed, nothing lost but on purpose, no call failed.
    pub fn is_sound(&self) -> bool {
        self.lost == 0 && self.dropped == 0 && self.failed_calls == 0
    }
}
