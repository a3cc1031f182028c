//! A plan and its concrete cases.

mod analogue;
mod build;
mod check;
mod envelope;
mod expand;
mod expected_states;
mod facts;
mod functions;
mod global_checks;
mod groups;
mod include;
mod inputs;
mod keys;
mod modules;
mod names;
mod read;
mod refusal;
mod settings;
mod step;
mod times;
mod uncalled;
mod variants;

use std::ops::Range;
use std::sync::Arc;

use profile::Profile;
use signal::Span;

use crate::alarm::Alarm;
use crate::expect::{Expectation, GlobalCheck};
use crate::judge::{Scenario, StepFacts};
use crate::lang::{Anchor, Need};
use crate::measure::Measurement;
use crate::signals::SignalBinding;
use crate::steps::{CasePart, ProgramRef, StepCondition, StepWait, Stimulus};

pub use functions::{FunctionSettings, FunctionType, FunctionValue};
pub use global_checks::{GlobalChecks, SUITE_KEYS};
pub use include::{PlanText, check_included, gather};
pub use inputs::InputSettings;
pub(crate) use keys::EXPECT_KEYS;
pub use keys::{GROUP_KEYS, INCLUDED_KEYS, PLAN_KEYS, STEP_KEYS};
pub use modules::ModuleSettings;
pub use read::{MAX_CASES, MAX_STEPS, Plan, read, read_gathered};
pub use refusal::ExpectedRefusal;
pub use settings::{
    AlwaysUpdate, HaltOutputs, InitialState, OutputsInStop, PlanSettings, Rearming, StartingMode,
    TaskSettings, TaskType, WatchdogBasis,
};
pub use times::AFTER_LAST;

/// What the model's outputs do with delays that their documents give as maxima (io:STD-OUT-01).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DelayModel {
    /// An edge comes when the delay is over.
    #[default]
    Exact,
    /// It comes at any instant from its command until the delay is over.
    WorstCase,
}

impl DelayModel {
    /// The names in plans.
    pub const NAMES: &[&str] = &["exact", "worst case"];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            DelayModel::Exact => "exact",
            DelayModel::WorstCase => "worst case",
        }
    }
}

/// How a step comes more than once.
#[derive(Clone, Debug, PartialEq)]
pub enum StepRepeat {
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

impl StepRepeat {
    /// How many times the step comes at most.
    pub const fn times(&self) -> u64 {
        match self {
            StepRepeat::Every { times, .. } | StepRepeat::Each { times } => *times,
        }
    }

    /// When the time `n` comes after the first one, where that is known before the case runs.
    pub fn after(&self, n: u64) -> Option<Span> {
        match self {
            StepRepeat::Every { period, until: None, .. } => {
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
    /// `.done` or pulse is meant: what depends on other steps was added up to here.
    At(Anchor),
    /// When something happens.
    When {
        /// The signal.
        signal: String,
        /// What it does.
        awaits: StepCondition,
        /// Where waiting begins; a change at the very instant counts if the trace has it later.
        from: Anchor,
        /// The same as the plan writes it: counted from the step that it names, of which the trace has a mark.
        written: Anchor,
        /// How long to wait. If it does not happen the case goes on without the step.
        within: Span,
    },
}

/// A step of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanStep {
    /// Its id; `step:<id>` is its signal in the trace. That of a step of a group has the id of the step that runs the
    /// group and a `.` in front.
    pub id: String,
    /// The part of the case that it belongs to.
    pub part: CasePart,
    /// When it comes.
    pub when: StepTime,
    /// Place of the step that its time counts from as it is written: where that lies elsewhere than the plan has it, as in a
    /// capture, this one moves with it.
    pub counts_from: Option<usize>,
    /// How it comes more than once.
    pub repeat: Option<StepRepeat>,
    /// Place of the step that the `until` of its repetition counts from.
    pub until_from: Option<usize>,
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
    pub settings: PlanSettings,
    /// What its delays mean where it is modelled.
    pub model: DelayModel,
    /// The program.
    pub program: ProgramRef,
    /// The board file as written, relative to the plan's folder; `None`: the simulated board.
    pub board: Option<String>,
    /// The signals that the plan binds, then those that it uses without binding them. `state` is built in and
    /// not among them.
    pub signals: Vec<SignalBinding>,
    /// Names that the plan binds and this case leaves aside. They are recorded all the same.
    pub unspoken: Vec<String>,
    /// The steps, setup, main and teardown each in the plan's order, those of a group after the step that runs it: the
    /// place is that of [`signal::Cause::Step`].
    pub steps: Vec<PlanStep>,
    /// What is claimed.
    pub expectations: Vec<Expectation>,
    /// What is measured.
    pub measurements: Vec<Measurement>,
    /// What is claimed of every case: of the plan, then of suite and board.
    pub invariants: Vec<GlobalCheck>,
    /// What ends the case when it lasts.
    pub alarms: Vec<Arc<Alarm>>,
    /// The end of the case; its base is as that of [`StepTime::At`].
    pub ends: Anchor,
    /// Place of the step that its end counts from as it is written.
    pub ends_from: Option<usize>,
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
    /// How often it runs, each turn with what is left to chance drawn again.
    pub repeat: u32,
    /// What its check must find, for a case that is never to run.
    pub refusal: Option<ExpectedRefusal>,
}

impl Case {
    /// What the judge needs of the case.
    pub fn scenario(&self) -> Scenario {
        Scenario {
            expectations: self.expectations.clone(),
            measurements: self.measurements.clone(),
            global_checks: self
                .invariants
                .iter()
                .cloned()
                .chain(self.alarms.iter().map(Alarm::global_check))
                .collect(),
            steps: self
                .steps
                .iter()
                .map(|step| StepFacts {
                    id: step.id.clone(),
                    awaited: Case::wait_of(step),
                    counts_from: step.counts_from,
                    train: match &step.stimulus {
                        Stimulus::Train(train) => Some(train.signal.clone()),
                        _ => None,
                    },
                    part: step.part,
                    asks: match &step.stimulus {
                        Stimulus::Ask(question) => Some(question.clone()),
                        _ => None,
                    },
                    line: step.line,
                })
                .collect(),
        }
    }

    /// How a step waits, if it does.
    fn wait_of(step: &PlanStep) -> Option<StepWait> {
        let StepTime::When { signal, awaits, written, within, .. } = &step.when else { return None };
        let from = written.clone();
        Some(StepWait { signal: signal.clone(), awaits: awaits.clone(), from, within: *within })
    }
}
