//! Simulated serial lines: characters take their time on the line, and each end reads them by its own settings.
//!
//! Every serial line of a board is one end; ends that join each other hear each other. Over RS-232 two ends hear each other
//! both ways at once. Over RS-485 all ends share one pair of wires: when several send at once the line is at 0 wherever one
//! of them wants it there, and an end hears itself only where it is set up so. Nothing ticks: what an end hears of what is
//! being sent is known from the moment at which it is sent.

mod output;
mod receiver;
#[cfg(test)]
mod tests;

use output::{Output, Transmission};
use receiver::{Levels, Receiver};
use signal::{SerialMessage, SerialOutput, SerialSettings, Span, Time, When};

use crate::circuit::{SerialEnd, SerialMedium};
use crate::{BoardError, BusEvent, BusId};

/// Outputs that wait at one end, the one on the line included.
pub const MAX_SERIAL_QUEUED: usize = 64;

/// An end at work.
#[derive(Clone, Debug)]
struct End {
    bus: BusId,
    line: usize,
    spec: SerialEnd,
    /// How it sends now; the receiver has its own.
    settings: SerialSettings,
    output: Output,
    receiver: Receiver,
    /// When its next message is over unless somebody sends.
    next: Option<Time>,
}

/// The serial lines of a simulated board.
#[derive(Clone, Debug, Default)]
pub struct SerialLines {
    ends: Vec<End>,
    lines: usize,
    latched: bool,
}

/// What an end hears.
struct Heard<'a> {
    ends: &'a [End],
    at: &'a End,
}

impl Heard<'_> {
    /// The outputs that it hears, and how long they take to it.
    fn outputs(&self) -> impl Iterator<Item = (&Output, i64)> {
        let hears_itself = matches!(self.at.spec.medium, SerialMedium::Rs485 { hears_itself: true });
        let on_line = self.ends.iter().filter(|end| end.line == self.at.line);
        on_line.filter_map(move |end| match end.bus == self.at.bus {
            true => hears_itself.then_some((&end.output, 0)),
            false => Some((&end.output, end.spec.delay.as_nanos())),
        })
    }

    /// Until when it hears nothing because it sends.
    fn deaf(&self, cell: i64) -> Option<i64> {
        match self.at.spec.medium {
            SerialMedium::Rs485 { hears_itself: false } => self.at.output.busy(cell),
            SerialMedium::Rs485 { hears_itself: true } | SerialMedium::Rs232 => None,
        }
    }

    /// The first cell from this one on in which it hears nothing because it sends.
    fn next_deaf(&self, cell: i64) -> Option<i64> {
        match self.at.spec.medium {
            SerialMedium::Rs485 { hears_itself: false } => self.at.output.next_busy(cell),
            SerialMedium::Rs485 { hears_itself: true } | SerialMedium::Rs232 => None,
        }
    }
}

impl Levels for Heard<'_> {
    fn next_zero(&self, cell: i64) -> Option<i64> {
        let mut cell = cell;
        loop {
            let zeros = self.outputs().filter_map(|(output, delay)| {
                Some(output.next_zero(cell.saturating_sub(delay))?.saturating_add(delay))
            });
            let zero = zeros.min()?;
            match self.deaf(zero) {
                Some(until) => cell = until,
                None => return Some(zero),
            }
        }
    }

    fn next_one(&self, cell: i64) -> i64 {
        let deaf = self.next_deaf(cell).unwrap_or(i64::MAX);
        let mut cell = cell;
        while cell < deaf {
            let ones = self
                .outputs()
                .map(|(output, delay)| output.next_one(cell.saturating_sub(delay)).saturating_add(delay));
            match ones.max() {
                Some(one) if one > cell => cell = one,
                _ => break,
            }
        }
        cell.min(deaf)
    }
}

impl SerialLines {
    /// Appends an end; it joins one that is there, or has a line of its own.
    pub fn push(&mut self, bus: BusId, spec: SerialEnd, joins: Option<BusId>) {
        let joined = joins.and_then(|other| self.ends.iter().find(|end| end.bus == other));
        let line = joined.map_or(self.lines, |end| end.line);
        self.lines = self.lines.max(line + 1);
        let receiver = Receiver::new(spec.settings, spec.message_gap);
        let output = Output::with_room(MAX_SERIAL_QUEUED);
        let settings = spec.settings;
        self.ends.push(End { bus, line, spec, settings, output, receiver, next: None });
    }

    /// Forgets what was before.
    pub fn start(&mut self) {
        self.latched = false;
        for end in &mut self.ends {
            end.output.clear();
            end.settings = end.spec.settings;
            end.receiver = Receiver::new(end.settings, end.spec.message_gap);
            end.next = None;
        }
    }

    /// Nothing more is sent; what is on a line comes to its end.
    pub fn safe(&mut self, now: Time) {
        self.latched = true;
        self.ends.iter_mut().for_each(|end| end.output.cancel(now));
        (0..self.ends.len()).for_each(|place| self.predict(place));
    }

    /// The sender of this end lost its power: the line is at rest from now on, in the middle of what was sent.
    pub fn break_off(&mut self, now: Time, bus: BusId) {
        let Some(place) = self.ends.iter().position(|end| end.bus == bus) else { return };
        self.ends[place].output.break_off(now);
        self.predict_line(self.ends[place].line);
    }

    /// Finds out again what the ends of a line hear.
    fn predict_line(&mut self, line: usize) {
        for place in 0..self.ends.len() {
            if self.ends[place].line == line {
                self.predict(place);
            }
        }
    }

