//! Which events the controller is configured to raise.

use super::{Config, TaskKind};
use crate::event_source::ExternalEventSource;
use profile::ChannelSet;

impl Config {
    /// Whether the input of an event, or the CANopen manager, is configured to raise it, on a controller that has the
    /// event. An advanced input of 2014 beyond the fast ones needs no configuration (io:EVT-03).
    pub(crate) fn raises(&self, source: ExternalEventSource) -> bool {
        match source {
            ExternalEventSource::Input(input) if input < self.reference.fast_inputs => {
                self.inputs.get(input).is_some_and(|input| input.event.is_some())
            }
            ExternalEventSource::CanSync => self.can_sync,
            _ => true,
        }
    }

    /// The inputs that raise events on rising edges because a task is started by them (io:EVT-03).
    pub(crate) fn advanced_inputs(&self) -> ChannelSet {
        let inputs = self.tasks.iter().filter_map(|task| match task.kind {
            TaskKind::ExternalEvent { source: ExternalEventSource::Input(input) } => Some(input),
            _ => None,
        });
        inputs.filter(|input| *input >= self.reference.fast_inputs).collect()
    }
}
