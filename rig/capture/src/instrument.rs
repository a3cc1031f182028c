//! What an instrument says of the errors of its clock and its channels, and what follows for the instants of a capture.
//!
//! Every instant gets wider by all that its stamp may be off, rounded outwards: the instant itself lies within it.

use crate::{Capture, Knowledge};
use signal::{ClockError, Span, Time, When};
use std::collections::BTreeMap;

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
    /// How far its rate may be off.
    pub rate: ClockError,
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
    pub fn widen_by_rate(&mut self, reference: When, rate: ClockError) {
        if rate.is_none() {
            return;
        }
        for change in &mut self.changes {
            change.at = rate.drifted(change.at, reference);
        }
        self.end = rate.drifted(self.end, reference);
        if let Knowledge::Sampled(period) = &mut self.knowledge {
            *period = *period + rate.of(*period);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CapturedChange, CapturedChannel, ChannelType};
    use signal::Value;

    fn at(earliest: i64, latest: i64) -> When {
        When::within(Time::from_nanos(earliest), Time::from_nanos(latest))
    }

    fn capture(changes: &[(u32, i64, i64)]) -> Capture {
        let channel = |name: &str| CapturedChannel {
            name: name.to_owned(),
            shares_name: false,
            unit: String::new(),
            shape: ChannelType::Bit,
            recording: None,
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
                rate: ClockError::NONE,
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
}
