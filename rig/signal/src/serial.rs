//! Characters of serial lines: how they are made of bits, how long they take, and what was received of them.

use std::fmt;

use crate::{Span, When};

/// The most bytes of a [`SerialMessage`]: those of a frame of Modbus RTU (Modbus over serial line V1.02, 2.5.1). What is
/// longer comes in parts.
pub const MAX_SERIAL_DATA: usize = 256;

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
pub struct SerialSettings {
    /// Symbols a second, above 0.
    pub baud: u32,
    /// Bits of a byte: 5 to 8.
    pub data_bits: u8,
    /// Its parity bit.
    pub parity: Parity,
    /// Stop bits: 1 or 2.
    pub stop_bits: u8,
}

impl Default for SerialSettings {
    /// 19200 Bd, 8E1: what Modbus over serial line asks of every device.
    fn default() -> SerialSettings {
        SerialSettings { baud: 19_200, data_bits: 8, parity: Parity::Even, stop_bits: 1 }
    }
}

/// Above this speed the silences of Modbus RTU do not get shorter any more, in Bd.
const FIXED_ABOVE: u32 = 19_200;

impl SerialSettings {
    /// Bits of a character on the line: start bit, data, parity, stop bits.
    pub const fn bits(&self) -> u32 {
        let parity = match self.parity {
            Parity::None => 0,
            Parity::Even | Parity::Odd => 1,
        };
        1 + self.data_bits as u32 + parity + self.stop_bits as u32
    }

    /// How long so many characters take on the line, rounded up to whole nanoseconds.
    pub const fn lasts(&self, characters: u64) -> Span {
        self.tenths(characters.saturating_mul(10))
    }

    /// As [`SerialSettings::lasts`], of tenths of a character.
    const fn tenths(&self, tenths: u64) -> Span {
        let baud = if self.baud == 0 { 1 } else { self.baud as u128 };
        let nanos = (tenths as u128 * self.bits() as u128 * 100_000_000).div_ceil(baud);
        if nanos > i64::MAX as u128 { Span::MAX } else { Span::from_nanos(nanos as i64) }
    }

    /// The silence that ends a frame of Modbus RTU: 3.5 characters, above 19200 Bd 1.75 ms
    /// (Modbus over serial line V1.02, 2.5.1.1).
    pub const fn frame_gap(&self) -> Span {
        if self.baud > FIXED_ABOVE { Span::from_micros(1_750) } else { self.tenths(35) }
    }

    /// The longest silence inside a frame of Modbus RTU: 1.5 characters, above 19200 Bd 0.75 ms.
    pub const fn character_gap(&self) -> Span {
        if self.baud > FIXED_ABOVE { Span::from_micros(750) } else { self.tenths(15) }
    }
}

impl fmt::Display for SerialSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} Bd {}{}{}", self.baud, self.data_bits, self.parity.letter(), self.stop_bits)
    }
}

/// What was wrong with the characters of a message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct SerialErrors {
    /// Characters with a wrong parity bit.
    pub parity: u16,
    /// Characters without a stop bit.
    pub framing: u16,
    /// Characters with one of both, where the receiver does not say which.
    pub damaged: u16,
    /// Times that the line was held at 0 for longer than a character.
    pub breaks: u16,
    /// Times that the receiver lost characters, at least.
    pub overruns: u16,
}

impl SerialErrors {
    /// Nothing was wrong.
    pub const NONE: SerialErrors = SerialErrors { parity: 0, framing: 0, damaged: 0, breaks: 0, overruns: 0 };

    /// Whether anything was wrong.
    pub fn any(&self) -> bool {
        *self != SerialErrors::NONE
    }
}

/// Characters that came one after another on a serial line, until it was silent for as long as the line's message gap.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct SerialMessage {
    /// When its first character began.
    pub first: When,
    /// When its last character ended, by its first stop bit.
    pub last: When,
    /// What was wrong with its characters.
    pub errors: SerialErrors,
    /// It is the next part of a message longer than [`MAX_SERIAL_DATA`].
    pub continues: bool,
    /// The line was silent after it; else it is full, and goes on in the next one.
    pub ends: bool,
    /// A silence may have slipped into it unseen, because the rig was late: it may be two messages.
    pub doubtful: bool,
    len: u16,
    data: [u8; MAX_SERIAL_DATA],
}

