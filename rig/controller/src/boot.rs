//! The boot decision of a power cycle (controller:RB-02).

use crate::{StartingMode, State};
use profile::Family;

/// What the boot decision depends on. A script reboot (rows 10 and 16) is no power cycle and not decided here; an
/// M241 has no Run/Stop input configured (rows 9 and 13).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BootFacts {
    /// Family of the reference: the switch of an M251 is to it what a Run/Stop input is to an M241.
    pub family: Family,
    /// The reboot was provoked by a system error.
    pub system_error: bool,
    /// There is a valid boot application.
    pub application: bool,
    /// The saved context of the remanent variables is valid (controller:STATE-10).
    pub remanents: bool,
    /// The boot application is the one that was in memory before.
    pub same: bool,
    /// State before the reboot.
    pub previous: State,
    /// Starting mode.
    pub mode: StartingMode,
    /// The Run/Stop switch is at Run.
    pub switch_at_run: bool,
}

/// Where a boot ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BootOutcome {
    /// EMPTY, STOPPED or RUNNING.
    pub state: State,
    /// The row of controller:RB-02 that decided.
    pub row: u8,
}

/// The boot decision of a power cycle: the first row of controller:RB-02 that matches.
pub(crate) fn decide(facts: &BootFacts) -> BootOutcome {
    let (state, row) = row(facts);
    // An M241 whose switch is at Stop is STOPPED in every row.
    let held = facts.family == Family::M241 && !facts.switch_at_run && state == State::Running;
    BootOutcome { state: if held { State::Stopped } else { state }, row }
}

fn row(facts: &BootFacts) -> (State, u8) {
    let at_stop = facts.family == Family::M251 && !facts.switch_at_run;
    if facts.system_error {
        return (State::Empty, 2);
    }
    if !facts.application {
        return (State::Empty, 3);
    }
    if !facts.remanents {
        return (State::Stopped, 4);
    }
    match facts.mode {
        StartingMode::Stop => (State::Stopped, 5),
        StartingMode::Run if facts.previous == State::Halt => (State::Stopped, 6),
        StartingMode::Run if at_stop => (State::Stopped, 7),
        StartingMode::Run => (State::Running, 8),
        StartingMode::Previous if facts.previous != State::Running => (State::Stopped, 11),
        StartingMode::Previous if at_stop => (State::Stopped, 12),
        StartingMode::Previous if !facts.same => (State::Stopped, 14),
        StartingMode::Previous => (State::Running, 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACTS: BootFacts = BootFacts {
        family: Family::M241,
        system_error: false,
        application: true,
        remanents: true,
        same: true,
        previous: State::Running,
        mode: StartingMode::Previous,
        switch_at_run: true,
    };

    // controller:RB-02, row by row, the first match winning over all that follow.
    #[test]
    fn every_row() {
        use StartingMode as Mode;
        let at_stop = BootFacts { family: Family::M251, switch_at_run: false, ..FACTS };
        let rows = [
            (2, State::Empty, BootFacts { system_error: true, application: false, ..FACTS }),
            (3, State::Empty, BootFacts { application: false, remanents: false, ..FACTS }),
            (4, State::Stopped, BootFacts { remanents: false, mode: Mode::Run, ..FACTS }),
            (5, State::Stopped, BootFacts { mode: Mode::Stop, ..FACTS }),
            (6, State::Stopped, BootFacts { mode: Mode::Run, previous: State::Halt, ..FACTS }),
            (7, State::Stopped, BootFacts { mode: Mode::Run, ..at_stop }),
            (8, State::Running, BootFacts { mode: Mode::Run, previous: State::Stopped, ..FACTS }),
            (11, State::Stopped, BootFacts { previous: State::Halt, ..at_stop }),
            (11, State::Stopped, BootFacts { previous: State::Stopped, ..FACTS }),
            (12, State::Stopped, BootFacts { same: false, ..at_stop }),
            (14, State::Stopped, BootFacts { same: false, ..FACTS }),
            (15, State::Running, FACTS),
        ];
        for (row, state, facts) in rows {
            assert_eq!(decide(&facts), BootOutcome { state, row }, "{facts:?}");
        }
    }

    #[test]
    fn the_switch_at_stop() {
        let stopped = BootFacts { switch_at_run: false, ..FACTS };
        assert_eq!(decide(&stopped).state, State::Stopped);
        let m251 = BootFacts { family: Family::M251, ..FACTS };
        assert_eq!(decide(&m251), BootOutcome { state: State::Running, row: 15 });
    }
}
