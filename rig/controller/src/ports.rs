//! The ports of the controller: their endpoints, what these send, and the processor time that they take.
//!
//! Communication has the lowest priority: its steps take processor time that no task wants (ethernet:NET-08), one at a
//! time, port by port in turn.

use crate::endpoint::{Endpoint, PortEvent, PortLife, PortMessage, PortOutbox};
use crate::register_access::RegisterAccess;
use crate::state::State;
use signal::{Span, Time};

/// What passed at a port since it was attached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortStatus {
    /// Messages and frames that reached the endpoint.
    pub received: u64,
    /// Messages and frames that it sent.
    pub sent: u64,
    /// Steps that it took.
    pub steps: u64,
    /// What came and reached nobody: without an endpoint, without power, during a boot.
    pub discarded: u64,
    /// Messages that found no room in the outbox.
    pub dropped: u64,
}

/// A port.
#[derive(Debug)]
struct Port {
    endpoint: Option<Box<dyn Endpoint>>,
    outbox: PortOutbox,
    status: PortStatus,
}

/// What is to be reported to the endpoints.
#[derive(Clone, Copy, Debug, Default)]
struct Notices {
    /// Since when.
    at: Option<Time>,
    restarted: bool,
    state: Option<State>,
    /// Power went, or the controller boots: what was under way is gone.
    cleared: bool,
}

/// The ports of a controller, by their numbers. Without an endpoint there is nothing to do.
#[derive(Debug, Default)]
pub(crate) struct Ports {
    list: Vec<Port>,
    attached: bool,
    /// The port whose step is under way, and the processor time that it still takes.
    step: Option<(usize, Span)>,
    /// The port whose step was the last.
    last: usize,
    notices: Notices,
    /// Nothing comes and goes.
    quiet: bool,
}

impl Ports {
    /// So many ports, none with an endpoint, without power.
    pub(crate) fn new(ports: usize) -> Ports {
        let port = || Port { endpoint: None, outbox: PortOutbox::new(), status: PortStatus::default() };
        Ports { list: (0..ports).map(|_| port()).collect(), quiet: true, ..Ports::default() }
    }

    /// Puts an endpoint at a port; FALSE where there is no such port.
    pub(crate) fn attach(&mut self, port: usize, endpoint: Box<dyn Endpoint>) -> bool {
        let Some(port) = self.list.get_mut(port) else { return false };
        port.endpoint = Some(endpoint);
        self.attached = true;
        true
    }

    pub(crate) fn status(&self, port: usize) -> Option<PortStatus> {
        let port = self.list.get(port)?;
        Some(PortStatus { dropped: port.outbox.dropped(), ..port.status })
    }

    /// The controller entered a state.
    pub(crate) fn note_state(&mut self, now: Time, state: State) {
        self.notices.at.get_or_insert(now);
        self.notices.state = Some(state);
        self.notices.cleared |= matches!(state, State::Off | State::Booting);
    }

    /// An application came into memory, or was reset.
    pub(crate) fn note_restart(&mut self, now: Time) {
        self.notices.at.get_or_insert(now);
        self.notices.restarted = true;
    }

    /// Takes over what was noted elsewhere while a step was carried out.
    pub(crate) fn adopt(&mut self, other: &Ports) {
        let Notices { at, restarted, state, cleared } = other.notices;
        let mine = &mut self.notices;
        mine.at = mine.at.or(at);
        mine.restarted |= restarted;
        mine.state = state.or(mine.state);
        mine.cleared |= cleared;
    }

    /// When something happens here by itself; [`Time::MAX`] for never.
    #[inline]
    pub(crate) fn next(&self) -> Time {
        if !self.attached {
            return Time::MAX;
        }
        let due = |port: &Port| {
            let own = port.endpoint.as_ref().map_or(Time::MAX, |endpoint| endpoint.next());
            own.min(port.outbox.next())
        };
        let ports = if self.quiet { Time::MAX } else { self.list.iter().map(due).min().unwrap_or(Time::MAX) };
        self.notices.at.unwrap_or(Time::MAX).min(ports)
    }

