//! How the changes of a signal came to be known and which of them were kept, in words that a file can hold.

use crate::{ClockDomain, Policy, Sampling, SignalInfo, Span};
use std::fmt;

/// What a trace knows of how a signal was recorded, beside its events: the part of [`SignalInfo`] that depends on the instrument and
/// not on the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignalRecording {
    /// Whose clock stamped it.
    pub clock: ClockDomain,
    /// How changes came to be known.
    pub sampling: Sampling,
    /// The shortest pulse that was certain to be seen (0 = any).
    pub shortest_pulse: Span,
    /// Which changes were kept.
    pub policy: Policy,
}

impl SignalRecording {
    /// That of a signal.
    pub const fn of(info: &SignalInfo) -> SignalRecording {
        let SignalInfo { clock, sampling, shortest_pulse, policy, .. } = *info;
        SignalRecording { clock, sampling, shortest_pulse, policy }
    }

    /// The same signal as it was recorded in this way.
    #[must_use]
    pub fn applied_to(self, info: SignalInfo) -> SignalInfo {
        let SignalRecording { clock, sampling, shortest_pulse, policy } = self;
        SignalInfo { clock, sampling, shortest_pulse, policy, ..info }
    }

    /// Reads what [`fmt::Display`] writes; `None` for other words.
    pub fn parse(text: &str) -> Option<SignalRecording> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let ["clock", clock, sampling, width, "ns", "shortest", shortest, "ns", policy @ ..] = &words[..]
        else {
            return None;
        };
        let span = |word: &str| word.parse().ok().filter(|ns| *ns >= 0).map(Span::from_nanos);
        Some(SignalRecording {
            clock: match *clock {
                "virtual" => ClockDomain::Virtual,
                "monotonic" => ClockDomain::Monotonic,
                "device" => ClockDomain::Device,
                _ => return None,
            },
            sampling: match (*sampling, span(width)?) {
                ("edges", resolution) => Sampling::Edges { resolution },
                ("sampled", period) => Sampling::Sampled { period },
                _ => return None,
            },
            shortest_pulse: span(shortest)?,
            policy: match policy {
                ["changes"] => Policy::Changes,
                ["deadband", band] => {
                    Policy::Deadband(band.parse().ok().filter(|band: &f64| *band > 0.0 && band.is_finite())?)
                }
                ["at-most-every", every, "ns"] => {
                    Policy::AtMostEvery(span(every).filter(|every| *every > Span::ZERO)?)
                }
                _ => return None,
            },
        })
    }
}

impl fmt::Display for SignalRecording {
    /// As `clock device sampled 1000 ns shortest 2000 ns deadband 0.5`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let clock = match self.clock {
            ClockDomain::Virtual => "virtual",
            ClockDomain::Monotonic => "monotonic",
            ClockDomain::Device => "device",
        };
        let (sampling, width) = match self.sampling {
            Sampling::Edges { resolution } => ("edges", resolution),
            Sampling::Sampled { period } => ("sampled", period),
        };
        let (width, shortest) = (width.as_nanos(), self.shortest_pulse.as_nanos());
        write!(f, "clock {clock} {sampling} {width} ns shortest {shortest} ns ")?;
        match self.policy {
            Policy::Changes => f.write_str("changes"),
            Policy::Deadband(band) => write!(f, "deadband {band:e}"),
            Policy::AtMostEvery(every) => write!(f, "at-most-every {} ns", every.as_nanos()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn recordings() -> impl Strategy<Value = SignalRecording> {
        let spans = || (0..=i64::MAX).prop_map(Span::from_nanos);
        let clocks =
            prop_oneof![Just(ClockDomain::Virtual), Just(ClockDomain::Monotonic), Just(ClockDomain::Device),];
        let samplings = prop_oneof![
            spans().prop_map(|resolution| Sampling::Edges { resolution }),
            spans().prop_map(|period| Sampling::Sampled { period }),
        ];
        let policies = prop_oneof![
            Just(Policy::Changes),
            proptest::num::f64::POSITIVE
                .prop_filter("finite", |band| *band > 0.0 && band.is_finite())
                .prop_map(Policy::Deadband),
            (1..=i64::MAX).prop_map(|ns| Policy::AtMostEvery(Span::from_nanos(ns))),
        ];
        (clocks, samplings, spans(), policies).prop_map(|(clock, sampling, shortest_pulse, policy)| {
            SignalRecording { clock, sampling, shortest_pulse, policy }
        })
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(recording in recordings()) {
            prop_assert_eq!(SignalRecording::parse(&recording.to_string()), Some(recording));
        }

        #[test]
        fn no_text_panics(text in ".*") {
            let _ = SignalRecording::parse(&text);
        }
    }

    #[test]
    fn other_words_are_none() {
        let text = "clock device sampled 1000 ns shortest 2000 ns deadband 5e-1";
        assert_eq!(
            SignalRecording::parse(text).map(|recording| recording.to_string()).as_deref(),
            Some(text)
        );
        for (word, other) in [
            ("device", "other"),
            ("sampled", "seen"),
            ("1000", "-1"),
            ("2000 ns", "2 us"),
            ("deadband 5e-1", "deadband NaN"),
            ("deadband 5e-1", "deadband 0"),
            ("deadband 5e-1", ""),
            ("deadband 5e-1", "changes, all"),
        ] {
            assert_eq!(SignalRecording::parse(&text.replace(word, other)), None, "{other}");
        }
    }
}
