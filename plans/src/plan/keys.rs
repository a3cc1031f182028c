//! The keys of a plan and of what stands in its lists.

use document::{KeySpec, KeyType};

use super::DelayModel;
use super::global_checks::ALARM_KEYS;
use super::refusal::REFUSAL_KEYS;
use super::settings::SETTINGS_KEYS;
use super::variants::{PARAMETER_TYPE, ROW_TYPE, SWEEP_TYPE};
use crate::measure;
use crate::signals::SIGNAL_TYPE;
use crate::signals::frames::FRAME_TYPE;

const FILES: KeyType = KeyType::OneOrMore(&KeyType::Text);

/// The keys of a plan.
pub const PLAN_KEYS: &[KeySpec] = &[
    KeySpec::required("format", KeyType::Integer(1, 1), "The format of the plan, 1."),
    KeySpec::optional("title", KeyType::Text, "What the plan shows, one sentence."),
    KeySpec::optional("description", KeyType::Text, "Anything that a reader should know."),
    KeySpec::optional(
        "proves",
        KeyType::List(&KeyType::Text),
        "IDs of the requirements that the plan proves.",
    ),
    KeySpec::optional(
        "tags",
        KeyType::List(&KeyType::Text),
        "Words of your own to choose and filter cases by.",
    ),
    KeySpec::optional(
        "profiles",
        KeyType::List(&KeyType::Text),
        "The profiles that it holds for; all if left out.",
    ),
    KeySpec::optional("program", FILES, "Structured Text files, relative to the plan."),
    KeySpec::optional("program-text", KeyType::Text, "Structured Text in the plan itself."),
    KeySpec::optional(
        "board",
        KeyType::Text,
        "The board file, relative to the plan; a simulated board if left out.",
    ),
    KeySpec::optional(
        "needs",
        KeyType::List(&KeyType::Text),
        "Powers of rig and subject that the plan needs.",
    ),
    KeySpec::optional("settings", KeyType::Table(SETTINGS_KEYS), "Configuration of the controller."),
    KeySpec::optional(
        "model",
        KeyType::Choice(DelayModel::NAMES),
        "Whether modelled outputs change at the end of their documented delay or at any instant up to it.",
    ),
    KeySpec::optional(
        "refused",
        KeyType::Table(REFUSAL_KEYS),
        "Errors that the check of the case must find.",
    ),
    KeySpec::optional(
        "warned",
        KeyType::Table(REFUSAL_KEYS),
        "Warnings that the check of the case must find.",
    ),
    KeySpec::optional("signals", KeyType::Map(&SIGNAL_TYPE), "Names and what they stand for."),
    KeySpec::optional("frames", KeyType::Map(&FRAME_TYPE), "Frames of buses, and values in them, by name."),
    KeySpec::optional("ends", KeyType::Anchor, "The end of a case; 1 s after the last step if left out."),
    KeySpec::optional("timeout", KeyType::Duration, "Most modelled time of a case, from power-on."),
    KeySpec::optional(
        "include",
        FILES,
        "Files with signals, groups, parameters and settings, relative to the plan.",
    ),
    KeySpec::optional("setup", STEPS, "What is done before the steps; they wait for it."),
    KeySpec::optional("steps", STEPS, "What is done, in order."),
    KeySpec::optional("teardown", STEPS, "What is done after the case, however it ended."),
    KeySpec::optional(
        "group",
        KeyType::Map(&KeyType::Table(GROUP_KEYS)),
        "Steps and claims with a name, for `run`.",
    ),
    KeySpec::optional("expect", KeyType::List(&KeyType::Table(EXPECT_KEYS)), "What is claimed."),
    KeySpec::optional(
        "invariants",
        KeyType::List(&KeyType::Table(EXPECT_KEYS)),
        "What is claimed of every case from its start to its end.",
    ),
    KeySpec::optional(
        "alarms",
        KeyType::List(&KeyType::Table(ALARM_KEYS)),
        "What ends a case when it lasts.",
    ),
    KeySpec::optional("measure", KeyType::List(&KeyType::Table(measure::KEYS)), "What is measured."),
    KeySpec::optional(
        measure::GUARD,
        KeyType::Choice(measure::GUARDS),
        "How the uncertainty of what is measured counts against limits: a guard band, or none.",
    ),
    KeySpec::optional(
        "repeat",
        KeyType::Integer(1, 10_000),
        "How often each case runs, with what is left to chance drawn again; every turn has to pass.",
    ),
    KeySpec::optional("rows", KeyType::Map(&ROW_TYPE), "Cases: name and values of each."),
    KeySpec::optional("sweep", KeyType::Map(&SWEEP_TYPE), "Values that multiply the cases."),
    KeySpec::optional(
        "parameters",
        KeyType::Map(&PARAMETER_TYPE),
        "Values that the command line may change.",
    ),
];

const STEPS: KeyType = KeyType::List(&KeyType::Table(STEP_KEYS));

