//! MAX1110 to MAX1113 (Maxim 19-1194, 19-1231): a control byte asks for an input, the code follows in the same frame.

use super::codec::{Bytes, Chosen, Codec, Frame, Span, SpiInput};

/// One of the family.
#[derive(Debug)]
pub struct Max111x {
    name: &'static str,
    inputs: u8,
    reference: f64,
}

/// 8 inputs, reference of 2.048 V.
pub const MAX1110: Max111x = Max111x { name: "max1110", inputs: 8, reference: 2.048 };
/// 4 inputs, reference of 2.048 V.
pub const MAX1111: Max111x = Max111x { name: "max1111", inputs: 4, reference: 2.048 };
/// 8 inputs, reference of 4.096 V.
pub const MAX1112: Max111x = Max111x { name: "max1112", inputs: 8, reference: 4.096 };
/// 4 inputs, reference of 4.096 V.
pub const MAX1113: Max111x = Max111x { name: "max1113", inputs: 4, reference: 4.096 };

const START: u8 = 0x80;
/// Fully on, and clocked by the bus.
const POWERED: u8 = 0x03;
const SINGLE: u8 = 0x04;
const UNIPOLAR: u8 = 0x08;

impl Max111x {
    /// The control byte of an input.
    fn control(&self, chosen: &Chosen) -> u8 {
        // The lowest bit of the number comes first; parts of four inputs leave out the last.
        let number = chosen.input.number();
        let select =
            if self.inputs > 4 { (number & 1) << 2 | number >> 1 } else { (number & 1) << 2 | number & 2 };
        let single = if matches!(chosen.input, SpiInput::Single(_)) { SINGLE } else { 0 };
        START | select << 4 | single | chosen.span.setting | POWERED
    }
}

impl Codec for Max111x {
    fn name(&self) -> &'static str {
        self.name
    }

    fn modes(&self) -> &'static [u8] {
        &[0, 3]
    }

    fn fastest(&self) -> u32 {
        500_000
    }

    fn reference(&self) -> Option<f64> {
        Some(self.reference)
    }

    fn inputs(&self) -> u8 {
        self.inputs
    }

    fn has_pairs(&self) -> bool {
        true
    }

    fn spans(&self, _input: SpiInput, reference: f64) -> Vec<Span> {
        let half = reference / 2.0;
        vec![
            Span { low: 0.0, high: reference, setting: UNIPOLAR },
            Span { low: -half, high: half, setting: 0 },
        ]
    }

    fn bits(&self) -> u8 {
        8
    }

    fn frame(&self) -> usize {
        3
    }

    fn sweep(&self, inputs: &[Chosen]) -> Vec<Frame> {
        let frame =
            |(at, chosen)| Frame { send: [self.control(chosen), 0, 0, 0], gives: Some(at), expects: None };
        inputs.iter().enumerate().map(frame).collect()
    }

    /// Two bits of 0, the code, six bits of 0.
    fn code(&self, chosen: &Chosen, answer: &Bytes) -> Option<u32> {
        let word = u16::from_be_bytes([answer[1], answer[2]]);
        let code = (word >> 6) as u8;
        // A bipolar code is in two's complement.
        let code = if chosen.span.setting == UNIPOLAR { code } else { code ^ 0x80 };
        (word & 0xC03F == 0).then_some(u32::from(code))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(part: &Max111x, input: SpiInput, span: usize) -> Chosen {
        Chosen { input, span: part.spans(input, part.reference)[span] }
    }

    #[test]
    fn control_bytes_select_by_the_tables_of_the_data_sheet() {
        let select = |part: &Max111x, input| part.control(&chosen(part, input, 0)) >> 4 & 7;
        let of =
            |part: &Max111x| (0..part.inputs).map(|n| select(part, SpiInput::Single(n))).collect::<Vec<_>>();
        assert_eq!(of(&MAX1110), [0b000, 0b100, 0b001, 0b101, 0b010, 0b110, 0b011, 0b111]);
        assert_eq!(of(&MAX1111), [0b000, 0b100, 0b010, 0b110]);
        assert_eq!(MAX1111.control(&chosen(&MAX1111, SpiInput::Single(0), 0)), 0b1000_1111);
        assert_eq!(MAX1110.control(&chosen(&MAX1110, SpiInput::Pair(1, 0), 1)), 0b1100_0011);
    }

    #[test]
    fn a_code_stands_between_bits_of_0() {
        let (unipolar, bipolar) =
            (chosen(&MAX1111, SpiInput::Single(0), 0), chosen(&MAX1111, SpiInput::Single(0), 1));
        assert_eq!(MAX1111.code(&unipolar, &[0, 0x20, 0x40, 0]), Some(0x81));
        assert_eq!(MAX1111.code(&bipolar, &[0, 0x20, 0x00, 0]), Some(0), "the lowest");
        assert_eq!(MAX1111.code(&bipolar, &[0, 0x1F, 0xC0, 0]), Some(255), "the highest");
        for garbled in [[0, 0x60, 0x40, 0], [0, 0x20, 0x60, 0], [0xFF; 4]] {
            assert_eq!(MAX1111.code(&unipolar, &garbled), None, "{garbled:?}");
        }
    }
}
