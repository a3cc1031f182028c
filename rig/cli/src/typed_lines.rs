//! Lines of standard input, read by a thread of their own: a wait for one ends with an interrupt, too.

use std::io::{self, BufRead, Read};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

/// How long an interrupt may go unseen.
const LOOK: Duration = Duration::from_millis(100);

/// The longest line, bytes; the rest of a longer one is another.
const LONGEST: u64 = 4_096;

/// Lines that are read before they are wanted.
const AHEAD: usize = 16;

/// What came of a wait for a line.
#[derive(Debug)]
pub enum TypedLine {
    /// A line, with what is no UTF-8 replaced.
    Line(String),
    /// The input is over.
    End,
    /// The input cannot be read.
    Failed(io::Error),
    /// The command was interrupted.
    Interrupted,
}

/// The lines of standard input. To be made once: whatever is read belongs to this one.
#[derive(Debug)]
pub struct TypedLines(Receiver<io::Result<String>>);

impl TypedLines {
    /// Begins to read.
    ///
    /// # Errors
    /// The machine has no room for another thread.
    pub fn start() -> io::Result<TypedLines> {
        let (send, lines) = mpsc::sync_channel(AHEAD);
        // Never joined: it may wait for a line of somebody who types none any more.
        std::thread::Builder::new().name(String::from("input")).spawn(move || {
            let mut input = io::stdin().lock();
            loop {
                let mut bytes = Vec::new();
                let line = match (&mut input).take(LONGEST).read_until(b'\n', &mut bytes) {
                    Ok(0) => return,
                    Ok(_) => Ok(String::from_utf8_lossy(&bytes).into_owned()),
                    Err(error) => Err(error),
                };
                let is_over = line.is_err();
                if send.send(line).is_err() || is_over {
                    return;
                }
            }
        })?;
        Ok(TypedLines(lines))
    }

    /// The next line, with its end. Waits for it until the command is interrupted.
    pub fn next(&self, interrupt: &AtomicBool) -> TypedLine {
        loop {
            if interrupt.load(Ordering::Relaxed) {
                return TypedLine::Interrupted;
            }
            match self.0.recv_timeout(LOOK) {
                Ok(Ok(line)) => return TypedLine::Line(line),
                Ok(Err(error)) => return TypedLine::Failed(error),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return TypedLine::End,
            }
        }
    }

    /// Forgets what was typed by now.
    pub fn forget_waiting(&self) {
        while self.0.try_recv().is_ok() {}
    }
}
