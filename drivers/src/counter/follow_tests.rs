//! A count that is followed, against one that never wraps.

use host::{CounterEvent, CounterEventKind, HostInstant};
use proptest::prelude::*;
use signal::Span;

use super::spec::{CounterSpec, FindCount, FindCounter};
use super::{CountStep, CounterReading, Follower};
use crate::counting::CountFunction;

const PERIOD: i64 = 1_000_000;
/// Longer than anything here takes.
const LONG: Span = Span::from_secs(1_000);

fn at(nanos: i64) -> HostInstant {
    HostInstant::from_nanos(nanos)
}

fn spec(function: CountFunction, events: &[CounterEventKind], counts_hz: Option<u64>) -> CounterSpec {
    CounterSpec {
        name: "wheel".into(),
        place: 0..0,
        find: FindCounter::Name("wheel".into()),
        count: FindCount::Number(0),
        function: Some(function),
        edge: None,
        ceiling: None,
        period: Span::from_nanos(PERIOD),
        events: events.to_vec(),
        buffer: 1_024,
        counts_hz,
    }
}

/// A count at work: instants in ns at which it moved, each with the way.
struct Wheel {
    range: i64,
    first: i64,
    moves: Vec<(i64, i64)>,
    /// How far it has moved after each of them.
    sums: Vec<i64>,
}

impl Wheel {
    /// How far it has moved by an instant, from the instant 0.
    fn moved(&self, at: i64) -> i64 {
        let count = self.moves.partition_point(|(when, _)| *when <= at);
        count.checked_sub(1).map_or(0, |last| self.sums[last])
    }

    fn value(&self, at: i64) -> u64 {
        (self.first + self.moved(at)).rem_euclid(self.range) as u64
    }

    /// What it reports: events of each wrap or of each move, so much later than they happen.
    fn events(&self, each: bool, late: i64) -> Vec<CounterEvent> {
        let mut events = Vec::new();
        let mut position = self.first;
        for (moved, way) in &self.moves {
            let before = position.div_euclid(self.range);
            position += way;
            let count = self.value(moved + late);
            let mut told = |kind| events.push(CounterEvent { stamp: at(moved + late), count, kind });
            match position.div_euclid(self.range) - before {
                1 => told(CounterEventKind::Overflow),
                -1 => told(CounterEventKind::Underflow),
                _ => {}
            }
            if each {
                told(CounterEventKind::ChangeOfState);
            }
        }
        events
    }

    /// Follows it by readings at these instants, each of which takes a while, and by its events.
    fn follow(&self, follower: &mut Follower, readings: &[i64], events: &[CounterEvent]) -> Vec<CountStep> {
        let mut steps = Vec::new();
        let mut next = 0;
        for now in readings {
            let reading = CounterReading { before: at(*now), after: at(now + 60), value: self.value(*now) };
            let came = events[next..].iter().take_while(|event| event.stamp <= reading.after).count();
            follower.take(reading, &events[next..next + came], &mut |step| steps.push(step));
            next += came;
        }
        steps
    }

    /// Each step reports what was so at some instant of its interval, and the last one where the wheel stands.
    fn agrees(&self, steps: &[CountStep], follower: &Follower, end: i64) -> Result<(), TestCaseError> {
        let base = self.moved(follower.since().unwrap_or_default().as_nanos());
        for step in steps {
            prop_assert!(step.from <= step.to, "{step:?}");
            let (from, to) = (step.from.as_nanos(), step.to.as_nanos());
            let first = self.moves.partition_point(|(at, _)| *at < from);
            let within = self.moves[first..].iter().map(|(at, _)| *at).take_while(|at| *at <= to);
            let mut instants = within.chain([from, to]);
            prop_assert!(
                instants.any(|at| self.moved(at) - base == step.total),
                "{step:?} of {:?}",
                self.moves
            );
            prop_assert!(!step.doubtful, "{step:?}");
        }
        prop_assert!(steps.is_sorted_by_key(|step| step.to));
        let last = steps.last().map_or(0, |step| step.total);
        prop_assert_eq!(last, self.moved(end) - base);
        Ok(())
    }
}

/// Readings every period up to the end and some beyond, in which nothing moves any more.
fn readings(periods: i64) -> Vec<i64> {
    (1..periods + 4).map(|number| number * PERIOD).collect()
}

fn wheel(range: i64, first: i64, gaps: &[(i64, i64)]) -> Wheel {
    let (mut at, mut sum) = (0, 0);
    let (mut moves, mut sums) = (Vec::new(), Vec::new());
    for (gap, way) in gaps {
        at += gap;
        sum += way;
        moves.push((at, *way));
        sums.push(sum);
    }
    Wheel { range, first: first % range, moves, sums }
}

