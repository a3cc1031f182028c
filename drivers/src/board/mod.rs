//! What every board is to the rest of the rig: channels, writes, events, faults and a safe state.

mod channel;
mod emission;
mod error;
mod event;
mod fault;

use std::fmt;

use crate::{Bus, BusEvent, BusId, Frame, HeldLines};
use signal::{Span, Time, Value, When};

pub use channel::{Channel, ChannelId, ChannelKind, TimestampSource};
pub use emission::{Emission, Emits, NotEmitted};
pub use error::{BoardError, Call};
pub use event::{BoardEvent, Health, LossReason, Origin};
pub use fault::{Fault, FaultKind, FaultSet};

/// A board: the rig's terminals, simulated or real.
///
/// Time is an argument and never goes backwards from call to call. Calls do not wait for anything and, once the
/// board has run for a while, do not allocate.
///
/// With the model as subject the model's output terminals are written by [`Board::write`] and every line,
/// those included, is reported by [`Board::poll`]: what a plan sees of `%QX0.4` is the line behind the terminal,
/// with its wires and faults. With an external controller only its inputs are written.
pub trait Board: Send + fmt::Debug {
    /// The board's channels; a [`ChannelId`] is a place in this slice. Fixed from the making of the board.
    fn channels(&self) -> &[Channel];

    /// Claims the lines, drives safe values, forgets faults, events and health of what was before, and lifts the
    /// latch of [`Board::safe`]. The value of every sensed channel at `now` is the first that a poll reports.
    ///
    /// # Errors
    /// [`BoardError::Os`] where a device refuses.
    fn start(&mut self, now: Time) -> Result<(), BoardError>;

    /// Drives the channels to these values, all at once; [`Value::HighZ`] lets go. Later entries for the same
    /// channel win. Changes that the board had due before `now` happen first; those due at `now` happen after.
    ///
    /// # Errors
    /// Nothing is written where one entry is refused: [`BoardError::NoChannel`], [`BoardError::NotDriven`],
    /// [`BoardError::BadValue`], [`BoardError::Latched`], [`BoardError::NotStarted`], [`BoardError::Backwards`],
    /// [`BoardError::Storm`], [`BoardError::Os`].
    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError>;

