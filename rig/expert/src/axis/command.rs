//! Commands to an axis, and what became of them.

use super::fault::AxisFault;
use super::homing::HomingMethod;
use super::profile::Ramps;
use signal::Span;

/// When a command begins (io:STD-PTO-05). The numbers of PLCopen; those from 10 on are the controller's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BufferMode {
    /// At once.
    Aborting,
    /// When the current one is done.
    Buffered,
    /// When the current one is done, with the lower velocity of both.
    BlendingLow,
    /// When the current one is done, with its velocity.
    BlendingPrevious,
    /// When the current one is done, with its own velocity.
    BlendingNext,
    /// When the current one is done, with the higher velocity of both.
    BlendingHigh,
    /// With the next event of the PROBE input.
    Trigger,
    /// When the current one has been done for a time.
    BufferedDelay,
}

impl BufferMode {
    /// The mode with a number.
    pub fn of(number: i64) -> Option<BufferMode> {
        Some(match number {
            0 => BufferMode::Aborting,
            1 => BufferMode::Buffered,
            2 => BufferMode::BlendingLow,
            3 => BufferMode::BlendingPrevious,
            4 => BufferMode::BlendingNext,
            5 => BufferMode::BlendingHigh,
            10 => BufferMode::Trigger,
            11 => BufferMode::BufferedDelay,
            _ => return None,
        })
    }

    /// The velocity at the end of a command with velocity `first` where one with velocity `second` follows in this mode;
    /// 0 where it comes to rest.
    pub fn blend(self, first: i64, second: i64) -> i64 {
        match self {
            BufferMode::BlendingLow => first.min(second),
            BufferMode::BlendingPrevious => first,
            BufferMode::BlendingNext => second,
            BufferMode::BlendingHigh => first.max(second),
            _ => 0,
        }
    }
}

/// What an axis is commanded to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionCommand {
    /// To a position.
    To(i64),
    /// So many pulses on, negative backwards.
    By(i64),
    /// With a velocity in a direction; None for the current one.
    Velocity(Option<bool>),
    /// To rest.
    Halt,
    /// To rest, and nothing else before it is released.
    Stop,
    /// To a known position.
    Home(HomingMethod),
}

/// A command.
#[derive(Clone, Copy, Debug)]
pub struct AxisCommand {
    pub order: MotionCommand,
    /// In units of velocity.
    pub velocity: i64,
    pub ramps: Ramps,
    pub mode: BufferMode,
    /// Of [`BufferMode::BufferedDelay`].
    pub delay: Span,
}

/// How far a command is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandPhase {
    /// Waits for another one, a time or an event.
    Waiting,
    /// Controls the axis.
    Active,
    /// Controls the axis, which has its velocity.
    InVelocity,
    /// Has done what it should.
    Done,
    /// Another command took its place.
    Aborted,
    /// The axis had to end it.
    Failed(AxisFault),
}

/// A command that an axis took, known by a number that is not 0.
#[derive(Clone, Copy, Debug)]
pub struct QueuedCommand {
    pub ticket: u32,
    pub command: AxisCommand,
}

/// Ends of commands that are remembered until their blocks ask.
const REMEMBERED: usize = 64;

/// How the last commands ended. A block that asks for one that more than that many others have ended after gets Aborted.
#[derive(Clone, Debug)]
pub struct CommandResults {
    list: [(u32, CommandPhase); REMEMBERED],
}

impl CommandResults {
    pub const fn new() -> CommandResults {
        CommandResults { list: [(0, CommandPhase::Aborted); REMEMBERED] }
    }

    pub fn set(&mut self, ticket: u32, phase: CommandPhase) {
        self.list[ticket as usize % REMEMBERED] = (ticket, phase);
    }

    pub fn get(&self, ticket: u32) -> CommandPhase {
        let (last, phase) = self.list[ticket as usize % REMEMBERED];
        if last == ticket { phase } else { CommandPhase::Aborted }
    }
}
