//! Counts of modelled lines: what a counter in hardware would have counted.

use signal::Value;

use super::line::Line;
use crate::channel::ChannelId;
use crate::circuit::TallySpec;
use crate::counting::{CountEdge, CountFunction};

/// The counts of a board.
#[derive(Debug)]
pub(super) struct Tallies(Vec<Tally>);

impl Tallies {
    pub(super) fn new(specs: &[TallySpec]) -> Tallies {
        Tallies(specs.iter().copied().map(Tally::new).collect())
    }

    /// Each begins at 0, its signals as they stand.
    pub(super) fn start(&mut self, lines: &mut [Line]) {
        for tally in &mut self.0 {
            tally.start(signals(&tally.spec, lines));
            let line = &mut lines[usize::from(tally.spec.channel.0)];
            (line.wanted, line.driven) = (tally.value(), tally.value());
            line.settle(tally.value());
        }
    }

    /// One of them looks at its signals, and its line reports what it has counted.
    pub(super) fn look(&mut self, place: usize, lines: &mut [Line]) {
        let tally = &mut self.0[place];
        let value = tally.see(signals(&tally.spec, lines));
        let line = &mut lines[usize::from(tally.spec.channel.0)];
        (line.wanted, line.driven) = (value, value);
    }
}

/// How the signals of a count stand.
fn signals(spec: &TallySpec, lines: &[Line]) -> (bool, bool) {
    let level = |channel: ChannelId| lines[usize::from(channel.0)].sense() == Value::Bool(true);
    (level(spec.a), spec.b.is_some_and(level))
}

/// A count at work. At each instant it sees how its signals stand when all has settled.
///
/// Where A and B change at one instant nobody knows which was first: of quadrature that is no count, as the two phases
/// never change together; elsewhere the direction is the new one.
#[derive(Clone, Copy, Debug)]
struct Tally {
    spec: TallySpec,
    signals: (bool, bool),
    total: i64,
}

impl Tally {
    fn new(spec: TallySpec) -> Tally {
        Tally { spec, signals: (false, false), total: 0 }
    }

    /// Begins at 0 with signals that stand like this.
    fn start(&mut self, signals: (bool, bool)) {
        (self.signals, self.total) = (signals, 0);
    }

    /// How far it has counted when its signals stand like this.
    fn see(&mut self, signals: (bool, bool)) -> Value {
        let before = std::mem::replace(&mut self.signals, signals);
        self.total = self.total.saturating_add(self.counts(before, signals));
        self.value()
    }

    /// How far it has counted.
    fn value(&self) -> Value {
        Value::Int(self.total)
    }

    fn counts(&self, before: (bool, bool), now: (bool, bool)) -> i64 {
        let rises = |before: bool, now: bool| now && !before;
        let (a_moved, b_moved) = (before.0 != now.0, before.1 != now.1);
        let single = match self.spec.edge {
            CountEdge::Rising => rises(before.0, now.0),
            CountEdge::Falling => rises(now.0, before.0),
            CountEdge::Both => a_moved,
        };
        let way = match (place(now) - place(before)).rem_euclid(4) {
            1 => 1,
            3 => -1,
            _ => 0,
        };
        // Of one count for each period forwards is reported by a rise, backwards by a fall: the same place of the shaft.
        let once = |before: bool, now: bool| if way > 0 { rises(before, now) } else { rises(now, before) };
        match self.spec.function {
            CountFunction::Increase => i64::from(single),
            CountFunction::Decrease => -i64::from(single),
            CountFunction::PulseDirection if rises(before.0, now.0) => {
                if now.1 {
                    -1
                } else {
                    1
                }
            }
            CountFunction::PulseDirection => 0,
            CountFunction::QuadratureX1 => way * i64::from(once(before.0, now.0)),
            CountFunction::QuadratureX1B => way * i64::from(once(before.1, now.1)),
            CountFunction::QuadratureX2 => way * i64::from(a_moved),
            CountFunction::QuadratureX2B => way * i64::from(b_moved),
            CountFunction::QuadratureX4 => way,
        }
    }
}

