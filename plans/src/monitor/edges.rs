//! Edges out of changes, and the first edge after an instant.

use signal::Value;

use super::{TimedValue, Truth, UncertainInstant, ValueTest};

/// Which changes of a signal count.
#[derive(Clone, Debug, PartialEq)]
pub enum CountedEdge {
    /// A line becomes TRUE, a number grows.
    Rises,
    /// A line is TRUE no longer (FALSE or not driven), a number shrinks.
    Falls,
    /// The value becomes another.
    Changes,
    /// The value meets a condition that it did not meet before.
    Becomes(ValueTest),
}

impl CountedEdge {
    /// Whether the change from `old` to `new`, both clear, counts.
    #[inline]
    fn matches(&self, old: Value, new: Value, slack: f64) -> bool {
        match self {
            CountedEdge::Rises => grows(old, new),
            CountedEdge::Falls => grows(new, old),
            CountedEdge::Changes => old != new,
            CountedEdge::Becomes(test) => {
                test.holds(old, slack) == Truth::False && test.holds(new, slack) == Truth::True
            }
        }
    }

    /// Whether edges can hide while the signal is recorded as this: its value is not known well enough.
    fn is_open(&self, value: Value, slack: f64) -> bool {
        match self {
            _ if matches!(value, Value::Unknown) => true,
            CountedEdge::Becomes(test) => test.holds(value, slack) == Truth::Unknown,
            // Within a deadband, or within what it is uncertain by, a number may grow and shrink unseen.
            CountedEdge::Rises | CountedEdge::Falls | CountedEdge::Changes => {
                slack + value.uncertainty() > 0.0 && value.as_real().is_some()
            }
        }
    }

    /// The word for one in the past: `rose`.
    pub fn past(&self) -> &'static str {
        match self {
            CountedEdge::Rises => "rose",
            CountedEdge::Falls => "fell",
            CountedEdge::Changes => "changed",
            CountedEdge::Becomes(_) => "came",
        }
    }
}

#[inline]
fn grows(old: Value, new: Value) -> bool {
    let on = |value: Value| matches!(value, Value::Bool(true));
    match (old, new) {
        (Value::Bool(_) | Value::HighZ, _) | (_, Value::Bool(_) | Value::HighZ) => !on(old) && on(new),
        _ => match (old.as_int(), new.as_int()) {
            (Some(old), Some(new)) => new > old,
            _ => matches!((old.as_real(), new.as_real()), (Some(old), Some(new)) if new > old),
        },
    }
}

/// A place in the trace after all events.
pub(crate) const LAST: u64 = u64::MAX - 1;

/// A change that counts, or one that may be hidden in a stretch of which nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundEdge {
    /// When, and who.
    pub seen: TimedValue,
    /// `false` for an edge that may not exist.
    pub certain: bool,
}

/// Finds the edges of one kind in the events of one signal.
#[derive(Clone, Debug)]
pub struct EdgeFinder {
    edge: CountedEdge,
    slack: f64,
    last: Option<Value>,
    /// The earliest instant from which the value is not known, and its place in the trace.
    unknown_from: Option<(i64, u64)>,
    /// The value until then.
    before: Option<Value>,
}

impl EdgeFinder {
    /// Nothing is known of the signal before its first event.
    pub fn new(edge: CountedEdge, slack: f64) -> Self {
        EdgeFinder { edge, slack, last: None, unknown_from: Some((i64::MIN, 0)), before: None }
    }

    /// The kind of edge.
    pub fn edge(&self) -> &CountedEdge {
        &self.edge
    }

    /// The value after the last event, if it is known.
    pub fn value(&self) -> Option<Value> {
        self.last
    }

    /// The edge that this event makes.
    #[inline]
    pub fn see(&mut self, seen: &TimedValue) -> Option<FoundEdge> {
        // The common case first: a line that is known and stays known.
        if let (Value::Bool(new), Some(Value::Bool(old)), None) = (seen.value, self.last, self.unknown_from) {
            let counts = match self.edge {
                CountedEdge::Rises => Some(new && !old),
                CountedEdge::Falls => Some(old && !new),
                CountedEdge::Changes => Some(new != old),
                CountedEdge::Becomes(_) => None,
            };
            if let Some(counts) = counts {
                self.last = Some(seen.value);
                return counts.then_some(FoundEdge { seen: *seen, certain: true });
            }
        }
        if self.edge.is_open(seen.value, self.slack) {
            self.unknown_from.get_or_insert((seen.a, seen.place));
            self.before = self.last.take().or(self.before);
            return None;
        }
        let old = self.last.replace(seen.value);
        if let Some((a, since)) = self.unknown_from.take() {
            // A condition that held on neither side need not have been met, one that holds only after it was.
            let before = self.before.take().filter(|_| matches!(self.edge, CountedEdge::Becomes(_)));
            let certain = before.is_some_and(|old| self.edge.matches(old, seen.value, self.slack));
            return Some(FoundEdge { seen: TimedValue { a, since, ..*seen }, certain });
        }
        self.edge.matches(old?, seen.value, self.slack).then_some(FoundEdge { seen: *seen, certain: true })
    }

