//! Simulated CAN buses: frames take their time on the wire, and identifiers decide who sends first.
//!
//! Every bus of a board is one node; buses that join each other hang on one wire. What one of them sends the others
//! receive, and the sender sees it as its own, at the end of the frame. A bus that joins no other has a silent node
//! beside it which acknowledges what it hears, so that a frame comes to its end.

use std::collections::VecDeque;

use signal::{CanFrame, Span, Time, When};

use super::can_bits::{bits, intermission, priority};
use crate::circuit::CanRates;
use crate::{BoardError, BusEvent, BusId};

/// Frames that wait in the queue of one bus.
pub const MAX_QUEUED: usize = 1024;

/// A frame that waits, and since when.
#[derive(Clone, Copy, Debug)]
struct Queued {
    since: Time,
    frame: CanFrame,
}

/// One node on a wire.
#[derive(Clone, Debug)]
struct Node {
    bus: BusId,
    wire: usize,
    queue: VecDeque<Queued>,
}

/// A wire and the frame on it.
#[derive(Clone, Copy, Debug)]
struct CanWire {
    rates: CanRates,
    /// From here on a frame may start.
    free: Time,
    /// Its sender, when it ends, and what it is.
    under_way: Option<(usize, Time, CanFrame)>,
}

/// The CAN buses of a simulated board.
#[derive(Clone, Debug, Default)]
pub struct CanWires {
    nodes: Vec<Node>,
    wires: Vec<CanWire>,
    latched: bool,
}

impl CanWires {
    /// Appends a bus; it joins one that is there, or has a wire of its own.
    pub fn push(&mut self, bus: BusId, rates: CanRates, joins: Option<BusId>) {
        let joined = joins.and_then(|other| self.nodes.iter().find(|node| node.bus == other));
        let wire = joined.map_or(self.wires.len(), |node| node.wire);
        if wire == self.wires.len() {
            self.wires.push(CanWire { rates, free: Time::MIN, under_way: None });
        }
        self.nodes.push(Node { bus, wire, queue: VecDeque::with_capacity(MAX_QUEUED) });
    }

    /// Forgets what was before.
    pub fn start(&mut self) {
        self.latched = false;
        self.nodes.iter_mut().for_each(|node| node.queue.clear());
        self.wires.iter_mut().for_each(|wire| (wire.free, wire.under_way) = (Time::MIN, None));
    }

    /// Nothing more is sent; the frame that is on a wire comes to its end.
    pub fn safe(&mut self) {
        self.latched = true;
        self.nodes.iter_mut().for_each(|node| node.queue.clear());
    }

    /// Nothing more is sent from this bus; the frame that is on its wire comes to its end.
    pub fn break_off(&mut self, now: Time, bus: BusId) {
        (0..self.wires.len()).for_each(|wire| self.begin(wire, now));
        self.nodes.iter_mut().filter(|node| node.bus == bus).for_each(|node| node.queue.clear());
    }

    /// Puts a frame into the queue of a bus.
    ///
    /// # Errors
    /// [`BoardError::NoBus`], [`BoardError::BadFrame`], [`BoardError::BusFull`], [`BoardError::Latched`].
    pub fn send(&mut self, now: Time, bus: BusId, frame: &CanFrame) -> Result<(), BoardError> {
        let node = self.nodes.iter_mut().find(|node| node.bus == bus).ok_or(BoardError::NoBus(bus))?;
        if self.latched {
            return Err(BoardError::Latched);
        }
        if !fits(frame, self.wires[node.wire].rates.data_bitrate) {
            return Err(BoardError::BadFrame(bus));
        }
        if node.queue.len() >= MAX_QUEUED {
            return Err(BoardError::BusFull(bus));
        }
        node.queue.push_back(Queued { since: now, frame: *frame });
        Ok(())
    }

    /// When the next frame ends, as things stand.
    pub fn next_event(&self) -> Option<Time> {
        let ends = (0..self.wires.len()).filter_map(|wire| match self.wires[wire].under_way {
            Some((_, end, _)) => Some(end),
            None => self.winner(wire).map(|(_, start)| self.end(wire, start)),
        });
        ends.min()
    }

