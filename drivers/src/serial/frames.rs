//! Frames that end by silence, as those of Modbus RTU.
//!
//! The kernel does not stamp bytes. What is known is when they were read, and when a look found nothing to read. So a
//! silence is known to have been at least the time from the last read to a look that found nothing, less a character
//! that may have been on its way, less what the port's hardware may hold back. A frame ends when that is long enough.
//! Whether the bytes *inside* a frame came close enough together cannot be seen: they wait in the hardware's buffer and
//! come in packets. A frame into which a silence may have slipped unseen is [`LineFrame::doubtful`].

use super::{Received, Symbol};
use host::HostInstant;
use signal::{MAX_SERIAL_DATA, SerialSettings, Span};

/// How frames end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Framing {
    /// The silence that ends a frame.
    pub gap: Span,
    /// How long a character lasts.
    pub character: Span,
    /// How long the hardware may keep a received byte to itself.
    pub hold: Span,
    /// The most bytes of a frame; what is longer is cut off and [`LineFrame::overlong`].
    pub most: usize,
}

/// Characters for which a 16550 keeps received bytes that are too few to tell of.
const HELD_CHARACTERS: u64 = 4;

impl Framing {
    /// Of messages with this silence between them, of at most [`MAX_SERIAL_DATA`] bytes.
    pub fn of(line: &SerialSettings, gap: Span) -> Framing {
        Framing { gap, most: MAX_SERIAL_DATA, ..Framing::modbus_rtu(line) }
    }

    /// Of Modbus RTU: frames of at most 256 bytes.
    pub fn modbus_rtu(line: &SerialSettings) -> Framing {
        Framing {
            gap: line.frame_gap(),
            character: line.lasts(1),
            hold: line.lasts(HELD_CHARACTERS),
            most: 256,
        }
    }
}

/// A frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LineFrame {
    /// Its bytes, damaged ones as they came.
    pub bytes: Vec<u8>,
    /// How many of them were damaged.
    pub damaged: u32,
    /// Breaks in it.
    pub breaks: u32,
    /// It had more bytes than a frame may have.
    pub overlong: bool,
    /// A silence may have slipped into it unseen: it may be two.
    pub doubtful: bool,
    /// When its first byte was read, and before when nothing of it was there.
    pub first: (HostInstant, HostInstant),
    /// When its last byte was read.
    pub last: HostInstant,
}

impl LineFrame {
    /// Whether it arrived whole and unharmed, as far as the line can tell.
    pub fn is_sound(&self) -> bool {
        self.damaged == 0 && self.breaks == 0 && !self.overlong && !self.doubtful
    }

    fn is_empty(&self) -> bool {
        self.bytes.is_empty() && self.breaks == 0
    }
}

/// Puts together frames from what is read. Does no input and reads no clock.
#[derive(Clone, Debug)]
pub struct Frames {
    framing: Framing,
    current: LineFrame,
}

impl Frames {
    /// Nothing was received yet.
    pub fn new(framing: Framing) -> Frames {
        let bytes = Vec::with_capacity(framing.most);
        Frames { framing, current: LineFrame { bytes, ..LineFrame::default() } }
    }

    /// When the frame under way ends unless more of it comes: from then on a look that finds nothing ends it.
    pub fn due(&self) -> Option<HostInstant> {
        let Framing { gap, character, hold, .. } = self.framing;
        let silent = gap + character + hold;
        (!self.current.is_empty()).then(|| self.current.last + silent)
    }

    /// A look at this instant found nothing. The frame that has ended by that.
    pub fn quiet(&mut self, looked: HostInstant) -> Option<LineFrame> {
        let over = self.due().is_some_and(|due| looked >= due);
        over.then(|| {
            let bytes = Vec::with_capacity(self.framing.most);
            std::mem::replace(&mut self.current, LineFrame { bytes, ..LineFrame::default() })
        })
    }

