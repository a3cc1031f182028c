//! What every board is to the rest of the rig: a small core (channels, writes, events, a safe state, health), and the
//! capabilities that only some boards have.

mod capability;
mod error;
mod ext;

use std::fmt;

use crate::channel::{Channel, ChannelId};
use crate::circuit::PlantFault;
use crate::event::{BoardEvent, Health};
use crate::output_claim::OutputClaim;
use signal::{Time, Value};

pub use capability::{Buses, Descriptions, FaultInjection, PlantParameters, PulseOutputs};
pub use error::{BoardError, Call};
pub use ext::BoardExt;

/// A board: the rig's terminals, simulated or real.
///
/// Time is an argument and never goes backwards from call to call. Calls do not wait for anything and, once the
/// board has run for a while, do not allocate.
///
/// With the model as subject the model's output terminals are written by [`Board::write`] and every line,
/// those included, is reported by [`Board::poll`]: what a plan sees of `%QX0.4` is the line behind the terminal,
/// with its wires and faults. With an external controller only its inputs are written.
///
/// What not every board has is a capability of its own, reached by an accessor: [`Board::buses`],
/// [`Board::pulse_outputs`], [`Board::faults`], [`Board::output_claims`], [`Board::descriptions`]. Callers who do not care
/// whether it is there use [`BoardExt`].
///
/// # A board around another
///
/// A wrapper names the board within by [`Board::inner`] and [`Board::inner_mut`], which nobody can leave out. It writes the
/// core methods, as the compiler asks; every capability, those that come later included, is that of the board within unless
/// the wrapper changes it: then it implements the capability and answers its accessor by itself.
pub trait Board: Send + fmt::Debug {
    /// The board that this one is wrapped around; `None` for a board of its own.
    fn inner(&self) -> Option<&dyn Board>;

    /// As [`Board::inner`].
    fn inner_mut(&mut self) -> Option<&mut dyn Board>;

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
    /// [`BoardError::Storm`], [`BoardError::PlantFailed`], [`BoardError::Os`].
    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError>;

    /// Appends to `out` all that happened up to and including `now` and was not reported yet, oldest first.
    ///
    /// # Errors
    /// [`BoardError::NotStarted`], [`BoardError::Backwards`], [`BoardError::Storm`], [`BoardError::PlantFailed`],
    /// [`BoardError::Os`]. What had
    /// happened before the error is in `out`.
    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError>;

    /// When the board will next have something to report if nobody writes: an instant already passed where a
    /// report is waiting. `None`: never by itself, and always for a real board, whose poll waits on readiness.
    /// Speaks for the board's buses, too.
    fn next_event(&self) -> Option<Time>;

    /// By when every change up to `at`, which was polled for, will have been reported, as far as the board itself holds reports
    /// back. `at` where it holds nothing.
    fn reported_by(&self, at: Time) -> Time {
        self.inner().map_or(at, |board| board.reported_by(at))
    }

    /// Drives every driven line to its safe value and latches it there until the next start.
    ///
    /// # Errors
    /// [`BoardError::Os`]; the lines that could be made safe are.
    fn safe(&mut self, now: Time) -> Result<(), BoardError>;

    /// What went wrong since the start.
    fn health(&self) -> Health;

    /// The board's buses.
    fn buses(&self) -> Option<&dyn Buses> {
        self.inner()?.buses()
    }

    /// As [`Board::buses`], to send and to poll.
    fn buses_mut(&mut self) -> Option<&mut dyn Buses> {
        self.inner_mut()?.buses_mut()
    }

    /// Outputs that emit pulses by themselves.
    fn pulse_outputs(&mut self) -> Option<&mut dyn PulseOutputs> {
        self.inner_mut()?.pulse_outputs()
    }

    /// Faults that can be put on the channels.
    fn faults(&self) -> Option<&dyn FaultInjection> {
        self.inner()?.faults()
    }

    /// As [`Board::faults`], to inject and to clear.
    fn faults_mut(&mut self) -> Option<&mut dyn FaultInjection> {
        self.inner_mut()?.faults_mut()
    }

    /// Plants that can be set.
    fn plant_parameters(&mut self) -> Option<&mut dyn PlantParameters> {
        self.inner_mut()?.plant_parameters()
    }

    /// Why a plant came to its end, where one did since the start: the first.
    fn plant_fault(&self) -> Option<&PlantFault> {
        self.inner()?.plant_fault()
    }

    /// A claim of their own on the output lines, for whoever makes them safe when the rig cannot any more. Empty for a
    /// board without real lines.
    ///
    /// # Errors
    /// [`BoardError::Os`] where the claim cannot be shared.
    fn output_claims(&self) -> Result<Vec<OutputClaim>, BoardError> {
        self.inner().map_or(Ok(Vec::new()), |board| board.output_claims())
    }

    /// What is known of the devices behind the channels.
    fn descriptions(&self) -> Option<&dyn Descriptions> {
        self.inner()?.descriptions()
    }
}

impl Board for Box<dyn Board> {
    fn inner(&self) -> Option<&dyn Board> {
        Some(&**self)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        Some(&mut **self)
    }

    fn channels(&self) -> &[Channel] {
        (**self).channels()
    }

    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        (**self).start(now)
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        (**self).write(now, writes)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        (**self).poll(now, out)
    }

    fn next_event(&self) -> Option<Time> {
        (**self).next_event()
    }

    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        (**self).safe(now)
    }

    fn health(&self) -> Health {
        (**self).health()
    }
}
