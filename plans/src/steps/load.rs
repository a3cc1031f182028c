//! `overload`: cycles of a task that take longer than its program does. `suspend`: a task that does not get the
//! processor.

use document::{Findings, KeySpec, KeyType, Node};

use super::drive::above_zero;
use super::{StepNames, table_fields};
use super::{StepVerb, Stimulus};

const KEYS: &[KeySpec] = &[
    KeySpec::required("task", KeyType::Text, "Name of the task."),
    KeySpec::required("cycle", KeyType::Duration, "Time of execution of one cycle in all."),
    KeySpec::optional("times", KeyType::Integer(1, 1_000_000), "How many cycles; 1 if left out."),
];

pub(super) const OVERLOAD: StepVerb = StepVerb {
    name: "overload",
    doc: "Makes the next cycles of a task take a given time.",
    value: KeyType::Table(KEYS),
    needs: &["task-load"],
    read,
};

fn read(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, KEYS)?;
    // Whether there is such a task is known only with the program: it may configure tasks of its own.
    let task = fields.text("task").map(str::to_owned);
    let cycle = above_zero(&fields, "cycle", out);
    // The type's limits hold the number within 32 bits.
    let times = fields.integer("times").map_or(1, |times| u32::try_from(times).unwrap_or(u32::MAX));
    Some(Stimulus::Overload { task: task?, cycle: cycle?, times })
}

const SUSPEND_KEYS: &[KeySpec] = &[
    KeySpec::required("task", KeyType::Text, "Name of the task."),
    KeySpec::required("duration", KeyType::Duration, "How long it does not get the processor.").was("for"),
];

pub(super) const SUSPEND: StepVerb = StepVerb {
    name: "suspend",
    doc: "Keeps a task from the processor, however much it wants it.",
    value: KeyType::Table(SUSPEND_KEYS),
    needs: &["task-load"],
    read: read_suspend,
};

fn read_suspend(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, SUSPEND_KEYS)?;
    let task = fields.text("task").map(str::to_owned);
    let lasts = above_zero(&fields, "duration", out);
    Some(Stimulus::Suspend { task: task?, lasts: lasts? })
}
