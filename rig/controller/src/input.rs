//! Digital inputs: own delay and integrating filter as closed forms, evaluated only when somebody looks.

use profile::Filter;
use signal::{Level, Span, Time};

/// The channel model of one input.
///
/// The own delay is inertial: a level counts once it has lasted that long. Behind it stands the integrator of
/// io:STD-IN-01, an accumulator that rises and falls by one nanosecond each nanosecond between 0 and the filter time.
#[derive(Clone, Debug)]
struct Channel {
    delay: Span,
    filter: i64,
    /// Level at the terminal.
    terminal: bool,
    /// Level behind the own delay.
    inside: bool,
    /// When `inside` takes the terminal's level, where they differ.
    follows: Time,
    /// The integrator at `at`, 0...filter nanoseconds.
    sum: i64,
    at: Time,
    /// The filtered level at `at`.
    out: bool,
}

impl Channel {
    /// Brings the channel to `now`.
    fn settle(&mut self, now: Time) {
        if self.inside != self.terminal && self.follows <= now {
            self.integrate(self.follows);
            self.inside = self.terminal;
        }
        self.integrate(now);
    }

    fn integrate(&mut self, to: Time) {
        let passed = to.as_nanos().saturating_sub(self.at.as_nanos()).max(0);
        self.at = self.at.max(to);
        if self.inside {
            self.sum = self.sum.saturating_add(passed).min(self.filter);
            self.out |= self.sum == self.filter;
        } else {
            self.sum = (self.sum - passed).max(0);
            self.out &= self.sum != 0;
        }
    }

    /// Whether its output can change without a change at the terminal.
    fn moves(&self) -> bool {
        self.inside != self.terminal
            || self.out != self.inside
            || self.sum != if self.inside { self.filter } else { 0 }
    }
}

/// All embedded inputs.
#[derive(Clone, Debug)]
pub(crate) struct Inputs {
    channels: Vec<Channel>,
    /// Filtered levels, bit n for In.
    filtered: u32,
    /// Channels that have to be evaluated.
    moving: u32,
}

impl Inputs {
    /// Inputs with these own delays and filters.
    pub(crate) fn new(channels: impl Iterator<Item = (Span, Filter)>) -> Inputs {
        let channels = channels
            .map(|(delay, filter)| Channel {
                delay,
                filter: filter.span().as_nanos(),
                terminal: false,
                inside: false,
                follows: Time::MAX,
                sum: 0,
                at: Time::MIN,
                out: false,
            })
            .collect();
        Inputs { channels, filtered: 0, moving: 0 }
    }

    /// A 1 for every input.
    pub(crate) fn mask(&self) -> u32 {
        ((1u64 << self.channels.len()) - 1) as u32
    }

    /// The inputs' electronics come up at `now`: everything behind the terminals starts from 0.
    pub(crate) fn power_on(&mut self, now: Time) {
        (self.filtered, self.moving) = (0, 0);
        for (n, channel) in self.channels.iter_mut().enumerate() {
            (channel.inside, channel.sum, channel.out) = (false, 0, false);
            channel.at = now;
            channel.follows = now.saturating_add(channel.delay);
            self.moving |= u32::from(channel.terminal) << n;
        }
    }

    /// The level at a terminal from `now` on. Numbers beyond the reference's inputs are ignored.
    pub(crate) fn set(&mut self, now: Time, input: usize, level: Level) {
        let Some(channel) = self.channels.get_mut(input) else { return };
        // At rest the integrator stands at its end, so the time since then adds nothing.
        channel.settle(now);
        let high = level.is_high();
        if channel.terminal != high {
            channel.terminal = high;
            channel.follows = now.saturating_add(channel.delay);
        }
        self.filtered = self.filtered & !(1 << input) | u32::from(channel.out) << input;
        self.moving |= 1 << input;
    }

    /// The filtered levels at `now`, bit n for In.
    #[inline]
    pub(crate) fn levels(&mut self, now: Time) -> u32 {
        if self.moving != 0 {
            self.evaluate(now);
        }
        self.filtered
    }

