//! MCP3004, MCP3008, MCP3204 and MCP3208 (Microchip DS21295, DS21298): a frame asks for an input and carries its code.

use super::codec::{Bytes, Chosen, Codec, Frame, Span, SpiInput};

/// One of the family.
#[derive(Debug)]
pub struct Mcp3x0x {
    name: &'static str,
    inputs: u8,
    bits: u8,
    fastest: u32,
}

/// 4 inputs, 10 bits.
pub const MCP3004: Mcp3x0x = Mcp3x0x { name: "mcp3004", inputs: 4, bits: 10, fastest: 3_600_000 };
/// 8 inputs, 10 bits.
pub const MCP3008: Mcp3x0x = Mcp3x0x { name: "mcp3008", inputs: 8, bits: 10, fastest: 3_600_000 };
/// 4 inputs, 12 bits.
pub const MCP3204: Mcp3x0x = Mcp3x0x { name: "mcp3204", inputs: 4, bits: 12, fastest: 2_000_000 };
/// 8 inputs, 12 bits.
pub const MCP3208: Mcp3x0x = Mcp3x0x { name: "mcp3208", inputs: 8, bits: 12, fastest: 2_000_000 };

/// Bits of a frame: such that the last bit of the code is the last of the frame.
const FRAME_BITS: u32 = 24;

impl Codec for Mcp3x0x {
    fn name(&self) -> &'static str {
        self.name
    }

    fn modes(&self) -> &'static [u8] {
        &[0, 3]
    }

    fn fastest(&self) -> u32 {
        self.fastest
    }

    fn reference(&self) -> Option<f64> {
        None
    }

    fn inputs(&self) -> u8 {
        self.inputs
    }

    fn has_pairs(&self) -> bool {
        true
    }

    fn spans(&self, _input: SpiInput, reference: f64) -> Vec<Span> {
        vec![Span { low: 0.0, high: reference, setting: 0 }]
    }

    fn bits(&self) -> u8 {
        self.bits
    }

    fn frame(&self) -> usize {
        3
    }

    fn sweep(&self, inputs: &[Chosen]) -> Vec<Frame> {
        let frame = |(at, chosen): (usize, &Chosen)| {
            let single = u32::from(matches!(chosen.input, SpiInput::Single(_)));
            // Start bit, single-ended or not, three bits of the input; two clocks to sample, of which the second is
            // answered by 0; then the code.
            let command = 1 << 4 | single << 3 | u32::from(chosen.input.number());
            let [_, send @ ..] = (command << (u32::from(self.bits) + 2)).to_be_bytes();
            Frame { send: [send[0], send[1], send[2], 0], gives: Some(at), expects: None }
        };
        inputs.iter().enumerate().map(frame).collect()
    }

    fn code(&self, _chosen: &Chosen, answer: &Bytes) -> Option<u32> {
        let word = u32::from_be_bytes(*answer) >> (32 - FRAME_BITS);
        let below = 1 << self.bits;
        (word & below == 0).then_some(word & (below - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(input: SpiInput) -> Chosen {
        Chosen { input, span: Span { low: 0.0, high: 3.3, setting: 0 } }
    }

    #[test]
    fn commands_are_those_of_the_data_sheets() {
        let send = |part: &Mcp3x0x, input| part.sweep(&[chosen(input)])[0].send[..3].to_vec();
        // DS21295, figure 6-1: the start bit is the last of the first byte.
        assert_eq!(send(&MCP3008, SpiInput::Single(0)), [0x01, 0x80, 0]);
        assert_eq!(send(&MCP3008, SpiInput::Single(7)), [0x01, 0xF0, 0]);
        assert_eq!(send(&MCP3004, SpiInput::Pair(1, 0)), [0x01, 0x10, 0]);
        // DS21298, figure 6-1: 0000 01 SGL D2, D1 D0.
        assert_eq!(send(&MCP3208, SpiInput::Single(5)), [0x07, 0x40, 0]);
        assert_eq!(send(&MCP3204, SpiInput::Pair(2, 3)), [0x04, 0x80, 0]);
    }

    #[test]
    fn a_code_stands_behind_its_null_bit() {
        let code = |part: &Mcp3x0x, answer: [u8; 3]| {
            part.code(&chosen(SpiInput::Single(0)), &[answer[0], answer[1], answer[2], 0])
        };
        // What is in front of the null bit is not driven by the part.
        assert_eq!(code(&MCP3008, [0xFF, 0xFA, 0x34]), Some(0x234));
        assert_eq!(code(&MCP3008, [0xFF, 0xFF, 0x34]), None);
        assert_eq!(code(&MCP3208, [0xFF, 0xE9, 0x87]), Some(0x987));
        assert_eq!(code(&MCP3208, [0x00, 0x19, 0x87]), None);
    }
}
