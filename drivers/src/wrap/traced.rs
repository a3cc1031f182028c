//! A board that remembers what was asked of it and what it told.

use std::collections::VecDeque;

use signal::{Span, Time, Value, When};

use crate::board::{Board, BoardError, BoardEvent, Channel, ChannelId, Emission, Fault, Health};
use crate::{Bus, BusEvent, BusId, Frame, HeldLines};

/// Something that passed through a traced board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Entry {
    /// The board was started.
    Start,
    /// One entry of a write.
    Write {
        /// Which channel.
        channel: ChannelId,
        /// What it was to be driven to.
        value: Value,
    },
    /// A channel was to emit pulses.
    Emit(ChannelId),
    /// A fault was injected.
    Inject(Fault),
    /// The faults of a channel were cleared.
    Clear(ChannelId),
    /// The outputs were made safe.
    Safe,
    /// A poll reported this.
    Event(BoardEvent),
    /// The call before this entry failed.
    Failed(BoardError),
}

/// How often what was called.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Calls of start.
    pub starts: u64,
    /// Calls of write.
    pub writes: u64,
    /// Channels written in all.
    pub written: u64,
    /// Calls of emit.
    pub emissions: u64,
    /// Calls of poll.
    pub polls: u64,
    /// Events reported.
    pub events: u64,
    /// Calls of inject and clear.
    pub faults: u64,
    /// Calls that failed.
    pub failed: u64,
}

/// A wrapper with a ring of the newest entries, each with the time of its call.
#[derive(Debug)]
pub struct Traced<B: Board> {
    inner: B,
    ring: VecDeque<(Time, Entry)>,
    capacity: usize,
    counts: Counts,
}

impl<B: Board> Traced<B> {
    /// Remembers the newest `capacity` entries.
    pub fn new(inner: B, capacity: usize) -> Self {
        Traced { inner, ring: VecDeque::with_capacity(capacity), capacity, counts: Counts::default() }
    }

    /// The newest entries, oldest first.
    pub fn entries(&self) -> impl Iterator<Item = &(Time, Entry)> {
        self.ring.iter()
    }

    /// How often what was called since the making of the wrapper.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The board within.
    pub fn into_inner(self) -> B {
        self.inner
    }

    fn note(&mut self, now: Time, entry: Entry) {
        if self.capacity == 0 {
            return;
        }
        if self.ring.len() >= self.capacity {
            self.ring.pop_front();
        }
        self.ring.push_back((now, entry));
    }

    fn outcome(&mut self, now: Time, outcome: Result<(), BoardError>) -> Result<(), BoardError> {
        if let Err(error) = outcome {
            self.counts.failed += 1;
            self.note(now, Entry::Failed(error));
        }
        outcome
    }
}

impl<B: Board> Board for Traced<B> {
    fn channels(&self) -> &[Channel] {
        self.inner.channels()
    }

    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.counts.starts += 1;
        self.note(now, Entry::Start);
        let outcome = self.inner.start(now);
        self.outcome(now, outcome)
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.counts.writes += 1;
        self.counts.written += writes.len() as u64;
        for (channel, value) in writes {
            self.note(now, Entry::Write { channel: *channel, value: *value });
        }
        let outcome = self.inner.write(now, writes);
        self.outcome(now, outcome)
    }

    fn emit(&mut self, now: Time, channel: ChannelId, emission: &Emission) -> Result<(), BoardError> {
        self.counts.emissions += 1;
        self.note(now, Entry::Emit(channel));
        let outcome = self.inner.emit(now, channel, emission);
        self.outcome(now, outcome)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.counts.polls += 1;
        let before = out.len();
        let outcome = self.inner.poll(now, out);
        for event in out.iter().skip(before) {
            self.counts.events += 1;
            self.note(now, Entry::Event(*event));
        }
        self.outcome(now, outcome)
    }

    fn next_event(&self) -> Option<Time> {
        self.inner.next_event()
    }

    fn inject(&mut self, now: Time, fault: Fault) -> Result<(), BoardError> {
        self.counts.faults += 1;
        self.note(now, Entry::Inject(fault));
        let outcome = self.inner.inject(now, fault);
        self.outcome(now, outcome)
    }

    fn clear(&mut self, now: Time, channel: ChannelId) -> Result<(), BoardError> {
        self.counts.faults += 1;
        self.note(now, Entry::Clear(channel));
        let outcome = self.inner.clear(now, channel);
        self.outcome(now, outcome)
    }

    fn settle(&self, channel: ChannelId) -> Span {
        self.inner.settle(channel)
    }

    fn came(&self, channel: ChannelId) -> Option<When> {
        self.inner.came(channel)
    }

    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.note(now, Entry::Safe);
        let outcome = self.inner.safe(now);
        self.outcome(now, outcome)
    }

    fn held(&self) -> Result<Vec<HeldLines>, BoardError> {
        self.inner.held()
    }

    fn device(&self, channel: ChannelId) -> Option<&str> {
        self.inner.device(channel)
    }

    fn noise(&self, channel: ChannelId) -> Option<f64> {
        self.inner.noise(channel)
    }

    fn bus_device(&self, bus: BusId) -> Option<&str> {
        self.inner.bus_device(bus)
    }

    fn buses(&self) -> &[Bus] {
        self.inner.buses()
    }

    fn send(&mut self, now: Time, bus: BusId, frame: &Frame) -> Result<(), BoardError> {
        self.inner.send(now, bus, frame)
    }

    fn poll_buses(&mut self, now: Time, out: &mut Vec<BusEvent>) -> Result<(), BoardError> {
        self.inner.poll_buses(now, out)
    }

    fn health(&self) -> Health {
        self.inner.health()
    }
}
