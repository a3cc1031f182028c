//! How long a CAN frame is on its bus: exact, by its bits (ISO 11898-1), stuff bits among them.
//!
//! Of a classic frame every bit is known, its CRC included, so its stuff bits are counted and not estimated. A CAN FD
//! frame has stuff bits by its contents up to the end of the data; those of its CRC stand at fixed places. Where the bit
//! rate switches, the bits from ESI up to the delimiter of the CRC count as fast ones.

use signal::{CanFrame, Span};

/// Bits after the CRC: its delimiter (of a classic frame), the acknowledgement with its delimiter, the end of frame.
const CLASSIC_TAIL: u64 = 1 + 2 + 7;
/// The same of a CAN FD frame, whose delimiter of the CRC is a fast bit.
const FD_TAIL: u64 = 2 + 7;
/// Bits between two frames.
const INTERMISSION: u64 = 3;

/// The bits of a frame by their length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bits {
    /// At the bit rate of the arbitration.
    pub slow: u64,
    /// At the bit rate of the data.
    pub fast: u64,
}

impl Bits {
    /// How long they take, rounded up to the nanosecond.
    pub fn lasts(self, bitrate: u32, data_bitrate: u32) -> Span {
        let nanos = |bits: u64, rate: u32| u128::from(bits) * 1_000_000_000 * u128::from(rate);
        let (slow, fast) = (u128::from(bitrate.max(1)), u128::from(data_bitrate.max(1)));
        // Over one denominator, so that only the sum is rounded.
        let sum = nanos(self.slow, data_bitrate.max(1)) + nanos(self.fast, bitrate.max(1));
        Span::from_nanos(i64::try_from(sum.div_ceil(slow * fast)).unwrap_or(i64::MAX))
    }
}

/// The least distance from the end of one frame to the start of the next.
pub fn intermission(bitrate: u32) -> Span {
    Bits { slow: INTERMISSION, fast: 0 }.lasts(bitrate, bitrate)
}

/// Counts bits and the stuff bits that follow five equal ones.
#[derive(Debug, Default)]
struct Stuffing {
    last: bool,
    run: u8,
    bits: u64,
    crc: u16,
    /// The last bit made a run of five: its stuff bit is only due if another stuffed bit follows.
    due: bool,
}

impl Stuffing {
    fn push(&mut self, bit: bool) {
        self.settle();
        if self.bits > 0 && bit == self.last {
            self.run += 1;
        } else {
            (self.last, self.run) = (bit, 1);
        }
        self.bits += 1;
        self.due = self.run == 5;
        // CRC-15 of ISO 11898-1: x15 + x14 + x10 + x8 + x7 + x4 + x3 + 1, of the bits without stuff bits.
        let next = bit != (self.crc & 0x4000 != 0);
        self.crc = (self.crc << 1) & 0x7FFF;
        if next {
            self.crc ^= 0x4599;
        }
    }

    /// Puts the stuff bit in that is due: the opposite of the last bit.
    fn settle(&mut self) {
        if std::mem::take(&mut self.due) {
            self.bits += 1;
            (self.last, self.run) = (!self.last, 1);
        }
    }

    fn number(&mut self, value: u32, width: u32) {
        (0..width).rev().for_each(|bit| self.push(value >> bit & 1 == 1));
    }
}

/// The bits of a frame from its start to its end, without the pause after it.
pub fn bits(frame: &CanFrame) -> Bits {
    let mut stuffing = Stuffing::default();
    stuffing.push(false);
    if frame.extended {
        stuffing.number(frame.id >> 18 & 0x7FF, 11);
        // In place of the remote bit, then the mark of the extended identifier.
        stuffing.number(0b11, 2);
        stuffing.number(frame.id & 0x3_FFFF, 18);
    } else {
        stuffing.number(frame.id & 0x7FF, 11);
    }
    stuffing.push(frame.remote && !frame.fd);
    if frame.fd { fd(frame, stuffing) } else { classic(frame, stuffing) }
}

/// The rest of a classic frame.
fn classic(frame: &CanFrame, mut stuffing: Stuffing) -> Bits {
    // Both kinds have two more dominant bits here, one of them the mark of the base identifier or reserved.
    stuffing.number(0, 2);
    stuffing.number(u32::from(frame.len.min(8)), 4);
    frame.data().iter().for_each(|byte| stuffing.number(u32::from(*byte), 8));
    let crc = stuffing.crc;
    stuffing.number(u32::from(crc), 15);
    stuffing.settle();
    Bits { slow: stuffing.bits + CLASSIC_TAIL, fast: 0 }
}

/// The rest of a CAN FD frame.
fn fd(frame: &CanFrame, mut stuffing: Stuffing) -> Bits {
    if !frame.extended {
        // The mark of the base identifier.
        stuffing.push(false);
    }
    // FDF, reserved, BRS.
    stuffing.number(0b10, 2);
    stuffing.push(frame.brs);
    stuffing.settle();
    let arbitration = stuffing.bits;
    stuffing.push(frame.esi);
    stuffing.number(length_code(frame.len), 4);
    frame.data().iter().for_each(|byte| stuffing.number(u32::from(*byte), 8));
    // A run of five at the very end is broken by the first fixed stuff bit. The count of stuff bits takes 4 bits; a fixed
    // stuff bit stands in front of it and after every fourth bit. Then the delimiter.
    let crc: u64 = if frame.len > 16 { 4 + 21 } else { 4 + 17 };
    let fixed = crc.div_ceil(4);
    let rest = stuffing.bits - arbitration + crc + fixed + 1;
    match frame.brs {
        true => Bits { slow: arbitration + FD_TAIL, fast: rest },
        false => Bits { slow: arbitration + rest + FD_TAIL, fast: 0 },
    }
}

