use super::*;
use crate::config::InputConfig;
use profile::{BounceFilter, EventEdges, InputFilter, Profile};
use proptest::prelude::*;

/// Inputs of an M241 with these parameters of I`input`.
fn of(profile: Profile, input: usize, config: InputConfig) -> Inputs {
    let mut controller = Config::new(profile);
    controller.inputs = vec![InputConfig::default(); 14];
    controller.inputs[input] = config;
    controller.check().unwrap();
    let mut inputs = Inputs::new(&controller);
    inputs.power_on(Time::ZERO);
    inputs
}

fn filtered(input: usize, filter: InputFilter) -> Inputs {
    of(Profile::M241_2019, input, InputConfig::filtered(filter))
}

fn expert(latch: bool, event: Option<EventEdges>, bounce: i64) -> InputConfig {
    let bounce = BounceFilter::from_span(Span::from_micros(bounce)).unwrap();
    InputConfig { filter: InputFilter::None, latch, event, bounce }
}

fn us(n: i64) -> Time {
    Time::from_nanos(n * 1_000)
}

/// The level of the only input that is not at 0.
fn level(inputs: &mut Inputs, now: Time) -> bool {
    !inputs.levels(now).is_empty()
}

/// What the controller sees up to now.
fn taken(inputs: &mut Inputs) -> Vec<InputEvent> {
    (0..).map_while(|place| inputs.take(place)).collect()
}

// io:EIO-01, io:STD-IN-01
#[test]
fn a_clean_edge_is_late_by_delay_and_filter() {
    let mut inputs = filtered(8, InputFilter::Ms4);
    inputs.set(us(100), 8, Level::High);
    assert!(!level(&mut inputs, Time::from_nanos(4_149_999)));
    assert!(level(&mut inputs, Time::from_nanos(4_150_000)));
    inputs.set(us(10_000), 8, Level::Low);
    assert!(level(&mut inputs, Time::from_nanos(14_049_999)));
    assert!(!level(&mut inputs, Time::from_nanos(14_050_000)));
}

#[test]
fn short_pulses_never_appear_and_interrupted_ones_accumulate() {
    let mut inputs = filtered(0, InputFilter::Ms1);
    for k in 0..3 {
        inputs.set(us(2_000 * k), 0, Level::High);
        inputs.set(us(2_000 * k + 999), 0, Level::Low);
        assert!(!level(&mut inputs, us(2_000 * k + 1_999)));
    }
    // 600 up, 100 down, 500 up: the integrator is full at 600 - 100 + 500, 2 us late.
    inputs.set(us(10_000), 0, Level::High);
    inputs.set(us(10_600), 0, Level::HighZ);
    inputs.set(us(10_700), 0, Level::High);
    assert!(!level(&mut inputs, us(11_201)));
    assert!(level(&mut inputs, us(11_202)));
}

// io:EIO-02
#[test]
fn without_filter_only_the_own_delay_is_left() {
    let mut inputs = filtered(0, InputFilter::None);
    inputs.set(us(10), 0, Level::High);
    assert!(!level(&mut inputs, Time::from_nanos(11_999)));
    assert!(level(&mut inputs, us(12)));
    inputs.set(us(20), 0, Level::Low);
    inputs.set(us(21), 0, Level::High);
    assert!(level(&mut inputs, us(22)), "a gap shorter than the own delay");
}

#[test]
fn power_on_starts_from_zero() {
    let mut inputs = filtered(8, InputFilter::Ms4);
    inputs.set(us(0), 8, Level::High);
    assert!(level(&mut inputs, us(5_000)));
    inputs.power_on(us(6_000));
    assert!(!level(&mut inputs, us(6_000)));
    assert!(!level(&mut inputs, us(10_049)));
    assert!(level(&mut inputs, us(10_050)));
}

