//! Stretches at a level out of changes: the pulses of a signal.

use super::edges::LAST;
use super::pulses::Pulse;
use super::{TimedValue, Truth, ValueTest};

/// Finds the pulses of one level in the events of one signal.
#[derive(Clone, Debug)]
pub struct PulseFinder {
    test: ValueTest,
    slack: f64,
    /// The beginning of the stretch that is open, and whether it is a pulse.
    open: Option<(TimedValue, Truth)>,
    /// The open pulse has a known beginning.
    clean: bool,
}

impl PulseFinder {
    /// Pulses are high, or low. Nothing is known of the signal before its first event.
    pub fn new(high: bool, slack: f64) -> PulseFinder {
        let test = ValueTest::bool(high);
        PulseFinder { test, slack, open: Some((TimedValue::NOTHING, Truth::Unknown)), clean: true }
    }

    /// The pulse that ends with this event.
    #[inline]
    pub fn see(&mut self, seen: &TimedValue) -> Option<Pulse> {
        let class = self.test.holds(seen.value, self.slack);
        let Some((start, open)) = self.open else {
            self.open = (class != Truth::False).then_some((*seen, class));
            return None;
        };
        match (open, class) {
            (Truth::True, Truth::False) => {
                self.open = None;
                let certain = std::mem::replace(&mut self.clean, true);
                Some(Pulse { start, end: (seen.a, seen.b), certain })
            }
            // It ends, or goes on, where nothing is known.
            (Truth::True, Truth::Unknown) => {
                self.open = Some((start, Truth::Unknown));
                None
            }
            (Truth::Unknown, Truth::True | Truth::False) => {
                // There can be any pulse in an unknown stretch, and one that is there after it can have begun
                // anywhere in it.
                let begun = TimedValue { a: start.a, since: start.since, ..*seen };
                self.clean = class == Truth::False;
                self.open = (class == Truth::True).then_some((begun, Truth::True));
                Some(Pulse { start: begun, end: (start.a, seen.b), certain: false })
            }
            _ => None,
        }
    }

    /// The pulse that lasts at least to the end of the case.
    pub fn rest(&mut self, end: i64) -> Option<Pulse> {
        let (start, class) = self.open.take()?;
        Some(match class {
            Truth::True => Pulse { start, end: (end.max(start.a), i64::MAX), certain: self.clean },
            _ => {
                let start = TimedValue { b: i64::MAX, place: LAST, ..start };
                Pulse { start, end: (start.a, i64::MAX), certain: false }
            }
        })
    }
}
