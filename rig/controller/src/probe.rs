//! What can be observed inside the controller.

use crate::config::RelocationPart;
use crate::led::Led;
use crate::scheduler::TaskFigure;
use crate::terminal::Terminal;
use profile::SystemVariable;
use signal::{Address, Level};

/// Something observable inside the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probe {
    /// The state: [`crate::State::number`].
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
    /// The terminal of an output.
    Terminal(Terminal),
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

/// What can be observed of an input besides its terminal and its image (io: section 17.6).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InputProbe {
    /// The level behind own delay and filter: a Boolean.
    Filtered,
    /// Whether the latch holds a pulse for the next read of MAST: a Boolean.
    Latched,
    /// Events that it raised since power-on: a count.
    Events,
    /// It was driven faster than its profile allows: a Boolean that stays (io:REF-03).
    Overdriven,
}

/// What can be asked of a register or of a row of the relocation table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegisterProbe {
    /// What reading it gives; unknown where nothing answers, and after an exception.
    Value(u16),
    /// The exception that reading it gives: 0 for none, 2 for an illegal address; unknown where nothing answers.
    Exception(u16),
    /// The address of a row: -1 where its variable does not exist (controller:REL-05).
    Address(RelocationPart, u16),
    /// The length of a row in registers.
    Length(RelocationPart, u16),
    /// Whether the variable of a row exists.
    Valid(RelocationPart, u16),
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
