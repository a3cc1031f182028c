//! `command`, `power`, `power-cut`, `switch` and `mark`.

use document::{Findings, KeySpec, KeyType, Node};

use super::drive::above_zero;
use super::{PlanCommand, StepVerb, Stimulus};
use super::{StepNames, table_fields};

const CUT_KEYS: &[KeySpec] =
    &[KeySpec::required("duration", KeyType::Duration, "How long the supply is off.").was("lasts")];

pub(super) const COMMAND: StepVerb = StepVerb {
    name: "command",
    doc: "Commands the controller.",
    value: KeyType::Choice(&[
        "run",
        "stop",
        "reset-warm",
        "reset-cold",
        "login",
        "logout",
        "logout-keep-forcing",
        "identify-on",
        "identify-off",
        "reset-origin",
        "reboot",
        "create-boot-application",
        "delete-application",
    ]),
    needs: &["commands"],
    read: read_command,
};

pub(super) const POWER: StepVerb = StepVerb {
    name: "power",
    doc: "Switches the controller's supply.",
    value: KeyType::Choice(&["on", "off"]),
    needs: &["power"],
    read: read_power,
};

pub(super) const POWER_CUT: StepVerb = StepVerb {
    name: "power-cut",
    doc: "Switches the controller's supply off and on again.",
    value: KeyType::Table(CUT_KEYS),
    needs: &["power"],
    read: read_power_cut,
};

pub(super) const SWITCH: StepVerb = StepVerb {
    name: "switch",
    doc: "Moves the Run/Stop switch.",
    value: KeyType::Choice(&["run", "stop"]),
    needs: &["run-stop"],
    read: |node, _, _| Some(Stimulus::Switch(node.as_text()? == "run")),
};

pub(super) const MARK: StepVerb = StepVerb {
    name: "mark",
    doc: "Does nothing: gives an instant a name.",
    value: KeyType::Table(&[]),
    needs: &[],
    read: |_, _, _| Some(Stimulus::Mark),
};

fn read_command(node: &Node, _: &dyn StepNames, _: &mut Findings) -> Option<Stimulus> {
    Some(Stimulus::Command(match node.as_text()? {
        "run" => PlanCommand::Run,
        "stop" => PlanCommand::Stop,
        "reset-warm" => PlanCommand::ResetWarm,
        "login" => PlanCommand::Login,
        "logout" => PlanCommand::Logout,
        "logout-keep-forcing" => PlanCommand::LogoutKeepForcing,
        "identify-on" => PlanCommand::IdentifyOn,
        "identify-off" => PlanCommand::IdentifyOff,
        "reset-origin" => PlanCommand::ResetOrigin,
        "reboot" => PlanCommand::Reboot,
        "create-boot-application" => PlanCommand::CreateBootApplication,
        "delete-application" => PlanCommand::DeleteApplication,
        _ => PlanCommand::ResetCold,
    }))
}

fn read_power(node: &Node, _: &dyn StepNames, _: &mut Findings) -> Option<Stimulus> {
    Some(Stimulus::Power(node.as_text()? == "on"))
}

fn read_power_cut(node: &Node, _: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    Some(Stimulus::PowerCut(above_zero(&table_fields(node, CUT_KEYS)?, "duration", out)?))
}