    /// Appends the frames that ended up to `now`, oldest first.
    pub fn poll(&mut self, now: Time, out: &mut Vec<BusEvent>) {
        loop {
            for wire in 0..self.wires.len() {
                self.begin(wire, now);
            }
            let ending = |wire: &CanWire| wire.under_way.map(|(_, end, _)| end).filter(|end| *end <= now);
            let first = (0..self.wires.len()).filter_map(|wire| Some((ending(&self.wires[wire])?, wire)));
            let Some((end, wire)) = first.min() else { return };
            self.arrive(wire, end, out);
        }
    }

    /// Lets the frame start that wins the wire before `now`: at `now` itself others may still be queued.
    fn begin(&mut self, wire: usize, now: Time) {
        if self.wires[wire].under_way.is_some() {
            return;
        }
        let Some((node, start)) = self.winner(wire).filter(|(_, start)| *start < now) else { return };
        let end = self.end(wire, start);
        if let Some(queued) = self.nodes[node].queue.pop_front() {
            self.wires[wire].under_way = Some((node, end, queued.frame));
        }
    }

    /// The node that sends next on a free wire, and when its frame starts.
    fn winner(&self, wire: usize) -> Option<(usize, Time)> {
        let heads = self.nodes.iter().enumerate().filter(|(_, node)| node.wire == wire);
        let heads = heads.filter_map(|(place, node)| Some((place, node.queue.front()?)));
        let start = heads.clone().map(|(_, queued)| queued.since).min()?.max(self.wires[wire].free);
        let ready = heads.filter(|(_, queued)| queued.since <= start);
        // Equal identifiers must not meet on a wire; here the first bus of the file goes first.
        let (place, _) = ready.min_by_key(|(place, queued)| (priority(&queued.frame), *place))?;
        Some((place, start))
    }

    /// When the frame ends that wins the wire and starts now.
    fn end(&self, wire: usize, start: Time) -> Time {
        let head = self.winner(wire).and_then(|(node, _)| self.nodes[node].queue.front());
        let CanRates { bitrate, data_bitrate } = self.wires[wire].rates;
        let lasts = head
            .map_or(Span::ZERO, |queued| bits(&queued.frame).lasts(bitrate, data_bitrate.unwrap_or(bitrate)));
        start.saturating_add(lasts)
    }

    /// The frame on a wire is at its end: everybody on it sees it.
    fn arrive(&mut self, wire: usize, end: Time, out: &mut Vec<BusEvent>) {
        let Some((sender, _, frame)) = self.wires[wire].under_way.take() else { return };
        self.wires[wire].free = end.saturating_add(intermission(self.wires[wire].rates.bitrate));
        for (place, node) in self.nodes.iter().enumerate().filter(|(_, node)| node.wire == wire) {
            let (bus, own) = (node.bus, place == sender);
            out.push(BusEvent::CanFrame { bus, at: When::exactly(end), frame, own });
        }
    }
}

