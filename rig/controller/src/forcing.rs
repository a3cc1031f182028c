//! Forcing: who may force, when a forced value acts, and when it ends (controller: section 12).

use crate::{Channel, CommandError, Controller, State};

/// Forced channels (controller:FRC-02).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Forced {
    /// A 1 for every forced channel.
    pub mask: u32,
    /// Their values.
    pub bits: u32,
}

impl Forced {
    #[inline]
    pub(crate) const fn apply(self, bits: u32) -> u32 {
        bits & !self.mask | self.bits & self.mask
    }

    fn set(&mut self, channel: usize, on: Option<bool>) {
        let bit = 1 << channel;
        self.mask = if on.is_some() { self.mask | bit } else { self.mask & !bit };
        self.bits = if on == Some(true) { self.bits | bit } else { self.bits & !bit };
    }

    /// Takes the channels of `which` from `other`.
    fn take(&mut self, other: Forced, which: u32) {
        self.mask = self.mask & !which | other.mask & which;
        self.bits = self.bits & !which | other.bits & which;
    }
}

/// What belongs to forcing besides the forced channels themselves.
#[derive(Clone, Debug)]
pub(crate) struct Forcing {
    /// A programming tool is connected (controller:FRC-01).
    pub connected: bool,
    /// What acts on the outputs: the forced values that their tasks have come to (controller:FRC-05).
    acting: Forced,
    /// The outputs of each task, by rank.
    owned: Vec<u32>,
}

impl Forcing {
    pub(crate) fn new(connected: bool, tasks: usize) -> Forcing {
        Forcing { connected, acting: Forced::default(), owned: vec![0; tasks] }
    }
}

impl Controller {
    /// Ends all forcing.
    pub(crate) fn clear_forcing(&mut self) {
        (self.forced_inputs, self.forced_outputs) = (Forced::default(), Forced::default());
        self.forcing.acting = Forced::default();
    }

    /// Finds out which task of a new application contains which output: that which writes it, else that which
    /// exchanges it.
    pub(crate) fn assign_forcing(&mut self) {
        let Some(application) = &self.application else { return };
        let written = |place| application.written_outputs(place);
        let used = self.tasks.iter().fold(0, |used, task| used | written(task.place));
        for (owned, task) in self.forcing.owned.iter_mut().zip(&self.tasks) {
            *owned = written(task.place) | task.outputs & !used;
        }
    }

    /// Forcing comes to act on the outputs of a task that has executed, or without one on all of them.
    #[inline]
    pub(crate) fn act_forcing(&mut self, rank: Option<usize>) {
        if self.forced_outputs.mask | self.forcing.acting.mask != 0 {
            let which = rank.map_or(u32::MAX, |rank| self.forcing.owned[rank]);
            self.forcing.acting.take(self.forced_outputs, which);
        }
    }

    /// The forced outputs that act.
    #[inline]
    pub(crate) fn acting_outputs(&self) -> Forced {
        self.forcing.acting
    }

    /// Forcing acts at the next end of the output's task (controller:FRC-05) or read of the inputs.
    pub(crate) fn force(&mut self, channel: Channel, on: Option<bool>) -> Result<(), CommandError> {
        if !matches!(self.state, State::Running | State::Breakpoint | State::Stopped | State::Halt) {
            return Err(CommandError::State(self.state));
        }
        if !self.forcing.connected {
            return Err(CommandError::NotConnected);
        }
        match channel {
            Channel::Input(input) if input < self.config.reference.input_count() => {
                self.forced_inputs.set(input, on);
            }
            Channel::Output(output) if self.functions.drives(output) => {
                return Err(CommandError::ExpertOutput(output));
            }
            Channel::Output(output) if output < self.config.reference.output_count() => {
                self.forced_outputs.set(output, on);
                if on.is_none() {
                    self.forcing.acting.set(output, None);
                }
            }
            channel => return Err(CommandError::NoChannel(channel)),
        }
        Ok(())
    }

    /// The tool connects (controller:FRC-01).
    pub(crate) fn log_in(&mut self) -> Result<(), CommandError> {
        self.state.status().ok_or(CommandError::State(self.state))?;
        self.forcing.connected = true;
        Ok(())
    }

    /// The tool disconnects and keeps forcing, or ends it (controller:FRC-03).
    pub(crate) fn log_out(&mut self, keep_forcing: bool) -> Result<(), CommandError> {
        self.state.status().ok_or(CommandError::State(self.state))?;
        if !self.forcing.connected {
            return Err(CommandError::NotConnected);
        }
        self.forcing.connected = false;
        if !keep_forcing {
            self.clear_forcing();
        }
        Ok(())
    }
}