    /// The edge that may lie in an unknown stretch which lasts to the end.
    pub fn rest(&self) -> Option<FoundEdge> {
        let (a, since) = self.unknown_from?;
        let seen = TimedValue { a, b: i64::MAX, since, place: LAST, ..TimedValue::NOTHING };
        Some(FoundEdge { seen, certain: false })
    }
}

/// The first edge at or after an instant: is its delay within limits?
///
/// Each edge in turn is the first one in those placements that have the instant after the edge before it.
/// For each, the placements of the instant that make the delay right, too short or too long are intervals,
/// so that nothing needs to be enumerated.
#[derive(Clone, Debug)]
pub struct FirstEdge {
    from: UncertainInstant,
    least: i64,
    most: i64,
    /// The end of the case: an edge that may come after it need not be one of the case.
    end: i64,
    /// The earliest placement of the instant with all certain edges so far before it.
    left: i64,
    done: bool,
    can_hold: bool,
    can_be_early: bool,
    can_be_late: bool,
    /// Least and greatest delay of all placements so far.
    delay: Option<(i64, i64)>,
    /// The edge that is the first one, or may be.
    deciding: Option<FoundEdge>,
    doubtful: bool,
}

/// What the first edge came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// Some placement has it within the limits.
    pub can_hold: bool,
    /// Some placement has it before the limits.
    pub can_be_early: bool,
    /// Some placement has it after the limits.
    pub can_be_late: bool,
    /// Some placement has no edge at all.
    pub can_be_missing: bool,
    /// Least and greatest delay of the placements that have an edge, nanoseconds.
    pub delay: Option<(i64, i64)>,
    /// The first edge, or the first that may be it.
    pub deciding: Option<FoundEdge>,
    /// An edge may be hidden where nothing is known.
    pub doubtful: bool,
}

impl FirstEdge {
    /// The first edge at or after `from`, wanted `least` to `most` nanoseconds later, both included.
    pub fn new(from: UncertainInstant, least: i64, most: i64) -> Self {
        FirstEdge {
            from,
            least,
            most,
            end: i64::MAX,
            left: i64::MIN,
            done: false,
            can_hold: false,
            can_be_early: false,
            can_be_late: false,
            delay: None,
            deciding: None,
            doubtful: false,
        }
    }

    /// The same of a case with this end: an edge that may have come after it need not be one of the case.
    #[must_use]
    pub fn until(self, end: i64) -> FirstEdge {
        FirstEdge { end, ..self }
    }

    /// The next edge.
    #[inline]
    pub fn see(&mut self, found: &FoundEdge) {
        if self.done {
            return;
        }
        let found = &FoundEdge { certain: found.certain && found.seen.b <= self.end, ..*found };
        let seen = &found.seen;
        // The instants that have this edge as the first at or after them.
        let low = self.from.a.max(self.left);
        let high = self.from.b.min(seen.after(&self.from));
        if low <= high {
            let soonest = i64::from(seen.place < self.from.place);
            let least = self.least.max(soonest);
            let right = (low.max(seen.a.saturating_sub(self.most)), high.min(seen.b.saturating_sub(least)));
            self.can_hold |= least <= self.most && right.0 <= right.1;
            self.can_be_late |= low <= high.min(seen.b.saturating_sub(self.most).saturating_sub(1));
            self.can_be_early |=
                self.least > soonest && low.max(seen.a.saturating_sub(self.least).saturating_add(1)) <= high;
            self.doubtful |= !found.certain;
            let delay = (seen.a.saturating_sub(high).max(soonest), seen.b.saturating_sub(low));
            if found.certain {
                self.delay = Some(match self.delay {
                    Some(old) => (old.0.min(delay.0), old.1.max(delay.1)),
                    None => delay,
                });
            }
            if self.deciding.is_none_or(|old| found.certain && !old.certain) {
                self.deciding = Some(*found);
            }
        }
        if found.certain {
            self.left = self.left.max(seen.before(&self.from));
            self.done = self.left > self.from.b;
        }
    }

    /// Whether no placement can be right whatever comes, when nothing unseen lies before `now`.
    pub fn lost(&self, now: i64) -> bool {
        !self.can_hold && (self.done || now > self.from.b.saturating_add(self.most))
    }

    /// Whether later edges do not matter.
    pub fn is_done(&self) -> bool {
        self.done
    }

    /// The judgement when no edge comes any more.
    pub fn finish(&self) -> Delay {
        Delay {
            can_hold: self.can_hold,
            can_be_early: self.can_be_early,
            can_be_late: self.can_be_late,
            can_be_missing: !self.done && self.from.a.max(self.left) <= self.from.b,
            delay: self.delay,
            deciding: self.deciding,
            doubtful: self.doubtful,
        }
    }
}

impl Delay {
    /// Some placement is wrong.
    pub fn can_break(&self) -> bool {
        self.can_be_early || self.can_be_late || self.can_be_missing
    }
}
