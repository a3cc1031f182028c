//! How bytes are made of bits on a serial line, and how long they take.

/// The parity bit of a byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Parity {
    /// None is sent.
    None,
    /// With it the number of ones is even.
    Even,
    /// With it the number of ones is odd.
    Odd,
}

impl Parity {
    /// Its letter in settings such as `8E1`.
    pub const fn letter(self) -> char {
        match self {
            Parity::None => 'N',
            Parity::Even => 'E',
            Parity::Odd => 'O',
        }
    }
}

/// How a serial line carries bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LineSettings {
    /// Symbols a second, above 0.
    pub baud: u32,
    /// Bits of a byte: 5 to 8.
    pub data_bits: u8,
    /// Its parity bit.
    pub parity: Parity,
    /// Stop bits: 1 or 2.
    pub stop_bits: u8,
}

impl Default for LineSettings {
    /// 19200 Bd, 8E1: what Modbus over serial line asks of every device.
    fn default() -> LineSettings {
        LineSettings { baud: 19_200, data_bits: 8, parity: Parity::Even, stop_bits: 1 }
    }
}

/// Above this speed the silences of Modbus RTU do not get shorter any more, in Bd.
const FIXED_ABOVE: u32 = 19_200;

impl LineSettings {
    /// Bits of a character on the line: start bit, data, parity, stop bits.
    pub const fn bits(&self) -> u32 {
        let parity = match self.parity {
            Parity::None => 0,
            Parity::Even | Parity::Odd => 1,
        };
        1 + self.data_bits as u32 + parity + self.stop_bits as u32
    }

    /// How long so many characters take on the line, in nanoseconds, rounded up.
    pub const fn lasts(&self, characters: u64) -> i64 {
        self.tenths(characters.saturating_mul(10))
    }

    /// As [`LineSettings::lasts`], of tenths of a character.
    const fn tenths(&self, tenths: u64) -> i64 {
        let baud = if self.baud == 0 { 1 } else { self.baud as u128 };
        let nanos = (tenths as u128 * self.bits() as u128 * 100_000_000).div_ceil(baud);
        if nanos > i64::MAX as u128 { i64::MAX } else { nanos as i64 }
    }

    /// The silence that ends a frame of Modbus RTU, in nanoseconds: 3.5 characters, from 19200 Bd on 1.75 ms
    /// (Modbus over serial line V1.02, 2.5.1.1).
    pub const fn frame_gap(&self) -> i64 {
        if self.baud > FIXED_ABOVE { 1_750_000 } else { self.tenths(35) }
    }

    /// The longest silence inside a frame of Modbus RTU, in nanoseconds: 1.5 characters, above 19200 Bd 0.75 ms.
    pub const fn character_gap(&self) -> i64 {
        if self.baud > FIXED_ABOVE { 750_000 } else { self.tenths(15) }
    }
}

impl std::fmt::Display for LineSettings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} Bd {}{}{}", self.baud, self.data_bits, self.parity.letter(), self.stop_bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(baud: u32, data_bits: u8, parity: Parity, stop_bits: u8) -> LineSettings {
        LineSettings { baud, data_bits, parity, stop_bits }
    }

    #[test]
    fn a_character_lasts_as_long_as_its_bits() {
        assert_eq!(LineSettings::default().bits(), 11);
        assert_eq!(at(9_600, 8, Parity::None, 1).lasts(1), 1_041_667);
        assert_eq!(at(9_600, 8, Parity::None, 1).lasts(96), 100_000_000);
        assert_eq!(at(115_200, 7, Parity::Odd, 2).bits(), 11);
        assert_eq!(at(1, 8, Parity::None, 1).lasts(u64::MAX), i64::MAX);
    }

    #[test]
    fn the_silences_of_modbus_are_those_of_its_standard() {
        // 3.5 and 1.5 characters of 11 bits at 19200 Bd.
        assert_eq!(LineSettings::default().frame_gap(), 2_005_209);
        assert_eq!(LineSettings::default().character_gap(), 859_375);
        let fast = at(115_200, 8, Parity::Even, 1);
        assert_eq!((fast.frame_gap(), fast.character_gap()), (1_750_000, 750_000));
        assert_eq!(at(1_200, 8, Parity::None, 2).frame_gap(), 32_083_334);
    }
}
