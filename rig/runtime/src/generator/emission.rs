//! Pulses that the board makes by itself: one act in place of one for each edge.

use super::StimulusGenerator;
use drivers::{ChannelId, Emission, NotEmitted, PulseCapability};
use signal::{Span, Value};
use std::sync::Arc;

/// Pulses that a channel emits by itself.
#[derive(Clone, Debug)]
pub struct EmittedPulses {
    /// The channel.
    pub channel: ChannelId,
    /// The pulses.
    pub emission: Emission,
    /// When a wave without an end of its own ends.
    pub ends: Option<Span>,
}

/// Why the board cannot make what a generator does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmissionError {
    /// The channel does not have it.
    NotEmitted(NotEmitted),
    /// The line is high at the end.
    EndsHigh,
    /// The line is let go.
    LetGo,
    /// The line never moves.
    Still,
    /// A wave without end that begins elsewhere than with its rising edge.
    Phase,
}

impl EmittedPulses {
    /// How long after the beginning act `n` from 0 comes: the beginning, and the end of a wave that has none itself.
    pub(super) fn after(&self, n: u64) -> Option<Span> {
        match n {
            0 => Some(Span::ZERO),
            1 => self.ends,
            _ => None,
        }
    }

    /// What act `n` writes: the end leaves the line as the wave has it there.
    pub(super) fn writes(&self, n: u64, out: &mut Vec<(ChannelId, Value)>) {
        if let (1, Some(ends)) = (n, self.ends) {
            out.push((self.channel, self.level(ends)));
        }
    }

    /// Whether it goes on until somebody ends it.
    pub const fn is_endless(&self) -> bool {
        matches!(self.emission, Emission::Square { .. })
    }

    /// The level of an endless wave just before so long after its beginning.
    pub fn level(&self, after: Span) -> Value {
        match self.emission {
            Emission::Square { period, high } => {
                let into = (after.as_nanos() - 1).rem_euclid(period.as_nanos().max(1));
                Value::Bool(into < high.as_nanos())
            }
            Emission::Pulses(_) => Value::Bool(false),
        }
    }

    /// How many edges it has, where they end.
    pub fn edges(&self) -> Option<usize> {
        match &self.emission {
            Emission::Square { .. } => None,
            Emission::Pulses(edges) => Some(edges.len()),
        }
    }

    /// When pulse `n` from 1 rises.
    pub(super) fn rises(&self, n: u32) -> Option<Span> {
        match &self.emission {
            Emission::Square { .. } => None,
            Emission::Pulses(edges) => {
                let place = usize::try_from(n.checked_sub(1)?).ok()?.checked_mul(2)?;
                edges.get(place).copied()
            }
        }
    }
}

impl StimulusGenerator {
    /// All edges of what drives one line from low up to `lasts`, for a channel that emits so.
    ///
    /// # Errors
    /// What of it the channel cannot emit: found out before there are more edges than it takes.
    pub fn pulses(&self, lasts: Span, emits: &PulseCapability) -> Result<Emission, EmissionError> {
        let not = |why| Err(EmissionError::NotEmitted(why));
        if emits.counted == Span::ZERO {
            return not(NotEmitted::Counted);
        }
        let (mut edges, mut writes, mut high) = (Vec::new(), Vec::new(), false);
        for n in 0.. {
            let Some(after) = self.after(n).filter(|after| *after <= lasts) else { break };
            writes.clear();
            self.writes(n, &mut writes);
            for (_, value) in &writes {
                let Some(level) = value.as_bool() else { return Err(EmissionError::LetGo) };
                if level == high {
                    continue;
                }
                if after > emits.counted {
                    return not(NotEmitted::Lasting(emits.counted));
                }
                if edges.last().is_some_and(|last| after - *last < emits.shortest) {
                    return not(NotEmitted::Short(emits.shortest));
                }
                (high, _) = (level, edges.push(after));
            }
        }
        if high {
            return Err(EmissionError::EndsHigh);
        }
        if edges.is_empty() {
            return Err(EmissionError::Still);
        }
        let emission = Emission::Pulses(Arc::from(edges));
        emits.check(&emission).map_err(EmissionError::NotEmitted)?;
        Ok(emission)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::{Curve, Waveform};
    use plans::steps::ExactPeriod;

    const fn us(n: i64) -> Span {
        Span::from_micros(n)
    }

    const STREAM: PulseCapability = PulseCapability {
        shortest: us(1),
        longest: us(100),
        resolution: us(1),
        counted: Span::from_millis(1),
        endless: false,
    };

    /// 25 kHz of which a quarter is high.
    fn square(lasts: Option<Span>) -> StimulusGenerator {
        let cycle = ExactPeriod::of_millihertz(25_000_000);
        let shape = Waveform::Square { band: None, cycle, phase: 0, duty: 90_000_000 };
        StimulusGenerator::Wave { channel: ChannelId(0), curve: Curve { shape, lasts, sample: us(1) } }
    }

    fn edges(generator: &StimulusGenerator, lasts: Span) -> Result<Vec<i64>, EmissionError> {
        match generator.pulses(lasts, &STREAM)? {
            Emission::Pulses(edges) => Ok(edges.iter().map(|edge| edge.as_nanos() / 1_000).collect()),
            Emission::Square { .. } => panic!(),
        }
    }

    #[test]
    fn edges_are_those_that_would_be_written_one_by_one() {
        assert_eq!(edges(&square(Some(us(95))), us(95)).unwrap(), [0, 10, 40, 50, 80, 90]);
        assert_eq!(edges(&square(Some(us(85))), us(85)), Err(EmissionError::EndsHigh));
    }

    // A table or a train may have millions of acts: what does not fit is found at its first edge that does not.
    #[test]
    fn what_a_channel_cannot_emit_is_found_where_it_begins() {
        let hour = Span::from_secs(3_600);
        let not = |why| Err(EmissionError::NotEmitted(why));
        let long = square(Some(hour));
        assert_eq!(long.pulses(hour, &STREAM), not(NotEmitted::Lasting(STREAM.counted)));
        let coarse = PulseCapability { shortest: us(11), ..STREAM };
        assert_eq!(long.pulses(hour, &coarse), not(NotEmitted::Short(us(11))));
        let endless = PulseCapability { counted: Span::ZERO, ..STREAM };
        assert_eq!(long.pulses(hour, &endless), not(NotEmitted::Counted));
    }

    #[test]
    fn a_wave_that_is_ended_keeps_the_level_that_it_has_there() {
        let emission = Emission::Square { period: us(40), high: us(10) };
        let wave = EmittedPulses { channel: ChannelId(3), emission, ends: Some(us(85)) };
        let mut writes = Vec::new();
        wave.writes(1, &mut writes);
        assert_eq!(writes, [(ChannelId(3), Value::Bool(true))]);
        let at = |nanos| wave.level(Span::from_nanos(nanos));
        assert_eq!([40_000, 40_001, 50_000, 50_001].map(at), [false, true, true, false].map(Value::Bool));
    }
}
