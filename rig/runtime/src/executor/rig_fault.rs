//! Faults of the rig itself: the verdict is then `error`, whatever the controller did.

use crate::codes;
use crate::executor::operator::AskError;
use crate::subject::hook::HookError;
use controller::{CommandError, FileError, State, WriteError};
use drivers::{BoardError, BusKind, BusState, Channel, ChannelId, Health, LossReason, PlantFault};
use signal::{Span, Time, TraceError};
use std::fmt;

/// What went wrong in the rig, not in the controller.
#[derive(Clone, Debug, PartialEq)]
pub enum RigFault {
    /// A call of the board failed.
    Board {
        /// When.
        at: Time,
        /// Why.
        error: BoardError,
    },
    /// A plant of the board came to its end.
    Plant(PlantFault),
    /// The board was not sound at the end of the case.
    Unsound {
        /// When.
        at: Time,
        /// What it says.
        health: Health,
    },
    /// A device went away.
    Lost {
        /// When.
        at: Time,
        /// The first of its channels that reported it.
        channel: ChannelId,
        /// The device in words; empty where the board has none.
        device: String,
        /// Why.
        reason: LossReason,
    },
    /// Events were lost.
    Dropped {
        /// When.
        at: Time,
        /// The channel.
        channel: ChannelId,
        /// How many, at least.
        count: u32,
    },
    /// The device of a bus went away.
    BusLost {
        /// When.
        at: Time,
        /// The bus.
        bus: String,
        /// The device in words; empty where the board has none.
        device: String,
        /// Why.
        reason: LossReason,
    },
    /// A controller takes no part in its bus any more.
    BusOff {
        /// When.
        at: Time,
        /// The bus.
        bus: String,
        /// The device in words; empty where the board has none.
        device: String,
    },
    /// A device was lost before the case, and could not be taken back.
    StillLost {
        /// The channel or the bus, as in `channel I0`.
        what: String,
        /// The device in words; empty where the board has none.
        device: String,
        /// Why.
        reason: LossReason,
        /// For how long.
        since: Span,
        /// It is looked for.
        reconnect: bool,
    },
    /// What was sent did not come to its bus.
    NotOnBus {
        /// When that was noticed.
        at: Time,
        /// The bus.
        bus: String,
        /// What kind of bus it is.
        kind: BusKind,
        /// The device in words; empty where the board has none.
        device: String,
        /// How its controller takes part.
        state: BusState,
    },
    /// Frames or messages of a bus were lost.
    BusDropped {
        /// When.
        at: Time,
        /// The bus.
        bus: String,
        /// What kind of bus it is.
        kind: BusKind,
        /// How many, at least.
        count: u32,
    },
    /// A step could not send.
    NotSent {
        /// When.
        at: Time,
        /// The step.
        step: String,
        /// The bus.
        bus: String,
        /// Why.
        error: BoardError,
    },
    /// An endpoint of the controller could not send.
    PortNotSent {
        /// When.
        at: Time,
        /// The bus of its port.
        bus: String,
        /// Why.
        error: BoardError,
    },
    /// The outputs are not guarded any more.
    Guard {
        /// When it was noticed.
        at: Time,
        /// What the guard says.
        why: String,
    },
    /// The rig missed a deadline of its own.
    Late {
        /// The deadline.
        at: Time,
        /// How late it was.
        late: Span,
        /// How late it may be.
        limit: Span,
    },
    /// The program restarted the period of a square wave that a device makes.
    PeriodNotRestarted {
        /// When.
        at: Time,
        /// The channel.
        channel: ChannelId,
    },
    /// The subject did not come into the state in which the case begins.
    Startup {
        /// The state it was in.
        state: State,
        /// Why, where it said so.
        refusal: Option<CommandError>,
    },
    /// The case lasted longer than its plan allows.
    Timeout {
        /// Most modelled time that it may take.
        limit: Span,
    },
    /// Nothing will ever happen again, and the end is not known.
    Stuck {
        /// Since when.
        at: Time,
    },
    /// Events without end at one instant.
    Simultaneous {
        /// When.
        at: Time,
    },
    /// A command of a step was refused.
    Refused {
        /// The step.
        step: String,
        /// Why.
        refusal: CommandError,
    },
    /// A step could not write.
    NotWritten {
        /// The step.
        step: String,
        /// Why.
        error: WriteError,
    },
    /// A step could not reach a file.
    File {
        /// The step.
        step: String,
        /// Why.
        error: FileError,
    },
    /// The trace could not be written.
    Trace(TraceError),
    /// A step asked and got no answer.
    Unanswered {
        /// The step.
        step: String,
        /// Why.
        error: AskError,
    },
    /// A command that brings the program into the subject, or takes it away, did not end well.
    Hook(HookError),
    /// The user stopped the run.
    Interrupted,
}

