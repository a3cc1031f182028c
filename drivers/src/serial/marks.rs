//! What the kernel marks in the bytes that it received: breaks, and bytes that arrived damaged.
//!
//! With PARMRK set (`termios(3)`) the kernel writes `377 000 X` for a byte X with wrong parity or a missing stop bit,
//! `377 000 000` for a break, and `377 377` for a sound byte of 377. A damaged byte of zeros looks like a break: on the
//! line it nearly is one.

/// What came over a serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Symbol {
    /// A byte.
    Byte(u8),
    /// A byte with wrong parity or a missing stop bit, as it was received.
    Damaged(u8),
    /// The line was held at 0 for longer than a character.
    Break,
}

const MARK: u8 = 0xFF;

/// Reads marks out of bytes that come in pieces, of any size and content.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks {
    /// What was received of a mark so far.
    open: Open,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Open {
    #[default]
    Nothing,
    /// 377.
    Mark,
    /// 377 000.
    Error,
}

impl Marks {
    /// The next byte as the kernel hands it on. At most two symbols are complete with it.
    pub fn take(&mut self, byte: u8, mut each: impl FnMut(Symbol)) {
        self.open = match (self.open, byte) {
            (Open::Nothing, MARK) => Open::Mark,
            (Open::Nothing, _) => {
                each(Symbol::Byte(byte));
                Open::Nothing
            }
            (Open::Mark, 0) => Open::Error,
            (Open::Mark, MARK) => {
                each(Symbol::Byte(MARK));
                Open::Nothing
            }
            // The kernel writes no such thing. Nothing is lost of it.
            (Open::Mark, _) => {
                each(Symbol::Byte(MARK));
                each(Symbol::Byte(byte));
                Open::Nothing
            }
            (Open::Error, 0) => {
                each(Symbol::Break);
                Open::Nothing
            }
            (Open::Error, _) => {
                each(Symbol::Damaged(byte));
                Open::Nothing
            }
        };
    }

    /// Whether a mark has begun and is not complete.
    pub fn is_open(&self) -> bool {
        self.open != Open::Nothing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the kernel writes for a symbol.
    fn written(symbol: Symbol) -> Vec<u8> {
        match symbol {
            Symbol::Byte(MARK) => vec![MARK, MARK],
            Symbol::Byte(byte) => vec![byte],
            Symbol::Damaged(byte) => vec![MARK, 0, byte],
            Symbol::Break => vec![MARK, 0, 0],
        }
    }

    fn symbols(bytes: &[u8], marks: &mut Marks) -> Vec<Symbol> {
        let mut all = Vec::new();
        bytes.iter().for_each(|byte| marks.take(*byte, |symbol| all.push(symbol)));
        all
    }

    #[test]
    fn marks_are_what_the_kernel_writes() {
        let bytes = [b'a', 0xFF, 0xFF, 0xFF, 0, 0, 0, 0xFF, 0, b'x', 0xFF, 0, 0xFF];
        let wanted = [
            Symbol::Byte(b'a'),
            Symbol::Byte(0xFF),
            Symbol::Break,
            Symbol::Byte(0),
            Symbol::Damaged(b'x'),
            Symbol::Damaged(0xFF),
        ];
        assert_eq!(symbols(&bytes, &mut Marks::default()), wanted);
    }

    proptest! {
        #[test]
        fn what_the_kernel_writes_comes_back_whatever_the_pieces(
            sent in proptest::collection::vec(
                prop_oneof![
                    any::<u8>().prop_map(Symbol::Byte),
                    (1u8..).prop_map(Symbol::Damaged),
                    Just(Symbol::Break),
                ],
                0..50,
            ),
            cut in 1usize..7,
        ) {
            let bytes: Vec<u8> = sent.iter().copied().flat_map(written).collect();
            let mut marks = Marks::default();
            let back: Vec<Symbol> =
                bytes.chunks(cut).flat_map(|piece| symbols(piece, &mut marks)).collect();
            prop_assert_eq!(back, sent);
            prop_assert!(!marks.is_open());
        }

        #[test]
        fn no_byte_is_lost_or_made_of_nothing(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let mut marks = Marks::default();
            let all = symbols(&bytes, &mut marks);
            prop_assert!(all.len() <= bytes.len());
            prop_assert!(all.len() * 3 + 2 >= bytes.len());
        }
    }
}
