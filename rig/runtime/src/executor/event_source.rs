//! What can happen next, and in which order it does at one instant.

use super::Executor;
use crate::executor::rig_fault::RigFault;
use plans::steps::CasePart;
use signal::Time;

/// Something that says when it wants to act next, and then acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EventSource {
    /// Changes of the board.
    Board,
    /// Changes of inputs that the modelled time had not reached when they were seen, and the end of what was polled ahead.
    Inputs,
    /// What came on the buses of the controller's ports.
    Ports,
    /// Steps that wait for their last edges.
    Edges,
    /// Steps of the plan.
    Steps,
    /// Alarms whose conditions have lasted.
    Alarms,
    /// The end of the case. What is due at the end itself still belongs to it, but no step comes after it.
    End,
    /// Timers of the controller.
    Timers,
    /// Whoever goes through the case step by step.
    Stepper,
}

impl EventSource {
    /// All of them, in the order in which they act at one instant. The traces depend on it.
    pub(super) const ORDER: [EventSource; 9] = [
        EventSource::Board,
        EventSource::Inputs,
        EventSource::Ports,
        EventSource::Edges,
        EventSource::Steps,
        EventSource::Alarms,
        EventSource::End,
        EventSource::Timers,
        EventSource::Stepper,
    ];

    /// Those that bring something about where time stands still.
    pub(super) const BY_THEMSELVES: [EventSource; 6] = [
        EventSource::Timers,
        EventSource::Board,
        EventSource::Ports,
        EventSource::Steps,
        EventSource::Alarms,
        EventSource::Edges,
    ];

    /// When it wants to act next.
    #[inline]
    pub(super) fn next(self, executor: &Executor<'_>) -> Option<Time> {
        match self {
            EventSource::Board => executor.parts.board.next_event(),
            EventSource::Inputs => executor.lines.next(),
            EventSource::Ports => executor.ports.next(),
            EventSource::Edges => executor.awaited.edges.next(),
            EventSource::Steps => executor.parts.schedule.next_due(),
            EventSource::Alarms => executor.next_alarm(),
            EventSource::End => Some(executor.end),
            EventSource::Timers => executor.parts.subject.next_timer(),
            EventSource::Stepper => executor.stepping.as_ref().map(|stepping| stepping.wake(executor.now)),
        }
    }

    /// Acts at `due`, having wanted to at `planned`.
    #[inline]
    pub(super) fn fire(self, executor: &mut Executor<'_>, planned: Time, due: Time) -> Result<(), RigFault> {
        let is_due = planned <= due;
        match self {
            EventSource::Board if is_due || executor.pacing.has_wires() && executor.board_has_news(due) => {
                executor.poll()
            }
            // Not as planned: a change may have been seen since.
            EventSource::Inputs if executor.lines.next().is_some_and(|at| at <= due) => {
                executor.feed();
                executor.apply()
            }
            EventSource::Ports if is_due => executor.feed_ports(),
            EventSource::Edges => {
                executor.end_pulses();
                Ok(())
            }
            EventSource::Steps if is_due => executor.steps(due),
            EventSource::Alarms if is_due => {
                executor.raise_due();
                Ok(())
            }
            EventSource::End => {
                let early = executor.parts.schedule.ended().is_some()
                    && executor.parts.schedule.phase() != CasePart::Teardown;
                executor.ends = is_due || executor.over || early;
                Ok(())
            }
            // Not as planned: what acted before may have set a timer, or taken one back.
            EventSource::Timers if executor.parts.subject.next_timer().is_some_and(|timer| timer <= due) => {
                executor.parts.subject.fire(due, &mut executor.buffers.effects);
                executor.apply()
            }
            EventSource::Stepper if is_due && !executor.ends => executor.pause(None),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::EventSource::{self, Alarms, Board, Edges, End, Inputs, Ports, Stepper, Steps, Timers};

    /// Whoever changes it changes traces.
    #[test]
    fn the_order_at_one_instant_is_the_written_one() {
        assert_eq!(EventSource::ORDER, [Board, Inputs, Ports, Edges, Steps, Alarms, End, Timers, Stepper]);
    }
}
