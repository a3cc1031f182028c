//! The exchange with one module: whether it answers, and what follows where it does not.

use profile::{ExchangeCode, ModuleState};
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
    /// A module of the configured code is there to be reached.
    reached: bool,
    /// The exchange is disturbed: it takes place, and counts as failed (io:ERR-15).
    disturbed: bool,
    /// How many failed in a row.
    failed: u32,
    /// The module answered the last read, so that it hears what the bus writes.
    hears: bool,
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
            reached: true,
            disturbed: false,
            failed: 0,
            hears: true,
            state: ModuleState::Empty,
            outputs_off: Time::MAX,
        }
    }

    /// The module is silent for so many exchanges from now on, or until something else is said.
    pub(super) fn silence(&mut self, exchanges: Option<u32>) {
        self.failing = exchanges;
    }

    /// Whether a module of the configured code is there to be reached, and whether the exchange with it is disturbed.
    pub(super) fn reach(&mut self, reached: bool, disturbed: bool) {
        (self.reached, self.disturbed) = (reached, disturbed);
    }

    /// Whether the module is silent.
    pub(super) fn is_silent(&self) -> bool {
        self.failing != Some(0)
    }

    /// Whether a module answers.
    fn answers(&self) -> bool {
        self.reached && !self.is_silent()
    }

    /// Whether there is an exchange at all: a module that was not there when the bus was started, or was another one, is left
    /// alone until it is started again.
    fn is_exchanged(&self) -> bool {
        !matches!(self.state, ModuleState::MissingOptional | ModuleState::ConfigurationError)
    }

    /// Whether what the bus writes arrives: not in a cycle whose read failed, the last one of a silence included.
    pub(super) fn is_written(&self) -> bool {
        self.hears && self.answers() && self.is_exchanged()
    }

    /// The state of the module.
    pub(super) fn state(&self) -> ModuleState {
        self.state
    }

    /// The code of the last one (io:DIAG-04): a module that was not there when the bus was started, or was another one, has none
    /// that succeeded.
    pub(super) fn code(&self) -> ExchangeCode {
        match self.state {
            ModuleState::BusError => ExchangeCode::Bus,
            ModuleState::Ok if self.failed == 0 => ExchangeCode::NoError,
            _ => ExchangeCode::Failed,
        }
    }

    /// The bus starts at `now`, and found the module in this state.
    pub(super) fn start(&mut self, now: Time, state: ModuleState) {
        (self.failed, self.state, self.outputs_off) = (0, state, Time::MAX);
        self.hears = state != ModuleState::BusError;
        if !self.hears {
            self.silent_since(now);
        }
    }

    /// The bus stops: nothing is configured any more.
    pub(super) fn stop(&mut self) {
        (self.failed, self.state, self.outputs_off) = (0, ModuleState::Empty, Time::MAX);
    }

    /// A cycle of the bus exchanges with the module at `now`; whether it answered.
    pub(super) fn succeeds(&mut self, now: Time) -> bool {
        if !self.is_exchanged() {
            return false;
        }
        let answers = self.answers();
        if let Some(left) = &mut self.failing {
            *left = left.saturating_sub(1);
        }
        if answers {
            self.outputs_off = Time::MAX;
        } else if self.hears {
            self.silent_since(now);
        }
        self.hears = answers;
        if answers && !self.disturbed {
            (self.failed, self.state) = (0, ModuleState::Ok);
            return true;
        }
        self.failed = self.failed.saturating_add(1);
        if self.failed >= FAILURES {
            self.state = ModuleState::BusError;
        }
        answers
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

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: i64) -> Time {
        Time::ZERO + Span::from_secs(seconds)
    }

    #[test]
    fn the_last_exchange_of_a_silence_hears_no_write() {
        let mut exchange = Exchange::new(true);
        exchange.start(at(0), ModuleState::Ok);
        exchange.silence(Some(1));
        assert!(!exchange.succeeds(at(1)) && !exchange.is_written());
        assert!(exchange.succeeds(at(2)) && exchange.is_written());
    }

    #[test]
    fn each_silence_counts_its_own_time() {
        let mut exchange = Exchange::new(true);
        exchange.start(at(0), ModuleState::Ok);
        for silent in [10, 20] {
            exchange.silence(Some(1));
            assert!(!exchange.succeeds(at(silent)));
            assert_eq!(exchange.outputs_off(), at(silent + 10));
            assert!(exchange.succeeds(at(silent + 1)));
            assert_eq!(exchange.outputs_off(), Time::MAX);
        }
    }
}
