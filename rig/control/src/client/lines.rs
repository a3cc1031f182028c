//! Lines off a stream, each no longer than a limit.

use crate::ClientError;
use std::io::{ErrorKind, Read};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// The longest line of a rig, in bytes: a description of thousands of signals fits.
const LONGEST: usize = 64 * 1024 * 1024;

/// What is read at once.
const PIECE: usize = 64 * 1024;

/// The shortest wait that the kernel is asked for: none at all would mean for ever.
const LEAST: Duration = Duration::from_micros(100);

/// Why there is no further line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineError {
    /// The other side is gone.
    Lost,
    /// A line is longer than any can be.
    TooLong,
}

impl LineError {
    /// As the client reports it.
    pub fn of(self, socket: &Path) -> ClientError {
        match self {
            LineError::Lost => ClientError::Lost(socket.to_owned()),
            LineError::TooLong => ClientError::Garbled(format!("a line of more than {LONGEST} bytes")),
        }
    }
}

/// The lines of a stream.
#[derive(Debug)]
pub struct LineStream {
    stream: UnixStream,
    bytes: Vec<u8>,
    /// Where the next line begins.
    begin: usize,
    /// Up to where no end of it was found.
    seen: usize,
}

impl LineStream {
    /// Of this stream.
    pub fn new(stream: UnixStream) -> LineStream {
        LineStream { stream, bytes: Vec::new(), begin: 0, seen: 0 }
    }

    /// The next line without its end; `None` where there is none by this instant. What is there when it has passed is still
    /// given, but no line is waited for that comes in pieces.
    pub fn next(&mut self, until: Option<Instant>) -> Result<Option<&[u8]>, LineError> {
        let mut last = false;
        loop {
            if let Some(length) = self.bytes[self.seen..].iter().position(|byte| *byte == b'\n') {
                let (begin, end) = (self.begin, self.seen + length);
                (self.begin, self.seen) = (end + 1, end + 1);
                return Ok(Some(&self.bytes[begin..end]));
            }
            self.seen = self.bytes.len();
            if self.seen - self.begin > LONGEST {
                return Err(LineError::TooLong);
            }
            let over = until.is_some_and(|until| Instant::now() >= until);
            if std::mem::replace(&mut last, over) || !self.fill(until)? {
                return Ok(None);
            }
        }
    }

    /// Reads a piece; `false` where there was none by this instant.
    fn fill(&mut self, until: Option<Instant>) -> Result<bool, LineError> {
        self.bytes.drain(..self.begin);
        self.seen -= self.begin;
        self.begin = 0;
        let filled = self.bytes.len();
        self.bytes.resize(filled + PIECE, 0);
        let read = loop {
            let left = until.map(|until| until.saturating_duration_since(Instant::now()).max(LEAST));
            let read = match self.stream.set_read_timeout(left) {
                Ok(()) => self.stream.read(&mut self.bytes[filled..]),
                Err(error) => Err(error),
            };
            match read {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                read => break read,
            }
        };
        self.bytes.truncate(filled + *read.as_ref().unwrap_or(&0));
        match read {
            Ok(0) => Err(LineError::Lost),
            Ok(_) => Ok(true),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => Ok(false),
            Err(_) => Err(LineError::Lost),
        }
    }
}
