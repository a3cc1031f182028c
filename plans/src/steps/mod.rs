//! Steps: what a plan does, one entry of [`VERBS`] for each verb.
//!
//! A verb is a type of value (mostly a table of keys), the powers that it needs, and a reader that makes a
//! [`Stimulus`] of a value that was held against the type.

mod control;
mod drive;
mod fault;
mod load;
mod train;

use document::{Findings, KeyType, Node};
use signal::Span;

use crate::lang::Literal;
use crate::plan::{ProgramRef, Scope};

pub use train::{MAX_PULSES, Train};

/// A verb of `steps`: `{ id = "busy", at = "start + 1 s", overload = { ... } }`.
#[derive(Debug)]
pub struct Verb {
    /// The verb as written.
    pub name: &'static str,
    /// What it does, one sentence, for the schema and the manual.
    pub doc: &'static str,
    /// What its value is.
    pub value: KeyType,
    /// The powers that it needs of rig and subject, words of [`crate::lang::CAPABILITIES`].
    pub needs: &'static [&'static str],
    /// Makes the stimulus of a value that was held against `value`. `None` after it reported what is wrong.
    pub(crate) read: fn(&Node, &Scope<'_>, &mut Findings) -> Option<Stimulus>,
}

/// Every verb of `steps`, in alphabetical order.
pub static VERBS: &[Verb] = &[
    fault::CLEAR,
    control::COMMAND,
    control::DOWNLOAD,
    fault::FAULT,
    drive::FORCE,
    control::MARK,
    load::OVERLOAD,
    control::POWER,
    control::POWER_CUT,
    drive::PULSE,
    drive::RELEASE,
    drive::SET,
    train::TRAIN,
    drive::WRITE,
];

/// A command to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Run.
    Run,
    /// Stop.
    Stop,
    /// Reset warm.
    ResetWarm,
    /// Reset cold.
    ResetCold,
}

/// What a fault does to a line.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// It keeps this value.
    Stuck(Literal),
    /// It is cut.
    Open,
    /// It is at 0 V.
    ShortToGround,
    /// It is at the supply.
    ShortToSupply,
    /// It has this value for this time.
    Glitch {
        /// The value.
        value: Literal,
        /// The time, above 0.
        width: Span,
    },
    /// Every change comes this much later.
    Late(Span),
    /// Its device is gone.
    Lost,
}

/// What a step does.
#[derive(Clone, Debug, PartialEq)]
pub enum Stimulus {
    /// Drives lines, all at once.
    Set(Vec<(String, Literal)>),
    /// Drives a line, then drives it back to what it was.
    Pulse {
        /// The line.
        signal: String,
        /// What it is driven to.
        value: Literal,
        /// For how long, above 0.
        width: Span,
    },
    /// Forces an input or output of the controller.
    Force {
        /// The input or output.
        signal: String,
        /// The forced value.
        value: Literal,
    },
    /// Ends forcing.
    Release {
        /// The input or output.
        signal: String,
    },
    /// Writes a variable or a place of memory.
    Write {
        /// The variable or place.
        of: String,
        /// The value.
        value: Literal,
    },
    /// Commands the controller.
    Command(Command),
    /// Downloads an application; `None`: the case's own program again.
    Download(Option<ProgramRef>),
    /// Switches the supply off, and on again after this time, above 0.
    PowerCut(Span),
    /// Switches the supply on or off.
    Power(bool),
    /// The next cycles of a task take this long in all.
    Overload {
        /// Name of the task.
        task: String,
        /// Time of execution of one cycle.
        cycle: Span,
        /// How many cycles.
        times: u32,
    },
    /// Puts a fault on a line.
    Fault {
        /// The line.
        signal: String,
        /// The fault.
        kind: FaultKind,
        /// For how long; `None`: until it is cleared.
        lasts: Option<Span>,
    },
    /// Takes every fault off a line.
    Clear {
        /// The line.
        signal: String,
    },
    /// Emits a train of pulses.
    Train(Train),
    /// Nothing: marks an instant.
    Mark,
}

impl Stimulus {
    /// The powers that it needs of rig and subject.
    pub fn needs(&self) -> &'static [&'static str] {
        let name = match self {
            Stimulus::Set(_) => "set",
            Stimulus::Pulse { .. } => "pulse",
            Stimulus::Force { .. } => "force",
            Stimulus::Release { .. } => "release",
            Stimulus::Write { .. } => "write",
            Stimulus::Command(_) => "command",
            Stimulus::Download(_) => "download",
            Stimulus::PowerCut(_) => "power-cut",
            Stimulus::Power(_) => "power",
            Stimulus::Overload { .. } => "overload",
            Stimulus::Fault { .. } => "fault",
            Stimulus::Clear { .. } => "clear",
            Stimulus::Train(_) => "train",
            Stimulus::Mark => "mark",
        };
        VERBS.iter().find(|verb| verb.name == name).map_or(&[], |verb| verb.needs)
    }

    /// How long after its step it is done, 0 where it is done at once.
    pub fn duration(&self) -> Span {
        match self {
            Stimulus::Pulse { width, .. } | Stimulus::Fault { kind: FaultKind::Glitch { width, .. }, .. } => {
                *width
            }
            Stimulus::PowerCut(lasts) => *lasts,
            Stimulus::Fault { lasts: Some(lasts), .. } => *lasts,
            Stimulus::Train(train) => train.length(),
            _ => Span::ZERO,
        }
    }

    /// The signals that it drives, forces or writes.
    pub fn signals(&self) -> Vec<&str> {
        match self {
            Stimulus::Set(list) => list.iter().map(|(signal, _)| signal.as_str()).collect(),
            Stimulus::Pulse { signal, .. }
            | Stimulus::Force { signal, .. }
            | Stimulus::Release { signal }
            | Stimulus::Write { of: signal, .. }
            | Stimulus::Fault { signal, .. }
            | Stimulus::Clear { signal } => vec![signal],
            Stimulus::Train(train) => vec![&train.signal],
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::CAPABILITIES;

    #[test]
    fn verbs_are_in_order_and_need_known_powers() {
        assert!(VERBS.windows(2).all(|pair| pair[0].name < pair[1].name));
        for need in VERBS.iter().flat_map(|verb| verb.needs) {
            assert!(CAPABILITIES.iter().any(|one| one.word == *need), "{need}");
        }
    }
}
