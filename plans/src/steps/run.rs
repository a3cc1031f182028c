//! `run`: the steps and claims of a group.

use document::{Findings, KeyType, Node};

use super::StepNames;
use super::{StepVerb, Stimulus};

pub(super) const RUN: StepVerb = StepVerb {
    name: "run",
    doc: "Runs a group of steps with arguments.",
    value: KeyType::Map(&KeyType::Any),
    needs: &[],
    read,
};

/// Which group it is, and whether it has the arguments, was looked at when its steps were put into the case.
fn read(node: &Node, _: &dyn StepNames, _: &mut Findings) -> Option<Stimulus> {
    let group = node.as_table()?.get("group")?.as_text()?.to_owned();
    Some(Stimulus::Run { group })
}
