//! What the controller asks of a protocol endpoint, and what passes between the endpoint and its port.
//!
//! An endpoint knows neither clocks nor wires nor tasks. What came on its line is handed to it with its instants; what it
//! sends goes into a [`PortOutbox`] with the instant at which it may begin. What it does takes processor time: it says how much
//! its next step takes ([`Endpoint::work`]), and the step is carried out when the processor has had that time for it. Nothing
//! of it allocates between two starts of communication.

use crate::register_access::RegisterAccess;
use crate::state::State;
use signal::{
    BusError, BusState, CanFrame, MAX_SERIAL_DATA, SerialMessage, SerialSettings, Span, Time, When,
};
use std::collections::VecDeque;
use std::fmt;

/// Messages that wait at a port to be sent.
pub const OUTBOX_MESSAGES: usize = 16;

/// A protocol at a port of the controller: a Modbus slave, a CANopen manager.
pub trait Endpoint: fmt::Debug + Send {
    /// The controller is in another state, or communication starts again. In OFF and BOOTING nothing comes and nothing goes;
    /// what was in the outbox and the step under way are gone by then.
    fn enter(&mut self, now: Time, life: PortLife, outbox: &mut PortOutbox);

    /// Something happened at the port, by `now`.
    fn receive(&mut self, now: Time, event: &PortEvent, outbox: &mut PortOutbox);

    /// When it wants to be called by itself; [`Time::MAX`] for never.
    fn next(&self) -> Time;

    /// It wanted to be called by `now`.
    fn fire(&mut self, now: Time, outbox: &mut PortOutbox);

    /// The processor time that its next step takes, at least 1 ns; `None` where it has nothing to do. It is asked after each
    /// call, and not again while a step is under way.
    fn work(&self) -> Option<Span>;

    /// The step that it asked for takes effect: the only place where it reaches the controller's memory.
    fn step(&mut self, now: Time, registers: &mut dyn RegisterAccess, outbox: &mut PortOutbox);
}

/// What happens to the controller that an endpoint is part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortLife {
    /// The controller entered a state.
    State(State),
    /// A download, a boot or a reset put an application into memory: communication starts again with its configuration
    /// (serial-can:SER-19, serial-can:CAN-33).
    Restarted,
}

/// Something that happened at a port.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "copied between queues that never allocate")]
pub enum PortEvent {
    /// Characters came on its serial line: a message, or a part of one.
    Serial(SerialMessage),
    /// A frame came on its CAN bus, which ended at this instant.
    Can {
        /// When.
        at: When,
        /// The frame.
        frame: CanFrame,
    },
    /// The oldest message that the endpoint sent and that is not reported yet is over: the line is free of it.
    Sent {
        /// When its last bit was on the wire.
        at: When,
    },
    /// The oldest message that is not reported yet could not be sent, and never will be.
    NotSent,
    /// The CAN controller takes part in its bus in another way.
    State(BusState),
    /// Something went wrong on the bus.
    Error(BusError),
    /// So many messages or frames were lost on their way here, at least.
    Missed(u32),
    /// The device behind the port is gone.
    Lost,
    /// It is back.
    Returned,
}

impl PortEvent {
    /// The same in a time that is ahead by so much.
    #[must_use]
    pub fn shifted(self, by: Span) -> PortEvent {
        let shift = |at: When| When {
            earliest: at.earliest.saturating_add(by),
            latest: at.latest.saturating_add(by),
        };
        match self {
            PortEvent::Serial(mut message) => {
                (message.first, message.last) = (shift(message.first), shift(message.last));
                PortEvent::Serial(message)
            }
            PortEvent::Can { at, frame } => PortEvent::Can { at: shift(at), frame },
            PortEvent::Sent { at } => PortEvent::Sent { at: shift(at) },
            other => other,
        }
    }
}

/// Something to be sent at a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortMessage {
    /// Characters for a serial line.
    Serial(SerialBytes),
    /// A frame for a CAN bus.
    Can(CanFrame),
    /// The port carries bytes in this way from then on, for what comes after it in the outbox and for what it hears. Neither
    /// [`PortEvent::Sent`] nor [`PortEvent::NotSent`] reports it; a line that cannot do it is a fault of the rig.
    Settings {
        /// Speed, data bits, parity, stop bits.
        line: SerialSettings,
        /// How long the line is silent between two messages, above 0.
        message_gap: Span,
    },
}

impl PortMessage {
    /// Characters for a serial line, 1 to [`MAX_SERIAL_DATA`] of them.
    pub fn serial(data: &[u8]) -> Option<PortMessage> {
        SerialBytes::new(data).map(PortMessage::Serial)
    }
}

/// Characters for a serial line.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct SerialBytes {
    data: [u8; MAX_SERIAL_DATA],
    len: u16,
}

