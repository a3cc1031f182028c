//! `train`: pulses at a frequency that need not have a period of whole nanoseconds.

use document::{Findings, KeySpec, KeyType, Node};
use signal::Span;

use super::cycle::{ExactPeriod, FREQUENCY, PERIOD, part};
use super::{StepNames, table_fields};
use super::{StepVerb, Stimulus};
use crate::codes;

/// Most pulses of one train.
pub const MAX_PULSES: u32 = 10_000_000;

const KEYS: &[KeySpec] = &[
    KeySpec::required("signal", KeyType::SignalRef, "The line that the pulses are emitted on."),
    FREQUENCY,
    PERIOD,
    KeySpec::required("count", KeyType::Integer(1, MAX_PULSES as i64), "How many pulses."),
    KeySpec::optional(
        "duty",
        KeyType::Text,
        "Part of the period that is high, as in \"25 %\"; half if left out.",
    ),
    KeySpec::optional(
        "jitter",
        KeyType::Duration,
        "Each edge is moved by up to this, at random, to either side.",
    ),
];

pub(super) const TRAIN: StepVerb = StepVerb {
    name: "train",
    doc: "Emits a train of pulses.",
    value: KeyType::Table(KEYS),
    needs: &["pulse"],
    read,
};

/// A train of pulses. Pulse `n`, counted from 1, rises at [`TrainStimulus::rises`] and falls at [`TrainStimulus::falls`] after
/// the step, before jitter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrainStimulus {
    /// The line.
    pub signal: String,
    /// How many pulses, 1 ..= [`MAX_PULSES`].
    pub count: u32,
    /// From one rising edge to the next.
    cycle: ExactPeriod,
    /// Millionths of the period that are high, above 0 and below 1 000 000.
    duty: u32,
    /// Each edge is moved by up to this to either side; less than half of the shorter part of a period.
    pub jitter: Span,
}

impl TrainStimulus {
    /// From the step to the rising edge of pulse `n` from 1, rounded to the nanosecond.
    pub fn rises(&self, n: u32) -> Span {
        self.edge(u128::from(n.saturating_sub(1)) * 1_000_000)
    }

    /// From the step to the falling edge of pulse `n` from 1, rounded to the nanosecond.
    pub fn falls(&self, n: u32) -> Span {
        self.edge(u128::from(n.saturating_sub(1)) * 1_000_000 + u128::from(self.duty))
    }

    /// From the step to the last falling edge.
    pub fn length(&self) -> Span {
        self.falls(self.count)
    }

    /// Pulses per time, in thousandths of a Hertz, rounded up: what the rig must be able to emit.
    pub fn millihertz(&self) -> u64 {
        self.cycle.millihertz()
    }

    /// The instant after so many millionths of a period.
    fn edge(&self, millionths: u128) -> Span {
        self.cycle.after(millionths, 1_000_000)
    }
}

fn read(node: &Node, scope: &dyn StepNames, out: &mut Findings) -> Option<Stimulus> {
    let fields = table_fields(node, KEYS)?;
    let signal = scope.whole_signal(fields.get("signal")?, out);
    let cycle = ExactPeriod::read(&fields, node, "train", out);
    let duty = part(&fields, "duty", out);
    let count = u32::try_from(fields.integer("count")?).unwrap_or(MAX_PULSES);
    let train = TrainStimulus {
        signal: signal?,
        count,
        cycle: cycle?,
        duty: duty?,
        jitter: fields.duration("jitter").unwrap_or(Span::ZERO),
    };
    let high = train.falls(1);
    let low = train.rises(2) - high;
    let shorter = high.min(low);
    if shorter <= Span::ZERO {
        let message = "a pulse, or the pause after it, is shorter than 1 ns";
        out.bad(codes::STIMULUS, node, message, "lower the frequency, or take a duty nearer to 50 %");
        return None;
    }
    if train.length() == Span::MAX {
        out.bad(codes::STIMULUS, node, "the train lasts longer than 292 years", "lower its count");
        return None;
    }
    if train.jitter.as_nanos() > (shorter.as_nanos() - 1) / 2 {
        let place = fields.get("jitter").unwrap_or(node);
        let help = format!("edges would pass each other: less than half of {shorter} is possible");
        out.bad(codes::STIMULUS, place, "the jitter is too large for this train", help);
        return None;
    }
    Some(Stimulus::Train(train))
}

#[cfg(test)]
mod tests {
    use super::*;

    // A period of 333 333.3 ns must not drift over a train: edges are rounded one by one.
    #[test]
    fn a_train_does_not_drift() {
        let train = TrainStimulus {
            signal: "a".into(),
            count: 30_000,
            cycle: ExactPeriod::of_millihertz(3_000_000),
            duty: 500_000,
            jitter: Span::ZERO,
        };
        assert_eq!(train.rises(1), Span::ZERO);
        assert_eq!(train.rises(2), Span::from_nanos(333_333));
        assert_eq!(train.rises(3), Span::from_nanos(666_667));
        assert_eq!(train.rises(30_001), Span::from_secs(10));
        assert_eq!(train.falls(1), Span::from_nanos(166_667));
        assert_eq!(train.millihertz(), 3_000_000);
    }
}
