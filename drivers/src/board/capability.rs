//! What only some boards can do.
//!
//! No method has a body here: a wrapper that changes a capability has to say what becomes of each of its methods.

use std::fmt;

use signal::{CanFrame, SerialOutput, SerialSettings, Span, Time, When};

use super::BoardError;
use crate::bus::{Bus, BusEvent, BusId};
use crate::channel::{ChannelId, Emission, Fault};

/// The buses of a board.
pub trait Buses: fmt::Debug {
    /// The buses; a [`BusId`] is a place in this slice. Fixed from the making of the board.
    fn bus_list(&self) -> &[Bus];

    /// The device of a bus in words, as in `can0`. `None` where there is none.
    fn bus_device(&self, bus: BusId) -> Option<&str>;

    /// Puts a frame into the queue of a CAN bus. It is on the bus when [`Buses::poll_buses`] reports it as its own.
    ///
    /// # Errors
    /// [`BoardError::NoBus`], [`BoardError::BadFrame`], [`BoardError::BusFull`], [`BoardError::Latched`],
    /// [`BoardError::NotStarted`], [`BoardError::Backwards`], [`BoardError::Os`].
    fn send(&mut self, now: Time, bus: BusId, frame: &CanFrame) -> Result<(), BoardError>;

    /// Sends on a serial line, after what it sends already. It is over when [`Buses::poll_buses`] reports it as its own.
    ///
    /// # Errors
    /// As [`Buses::send`]; [`BoardError::BadFrame`] also for gaps between characters and flaws on lines that cannot make
    /// them, which are all real ones.
    fn send_serial(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError>;

    /// Has an end of a serial line send and hear with other settings from `now` on, until the next start. What it is sending,
    /// and what waits, goes out as it was; a message that it is in the middle of hearing is lost. `message_gap` is how long
    /// the line is silent between two messages. The other ends keep theirs.
    ///
    /// # Errors
    /// [`BoardError::BadSettings`] for what the line cannot do: on a real line all but the settings of the board file;
    /// [`BoardError::NoBus`], [`BoardError::Latched`], [`BoardError::NotStarted`], [`BoardError::Backwards`].
    fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        settings: &SerialSettings,
        message_gap: Span,
    ) -> Result<(), BoardError>;

    /// Whoever sends on this bus lost its power: nothing more is sent, and on a modelled serial line what is under way ends in
    /// the middle of a character. A frame on a modelled CAN bus comes to its end, and so does what a real device has taken
    /// over already, as far as it cannot be called back. The bus can be sent on again at once.
    ///
    /// # Errors
    /// [`BoardError::NoBus`], [`BoardError::NotStarted`], [`BoardError::Backwards`].
    fn break_off(&mut self, now: Time, bus: BusId) -> Result<(), BoardError>;

    /// As [`Board::poll`](super::Board::poll), of what happened on the buses.
    ///
    /// # Errors
    /// As [`Board::poll`](super::Board::poll).
    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError>;
}

/// Outputs that emit pulses by themselves, without a write for each edge.
pub trait PulseOutputs: fmt::Debug {
    /// Has the channel emit pulses by itself, from as soon as its device can. What it emitted before ends, as
    /// [`Emission::Square`] says; a write to the channel ends it, too.
    ///
    /// # Errors
    /// [`BoardError::NotEmitted`] where the channel's [`Channel::emits`](crate::Channel::emits) does not have it, and as
    /// [`Board::write`](super::Board::write).
    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError>;
}

/// Faults that can be put on the channels of a board.
pub trait FaultInjection: fmt::Debug {
    /// Injects a fault from `now` on.
    ///
    /// # Errors
    /// [`BoardError::NoSuchFault`] where the channel's [`Channel::faults`](crate::Channel::faults) lacks it,
    /// [`BoardError::BadValue`], [`BoardError::BadFaultTime`], [`BoardError::TooManyFaults`],
    /// [`BoardError::FaultsApart`], and as [`Board::write`](super::Board::write).
    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError>;

    /// Ends every injected fault of the channel, if it has any.
    ///
    /// # Errors
    /// [`BoardError::NoChannel`], and as [`Board::write`](super::Board::write).
    fn clear_faults(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError>;

    /// The longest that a fault on this channel takes to come or to go, beyond the call of a device: the time of a relay.
    /// A fault that lasts less than twice as long cannot be injected.
    fn fault_switching_time(&self, channel: ChannelId) -> Span;

    /// When the faults of this channel came to be what was asked for last; `None` while that is not known yet, because
    /// a relay moves, and where faults take no time.
    fn fault_settled_at(&self, channel: ChannelId) -> Option<When>;
}

/// The plants of a board, as far as they can be set.
pub trait PlantParameters: fmt::Debug {
    /// Sets a parameter of a plant from `now` on; both are counted in the order of the board file and of
    /// [`PlantSpec::parameters`](crate::circuit::PlantSpec::parameters).
    ///
    /// # Errors
    /// [`BoardError::NoPlant`], and as [`Board::write`](super::Board::write).
    fn set_parameter(
        &mut self,
        now: Time,
        plant: usize,
        parameter: usize,
        value: f64,
    ) -> Result<(), BoardError>;
}

/// What is known of the devices behind the channels.
pub trait Descriptions: fmt::Debug {
    /// The device behind a channel in words, as in `/dev/gpiochip0 (pinctrl-bcm2711)`. `None` where there is none.
    fn device(&self, channel: ChannelId) -> Option<&str>;

    /// What that device is, in a word for clients: `gpio`, `spi`, `iio`, `counter`, `pwm`.
    fn device_kind(&self, channel: ChannelId) -> Option<&'static str>;

    /// How noisy an analog channel was when it was read last: the standard deviation of its samples, in its unit. `None`
    /// where a reading is one sample.
    fn noise(&self, channel: ChannelId) -> Option<f64>;
}
