//! Messages that end by silence, as those of Modbus RTU.
//!
//! The kernel does not stamp bytes. What is known is when they were read, and when a look found nothing to read. So a
//! silence is known to have been at least the time from the last read to a look that found nothing, less a character
//! that may have been on its way, less what the port's hardware may hold back. A message ends when that is long enough.
//! Whether the bytes *inside* a message came close enough together cannot be seen: they wait in the hardware's buffer and
//! come in packets. A message into which a silence may have slipped unseen is [`SerialMessage::doubtful`].

use super::{Received, Symbol};
use host::HostInstant;
use signal::{SerialMessage, SerialSettings, Span, Time, When};

/// When messages end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MessageTiming {
    /// The silence that ends a message.
    pub gap: Span,
    /// How long a character lasts.
    pub character: Span,
    /// How long the hardware may keep a received byte to itself.
    pub hold: Span,
}

/// Characters for which a 16550 keeps received bytes that are too few to report.
const HELD_CHARACTERS: u64 = 4;

impl MessageTiming {
    /// Of messages with this silence between them.
    pub fn of(line: &SerialSettings, gap: Span) -> MessageTiming {
        MessageTiming { gap, character: line.lasts(1), hold: line.lasts(HELD_CHARACTERS) }
    }

    /// Of Modbus RTU.
    pub fn modbus_rtu(line: &SerialSettings) -> MessageTiming {
        MessageTiming::of(line, line.frame_gap())
    }
}

/// The instants of a message on the clock of a run, which is not known here.
pub(super) const UNSET: When = When { earliest: Time::ZERO, latest: Time::ZERO };

/// A message as it was read, or a part of one with more than [`signal::MAX_SERIAL_DATA`] bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceivedMessage {
    /// Its bytes and what was wrong with them. Its own instants are 0.
    pub message: SerialMessage,
    /// Before when nothing of it was there, and when its first byte was read.
    pub first: (HostInstant, HostInstant),
    /// When its last byte was read.
    pub last: HostInstant,
}

impl ReceivedMessage {
    fn begin(first: (HostInstant, HostInstant), continues: bool) -> ReceivedMessage {
        ReceivedMessage { message: SerialMessage::begin(UNSET, continues), first, last: first.1 }
    }

    fn none() -> ReceivedMessage {
        ReceivedMessage::begin((HostInstant::BOOT, HostInstant::BOOT), false)
    }
}

/// Puts together messages from what is read. Does no input, reads no clock and takes no memory.
#[derive(Clone, Debug)]
pub struct MessageAssembler {
    timing: MessageTiming,
    current: ReceivedMessage,
}

impl MessageAssembler {
    /// Nothing was received yet.
    pub fn new(timing: MessageTiming) -> MessageAssembler {
        MessageAssembler { timing, current: ReceivedMessage::none() }
    }

    /// Forgets the message under way.
    pub fn clear(&mut self) {
        self.current = ReceivedMessage::none();
    }

    /// When the message under way ends unless more of it comes: from then on a look that finds nothing ends it.
    pub fn due(&self) -> Option<HostInstant> {
        let MessageTiming { gap, character, hold } = self.timing;
        (!self.current.message.is_empty()).then(|| self.current.last + (gap + character + hold))
    }

    /// A look at this instant found nothing. The message that has ended by that.
    pub fn quiet(&mut self, looked: HostInstant) -> Option<ReceivedMessage> {
        let over = self.due().is_some_and(|due| looked >= due);
        over.then(|| {
            let mut ended = std::mem::replace(&mut self.current, ReceivedMessage::none());
            ended.message.ends = true;
            ended
        })
    }

