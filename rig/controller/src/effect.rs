//! What the controller hands back, and what of it can be observed.

use crate::{Entry, Figure, State};
use signal::{Address, Cause, Level, Time, Value};

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// An output terminal changed.
    Terminal {
        /// When.
        at: Time,
        /// The output: n for Qn.
        output: usize,
        /// What it is from then on. High is the conducting state, also of sink outputs and relays.
        level: Level,
        /// Who wrote it.
        cause: Cause,
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
        entry: Entry,
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

/// Something observable inside the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probe {
    /// The state: [`State::number`].
    State,
    /// A place in memory: a Boolean for bits, else a bit string.
    Address(Address),
    /// A variable of the application by its number; unknown without an application.
    Variable(u32),
    /// A system variable; unknown while no service answers.
    System(SystemVariable),
    /// A figure of a task.
    TaskFigure {
        /// The task's place in the configuration.
        task: usize,
        /// Which figure.
        figure: Figure,
    },
    /// An output terminal.
    Terminal(usize),
}

/// The number of an observed probe, in the order of [`crate::Controller::watch`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ProbeId(pub u32);

/// The system variables that the state machine keeps (controller:STATE-02, controller:SYS-01...03).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SystemVariable {
    /// PLC_R.i_wStatus.
    Status,
    /// PLC_R.i_wBootProjectStatus.
    BootProjectStatus,
    /// PLC_R.i_wLastStopCause.
    LastStopCause,
    /// PLC_R.i_wLastApplicationError.
    LastApplicationError,
}

impl SystemVariable {
    /// Every system variable.
    pub const ALL: [SystemVariable; 4] = [
        SystemVariable::Status,
        SystemVariable::BootProjectStatus,
        SystemVariable::LastStopCause,
        SystemVariable::LastApplicationError,
    ];

    /// The name, as in `PLC_R.i_wStatus`.
    pub const fn name(self) -> &'static str {
        match self {
            SystemVariable::Status => "PLC_R.i_wStatus",
            SystemVariable::BootProjectStatus => "PLC_R.i_wBootProjectStatus",
            SystemVariable::LastStopCause => "PLC_R.i_wLastStopCause",
            SystemVariable::LastApplicationError => "PLC_R.i_wLastApplicationError",
        }
    }

    /// The system variable of this name, in any case of letters.
    pub fn find(name: &str) -> Option<SystemVariable> {
        SystemVariable::ALL.into_iter().find(|variable| variable.name().eq_ignore_ascii_case(name))
    }
}
