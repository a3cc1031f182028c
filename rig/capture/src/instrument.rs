//! What an instrument says of the errors of its clock and its channels, and what follows for the instants of a capture.
//!
//! Every instant gets wider by all that its stamp may be off, rounded outwards: the instant itself lies within it.

use crate::{Capture, Knowledge};
use signal::{Span, Time, When};
use std::collections::BTreeMap;

/// The greatest relative error of a clock, in parts of 10^12: 10 %. Beyond it there is no clock.
pub const MAX_RATE_ERROR: u64 = PARTS / 10;

/// The parts that a relative error is counted in.
const PARTS: u64 = 1_000_000_000_000;

/// The errors of an instrument. By default it has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstrumentErrors {
    /// Those of its clock.
    pub timebase: TimebaseErrors,
    /// Those of its channels, by the name that the capture has for them.
    pub channels: BTreeMap<String, ChannelErrors>,
}

/// The errors of a clock that all channels are stamped by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TimebaseErrors {
    /// How far the clock may be off, as a part of the time that it shows, in parts of 10^12 (25 ppm is 25 000 000); at
    /// most [`MAX_RATE_ERROR`].
    pub rate: u64,
    /// What is subtracted from each stamp, so that it counts from the instant that a user names by a time.
    pub offset: Span,
    /// How far the offset may be off, either way; at least 0.
    pub offset_error: Span,
    /// The step of the stamps: an instant is known to within one before and one after its stamp; at least 0.
    pub resolution: Span,
    /// The greatest distance between the stamps that two channels give one instant; at least 0.
    pub skew: Span,
}

/// The errors of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChannelErrors {
    /// How much later than the instant its stamp is: subtracted from each stamp.
    pub delay: Span,
    /// How far the delay may be off, either way; at least 0.
    pub delay_error: Span,
}

impl TimebaseErrors {
    /// An instant that the user names by a time of the capture: no stamp, so that only the offset may be off.
    pub fn named(&self, at: Time) -> When {
        widened(When::exactly(at), self.offset_error.as_nanos())
    }

    /// An instant as it may lie when the clock is off since `reference`, which itself may be anywhere in its interval.
    pub fn drifted(&self, at: When, reference: When) -> When {
        drifted(at, reference, self.rate)
    }
}

impl Capture {
    /// Takes offset and delays out of the instants, and widens them by what does not grow with the time: the step of the
    /// stamps, the skew between channels, what is not known of the delays.
    pub fn correct(&mut self, errors: &InstrumentErrors) {
        let TimebaseErrors { offset, resolution, skew, .. } = errors.timebase;
        // Two channels that are each off by half of it, either way, are at most the skew apart.
        let common = resolution.as_nanos().saturating_add(skew.as_nanos().saturating_add(1) / 2);
        let of_channel = |name: &str| errors.channels.get(name).copied().unwrap_or_default();
        let moves: Vec<(Span, i64)> = self
            .channels
            .iter()
            .map(|channel| {
                let ChannelErrors { delay, delay_error } = of_channel(&channel.name);
                let late = Span::from_nanos(offset.as_nanos().saturating_add(delay.as_nanos()));
                (late, common.saturating_add(delay_error.as_nanos()))
            })
            .collect();
        let moved = |at: When, (late, by): (Span, i64)| {
            let earlier = Span::from_nanos(late.as_nanos().saturating_neg());
            let at = When::within(at.earliest.saturating_add(earlier), at.latest.saturating_add(earlier));
            widened(at, by)
        };
        for change in &mut self.changes {
            if let Some(own) = moves.get(change.channel as usize) {
                change.at = moved(change.at, *own);
            }
        }
        let ends = moves.iter().map(|own| moved(self.end, *own));
        let both = |a: When, b: When| When::within(a.earliest.min(b.earliest), a.latest.max(b.latest));
        self.end = ends.reduce(both).unwrap_or(self.end);
        let earlier = Span::from_nanos(offset.as_nanos().saturating_neg());
        self.span = self.span.map(|at| at.saturating_add(earlier));
        if let Knowledge::Edges(known) = &mut self.knowledge {
            *known = Span::from_nanos(known.as_nanos().saturating_add(resolution.as_nanos()));
        }
        self.sort();
    }

    /// Widens the instants by what the clock may be off since `reference`, the instant that the case is laid at.
    pub fn widen_by_rate(&mut self, reference: When, rate: u64) {
        if rate == 0 {
            return;
        }
        for change in &mut self.changes {
            change.at = drifted(change.at, reference, rate);
        }
        self.end = drifted(self.end, reference, rate);
        if let Knowledge::Sampled(period) = &mut self.knowledge {
            let longer = drift(period.as_nanos(), 0, rate);
            *period = Span::from_nanos(period.as_nanos().saturating_add(longer));
        }
        self.sort();
    }

    /// Puts the changes into the order of their latest instants; those of one channel are in it before.
    pub(crate) fn sort(&mut self) {
        self.changes.sort_by_key(|change| change.at.latest);
    }
}

/// The same, wider by so many nanoseconds at each end.
fn widened(at: When, by: i64) -> When {
    let by = by.max(0);
    When::within(
        at.earliest.saturating_add(Span::from_nanos(-by)),
        at.latest.saturating_add(Span::from_nanos(by)),
    )
}

