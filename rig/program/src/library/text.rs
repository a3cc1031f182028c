//! Texts: units of one or two bytes, ended by a 0 or by the storage.

use super::{Text, TextOut};
use std::fmt;

/// What stands for a character that a STRING cannot hold.
const UNKNOWN: u16 = b'?' as u16;

impl<'a> Text<'a> {
    /// What the storage holds at a place, counted from 0, be it before the end of the text or after it.
    fn stored(self, place: usize) -> Option<u16> {
        if self.wide {
            let start = place.checked_mul(2)?;
            let pair: &[u8; 2] = self.bytes.get(start..)?.first_chunk()?;
            Some(u16::from_le_bytes(*pair))
        } else {
            self.bytes.get(place).map(|unit| u16::from(*unit))
        }
    }

    /// The units up to the end.
    pub(crate) fn units(self) -> impl Iterator<Item = u16> + 'a {
        (0..).map_while(move |place| self.stored(place)).take_while(|unit| *unit != 0)
    }

    /// Characters up to the end.
    pub(crate) fn length(self) -> usize {
        self.units().count()
    }

    /// The bytes up to the end.
    pub(super) fn stored_units(self) -> &'a [u8] {
        let width = if self.wide { 2 } else { 1 };
        self.bytes.get(..self.length() * width).unwrap_or_default()
    }

    /// The unit at a place, which must not be after the end of the text; 0 at the end.
    pub(super) fn unit(self, place: usize) -> u16 {
        self.stored(place).unwrap_or(0)
    }
}

impl<'a> TextOut<'a> {
    /// An empty text in `bytes`.
    #[cfg(test)]
    pub(crate) fn new(wide: bool, bytes: &'a mut [u8]) -> Self {
        let mut out = TextOut { wide, bytes, length: 0 };
        out.clear();
        out
    }

    /// Makes the text empty.
    pub(crate) fn clear(&mut self) {
        self.length = 0;
        self.put(0, 0);
    }

    /// Units that fit in front of the closing 0.
    pub(crate) fn capacity(&self) -> usize {
        let units = if self.wide { self.bytes.len() / 2 } else { self.bytes.len() };
        units.saturating_sub(1)
    }

    /// Adds a unit and closes the text. What does not fit is cut off.
    pub(crate) fn push(&mut self, unit: u16) {
        if self.length < self.capacity() {
            let unit = if self.wide || unit <= 0xFF { unit } else { UNKNOWN };
            self.put(self.length, unit);
            self.length += 1;
            self.put(self.length, 0);
        }
    }

    /// Adds units.
    pub(crate) fn extend(&mut self, units: impl IntoIterator<Item = u16>) {
        for unit in units {
            if self.length >= self.capacity() {
                break;
            }
            self.push(unit);
        }
    }

    fn put(&mut self, place: usize, unit: u16) {
        if self.wide {
            if let Some(pair) = self.bytes.get_mut(2 * place..2 * place + 2) {
                pair.copy_from_slice(&unit.to_le_bytes());
            }
        } else if let Some(byte) = self.bytes.get_mut(place) {
            *byte = unit as u8;
        }
    }
}

impl fmt::Write for TextOut<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        // What the library writes is ASCII.
        self.extend(text.bytes().map(u16::from));
        Ok(())
    }
}
