//! The keys of a plan and of what stands in its lists.

use document::{KeySpec, KeyType};

use super::refusal::REFUSAL_KEYS;
use super::settings::SETTINGS_KEYS;
use super::signals::SIGNAL_TYPE;
use super::variants::{PARAMETER_TYPE, ROW_TYPE, SWEEP_TYPE};

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
    KeySpec::optional("ends", KeyType::Anchor, "The end of a case; 1 s after the last step if left out."),
    KeySpec::optional("timeout", KeyType::Duration, "Most modelled time of a case, from power-on."),
    KeySpec::optional("steps", KeyType::List(&KeyType::Table(STEP_KEYS)), "What is done, in order."),
    KeySpec::optional("expect", KeyType::List(&KeyType::Table(EXPECT_KEYS)), "What is claimed."),
    KeySpec::optional("measure", KeyType::List(&KeyType::Any), "What is measured."),
    KeySpec::optional("rows", KeyType::Map(&ROW_TYPE), "Cases: name and values of each."),
    KeySpec::optional("sweep", KeyType::Map(&SWEEP_TYPE), "Values that multiply the cases."),
    KeySpec::optional(
        "parameters",
        KeyType::Map(&PARAMETER_TYPE),
        "Values that the command line may change.",
    ),
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
];

/// The keys that every step has besides its verb.
pub const STEP_KEYS: &[KeySpec] = &[
    KeySpec::required("id", KeyType::Text, "The step's name, for instants such as `busy + 10 ms`."),
    KeySpec::optional("at", KeyType::Anchor, "The instant of the step."),
    KeySpec::optional("when", KeyType::Table(WHEN_KEYS), "What the step waits for."),
    KeySpec::optional(
        "phase",
        KeyType::Table(PHASE_KEYS),
        "Moves the step over a span of time, case by case.",
    ),
    KeySpec::optional("rows", KeyType::List(&KeyType::Text), "The rows that have the step; all if left out."),
    KeySpec::optional("refused", KeyType::Bool, "The controller must refuse what the step does."),
];

/// The keys that every expectation has besides its verb.
pub(super) const EXPECT_KEYS: &[KeySpec] = &[
    KeySpec::optional("name", KeyType::Text, "The expectation in the reader's words."),
    KeySpec::optional("rows", KeyType::List(&KeyType::Text), "The rows that claim it; all if left out."),
];