/// The instant as it may lie when the clock is off by `rate` since `reference`, which itself may be anywhere in its interval.
fn drifted(at: When, reference: When, rate: u64) -> When {
    let farthest = |end: Time| {
        let of = |start: Time| drift(end.as_nanos(), start.as_nanos(), rate);
        Span::from_nanos(of(reference.earliest).max(of(reference.latest)))
    };
    let (before, after) = (farthest(at.earliest), farthest(at.latest));
    When::within(at.earliest.saturating_add(-before), at.latest.saturating_add(after))
}

/// How far the time between two stamps may be off, rounded up, nanoseconds. A clock that is fast by a part `e` shows `1 + e`
/// for each second, so of what it shows a part of at most `e / (1 - e)` is wrong.
fn drift(one: i64, other: i64, rate: u64) -> i64 {
    let rate = i128::from(rate.min(MAX_RATE_ERROR));
    let rest = i128::from(PARTS) - rate;
    let distance = (i128::from(one) - i128::from(other)).abs();
    i64::try_from((distance * rate + rest - 1) / rest).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CapturedChange, CapturedChannel, ChannelType};
    use proptest::prelude::*;
    use signal::Value;

    const PPM: u64 = 1_000_000;

    fn at(earliest: i64, latest: i64) -> When {
        When::within(Time::from_nanos(earliest), Time::from_nanos(latest))
    }

    fn capture(changes: &[(u32, i64, i64)]) -> Capture {
        let channel = |name: &str| CapturedChannel {
            name: name.to_owned(),
            shares_name: false,
            unit: String::new(),
            shape: ChannelType::Bit,
        };
        let one = |&(channel, earliest, latest): &(u32, i64, i64)| CapturedChange {
            channel,
            at: at(earliest, latest),
            value: Value::Bool(true),
        };
        Capture {
            channels: vec![channel("CH1"), channel("CH2")],
            changes: changes.iter().map(one).collect(),
            knowledge: Knowledge::Edges(Span::from_nanos(1)),
            span: [Time::ZERO, Time::from_nanos(1_000)],
            end: at(1_000, 1_000),
            notes: Vec::new(),
        }
    }

    #[test]
    fn offset_and_delay_are_taken_out_and_what_is_not_known_widens() {
        let mut capture = capture(&[(0, 500, 500), (1, 510, 520)]);
        let ns = Span::from_nanos;
        let own = ChannelErrors { delay: ns(40), delay_error: ns(2) };
        let errors = InstrumentErrors {
            timebase: TimebaseErrors {
                offset: ns(-100),
                offset_error: ns(7),
                resolution: ns(10),
                skew: ns(5),
                rate: 0,
            },
            channels: BTreeMap::from([("CH2".to_owned(), own)]),
        };
        capture.correct(&errors);
        // CH1: 500 + 100, wider by 10 and by half of 5, rounded up. CH2: 40 less, wider by 2 more: it comes first now.
        let seen: Vec<_> = capture.changes.iter().map(|change| (change.channel, change.at)).collect();
        assert_eq!(seen, [(1, at(555, 595)), (0, at(587, 613))]);
        assert_eq!(capture.end, at(1_045, 1_113));
        assert_eq!(capture.knowledge, Knowledge::Edges(ns(11)));
        // The offset is what is not known of an instant that is named by a time.
        assert_eq!(errors.timebase.named(Time::from_nanos(50)), at(43, 57));
    }

    #[test]
    fn a_clock_is_off_by_a_part_of_the_time_since_the_start() {
        const S: i64 = 1_000_000_000;
        let of = |one, other| drifted(at(one, one), at(other, other), 100 * PPM);
        // 100 ppm of 10 s is 1 ms; a clock that is fast by it shows 1 ms / 0.9999 too much: 1 000 100.01 ns.
        assert_eq!(of(12 * S, 2 * S), at(12 * S - 1_000_101, 12 * S + 1_000_101));
        // Before the start as well.
        assert_eq!(of(2 * S, 12 * S), at(2 * S - 1_000_101, 2 * S + 1_000_101));
        assert_eq!(of(2 * S, 2 * S), at(2 * S, 2 * S));
        // A start that may be earlier makes the distance longer.
        assert_eq!(
            drifted(at(10 * S, 10 * S), at(0, 5 * S), 100 * PPM).latest,
            Time::from_nanos(10 * S + 1_000_101)
        );
        assert_eq!(drift(i64::MIN, i64::MAX, u64::MAX), 2_049_638_230_412_172_402);
    }

    proptest! {
        // What the clock showed of a true time is within what is made of it.
        #[test]
        fn the_true_time_is_within(time in 0..1_000_000_000_000i64, rate in 0..=MAX_RATE_ERROR, part in -1.0..=1.0f64) {
            let parts = (rate as f64 * part) as i128;
            let shown = (i128::from(time) * (i128::from(PARTS) + parts) / i128::from(PARTS)) as i64;
            // What it shows is cut to a nanosecond.
            let known = drifted(at(shown, shown + 1), at(0, 0), rate);
            prop_assert!(known.earliest.as_nanos() <= time && time <= known.latest.as_nanos(), "{known:?}");
        }
    }
}