    /// What was read. The frame that had ended before it.
    pub fn take(&mut self, received: &Received) -> Option<LineFrame> {
        let ended = self.quiet(received.empty);
        if received.symbols.is_empty() {
            return ended;
        }
        if self.current.is_empty() {
            self.current.first = (received.empty, received.read);
        } else {
            let Framing { gap, character, .. } = self.framing;
            let between = received.read - self.current.last;
            let busy = character * received.symbols.len() as i64;
            self.current.doubtful |= between - busy >= gap;
        }
        self.current.last = received.read;
        for symbol in &received.symbols {
            let byte = match *symbol {
                Symbol::Byte(byte) => byte,
                Symbol::Damaged(byte) => {
                    self.current.damaged = self.current.damaged.saturating_add(1);
                    byte
                }
                Symbol::Break => {
                    self.current.breaks = self.current.breaks.saturating_add(1);
                    continue;
                }
            };
            if self.current.bytes.len() < self.framing.most {
                self.current.bytes.push(byte);
            } else {
                self.current.overlong = true;
            }
        }
        ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: Span = Span::from_millis(1);

    fn ms(count: i64) -> HostInstant {
        HostInstant::BOOT + MS * count
    }

    fn framing() -> Framing {
        Framing { gap: MS * 4, character: MS, hold: MS * 2, most: 8 }
    }

    fn read(empty: HostInstant, read: HostInstant, bytes: &[u8]) -> Received {
        Received { symbols: bytes.iter().map(|byte| Symbol::Byte(*byte)).collect(), empty, read }
    }

    #[test]
    fn a_frame_ends_when_the_silence_is_certain_and_not_before() {
        let mut frames = Frames::new(framing());
        assert_eq!((frames.due(), frames.quiet(HostInstant::NEVER)), (None, None));
        assert_eq!(frames.take(&read(ms(0), ms(10), b"ab")), None);
        // The gap, a character that may be on its way, and what the hardware may hold back.
        assert_eq!(frames.due(), Some(ms(17)));
        assert_eq!(frames.quiet(ms(17) - Span::from_nanos(1)), None);
        let frame = frames.quiet(ms(17)).unwrap();
        assert_eq!((&*frame.bytes, frame.first, frame.last), (&b"ab"[..], (ms(0), ms(10)), ms(10)));
        assert!(frame.is_sound());
        assert_eq!(frames.due(), None);
    }

    #[test]
    fn bytes_behind_a_silence_begin_another_frame_though_nobody_looked_in_between() {
        let mut frames = Frames::new(framing());
        frames.take(&read(ms(0), ms(1), b"a"));
        let first = frames.take(&read(ms(9), ms(11), b"b")).unwrap();
        assert_eq!(first.bytes, b"a");
        assert_eq!(frames.quiet(HostInstant::NEVER).unwrap().bytes, b"b");
    }

    #[test]
    fn a_reader_that_was_away_for_too_long_does_not_take_two_frames_for_one_sound_one() {
        let mut frames = Frames::new(framing());
        frames.take(&read(ms(0), ms(1), b"a"));
        // Nothing was there at 2 ms. 9 ms later there were two bytes: they may have come at any time in between.
        assert_eq!(frames.take(&read(ms(2), ms(11), b"bc")), None);
        let frame = frames.quiet(HostInstant::NEVER).unwrap();
        assert_eq!((&*frame.bytes, frame.doubtful, frame.is_sound()), (&b"abc"[..], true, false));
        // Bytes that fill the time between two reads leave no room for a silence.
        frames.take(&read(ms(0), ms(1), b"a"));
        frames.take(&read(ms(2), ms(8), b"bcdefg"));
        assert!(frames.quiet(HostInstant::NEVER).unwrap().is_sound());
    }

    #[test]
    fn harm_is_kept_with_the_frame_that_it_came_to() {
        let mut frames = Frames::new(framing());
        let symbols = vec![Symbol::Byte(1), Symbol::Damaged(2), Symbol::Break, Symbol::Byte(3)];
        frames.take(&Received { symbols, empty: ms(0), read: ms(1) });
        let frame = frames.quiet(HostInstant::NEVER).unwrap();
        assert_eq!((frame.bytes.as_slice(), frame.damaged, frame.breaks), (&[1, 2, 3][..], 1, 1));
        frames.take(&read(ms(0), ms(1), b"123456789"));
        let frame = frames.quiet(HostInstant::NEVER).unwrap();
        assert_eq!((frame.bytes.len(), frame.overlong, frame.is_sound()), (8, true, false));
    }

    #[test]
    fn the_silence_of_modbus_follows_the_speed() {
        let framing = Framing::modbus_rtu(&SerialSettings::default());
        assert_eq!(
            (framing.gap, framing.character, framing.most),
            (Span::from_nanos(2_005_209), Span::from_nanos(572_917), 256)
        );
    }

    proptest! {
        /// Whatever is read whenever: no byte is lost or moved, no frame is longer than it may be.
        #[test]
        fn frames_are_cut_out_of_what_was_read(
            pieces in proptest::collection::vec(
                (0i64..20_000_000, 0i64..20_000_000, proptest::collection::vec(any::<u8>(), 0..6)), 0..20
            ),
        ) {
            let mut frames = Frames::new(Framing { most: 1_000, ..framing() });
            let (mut now, mut sent, mut got) = (HostInstant::BOOT, Vec::new(), Vec::new());
            for (idle, late, bytes) in &pieces {
                let piece = read(now + Span::from_nanos(*idle), now + Span::from_nanos(idle + late), bytes);
                now = piece.read;
                sent.extend_from_slice(bytes);
                got.extend(frames.take(&piece));
            }
            got.extend(frames.quiet(HostInstant::NEVER));
            prop_assert!(got.iter().all(|frame| !frame.bytes.is_empty() && !frame.overlong));
            let back: Vec<u8> = got.into_iter().flat_map(|frame| frame.bytes).collect();
            prop_assert_eq!(back, sent);
        }
    }
}
