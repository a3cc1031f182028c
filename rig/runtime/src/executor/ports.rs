//! Between the ports of the subject and the buses that they are on.

use super::Executor;
use crate::executor::rig_fault::RigFault;
use crate::wiring::WiredPort;
use controller::{PortEvent, PortMessage};
use drivers::{BoardError, BoardExt, Bus, BusEvent, BusId};
use signal::{MAX_SERIAL_DATA, SerialOutput, Span, Time};
use std::collections::VecDeque;

/// Most events that wait for the modelled time to reach them: those of one late wake-up.
const MOST_PENDING: usize = 1024;

/// Most where no port has a bus: that what was sent is not on its way, and nothing else.
const MOST_PENDING_WITHOUT_A_BUS: usize = 8;

/// An event on its way to a port.
#[derive(Clone, Copy, Debug)]
struct PendingEvent {
    at: Time,
    port: usize,
    event: PortEvent,
}

/// What passes between ports and buses.
#[derive(Debug)]
pub(super) struct BoundPorts {
    /// The bus behind each port, by the port's number.
    list: Vec<WiredPort>,
    /// Something was sent at this port, which has no bus, and that is in the log.
    discards: Vec<bool>,
    /// The port on each bus.
    ports: Vec<Option<usize>>,
    /// By their instants.
    pending: VecDeque<PendingEvent>,
    /// How many there may be.
    most_pending: usize,
    /// What is sent on a serial line; its memory is used again.
    output: SerialOutput,
}

impl BoundPorts {
    /// Ports on these buses, of a board with so many.
    pub(super) fn new(wired: &[WiredPort], buses: usize) -> BoundPorts {
        let any = wired.iter().any(|port| port.bus.is_some());
        let most_pending = if any { MOST_PENDING } else { MOST_PENDING_WITHOUT_A_BUS };
        let mut ports = vec![None; buses];
        for (port, wired) in wired.iter().enumerate() {
            if let Some(place) = wired.bus.and_then(|bus| ports.get_mut(usize::from(bus.0))) {
                *place = Some(port);
            }
        }
        BoundPorts {
            list: wired.to_vec(),
            discards: vec![false; wired.len()],
            ports,
            pending: VecDeque::with_capacity(most_pending),
            most_pending,
            output: SerialOutput::Characters {
                data: Vec::with_capacity(if any { MAX_SERIAL_DATA } else { 0 }),
                gap: Span::ZERO,
                flaw: None,
            },
        }
    }

    /// The bus behind a port.
    fn bus(&self, port: usize) -> Option<BusId> {
        self.list.get(port)?.bus
    }

    /// When the next event reaches its port.
    #[inline]
    pub(super) fn next(&self) -> Option<Time> {
        self.pending.front().map(|pending| pending.at)
    }
}

/// What an event of a bus is at the port on it.
fn at_port(event: &BusEvent) -> PortEvent {
    match *event {
        BusEvent::CanFrame { at, own: true, .. } => PortEvent::Sent { at },
        BusEvent::CanFrame { at, frame, .. } => PortEvent::Can { at, frame },
        BusEvent::SerialMessage { message, own: true, .. } => PortEvent::Sent { at: message.last },
        BusEvent::SerialMessage { message, .. } => PortEvent::Serial(message),
        BusEvent::State { state, .. } => PortEvent::State(state),
        BusEvent::Error { error, .. } => PortEvent::Error(error),
        BusEvent::Dropped { count, .. } => PortEvent::Missed(count),
        BusEvent::Lost { .. } => PortEvent::Lost,
        BusEvent::Returned { .. } => PortEvent::Returned,
    }
}

impl Executor<'_> {
    /// A bus reports something: the port on it gets it when the modelled time has come there.
    pub(super) fn hear_at_port(&mut self, event: &BusEvent) {
        let bus = event.bus();
        let Some(port) = self.ports.ports.get(usize::from(bus.0)).copied().flatten() else { return };
        self.put_to_port(event.latest(), port, at_port(event));
    }

    fn put_to_port(&mut self, at: Time, port: usize, event: PortEvent) {
        let at = at.max(self.now);
        if self.ports.pending.len() >= self.ports.most_pending {
            if let Some(known) = self.port_bus(port) {
                let (bus, kind) = (known.name.clone(), known.kind);
                self.report.fault.get_or_insert(RigFault::BusDropped { at, bus, kind, count: 1 });
            }
            return;
        }
        let place = self.ports.pending.partition_point(|pending| pending.at <= at);
        self.ports.pending.insert(place, PendingEvent { at, port, event });
    }

    /// The events that are due reach their ports.
    pub(super) fn feed_ports(&mut self) -> Result<(), RigFault> {
        while let Some(pending) = self.ports.pending.front().copied().filter(|pending| pending.at <= self.now)
        {
            self.ports.pending.pop_front();
            if let Some(ports) = self.parts.subject.ports() {
                ports.receive(self.now, pending.port, &pending.event, &mut self.buffers.effects);
            }
        }
        self.apply()
    }

    /// A port sends a message now, or gets other settings.
    pub(super) fn send_from_port(&mut self, at: Time, port: usize) {
        let Some(message) = self.parts.subject.ports().and_then(|ports| ports.take_output(port)) else {
            return;
        };
        let Some(bus) = self.ports.bus(port) else {
            self.note_discarded(at, port);
            if !matches!(message, PortMessage::Settings { .. }) {
                self.put_to_port(at, port, PortEvent::NotSent);
            }
            return;
        };
        let now = self.board_time();
        let sent = match (&message, &mut self.ports.output) {
            (PortMessage::Can(frame), _) => self.parts.board.send(now, bus, frame),
            (PortMessage::Settings { line, message_gap }, _) => {
                self.parts.board.configure(now, bus, line, *message_gap)
            }
            (PortMessage::Serial(bytes), SerialOutput::Characters { data, .. }) => {
                data.clear();
                data.extend_from_slice(bytes.data());
                self.parts.board.send_serial(now, bus, &self.ports.output)
            }
            (PortMessage::Serial(_), SerialOutput::Break(_)) => Err(BoardError::BadFrame(bus)),
        };
        if let Err(error) = sent {
            let bus = self.port_bus(port).map_or_else(String::new, |known| known.name.clone());
            self.report.fault.get_or_insert(RigFault::PortNotSent { at, bus, error });
            if !matches!(message, PortMessage::Settings { .. }) {
                self.put_to_port(at, port, PortEvent::NotSent);
            }
        }
    }

    /// What was sent at a port without a bus is discarded; the log says so once.
    fn note_discarded(&mut self, at: Time, port: usize) {
        let Some(noted) = self.ports.discards.get_mut(port) else { return };
        if !std::mem::replace(noted, true) {
            let name = self.ports.list[port].name;
            self.log(
                at,
                format!("{name}: the board file binds no bus to it; what its endpoint sends is discarded"),
            );
        }
    }

    /// The electronics of a port stop: what it is sending breaks off.
    pub(super) fn silence_port(&mut self, port: usize) -> Result<(), RigFault> {
        let Some(bus) = self.ports.bus(port) else { return Ok(()) };
        let at = self.board_time();
        self.parts.board.break_off(at, bus).map_err(|error| RigFault::Board { at, error })
    }

    /// The bus behind a port.
    fn port_bus(&self, port: usize) -> Option<&Bus> {
        let bus = self.ports.bus(port)?;
        self.parts.board.bus_list().get(usize::from(bus.0))
    }
}
