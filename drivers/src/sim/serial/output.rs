//! What an end of a simulated serial line puts on it: levels in closed form.
//!
//! Levels are asked for by *cell*: cell `n` is the nanosecond from instant `n` to `n + 1`. A sample at an instant reads the
//! cell before it, so that what begins at this very instant does not show yet.

use std::collections::VecDeque;

use signal::{MAX_SERIAL_DATA, Parity, SerialFlaw, SerialOutput, SerialSettings, Time};

const SECOND: i64 = 1_000_000_000;

/// What is sent besides bytes.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Characters { gap: i64, flaw: Option<(u16, SerialFlaw)> },
    Break(i64),
}

/// Characters or a break on the line from an instant on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transmission {
    start: i64,
    settings: SerialSettings,
    shape: Shape,
    data: [u8; MAX_SERIAL_DATA],
    /// Number of characters; 0 of a break.
    len: u16,
    /// It broke off so long after its start; never where it did not.
    cut: i64,
}

impl Transmission {
    /// `None` where there is nothing to send, or too much.
    pub(super) fn new(start: Time, settings: SerialSettings, output: &SerialOutput) -> Option<Transmission> {
        let mut bytes = [0; MAX_SERIAL_DATA];
        let (shape, len) = match output {
            SerialOutput::Characters { data, gap, flaw } => {
                bytes.get_mut(..data.len()).filter(|bytes| !bytes.is_empty())?.copy_from_slice(data);
                let sound = gap.as_nanos() >= 0 && flaw.is_none_or(|(at, _)| usize::from(at) < data.len());
                let len = u16::try_from(data.len()).ok().filter(|_| sound)?;
                (Shape::Characters { gap: gap.as_nanos(), flaw: *flaw }, len)
            }
            SerialOutput::Break(lasts) => {
                (Shape::Break(Some(lasts.as_nanos()).filter(|nanos| *nanos > 0)?), 0)
            }
        };
        Some(Transmission { start: start.as_nanos(), settings, shape, data: bytes, len, cut: i64::MAX })
    }

    /// From its start to bit `bit` of character `character`: that of the first is its start bit.
    fn edge(&self, character: u16, bit: u32, gap: i64) -> i64 {
        let bits = i64::from(character) * i64::from(self.settings.bits()) + i64::from(bit);
        (bits * SECOND / i64::from(self.settings.baud))
            .saturating_add(i64::from(character).saturating_mul(gap))
    }

    /// How long it lasts, with the stop bits of its last character.
    fn lasts(&self) -> i64 {
        let whole = match self.shape {
            Shape::Characters { gap, .. } => self.edge(self.len.saturating_sub(1), self.settings.bits(), gap),
            Shape::Break(lasts) => lasts,
        };
        whole.min(self.cut)
    }

    /// The bytes of the characters that came to their end.
    pub(super) fn sent(&self) -> &[u8] {
        let Shape::Characters { gap, .. } = self.shape else { return &[] };
        let whole = (0..self.len).take_while(|at| self.edge(*at, self.settings.bits(), gap) <= self.cut);
        &self.data[..whole.count()]
    }

    /// When it begins.
    pub(super) fn start(&self) -> Time {
        Time::from_nanos(self.start)
    }

    /// When the line is free after it.
    pub(super) fn end(&self) -> Time {
        Time::from_nanos(self.start.saturating_add(self.lasts()))
    }

