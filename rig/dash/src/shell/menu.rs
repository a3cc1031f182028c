//! The commands that can be given from every view.

use crate::model::RigModel;
use crate::show;
use control::{ControllerAction, RequestOperation};

/// What an entry of the menu does.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum MenuAction {
    /// Asks the rig, once the user has said yes: it moves outputs.
    Confirmed(RequestOperation),
    /// Asks the rig.
    Immediate(RequestOperation),
    /// Lets the user say why, and locks.
    Lock,
}

/// The entries: what they are called, and what they do.
pub(super) fn entries(model: &RigModel) -> Vec<(&'static str, MenuAction)> {
    let mut entries: Vec<(&'static str, MenuAction)> = ControllerAction::ALL
        .iter()
        .map(|action| (label(*action), MenuAction::Confirmed(RequestOperation::Command { action: *action })))
        .collect();
    entries.push(("Release all forces", MenuAction::Confirmed(RequestOperation::ReleaseAll)));
    if model.status.plan.is_some() {
        entries.push(("Abort the plan", MenuAction::Confirmed(RequestOperation::Abort)));
    }
    if model.status.locked.is_some() {
        entries.push(("Unlock", MenuAction::Immediate(RequestOperation::Unlock)));
    } else {
        entries.push(("Lock", MenuAction::Lock));
    }
    entries
}

const fn label(action: ControllerAction) -> &'static str {
    match action {
        ControllerAction::Run => "Run",
        ControllerAction::Stop => "Stop",
        ControllerAction::ResetWarm => "Reset warm",
        ControllerAction::ResetCold => "Reset cold",
        ControllerAction::ResetOrigin => "Reset origin",
        ControllerAction::Reboot => "Reboot",
        ControllerAction::SwitchRun => "Run/Stop switch to Run",
        ControllerAction::SwitchStop => "Run/Stop switch to Stop",
        ControllerAction::PowerOn => "Supply on",
        ControllerAction::PowerOff => "Supply off",
    }
}

/// What the user is asked before.
pub(super) fn question(ask: &RequestOperation, model: &RigModel) -> String {
    let what = match ask {
        RequestOperation::Command { action } => match action {
            ControllerAction::Run => "Start the application? Outputs follow the program.",
            ControllerAction::Stop => "Stop the application? Outputs go to their fallback values.",
            ControllerAction::ResetWarm => "Reset warm? The application stops; retained values stay.",
            ControllerAction::ResetCold => {
                "Reset cold? The application stops; retained values go, persistent ones stay."
            }
            ControllerAction::ResetOrigin => "Reset origin? The application is removed from the controller.",
            ControllerAction::Reboot => "Reboot the controller? Outputs go off until it has booted.",
            ControllerAction::SwitchRun => "Move the Run/Stop switch to Run? The application may start.",
            ControllerAction::SwitchStop => "Move the Run/Stop switch to Stop? The application stops.",
            ControllerAction::PowerOn => {
                "Switch the supply on? The controller boots and may start its application."
            }
            ControllerAction::PowerOff => "Switch the supply off? Outputs go off.",
        },
        RequestOperation::ReleaseAll => {
            return match model.status.forced.len() {
                0 => "Nothing is forced. Release all anyway?".to_owned(),
                1 => "Release what is forced? It follows the program or its line again.".to_owned(),
                count => format!("Release all {count} forces? They follow the program or their lines again."),
            };
        }
        RequestOperation::Abort => {
            "Abort the plan? Outputs go to their safe values, then the controller restarts."
        }
        _ => "Do it?",
    };
    what.to_owned()
}

/// What is said when it is done.
pub(super) fn done(ask: &RequestOperation) -> String {
    match ask {
        RequestOperation::Write { name, value } => format!("{name} := {}", show::value(*value, &[])),
        RequestOperation::Force { name, value } => {
            format!("{name} is forced to {}", show::value(*value, &[]))
        }
        RequestOperation::Release { name } => format!("{name} is released"),
        RequestOperation::ReleaseAll => "all forces are released".to_owned(),
        RequestOperation::Command { action } => format!("{}: done", label(*action)),
        RequestOperation::Plan { name } => format!("{name} begins"),
        RequestOperation::Abort => "the plan is aborted".to_owned(),
        RequestOperation::Lock { .. } => "locked".to_owned(),
        RequestOperation::Unlock => "unlocked".to_owned(),
        _ => "done".to_owned(),
    }
}
