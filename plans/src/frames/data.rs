//! Data of frames as a plan writes them: `01 2A`, `05 .. *`, `2#1...0...`.
//!
//! ```text
//! 01 2A      two bytes
//! 012A       the same
//! 01 ..      any second byte
//! 01 4.      a second byte from 40 to 4F
//! 2#1......0 one byte, bit by bit, the highest first
//! 05 *       05, and any number of bytes after it
//! ```

use std::fmt;

/// Most data bytes of a frame (CAN FD, ISO 11898-1).
pub const MAX_DATA: usize = 64;

/// The bits that data must have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DataPattern {
    /// Of each byte which bits count, and what they are.
    bytes: Vec<(u8, u8)>,
    /// Any number of bytes may follow.
    open: bool,
}

/// Why a text is no data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DataFault {
    /// Neither a digit nor a dot.
    #[error("a byte has two digits from 0 to F, or a dot for any")]
    Digit,
    /// A digit without its other half.
    #[error("a byte has two digits, and one is missing")]
    Half,
    /// Not eight bits after `2#`.
    #[error("after `2#` stand eight bits, each 0, 1 or a dot for any")]
    Bits,
    /// Something after `*`.
    #[error("nothing stands after `*`")]
    AfterOpen,
    /// More than [`MAX_DATA`] bytes.
    #[error("a frame has at most 64 bytes")]
    TooLong,
}

impl DataPattern {
    /// Any data.
    pub const ANY: DataPattern = DataPattern { bytes: Vec::new(), open: true };

    /// Reads data; with the byte of the text at which it goes wrong.
    ///
    /// # Errors
    /// [`DataFault`].
    pub fn parse(text: &str) -> Result<DataPattern, (usize, DataFault)> {
        let mut pattern = DataPattern { bytes: Vec::new(), open: false };
        let mut at = 0;
        while let Some(c) = text[at..].chars().next() {
            if c.is_whitespace() {
                at += c.len_utf8();
                continue;
            }
            if pattern.open {
                return Err((at, DataFault::AfterOpen));
            }
            if c == '*' {
                pattern.open = true;
                at += 1;
                continue;
            }
            let rest = &text[at..];
            let (byte, length) = match rest.strip_prefix("2#") {
                Some(bits) => (bits_of(bits).ok_or((at, DataFault::Bits))?, 10),
                None => (digits_of(rest).map_err(|fault| (at, fault))?, 2),
            };
            if pattern.bytes.len() >= MAX_DATA {
                return Err((at, DataFault::TooLong));
            }
            pattern.bytes.push(byte);
            at += length;
        }
        Ok(pattern)
    }

    /// Whether data are like this.
    #[inline]
    pub fn matches(&self, data: &[u8]) -> bool {
        let long_enough =
            if self.open { data.len() >= self.bytes.len() } else { data.len() == self.bytes.len() };
        long_enough && self.bytes.iter().zip(data).all(|((mask, value), byte)| byte & mask == *value)
    }

    /// The bytes, where it leaves nothing open.
    pub fn exact(&self) -> Option<Vec<u8>> {
        let byte = |(mask, value): &(u8, u8)| (*mask == 0xFF).then_some(*value);
        if self.open { None } else { self.bytes.iter().map(byte).collect() }
    }

    /// The least number of bytes.
    pub fn least(&self) -> usize {
        self.bytes.len()
    }

    /// Whether it says nothing of the data.
    pub fn is_any(&self) -> bool {
        self.open && self.bytes.iter().all(|(mask, _)| *mask == 0)
    }
}

impl fmt::Display for DataPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut between = "";
        for (mask, value) in &self.bytes {
            f.write_str(between)?;
            between = " ";
            let nibble = |shift: u8| match mask >> shift & 0xF {
                0xF => char::from_digit(u32::from(value >> shift & 0xF), 16).map(|c| c.to_ascii_uppercase()),
                0 => Some('.'),
                _ => None,
            };
            match (nibble(4), nibble(0)) {
                (Some(high), Some(low)) => write!(f, "{high}{low}")?,
                _ => {
                    f.write_str("2#")?;
                    for bit in (0..8).rev() {
                        let known = ['0', '1'][usize::from(value >> bit & 1)];
                        write!(f, "{}", if mask >> bit & 1 == 1 { known } else { '.' })?;
                    }
                }
            }
        }
        if self.open { write!(f, "{between}*") } else { Ok(()) }
    }
}

