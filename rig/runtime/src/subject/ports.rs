//! The ports of a subject that the rig plays, as a capability.

use controller::{Effects, PortEvent, PortMessage};
use signal::Time;

/// The ports of a subject, by their numbers: those of its reference (`profile::Reference::ports`).
pub trait PortAccess {
    /// Something happened at a port, by `now`.
    fn receive(&mut self, now: Time, port: usize, event: &PortEvent, effects: &mut Effects);

    /// The message of which [`controller::Effect::PortOutput`] says that it may be sent.
    fn take_output(&mut self, port: usize) -> Option<PortMessage>;
}
