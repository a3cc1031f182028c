//! The states of the controller.

use profile::PlcStatus;

/// A state of the controller (controller:STATE-01).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// Without power.
    Off,
    /// Self tests and loading of the boot application.
    Booting,
    /// No valid firmware.
    InvalidOs,
    /// No application.
    Empty,
    /// A valid application, stopped.
    Stopped,
    /// Executing.
    Running,
    /// Stopped by an application error.
    Halt,
    /// Executing, held at a breakpoint.
    Breakpoint,
}

impl State {
    /// Every state.
    pub const ALL: [State; 8] = [
        State::Off,
        State::Booting,
        State::InvalidOs,
        State::Empty,
        State::Stopped,
        State::Running,
        State::Halt,
        State::Breakpoint,
    ];

    /// The state as the system variable shows it (controller:STATE-02); none where no service answers.
    pub(crate) const fn status(self) -> Option<PlcStatus> {
        match self {
            State::Off | State::Booting | State::InvalidOs => None,
            State::Empty => Some(PlcStatus::Empty),
            State::Stopped => Some(PlcStatus::Stopped),
            State::Running => Some(PlcStatus::Running),
            State::Halt => Some(PlcStatus::Halt),
            State::Breakpoint => Some(PlcStatus::Breakpoint),
        }
    }

    /// The state's number in a trace: that of the system variable where it has one, else 16 and above.
    pub const fn number(self) -> i64 {
        match self {
            State::Booting => 16,
            State::InvalidOs => 17,
            State::Off => 32,
            State::Empty => PlcStatus::Empty.code() as i64,
            State::Stopped => PlcStatus::Stopped.code() as i64,
            State::Running => PlcStatus::Running.code() as i64,
            State::Halt => PlcStatus::Halt.code() as i64,
            State::Breakpoint => PlcStatus::Breakpoint.code() as i64,
        }
    }

    /// The state of this number.
    pub(crate) fn from_number(number: i64) -> Option<State> {
        State::ALL.into_iter().find(|state| state.number() == number)
    }

    /// The name in reports, as in `RUNNING`.
    pub const fn name(self) -> &'static str {
        match self {
            State::Off => "OFF",
            State::Booting => "BOOTING",
            State::InvalidOs => "INVALID_OS",
            State::Empty => "EMPTY",
            State::Stopped => "STOPPED",
            State::Running => "RUNNING",
            State::Halt => "HALT",
            State::Breakpoint => "BREAKPOINT",
        }
    }
}

impl std::fmt::Display for State {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // controller:STATE-02
    #[test]
    fn numbers_are_unique() {
        for state in State::ALL {
            assert_eq!(State::from_number(state.number()), Some(state));
        }
        assert_eq!(State::from_number(3), None);
    }
}
