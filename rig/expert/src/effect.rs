//! What expert functions do to the rest of the controller.

use signal::{Span, Time};

/// Something that a function does at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExpertEffect {
    /// The stage of output Q`output` is commanded: a pulse, a reflex, the enable of a drive.
    Output {
        /// n for Qn.
        output: u8,
        /// Whether it is switched on.
        on: bool,
    },
    /// The stage of output Q`output`, which was offloaded, pulses until it is commanded something else. Where it pulses
    /// already, from the end of its period on.
    Wave {
        /// n for Qn.
        output: u8,
        /// The period, to the nanosecond.
        period: Span,
        /// How long of it the output is on, to the nanosecond; above 0 and below the period.
        high: Span,
    },
    /// The period of such a wave starts again.
    PeriodRestarted {
        /// n for Qn.
        output: u8,
    },
    /// A threshold of a counter raises its event (io:STD-HSC-11).
    Threshold {
        /// The counter, by its place among the counters.
        counter: u8,
        /// The threshold, 0...3.
        threshold: u8,
    },
    /// A counter raises its stop event (io:STD-HSC-10).
    Stop {
        /// The counter, by its place among the counters.
        counter: u8,
    },
    /// Edges come faster than a function can take them: what it counts from here on is not sure (io:STD-HSC-16).
    Overdriven {
        /// The function, by its place in the configuration.
        function: u8,
    },
    /// An axis went to ErrorStop by itself (io:STD-PTO-03).
    AxisError {
        /// The function, by its place in the configuration.
        function: u8,
    },
}

/// ExpertEffects in the order in which they happened, with their instants.
#[derive(Clone, Debug)]
pub struct ExpertEffects {
    list: Vec<(Time, ExpertEffect)>,
}

/// Between two looks at them the functions bring about no more: the caller looks at each instant, and no instant has
/// more than a few of each function.
const MOST: usize = 256;

impl ExpertEffects {
    /// No effects, with room for those of one instant.
    pub(crate) fn new() -> ExpertEffects {
        ExpertEffects { list: Vec::with_capacity(MOST) }
    }

    /// Adds one.
    #[inline]
    pub(crate) fn push(&mut self, at: Time, effect: ExpertEffect) {
        self.list.push((at, effect));
    }

    /// What happened so far.
    pub fn as_slice(&self) -> &[(Time, ExpertEffect)] {
        &self.list
    }

    /// When the first of them happened; [`Time::MAX`] for none.
    #[inline]
    pub(crate) fn first(&self) -> Time {
        self.list.first().map_or(Time::MAX, |(at, _)| *at)
    }

    /// The effect at a place, in their order; after the last one the list is emptied.
    pub fn take(&mut self, place: usize) -> Option<(Time, ExpertEffect)> {
        let effect = self.list.get(place).copied();
        if effect.is_none() {
            self.list.clear();
        }
        effect
    }
}
