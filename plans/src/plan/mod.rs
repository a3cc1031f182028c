//! A plan and its concrete cases.

mod build;
mod check;
mod envelope;
mod expand;
mod facts;
mod functions;
mod groups;
mod guards;
mod include;
mod inputs;
mod keys;
mod read;
mod refusal;
mod scope;
mod settings;
mod signals;
mod step;
mod times;
mod variants;

use std::ops::Range;
use std::sync::Arc;

use profile::Profile;
use signal::{Address, Span};

use crate::alarm::Alarm;
use crate::expect::Expectation;
use crate::frames::can::{FramePattern, FrameSignal};
use crate::judge::{Guard, Scenario, StepFacts};
use crate::lang::{Anchor, Literal, Need};
use crate::measure::Measurement;
use crate::steps::Stimulus;

pub use functions::{FunctionSettings, FunctionType, FunctionValue};
pub use guards::{Guards, SUITE_KEYS};
pub use include::{PlanText, check_included, gather};
pub use inputs::InputSettings;
pub(crate) use keys::EXPECT_KEYS;
pub use keys::{GROUP_KEYS, INCLUDED_KEYS, PLAN_KEYS, STEP_KEYS};
pub use read::{MAX_CASES, MAX_STEPS, Plan, read, read_gathered};
pub use refusal::Refusal;
pub use scope::Scope;
pub(crate) use settings::output;
pub use settings::{
    AlwaysUpdate, HaltOutputs, Initial, OutputsInStop, Rearming, Settings, StartingMode, TaskSettings,
    TaskType, WatchdogBasis,
};

pub(crate) use signals::{AT_MOST_EVERY, BUILT_IN, DEADBAND, RECORD, SOURCE_KEYS, recording};

/// The program of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProgramRef {
    /// Structured Text files, as written: relative to the plan's folder.
    Files(Vec<String>),
    /// Structured Text in the plan itself, with the byte of the plan at which it begins (where the plan has
    /// it as it is).
    Text {
        /// The source.
        text: String,
        /// Byte of the plan, `None` if escapes stand in it.
        at: Option<usize>,
    },
    /// None: the controller starts without an application.
    None,
}

/// What a name of a plan stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// An input or output terminal of the controller: the line itself (`%IX0.0`, `%QX0.4`).
    Line(Address),
    /// A place of the memory (`%MW10`), or more than one bit of the inputs or outputs (`%IW0`).
    Memory(Address),
    /// A bit of the image that the program sees, behind the filter or before the output.
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
pub enum Recording {
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
    pub source: Source,
    /// How it is recorded.
    pub recording: Recording,
    /// It is there for the trace, even if nothing speaks of it.
    pub record: bool,
    /// The file that binds or first uses it, where that is not the plan.
    pub file: Option<Arc<str>>,
    /// Bytes of that file.
    pub span: Range<usize>,
}

/// What an awaited step waits for.
#[derive(Clone, Debug, PartialEq)]
pub enum Await {
    /// The signal changes to this value.
    Becomes(Literal),
    /// It becomes TRUE (or non-zero).
    Rises,
    /// It becomes FALSE (or zero).
    Falls,
    /// Any change.
    Changes,
    /// It moves from at or below to above this.
    Above(Literal),
    /// It moves from at or above to below this.
    Below(Literal),
}

/// A part of a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// Before the steps proper, which wait for all of it.
    Setup,
    /// The steps proper.
    #[default]
    Main,
    /// Behind the case, however it ended.
    Teardown,
}

impl Phase {
    /// The word in records.
    pub const fn word(self) -> &'static str {
        match self {
            Phase::Setup => "setup",
            Phase::Main => "main",
            Phase::Teardown => "teardown",
        }
    }
}

/// How a step comes more than once.
#[derive(Clone, Debug, PartialEq)]
pub enum Repeat {
    /// Again and again from its instant on.
    Every {
        /// From one time to the next, above 0.
        period: Span,
        /// How many times at most, from 1.
        times: u64,
        /// From here on no more; its base is as that of [`StepTime::At`].
        until: Option<Anchor>,
    },
    /// Every time that what it waits for happens.
    Each {
        /// How many times at most, from 1.
        times: u64,
    },
}

impl Repeat {
    /// How many times the step comes at most.
    pub const fn times(&self) -> u64 {
        match self {
            Repeat::Every { times, .. } | Repeat::Each { times } => *times,
        }
    }

    /// When the time `n` comes after the first one, where that is known before the case runs.
    pub fn after(&self, n: u64) -> Option<Span> {
        match self {
            Repeat::Every { period, until: None, .. } => {
                let nanos = i128::from(period.as_nanos()) * i128::from(n.saturating_sub(1));
                Some(Span::from_nanos(i64::try_from(nanos).unwrap_or(i64::MAX)))
            }
            _ => None,
        }
    }
}