impl RigFault {
    /// The fault in words, with the names of the board's channels.
    pub fn show<'a>(&'a self, channels: &'a [Channel]) -> RigFaultText<'a> {
        RigFaultText { fault: self, channels }
    }
}

/// A fault in words.
#[derive(Clone, Copy, Debug)]
pub struct RigFaultText<'a> {
    fault: &'a RigFault,
    channels: &'a [Channel],
}

impl RigFaultText<'_> {
    /// The name of a channel, or its number where the board has no such channel.
    fn name(&self, channel: ChannelId) -> String {
        let known = self.channels.get(usize::from(channel.0));
        known.map_or_else(|| channel.0.to_string(), |known| known.name.clone())
    }

    /// An error of the board: those that concern a channel name it.
    fn board(&self, f: &mut fmt::Formatter<'_>, error: &BoardError) -> fmt::Result {
        match *error {
            BoardError::NotDriven(channel) => write!(f, "the board cannot drive {}", self.name(channel)),
            BoardError::BadValue(channel) => write!(f, "the value does not fit {}", self.name(channel)),
            BoardError::NotEmitted(channel, why) => {
                write!(f, "{} cannot emit what was asked: {why}", self.name(channel))
            }
            BoardError::NoSuchFault(channel) => {
                write!(f, "this fault cannot be injected on {}", self.name(channel))
            }
            BoardError::BadFaultTime(channel) => {
                write!(f, "the times of a fault on {} must be above 0", self.name(channel))
            }
            BoardError::FaultsApart { channel, other } => {
                let (channel, other) = (self.name(channel), self.name(other));
                write!(f, "channel {channel} takes no fault while one is on channel {other}")
            }
            BoardError::TooManyFaults { channel, limit } => {
                write!(f, "{} has {limit} faults already: clear it first", self.name(channel))
            }
            _ => write!(f, "{error}"),
        }
    }
}

/// What became of a device, in words.
fn lost(f: &mut fmt::Formatter<'_>, device: &str, reason: LossReason) -> fmt::Result {
    match device {
        "" => write!(f, "its device {reason}"),
        device => write!(f, "its device, {device}, {reason}"),
    }
}

impl fmt::Display for RigFaultText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.fault {
            RigFault::Board { at, error } => {
                write!(f, "at {at}: ")?;
                self.board(f, error)
            }
            RigFault::Plant(PlantFault { plant, at, why }) => {
                write!(f, "the plant `{plant}` failed at {at}: {why} ({})", codes::PLANT_FAILED)
            }
            RigFault::Unsound { at, health } => write!(
                f,
                "at {at} the board had lost {} channels and {} events, and {} calls had failed",
                health.lost, health.dropped, health.failed_calls
            ),
            RigFault::Lost { at, channel, device, reason } => {
                write!(f, "channel {} was lost at {at}: ", self.name(*channel))?;
                lost(f, device, *reason)
            }
            RigFault::BusLost { at, bus, device, reason } => {
                write!(f, "bus {bus} was lost at {at}: ")?;
                lost(f, device, *reason)
            }
            RigFault::BusOff { at, bus, device } => {
                let words = "went off the bus: it had counted 256 errors of sending";
                match device.as_str() {
                    "" => write!(f, "bus {bus} was lost at {at}: its controller {words}"),
                    device => write!(f, "bus {bus} was lost at {at}: its controller, {device}, {words}"),
                }
            }
            RigFault::StillLost { what, device, reason, since, reconnect } => {
                write!(f, "{what} is lost for {since}: ")?;
                lost(f, device, *reason)?;
                f.write_str(match (reason, reconnect) {
                    (LossReason::Gone, false) => {
                        "; `reconnect = true` below [board] takes back a device that is there again"
                    }
                    (LossReason::Gone, true) => {
                        "; it was looked for, and is not there as the board file has it"
                    }
                    // It is there, and nobody has to take it back.
                    _ => "",
                })
            }
            RigFault::NotOnBus { at, bus, kind: BusKind::Serial { .. }, device, .. } => {
                write!(f, "what was to be sent on serial line {bus} had not left by {at}: its port")?;
                if !device.is_empty() {
                    write!(f, ", {device},")?;
                }
                f.write_str(" refuses it or stands still")
            }
            RigFault::NotOnBus { at, bus, kind: BusKind::Can { .. }, device, state } => {
                write!(f, "a frame that was sent on bus {bus} was not on it by {at}: its controller")?;
                if !device.is_empty() {
                    write!(f, ", {device},")?;
                }
                f.write_str(match state {
                    BusState::ErrorActive => " waits for the bus",
                    _ => " counts errors of sending: nobody acknowledges, or another bit rate is on the bus",
                })
            }
            RigFault::NotSent { at, step, bus, error } => {
                write!(f, "step `{step}` could not send on bus {bus} at {at}: ")?;
                not_sent(error, f)
            }
            RigFault::PortNotSent { at, bus, error } => {
                write!(f, "the controller could not send on bus {bus} at {at}: ")?;
                not_sent(error, f)
            }
            RigFault::BusDropped { at, bus, kind: BusKind::Can { .. }, count } => {
                write!(f, "at least {count} frames of bus {bus} were lost by {at}")
            }
            RigFault::BusDropped { at, bus, kind: BusKind::Serial { .. }, count } => {
                write!(f, "at least {count} messages of serial line {bus} were lost by {at}")
            }
            RigFault::Dropped { at, channel, count } => {
                write!(f, "at least {count} events of channel {} were lost by {at}", self.name(*channel))
            }
            RigFault::Guard { at, why } => write!(f, "at {at}: {why}"),
            RigFault::Late { at, late, limit } => {
                write!(f, "the rig was {late} late at {at}, where {limit} is the limit")
            }
            RigFault::PeriodNotRestarted { at, channel } => {
                let name = self.name(*channel);
                write!(
                    f,
                    "at {at} the program restarted the period of {name}, which the device that makes its pulses cannot: \
                     leave out `Sync`, or take a line that the rig drives"
                )
            }
            RigFault::Startup { state, refusal: Some(refusal) } => {
                write!(
                    f,
                    "the controller did not reach the state in which the case begins: it was {state}: {refusal}"
                )
            }
            RigFault::Startup { state, refusal: None } => {
                write!(
                    f,
                    "the controller did not reach the state in which the case begins: it stayed {state}"
                )
            }
            RigFault::Timeout { limit } => write!(f, "the case had not ended after its `timeout` of {limit}"),
            RigFault::Stuck { at } => {
                write!(f, "nothing happens any more since {at}, and the case has no end")
            }
            RigFault::Simultaneous { at } => {
                write!(f, "events without end at {at}: wires or steps that chase each other")
            }
            RigFault::Refused { step, refusal } => {
                write!(
                    f,
                    "the command of step `{step}` was refused: {refusal}; `refused = true` expects that"
                )
            }
            RigFault::NotWritten { step, error } => write!(f, "step `{step}` could not write: {error}"),
            RigFault::File { step, error } => {
                write!(f, "step `{step}` could not reach its file: {error}; `refused = true` expects that")
            }
            RigFault::Trace(error) => write!(f, "the trace could not be written: {error}"),
            RigFault::Unanswered { step, error } => {
                write!(f, "step `{step}` asked and got no answer: {error}")
            }
            RigFault::Hook(error) => write!(f, "{error}"),
            RigFault::Interrupted => f.write_str("interrupted"),
        }
    }
}