    /// This end sends and hears with other settings from now on. What it sends already goes out as it was.
    ///
    /// # Errors
    /// [`BoardError::NoBus`], [`BoardError::Latched`], [`BoardError::BadSettings`].
    pub fn configure(
        &mut self,
        now: Time,
        bus: BusId,
        settings: &SerialSettings,
        message_gap: Span,
    ) -> Result<(), BoardError> {
        let place = self.ends.iter().position(|end| end.bus == bus).ok_or(BoardError::NoBus(bus))?;
        if self.latched {
            return Err(BoardError::Latched);
        }
        let possible = settings.baud > 0
            && (5..=8).contains(&settings.data_bits)
            && (1..=2).contains(&settings.stop_bits)
            && message_gap > Span::ZERO;
        if !possible {
            return Err(BoardError::BadSettings(bus));
        }
        self.forget(now);
        self.ends[place].settings = *settings;
        self.ends[place].receiver.change(now, *settings, message_gap);
        self.predict(place);
        Ok(())
    }

    /// Sends from this end, after what it sends already.
    ///
    /// # Errors
    /// [`BoardError::NoBus`], [`BoardError::BadFrame`], [`BoardError::BusFull`], [`BoardError::Latched`].
    pub fn send(&mut self, now: Time, bus: BusId, output: &SerialOutput) -> Result<(), BoardError> {
        let place = self.ends.iter().position(|end| end.bus == bus).ok_or(BoardError::NoBus(bus))?;
        if self.latched {
            return Err(BoardError::Latched);
        }
        self.forget(now);
        let end = &mut self.ends[place];
        let start = end.output.free().map_or(now, |free| free.max(now));
        let transmission = Transmission::new(start, end.settings, output);
        let transmission = transmission.ok_or(BoardError::BadFrame(bus))?;
        if end.output.len() >= MAX_SERIAL_QUEUED {
            return Err(BoardError::BusFull(bus));
        }
        end.output.push(transmission);
        let line = end.line;
        self.predict_line(line);
        Ok(())
    }

    /// When something is sent or a message is over, as things stand.
    pub fn next_event(&self) -> Option<Time> {
        self.first().map(|(at, ..)| at)
    }

    /// The first thing to report: when, whether it was received, and at which end.
    fn first(&self) -> Option<(Time, bool, usize)> {
        let sent = |(place, end): (usize, &End)| Some((end.output.unreported()?.end(), false, place));
        let received = |(place, end): (usize, &End)| Some((end.next?, true, place));
        let sent = self.ends.iter().enumerate().filter_map(sent);
        sent.chain(self.ends.iter().enumerate().filter_map(received)).min()
    }

    /// Appends what was sent and received up to `now`, oldest first.
    pub fn poll(&mut self, now: Time, out: &mut Vec<BusEvent>) {
        while let Some((at, is_received, place)) = self.first().filter(|(at, ..)| *at <= now) {
            let bus = self.ends[place].bus;
            let message = if is_received { self.receive(place, at) } else { self.sent(place) };
            out.extend(message.map(|message| BusEvent::SerialMessage { bus, message, own: !is_received }));
        }
        self.forget(now);
    }

    /// What an end sent, which is over.
    fn sent(&mut self, place: usize) -> Option<SerialMessage> {
        let output = &mut self.ends[place].output;
        let transmission = output.unreported()?;
        let (first, last) = (When::exactly(transmission.start()), When::exactly(transmission.end()));
        let mut message = SerialMessage::of(first, last, transmission.sent());
        message.errors.breaks = u16::from(transmission.data().is_empty());
        // Of what broke off in its first character nobody can say that it was sent.
        let was_sent = !message.is_empty();
        output.report();
        was_sent.then_some(message)
    }

    /// The message that is over at an end.
    fn receive(&mut self, place: usize, at: Time) -> Option<SerialMessage> {
        let mut receiver = self.ends[place].receiver;
        let message = receiver.run(&Heard { ends: &self.ends, at: &self.ends[place] }, at);
        self.ends[place].receiver = receiver;
        self.predict(place);
        message.map(|(_, message)| message)
    }

    /// Finds out when the next message of an end is over.
    fn predict(&mut self, place: usize) {
        let mut receiver = self.ends[place].receiver;
        let over = receiver.run(&Heard { ends: &self.ends, at: &self.ends[place] }, Time::MAX);
        self.ends[place].next = over.map(|(at, _)| at);
    }

    /// Forgets what nobody needs any more.
    fn forget(&mut self, now: Time) {
        for place in 0..self.ends.len() {
            let mut receiver = self.ends[place].receiver;
            let heard = Heard { ends: &self.ends, at: &self.ends[place] };
            // What it took for no character is looked at only once: else a receiver that hears nothing in a line that is
            // too fast for it would need all of it for ever. A message that was not polled yet stays.
            if receiver.run(&heard, now).is_none() {
                receiver.rest(&heard, now);
                self.ends[place].receiver = receiver;
            }
        }
        for place in 0..self.ends.len() {
            let line = self.ends[place].line;
            let on_line = self.ends.iter().filter(|end| end.line == line);
            let needed = on_line.map(|end| end.receiver.position()).min().unwrap_or(now);
            let delay = self.ends[place].spec.delay.as_nanos();
            let before = Time::from_nanos(needed.as_nanos().saturating_sub(delay));
            self.ends[place].output.forget(before);
        }
    }
}