#[test]
fn a_wrap_stamped_while_a_reading_is_made_does_not_end_before_it() {
    let told = [CounterEventKind::Overflow];
    let mut follower = Follower::new(&spec(CountFunction::Increase, &told, None), 9, LONG, Span::ZERO);
    let wheel = wheel(10, 8, &[(3 * PERIOD + 500, 1), (PERIOD - 470, 1), (PERIOD, 1)]);
    let events = wheel.events(false, 0);
    assert!(events[0].stamp > at(4 * PERIOD) && events[0].stamp < at(4 * PERIOD + 60), "{events:?}");
    let steps = wheel.follow(&mut follower, &readings(4), &events);
    assert_eq!(steps.iter().map(|step| step.total).collect::<Vec<_>>(), [1, 2, 3]);
    assert!(steps.is_sorted_by_key(|step| step.to), "{steps:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn readings_alone_follow_both_ways_below_half_the_range(
        range in 9i64..40,
        first in 0i64..40,
        // At most four moves in a period, so that half of the least range is never reached.
        gaps in prop::collection::vec((250_001i64..900_000, prop_oneof![Just(1i64), Just(-1)]), 0..200),
    ) {
        let wheel = wheel(range, first, &gaps);
        let end = wheel.moves.last().map_or(0, |(at, _)| *at);
        let readings = readings(end / PERIOD + 1);
        let mut follower =
            Follower::new(&spec(CountFunction::QuadratureX4, &[], Some(4_000)), range as u64 - 1, LONG, Span::ZERO);
        let steps = wheel.follow(&mut follower, &readings, &[]);
        // What the file promises is exceeded by nobody here, but half the range is near: doubts are right.
        let sure: Vec<CountStep> = steps.iter().map(|step| CountStep { doubtful: false, ..*step }).collect();
        wheel.agrees(&sure, &follower, end)?;
    }

    #[test]
    fn one_way_may_take_nearly_the_whole_range(
        range in 5i64..40,
        first in 0i64..40,
        down in any::<bool>(),
        gaps in prop::collection::vec(250_001i64..900_000, 0..200),
    ) {
        let way = if down { -1 } else { 1 };
        let gaps: Vec<(i64, i64)> = gaps.into_iter().map(|gap| (gap, way)).collect();
        let wheel = wheel(range, first, &gaps);
        let end = wheel.moves.last().map_or(0, |(at, _)| *at);
        let readings = readings(end / PERIOD + 1);
        let function = if down { CountFunction::Decrease } else { CountFunction::Increase };
        let mut follower = Follower::new(&spec(function, &[], Some(3_000)), range as u64 - 1, LONG, Span::ZERO);
        let steps = wheel.follow(&mut follower, &readings, &[]);
        let sure: Vec<CountStep> = steps.iter().map(|step| CountStep { doubtful: false, ..*step }).collect();
        wheel.agrees(&sure, &follower, end)?;
    }

    #[test]
    fn wraps_that_are_told_make_any_speed_certain(
        range in 10i64..40,
        first in 0i64..40,
        gap in 2_000i64..50_000,
        count in 0usize..3_000,
        late in 0i64..1_000,
        down in any::<bool>(),
    ) {
        let way = if down { -1 } else { 1 };
        let wheel = wheel(range, first, &vec![(gap, way); count]);
        let end = wheel.moves.last().map_or(0, |(at, _)| *at);
        let readings = readings(end / PERIOD + 1);
        let function = if down { CountFunction::Decrease } else { CountFunction::Increase };
        let told = [CounterEventKind::Overflow, CounterEventKind::Underflow];
        let mut follower = Follower::new(&spec(function, &told, None), range as u64 - 1, LONG, Span::ZERO);
        let steps = wheel.follow(&mut follower, &readings, &wheel.events(false, late));
        wheel.agrees(&steps, &follower, end)?;
    }

    #[test]
    fn wraps_that_are_told_decide_both_ways(
        range in 9i64..40,
        first in 0i64..40,
        late in 0i64..1_000,
        gaps in prop::collection::vec((250_001i64..900_000, prop_oneof![Just(1i64), Just(-1)]), 0..200),
    ) {
        let wheel = wheel(range, first, &gaps);
        let end = wheel.moves.last().map_or(0, |(at, _)| *at);
        let readings = readings(end / PERIOD + 1);
        let told = [CounterEventKind::OverflowUnderflow];
        let mut follower = Follower::new(&spec(CountFunction::QuadratureX4, &told, None), range as u64 - 1, LONG, Span::ZERO);
        let events: Vec<CounterEvent> = wheel
            .events(false, late)
            .into_iter()
            .map(|event| CounterEvent { kind: CounterEventKind::OverflowUnderflow, ..event })
            .collect();
        let steps = wheel.follow(&mut follower, &readings, &events);
        wheel.agrees(&steps, &follower, end)?;
    }

    #[test]
    fn every_count_that_is_told_has_its_own_instant(
        range in 9i64..40,
        gaps in prop::collection::vec((2_000i64..900_000, prop_oneof![Just(1i64), Just(-1)]), 0..300),
    ) {
        let wheel = wheel(range, 0, &gaps);
        let end = wheel.moves.last().map_or(0, |(at, _)| *at);
        let readings = readings(end / PERIOD + 1);
        let told = [CounterEventKind::OverflowUnderflow, CounterEventKind::ChangeOfState];
        let mut follower =
            Follower::new(&spec(CountFunction::QuadratureX4, &told, None), range as u64 - 1, LONG, Span::from_nanos(100));
        let events: Vec<CounterEvent> = wheel
            .events(true, 50)
            .into_iter()
            .filter(|event| event.kind == CounterEventKind::ChangeOfState)
            .collect();
        let steps = wheel.follow(&mut follower, &readings, &events);
        // Wraps without an event of their own are told from the way that is the shorter one, as there is no other.
        if wheel.events(false, 0).is_empty() {
            wheel.agrees(&steps, &follower, end)?;
            prop_assert!(steps.iter().filter(|step| step.to - step.from <= Span::from_nanos(100)).count() + 3 >= steps.len());
        }
    }

    #[test]
    fn whatever_a_device_says_is_survived(
        ceiling in prop_oneof![Just(u64::MAX), Just(0), any::<u64>()],
        said in prop::collection::vec(
            (any::<i64>(), any::<u64>(), prop::collection::vec((any::<i64>(), any::<u64>(), 0usize..7), 0..4)),
            0..60,
        ),
        events in prop::sample::subsequence(CounterEventKind::ALL.to_vec(), 0..7),
    ) {
        let mut follower =
            Follower::new(&spec(CountFunction::PulseDirection, &events, Some(1)), ceiling, Span::from_nanos(PERIOD), Span::from_nanos(PERIOD));
        for (now, value, told) in said {
            let event = |(stamp, count, kind): &(i64, u64, usize)| CounterEvent {
                stamp: at(*stamp),
                count: *count,
                kind: CounterEventKind::ALL[*kind],
            };
            let told: Vec<CounterEvent> = told.iter().map(event).collect();
            follower.take(CounterReading { before: at(now), after: at(now), value }, &told, &mut |_| {});
        }
    }
}

