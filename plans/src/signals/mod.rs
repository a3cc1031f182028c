//! Signals of a plan: what a name stands for, and how its changes are recorded.

pub(crate) mod frames;
mod read;

use std::ops::Range;
use std::sync::Arc;

use signal::{Address, Span};

use crate::frames::can::{FramePattern, FrameSignal};
use crate::lang::Literal;

pub(crate) use read::{BUILT_IN, SIGNAL_TYPE, SOURCE_KEYS, read, source, text_source};

/// What a name of a plan stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SignalSource {
    /// An input or output terminal of the controller: the line itself (`%IX0.0`, `%QX0.4`).
    Line(Address),
    /// A place of the memory (`%MW10`), or more than one bit of the inputs or outputs (`%IW0`).
    Memory(Address),
    /// A bit of the image that the program sees, after the filter or before the output.
    Image(Address),
    /// A variable of the program, a system variable (`PLC_R...`) or a channel of the board, found by the runtime
    /// in this order.
    Path(String),
    /// A channel of the board.
    Channel(String),
    /// A figure of a task.
    Task {
        /// Name of the task.
        task: String,
        /// Which figure.
        figure: TaskFigure,
    },
    /// How many entries of the controller's log hold this text.
    Log(String),
    /// A file of the controller.
    File {
        /// Its path, in any case of letters.
        path: String,
        /// What is asked of it.
        asks: FileFigure,
    },
    /// A register as a client in the network reads it.
    Register {
        /// Its number.
        register: u16,
        /// The exception of reading it in place of its value.
        exception: bool,
    },
    /// How many frames like this were on their bus.
    Frames(Arc<FramePattern>),
    /// A value in the last frame like this.
    FrameSignal(Arc<FrameSignal>),
    /// A row of the relocation table.
    Relocation {
        /// Its variable.
        row: String,
        /// What is asked of it.
        figure: RowFigure,
    },
}

/// What can be asked of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileFigure {
    /// Whether it is there.
    Exists,
    /// Whether it holds a text.
    Holds(String),
    /// Its bytes.
    Size,
    /// Entries that it lost because the disk was full.
    Lost,
}

/// What can be asked of a row of the relocation table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RowFigure {
    /// Its first register, -1 where its variable does not exist.
    Address,
    /// How many registers it has.
    Length,
    /// Whether its variable exists.
    Valid,
}

/// What can be asked of a task. Times are in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TaskFigure {
    /// Cycles that ended.
    Cycles,
    /// Processor time of the last cycle.
    LastCycle,
    /// Least processor time of a cycle.
    MinCycle,
    /// Most processor time of a cycle.
    MaxCycle,
    /// From start to end of the last cycle.
    Elapsed,
    /// Cycles that took longer than the interval.
    Overruns,
    /// Lost releases.
    Lost,
    /// Watchdog exceptions.
    Exceptions,
    /// Mean processor time of a cycle.
    MeanCycle,
    /// From the last release to the start of its cycle.
    Jitter,
    /// Least time from a release to the start of its cycle.
    MinJitter,
    /// Most time from a release to the start of its cycle.
    MaxJitter,
    /// Per cent of the processor in the last whole second.
    Load,
}

impl TaskFigure {
    /// The names in plans, in the order of the enumeration.
    pub const NAMES: &[&str] = &[
        "cycles",
        "last-cycle",
        "min-cycle",
        "max-cycle",
        "elapsed",
        "overruns",
        "lost",
        "exceptions",
        "mean-cycle",
        "jitter",
        "min-jitter",
        "max-jitter",
        "load",
    ];

    /// Every figure.
    pub const ALL: [TaskFigure; 13] = [
        TaskFigure::Cycles,
        TaskFigure::LastCycle,
        TaskFigure::MinCycle,
        TaskFigure::MaxCycle,
        TaskFigure::Elapsed,
        TaskFigure::Overruns,
        TaskFigure::Lost,
        TaskFigure::Exceptions,
        TaskFigure::MeanCycle,
        TaskFigure::Jitter,
        TaskFigure::MinJitter,
        TaskFigure::MaxJitter,
        TaskFigure::Load,
    ];

    /// The figure of this name.
    pub fn find(name: &str) -> Option<TaskFigure> {
        let at = Self::NAMES.iter().position(|known| *known == name)?;
        Self::ALL.get(at).copied()
    }
}

/// Which changes of a signal are recorded.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordingPolicy {
    /// Every change.
    Changes,
    /// Changes by more than this, a number above 0 or such a quantity.
    Deadband(Literal),
    /// At most one value in this time, which is above 0.
    AtMostEvery(Span),
}

/// A name of the plan and what it stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalBinding {
    /// The name that the trace has.
    pub name: String,
    /// What it stands for.
    pub source: SignalSource,
    /// How it is recorded.
    pub recording: RecordingPolicy,
    /// It is there for the trace, even if nothing speaks of it.
    pub record: bool,
    /// The file that binds or first uses it, where that is not the plan.
    pub file: Option<Arc<str>>,
    /// Bytes of that file.
    pub span: Range<usize>,
}
