//! The boot decision (controller:RB-02).

use crate::{StartingMode, State};
use profile::{Family, Profile};

/// What the boot decision depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BootFacts {
    /// The rows of a reboot by script differ between the documents.
    pub profile: Profile,
    /// Family of the reference: the switch of an M251 is to it what a Run/Stop input is to an M241.
    pub family: Family,
    /// The firmware is valid.
    pub firmware: bool,
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
    /// Whether the input configured as Run/Stop is at Run; none without such an input.
    pub run_input: Option<bool>,
    /// The reboot was commanded by a script; else it is a power cycle.
    pub script: bool,
}

/// Where a boot ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BootOutcome {
    /// INVALID_OS, EMPTY, STOPPED or RUNNING.
    pub state: State,
    /// The row of controller:RB-02 that decided.
    pub row: u8,
}

/// The boot decision: the first row of controller:RB-02 that matches.
pub(crate) fn decide(facts: &BootFacts) -> BootOutcome {
    let (state, row) = row(facts);
    // An M241 whose switch is at Stop is STOPPED in every row.
    let held = facts.family == Family::M241 && !facts.switch_at_run && state == State::Running;
    BootOutcome { state: if held { State::Stopped } else { state }, row }
}

fn row(facts: &BootFacts) -> (State, u8) {
    let input = match facts.family {
        Family::M241 => facts.run_input,
        // At Run it is as if no input was configured: the boot application has to be unchanged, too.
        Family::M251 => (!facts.switch_at_run).then_some(false),
    };
    if !facts.firmware {
        return (State::InvalidOs, 1);
    }
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
        (StartingMode::Run, Some(false)) => (State::Stopped, 7),
        (StartingMode::Run, _) if facts.script => (State::Running, 10),
        (StartingMode::Run, None) => (State::Running, 8),
        (StartingMode::Run, Some(true)) => (State::Running, 9),
        (StartingMode::Previous, _) if facts.previous != State::Running => (State::Stopped, 11),
        (StartingMode::Previous, Some(false)) => (State::Stopped, 12),
        (StartingMode::Previous, _) if facts.script => {
            let resumes = facts.profile == Profile::M241_2014 && (input.is_some() || facts.same);
            (if resumes { State::Running } else { State::Stopped }, 16)
        }
        (StartingMode::Previous, Some(true)) => (State::Running, 13),
        (StartingMode::Previous, None) if !facts.same => (State::Stopped, 14),
        (StartingMode::Previous, None) => (State::Running, 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACTS: BootFacts = BootFacts {
        profile: Profile::M241_2019,
        family: Family::M241,
        firmware: true,
        system_error: false,
        application: true,
        remanents: true,
        same: true,
        previous: State::Running,
        mode: StartingMode::Previous,
        switch_at_run: true,
        run_input: None,
        script: false,
    };

    // controller:RB-02, row by row, the first match winning over all that follow.
    #[test]
    fn every_row() {
        use StartingMode as Mode;
        let at_stop = BootFacts { run_input: Some(false), ..FACTS };
        let at_run = BootFacts { run_input: Some(true), ..FACTS };
        let script = BootFacts { script: true, ..FACTS };
        let old = BootFacts { profile: Profile::M241_2014, script: true, same: false, ..FACTS };
        let rows = [
            (1, State::InvalidOs, BootFacts { firmware: false, system_error: true, ..FACTS }),
            (2, State::Empty, BootFacts { system_error: true, application: false, ..FACTS }),
            (3, State::Empty, BootFacts { application: false, remanents: false, ..FACTS }),
            (4, State::Stopped, BootFacts { remanents: false, mode: Mode::Run, ..FACTS }),
            (5, State::Stopped, BootFacts { mode: Mode::Stop, ..at_run }),
            (6, State::Stopped, BootFacts { mode: Mode::Run, previous: State::Halt, ..at_run }),
            (7, State::Stopped, BootFacts { mode: Mode::Run, script: true, ..at_stop }),
            (8, State::Running, BootFacts { mode: Mode::Run, previous: State::Stopped, ..FACTS }),
            (9, State::Running, BootFacts { mode: Mode::Run, same: false, ..at_run }),
            (10, State::Running, BootFacts { mode: Mode::Run, ..script }),
            (10, State::Running, BootFacts { mode: Mode::Run, ..old }),
            (11, State::Stopped, BootFacts { previous: State::Halt, ..at_stop }),
            (11, State::Stopped, BootFacts { previous: State::Halt, run_input: Some(true), ..FACTS }),
            (11, State::Stopped, BootFacts { previous: State::Stopped, ..FACTS }),
            (12, State::Stopped, BootFacts { same: false, script: true, ..at_stop }),
            (13, State::Running, BootFacts { same: false, ..at_run }),
            (14, State::Stopped, BootFacts { same: false, ..FACTS }),
            (15, State::Running, FACTS),
            (16, State::Stopped, BootFacts { run_input: Some(true), ..script }),
            (16, State::Running, BootFacts { run_input: Some(true), ..old }),
            (16, State::Stopped, old),
            (16, State::Running, BootFacts { same: true, ..old }),
        ];
        for (row, state, facts) in rows {
            assert_eq!(decide(&facts), BootOutcome { state, row }, "{facts:?}");
        }
    }

    #[test]
    fn the_switch_at_stop() {
        let stopped = BootFacts { switch_at_run: false, ..FACTS };
        assert_eq!(decide(&stopped), BootOutcome { state: State::Stopped, row: 15 });
        let m251 = BootFacts { profile: Profile::M251_2024, family: Family::M251, ..FACTS };
        assert_eq!(decide(&m251), BootOutcome { state: State::Running, row: 15 });
        let at_stop = BootFacts { switch_at_run: false, ..m251 };
        assert_eq!(decide(&at_stop), BootOutcome { state: State::Stopped, row: 12 });
        let run = BootFacts { mode: StartingMode::Run, ..at_stop };
        assert_eq!(decide(&run), BootOutcome { state: State::Stopped, row: 7 });
    }
}
