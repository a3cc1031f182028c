//! The commands that can be given from every view.

use crate::model::Model;
use crate::show;
use control::{Action, Operation};

/// What an entry of the menu does.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum MenuAction {
    /// Asks the rig, once the user has said yes: it moves outputs.
    Confirmed(Operation),
    /// Asks the rig.
    Immediate(Operation),
    /// Lets the user say why, and locks.
    Lock,
}

/// The entries: what they are called, and what they do.
pub(super) fn entries(model: &Model) -> Vec<(&'static str, MenuAction)> {
    let mut entries: Vec<(&'static str, MenuAction)> = Action::ALL
        .iter()
        .map(|action| (label(*action), MenuAction::Confirmed(Operation::Command { action: *action })))
        .collect();
    entries.push(("Release all forces", MenuAction::Confirmed(Operation::ReleaseAll)));
    if model.status.plan.is_some() {
        entries.push(("Abort the plan", MenuAction::Confirmed(Operation::Abort)));
    }
    if model.status.locked.is_some() {
        entries.push(("Unlock", MenuAction::Immediate(Operation::Unlock)));
    } else {
        entries.push(("Lock", MenuAction::Lock));
    }
    entries
}

const fn label(action: Action) -> &'static str {
    match action {
        Action::Run => "Run",
        Action::Stop => "Stop",
        Action::ResetWarm => "Reset warm",
        Action::ResetCold => "Reset cold",
        Action::ResetOrigin => "Reset origin",
        Action::Reboot => "Reboot",
        Action::SwitchRun => "Run/Stop switch to Run",
        Action::SwitchStop => "Run/Stop switch to Stop",
        Action::PowerOn => "Supply on",
        Action::PowerOff => "Supply off",
    }
}

/// What the user is asked before.
pub(super) fn question(ask: &Operation, model: &Model) -> String {
    let what = match ask {
        Operation::Command { action } => match action {
            Action::Run => "Start the application? Outputs follow the program.",
            Action::Stop => "Stop the application? Outputs go to their fallback values.",
            Action::ResetWarm => "Reset warm? The application stops; retained values stay.",
            Action::ResetCold => {
                "Reset cold? The application stops; retained values go, persistent ones stay."
            }
            Action::ResetOrigin => "Reset origin? The application is removed from the controller.",
            Action::Reboot => "Reboot the controller? Outputs go off until it has booted.",
            Action::SwitchRun => "Move the Run/Stop switch to Run? The application may start.",
            Action::SwitchStop => "Move the Run/Stop switch to Stop? The application stops.",
            Action::PowerOn => "Switch the supply on? The controller boots and may start its application.",
            Action::PowerOff => "Switch the supply off? Outputs go off.",
        },
        Operation::ReleaseAll => {
            return match model.status.forced.len() {
                0 => "Nothing is forced. Release all anyway?".to_owned(),
                1 => "Release what is forced? It follows the program or its line again.".to_owned(),
                count => format!("Release all {count} forces? They follow the program or their lines again."),
            };
        }
        Operation::Abort => "Abort the plan? Outputs go to their safe values, then the controller restarts.",
        _ => "Do it?",
    };
    what.to_owned()
}

/// What is said when it is done.
pub(super) fn done(ask: &Operation) -> String {
    match ask {
        Operation::Write { name, value } => format!("{name} := {}", show::value(*value, &[])),
        Operation::Force { name, value } => format!("{name} is forced to {}", show::value(*value, &[])),
        Operation::Release { name } => format!("{name} is released"),
        Operation::ReleaseAll => "all forces are released".to_owned(),
        Operation::Command { action } => format!("{}: done", label(*action)),
        Operation::Plan { name } => format!("{name} begins"),
        Operation::Abort => "the plan is aborted".to_owned(),
        Operation::Lock { .. } => "locked".to_owned(),
        Operation::Unlock => "unlocked".to_owned(),
        _ => "done".to_owned(),
    }
}
