//! `command`, `download`, `power`, `power-cut` and `mark`.

use document::{Findings, KeySpec, KeyType, Node};

use super::drive::above_zero;
use super::{Command, Stimulus, Verb};
use crate::plan::{ProgramRef, Scope};

const DOWNLOAD_KEYS: &[KeySpec] = &[KeySpec::optional(
    "program",
    KeyType::OneOrMore(&KeyType::Text),
    "Structured Text files relative to the plan; the plan's own program if left out.",
)];

const CUT_KEYS: &[KeySpec] = &[KeySpec::required("lasts", KeyType::Duration, "How long the supply is off.")];

pub(super) const COMMAND: Verb = Verb {
    name: "command",
    doc: "Commands the controller.",
    value: KeyType::Choice(&["run", "stop", "reset-warm", "reset-cold"]),
    needs: &["commands"],
    read: read_command,
};

pub(super) const DOWNLOAD: Verb = Verb {
    name: "download",
    doc: "Downloads an application.",
    value: KeyType::Table(DOWNLOAD_KEYS),
    needs: &["download"],
    read: read_download,
};

pub(super) const POWER: Verb = Verb {
    name: "power",
    doc: "Switches the controller's supply.",
    value: KeyType::Choice(&["on", "off"]),
    needs: &["power"],
    read: read_power,
};

pub(super) const POWER_CUT: Verb = Verb {
    name: "power-cut",
    doc: "Switches the controller's supply off and on again.",
    value: KeyType::Table(CUT_KEYS),
    needs: &["power"],
    read: read_power_cut,
};

pub(super) const MARK: Verb = Verb {
    name: "mark",
    doc: "Does nothing: gives an instant a name.",
    value: KeyType::Table(&[]),
    needs: &[],
    read: |_, _, _| Some(Stimulus::Mark),
};

fn read_command(node: &Node, _: &Scope<'_>, _: &mut Findings) -> Option<Stimulus> {
    Some(Stimulus::Command(match node.as_text()? {
        "run" => Command::Run,
        "stop" => Command::Stop,
        "reset-warm" => Command::ResetWarm,
        _ => Command::ResetCold,
    }))
}

fn read_download(node: &Node, scope: &Scope<'_>, _: &mut Findings) -> Option<Stimulus> {
    let fields = scope.fields(node, DOWNLOAD_KEYS)?;
    let files: Vec<String> =
        fields.each("program").iter().filter_map(Node::as_text).map(str::to_owned).collect();
    Some(Stimulus::Download((!files.is_empty()).then_some(ProgramRef::Files(files))))
}

fn read_power(node: &Node, _: &Scope<'_>, _: &mut Findings) -> Option<Stimulus> {
    Some(Stimulus::Power(node.as_text()? == "on"))
}

fn read_power_cut(node: &Node, scope: &Scope<'_>, out: &mut Findings) -> Option<Stimulus> {
    Some(Stimulus::PowerCut(above_zero(&scope.fields(node, CUT_KEYS)?, "lasts", out)?))
}