impl SerialBytes {
    /// 1 to [`MAX_SERIAL_DATA`] of them; else `None`.
    pub fn new(data: &[u8]) -> Option<SerialBytes> {
        let mut bytes = [0; MAX_SERIAL_DATA];
        bytes.get_mut(..data.len()).filter(|bytes| !bytes.is_empty())?.copy_from_slice(data);
        Some(SerialBytes { data: bytes, len: data.len() as u16 })
    }

    /// The bytes, 1 or more.
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }
}

impl fmt::Debug for SerialBytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:02X?}", self.data())
    }
}

/// The outbox has no room left; the message is not sent, and counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutboxFull;

impl fmt::Display for OutboxFull {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{OUTBOX_MESSAGES} messages wait at the port already")
    }
}

impl std::error::Error for OutboxFull {}

/// What waits at a port to be sent, in the order in which it was put there.
#[derive(Clone, Debug)]
pub struct PortOutbox {
    queue: VecDeque<(Time, PortMessage)>,
    /// How many of the first were announced to whoever sends them.
    announced: usize,
    dropped: u64,
}

impl PortOutbox {
    pub(crate) fn new() -> PortOutbox {
        PortOutbox { queue: VecDeque::with_capacity(OUTBOX_MESSAGES), announced: 0, dropped: 0 }
    }

    /// Sends a message from `at` on, and not before those that are here already.
    ///
    /// # Errors
    /// [`OutboxFull`]; the controller's log reports it as well.
    pub fn push(&mut self, at: Time, message: PortMessage) -> Result<(), OutboxFull> {
        if self.queue.len() >= OUTBOX_MESSAGES {
            self.dropped += 1;
            return Err(OutboxFull);
        }
        self.queue.push_back((at, message));
        Ok(())
    }

    /// Messages that wait.
    pub fn len(&self) -> usize {
        self.queue.len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Messages that found no room so far.
    pub(crate) const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// When the next one is to be announced.
    pub(crate) fn next(&self) -> Time {
        self.queue.get(self.announced).map_or(Time::MAX, |(at, _)| *at)
    }

    /// One more is announced that may be sent by `now`.
    pub(crate) fn announce(&mut self, now: Time) -> bool {
        let due = self.next() <= now;
        self.announced += usize::from(due);
        due
    }

    /// The first one that was announced.
    pub(crate) fn take(&mut self) -> Option<PortMessage> {
        self.announced = self.announced.checked_sub(1)?;
        self.queue.pop_front().map(|(_, message)| message)
    }

    pub(crate) fn clear(&mut self) {
        self.queue.clear();
        self.announced = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(nanos: i64) -> Time {
        Time::from_nanos(nanos)
    }

    fn bytes(byte: u8) -> PortMessage {
        PortMessage::serial(&[byte]).unwrap()
    }

    #[test]
    fn messages_keep_their_order_and_their_instants() {
        let mut outbox = PortOutbox::new();
        outbox.push(at(10), bytes(1)).unwrap();
        outbox.push(at(5), bytes(2)).unwrap();
        assert_eq!(outbox.next(), at(10));
        assert!(!outbox.announce(at(9)));
        assert_eq!(outbox.take(), None, "nothing is handed out before its instant");
        assert!(outbox.announce(at(10)) && outbox.announce(at(10)) && !outbox.announce(at(10)));
        assert_eq!((outbox.take(), outbox.take(), outbox.take()), (Some(bytes(1)), Some(bytes(2)), None));
    }

    /// A controller whose boot took no time is ahead of its lines: every instant of an event is.
    #[test]
    fn an_event_is_moved_with_all_its_instants() {
        let by = Span::from_nanos(100);
        let when = |earliest, latest| When::within(at(earliest), at(latest));
        let message = |by: i64| SerialMessage::of(when(1 + by, 2 + by), when(3 + by, 5 + by), b"x");
        let frame = CanFrame::classic(1, false, &[]).unwrap();
        for (event, moved) in [
            (PortEvent::Serial(message(0)), PortEvent::Serial(message(100))),
            (PortEvent::Can { at: when(1, 2), frame }, PortEvent::Can { at: when(101, 102), frame }),
            (PortEvent::Sent { at: when(1, 2) }, PortEvent::Sent { at: when(101, 102) }),
            (PortEvent::Missed(3), PortEvent::Missed(3)),
        ] {
            assert_eq!(event.shifted(by), moved);
        }
    }

    #[test]
    fn a_full_outbox_refuses_and_counts() {
        let mut outbox = PortOutbox::new();
        (0..OUTBOX_MESSAGES).for_each(|n| outbox.push(at(0), bytes(n as u8)).unwrap());
        assert_eq!(outbox.push(at(0), bytes(99)), Err(OutboxFull));
        assert_eq!((outbox.len(), outbox.dropped()), (OUTBOX_MESSAGES, 1));
        assert!(PortMessage::serial(&[]).is_none() && PortMessage::serial(&[0; 257]).is_none());
    }
}