    /// Has the channel emit pulses by itself, from as soon as its device can. What it emitted before ends, as
    /// [`Emission::Square`] says; a write to the channel ends it, too.
    ///
    /// # Errors
    /// [`BoardError::NotEmitted`] where the channel's [`Channel::emits`] does not have it, and as [`Board::write`].
    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        let _ = (now, emission);
        Err(BoardError::NotEmitted(channel, NotEmitted::Nothing))
    }

    /// Appends to `out` all that happened up to and including `now` and was not reported yet, oldest first.
    ///
    /// # Errors
    /// [`BoardError::NotStarted`], [`BoardError::Backwards`], [`BoardError::Storm`], [`BoardError::Os`]. What had
    /// happened before the error is in `out`.
    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError>;

    /// When the board will next have something to report if nobody writes: an instant already passed where a
    /// report is waiting. `None`: never by itself, and always for a real board, whose poll waits on readiness.
    fn next_event(&self) -> Option<Time>;

    /// Injects a fault from `now` on.
    ///
    /// # Errors
    /// [`BoardError::NoSuchFault`] where the channel's [`Channel::faults`] lacks it, [`BoardError::BadValue`],
    /// [`BoardError::BadFaultTime`], [`BoardError::TooManyFaults`], and as [`Board::write`].
    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError>;

    /// Ends every injected fault of the channel, if it has any.
    ///
    /// # Errors
    /// [`BoardError::NoChannel`], and as [`Board::write`].
    fn clear(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError>;

    /// The longest that a fault on this channel takes to come or to go, beyond the call of a device: the time of a relay.
    /// A fault that lasts less than twice as long cannot be injected.
    fn settle(&self, channel: ChannelId) -> Span {
        let _ = channel;
        Span::ZERO
    }

    /// When the faults of this channel came to be what was asked for last; `None` while that is not known yet, because
    /// a relay moves, and where faults take no time.
    fn came(&self, channel: ChannelId) -> Option<When> {
        let _ = channel;
        None
    }

    /// Drives every driven line to its safe value and latches it there until the next start.
    ///
    /// # Errors
    /// [`BoardError::Os`]; the lines that could be made safe are.
    fn safe(&mut self, now: Time) -> Result<(), BoardError>;

    /// What went wrong since the start.
    fn health(&self) -> Health;

    /// The device behind a channel in words, as in `/dev/gpiochip0 (pinctrl-bcm2711)`. `None` where there is none.
    fn device(&self, channel: ChannelId) -> Option<&str> {
        let _ = channel;
        None
    }

    /// How noisy an analog channel was when it was read last: the standard deviation of its samples, in its unit. `None`
    /// where a reading is one sample.
    fn noise(&self, channel: ChannelId) -> Option<f64> {
        let _ = channel;
        None
    }

    /// The device of a bus in words, as in `can0`. `None` where there is none.
    fn bus_device(&self, bus: BusId) -> Option<&str> {
        let _ = bus;
        None
    }

    /// The board's buses; a [`BusId`] is a place in this slice. Fixed from the making of the board.
    fn buses(&self) -> &[Bus] {
        &[]
    }

    /// Puts a frame into the queue of a bus. It is on the bus when [`Board::poll_buses`] tells it as its own.
    ///
    /// # Errors
    /// [`BoardError::NoBus`], [`BoardError::BadFrame`], [`BoardError::BusFull`], [`BoardError::Latched`],
    /// [`BoardError::NotStarted`], [`BoardError::Backwards`], [`BoardError::Os`].
    fn send(&mut self, now: Time, bus: BusId, frame: &Frame) -> Result<(), BoardError> {
        let _ = (now, frame);
        Err(BoardError::NoBus(bus))
    }

    /// As [`Board::poll`], of what the buses have to tell. [`Board::next_event`] speaks for both.
    ///
    /// # Errors
    /// As [`Board::poll`].
    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        let _ = (now, out);
        Ok(())
    }

    /// A claim of their own on the output lines, for whoever makes them safe when the rig cannot any more. Empty for a
    /// board without real lines.
    ///
    /// # Errors
    /// [`BoardError::Os`] where the claim cannot be shared.
    fn held(&self) -> Result<Vec<HeldLines>, BoardError> {
        Ok(Vec::new())
    }

    /// The channel of this name.
    fn find(&self, name: &str) -> Option<ChannelId> {
        let place = self.channels().iter().position(|channel| channel.name == name)?;
        u16::try_from(place).ok().map(ChannelId)
    }
}

impl<B: Board + ?Sized> Board for Box<B> {
    fn channels(&self) -> &[Channel] {
        (**self).channels()
    }
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        (**self).start(now)
    }
    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        (**self).write(now, writes)
    }
    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        (**self).emit(now, channel, emission)
    }
    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        (**self).poll(now, out)
    }
    fn next_event(&self) -> Option<Time> {
        (**self).next_event()
    }
    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError> {
        (**self).inject(now, fault)
    }
    fn clear(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError> {
        (**self).clear(now, channel)
    }
    fn settle(&self, channel: ChannelId) -> Span {
        (**self).settle(channel)
    }
    fn came(&self, channel: ChannelId) -> Option<When> {
        (**self).came(channel)
    }
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        (**self).safe(now)
    }
    fn health(&self) -> Health {
        (**self).health()
    }
    fn held(&self) -> Result<Vec<HeldLines>, BoardError> {
        (**self).held()
    }
    fn device(&self, channel: ChannelId) -> Option<&str> {
        (**self).device(channel)
    }
    fn noise(&self, channel: ChannelId) -> Option<f64> {
        (**self).noise(channel)
    }
    fn bus_device(&self, bus: BusId) -> Option<&str> {
        (**self).bus_device(bus)
    }
    fn buses(&self) -> &[Bus] {
        (**self).buses()
    }
    fn send(&mut self, now: Time, bus: BusId, frame: &Frame) -> Result<(), BoardError> {
        (**self).send(now, bus, frame)
    }
    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        (**self).poll_buses(now, out)
    }
}
