//! The rig as an instrument: what it knows of a loop from one of its outputs to one of its inputs, of which it makes
//! every edge itself.
//!
//! Goals: an instrument that is not what it should be is found out before it judges anything; figures that follow from
//! the calls that a run makes. Not goals: what a plan claims.

mod counts;
pub mod figures;
mod loopback;
mod scan;
mod square;
pub mod standalone;

pub use counts::{Counts, Train, counts, is_countable};
pub use loopback::{Loopback, loopback};
pub use scan::{Phases, ScanFault, phases};
pub use square::{EDGES, PERIOD, Square, square};

use crate::codes;
use crate::executor::heartbeat::Heartbeat;
use document::Diagnostic;
use drivers::{Board, BoardContext, BoardError, BoardEvent, ChannelId, LoopbackPair, LossReason, Origin};
use guard::GuardError;
use signal::{Span, Time, Value, When};
use std::fmt;

/// How long an edge may take from the output to the input before there is no wire.
const PATIENCE: Span = Span::from_secs(1);

/// The longest that a wait lasts at a stretch, so that an interrupt is seen.
const LONGEST_WAIT: Span = Span::from_millis(50);

/// Names of a loop's channels, as messages have them.
pub fn names(board: &dyn Board, looped: LoopbackPair) -> [String; 2] {
    let name = |channel: ChannelId| {
        board.channels().get(usize::from(channel.0)).map_or_else(String::new, |known| known.name.clone())
    };
    [name(looped.out), name(looped.input)]
}

/// A board that is measured, or measures itself.
pub struct Instrument<'a> {
    /// The board.
    pub board: &'a mut dyn Board,
    /// What it lives in.
    pub lives: &'a BoardContext,
    /// Whoever makes the outputs safe when this ends badly.
    pub heartbeat: Option<&'a dyn Heartbeat>,
}

impl fmt::Debug for Instrument<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Instrument").field("heartbeat", &self.heartbeat).finish_non_exhaustive()
    }
}

/// Nothing stays driven after a measurement, whatever ended it.
impl Drop for Instrument<'_> {
    fn drop(&mut self) {
        // What is not safe now is the guard's.
        let safe = self.board.safe(self.lives.time.now());
        if let (Ok(()), Some(heartbeat)) = (safe, self.heartbeat) {
            let _ = heartbeat.end();
        }
    }
}

impl Instrument<'_> {
    /// Starts the board; from now on somebody watches.
    fn start(&mut self) -> Result<(), LoopFault> {
        self.board.start(self.lives.time.now())?;
        self.heartbeat.map_or(Ok(()), Heartbeat::begin)?;
        Ok(())
    }

    /// A sign of life.
    fn beat(&self) -> Result<(), LoopFault> {
        Ok(self.heartbeat.map_or(Ok(()), Heartbeat::beat)?)
    }

    /// Waits until the board has something to report, at most until then, and never so long that nobody would notice.
    fn wait(&self, until: Time) {
        let next = self.board.next_event().unwrap_or(Time::MAX);
        let every = self.heartbeat.map_or(LONGEST_WAIT, Heartbeat::every).min(LONGEST_WAIT);
        let until = until.min(next).min(self.lives.time.now() + every);
        self.lives.bell.wait_until(self.lives.time.stamp(until));
    }
}

/// Why a loop is none, or the board no instrument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LoopFault {
    /// A call of the board failed.
    Board(BoardError),
    /// A device went away.
    Lost(LossReason),
    /// Edges were lost.
    Dropped(u32),
    /// The input never followed.
    Silent {
        /// The edge that it missed, from 1.
        edge: u64,
        /// What the output was driven to.
        high: bool,
    },
    /// The input changed when nobody changed the output.
    Stray {
        /// The edge after which it did, from 1.
        edge: u64,
    },
    /// The input's edge is stamped before the output was driven: the two clocks differ.
    Early {
        /// The edge, from 1.
        edge: u64,
        /// By so much.
        by: Span,
    },
    /// Nobody watches over the outputs any more; why, and what can be done.
    Unguarded([String; 2]),
    /// Somebody wants it to end.
    Interrupted,
}

impl LoopFault {
    /// In words, for a loop of these names.
    pub fn words(&self, names: &[String; 2]) -> String {
        let [out, input] = names;
        match *self {
            LoopFault::Board(error) => error.to_string(),
            LoopFault::Lost(LossReason::Gone) => String::from("the device is gone"),
            LoopFault::Lost(_) => String::from("the device does not answer any more"),
            LoopFault::Dropped(count) => format!("{count} edges of `{input}` were lost on the way"),
            LoopFault::Silent { edge, high } => format!(
                "`{input}` did not follow edge {edge} of `{out}`, to {}, within {PATIENCE}",
                u8::from(high)
            ),
            LoopFault::Stray { edge } => {
                format!("`{input}` changed after edge {edge} of `{out}`, though nobody drove it")
            }
            LoopFault::Early { edge, by } => {
                format!("`{input}` is stamped {by} before `{out}` was driven, at edge {edge}")
            }
            LoopFault::Unguarded([ref why, _]) => why.clone(),
            LoopFault::Interrupted => String::from("interrupted"),
        }
    }

