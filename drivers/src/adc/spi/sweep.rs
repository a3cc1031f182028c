//! One or several sweeps as readings: codes, means, noise, stamps.

use super::super::{AdcReading, InRange, Noise, Resolution};
use super::AdcPart;
use super::codec::{Bytes, Chosen, Frame, SpiInput};
use host::HostInstant;

/// What the sweeps of one reading said of an input.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    count: u32,
    sum: u64,
    squares: u64,
    lowest: u32,
    highest: u32,
    before: HostInstant,
    after: HostInstant,
}

/// A sweep over the inputs of a part, and what its answers said.
#[derive(Debug)]
pub struct Sweep {
    part: AdcPart,
    inputs: Vec<Chosen>,
    frames: Vec<Frame>,
    sums: Vec<Sum>,
}

impl Sweep {
    /// A sweep over these inputs.
    pub fn new(part: AdcPart, inputs: Vec<Chosen>) -> Sweep {
        let (frames, sums) = (part.sweep(&inputs), vec![Sum::default(); inputs.len()]);
        Sweep { part, inputs, frames, sums }
    }

    /// Its frames.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// A new reading begins.
    pub fn clear(&mut self) {
        self.sums.fill(Sum::default());
    }

    /// The answer to a frame, by its place, that was on the bus between these stamps. FALSE where the part cannot have
    /// said that.
    pub fn take(&mut self, frame: usize, answer: &Bytes, before: HostInstant, after: HostInstant) -> bool {
        let Some(frame) = self.frames.get(frame) else { return false };
        if let Some((mask, wanted)) = frame.expects {
            return answered(answer, &mask, &wanted);
        }
        let Some(at) = frame.gives else { return true };
        let (Some(chosen), Some(sum)) = (self.inputs.get(at), self.sums.get_mut(at)) else { return false };
        let Some(code) = self.part.code(chosen, answer) else { return false };
        if sum.count == 0 {
            (sum.lowest, sum.highest, sum.before) = (code, code, before);
        }
        sum.count += 1;
        sum.sum += u64::from(code);
        sum.squares += u64::from(code) * u64::from(code);
        sum.lowest = sum.lowest.min(code);
        sum.highest = sum.highest.max(code);
        sum.after = after;
        true
    }

    /// The readings: of each input the mean of its codes. Of one code at an end of the range the mean would be wrong,
    /// so that the reading is beyond it.
    pub fn readings(&self, out: &mut Vec<AdcReading>) {
        let steps = f64::from(self.part.highest()) + 1.0;
        for (at, (chosen, sum)) in self.inputs.iter().zip(&self.sums).enumerate() {
            if sum.count == 0 {
                continue;
            }
            let mean = sum.sum as f64 / f64::from(sum.count);
            let span = chosen.span;
            // An input against ground at 0 V shows what it has.
            let grounded = matches!(chosen.input, SpiInput::Single(_)) && span.low == 0.0;
            let range = if sum.highest >= self.part.highest() {
                InRange::Above
            } else if sum.lowest == 0 && !grounded {
                InRange::Below
            } else {
                InRange::Yes
            };
            let value = span.low + mean / steps * (span.high - span.low);
            out.push(AdcReading { input: at as u16, before: sum.before, after: sum.after, value, range });
        }
    }

    /// How finely an input is measured, in volts.
    pub fn resolution(&self, input: usize) -> Resolution {
        self.inputs.get(input).map_or(Resolution::default(), |chosen| {
            let range = chosen.span.high - chosen.span.low;
            Resolution { step: range / (f64::from(self.part.highest()) + 1.0), range: Some(range) }
        })
    }

    /// The noise of an input in the last reading: how far its sweeps lay from their mean, in volts. `None` of fewer than
    /// two.
    pub fn noise(&self, input: usize) -> Option<Noise> {
        let sum = self.sums.get(input)?;
        let count = u64::from(sum.count);
        if count < 2 {
            return None;
        }
        // Whole numbers, so that nothing is lost between two large ones.
        let spread = (u128::from(sum.squares) * u128::from(count)).saturating_sub(u128::from(sum.sum).pow(2));
        let variance = spread as f64 / (count * (count - 1)) as f64;
        Some(Noise { deviation: libm::sqrt(variance) * self.resolution(input).step, samples: sum.count })
    }
}

/// Whether the bits that count are those that were expected.
pub(super) fn answered(answer: &Bytes, mask: &Bytes, wanted: &Bytes) -> bool {
    answer.iter().zip(mask).zip(wanted).all(|((got, mask), wanted)| got & mask == wanted & mask)
}

#[cfg(test)]
mod tests {
    use super::super::{ADS8688, Codec, MCP3008, PARTS};
    use super::*;
    use proptest::prelude::*;

