//! The exchange with one module: whether it answers, and what follows where it does not.

use profile::ModuleState;
use signal::{Span, Time};

/// So many exchanges in a row have to fail for an error of the bus (io:ERR-03).
const FAILURES: u32 = 2;

/// A TM3 module that hears nothing for so long switches its outputs off (io:ERR-10). A TM2 module keeps them (io:ERR-11).
const SILENCE: Span = Span::from_secs(10);

/// The exchange.
#[derive(Clone, Debug)]
pub(super) struct Exchange {
    /// The module switches its outputs off after a while.
    switches_off: bool,
    /// How many exchanges fail from now on; none for all of them.
    failing: Option<u32>,
    /// How many failed in a row.
    failed: u32,
    state: ModuleState,
    /// When its outputs go off.
    outputs_off: Time,
}

impl Exchange {
    /// With a module that answers, which switches its outputs off by itself where the bus is silent for too long.
    pub(super) fn new(switches_off: bool) -> Exchange {
        Exchange {
            switches_off,
            failing: Some(0),
            failed: 0,
            state: ModuleState::Empty,
            outputs_off: Time::MAX,
        }
    }

    /// The module is silent for so many exchanges from now on, or until something else is said.
    pub(super) fn silence(&mut self, exchanges: Option<u32>) {
        self.failing = exchanges;
    }

    /// Whether the module answers.
    pub(super) fn answers(&self) -> bool {
        self.failing == Some(0)
    }

    /// Whether the bus writes to it: it answers, and was there when the bus was started.
    pub(super) fn is_written(&self) -> bool {
        self.answers() && self.state != ModuleState::MissingOptional
    }

    /// The state of the module.
    pub(super) fn state(&self) -> ModuleState {
        self.state
    }

    /// The bus starts at `now`, and found the module in this state.
    pub(super) fn start(&mut self, now: Time, state: ModuleState) {
        (self.failed, self.state, self.outputs_off) = (0, state, Time::MAX);
        if state == ModuleState::BusError {
            self.silent_since(now);
        }
    }

    /// The bus stops: nothing is configured any more.
    pub(super) fn stop(&mut self) {
        (self.failed, self.state, self.outputs_off) = (0, ModuleState::Empty, Time::MAX);
    }

    /// A cycle of the bus exchanges with the module at `now`; whether it answered.
    pub(super) fn succeeds(&mut self, now: Time) -> bool {
        if self.state == ModuleState::MissingOptional {
            return false;
        }
        if self.answers() {
            self.failed = 0;
            self.outputs_off = Time::MAX;
            self.state = ModuleState::Ok;
            return true;
        }
        if let Some(left) = &mut self.failing {
            *left -= 1;
        }
        if self.failed == 0 {
            self.silent_since(now);
        }
        self.failed = self.failed.saturating_add(1);
        if self.failed >= FAILURES {
            self.state = ModuleState::BusError;
        }
        false
    }

    /// It heard nothing from `now` on.
    fn silent_since(&mut self, now: Time) {
        if self.switches_off {
            self.outputs_off = now.saturating_add(SILENCE);
        }
    }

    /// When its outputs go off; [`Time::MAX`] for never.
    pub(super) fn outputs_off(&self) -> Time {
        self.outputs_off
    }

    /// Its outputs are off.
    pub(super) fn switched_off(&mut self) {
        self.outputs_off = Time::MAX;
    }
}