    /// What to do about it.
    pub fn fix(&self) -> &str {
        match self {
            LoopFault::Board(_) | LoopFault::Lost(_) => "see that the device is there: `rig board check`",
            LoopFault::Dropped(_) => "the machine is too busy to take edges: `rig doctor` says what helps",
            LoopFault::Silent { .. } => {
                "see that the wire is there, and that the board file names its two ends"
            }
            LoopFault::Stray { .. } => "see that nobody else drives the wire, and that it picks up no noise",
            LoopFault::Early { .. } => {
                "the kernel's stamps are of another clock than the rig's: say so to its makers"
            }
            LoopFault::Unguarded([_, fix]) => fix,
            LoopFault::Interrupted => "",
        }
    }
}

impl LoopFault {
    /// As a finding of a run that it ends, for a loop of these names.
    pub fn finding(&self, names: &[String; 2]) -> Diagnostic {
        Diagnostic::error(codes::NOT_AN_INSTRUMENT, self.words(names)).help(self.fix())
    }
}

impl From<GuardError> for LoopFault {
    fn from(error: GuardError) -> Self {
        LoopFault::Unguarded([error.to_string(), error.help()])
    }
}

impl From<BoardError> for LoopFault {
    fn from(error: BoardError) -> Self {
        LoopFault::Board(error)
    }
}

/// One edge that went around the loop.
#[derive(Clone, Copy, Debug)]
struct Round {
    /// When the board was asked.
    asked: Time,
    /// When the device's call began and ended, where the board reports.
    call: Option<When>,
    /// The stamp of the input's edge.
    stamped: Time,
    /// When it was known here.
    seen: Time,
}

/// A board whose loop is driven and watched.
#[derive(Debug)]
struct Driven<'a> {
    on: Instrument<'a>,
    looped: LoopbackPair,
    events: Vec<BoardEvent>,
    /// Whether the input has the level of the output; found out by the first edge.
    follows: Option<bool>,
    edges: u64,
    level: bool,
}

impl<'a> Driven<'a> {
    /// Starts the board, drives the output low and lets the input follow.
    fn start(mut on: Instrument<'a>, looped: LoopbackPair) -> Result<Driven<'a>, LoopFault> {
        on.start()?;
        let mut driven =
            Driven { on, looped, events: Vec::with_capacity(256), follows: None, edges: 0, level: false };
        let began = driven.now();
        driven.on.board.write(began, &[(looped.out, Value::Bool(false))])?;
        // What was before the first edge is of no interest, but for losses.
        while driven.now() < began + SETTLE {
            driven.poll()?;
            driven.on.wait(began + SETTLE);
        }
        driven.poll()?;
        Ok(driven)
    }

    fn now(&self) -> Time {
        self.on.lives.time.now()
    }

    fn poll(&mut self) -> Result<(), LoopFault> {
        self.on.beat()?;
        self.events.clear();
        self.on.board.poll(self.on.lives.time.now(), &mut self.events)?;
        for event in &self.events {
            match *event {
                BoardEvent::Dropped { count, .. } => return Err(LoopFault::Dropped(count)),
                BoardEvent::Lost { reason, .. } if reason != LossReason::Injected => {
                    return Err(LoopFault::Lost(reason));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Turns the output, and waits for the input to follow.
    fn edge(&mut self) -> Result<Round, LoopFault> {
        self.edges += 1;
        self.level = !self.level;
        let (edge, high) = (self.edges, self.level);
        let asked = self.now();
        self.on.board.write(asked, &[(self.looped.out, Value::Bool(high))])?;
        let due = asked + PATIENCE;
        let (mut call, mut answer) = (None, None);
        // A board that reads the output back reports one line only.
        let one = self.looped.out == self.looped.input;
        loop {
            self.poll()?;
            let seen = self.now();
            for event in &self.events {
                let BoardEvent::Changed { channel, at, value: Value::Bool(level), origin } = *event else {
                    continue;
                };
                if channel == self.looped.out && !one && origin == Origin::Write {
                    call = Some(at);
                } else if channel == self.looped.input {
                    let follows = *self.follows.get_or_insert(level == high);
                    if answer.is_some() || (level == high) != follows {
                        return Err(LoopFault::Stray { edge });
                    }
                    answer = Some((at, seen));
                }
            }
            if let Some((at, seen)) = answer.filter(|_| one || call.is_some()) {
                let began = call.map_or(asked, |call| call.earliest);
                if at.latest < began {
                    return Err(LoopFault::Early { edge, by: began - at.latest });
                }
                return Ok(Round { asked, call, stamped: at.latest, seen });
            }
            if seen >= due {
                return Err(LoopFault::Silent { edge, high });
            }
            self.on.wait(due);
        }
    }

    /// Lets time pass up to an instant: whatever the input does meanwhile is not ours.
    fn quiet(&mut self, until: Time) -> Result<(), LoopFault> {
        loop {
            self.poll()?;
            let stray = self.events.iter().any(
                |event| matches!(event, BoardEvent::Changed { channel, .. } if *channel == self.looped.input),
            );
            if stray {
                return Err(LoopFault::Stray { edge: self.edges });
            }
            if self.now() >= until {
                return Ok(());
            }
            self.on.wait(until);
        }
    }
}

/// How long a board may take from its start until its lines are at rest.
const SETTLE: Span = Span::from_millis(50);