#[test]
fn a_count_that_moves_faster_than_promised_is_told_as_doubtful() {
    let mut follower =
        Follower::new(&spec(CountFunction::Increase, &[], Some(1_000)), 9_999, LONG, Span::ZERO);
    let mut steps = Vec::new();
    let mut read = |now: i64, value: u64| {
        let reading = CounterReading { before: at(now), after: at(now), value };
        follower.take(reading, &[], &mut |step| steps.push((step.total, step.doubtful)));
    };
    read(0, 9_990);
    // Ten counts in 10 ms are as fast as was promised; one more may be of the nanosecond in which it began.
    read(10 * PERIOD, 1);
    read(20 * PERIOD, 100);
    assert_eq!(steps, [(11, false), (110, true)]);
}

#[test]
fn what_lies_too_far_apart_is_doubtful_though_nothing_moved() {
    let mut follower = Follower::new(
        &spec(CountFunction::QuadratureX4, &[], None),
        u64::MAX,
        Span::from_nanos(5 * PERIOD),
        Span::ZERO,
    );
    let mut doubts = 0;
    for periods in [0, 4, 8, 14] {
        let now = at(periods * PERIOD);
        let reading = CounterReading { before: now, after: now, value: 7 };
        follower.take(reading, &[], &mut |step| doubts += i32::from(step.doubtful));
    }
    assert_eq!(doubts, 1);
}

#[test]
fn the_first_reading_may_be_behind_a_wrap_that_is_told_later() {
    let told = [CounterEventKind::Overflow, CounterEventKind::Underflow];
    let mut follower = Follower::new(&spec(CountFunction::QuadratureX4, &told, None), 999, LONG, Span::ZERO);
    let overflow = |stamp, count| CounterEvent { stamp: at(stamp), count, kind: CounterEventKind::Overflow };
    let mut totals = Vec::new();
    let mut take = |now: i64, value: u64, events: &[CounterEvent]| {
        follower.take(CounterReading { before: at(now), after: at(now + 5), value }, events, &mut |step| {
            totals.push(step.total)
        });
        follower.since()
    };
    assert_eq!(take(1_000, 2, &[overflow(1_010, 3)]), None);
    assert_eq!(take(2_000, 10, &[]), Some(at(1_010)));
    take(3_000, 10, &[]);
    assert_eq!(totals, [7]);
}
