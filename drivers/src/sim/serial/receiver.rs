//! What an end of a simulated serial line makes of the levels on it, as the receiver of a UART does.
//!
//! A falling edge begins a character. Half a bit later the line is still at 0, or it was no start bit. Then each bit is
//! sampled in its middle, up to the first stop bit. The next start bit is waited for from that sample on; after a stop bit
//! that was 0 the line has to come back to 1 first. The sender's settings do not matter to it: bits that it takes for others
//! are what comes of two ends that disagree.

use signal::{Parity, SerialMessage, SerialSettings, Span, Time, When};

/// The levels that a receiver is shown; see the module `output` for what a cell is.
pub(super) trait Levels {
    /// The first cell from this one on in which the line is at 0; `None`: it stays at 1.
    fn next_zero(&self, cell: i64) -> Option<i64>;
    /// The first cell from this one on in which it is at 1.
    fn next_one(&self, cell: i64) -> i64;
    /// Whether it is at 0.
    fn is_zero(&self, cell: i64) -> bool {
        self.next_zero(cell) == Some(cell)
    }
}

#[derive(Clone, Copy, Debug)]
enum State {
    /// A start bit is waited for from this instant on.
    Idle(i64),
    /// The line has to come back to 1.
    Held(i64),
}

/// A receiver, and the message that it is in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Receiver {
    settings: SerialSettings,
    gap: i64,
    state: State,
    message: Option<SerialMessage>,
    /// Since when the line is silent after what was received.
    silent: i64,
    /// Other settings, with their message gap, from an instant on.
    change: Option<(i64, SerialSettings, i64)>,
}

/// What a receiver took for a character.
struct Character {
    byte: u8,
    parity: bool,
    framing: bool,
    /// All of it was 0.
    zero: bool,
}

impl Receiver {
    /// A receiver whose line was always at rest. A message ends when it is at rest for `gap`, above 0.
    pub(super) fn new(settings: SerialSettings, gap: Span) -> Receiver {
        let gap = gap.as_nanos().max(1);
        Receiver {
            settings,
            gap,
            state: State::Idle(i64::MIN),
            message: None,
            silent: i64::MIN,
            change: None,
        }
    }

    /// Goes on with other settings from `now` on: a character that is under way then is taken for what it is not, and the
    /// message under way is lost.
    pub(super) fn change(&mut self, now: Time, settings: SerialSettings, gap: Span) {
        self.change = Some((now.as_nanos(), settings, gap.as_nanos().max(1)));
    }

    /// Before this instant it needs no levels any more.
    pub(super) fn position(&self) -> Time {
        let (State::Idle(at) | State::Held(at)) = self.state;
        Time::from_nanos(at)
    }

    /// Nothing began before `now`: what was on the line is not looked at again.
    pub(super) fn rest(&mut self, levels: &impl Levels, now: Time) {
        let now = now.as_nanos();
        if let State::Idle(since) = self.state
            && since < now
            && levels.next_zero(since).is_none_or(|cell| cell >= now)
        {
            self.state = State::Idle(now);
        }
    }

    /// Goes on with the levels of all cells before `until`, up to the next message: it, and when that was over.
    pub(super) fn run(&mut self, levels: &impl Levels, until: Time) -> Option<(Time, SerialMessage)> {
        let until = until.as_nanos();
        if let Some((at, settings, gap)) = self.change.filter(|(at, ..)| *at <= until) {
            // What is over by then was heard as before.
            if let Some(message) = self.run_unchanged(levels, at) {
                return Some(message);
            }
            *self =
                Receiver { settings, gap, state: State::Idle(at), message: None, silent: at, change: None };
        }
        self.run_unchanged(levels, until)
    }

    fn run_unchanged(&mut self, levels: &impl Levels, until: i64) -> Option<(Time, SerialMessage)> {
        loop {
            let since = match self.state {
                State::Idle(since) => since,
                State::Held(from) => {
                    let rise = levels.next_one(from);
                    if rise >= until {
                        return None;
                    }
                    self.silent = self.silent.max(rise);
                    self.state = State::Idle(rise);
                    continue;
                }
            };
            let fall = levels.next_zero(since);
            if let Some(mut message) = self.message {
                // A level that was no start bit hides for half a bit that the message is over.
                let over = self.silent.saturating_add(self.gap).max(since);
                if fall.is_none_or(|fall| fall >= over) {
                    if over > until {
                        return None;
                    }
                    self.message = None;
                    message.ends = true;
                    return Some((Time::from_nanos(over), message));
                }
            }
            let fall = fall?;
            let sampled = self.sample(fall, 0);
            if sampled > until {
                return None;
            }
            if !levels.is_zero(sampled - 1) {
                self.state = State::Idle(sampled);
                continue;
            }
            let end = fall.saturating_add(self.bits(2 * self.last_bit() + 2));
            if end > until {
                return None;
            }
            if let Some(full) = self.take(levels, fall, end) {
                return Some((Time::from_nanos(end), full));
            }
        }
    }

    /// Halves of bits as nanoseconds.
    fn bits(&self, halves: u32) -> i64 {
        i64::from(halves) * 500_000_000 / i64::from(self.settings.baud)
    }

    /// When bit `bit` is sampled.
    fn sample(&self, fall: i64, bit: u32) -> i64 {
        fall.saturating_add(self.bits(2 * bit + 1)).max(fall.saturating_add(1))
    }

    /// The number of the first stop bit.
    fn last_bit(&self) -> u32 {
        1 + u32::from(self.settings.data_bits) + u32::from(self.settings.parity != Parity::None)
    }

    /// Takes the character that began with this edge. The message that has no room for it.
    fn take(&mut self, levels: &impl Levels, fall: i64, end: i64) -> Option<SerialMessage> {
        let stop = self.sample(fall, self.last_bit());
        let character = self.character(levels, fall);
        let mut full = None;
        let first = When::exactly(Time::from_nanos(fall));
        let mut message = self.message.unwrap_or_else(|| SerialMessage::begin(first, false));
        let is_break = character.zero && character.framing;
        if is_break {
            message.errors.breaks = message.errors.breaks.saturating_add(1);
        } else {
            if message.is_full() {
                full = Some(message);
                message = SerialMessage::begin(first, true);
            }
            message.push(character.byte);
            message.errors.framing += u16::from(character.framing);
            message.errors.parity += u16::from(character.parity && !character.framing);
        }
        message.last = When::exactly(Time::from_nanos(end));
        self.message = Some(message);
        self.silent = end;
        self.state = if character.framing { State::Held(stop) } else { State::Idle(stop) };
        full
    }

    fn character(&self, levels: &impl Levels, fall: i64) -> Character {
        let zero = |bit| levels.is_zero(self.sample(fall, bit) - 1);
        let SerialSettings { data_bits, parity, .. } = self.settings;
        let data_bits = u32::from(data_bits);
        let byte = (0..data_bits).filter(|bit| !zero(bit + 1)).fold(0_u8, |byte, bit| byte | 1 << bit);
        let odd = byte.count_ones() % 2 == 1;
        let parity_bit = parity != Parity::None && !zero(data_bits + 1);
        let wrong = match parity {
            Parity::None => false,
            Parity::Even => parity_bit != odd,
            Parity::Odd => parity_bit == odd,
        };
        let framing = zero(self.last_bit());
        Character { byte, parity: wrong, framing, zero: byte == 0 && !parity_bit }
    }
}