/// The code of a length of CAN FD data.
fn length_code(len: u8) -> u32 {
    match len {
        0..=8 => u32::from(len),
        9..=12 => 9,
        13..=16 => 10,
        17..=20 => 11,
        21..=24 => 12,
        25..=32 => 13,
        33..=48 => 14,
        _ => 15,
    }
}

/// What decides an arbitration: the frame with the least wins, as a dominant bit, 0, beats a recessive one.
pub fn priority(frame: &CanFrame) -> u64 {
    let remote = u64::from(frame.remote && !frame.fd);
    let id = u64::from(frame.id);
    match frame.extended {
        false => (id & 0x7FF) << 21 | remote << 20,
        true => (id >> 18 & 0x7FF) << 21 | 0b11 << 19 | (id & 0x3_FFFF) << 1 | remote,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::MAX_CAN_DATA;

    use proptest::prelude::*;

    fn classic(id: u32, extended: bool, data: &[u8]) -> CanFrame {
        CanFrame::classic(id, extended, data).unwrap()
    }

    fn fd(id: u32, extended: bool, brs: bool, data: &[u8]) -> CanFrame {
        let mut bytes = [0; MAX_CAN_DATA];
        bytes[..data.len()].copy_from_slice(data);
        CanFrame {
            id,
            extended,
            remote: false,
            fd: true,
            brs,
            esi: false,
            len: data.len() as u8,
            data: bytes,
        }
    }

    #[test]
    fn classic_frames_have_the_bits_of_the_standard() {
        // 44 bits and 8 for each byte without stuff bits, 64 with an extended identifier. These contents, worked out by
        // hand, need none before the CRC; what that adds is found with an independent count below.
        for (frame, plain) in [
            (classic(0x555, false, &[]), 44),
            (classic(0x2AA, false, &[0x55; 8]), 44 + 64),
            (classic(0x1555_5555, true, &[0xAA]), 64 + 8),
        ] {
            let stuffed = bits(&frame).slow;
            assert!((plain..plain + 4).contains(&stuffed), "{frame:?} has {stuffed} bits, not {plain}");
        }
        // The worst case: 1 stuff bit for every 4 bits after the first.
        let worst = (0..=255).map(|byte| bits(&classic(0, false, &[byte; 8])).slow).max().unwrap();
        assert!((108 + 12..=108 + 24).contains(&worst), "{worst}");
    }

    #[test]
    fn the_crc_is_that_of_the_standard() {
        // Start, identifier 0x14, three dominant bits, a length of 1, a byte of 1.
        let mut stuffing = Stuffing::default();
        stuffing.push(false);
        stuffing.number(0x14, 11);
        stuffing.number(0, 3);
        stuffing.number(1, 4);
        stuffing.number(1, 8);
        assert_eq!(stuffing.crc, crc15(0xA_0101, 27));
    }

    /// CRC-15 by long division, in place of the register.
    fn crc15(bits: u64, width: u32) -> u16 {
        let mut rest = u128::from(bits) << 15;
        let polynomial = 0xC599_u128;
        for bit in (15..15 + width).rev() {
            if rest >> bit & 1 == 1 {
                rest ^= polynomial << (bit - 15);
            }
        }
        (rest & 0x7FFF) as u16
    }

    #[test]
    fn a_switched_bit_rate_makes_a_frame_shorter() {
        let slow = bits(&fd(0x123, false, false, &[0x5A; 64])).lasts(500_000, 2_000_000);
        let fast = bits(&fd(0x123, false, true, &[0x5A; 64])).lasts(500_000, 2_000_000);
        assert!(fast.as_nanos() * 3 < slow.as_nanos(), "{fast} of {slow}");
    }

    #[test]
    fn time_is_exact_and_rounded_up_once() {
        assert_eq!(Bits { slow: 47, fast: 0 }.lasts(500_000, 500_000), Span::from_micros(94));
        assert_eq!(Bits { slow: 1, fast: 1 }.lasts(3, 6), Span::from_nanos(500_000_000));
        assert_eq!(intermission(250_000), Span::from_micros(12));
    }

    #[test]
    fn arbitration_is_by_identifier_and_kind() {
        let remote = CanFrame { remote: true, ..classic(0x100, false, &[]) };
        let order = [
            classic(0x0FF, false, &[]),
            classic(0x100, false, &[]),
            remote,
            classic(0x100 << 18, true, &[]),
            classic(0x100 << 18 | 1, true, &[]),
            classic(0x101, false, &[]),
        ];
        assert!(order.windows(2).all(|pair| priority(&pair[0]) < priority(&pair[1])));
    }

    proptest! {
        #[test]
        fn stuffing_is_within_its_bounds(
            id in 0u32..0x2000_0000,
            extended: bool,
            data in proptest::collection::vec(any::<u8>(), 0..=8),
        ) {
            let id = if extended { id } else { id & 0x7FF };
            let found = bits(&classic(id, extended, &data)).slow;
            let stuffable = if extended { 54 } else { 34 } + 8 * data.len() as u64;
            prop_assert!(found >= stuffable + 10 && found <= stuffable + (stuffable - 1) / 4 + 10);
        }
    }
}
