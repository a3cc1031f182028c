//! Text on its way to a stream that may be read slowly or not at all: it waits for a thread of its own, and whoever prints
//! it goes on.

use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The most that waits for the stream, bytes. What finds no room is left out and counted.
const ROOM: usize = 256 << 10;

/// A queue in front of a stream.
#[derive(Debug)]
pub struct LineQueue(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    waiting: Mutex<Waiting>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    bytes: Vec<u8>,
    /// Texts that found no room since the last that did.
    left_out: u64,
    /// Something is being written.
    writes: bool,
}

impl LineQueue {
    /// Starts the thread that writes. It is never joined: one whose stream takes nothing is left to it.
    ///
    /// # Errors
    /// The machine has no room for another thread.
    pub fn start(name: &str, stream: impl Write + Send + 'static) -> io::Result<LineQueue> {
        let shared = Arc::new(Shared::default());
        let own = shared.clone();
        std::thread::Builder::new().name(name.to_owned()).spawn(move || own.write_to(stream))?;
        Ok(LineQueue(shared))
    }

    /// Leaves a text for the stream, without a wait.
    pub fn put(&self, text: &[u8]) {
        let mut waiting = self.0.lock();
        if waiting.bytes.len() + text.len() > ROOM {
            waiting.left_out += 1;
            return;
        }
        waiting.note_left_out();
        waiting.bytes.extend_from_slice(text);
        self.0.changed.notify_all();
    }

    /// Waits until everything is written, no longer than `limit`. FALSE where something is left.
    pub fn settle(&self, limit: Duration) -> bool {
        let until = Instant::now() + limit;
        let mut waiting = self.0.lock();
        waiting.note_left_out();
        self.0.changed.notify_all();
        while !waiting.is_settled() {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            let woken = self.0.changed.wait_timeout(waiting, left);
            waiting = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }
}

impl Waiting {
    fn is_settled(&self) -> bool {
        self.bytes.is_empty() && !self.writes
    }

    /// Says how much is missing, where it is missing.
    fn note_left_out(&mut self) {
        if self.left_out > 0 {
            let note = format!("note: {} lines were left out, because nobody read them\n", self.left_out);
            self.bytes.extend_from_slice(note.as_bytes());
            self.left_out = 0;
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn write_to(&self, mut stream: impl Write) {
        loop {
            let mut waiting = self.lock();
            waiting.writes = false;
            while waiting.bytes.is_empty() {
                self.changed.notify_all();
                waiting = self.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
            }
            let bytes = std::mem::take(&mut waiting.bytes);
            waiting.writes = true;
            drop(waiting);
            // A stream that is closed is no fault: what goes there is lost.
            let _ = stream.write_all(&bytes).and_then(|()| stream.flush());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{PipeReader, Read};

    const SOON: Duration = Duration::from_millis(20);
    const LONG: Duration = Duration::from_secs(60);

    fn queue() -> (LineQueue, PipeReader) {
        let (reader, writer) = io::pipe().expect("a pipe");
        (LineQueue::start("test", writer).expect("a thread"), reader)
    }

    #[test]
    fn what_is_put_in_comes_out_in_its_order() {
        let (queue, mut reader) = queue();
        (0..1_000).for_each(|number| queue.put(format!("line {number}\n").as_bytes()));
        assert!(queue.settle(LONG));
        let wanted: String = (0..1_000).map(|number| format!("line {number}\n")).collect();
        let mut read = vec![0; wanted.len()];
        reader.read_exact(&mut read).expect("all lines");
        assert_eq!(String::from_utf8_lossy(&read), wanted);
    }

    #[test]
    fn a_stream_that_nobody_reads_holds_up_neither_who_prints_nor_the_end_and_what_is_missing_is_counted() {
        let (queue, mut reader) = queue();
        let mut line = [b'x'; 1_024];
        line[1_023] = b'\n';
        (0..1_000).for_each(|_| queue.put(&line));
        assert!(!queue.settle(SOON));
        // It is bounded, and says so once somebody reads.
        assert!(queue.0.lock().bytes.len() < ROOM + 200);
        let reads = std::thread::spawn(move || {
            let mut read = Vec::new();
            let mut piece = [0; 4_096];
            while !read.ends_with(b"\nlast\n") {
                let length = reader.read(&mut piece).expect("bytes");
                read.extend_from_slice(&piece[..length]);
            }
            String::from_utf8_lossy(&read).into_owned()
        });
        assert!(queue.settle(LONG));
        queue.put(b"last\n");
        let read = reads.join().expect("the reader");
        let notes =
            read.split("note: ").skip(1).filter_map(|note| note.split(' ').next()?.parse::<usize>().ok());
        let kept = read.lines().filter(|line| line.starts_with('x')).count();
        assert_eq!(kept + notes.sum::<usize>(), 1_000);
    }
}