    fn at(nanos: usize) -> HostInstant {
        HostInstant::from_nanos(nanos as i64)
    }

    fn single(part: AdcPart, numbers: &[u8]) -> Vec<Chosen> {
        let chosen = |number: &u8| {
            let input = SpiInput::Single(*number);
            Chosen { input, span: part.spans(input, 4.096)[0] }
        };
        numbers.iter().map(chosen).collect()
    }

    /// The answer of an MCP3008.
    fn mcp(code: u16) -> Bytes {
        [0xFF, 0xF8 | (code >> 8) as u8, code as u8, 0]
    }

    fn readings(sweep: &Sweep) -> Vec<AdcReading> {
        let mut out = Vec::new();
        sweep.readings(&mut out);
        out
    }

    #[test]
    fn sweeps_make_a_mean_with_its_noise_and_the_time_of_them_all() {
        let mut sweep = Sweep::new(&MCP3008, single(&MCP3008, &[0]));
        for (turn, code) in [100u16, 101, 102, 101].into_iter().enumerate() {
            assert!(sweep.take(0, &mcp(code), at(10 * turn), at(10 * turn + 5)));
        }
        let step = 0.004;
        assert_eq!(
            readings(&sweep),
            [AdcReading { input: 0, before: at(0), after: at(35), value: 101.0 * step, range: InRange::Yes }]
        );
        let Noise { deviation, samples } = sweep.noise(0).unwrap();
        assert_eq!((samples, sweep.resolution(0)), (4, Resolution { step, range: Some(4.096) }));
        let noise = deviation / step;
        assert!((noise - (2.0f64 / 3.0).sqrt()).abs() < 1e-12, "{noise}");
        sweep.clear();
        assert_eq!((readings(&sweep), sweep.noise(0)), (vec![], None));
    }

    #[test]
    fn one_code_at_the_end_of_a_range_spoils_the_mean() {
        let range = |codes: &[u16]| {
            let mut sweep = Sweep::new(&MCP3008, single(&MCP3008, &[0]));
            codes.iter().for_each(|code| assert!(sweep.take(0, &mcp(*code), at(0), at(1))));
            readings(&sweep)[0].range
        };
        assert_eq!(range(&[1000, 1023, 1000]), InRange::Above);
        // 0 V against ground is what it is.
        assert_eq!(range(&[0, 0]), InRange::Yes);
        let mut bipolar = Sweep::new(&ADS8688, single(&ADS8688, &[0]));
        assert!(bipolar.take(1, &[0, 0, 0, 0], at(0), at(1)));
        assert_eq!(readings(&bipolar)[0].range, InRange::Below);
        let pair =
            Chosen { input: SpiInput::Pair(0, 1), span: MCP3008.spans(SpiInput::Pair(0, 1), 4.096)[0] };
        let mut pair = Sweep::new(&MCP3008, vec![pair]);
        assert!(pair.take(0, &mcp(0), at(0), at(1)));
        assert_eq!(readings(&pair)[0].range, InRange::Below);
    }

    #[test]
    fn a_part_that_was_reset_is_noticed() {
        let mut sweep = Sweep::new(&ADS8688, single(&ADS8688, &[0, 1]));
        assert!(sweep.take(3, &[0xFF, 0xFF, 0x03, 0xFF], at(0), at(1)));
        for answer in [[0xFF; 4], [0; 4], [0xFF, 0xFF, 0x81, 0xFF]] {
            assert!(!sweep.take(3, &answer, at(0), at(1)), "{answer:?}");
        }
    }

    proptest! {
        #[test]
        fn no_answer_panics_or_leads_out_of_the_range(
            part in 0..PARTS.len(), numbers in prop::collection::vec(0u8..8, 1..9), oversample in 1usize..4,
            answers in prop::collection::vec(any::<Bytes>(), 1..40),
        ) {
            let part = PARTS[part];
            let numbers: Vec<u8> = numbers.into_iter().map(|number| number % part.inputs()).collect();
            let inputs = single(part, &numbers);
            let mut sweep = Sweep::new(part, inputs.clone());
            let frames = sweep.frames().len();
            for turn in 0..oversample * frames {
                let answer = &answers[turn % answers.len()];
                let _ = sweep.take(turn % frames, answer, at(turn), at(turn + 1));
            }
            for reading in readings(&sweep) {
                let span = inputs[usize::from(reading.input)].span;
                prop_assert!(span.low <= reading.value && reading.value < span.high, "{reading:?}");
                prop_assert!(reading.before < reading.after);
                let noise = sweep.noise(usize::from(reading.input));
                let within = |noise: Noise| noise.deviation >= 0.0 && noise.deviation <= span.high - span.low;
                prop_assert!(noise.is_none_or(within));
            }
            prop_assert!(!sweep.take(frames, &answers[0], at(0), at(1)));
        }
    }
}