/// When a step comes.
#[derive(Clone, Debug, PartialEq)]
pub enum StepTime {
    /// At an instant. Its base is never `end`, and a step among its bases is one that is awaited or whose
    /// `.done` or pulse is meant: what hangs on other steps was added up to here.
    At(Anchor),
    /// When something happens.
    When {
        /// The signal.
        signal: String,
        /// What it does.
        awaits: Await,
        /// Where waiting begins; a change at the very instant counts if the trace has it later.
        from: Anchor,
        /// How long to wait. If it does not happen the case goes on without the step.
        within: Span,
    },
}

/// A step of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Its id; `step:<id>` is its signal in the trace. That of a step of a group has the id of the step that runs the
    /// group and a `.` in front.
    pub id: String,
    /// The part of the case that it belongs to.
    pub phase: Phase,
    /// When it comes.
    pub when: StepTime,
    /// How it comes more than once.
    pub repeat: Option<Repeat>,
    /// Place of the step that runs its group.
    pub parent: Option<usize>,
    /// What it does.
    pub stimulus: Stimulus,
    /// Whether the controller must refuse it (a command or a download).
    pub refused: bool,
    /// Bytes of the plan.
    pub span: Range<usize>,
    /// Line of the plan, from 1.
    pub line: u32,
}

/// A concrete case: a plan with one row, one point of each sweep and one phase.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name: the plan's path without `.toml`, then `[row]`, `[sweep=value]`, `[step.phase=3/16]`.
    pub name: String,
    /// The plan's title, with the case's values put in.
    pub title: String,
    /// Name of the row, where the plan has rows.
    pub row: Option<String>,
    /// What `$` names had which value, in the plan's order.
    pub parameters: Vec<(String, String)>,
    /// The configuration.
    pub settings: Settings,
    /// The program.
    pub program: ProgramRef,
    /// The board file as written, relative to the plan's folder; `None`: the simulated board.
    pub board: Option<String>,
    /// The signals that the plan binds, then those that it uses without binding them. `state` is built in and
    /// not among them.
    pub signals: Vec<SignalBinding>,
    /// Names that the plan binds and this case leaves aside. They are recorded all the same.
    pub unspoken: Vec<String>,
    /// The steps, setup, main and teardown each in the plan's order, those of a group behind the step that runs it: the
    /// place is that of [`signal::Cause::Step`].
    pub steps: Vec<Step>,
    /// What is claimed.
    pub expectations: Vec<Expectation>,
    /// What is measured.
    pub measurements: Vec<Measurement>,
    /// What is claimed of every case: of the plan, then of suite and board.
    pub invariants: Vec<Guard>,
    /// What ends the case when it lasts.
    pub alarms: Vec<Arc<Alarm>>,
    /// The end of the case; its base is as that of [`StepTime::At`].
    pub ends: Anchor,
    /// Most modelled time from power-on to the end of the case.
    pub timeout: Span,
    /// Most modelled time of the teardown.
    pub teardown: Span,
    /// What it needs of rig and subject: what the plan says and what its verbs and signals imply.
    pub needs: Vec<Need>,
    /// IDs of the requirements that it proves.
    pub proves: Vec<String>,
    /// Words that it can be chosen by.
    pub tags: Vec<String>,
    /// The profiles that it holds for; empty for all.
    pub profiles: Vec<Profile>,
    /// How often it runs, each turn with what is left to chance drawn anew.
    pub repeat: u32,
    /// What its check must find, for a case that is never to run.
    pub refusal: Option<Refusal>,
}

impl Case {
    /// What the judge needs of the case.
    pub fn scenario(&self) -> Scenario {
        Scenario {
            expectations: self.expectations.clone(),
            measurements: self.measurements.clone(),
            guards: self.invariants.iter().cloned().chain(self.alarms.iter().map(Alarm::guard)).collect(),
            steps: self
                .steps
                .iter()
                .map(|step| StepFacts {
                    id: step.id.clone(),
                    awaited: match step.when {
                        StepTime::When { within, .. } => Some(within),
                        StepTime::At(_) => None,
                    },
                    train: match &step.stimulus {
                        Stimulus::Train(train) => Some(train.signal.clone()),
                        _ => None,
                    },
                    phase: step.phase,
                    asks: match &step.stimulus {
                        Stimulus::Ask(question) => Some(question.clone()),
                        _ => None,
                    },
                    line: step.line,
                })
                .collect(),
        }
    }
}
