//! Which events inputs are configured to raise.

use super::{Config, TaskKind};
use crate::event_source::EventSource;

impl Config {
    /// Whether the input of an event is configured to raise it, on a controller that has the event. An advanced input
    /// of 2014 beyond the fast ones needs no configuration (io:EVT-03).
    pub(crate) fn raises(&self, source: EventSource) -> bool {
        match source {
            EventSource::Input(input) if input < self.reference.fast_inputs => {
                self.inputs.get(input).is_some_and(|input| input.event.is_some())
            }
            _ => true,
        }
    }

    /// The inputs that raise events on rising edges because a task is started by them, bit n for In (io:EVT-03).
    pub(crate) fn advanced_inputs(&self) -> u32 {
        self.tasks.iter().fold(0, |mask, task| match task.kind {
            TaskKind::ExternalEvent { source: EventSource::Input(input) }
                if (self.reference.fast_inputs..32).contains(&input) =>
            {
                mask | 1 << input
            }
            _ => mask,
        })
    }
}
