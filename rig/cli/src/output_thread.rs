//! Pipes and files that a command prints all of its words to, and whose reader cannot keep it from an interrupt: a thread of
//! its own writes them, in the order in which they were printed.

use std::collections::VecDeque;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The most that waits for the streams, bytes: whoever prints more waits until there is room, or an interrupt.
const ROOM: usize = 256 << 10;

/// How long an interrupt may go unseen.
const SLICE: Duration = Duration::from_millis(50);

/// How often is looked whether a stream is read at all.
const IDLE: Duration = Duration::from_millis(200);

/// How long the readers are waited for after an interrupt.
const AFTER_INTERRUPT: Duration = Duration::from_secs(1);

/// One of the two streams of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Standard output.
    Output,
    /// Standard error.
    Errors,
}

/// The thread that writes.
#[derive(Debug)]
pub struct OutputThread {
    shared: Arc<Shared>,
    interrupt: &'static AtomicBool,
}

#[derive(Debug, Default)]
struct Shared {
    waiting: Mutex<Waiting>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    texts: VecDeque<(Stream, Vec<u8>)>,
    bytes: usize,
    /// Something is being written.
    writes: bool,
}

impl OutputThread {
    /// Starts the thread. It is never joined: one whose stream takes nothing is left to it.
    ///
    /// `write` writes to a stream and keeps what went wrong; `idle` is called now and then while there is nothing to write.
    ///
    /// # Errors
    /// The machine has no room for another thread.
    pub fn start(
        interrupt: &'static AtomicBool,
        write: impl FnMut(Stream, &[u8]) + Send + 'static,
        idle: impl FnMut() + Send + 'static,
    ) -> io::Result<OutputThread> {
        let shared = Arc::new(Shared::default());
        let own = shared.clone();
        std::thread::Builder::new().name("output".into()).spawn(move || own.write_with(write, idle))?;
        Ok(OutputThread { shared, interrupt })
    }

    /// Leaves a text for a stream. It waits while there is no room; after an interrupt what has no room is left out.
    pub fn put(&self, stream: Stream, text: &[u8]) {
        let mut waiting = self.shared.lock();
        while waiting.bytes > ROOM {
            if self.interrupt.load(Ordering::Relaxed) {
                return;
            }
            waiting = self.shared.wait(waiting, SLICE);
        }
        waiting.bytes += text.len();
        match waiting.texts.back_mut() {
            // Short texts of one stream are written together.
            Some((last, together)) if *last == stream && together.len() < ROOM / 16 => {
                together.extend_from_slice(text);
            }
            _ => waiting.texts.push_back((stream, text.to_vec())),
        }
        self.shared.changed.notify_all();
    }

    /// Waits until everything is written; after an interrupt no longer than a second.
    pub fn settle(&self) {
        let mut interrupted: Option<Instant> = None;
        let mut waiting = self.shared.lock();
        while waiting.writes || !waiting.texts.is_empty() {
            if self.interrupt.load(Ordering::Relaxed)
                && interrupted.get_or_insert_with(Instant::now).elapsed() > AFTER_INTERRUPT
            {
                return;
            }
            waiting = self.shared.wait(waiting, SLICE);
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'a>(&self, waiting: MutexGuard<'a, Waiting>, limit: Duration) -> MutexGuard<'a, Waiting> {
        self.changed.wait_timeout(waiting, limit).unwrap_or_else(PoisonError::into_inner).0
    }

    fn write_with(&self, mut write: impl FnMut(Stream, &[u8]), mut idle: impl FnMut()) {
        loop {
            let mut waiting = self.lock();
            waiting.writes = false;
            while waiting.texts.is_empty() {
                self.changed.notify_all();
                waiting = self.wait(waiting, IDLE);
                if waiting.texts.is_empty() {
                    drop(waiting);
                    idle();
                    waiting = self.lock();
                }
            }
            let Some((stream, text)) = waiting.texts.pop_front() else { continue };
            waiting.bytes -= text.len();
            waiting.writes = true;
            self.changed.notify_all();
            drop(waiting);
            write(stream, &text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn everything_is_written_in_the_order_of_printing() {
        static NEVER: AtomicBool = AtomicBool::new(false);
        let (written, texts) = mpsc::channel();
        let thread = OutputThread::start(
            &NEVER,
            move |stream, text| {
                written.send((stream, text.to_vec())).expect("the test waits");
            },
            || {},
        )
        .expect("a thread");
        let long = vec![b'x'; ROOM];
        for number in 0..20_u8 {
            thread.put(Stream::Output, &[number]);
            thread.put(Stream::Errors, &[number, number]);
            thread.put(Stream::Output, &long);
        }
        thread.settle();
        let of = |wanted: Stream, all: &[(Stream, Vec<u8>)]| -> Vec<u8> {
            all.iter().filter(|(stream, _)| *stream == wanted).flat_map(|(_, text)| text.clone()).collect()
        };
        let all: Vec<(Stream, Vec<u8>)> = texts.try_iter().collect();
        let wanted: Vec<u8> = (0..20_u8).flat_map(|number| [&[number][..], &long].concat()).collect();
        assert_eq!(of(Stream::Output, &all), wanted);
        assert_eq!(of(Stream::Errors, &all), (0..20_u8).flat_map(|n| [n, n]).collect::<Vec<_>>());
        assert_eq!(all[0], (Stream::Output, vec![0]), "the order between the two");
        assert_eq!(all[1], (Stream::Errors, vec![0, 0]));
    }

    #[test]
    fn a_stream_that_takes_nothing_does_not_outlast_an_interrupt() {
        static INTERRUPT: AtomicBool = AtomicBool::new(false);
        let (taken, wait) = mpsc::channel::<()>();
        let thread = OutputThread::start(
            &INTERRUPT,
            move |_, _| {
                // Until the test ends.
                let _ = wait.recv();
            },
            || {},
        )
        .expect("a thread");
        let ends = std::thread::spawn(|| {
            std::thread::sleep(SLICE);
            INTERRUPT.store(true, Ordering::Relaxed);
        });
        for _ in 0..8 {
            thread.put(Stream::Output, &vec![b'x'; ROOM]);
        }
        thread.settle();
        assert!(thread.shared.lock().bytes <= 3 * ROOM, "it is bounded");
        ends.join().expect("the other thread");
        drop(taken);
    }
}
