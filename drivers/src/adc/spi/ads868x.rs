//! ADS8684 and ADS8688 (Texas Instruments SBAS582): an answer carries the code of the input that the frame before
//! asked for, inputs have ranges of their own, and what was programmed can be read back.

use super::codec::{Bytes, Chosen, Codec, Frame, Span, SpiInput};

/// One of the family, with the way it goes through its inputs.
#[derive(Debug)]
pub struct Ads868x {
    name: &'static str,
    inputs: u8,
    /// It goes on to the next input by itself.
    automatic: bool,
}

/// 4 inputs, 16 bits; goes through its inputs by itself.
pub const ADS8684: Ads868x = Ads868x { name: "ads8684", inputs: 4, automatic: true };
/// 8 inputs, 16 bits; goes through its inputs by itself.
pub const ADS8688: Ads868x = Ads868x { name: "ads8688", inputs: 8, automatic: true };
/// As [`ADS8684`], given each input.
pub const ADS8684_MANUAL: Ads868x = Ads868x { automatic: false, ..ADS8684 };
/// As [`ADS8688`], given each input.
pub const ADS8688_MANUAL: Ads868x = Ads868x { automatic: false, ..ADS8688 };

/// Commands.
const GO_ON: u16 = 0x0000;
const RESET: u16 = 0x8500;
const FIRST: u16 = 0xA000;
const INPUT: u16 = 0xC000;
/// Program registers: which inputs it goes through, the range of the first input.
const SEQUENCE: u8 = 0x01;
const RANGE: u8 = 0x05;

/// Settings of a range and what they make of the reference.
const RANGES: [(u8, f64, f64); 5] =
    [(0, -2.5, 2.5), (1, -1.25, 1.25), (2, -0.625, 0.625), (5, 0.0, 2.5), (6, 0.0, 1.25)];

fn command(command: u16) -> Frame {
    let [high, low] = command.to_be_bytes();
    Frame::telling([high, low, 0, 0])
}

/// Writes a program register: the part answers with what it took.
fn program(register: u8, value: u8) -> Frame {
    Frame {
        expects: Some(([0, 0, 0xFF, 0], [0, 0, value, 0])),
        ..Frame::telling([register << 1 | 1, value, 0, 0])
    }
}

/// Reads a program register.
fn look(register: u8, value: u8) -> Frame {
    Frame { expects: Some(([0, 0, 0xFF, 0], [0, 0, value, 0])), ..Frame::telling([register << 1, 0, 0, 0]) }
}

impl Ads868x {
    /// The inputs that it is to go through, a bit each.
    fn sequence(inputs: &[Chosen]) -> u8 {
        inputs.iter().fold(0, |bits, chosen| bits | 1 << chosen.input.number())
    }
}

impl Codec for Ads868x {
    fn name(&self) -> &'static str {
        self.name
    }

    fn modes(&self) -> &'static [u8] {
        &[1]
    }

    fn fastest(&self) -> u32 {
        17_000_000
    }

    fn reference(&self) -> Option<f64> {
        Some(4.096)
    }

    fn inputs(&self) -> u8 {
        self.inputs
    }

    fn has_pairs(&self) -> bool {
        false
    }

    fn spans(&self, _input: SpiInput, reference: f64) -> Vec<Span> {
        let span = |(setting, low, high): (u8, f64, f64)| Span {
            low: low * reference,
            high: high * reference,
            setting,
        };
        RANGES.map(span).to_vec()
    }

    fn bits(&self) -> u8 {
        16
    }

    fn frame(&self) -> usize {
        4
    }

    fn setup(&self, inputs: &[Chosen]) -> Vec<Frame> {
        let mut frames = vec![command(RESET), program(SEQUENCE, Self::sequence(inputs))];
        let range = |chosen: &Chosen| program(RANGE + chosen.input.number(), chosen.span.setting);
        frames.extend(inputs.iter().map(range));
        // Once more: what was echoed may still not have been kept.
        frames.push(look(SEQUENCE, Self::sequence(inputs)));
        frames.extend(inputs.iter().map(|chosen| look(RANGE + chosen.input.number(), chosen.span.setting)));
        frames
    }

    /// One frame more than inputs, and one that shows whether the part is still set up as it was: a line that is stuck,
    /// a bit that slips or a part that was reset would look like a voltage.
    fn sweep(&self, inputs: &[Chosen]) -> Vec<Frame> {
        // By itself it goes through them by their numbers.
        let mut order: Vec<usize> = (0..inputs.len()).collect();
        order.sort_by_key(|at| inputs[*at].input.number());
        let ask = |at: usize| match self.automatic {
            true => command(GO_ON),
            false => command(INPUT | u16::from(inputs[at].input.number()) << 10),
        };
        let first = if self.automatic { Some(command(FIRST)) } else { order.first().map(|at| ask(*at)) };
        let mut frames: Vec<Frame> = first.into_iter().collect();
        for (place, at) in order.iter().enumerate() {
            // After the last nothing more is to be asked for.
            let next = order.get(place + 1).map_or(command(GO_ON), |next| ask(*next));
            frames.push(Frame { gives: Some(*at), ..next });
        }
        frames.push(look(SEQUENCE, Self::sequence(inputs)));
        frames
    }

    fn code(&self, _chosen: &Chosen, answer: &Bytes) -> Option<u32> {
        Some(u32::from(u16::from_be_bytes([answer[2], answer[3]])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(number: u8, range: usize) -> Chosen {
        let input = SpiInput::Single(number);
        Chosen { input, span: ADS8688.spans(input, 4.096)[range] }
    }

    fn sent(frames: &[Frame]) -> Vec<u16> {
        frames.iter().map(|frame| u16::from_be_bytes([frame.send[0], frame.send[1]])).collect()
    }

    #[test]
    fn registers_are_written_and_read_back_before_anything_is_measured() {
        let frames = ADS8688.setup(&[chosen(0, 0), chosen(7, 3)]);
        assert_eq!(sent(&frames), [0x8500, 0x0381, 0x0B00, 0x1905, 0x0200, 0x0A00, 0x1800]);
        let expected: Vec<u8> = frames.iter().filter_map(|frame| Some(frame.expects?.1[2])).collect();
        assert_eq!(expected, [0x81, 0, 5, 0x81, 0, 5]);
    }

    #[test]
    fn an_answer_belongs_to_the_frame_before() {
        let inputs = [chosen(5, 0), chosen(2, 0)];
        let automatic = ADS8688.sweep(&inputs);
        assert_eq!(sent(&automatic), [0xA000, 0, 0, 0x0200]);
        let manual = ADS8688_MANUAL.sweep(&inputs);
        assert_eq!(sent(&manual), [0xC800, 0xD400, 0, 0x0200]);
        for frames in [automatic, manual] {
            assert_eq!(
                frames.iter().map(|frame| frame.gives).collect::<Vec<_>>(),
                [None, Some(1), Some(0), None]
            );
            assert_eq!(frames[3].expects, Some(([0, 0, 0xFF, 0], [0, 0, 0x24, 0])));
        }
    }

    #[test]
    fn ranges_follow_the_reference() {
        let spans = ADS8688.spans(SpiInput::Single(0), 4.096);
        let ends: Vec<(f64, f64)> = spans.iter().map(|span| (span.low, span.high)).collect();
        assert_eq!(ends, [(-10.24, 10.24), (-5.12, 5.12), (-2.56, 2.56), (0.0, 10.24), (0.0, 5.12)]);
    }
}