/// The keys of an included file.
pub const INCLUDED_KEYS: &[KeySpec] = &[
    KeySpec::required("format", KeyType::Integer(1, 1), "The format of the file, 1."),
    KeySpec::optional("description", KeyType::Text, "Anything that a reader should know."),
    KeySpec::optional("include", FILES, "Further files, relative to this one."),
    KeySpec::optional("signals", KeyType::Map(&SIGNAL_TYPE), "Names and what they stand for."),
    KeySpec::optional("frames", KeyType::Map(&FRAME_TYPE), "Frames of buses, and values in them, by name."),
    KeySpec::optional("settings", KeyType::Any, "Configuration of the controller."),
    KeySpec::optional("group", KeyType::Any, "Steps and claims with a name, for `run`."),
    KeySpec::optional("invariants", KeyType::List(&KeyType::Any), "What is claimed of every case."),
    KeySpec::optional("parameters", KeyType::Any, "Values that the command line may change."),
];

/// The keys of a group.
pub const GROUP_KEYS: &[KeySpec] = &[
    KeySpec::optional("description", KeyType::Text, "What the group is for."),
    KeySpec::optional(
        "args",
        KeyType::Map(&KeyType::Any),
        "Its arguments: the value where a call gives none, or { doc = ... } for one that every call gives.",
    ),
    KeySpec::optional("steps", STEPS, "What is done; instants count from `begin`."),
    KeySpec::optional("expect", KeyType::List(&KeyType::Table(EXPECT_KEYS)), "What every call claims."),
    KeySpec::optional("measure", KeyType::List(&KeyType::Table(measure::KEYS)), "What every call measures."),
];

/// The keys of an argument that is written as a table.
pub(super) const ARG_KEYS: &[KeySpec] = &[
    KeySpec::optional("default", KeyType::Value, "The value where a call gives none."),
    KeySpec::optional("doc", KeyType::Text, "What it means."),
];

/// Most times that a step comes again: far more than a person looks at, and few enough for every trace.
pub(super) const MOST_TIMES: i64 = 1_000_000;

/// The keys of a step's `every`.
pub(super) const EVERY_KEYS: &[KeySpec] = &[
    KeySpec::required("period", KeyType::Duration, "From one time to the next."),
    KeySpec::optional("times", KeyType::Integer(1, MOST_TIMES), "How many times in all."),
    KeySpec::optional("until", KeyType::Anchor, "The instant from which on it comes no more."),
];

const PHASE_KEYS: &[KeySpec] = &[
    KeySpec::required("over", KeyType::Duration, "The time over which the step is moved."),
    KeySpec::optional(
        "positions",
        KeyType::Integer(1, 100_000),
        "How many evenly spread positions, each a case; one at random if left out.",
    ),
];

/// The keys of a step's `when`.
pub(super) const WHEN_KEYS: &[KeySpec] = &[
    KeySpec::required("signal", KeyType::SignalRef, "The signal that is waited for."),
    KeySpec::optional("becomes", KeyType::Value, "The value that it changes to."),
    KeySpec::optional(
        "edge",
        KeyType::Choice(&["rises", "falls", "changes"]),
        "The edge that is waited for.",
    ),
    KeySpec::optional("above", KeyType::Value, "The limit that it moves above."),
    KeySpec::optional("below", KeyType::Value, "The limit that it moves below."),
    KeySpec::optional("from", KeyType::Anchor, "Where waiting begins; at the step before if left out."),
    KeySpec::required("within", KeyType::Duration, "How long to wait; the case fails if it does not happen."),
    KeySpec::optional("each", KeyType::Bool, "The step comes every time that it happens, not once."),
    KeySpec::optional(
        "times",
        KeyType::Integer(1, MOST_TIMES),
        "With `each`: how many times at most; 1000 if left out.",
    ),
];

/// The keys that every step has besides its verb.
pub const STEP_KEYS: &[KeySpec] = &[
    KeySpec::required("id", KeyType::Text, "The step's name, for instants such as `busy + 10 ms`."),
    KeySpec::optional("at", KeyType::Anchor, "The instant of the step."),
    KeySpec::optional("when", KeyType::Table(WHEN_KEYS), "What the step waits for."),
    KeySpec::optional(
        "every",
        KeyType::Table(EVERY_KEYS),
        "Lets the step come again and again, from `at` on.",
    ),
    KeySpec::optional(
        "phase",
        KeyType::Table(PHASE_KEYS),
        "Moves the step over a span of time, case by case.",
    ),
    KeySpec::optional("rows", KeyType::List(&KeyType::Text), "The rows that have the step; all if left out."),
    KeySpec::optional("refused", KeyType::Bool, "The controller must refuse what the step does."),
];

/// The keys that every expectation has besides its verb.
pub(crate) const EXPECT_KEYS: &[KeySpec] = &[
    KeySpec::optional("name", KeyType::Text, "The expectation in the reader's words."),
    KeySpec::optional("rows", KeyType::List(&KeyType::Text), "The rows that claim it; all if left out."),
];
