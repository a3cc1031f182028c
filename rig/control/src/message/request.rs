//! What clients ask for.

use crate::WireValue;
use serde::{Deserialize, Serialize};

/// A line of a client.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Request {
    /// The client's number for it: the answer has it again.
    pub id: u64,
    /// What is asked.
    #[serde(flatten)]
    pub ask: RequestOperation,
}

/// What is asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub enum RequestOperation {
    /// Says who asks, and which protocol it speaks. Nobody has to.
    Hello {
        /// The version that the client was made for.
        protocol: u32,
        /// What it is called in the rig's log, as in `rig dash`.
        name: String,
    },
    /// The rig's [`crate::Description`].
    Describe,
    /// A [`crate::Status`].
    Status,
    /// Values of signals now, answered in their order.
    Read {
        /// Their names.
        names: Vec<String>,
    },
    /// Writes a variable or a place in memory.
    Write {
        /// Its name or address.
        name: String,
        /// The value.
        value: WireValue,
    },
    /// Forces an embedded input or output.
    Force {
        /// Its address, as in `%QX0.3`, or its terminal, as in `Q3`.
        name: String,
        /// The value.
        value: WireValue,
    },
    /// Ends the forcing of one.
    Release {
        /// As above.
        name: String,
    },
    /// Ends all forcing.
    ReleaseAll,
    /// A command to the controller, or to the rig.
    Command {
        /// Which.
        action: ControllerAction,
    },
    /// Brings events of a topic from now on; answered with the subscription's number, and with the present values where
    /// the topic has some.
    Subscribe {
        /// What.
        topic: Topic,
    },
    /// Ends a subscription.
    Unsubscribe {
        /// Its number.
        subscription: u64,
    },
    /// What can be run on the board: the cases of a plan or of the plans of a folder; where none is named, the plans that
    /// ship, by their names alone.
    Plans {
        /// A file or folder as the rig sees it, or a plan or folder of those that ship.
        #[serde(default)]
        path: Option<String>,
    },
    /// Runs cases on the board in place of the controller, which is stopped with safe outputs before and started again
    /// after. Answered when it begins; its course is reported to those who subscribe to [`Topic::Plan`].
    Plan {
        /// The case, or the plan with all its cases, by its name as [`RequestOperation::Plans`] reports it.
        name: String,
    },
    /// Ends the plan that runs.
    Abort,
    /// Freezes what was commissioned: nothing can be written, forced, commanded or run until it is unlocked.
    Lock {
        /// A word on why; reported to whoever is refused.
        #[serde(default)]
        note: String,
    },
    /// Ends the lock.
    Unlock,
    /// Says goodbye, and what becomes of the forces: else `on-disconnect` of the board file says it.
    Leave {
        /// What becomes of them.
        forces: Forces,
    },
    /// Lets time pass, where clients step it; answered when it has.
    Advance {
        /// How much, nanoseconds.
        by: i64,
    },
}

/// What stands in a request of each kind beside `id` and `do`, kind by kind.
pub const REQUEST_FIELDS: &[(&str, &[&str])] = &[
    ("hello", &["protocol", "name"]),
    ("describe", &[]),
    ("status", &[]),
    ("read", &["names"]),
    ("write", &["name", "value"]),
    ("force", &["name", "value"]),
    ("release", &["name"]),
    ("release-all", &[]),
    ("command", &["action"]),
    ("subscribe", &["topic"]),
    ("unsubscribe", &["subscription"]),
    ("plans", &["path"]),
    ("plan", &["name"]),
    ("abort", &[]),
    ("lock", &["note"]),
    ("unlock", &[]),
    ("leave", &["forces"]),
    ("advance", &["by"]),
];

/// What stands in a topic of each kind beside `of`.
pub const TOPIC_FIELDS: &[(&str, &[&str])] = &[
    ("signals", &["names", "every_ms", "all"]),
    ("status", &["every_ms"]),
    ("log", &[]),
    ("frames", &[]),
    ("plan", &[]),
];

/// What becomes of forces when a client leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Forces {
    /// They stay.
    Keep,
    /// They end.
    Release,
}

/// A command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ControllerAction {
    /// Start the application.
    Run,
    /// Stop it.
    Stop,
    /// Reset warm.
    ResetWarm,
    /// Reset cold.
    ResetCold,
    /// Reset origin: the application is removed.
    ResetOrigin,
    /// Reboot.
    Reboot,
    /// Move the Run/Stop switch to Run.
    SwitchRun,
    /// Move it to Stop.
    SwitchStop,
    /// Switch the supply on.
    PowerOn,
    /// Switch it off.
    PowerOff,
}

impl ControllerAction {
    /// Every command.
    pub const ALL: [ControllerAction; 10] = [
        ControllerAction::Run,
        ControllerAction::Stop,
        ControllerAction::ResetWarm,
        ControllerAction::ResetCold,
        ControllerAction::ResetOrigin,
        ControllerAction::Reboot,
        ControllerAction::SwitchRun,
        ControllerAction::SwitchStop,
        ControllerAction::PowerOn,
        ControllerAction::PowerOff,
    ];

    /// Its name in a line and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            ControllerAction::Run => "run",
            ControllerAction::Stop => "stop",
            ControllerAction::ResetWarm => "reset-warm",
            ControllerAction::ResetCold => "reset-cold",
            ControllerAction::ResetOrigin => "reset-origin",
            ControllerAction::Reboot => "reboot",
            ControllerAction::SwitchRun => "switch-run",
            ControllerAction::SwitchStop => "switch-stop",
            ControllerAction::PowerOn => "power-on",
            ControllerAction::PowerOff => "power-off",
        }
    }
}

/// What a subscription brings.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "of", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Topic {
    /// Changes of signals.
    Signals {
        /// Their names.
        names: Vec<String>,
        /// At most one message in so many milliseconds.
        #[serde(default = "tenth")]
        every_ms: u32,
        /// Every change, as far as the client can follow; else only the last one of each signal before a message.
        #[serde(default)]
        all: bool,
    },
    /// The status, whenever it changes and at most once in so many milliseconds.
    Status {
        /// See above.
        #[serde(default = "tenth")]
        every_ms: u32,
    },
    /// The log.
    Log,
    /// Frames of the buses.
    Frames,
    /// Plans that run.
    Plan,
}

const fn tenth() -> u32 {
    100
}