/// Eight bits at the beginning of a text.
fn bits_of(text: &str) -> Option<(u8, u8)> {
    let (mut mask, mut value) = (0, 0);
    let bits = text.as_bytes().get(..8)?;
    for bit in bits {
        let (known, one) = match bit {
            b'0' => (1, 0),
            b'1' => (1, 1),
            b'.' => (0, 0),
            _ => return None,
        };
        (mask, value) = (mask << 1 | known, value << 1 | one);
    }
    Some((mask, value))
}

/// Two digits at the beginning of a text.
fn digits_of(text: &str) -> Result<(u8, u8), DataFault> {
    let mut byte = (0, 0);
    let mut chars = text.chars();
    for place in 0..2 {
        let digit = match chars.next() {
            Some('.') => (0, 0),
            Some(c) => match c.to_digit(16) {
                Some(digit) => (0xF, digit as u8),
                None if place == 1 && (c.is_whitespace() || c == '*') => return Err(DataFault::Half),
                None => return Err(DataFault::Digit),
            },
            None => return Err(DataFault::Half),
        };
        byte = (byte.0 << 4 | digit.0, byte.1 << 4 | digit.1);
    }
    Ok(byte)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn like(text: &str, data: &[u8]) -> bool {
        DataPattern::parse(text).unwrap().matches(data)
    }

    #[test]
    fn data_are_like_their_pattern() {
        assert!(like("01 2A", &[1, 0x2A]) && like("012a", &[1, 0x2A]));
        assert!(!like("01 2A", &[1, 0x2A, 0]) && !like("01 2A", &[1]));
        assert!(like("01 ..", &[1, 7]) && like("01....", &[1, 7, 9]) && !like("01 ..", &[2, 7]));
        assert!(like("4.", &[0x4F]) && !like("4.", &[0x5F]) && like(".4", &[0xF4]));
        assert!(
            like("2#1......0", &[0x80]) && !like("2#1......0", &[0x81]) && like("2#........ 05", &[9, 5])
        );
        assert!(like("05 *", &[5]) && like("05 *", &[5; 9]) && !like("05 *", &[]));
        assert!(like("", &[]) && !like("", &[0]) && like("*", &[1, 2]));
    }

    #[test]
    fn what_is_wrong_has_its_place() {
        let fault = |text: &str| DataPattern::parse(text).unwrap_err();
        assert_eq!(fault("01 2"), (3, DataFault::Half));
        assert_eq!(fault("1 02"), (0, DataFault::Half));
        assert_eq!(fault("0G"), (0, DataFault::Digit));
        assert_eq!(fault("01 2#0101"), (3, DataFault::Bits));
        assert_eq!(fault("* 01"), (2, DataFault::AfterOpen));
        assert_eq!(fault(&"00".repeat(65)), (128, DataFault::TooLong));
    }

    #[test]
    fn only_whole_bytes_can_be_sent() {
        let exact = |text: &str| DataPattern::parse(text).unwrap().exact();
        assert_eq!(exact("01 FF"), Some(vec![1, 0xFF]));
        assert_eq!((exact("01 .."), exact("01 *"), exact("2#1.......")), (None, None, None));
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC*", near in "([0-9A-F]{2}| |\\.|2#|[01.]{8}|\\*|é){0,20}") {
            for text in [&text, &near] {
                if let Err((at, _)) = DataPattern::parse(text) {
                    prop_assert!(text.is_char_boundary(at));
                }
            }
        }

        #[test]
        fn what_is_shown_reads_the_same(
            bytes in proptest::collection::vec((any::<u8>(), any::<u8>()), 0..=64),
            open: bool,
        ) {
            let bytes = bytes.into_iter().map(|(mask, value)| (mask, value & mask)).collect();
            let pattern = DataPattern { bytes, open };
            prop_assert_eq!(DataPattern::parse(&pattern.to_string()), Ok(pattern));
        }

        #[test]
        fn bytes_are_like_themselves(data in proptest::collection::vec(any::<u8>(), 0..=64)) {
            let text: String = data.iter().map(|byte| format!("{byte:02x} ")).collect();
            let pattern = DataPattern::parse(&text).unwrap();
            prop_assert!(pattern.matches(&data));
            prop_assert_eq!(pattern.exact(), Some(data));
        }
    }
}
