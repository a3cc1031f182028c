//! What the controller hands back, and what of it can be observed.

use crate::{InputProbe, Led, LogEntry, RegisterProbe, State, SystemVariable, TaskFigure};
use signal::{Address, Cause, Level, Span, Time, Value};

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
        figure: TaskFigure,
    },
    /// Something of an embedded input besides its image.
    Input {
        /// The input: n for In.
        input: usize,
        /// What of it.
        part: InputProbe,
    },
    /// An output terminal.
    Terminal(usize),
    /// A fact of files or of the log, by its number: [`crate::Controller::file_probe`].
    File(u16),
    /// A fact of the registers that the network sees, or of the relocation table.
    Register(RegisterProbe),
    /// The state of an output's stage: [`OutputState::number`].
    Output(usize),
    /// Something of an expert function.
    Expert {
        /// The function, by its place in the configuration.
        function: usize,
        /// What of it.
        fact: expert::FunctionProbe,
    },
    /// What an indicator shows: [`crate::LedPattern::number`].
    Led(Led),
    /// Whether an indicator is lit; reckoned only while it is observed.
    LedLit(Led),
}

/// What an output's stage does (io:STD-OUT-02).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum OutputState {
    /// Driven to 0, or a contact that is open.
    Off = 0,
    /// Driven to 1, or a contact that is closed.
    On = 1,
    /// Not driven.
    HighZ = 2,
    /// Switched off by its protection.
    Protected = 3,
}

impl OutputState {
    /// Every state.
    pub const ALL: [OutputState; 4] =
        [OutputState::Off, OutputState::On, OutputState::HighZ, OutputState::Protected];

    /// The number in a trace.
    pub const fn number(self) -> i64 {
        self as i64
    }

    /// The name in plans and reports.
    pub const fn name(self) -> &'static str {
        match self {
            OutputState::Off => "0",
            OutputState::On => "1",
            OutputState::HighZ => "Z",
            OutputState::Protected => "protected",
        }
    }
}

impl From<Level> for OutputState {
    fn from(level: Level) -> Self {
        match level {
            Level::Low => OutputState::Off,
            Level::High => OutputState::On,
            Level::HighZ => OutputState::HighZ,
        }
    }
}

/// The number of an observed probe, in the order of [`crate::Controller::watch`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ProbeId(pub u32);