    /// What was read. Hands on what is complete by that: the message that had ended before it, and full parts of a long one.
    pub fn take(&mut self, received: &Received, mut each: impl FnMut(&ReceivedMessage)) {
        if let Some(ended) = self.quiet(received.empty) {
            each(&ended);
        }
        if received.symbols.is_empty() {
            return;
        }
        let first = (received.empty, received.read);
        if self.current.message.is_empty() {
            self.current.first = first;
        } else {
            let between = received.read - self.current.last;
            let busy = self.timing.character * received.symbols.len() as i64;
            self.current.message.doubtful |= between - busy >= self.timing.gap;
        }
        for symbol in &received.symbols {
            if self.current.message.is_full() && !matches!(symbol, Symbol::Break) {
                each(&self.current);
                let doubtful = self.current.message.doubtful;
                self.current = ReceivedMessage::begin(first, true);
                self.current.message.doubtful = doubtful;
            }
            self.current.last = received.read;
            let message = &mut self.current.message;
            match *symbol {
                Symbol::Byte(byte) => {
                    message.push(byte);
                }
                Symbol::Damaged(byte) => {
                    message.errors.damaged = message.errors.damaged.saturating_add(1);
                    message.push(byte);
                }
                Symbol::Break => message.errors.breaks = message.errors.breaks.saturating_add(1),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use signal::MAX_SERIAL_DATA;

    const MS: Span = Span::from_millis(1);

    fn ms(count: i64) -> HostInstant {
        HostInstant::BOOT + MS * count
    }

    fn assembler() -> MessageAssembler {
        MessageAssembler::new(MessageTiming { gap: MS * 4, character: MS, hold: MS * 2 })
    }

    fn read(empty: HostInstant, read: HostInstant, bytes: &[u8]) -> Received {
        Received { symbols: bytes.iter().map(|byte| Symbol::Byte(*byte)).collect(), empty, read }
    }

    /// What is complete by a read.
    fn take(assembler: &mut MessageAssembler, received: &Received) -> Vec<ReceivedMessage> {
        let mut all = Vec::new();
        assembler.take(received, |message| all.push(*message));
        all
    }

    #[test]
    fn a_message_ends_when_the_silence_is_certain_and_not_before() {
        let mut assembler = assembler();
        assert_eq!((assembler.due(), assembler.quiet(HostInstant::NEVER)), (None, None));
        assert_eq!(take(&mut assembler, &read(ms(0), ms(10), b"ab")), []);
        // The gap, a character that may be on its way, and what the hardware may hold back.
        assert_eq!(assembler.due(), Some(ms(17)));
        assert_eq!(assembler.quiet(ms(17) - Span::from_nanos(1)), None);
        let ended = assembler.quiet(ms(17)).unwrap();
        assert_eq!((ended.message.data(), ended.first, ended.last), (&b"ab"[..], (ms(0), ms(10)), ms(10)));
        assert!(ended.message.is_sound());
        assert_eq!(assembler.due(), None);
    }

    #[test]
    fn bytes_after_a_silence_begin_another_message_though_nobody_looked_in_between() {
        let mut assembler = assembler();
        take(&mut assembler, &read(ms(0), ms(1), b"a"));
        let ended = take(&mut assembler, &read(ms(9), ms(11), b"b"));
        assert_eq!((ended.len(), ended[0].message.data()), (1, &b"a"[..]));
        assert_eq!(assembler.quiet(HostInstant::NEVER).unwrap().message.data(), b"b");
    }

    #[test]
    fn a_reader_that_was_away_for_too_long_does_not_take_two_messages_for_one_sound_one() {
        let mut assembler = assembler();
        take(&mut assembler, &read(ms(0), ms(1), b"a"));
        // Nothing was there at 2 ms. 9 ms later there were two bytes: they may have come at any time in between.
        assert_eq!(take(&mut assembler, &read(ms(2), ms(11), b"bc")), []);
        let ended = assembler.quiet(HostInstant::NEVER).unwrap().message;
        assert_eq!((ended.data(), ended.doubtful, ended.is_sound()), (&b"abc"[..], true, false));
        // Bytes that fill the time between two reads leave no room for a silence.
        take(&mut assembler, &read(ms(0), ms(1), b"a"));
        take(&mut assembler, &read(ms(2), ms(8), b"bcdefg"));
        assert!(assembler.quiet(HostInstant::NEVER).unwrap().message.is_sound());
    }

    #[test]
    fn harm_is_kept_with_the_message_that_it_came_to() {
        let mut assembler = assembler();
        let symbols = vec![Symbol::Byte(1), Symbol::Damaged(2), Symbol::Break, Symbol::Byte(3)];
        take(&mut assembler, &Received { symbols, empty: ms(0), read: ms(1) });
        let ended = assembler.quiet(HostInstant::NEVER).unwrap().message;
        assert_eq!((ended.data(), ended.errors.damaged, ended.errors.breaks), (&[1, 2, 3][..], 1, 1));
    }

    #[test]
    fn a_message_that_is_too_long_comes_in_parts_and_one_that_just_fits_does_not() {
        let mut assembler = assembler();
        assert_eq!(take(&mut assembler, &read(ms(0), ms(1), &[7; MAX_SERIAL_DATA])), []);
        let whole = assembler.quiet(HostInstant::NEVER).unwrap().message;
        assert_eq!((whole.data().len(), whole.continues, whole.ends), (MAX_SERIAL_DATA, false, true));

        take(&mut assembler, &read(ms(0), ms(1), &[7; MAX_SERIAL_DATA]));
        let parts = take(&mut assembler, &read(ms(1), ms(2), &[8; MAX_SERIAL_DATA + 1]));
        let shapes: Vec<(u8, bool, bool, HostInstant)> = parts
            .iter()
            .map(|part| (part.message.data()[0], part.message.continues, part.message.ends, part.last))
            .collect();
        assert_eq!(shapes, [(7, false, false, ms(1)), (8, true, false, ms(2))]);
        let last = assembler.quiet(HostInstant::NEVER).unwrap();
        assert_eq!((last.message.data(), last.message.continues, last.message.ends), (&[8][..], true, true));
        assert_eq!(last.first, (ms(1), ms(2)));
    }

    #[test]
    fn the_silence_of_modbus_follows_the_speed() {
        let timing = MessageTiming::modbus_rtu(&SerialSettings::default());
        assert_eq!((timing.gap, timing.character), (Span::from_nanos(2_005_209), Span::from_nanos(572_917)));
    }

    proptest! {
        /// Whatever is read whenever: no byte is lost or moved, and a part goes on in the next one.
        #[test]
        fn messages_are_cut_out_of_what_was_read(
            pieces in proptest::collection::vec(
                (0i64..20_000_000, 0i64..20_000_000, proptest::collection::vec(any::<u8>(), 0..400)), 0..20
            ),
        ) {
            let mut assembler = assembler();
            let (mut now, mut sent, mut got) = (HostInstant::BOOT, Vec::new(), Vec::new());
            for (idle, late, bytes) in &pieces {
                let empty = now + Span::from_nanos(*idle);
                let piece = read(empty, empty + Span::from_nanos(*late), bytes);
                now = piece.read;
                sent.extend_from_slice(bytes);
                got.extend(take(&mut assembler, &piece));
            }
            got.extend(assembler.quiet(HostInstant::NEVER));
            let mut goes_on = false;
            for part in &got {
                prop_assert!(!part.message.is_empty());
                prop_assert_eq!(part.message.continues, goes_on);
                goes_on = !part.message.ends;
                prop_assert!(!goes_on || part.message.is_full());
            }
            prop_assert!(!goes_on);
            let back: Vec<u8> = got.iter().flat_map(|part| part.message.data().to_vec()).collect();
            prop_assert_eq!(back, sent);
        }
    }
}