    /// Its bytes; none of a break.
    pub(super) fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }

    fn covers(&self, cell: i64) -> bool {
        (self.start..self.start.saturating_add(self.lasts())).contains(&cell)
    }

    /// The character and its bit of which this nanosecond after the start is; after the bits there is a gap.
    fn locate(&self, after: i64, gap: i64) -> (u16, u32) {
        let (mut low, mut high) = (0, self.len);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.edge(middle, 0, gap) <= after { low = middle } else { high = middle }
        }
        let bits = self.settings.bits();
        let bit = (0..bits).find(|bit| self.edge(low, bit + 1, gap) > after).unwrap_or(bits);
        (low, bit)
    }

    /// Whether the line is at 0 during a bit of a character.
    fn is_zero(&self, byte: u8, flaw: Option<SerialFlaw>, bit: u32) -> bool {
        let SerialSettings { data_bits, parity, .. } = self.settings;
        let data_bits = u32::from(data_bits);
        let ones = (0..data_bits).filter(|bit| byte >> bit & 1 == 1).count();
        let has_parity = parity != Parity::None;
        match bit {
            0 => true,
            bit if bit <= data_bits => byte >> (bit - 1) & 1 == 0,
            bit if has_parity && bit == data_bits + 1 => {
                let one = (ones % 2 == 1) == (parity == Parity::Even);
                one == (flaw == Some(SerialFlaw::Parity))
            }
            bit => flaw == Some(SerialFlaw::Framing) && bit == data_bits + 1 + u32::from(has_parity),
        }
    }

    /// The first cell from this one on at which its level is as asked; `None` where none of its cells is.
    fn next(&self, cell: i64, zero: bool) -> Option<i64> {
        self.next_uncut(cell, zero).filter(|found| self.covers(*found))
    }

    fn next_uncut(&self, cell: i64, zero: bool) -> Option<i64> {
        let after = cell.max(self.start) - self.start;
        let (gap, flawed) = match self.shape {
            Shape::Characters { gap, flaw } => (gap, flaw),
            Shape::Break(lasts) => return (zero && after < lasts).then_some(self.start + after),
        };
        if after >= self.lasts() {
            return None;
        }
        let (mut character, mut bit) = self.locate(after, gap);
        loop {
            let byte = *self.data().get(usize::from(character))?;
            let flaw = flawed.and_then(|(at, flaw)| (at == character).then_some(flaw));
            while bit < self.settings.bits() {
                if self.is_zero(byte, flaw, bit) == zero {
                    return Some(self.start + self.edge(character, bit, gap).max(after));
                }
                bit += 1;
            }
            if !zero && gap > 0 && character + 1 < self.len {
                return Some(self.start + self.edge(character, bit, gap).max(after));
            }
            (character, bit) = (character + 1, 0);
        }
    }
}

/// What one end sends, in the order of time.
#[derive(Clone, Debug)]
pub(super) struct Output {
    queue: VecDeque<Transmission>,
    /// How many of the first were reported as sent.
    reported: usize,
}

impl Output {
    /// With room for so many transmissions.
    pub(super) fn with_room(most: usize) -> Output {
        Output { queue: VecDeque::with_capacity(most), reported: 0 }
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.queue.clear();
        self.reported = 0;
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.queue.len()
    }

    /// When it is free, as things stand.
    pub(super) fn free(&self) -> Option<Time> {
        self.queue.back().map(Transmission::end)
    }

    /// Appends one that starts when the others are over.
    pub(super) fn push(&mut self, transmission: Transmission) {
        self.queue.push_back(transmission);
    }

    /// Leaves out what has not begun by now.
    pub(super) fn cancel(&mut self, now: Time) {
        self.queue.retain(|transmission| transmission.start() < now);
    }

    /// Leaves out what has not begun by now, and ends what is under way.
    pub(super) fn break_off(&mut self, now: Time) {
        self.cancel(now);
        if let Some(last) = self.queue.back_mut() {
            last.cut = last.cut.min(now.as_nanos() - last.start);
        }
    }

    /// The next that will have been sent.
    pub(super) fn unreported(&self) -> Option<&Transmission> {
        self.queue.get(self.reported)
    }

    /// That one was reported.
    pub(super) fn report(&mut self) {
        self.reported += 1;
    }

    /// Forgets what was reported and is over by this instant.
    pub(super) fn forget(&mut self, before: Time) {
        while self.reported > 0 && self.queue.front().is_some_and(|first| first.end() <= before) {
            self.queue.pop_front();
            self.reported -= 1;
        }
    }

    /// When the transmission that has the line in this cell ends.
    pub(super) fn busy(&self, cell: i64) -> Option<i64> {
        self.queue.iter().find(|one| one.covers(cell)).map(|one| one.end().as_nanos())
    }

    /// The first cell from this one on in which a transmission has the line.
    pub(super) fn next_busy(&self, cell: i64) -> Option<i64> {
        let next = self.queue.iter().find(|one| one.end().as_nanos() > cell)?;
        Some(next.start().as_nanos().max(cell))
    }

    /// The first cell from this one on in which it holds the line at 0.
    pub(super) fn next_zero(&self, cell: i64) -> Option<i64> {
        self.queue.iter().find_map(|one| one.next(cell, true))
    }

    /// The first cell from this one on in which it lets the line be at 1.
    pub(super) fn next_one(&self, cell: i64) -> i64 {
        let mut cell = cell;
        for one in &self.queue {
            if one.covers(cell) {
                match one.next(cell, false) {
                    Some(found) => return found,
                    None => cell = one.end().as_nanos(),
                }
            }
        }
        cell
    }
}
