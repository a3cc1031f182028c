//! Bytes become lines.

use control::LONGEST_LINE;

/// A line of a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ClientLine {
    /// Its bytes, without the end.
    Whole(Vec<u8>),
    /// It was too long, and is passed over up to its end.
    TooLong,
}

/// The bytes of a client that are no line yet. They are never many more than the longest line.
#[derive(Debug, Default)]
pub(super) struct ClientLines {
    bytes: Vec<u8>,
    /// How many of them hold no end of a line.
    searched: usize,
    /// The end of a line that was too long has not come yet.
    skips: bool,
    over: bool,
}

impl ClientLines {
    /// Takes further bytes.
    pub(super) fn put(&mut self, mut bytes: &[u8]) {
        if self.skips {
            let Some(end) = bytes.iter().position(|&byte| byte == b'\n') else { return };
            self.skips = false;
            bytes = &bytes[end + 1..];
        }
        self.bytes.extend_from_slice(bytes);
    }

    /// Nothing follows: what is there is the last line.
    pub(super) fn end(&mut self) {
        self.over = true;
    }

    /// Nothing follows, and nothing is left.
    pub(super) fn is_over(&self) -> bool {
        self.over && self.bytes.is_empty()
    }

    /// The next line. An empty one is a line, too: whoever sends it is answered.
    pub(super) fn next(&mut self) -> Option<ClientLine> {
        let found = self.bytes[self.searched..].iter().position(|&byte| byte == b'\n');
        let Some(at) = found.map(|at| at + self.searched) else {
            self.searched = self.bytes.len();
            // A line that fits has its end within the longest; this one has none yet.
            if self.bytes.len() >= LONGEST_LINE {
                self.forget(self.bytes.len());
                self.skips = !self.over;
                return Some(ClientLine::TooLong);
            }
            let rest = self.over.then(|| std::mem::take(&mut self.bytes))?;
            self.searched = 0;
            // Nothing after the end of the last line is no line.
            return (!rest.is_empty()).then_some(ClientLine::Whole(rest));
        };
        if at >= LONGEST_LINE {
            self.forget(at + 1);
            return Some(ClientLine::TooLong);
        }
        let line = self.bytes[..at].to_vec();
        self.forget(at + 1);
        Some(ClientLine::Whole(line))
    }

    fn forget(&mut self, bytes: usize) {
        self.bytes.drain(..bytes);
        self.searched = 0;
        // Room for long lines is given back once nothing is left: a thousand clients may have had one each.
        if self.bytes.is_empty() {
            self.bytes = Vec::new();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all(lines: &mut ClientLines) -> Vec<ClientLine> {
        std::iter::from_fn(|| lines.next()).collect()
    }

    #[test]
    fn the_longest_line_is_read_and_a_longer_one_passed_over() {
        let fits = vec![b'a'; LONGEST_LINE - 1];
        let mut bytes = fits.clone();
        bytes.push(b'\n');
        bytes.extend(vec![b'b'; LONGEST_LINE]);
        bytes.extend(b"\nc\n");
        for piece in [1, 4096, bytes.len()] {
            let (mut lines, mut read) = (ClientLines::default(), Vec::new());
            for part in bytes.chunks(piece) {
                lines.put(part);
                read.extend(all(&mut lines));
                assert!(lines.bytes.capacity() <= 4 * LONGEST_LINE);
            }
            assert_eq!(
                read,
                [ClientLine::Whole(fits.clone()), ClientLine::TooLong, ClientLine::Whole(b"c".to_vec())]
            );
        }
    }

    #[test]
    fn what_has_no_end_is_a_line_once_nothing_follows() {
        let mut lines = ClientLines::default();
        lines.put(b"\n\nhalf");
        assert_eq!(all(&mut lines), [ClientLine::Whole(Vec::new()), ClientLine::Whole(Vec::new())]);
        lines.end();
        assert_eq!(all(&mut lines), [ClientLine::Whole(b"half".to_vec())]);
        assert!(lines.is_over());
    }

    proptest! {
        #[test]
        fn how_bytes_are_cut_never_shows(
            bytes in prop::collection::vec(prop_oneof![Just(b'\n'), Just(b' '), any::<u8>()], 0..200),
            piece in 1usize..50,
        ) {
            let mut whole = ClientLines::default();
            whole.put(&bytes);
            whole.end();
            let mut pieces = ClientLines::default();
            let mut read = Vec::new();
            for part in bytes.chunks(piece) {
                pieces.put(part);
                read.extend(all(&mut pieces));
            }
            pieces.end();
            read.extend(all(&mut pieces));
            prop_assert_eq!(all(&mut whole), read);
            prop_assert!(whole.is_over() && pieces.is_over());
        }
    }
}