// io:EIO-11
#[test]
fn the_first_fall_of_an_input_that_was_on_before() {
    let both = expert(false, Some(EventEdges::Both), 5);
    for (profile, expected) in [(Profile::M241_2014, 3), (Profile::M241_2019, 2)] {
        let mut inputs = of(profile, 3, both);
        inputs.set(us(10), 3, Level::High);
        inputs.power_on(us(100));
        inputs.operate(us(200), true);
        for (at, level) in [(300, Level::Low), (400, Level::High), (500, Level::Low)] {
            inputs.set(us(at), 3, level);
            inputs.fire(us(at + 7));
        }
        assert_eq!(taken(&mut inputs), vec![InputEvent::Event(3); expected]);
        assert_eq!(inputs.show(3, InputProbe::Events), Value::Int(expected as i64));
    }
}

// io:STD-IN-04
#[test]
fn only_the_read_of_mast_empties_a_latch() {
    let mut inputs = of(Profile::M241_2019, 0, expert(true, None, 0));
    inputs.operate(us(1), true);
    for at in [10, 20] {
        inputs.set(us(at), 0, Level::High);
        inputs.set(us(at + 3), 0, Level::Low);
    }
    let (all, none, first) = (inputs.all(), ChannelSet::EMPTY, ChannelSet::of(0));
    assert_eq!(inputs.read(us(30), false), (none, all - first));
    assert_eq!(inputs.read(us(30), true), (first, all));
    assert_eq!(inputs.read(us(40), true), (none, all));
    // A latch that is not emptied in time is lost when the controller stops.
    inputs.set(us(50), 0, Level::High);
    inputs.set(us(53), 0, Level::Low);
    inputs.operate(us(60), false);
    inputs.operate(us(70), true);
    assert_eq!(inputs.read(us(80), true), (none, all));
}

// io:REF-03, controller:HW-03
#[test]
fn a_regular_input_that_is_driven_too_fast_is_reported_once() {
    for (profile, period) in [(Profile::M241_2014, 200), (Profile::M241_2019, 1_000)] {
        for (input, shorter, reports) in [(8, 0, 0), (8, 1, 1), (7, 1, 0)] {
            let mut inputs = of(profile, input, InputConfig::default());
            for k in 0..4 {
                inputs.set(us(k * (period - shorter)), input, Level::High);
                inputs.set(us(k * (period - shorter) + 60), input, Level::Low);
            }
            assert_eq!(taken(&mut inputs), vec![InputEvent::Overdriven(8); reports]);
        }
    }
}

/// A channel as it would be stepped, a microsecond at a time.
#[derive(Debug, Default)]
struct Stepped {
    delay: i64,
    /// Time of the filter, and whether it is the anti-bounce one.
    span: i64,
    bounce: bool,
    terminal: bool,
    differs: i64,
    inside: bool,
    /// The accumulator, or how long the level has been stable.
    sum: i64,
    out: bool,
    rises: i64,
    falls: i64,
}

impl Stepped {
    fn set(&mut self, terminal: bool) {
        if self.terminal != terminal {
            (self.terminal, self.differs) = (terminal, 0);
        }
    }

    /// What turns at this instant. The filter may reach its end just as the level behind the delay turns.
    fn advance(&mut self) {
        for turn in [false, true] {
            if turn && self.inside != self.terminal && self.differs >= self.delay {
                self.inside = self.terminal;
                if self.bounce {
                    self.sum = 0;
                }
            }
            let there = match (self.bounce, self.inside) {
                (true, _) | (false, true) => self.sum >= self.span,
                (false, false) => self.sum == 0,
            };
            if there && self.out != self.inside {
                self.out = self.inside;
                *(if self.out { &mut self.rises } else { &mut self.falls }) += 1;
            }
        }
    }

    fn pass(&mut self) {
        self.differs += 1;
        self.sum = match (self.bounce, self.inside) {
            (true, _) => self.sum + 1,
            (false, true) => (self.sum + 1).min(self.span),
            (false, false) => (self.sum - 1).max(0),
        };
    }
}

