//! The boot decision of a power cycle (controller:RB-02).

use crate::{StartingMode, State};
use profile::Family;

/// What a configured Run/Stop input says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RunStopInput {
    /// No input is configured.
    #[default]
    None,
    /// The input is at 0.
    Stop,
    /// The input is at 1.
    Run,
}

/// What the boot decision depends on. A script reboot (rows 10 and 16) is no power cycle and not decided here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BootFacts {
    /// Family of the reference: an M251 has no Run/Stop input, its switch takes that place.
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
    /// The Run/Stop input.
    pub input: RunStopInput,
    /// The Run/Stop switch is at Run.
    pub switch_at_run: bool,
}

/// Where a boot ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BootOutcome {
    /// EMPTY, STOPPED or RUNNING.
    pub state: State,
    /// The row of controller:RB-02 that decided.
    pub row: u8,
}

/// The boot decision of a power cycle: the first row of controller:RB-02 that matches.
pub fn decide(facts: &BootFacts) -> BootOutcome {
    let (state, row) = row(facts);
    // An M241 whose switch is at Stop is STOPPED in every row.
    let held = facts.family == Family::M241 && !facts.switch_at_run && state == State::Running;
    BootOutcome { state: if held { State::Stopped } else { state }, row }
}

fn row(facts: &BootFacts) -> (State, u8) {
    let input = match (facts.family, facts.switch_at_run) {
        (Family::M241, _) => facts.input,
        (Family::M251, true) => RunStopInput::None,
        (Family::M251, false) => RunStopInput::Stop,
    };
    if facts.system_error {
        return (State::Empty, 2);
    }
    if !facts.application {
        return (State::Empty, 3);
    }
    if !facts.remanents {
        return (State::Stopped, 4);
    }
    match (facts.mode, input) {
        (StartingMode::Stop, _) => (State::Stopped, 5),
        (StartingMode::Run, _) if facts.previous == State::Halt => (State::Stopped, 6),
        (StartingMode::Run, RunStopInput::Stop) => (State::Stopped, 7),
        (StartingMode::Run, RunStopInput::None) => (State::Running, 8),
        (StartingMode::Run, RunStopInput::Run) => (State::Running, 9),
        (StartingMode::Previous, _) if facts.previous != State::Running => (State::Stopped, 11),
        (StartingMode::Previous, RunStopInput::Stop) => (State::Stopped, 12),
        (StartingMode::Previous, RunStopInput::Run) => (State::Running, 13),
        (StartingMode::Previous, RunStopInput::None) if !facts.same => (State::Stopped, 14),
        (StartingMode::Previous, RunStopInput::None) => (State::Running, 15),
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
        input: RunStopInput::None,
        switch_at_run: true,
    };

    // controller:RB-02, row by row, the first match winning over all that follow.
    #[test]
    fn every_row() {
        use RunStopInput as Input;
        use StartingMode as Mode;
        let rows = [
            (2, State::Empty, BootFacts { system_error: true, application: false, ..FACTS }),
            (3, State::Empty, BootFacts { application: false, remanents: false, ..FACTS }),
            (4, State::Stopped, BootFacts { remanents: false, mode: Mode::Run, ..FACTS }),
            (5, State::Stopped, BootFacts { mode: Mode::Stop, ..FACTS }),
            (6, State::Stopped, BootFacts { mode: Mode::Run, previous: State::Halt, ..FACTS }),
            (7, State::Stopped, BootFacts { mode: Mode::Run, input: Input::Stop, ..FACTS }),
            (8, State::Running, BootFacts { mode: Mode::Run, previous: State::Stopped, ..FACTS }),
            (9, State::Running, BootFacts { mode: Mode::Run, input: Input::Run, ..FACTS }),
            (11, State::Stopped, BootFacts { previous: State::Halt, input: Input::Run, ..FACTS }),
            (11, State::Stopped, BootFacts { previous: State::Stopped, ..FACTS }),
            (12, State::Stopped, BootFacts { input: Input::Stop, ..FACTS }),
            (13, State::Running, BootFacts { input: Input::Run, same: false, ..FACTS }),
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
        let m251 = BootFacts { family: Family::M251, ..stopped };
        assert_eq!(decide(&m251), BootOutcome { state: State::Stopped, row: 12 });
        let run = BootFacts { mode: StartingMode::Run, ..m251 };
        assert_eq!(decide(&run), BootOutcome { state: State::Stopped, row: 7 });
        let at_run = BootFacts { switch_at_run: true, ..m251 };
        assert_eq!(decide(&at_run), BootOutcome { state: State::Running, row: 15 });
    }
}