    /// Reports to the endpoints what happened to the controller; whether what they sent breaks off.
    pub(crate) fn notify(&mut self, now: Time) -> bool {
        let Notices { at, restarted, state, cleared } = std::mem::take(&mut self.notices);
        if at.is_none() {
            return false;
        }
        if cleared {
            self.step = None;
        }
        if let Some(state) = state {
            self.quiet = matches!(state, State::Off | State::Booting);
        }
        for port in &mut self.list {
            if cleared {
                port.outbox.clear();
            }
            let Some(endpoint) = &mut port.endpoint else { continue };
            if restarted {
                endpoint.enter(now, PortLife::Restarted, &mut port.outbox);
            }
            if let Some(state) = state {
                endpoint.enter(now, PortLife::State(state), &mut port.outbox);
            }
        }
        if self.quiet {
            self.list.iter_mut().for_each(|port| port.outbox.clear());
        }
        self.choose();
        cleared
    }

    /// The ports with an endpoint.
    pub(crate) fn attached(&self) -> impl Iterator<Item = usize> + '_ {
        self.list.iter().enumerate().filter(|(_, port)| port.endpoint.is_some()).map(|(place, _)| place)
    }

    /// Something happened at a port.
    pub(crate) fn receive(&mut self, now: Time, port: usize, event: &PortEvent) {
        let is_message = matches!(event, PortEvent::Serial(_) | PortEvent::Can { .. });
        let Some(port) = self.list.get_mut(port) else { return };
        match &mut port.endpoint {
            Some(endpoint) if !self.quiet => {
                port.status.received += u64::from(is_message);
                endpoint.receive(now, event, &mut port.outbox);
            }
            _ => port.status.discarded += u64::from(is_message),
        }
        self.choose();
    }

    /// Lets the endpoints act that wanted to by `now`.
    pub(crate) fn fire(&mut self, now: Time) {
        if self.quiet {
            return;
        }
        for port in &mut self.list {
            if let Some(endpoint) = port.endpoint.as_mut().filter(|endpoint| endpoint.next() <= now) {
                endpoint.fire(now, &mut port.outbox);
            }
        }
        self.choose();
    }

    /// A port that may send by `now`, once for each message.
    pub(crate) fn announce(&mut self, now: Time) -> Option<usize> {
        if !self.attached {
            return None;
        }
        self.list.iter_mut().position(|port| port.outbox.announce(now))
    }

    /// The message that was announced.
    pub(crate) fn take(&mut self, port: usize) -> Option<PortMessage> {
        let port = self.list.get_mut(port)?;
        let message = port.outbox.take()?;
        port.status.sent += u64::from(!matches!(message, PortMessage::Settings { .. }));
        Some(message)
    }

    /// A port that dropped messages since it was asked last, and how many in all.
    pub(crate) fn take_dropped(&mut self) -> Option<(usize, u64)> {
        if !self.attached {
            return None;
        }
        let place = self.list.iter().position(|port| port.outbox.dropped() > port.status.dropped)?;
        let port = &mut self.list[place];
        port.status.dropped = port.outbox.dropped();
        Some((place, port.status.dropped))
    }

    /// Whether a step wants the processor.
    #[inline]
    pub(crate) const fn is_busy(&self) -> bool {
        self.step.is_some()
    }

    /// The processor time that the step under way still takes.
    pub(crate) fn left(&self) -> Option<Span> {
        self.step.map(|(_, left)| left)
    }

    /// The step under way had so much of the processor, and takes more.
    pub(crate) fn pass(&mut self, used: Span) {
        if let Some((_, left)) = &mut self.step {
            *left = *left - used;
        }
    }

    /// The port whose step is under way.
    pub(crate) fn stepping(&self) -> Option<usize> {
        self.step.map(|(port, _)| port)
    }

    /// The step under way takes effect.
    pub(crate) fn step(&mut self, now: Time, registers: &mut dyn RegisterAccess) {
        let Some((place, _)) = self.step.take() else { return };
        self.last = place;
        if let Some(port) = self.list.get_mut(place)
            && let Some(endpoint) = &mut port.endpoint
        {
            port.status.steps += 1;
            endpoint.step(now, registers, &mut port.outbox);
        }
        self.choose();
    }

    /// The next step, where none is under way: that of the next port after the last one that has something to do.
    fn choose(&mut self) {
        if self.quiet || self.step.is_some() {
            return;
        }
        let count = self.list.len();
        self.step = (1..=count).map(|ahead| (self.last + ahead) % count).find_map(|place| {
            let work = self.list[place].endpoint.as_ref()?.work()?;
            // At least a nanosecond, so that steps without cost cannot hold up the time.
            Some((place, work.max(Span::from_nanos(1))))
        });
    }
}