/// Whether a bus can carry a frame.
fn fits(frame: &CanFrame, data_bitrate: Option<u32>) -> bool {
    let most_id = if frame.extended { 0x1FFF_FFFF } else { 0x7FF };
    let length = match frame.fd {
        true => data_bitrate.is_some() && matches!(frame.len, 0..=8 | 12 | 16 | 20 | 24 | 32 | 48 | 64),
        false => frame.len <= 8 && !frame.brs && !frame.esi,
    };
    frame.id <= most_id && length && !(frame.remote && frame.fd)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair() -> CanWires {
        let rates = CanRates { bitrate: 500_000, data_bitrate: None };
        let mut wires = CanWires::default();
        for (bus, joins) in [(0, None), (1, Some(BusId(0))), (2, None)] {
            wires.push(BusId(bus), rates, joins);
        }
        wires
    }

    fn frame(id: u32) -> CanFrame {
        CanFrame::classic(id, false, &[1, 2]).unwrap()
    }

    /// What is reported up to `now`: bus, identifier, own, microseconds.
    fn told(buses: &mut CanWires, now: Time) -> Vec<(u16, u32, bool, i64)> {
        let mut out = Vec::new();
        buses.poll(now, &mut out);
        let tell = |event: &BusEvent| match event {
            BusEvent::CanFrame { bus, at, frame, own } => {
                (bus.0, frame.id, *own, at.latest.as_nanos() / 1_000)
            }
            other => panic!("{other:?}"),
        };
        out.iter().map(tell).collect()
    }

    #[test]
    fn a_frame_takes_its_time_and_all_on_the_wire_see_it() {
        let mut buses = pair();
        let now = Time::from_nanos(1_000_000);
        buses.send(now, BusId(0), &frame(0x123)).unwrap();
        let end = buses.next_event().unwrap();
        let lasts = bits(&frame(0x123)).lasts(500_000, 500_000);
        assert_eq!(end, now.saturating_add(lasts));
        assert_eq!(told(&mut buses, end.saturating_add(Span::from_nanos(-1))), []);
        let at = end.as_nanos() / 1_000;
        assert_eq!(told(&mut buses, end), [(0, 0x123, true, at), (1, 0x123, false, at)]);
        assert_eq!(buses.next_event(), None);
    }

    #[test]
    fn the_least_identifier_wins_and_the_next_waits_for_the_pause() {
        let mut buses = pair();
        let now = Time::ZERO;
        for (bus, id) in [(0, 0x200), (1, 0x100), (0, 0x001)] {
            buses.send(now, BusId(bus), &frame(id)).unwrap();
        }
        // A look at the same instant does not begin anything.
        assert_eq!(told(&mut buses, now), []);
        let first = bits(&frame(0x100)).lasts(500_000, 500_000);
        let second = first + intermission(500_000) + bits(&frame(0x200)).lasts(500_000, 500_000);
        let seen = told(&mut buses, Time::ZERO.saturating_add(Span::from_millis(10)));
        let ids: Vec<(u32, bool)> =
            seen.iter().filter(|(bus, ..)| *bus == 0).map(|(_, id, own, _)| (*id, *own)).collect();
        // 0x001 stands after 0x200 in the queue of its own bus.
        assert_eq!(ids, [(0x100, false), (0x200, true), (0x001, true)]);
        assert_eq!(seen[0].3, first.as_nanos() / 1_000);
        assert_eq!(seen[2].3, second.as_nanos() / 1_000);
    }

    #[test]
    fn how_often_it_is_polled_never_shows() {
        let run = |step: i64| {
            let mut buses = pair();
            let mut seen = Vec::new();
            for at in 0..4_000_i64 {
                let now = Time::from_nanos(at * 1_000);
                if at % step == 0 {
                    seen.extend(told(&mut buses, now));
                }
                if at % 150 == 0 {
                    let bus = BusId((at / 150 % 3) as u16);
                    buses.send(now, bus, &frame((at / 150) as u32)).unwrap();
                }
            }
            seen.extend(told(&mut buses, Time::from_nanos(1_000_000_000)));
            seen.sort_by_key(|(bus, _, _, at)| (*at, *bus));
            seen
        };
        assert_eq!(run(1), run(7));
        assert_eq!(run(1), run(5_000));
    }

    #[test]
    fn what_a_bus_cannot_carry_is_refused() {
        let mut buses = pair();
        let fd = CanFrame { fd: true, ..frame(1) };
        let long = CanFrame { id: 0x800, ..frame(1) };
        assert_eq!(buses.send(Time::ZERO, BusId(0), &fd), Err(BoardError::BadFrame(BusId(0))));
        assert_eq!(buses.send(Time::ZERO, BusId(0), &long), Err(BoardError::BadFrame(BusId(0))));
        assert_eq!(buses.send(Time::ZERO, BusId(9), &frame(1)), Err(BoardError::NoBus(BusId(9))));
        for _ in 0..MAX_QUEUED {
            buses.send(Time::ZERO, BusId(0), &frame(1)).unwrap();
        }
        assert_eq!(buses.send(Time::ZERO, BusId(0), &frame(1)), Err(BoardError::BusFull(BusId(0))));
        buses.safe();
        assert_eq!(buses.send(Time::ZERO, BusId(1), &frame(1)), Err(BoardError::Latched));
        assert_eq!(told(&mut buses, Time::from_nanos(1_000_000_000)), []);
    }
}