    fn evaluate(&mut self, now: Time) {
        let mut left = self.moving;
        while left != 0 {
            let n = left.trailing_zeros();
            left &= left - 1;
            let channel = &mut self.channels[n as usize];
            channel.settle(now);
            self.filtered = self.filtered & !(1 << n) | u32::from(channel.out) << n;
            if !channel.moves() {
                self.moving &= !(1 << n);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn one(delay: i64, filter: Filter) -> Inputs {
        let mut inputs = Inputs::new(std::iter::once((Span::from_micros(delay), filter)));
        inputs.power_on(Time::ZERO);
        inputs
    }

    fn us(n: i64) -> Time {
        Time::from_nanos(n * 1_000)
    }

    // io:EIO-01, io:STD-IN-01
    #[test]
    fn a_clean_edge_is_late_by_delay_and_filter() {
        let mut inputs = one(50, Filter::Ms4);
        inputs.set(us(100), 0, Level::High);
        assert_eq!(inputs.levels(Time::from_nanos(4_149_999)), 0);
        assert_eq!(inputs.levels(Time::from_nanos(4_150_000)), 1);
        inputs.set(us(10_000), 0, Level::Low);
        assert_eq!(inputs.levels(Time::from_nanos(14_049_999)), 1);
        assert_eq!(inputs.levels(Time::from_nanos(14_050_000)), 0);
    }

    #[test]
    fn short_pulses_never_appear_and_interrupted_ones_accumulate() {
        let mut inputs = one(0, Filter::Ms1);
        for k in 0..3 {
            inputs.set(us(2_000 * k), 0, Level::High);
            inputs.set(us(2_000 * k + 999), 0, Level::Low);
            assert_eq!(inputs.levels(us(2_000 * k + 1_999)), 0);
        }
        // 600 up, 100 down, 500 up: the integrator is full at 600 - 100 + 500.
        inputs.set(us(10_000), 0, Level::High);
        inputs.set(us(10_600), 0, Level::HighZ);
        inputs.set(us(10_700), 0, Level::High);
        assert_eq!(inputs.levels(us(11_199)), 0);
        assert_eq!(inputs.levels(us(11_200)), 1);
    }

    // io:EIO-02
    #[test]
    fn without_filter_only_the_own_delay_is_left() {
        let mut inputs = one(2, Filter::None);
        inputs.set(us(10), 0, Level::High);
        assert_eq!(inputs.levels(Time::from_nanos(11_999)), 0);
        assert_eq!(inputs.levels(us(12)), 1);
        inputs.set(us(20), 0, Level::Low);
        inputs.set(us(21), 0, Level::High);
        assert_eq!(inputs.levels(us(22)), 1, "a gap shorter than the own delay");
    }

    #[test]
    fn power_on_starts_from_zero() {
        let mut inputs = one(50, Filter::Ms4);
        inputs.set(us(0), 0, Level::High);
        assert_eq!(inputs.levels(us(5_000)), 1);
        inputs.power_on(us(6_000));
        assert_eq!(inputs.levels(us(6_000)), 0);
        assert_eq!(inputs.levels(us(10_049)), 0);
        assert_eq!(inputs.levels(us(10_050)), 1);
    }

    proptest! {
        /// The closed form against an integrator stepped every microsecond, wherever it is looked at.
        #[test]
        fn equals_a_stepped_integrator(
            gaps in proptest::collection::vec(1i64..1_500, 1..60),
            looks in proptest::collection::vec(any::<bool>(), 60),
            delay in prop_oneof![Just(0i64), Just(2), Just(50)],
            filter in prop_oneof![Just(Filter::None), Just(Filter::Ms1), Just(Filter::Ms4)],
        ) {
            let mut inputs = one(delay, filter);
            let span = filter.span().as_nanos() / 1_000;
            let (mut now, mut terminal) = (0i64, false);
            let (mut inside, mut sum, mut out) = (false, 0i64, false);
            for (k, gap) in gaps.iter().enumerate() {
                terminal = !terminal;
                inputs.set(us(now), 0, Level::from_bool(terminal));
                for differs in 0..=*gap {
                    // The integrator may reach its end just as the level behind the delay turns; then 1 us passes.
                    for turn in [false, true] {
                        if turn && inside != terminal && differs >= delay {
                            inside = terminal;
                        }
                        if inside && sum == span { out = true }
                        if !inside && sum == 0 { out = false }
                    }
                    if looks[k] || now % 7 == 0 {
                        prop_assert_eq!(inputs.levels(us(now)) == 1, out, "at {} us", now);
                    }
                    if differs == *gap { break }
                    sum = if inside { (sum + 1).min(span) } else { (sum - 1).max(0) };
                    now += 1;
                }
            }
        }
    }
}