impl SerialMessage {
    /// A message without a character yet.
    pub fn begin(first: When, continues: bool) -> SerialMessage {
        SerialMessage {
            first,
            last: first,
            errors: SerialErrors::NONE,
            continues,
            ends: false,
            doubtful: false,
            len: 0,
            data: [0; MAX_SERIAL_DATA],
        }
    }

    /// A whole message without errors, of at most [`MAX_SERIAL_DATA`] bytes; the rest is left out.
    pub fn of(first: When, last: When, data: &[u8]) -> SerialMessage {
        let mut message = SerialMessage { last, ends: true, ..SerialMessage::begin(first, false) };
        data.iter().for_each(|byte| {
            message.push(*byte);
        });
        message
    }

    /// Appends a byte; FALSE where there is no room.
    pub fn push(&mut self, byte: u8) -> bool {
        let Some(place) = self.data.get_mut(usize::from(self.len)) else { return false };
        *place = byte;
        self.len += 1;
        true
    }

    /// Its bytes, damaged ones as they were received.
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }

    /// Whether there is room for no more bytes.
    pub fn is_full(&self) -> bool {
        usize::from(self.len) >= MAX_SERIAL_DATA
    }

    /// Whether nothing was received: neither a byte nor a break.
    pub fn is_empty(&self) -> bool {
        self.len == 0 && self.errors.breaks == 0
    }

    /// Whether it is certainly one whole message, of characters of which none was damaged or lost.
    pub fn is_sound(&self) -> bool {
        self.ends && !self.continues && !self.doubtful && !self.errors.any()
    }
}

impl fmt::Debug for SerialMessage {
    /// `01 03 00 0A, parity 1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut between = "";
        for byte in self.data() {
            write!(f, "{between}{byte:02X}")?;
            between = " ";
        }
        let SerialErrors { parity, framing, damaged, breaks, overruns } = self.errors;
        let errors = [
            ("parity", parity),
            ("framing", framing),
            ("damaged", damaged),
            ("break", breaks),
            ("overrun", overruns),
        ];
        for (name, times) in errors.into_iter().filter(|(_, times)| *times > 0) {
            write!(f, "{between}{name} {times}")?;
            between = ", ";
        }
        if self.ends { Ok(()) } else { write!(f, "{between}...") }
    }
}

/// How one character of an output is sent wrong on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SerialFlaw {
    /// With the wrong parity bit.
    Parity,
    /// With the line at 0 where its first stop bit belongs.
    Framing,
}

/// What is sent on a serial line: characters, or a break.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SerialOutput {
    /// Characters one after another.
    Characters {
        /// The bytes: 1 to [`MAX_SERIAL_DATA`].
        data: Vec<u8>,
        /// How long the line is at rest between two of them, from 0.
        gap: Span,
        /// The place of a character that is sent wrong, from 0.
        flaw: Option<(u16, SerialFlaw)>,
    },
    /// The line at 0 for so long, above 0.
    Break(Span),
}

impl SerialOutput {
    /// Characters without a gap, as they ought to be.
    pub fn plain(data: &[u8]) -> SerialOutput {
        SerialOutput::Characters { data: data.to_vec(), gap: Span::ZERO, flaw: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(baud: u32, data_bits: u8, parity: Parity, stop_bits: u8) -> SerialSettings {
        SerialSettings { baud, data_bits, parity, stop_bits }
    }

    #[test]
    fn a_character_lasts_as_long_as_its_bits() {
        assert_eq!(SerialSettings::default().bits(), 11);
        assert_eq!(at(9_600, 8, Parity::None, 1).lasts(1), Span::from_nanos(1_041_667));
        assert_eq!(at(9_600, 8, Parity::None, 1).lasts(96), Span::from_millis(100));
        assert_eq!(at(115_200, 7, Parity::Odd, 2).bits(), 11);
        assert_eq!(at(1, 8, Parity::None, 1).lasts(u64::MAX), Span::MAX);
    }

    #[test]
    fn the_silences_of_modbus_are_those_of_its_standard() {
        // 3.5 and 1.5 characters of 11 bits at 19200 Bd.
        assert_eq!(SerialSettings::default().frame_gap(), Span::from_nanos(2_005_209));
        assert_eq!(SerialSettings::default().character_gap(), Span::from_nanos(859_375));
        let fast = at(115_200, 8, Parity::Even, 1);
        assert_eq!(
            (fast.frame_gap(), fast.character_gap()),
            (Span::from_micros(1_750), Span::from_micros(750))
        );
        assert_eq!(at(1_200, 8, Parity::None, 2).frame_gap(), Span::from_nanos(32_083_334));
    }
}