/// Why a bus did not take what it was given.
fn not_sent(error: &BoardError, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match error {
        BoardError::BusFull(_) => f.write_str("its queue is full"),
        BoardError::BadFrame(_) => f.write_str("the frame does not fit"),
        error => write!(f, "{error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A serial line carries messages, and no frames.
    #[test]
    fn a_fault_of_a_bus_says_what_the_bus_carries() {
        let (at, bus) = (Time::from_nanos(1_000_000_000), String::from("b"));
        let said = |kind| {
            let device = String::from("/dev/x");
            let state = BusState::ErrorActive;
            let lost = RigFault::BusDropped { at, bus: bus.clone(), kind, count: 2 };
            let kept = RigFault::NotOnBus { at, bus: bus.clone(), kind, device, state };
            [lost, kept].map(|fault| fault.show(&[]).to_string())
        };
        assert_eq!(
            said(BusKind::Serial { settings: signal::SerialSettings::default() }),
            [
                "at least 2 messages of serial line b were lost by 1.000000000 s",
                "what was to be sent on serial line b had not left by 1.000000000 s: its port, /dev/x, refuses it or stands still",
            ]
        );
        assert_eq!(
            said(BusKind::Can { bitrate: 250_000, data_bitrate: None }),
            [
                "at least 2 frames of bus b were lost by 1.000000000 s",
                "a frame that was sent on bus b was not on it by 1.000000000 s: its controller, /dev/x, waits for the bus",
            ]
        );
    }

    /// It names `reconnect` where that would have helped, and only there.
    #[test]
    fn a_device_that_is_still_lost_is_told_with_what_mends_it() {
        let said = |reason, reconnect| {
            let (what, device, since) = (String::from("bus b"), String::from("can0"), Span::from_secs(3));
            RigFault::StillLost { what, device, reason, since, reconnect }.show(&[]).to_string()
        };
        assert!(said(LossReason::Gone, false).ends_with(
            "can0, is gone; `reconnect = true` below [board] takes back a device that is there again"
        ));
        assert!(
            said(LossReason::Gone, true)
                .ends_with("can0, is gone; it was looked for, and is not there as the board file has it")
        );
        for reconnect in [false, true] {
            assert_eq!(
                said(LossReason::Unresponsive, reconnect),
                "bus b is lost for 3 s: its device, can0, does not answer"
            );
        }
    }
}
