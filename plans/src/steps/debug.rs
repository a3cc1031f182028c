//! `breakpoint`, `clear-breakpoints`, `online-change`, `resume` and `step-statement`.

use document::{Findings, KeySpec, KeyType, Node};

use super::{ProgramRef, StepNames, table_fields};
use super::{StepVerb, Stimulus};

const BREAKPOINT_KEYS: &[KeySpec] = &[
    KeySpec::required(
        "line",
        KeyType::Integer(1, 1_000_000),
        "Line of the source, from 1; the next one with a statement counts.",
    ),
    KeySpec::optional("file", KeyType::Text, "The source as the plan names it; the first one if left out."),
];

const CHANGE_KEYS: &[KeySpec] = &[KeySpec::required(
    "program",
    KeyType::OneOrMore(&KeyType::Text),
    "Structured Text files relative to the plan.",
)];

pub(super) const BREAKPOINT: StepVerb = StepVerb {
    name: "breakpoint",
    doc: "Holds the tasks where one comes to the first statement of a line.",
    value: KeyType::Table(BREAKPOINT_KEYS),
    needs: &["commands"],
    read: read_breakpoint,
};

pub(super) const CLEAR_BREAKPOINTS: StepVerb = StepVerb {
    name: "clear-breakpoints",
    doc: "Takes every breakpoint away; tasks that are held go on.",
    value: KeyType::Table(&[]),
    needs: &["commands"],
    read: |_, _, _| Some(Stimulus::ClearBreakpoints),
};

pub(super) const ONLINE_CHANGE: StepVerb = StepVerb {
    name: "online-change",
    doc: "Has another program go on with the values of the variables.",
    value: KeyType::Table(CHANGE_KEYS),
    needs: &["download"],
    read: read_change,
};

pub(super) const RESUME: StepVerb = StepVerb {
    name: "resume",
    doc: "Lets tasks that are held at a breakpoint go on.",
    value: KeyType::Table(&[]),
    needs: &["commands"],
    read: |_, _, _| Some(Stimulus::Resume),
};

pub(super) const STEP_STATEMENT: StepVerb = StepVerb {
    name: "step-statement",
    doc: "Lets a task that is held at a breakpoint go on to its next statement.",
    value: KeyType::Table(&[]),
    needs: &["commands"],
    read: |_, _, _| Some(Stimulus::StepStatement),
};

fn read_breakpoint(node: &Node, _: &dyn StepNames, _: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, BREAKPOINT_KEYS)?;
    let line = u32::try_from(fields.integer("line")?).ok()?;
    let file = fields.get("file").and_then(Node::as_text).map(str::to_owned);
    Some(Stimulus::Breakpoint { line, file })
}

fn read_change(node: &Node, _: &dyn StepNames, _: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, CHANGE_KEYS)?;
    let files = fields.each("program").iter().filter_map(Node::as_text).map(str::to_owned).collect();
    Some(Stimulus::OnlineChange(ProgramRef::Files(files)))
}
