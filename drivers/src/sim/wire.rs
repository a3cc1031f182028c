//! A wire at work: transport delay, inversion, bounce.

use std::collections::VecDeque;

use signal::{Span, Time, Value};

use crate::circuit::{Spacing, WireSpec};
use signal::Random;

/// A change of a wire's end to come.
#[derive(Clone, Copy, Debug)]
struct Change {
    due: Time,
    value: Value,
    /// Whether it is the change itself and no further edge of its bounce.
    is_first: bool,
}

/// A wire with what is on its way through it.
#[derive(Debug)]
pub(super) struct Wire {
    pub(super) spec: WireSpec,
    /// What its end drives now.
    pub(super) out: Value,
    /// Changes of its end to come, by their instants.
    pending: VecDeque<Change>,
    /// What its end will drive when all has arrived.
    settles_at: Value,
    random: Random,
    /// The drawn places of one bounce, kept to reuse its memory.
    places: Vec<i64>,
    lane: u64,
}

impl Wire {
    pub(super) fn new(spec: WireSpec, seed: u64, lane: u64) -> Self {
        Wire {
            spec,
            out: Value::HighZ,
            pending: VecDeque::new(),
            settles_at: Value::HighZ,
            random: Random::lane(seed, lane),
            places: Vec::new(),
            lane,
        }
    }

    /// Empty, with its draws from the beginning.
    pub(super) fn reset(&mut self, seed: u64) {
        self.out = Value::HighZ;
        self.settles_at = Value::HighZ;
        self.pending.clear();
        self.random = Random::lane(seed, self.lane);
    }

    /// What the end drives while the beginning has this value.
    pub(super) fn carry(&self, source: Value) -> Value {
        match (self.spec.invert, source) {
            (false, value) => value,
            (true, Value::Bool(level)) => Value::Bool(!level),
            (true, _) => Value::Bool(true),
        }
    }

    /// Lets the wire carry this value as if it had always done so.
    pub(super) fn settle(&mut self, source: Value) {
        self.out = self.carry(source);
        self.settles_at = self.out;
        self.pending.clear();
    }

    /// The beginning changed to `source` at `now`. Returns whether the end changed at once.
    pub(super) fn feed(&mut self, now: Time, source: Value) -> bool {
        let value = self.carry(source);
        if value == self.settles_at {
            return false;
        }
        let delay = self.spec.delay_to(value);
        let at = now.saturating_add(delay);
        self.settles_at = value;
        self.drop_overtaken(at);
        let before = self.pending.back().map_or(self.out, |last| last.value);
        // A pulse that was too short for its beginning to arrive: the contact never moved.
        if before == value {
            return false;
        }
        // The contact moves again: what is left of its last bounce does not come any more.
        if self.spec.bounce.is_some() {
            while self.pending.back().is_some_and(|last| last.due >= at) {
                self.pending.pop_back();
            }
        }
        let at_once = delay == Span::ZERO;
        let changed = at_once && self.out != value;
        if at_once {
            self.out = value;
        } else {
            self.pending.push_back(Change { due: at, value, is_first: true });
        }
        self.bounce(at, before, value);
        changed
    }

    /// Takes off changes, with their bounces, that would arrive at `at` or later: one after them arrives then.
    fn drop_overtaken(&mut self, at: Time) {
        if self.spec.off_delay.is_none() {
            return;
        }
        while let Some(place) = self.pending.iter().rposition(|change| change.is_first) {
            if self.pending[place].due < at {
                break;
            }
            self.pending.truncate(place);
        }
    }

    fn bounce(&mut self, at: Time, before: Value, value: Value) {
        let Some(bounce) = self.spec.bounce else { return };
        let (edges, over) = (i64::from(bounce.edges), bounce.over.as_nanos());
        self.places.clear();
        match bounce.spacing {
            Spacing::Even => self.places.extend((1..=edges).map(|edge| {
                // Through 128 bits: the product of two large factors.
                (i128::from(over) * i128::from(edge) / i128::from(edges)) as i64
            })),
            Spacing::Random => {
                // Drawn from a range that is short by the edges, then pulled apart by one nanosecond each.
                let free = Span::from_nanos(over - edges + 1);
                for _ in 0..edges {
                    self.places.push(self.random.span(free).as_nanos());
                }
                self.places.sort_unstable();
                for (edge, place) in self.places.iter_mut().enumerate() {
                    *place += edge as i64;
                }
            }
        }
        for (edge, place) in self.places.iter().enumerate() {
            let level = if edge % 2 == 0 { before } else { value };
            let due = at.saturating_add(Span::from_nanos(*place));
            self.pending.push_back(Change { due, value: level, is_first: false });
        }
    }

    /// When the end will next change.
    pub(super) fn next(&self) -> Option<Time> {
        self.pending.front().map(|change| change.due)
    }

    /// How many changes are on their way.
    pub(super) fn waiting(&self) -> usize {
        self.pending.len()
    }

    /// Lets arrive what is due at `now`. Returns whether the end changed.
    pub(super) fn arrive(&mut self, now: Time) -> bool {
        let before = self.out;
        while let Some(change) = self.pending.front().copied() {
            if change.due > now {
                break;
            }
            self.out = change.value;
            self.pending.pop_front();
        }
        before != self.out
    }
}
