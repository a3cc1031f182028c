//! The PROBE input: captures positions (io:STD-PTO-11).

use super::command::CommandPhase;

/// What to capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CaptureTrigger {
    /// With the edge at which the input comes on, else with the one at which it goes off.
    pub rising: bool,
    /// Only between two positions, these included.
    pub window: Option<(i64, i64)>,
}

/// The last capture, done or waiting.
#[derive(Clone, Debug, Default)]
pub struct TouchProbe {
    waiting: Option<CaptureTrigger>,
    ticket: u32,
    done: bool,
    recorded: i64,
}

impl TouchProbe {
    /// Waits for an edge; a capture that waits is aborted.
    pub fn arm(&mut self, ticket: u32, capture: CaptureTrigger) {
        *self = TouchProbe { waiting: Some(capture), ticket, done: false, recorded: self.recorded };
    }

    /// Waits no more.
    pub fn abort(&mut self) {
        self.waiting = None;
    }

    /// What became of a capture.
    pub fn phase(&self, ticket: u32) -> CommandPhase {
        match self.waiting {
            _ if ticket != self.ticket => CommandPhase::Aborted,
            Some(_) => CommandPhase::Active,
            None if self.done => CommandPhase::Done,
            None => CommandPhase::Aborted,
        }
    }

    /// The position of the last capture.
    pub const fn position(&self) -> i64 {
        self.recorded
    }

    /// The input comes on or goes off at a position; whether that is an event: what a capture waits for, or where none
    /// waits the edge at which it comes on.
    pub fn edge(&mut self, on: bool, position: i64) -> bool {
        let Some(capture) = self.waiting else { return on };
        let inside = capture.window.is_none_or(|(first, last)| (first..=last).contains(&position));
        let event = on == capture.rising && inside;
        if event {
            self.waiting = None;
            self.done = true;
            self.recorded = position;
        }
        event
    }
}
