//! The parameters of the embedded inputs and what they exclude (io: section 3).

use profile::{BounceFilter, EventEdges, InputFilter, Profile, Reference};
use thiserror::Error;

/// The parameters of one input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputConfig {
    /// The integrating filter; none with Latch or Event.
    pub filter: InputFilter,
    /// Pulses between two reads of MAST are kept for the next one (io:EIO-08).
    pub latch: bool,
    /// Edges that raise the input's event (io:EIO-10).
    pub event: Option<EventEdges>,
    /// The anti-bounce filter of an input with Latch, Event or another expert function, else 0.002 ms (io:EIO-07,
    /// io:EIO-12).
    pub bounce: BounceFilter,
}

impl InputConfig {
    /// An input with this filter and nothing else.
    pub fn filtered(filter: InputFilter) -> InputConfig {
        InputConfig { filter, ..InputConfig::default() }
    }

    /// Whether an expert function uses it: Latch or Event (io:EIO-12).
    pub const fn is_expert(&self) -> bool {
        self.latch || self.event.is_some()
    }

    /// Whether an input of this number can have these parameters; `used` where a fast counter or a pulse generator
    /// looks at it.
    ///
    /// # Errors
    /// The first [`InputFault`].
    pub(crate) fn check(&self, input: usize, used: bool, reference: &Reference) -> Result<(), InputFault> {
        match (self.latch, self.event.is_some()) {
            (true, true) => return Err(InputFault::LatchWithEvent),
            (latch, event) if (latch || event) && input >= reference.fast_inputs => {
                return Err(InputFault::NotFast);
            }
            (latch, event) if (latch || event) && self.filter != InputFilter::None => {
                return Err(InputFault::FilterWithExpert);
            }
            (false, false) if !used && self.bounce != BounceFilter::default() => {
                return Err(InputFault::BounceAlone);
            }
            _ => {}
        }
        Ok(())
    }
}

/// Parameters that one input cannot have together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum InputFault {
    /// A filter beside Latch or Event (io:EIO-04).
    #[error("has a filter beside Latch or Event")]
    FilterWithExpert,
    /// Latch and Event (io:EIO-05).
    #[error("has both Latch and Event")]
    LatchWithEvent,
    /// Latch or Event on a regular input (io:EIO-06).
    #[error("has Latch or Event, which only fast inputs have")]
    NotFast,
    /// A bounce time without Latch, Event and expert functions (io:EIO-07).
    #[error("has a bounce time without Latch or Event, and no expert function uses it")]
    BounceAlone,
}

/// Why an input cannot be the Run/Stop input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum RunStopFault {
    /// The profile has none (controller:RS-01).
    #[error("the controller has none")]
    NoneAtAll,
    /// The profile allows only the first ones (controller:RS-03).
    #[error("the controller takes I0 to I{}", most.saturating_sub(1))]
    Beyond {
        /// How many, from I0.
        most: usize,
    },
    /// It has Latch or Event (controller:RS-05).
    #[error("the input has Latch or Event")]
    Expert,
}

impl RunStopFault {
    /// Whether I`input` with these parameters can be the Run/Stop input.
    pub(crate) fn check(
        input: usize,
        config: Option<&InputConfig>,
        profile: Profile,
        reference: &Reference,
    ) -> Result<(), RunStopFault> {
        match profile.run_stop_inputs(reference) {
            0 => Err(RunStopFault::NoneAtAll),
            most if input >= most => Err(RunStopFault::Beyond { most }),
            _ if config.is_some_and(InputConfig::is_expert) => Err(RunStopFault::Expert),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(input: usize, change: impl FnOnce(&mut InputConfig)) -> Result<(), InputFault> {
        let mut config = InputConfig::default();
        change(&mut config);
        config.check(input, false, Profile::default().default_reference())
    }

    // io:EIO-04, io:EIO-05, io:EIO-06, io:EIO-07
    #[test]
    fn each_conflict_is_refused() {
        let latch = |c: &mut InputConfig| (c.latch, c.filter) = (true, InputFilter::None);
        let event = |c: &mut InputConfig| (c.event, c.filter) = (Some(EventEdges::Both), InputFilter::None);
        assert_eq!(check(13, |_| ()), Ok(()));
        assert_eq!(check(7, latch), Ok(()));
        assert_eq!(check(7, event), Ok(()));
        assert_eq!(check(8, latch), Err(InputFault::NotFast));
        assert_eq!(check(8, event), Err(InputFault::NotFast));
        assert_eq!(check(0, |c| c.latch = true), Err(InputFault::FilterWithExpert));
        assert_eq!(check(0, |c| c.event = Some(EventEdges::Rising)), Err(InputFault::FilterWithExpert));
        let both = |c: &mut InputConfig| (c.latch, c.event) = (true, Some(EventEdges::Falling));
        assert_eq!(check(0, both), Err(InputFault::LatchWithEvent));
        let bounce = |c: &mut InputConfig| c.bounce = BounceFilter::ALL[3];
        assert_eq!(check(0, bounce), Err(InputFault::BounceAlone));
        assert_eq!(check(0, |c| (latch(c), bounce(c)).0), Ok(()));
    }
}
