//! An input as the functions see it: own delay and anti-bounce filter as a closed form.

use signal::{Span, Time};

/// What stands between the terminal of an input and the functions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputConditions {
    /// The input's own delay in each direction (io:STD-IN-02).
    pub delay: Span,
    /// Its anti-bounce filter (io:EIO-12, io:STD-IN-03).
    pub bounce: Span,
}

/// The way from a terminal to the functions, the same as that to the image (io:EIO-12).
///
/// The own delay is inertial: a level counts behind it once it has lasted that long, so that a shorter pulse is not
/// seen there at all. The anti-bounce filter accepts a level once it has been stable behind the own delay for the
/// bounce time (io:STD-IN-03). Only instants at which a level is accepted are reported; what happens between the two stages
/// is caught up when somebody looks.
#[derive(Clone, Debug)]
pub(crate) struct Filter {
    delay: Span,
    bounce: Span,
    terminal: bool,
    /// Level behind the own delay, as far as it was caught up.
    inside: bool,
    accepted: bool,
    /// When `inside` takes the terminal's level, where they differ.
    follows: Time,
    /// When `inside` changed last.
    since: Time,
    /// When `accepted` changes; [`Time::MAX`] for never.
    due: Time,
}

impl Filter {
    /// A filter at rest at 0.
    pub fn new(conditions: &InputConditions) -> Filter {
        Filter {
            delay: conditions.delay,
            bounce: conditions.bounce,
            terminal: false,
            inside: false,
            accepted: false,
            follows: Time::MAX,
            since: Time::MIN,
            due: Time::MAX,
        }
    }

    /// The level at the terminal from `at` on; whatever was due up to `at` has been accepted. Returns whether a pulse is
    /// now known to have been too short.
    #[inline]
    pub fn set(&mut self, at: Time, high: bool) -> bool {
        if self.terminal == high {
            return false;
        }
        let mut suppressed = self.inside != self.terminal;
        if suppressed && self.follows <= at {
            // What was inside lasted for the own delay, if not for the bounce time.
            suppressed = self.inside != self.accepted;
            self.follow();
        }
        self.terminal = high;
        self.follows = at.saturating_add(self.delay);
        self.schedule();
        suppressed
    }

    /// The level behind the own delay becomes that of the terminal.
    #[inline]
    fn follow(&mut self) {
        self.inside = self.terminal;
        self.since = self.follows;
    }

    /// Works out when a level is accepted next if the terminal stays as it is.
    #[inline]
    fn schedule(&mut self) {
        let follows = if self.inside == self.terminal { Time::MAX } else { self.follows };
        let turns = self.since.saturating_add(self.bounce);
        self.due = if self.inside != self.accepted && turns <= follows {
            turns
        } else if follows != Time::MAX && self.terminal != self.accepted {
            follows.saturating_add(self.bounce)
        } else {
            Time::MAX
        };
    }

    /// When it accepts the terminal's level; [`Time::MAX`] for never.
    #[inline]
    pub const fn next(&self) -> Time {
        self.due
    }

    /// The level that it accepts at `at`, if it does; `at` is not after [`Filter::next`].
    #[inline]
    pub fn accept(&mut self, at: Time) -> Option<bool> {
        if self.due > at {
            return None;
        }
        self.accepted = !self.accepted;
        if self.inside != self.terminal && self.follows <= at {
            self.follow();
        }
        self.schedule();
        Some(self.accepted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Changes that last for `span`, reported when they have: what either stage does, said in another way.
    fn lasting(changes: &[(i64, bool)], span: i64) -> Vec<(i64, bool)> {
        let mut accepted = Vec::new();
        let mut level = false;
        for (place, (from, high)) in changes.iter().enumerate() {
            let to = changes.get(place + 1).map_or(i64::MAX, |(next, _)| *next);
            if to - from >= span && *high != level {
                level = *high;
                accepted.push((from + span, level));
            }
        }
        accepted
    }

    fn levels(gaps: &[i64]) -> Vec<(i64, bool)> {
        let mut at = 0;
        let mut high = false;
        gaps.iter()
            .map(|gap| {
                (at, high) = (at + gap, !high);
                (at, high)
            })
            .collect()
    }

    fn filtered(changes: &[(i64, bool)], delay: i64, bounce: i64) -> Vec<(i64, bool)> {
        let (delay, bounce) = (Span::from_nanos(delay), Span::from_nanos(bounce));
        let mut filter = Filter::new(&InputConditions { delay, bounce });
        let mut accepted = Vec::new();
        let mut settle = |filter: &mut Filter, to: Time| {
            while filter.next() <= to {
                let at = filter.next();
                accepted.extend(filter.accept(at).map(|high| (at.as_nanos(), high)));
            }
        };
        for (at, high) in changes {
            let at = Time::from_nanos(*at);
            settle(&mut filter, at);
            filter.set(at, *high);
            settle(&mut filter, at);
        }
        settle(&mut filter, Time::from_nanos(i64::MAX - 1));
        accepted
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        // io:EIO-12, io:STD-IN-03
        #[test]
        fn equals_two_stages(
            gaps in proptest::collection::vec(1_i64..12, 0..24),
            delay in 0_i64..6,
            bounce in 0_i64..10,
        ) {
            let changes = levels(&gaps);
            let inside = lasting(&changes, delay);
            prop_assert_eq!(filtered(&changes, delay, bounce), lasting(&inside, bounce));
        }
    }

    // A pulse shorter than the own delay does not begin the bounce time again: the sum of both times would.
    #[test]
    fn a_short_pulse_is_not_seen_behind_the_own_delay() {
        let changes = [(0, true), (6, false), (7, true)];
        assert_eq!(filtered(&changes, 2, 10), [(12, true)]);
    }
}
