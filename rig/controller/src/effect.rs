//! What the controller hands back.

use crate::log::LogEntry;
use crate::probe::ProbeId;
use crate::state::State;
use crate::terminal::Terminal;
use signal::{Cause, Span, Time, Value};

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// The terminal of an output changed.
    Terminal {
        /// When.
        at: Time,
        /// Which one.
        terminal: Terminal,
        /// What it shows from then on: a level, high being the conducting state, also of sink outputs and relays; or a
        /// number in the unit of an analogue channel.
        value: Value,
        /// Who wrote it.
        cause: Cause,
        /// By how much it may have changed earlier: not at all but with [`crate::Config::worst_case`].
        early: Span,
    },
    /// An output may have shown a pulse of which the model has none: a command was taken back before its edge came out. Only
    /// with [`crate::Config::worst_case`].
    Unsettled {
        /// When it certainly shows again what it did before, or the level that an effect after this one reports.
        at: Time,
        /// Which one.
        terminal: Terminal,
        /// By how much earlier it may have left what it showed before.
        left: Span,
        /// By how much earlier it may have come back to it; none where another level follows, so that it may never have.
        back: Option<Span>,
    },
    /// An output terminal pulses until it changes, without an edge being reported: [`crate::Controller::offload_pulses`]. Where it
    /// pulses already, from the end of its period on.
    Wave {
        /// When.
        at: Time,
        /// The output: n for Qn.
        output: usize,
        /// The period.
        period: Span,
        /// How long of it the terminal is high; above 0 and below the period.
        high: Span,
        /// Who wrote it.
        cause: Cause,
    },
    /// The period of such a wave starts again.
    PeriodRestarted {
        /// When.
        at: Time,
        /// The output: n for Qn.
        output: usize,
    },
    /// A port sends a message from now on: [`crate::Controller::take_output`] has it.
    PortOutput {
        /// When.
        at: Time,
        /// The port's number.
        port: usize,
    },
    /// The electronics of a port stop: what it is sending breaks off.
    PortSilent {
        /// When.
        at: Time,
        /// The port's number.
        port: usize,
    },
    /// The controller changed its state.
    State {
        /// When.
        at: Time,
        /// The state from then on.
        state: State,
    },
    /// An observed value changed.
    Changed {
        /// When.
        at: Time,
        /// What was observed.
        probe: ProbeId,
        /// Its value from then on.
        value: Value,
        /// Who changed it.
        cause: Cause,
    },
    /// An entry of the log.
    Log {
        /// When.
        at: Time,
        /// What it says.
        entry: LogEntry,
    },
}

/// The effects of the calls since the caller last drained the list, in the order in which they happened.
#[derive(Clone, Debug, Default)]
pub struct Effects {
    /// The list, to be drained by the caller; it keeps its capacity.
    pub list: Vec<Effect>,
}

impl Effects {
    /// An empty list with room for what a scan commonly causes.
    pub fn new() -> Effects {
        Effects { list: Vec::with_capacity(256) }
    }

    pub(crate) fn push(&mut self, effect: Effect) {
        self.list.push(effect);
    }

    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }
}