/// Where in its period a shaft stands whose A comes before B as it turns forwards.
fn place((a, b): (bool, bool)) -> i64 {
    match (a, b) {
        (false, false) => 0,
        (true, false) => 1,
        (true, true) => 2,
        (false, true) => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tally(function: CountFunction, edge: CountEdge) -> Tally {
        let spec =
            TallySpec { channel: ChannelId(2), a: ChannelId(0), b: Some(ChannelId(1)), function, edge };
        Tally::new(spec)
    }

    /// How far a count stands at a quarter of a period.
    type Places = fn(i64) -> i64;

    /// A and B of a shaft at a quarter of a period.
    fn turned(quarter: i64) -> (bool, bool) {
        ([1, 2].contains(&quarter.rem_euclid(4)), [2, 3].contains(&quarter.rem_euclid(4)))
    }

    proptest! {
        /// However a shaft turns, its count follows from where it stands, and never from how it came there.
        #[test]
        fn quadrature_tells_where_a_shaft_stands(
            start in 0i64..4,
            turns in prop::collection::vec(prop_oneof![Just(1i64), Just(-1)], 0..400),
        ) {
            // Places between two quarters at which a count changes: each, those at which A moves, and those at which A rises.
            let every = |quarter: i64| quarter;
            let of_a = |quarter: i64| (quarter + 1).div_euclid(2);
            let of_b = |quarter: i64| quarter.div_euclid(2);
            let rises_a = |quarter: i64| (quarter + 3).div_euclid(4);
            let rises_b = |quarter: i64| (quarter + 2).div_euclid(4);
            let all: [(CountFunction, Places); 5] = [
                (CountFunction::QuadratureX4, every),
                (CountFunction::QuadratureX2, of_a),
                (CountFunction::QuadratureX2B, of_b),
                (CountFunction::QuadratureX1, rises_a),
                (CountFunction::QuadratureX1B, rises_b),
            ];
            for (function, expected) in all {
                let mut tally = tally(function, CountEdge::Rising);
                tally.start(turned(start));
                let mut quarter = start;
                for turn in &turns {
                    quarter += turn;
                    let count = tally.see(turned(quarter));
                    prop_assert_eq!(count, Value::Int(expected(quarter) - expected(start)), "{:?}", function);
                }
            }
        }

        #[test]
        fn pulses_count_by_the_edge_that_is_asked_for(levels in prop::collection::vec(any::<(bool, bool)>(), 0..100)) {
            let runs = |function, edge| {
                let mut tally = tally(function, edge);
                tally.start((false, false));
                levels.iter().fold(Value::Int(0), |_, level| tally.see(*level))
            };
            let of_a: Vec<bool> = std::iter::once(false).chain(levels.iter().map(|level| level.0)).collect();
            let count = |from: bool, to: bool| {
                Value::Int(of_a.windows(2).filter(|pair| **pair == [from, to]).count() as i64)
            };
            prop_assert_eq!(runs(CountFunction::Increase, CountEdge::Rising), count(false, true));
            prop_assert_eq!(runs(CountFunction::Increase, CountEdge::Falling), count(true, false));
            let directed: i64 = of_a
                .windows(2)
                .zip(&levels)
                .filter(|(pair, _)| **pair == [false, true])
                .map(|(_, level)| if level.1 { -1 } else { 1 })
                .sum();
            prop_assert_eq!(runs(CountFunction::PulseDirection, CountEdge::Rising), Value::Int(directed));
        }
    }

    #[test]
    fn both_phases_at_once_are_no_count() {
        let mut tally = tally(CountFunction::QuadratureX4, CountEdge::Rising);
        tally.start((false, false));
        assert_eq!(tally.see((true, true)), Value::Int(0));
        assert_eq!(tally.see((false, true)), Value::Int(1));
    }
}