proptest! {
    /// The closed forms against a stepped channel, wherever they are looked at: integrating filter (io:STD-IN-01),
    /// anti-bounce filter (io:STD-IN-03), latch (io:STD-IN-04) and events on edges (io:EIO-10, io:EIO-13).
    #[test]
    fn equals_a_stepped_channel(
        gaps in proptest::collection::vec(prop_oneof![1i64..60, 1i64..1_500], 1..60),
        looks in proptest::collection::vec(any::<bool>(), 60),
        (input, config) in prop_oneof![
            (prop_oneof![Just(0usize), Just(8)], prop_oneof![Just(InputFilter::None), Just(InputFilter::Ms1), Just(InputFilter::Ms4)])
                .prop_map(|(input, filter)| (input, InputConfig::filtered(filter))),
            prop_oneof![Just(0i64), Just(1), Just(5), Just(50), Just(1_000)]
                .prop_map(|bounce| (3, expert(true, None, bounce))),
            (prop_oneof![Just(0i64), Just(2), Just(50)], prop_oneof![
                Just(EventEdges::Rising), Just(EventEdges::Falling), Just(EventEdges::Both)])
                .prop_map(|(bounce, edges)| (3, expert(false, Some(edges), bounce))),
        ],
    ) {
        let mut inputs = of(Profile::M241_2019, input, config);
        inputs.operate(us(0), true);
        let span = if config.is_expert() { config.bounce.span() } else { config.filter.span() };
        let mut stepped = Stepped {
            delay: if input < 8 { 2 } else { 50 },
            span: span.as_nanos() / 1_000,
            bounce: config.is_expert(),
            ..Stepped::default()
        };
        let (mut now, mut high, mut read) = (0i64, false, 0);
        for (k, gap) in gaps.iter().enumerate() {
            high = !high;
            inputs.set(us(now), input, Level::from_bool(high));
            stepped.set(high);
            for step in 0..=*gap {
                stepped.advance();
                if looks[k] || now % 7 == 0 {
                    prop_assert_eq!(level(&mut inputs, us(now)), stepped.out, "at {} us", now);
                }
                if config.latch && now % 997 == 0 {
                    let expected = stepped.out || stepped.rises > read;
                    prop_assert_eq!(!inputs.read(us(now), true).0.is_empty(), expected, "read at {} us", now);
                    read = stepped.rises;
                }
                if step < *gap {
                    stepped.pass();
                    now += 1;
                }
            }
        }
        inputs.levels(us(now));
        let rises = if config.event.is_some_and(|edges| edges.includes(true)) { stepped.rises } else { 0 };
        let falls = if config.event.is_some_and(|edges| edges.includes(false)) { stepped.falls } else { 0 };
        prop_assert_eq!(inputs.show(input, InputProbe::Events), Value::Int(rises + falls));
    }

    /// An input that is acted on is never seen to turn at another instant than the one that was foretold.
    #[test]
    fn turns_are_foretold(
        gaps in proptest::collection::vec(1i64..9_000, 1..40),
        filter in prop_oneof![Just(InputFilter::None), Just(InputFilter::Ms1), Just(InputFilter::Ms4)],
    ) {
        let mut inputs = filtered(8, filter);
        inputs.watch(8);
        let (mut now, mut high) = (Time::ZERO, false);
        for gap in gaps {
            high = !high;
            inputs.set(now, 8, Level::from_bool(high));
            let until = now + Span::from_micros(gap);
            while inputs.next() < until {
                let (due, before) = (inputs.next(), inputs.show(8, InputProbe::Filtered));
                inputs.levels(Time::from_nanos(due.as_nanos() - 1));
                prop_assert_eq!(inputs.show(8, InputProbe::Filtered), before);
                inputs.fire(due);
                prop_assert!(inputs.next() > due);
            }
            now = until;
        }
    }
}
