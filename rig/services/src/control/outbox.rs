//! What waits to be sent to a client.

use serde::Serialize;
use signal::Time;

/// Lines that wait, in their order. Whoever puts events in asks for room first; one answer always fits.
#[derive(Debug, Default)]
pub(super) struct ClientOutbox {
    bytes: Vec<u8>,
    /// How many of them are sent.
    sent: usize,
    /// Where the last answer ends; 0 if all are sent.
    answers: usize,
    /// When something was sent last, or when the first of what waits was put in.
    moved: Time,
}

impl ClientOutbox {
    /// What waits.
    pub(super) fn waiting(&self) -> &[u8] {
        &self.bytes[self.sent..]
    }

    /// How much waits, bytes.
    pub(super) fn len(&self) -> usize {
        self.bytes.len() - self.sent
    }

    /// Nothing waits.
    pub(super) fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Since when nothing was sent though an answer waits, or anything at all.
    pub(super) fn stuck_since(&self, anything: bool) -> Option<Time> {
        (self.answers > self.sent || anything && !self.is_empty()).then_some(self.moved)
    }

    /// So many bytes are sent.
    pub(super) fn forward(&mut self, bytes: usize, now: Time) {
        self.sent = (self.sent + bytes).min(self.bytes.len());
        self.moved = now;
        if self.sent == self.bytes.len() {
            // A great answer's room is given back.
            *self = ClientOutbox { moved: now, ..ClientOutbox::default() };
        } else if self.sent > self.bytes.len() / 2 {
            self.bytes.drain(..self.sent);
            self.answers = self.answers.saturating_sub(self.sent);
            self.sent = 0;
        }
    }

    /// Puts in a line that answers.
    pub(super) fn answer(&mut self, line: &impl Serialize, now: Time) {
        self.put(line, now);
        self.answers = self.bytes.len();
    }

    /// Puts in a line that answers and is written already.
    pub(super) fn answer_written(&mut self, parts: &[&str], now: Time) {
        self.put_written(parts, now);
        self.answers = self.bytes.len();
    }

    /// Puts in a line of its own.
    pub(super) fn put(&mut self, line: &impl Serialize, now: Time) {
        self.begin(now);
        let before = self.bytes.len();
        // Writing into memory cannot fail, and every message is made of what JSON can write.
        if serde_json::to_writer(&mut self.bytes, line).is_err() {
            self.bytes.truncate(before);
            return;
        }
        self.bytes.push(b'\n');
    }

    /// Puts in a line that is written already.
    pub(super) fn put_written(&mut self, parts: &[&str], now: Time) {
        self.begin(now);
        for part in parts {
            self.bytes.extend_from_slice(part.as_bytes());
        }
        self.bytes.push(b'\n');
    }

    fn begin(&mut self, now: Time) {
        if self.is_empty() {
            self.moved = now;
        }
    }
}
