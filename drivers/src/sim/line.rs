//! A line at work: what its drivers make of it, what faults make of that, what is seen of it.

use std::collections::VecDeque;

use signal::{Span, Time, Value};

use crate::channel::{Fault, FaultKind};
use crate::circuit::Pull;
use crate::event::Origin;

/// The most faults that one channel can have at once.
pub const MAX_FAULTS: u8 = 8;

#[derive(Clone, Copy, Debug)]
struct Active {
    kind: FaultKind,
    until: Option<Time>,
}

/// A channel's line.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) digital: bool,
    pull: Pull,
    /// What writes want the channel to drive.
    pub(super) wanted: Value,
    /// What it drives: what was wanted last while its device was there.
    pub(super) driven: Value,
    /// The outcome of all drivers.
    raw: Value,
    /// The outcome once late changes have arrived.
    base: Value,
    /// Late changes to come.
    late: VecDeque<(Time, Value)>,
    /// What wires and plants get: the base under the faults.
    pub(super) level: Value,
    /// What is seen of it.
    pub(super) seen: Value,
    faults: Vec<Active>,
    /// Two drivers pull both ways.
    pub(super) contended: bool,
    /// Who touched it last.
    pub(super) origin: Origin,
}

impl Line {
    pub(super) fn new(digital: bool, pull: Pull) -> Self {
        Line {
            digital,
            pull,
            wanted: Value::HighZ,
            driven: Value::HighZ,
            raw: Value::HighZ,
            base: Value::HighZ,
            late: VecDeque::new(),
            level: Value::HighZ,
            seen: Value::HighZ,
            faults: Vec::with_capacity(usize::from(MAX_FAULTS)),
            contended: false,
            origin: Origin::Write,
        }
    }

    /// As new, driven to `value`.
    pub(super) fn reset(&mut self, value: Value) {
        let faults = std::mem::take(&mut self.faults);
        *self = Line { faults, ..Line::new(self.digital, self.pull) };
        self.faults.clear();
        self.wanted = value;
        self.driven = value;
    }

    /// Takes the outcome of the drivers over without any delay: at the start.
    pub(super) fn settle(&mut self, raw: Value) {
        self.raw = raw;
        self.base = raw;
        self.level = raw;
        self.seen = self.sense();
    }

    /// Whether its level is the outcome of its drivers: no fault is on it, and no late change to come.
    #[inline]
    pub(super) fn is_plain(&self) -> bool {
        self.faults.is_empty() && self.late.is_empty()
    }

    /// Takes the outcome of the drivers of a line that is plain. Returns whether the level changed.
    #[inline]
    pub(super) fn follow(&mut self, raw: Value) -> bool {
        (self.raw, self.base) = (raw, raw);
        std::mem::replace(&mut self.level, raw) != raw
    }

    /// Takes the outcome of the drivers. Returns whether the level changed.
    pub(super) fn update(&mut self, now: Time, raw: Value) -> bool {
        if raw != self.raw {
            self.raw = raw;
            if let Some(delay) = self.delay() {
                let newest = self.late.back().map_or(now, |(due, _)| *due);
                self.late.push_back((now.saturating_add(delay).max(newest), raw));
            }
        }
        if self.delay().is_none() {
            self.late.clear();
            self.base = raw;
        }
        let level = self.faulted();
        let changed = level != self.level;
        self.level = level;
        changed
    }

    /// The line's level by its drivers, in arguments, and whether they pull both ways: a driven 1 wins over a
    /// driven 0, as with outputs that source; a write wins over other sources of a value.
    pub(super) fn resolve(&self, others: impl Iterator<Item = Value>) -> (Value, bool) {
        let (mut value, mut contended) = (self.driven, false);
        for other in others {
            match (value, other) {
                (_, Value::HighZ) => {}
                (Value::HighZ, other) => value = other,
                (Value::Bool(a), Value::Bool(b)) => {
                    contended |= a != b;
                    value = Value::Bool(a | b);
                }
                _ => {}
            }
        }
        (value, contended)
    }

    fn delay(&self) -> Option<Span> {
        self.faults.iter().rev().find_map(|fault| match fault.kind {
            FaultKind::Late(delay) => Some(delay),
            _ => None,
        })
    }

    fn faulted(&self) -> Value {
        self.faults.iter().fold(self.base, |level, fault| match fault.kind {
            FaultKind::StuckAt(value) | FaultKind::Glitch { value, .. } => value,
            FaultKind::Open => Value::HighZ,
            FaultKind::ShortToGround if self.digital => Value::Bool(false),
            FaultKind::ShortToGround => Value::Real(0.0),
            FaultKind::ShortToSupply => Value::Bool(true),
            FaultKind::Late(_) | FaultKind::Lost => level,
        })
    }

    /// What a device on the line reads.
    pub(super) fn sense(&self) -> Value {
        match (self.level, self.digital, self.pull) {
            (Value::HighZ, true, Pull::Up) => Value::Bool(true),
            (Value::HighZ, true, Pull::Down) => Value::Bool(false),
            (Value::HighZ, false, Pull::Up | Pull::Down) => Value::Real(0.0),
            (level, ..) => level,
        }
    }

    pub(super) fn is_lost(&self) -> bool {
        self.faults.iter().any(|fault| fault.kind == FaultKind::Lost)
    }

    pub(super) fn has_faults(&self) -> bool {
        !self.faults.is_empty()
    }

    /// Adds a fault whose times were checked; false: there are as many as can be.
    pub(super) fn inject(&mut self, fault: Fault, until: Option<Time>) -> bool {
        if self.faults.len() >= usize::from(MAX_FAULTS) {
            return false;
        }
        self.faults.push(Active { kind: fault.kind, until });
        true
    }

    /// Ends all faults.
    pub(super) fn clear(&mut self) {
        self.faults.clear();
    }

    /// When the line will next change by itself: a fault ends, a late change arrives.
    pub(super) fn next(&self) -> Option<Time> {
        let ends = self.faults.iter().filter_map(|fault| fault.until);
        ends.chain(self.late.front().map(|(due, _)| *due)).min()
    }

    /// How many changes are on their way.
    pub(super) fn waiting(&self) -> usize {
        self.late.len()
    }

    /// Lets happen what is due at `now`. Returns whether anything was.
    pub(super) fn pass(&mut self, now: Time) -> bool {
        let before = self.faults.len();
        self.faults.retain(|fault| fault.until.is_none_or(|until| until > now));
        let ended = self.faults.len() != before;
        if ended {
            self.origin = Origin::Fault;
        }
        let mut arrived = false;
        while let Some((due, value)) = self.late.front().copied() {
            if due > now {
                break;
            }
            self.base = value;
            self.late.pop_front();
            arrived = true;
        }
        ended || arrived
    }
}
