//! Text on its way to a stream that may be read slowly or not at all: it waits in a queue for a thread of its own. Whoever
//! prints it goes on at once, or waits for room until an interrupt.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The most that waits for the stream, bytes, beside what is being written. One text alone may be longer where it is waited for.
const ROOM: usize = 256 << 10;

/// How long an interrupt may go unseen.
const SLICE: Duration = Duration::from_millis(50);

/// How often is looked whether a stream is read at all.
const IDLE: Duration = Duration::from_millis(200);

/// How long readers are waited for after an interrupt, in all.
const AFTER_INTERRUPT: Duration = Duration::from_secs(1);

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

/// How long readers are waited for: until an interrupt, and for a second in all after it, however many queues wait.
#[derive(Debug)]
pub struct WaitLimit {
    interrupt: &'static AtomicBool,
    /// What is left of the second.
    left: Mutex<Duration>,
}

impl LineQueue {
    /// Starts the thread that writes. It is never joined: one whose stream takes nothing is left to it.
    ///
    /// `write` writes to the stream, and keeps what goes wrong if that is to be known; `idle` is called now and then while there
    /// is nothing to write.
    ///
    /// # Errors
    /// The machine has no room for another thread.
    pub fn start(
        name: &str,
        write: impl FnMut(&[u8]) + Send + 'static,
        idle: impl FnMut() + Send + 'static,
    ) -> io::Result<LineQueue> {
        let shared = Arc::new(Shared::default());
        let own = shared.clone();
        std::thread::Builder::new().name(name.to_owned()).spawn(move || own.write_with(write, idle))?;
        Ok(LineQueue(shared))
    }

    /// Leaves a text for the stream, without a wait: what finds no room is left out and counted.
    pub fn put(&self, text: &[u8]) {
        self.0.lock().push(text);
        self.0.changed.notify_all();
    }

    /// Leaves a text for the stream, and waits for room: what finds none within the limit is left out and counted.
    pub fn put_within(&self, text: &[u8], limit: &WaitLimit) {
        let mut waiting = self.0.wait_within(limit, |waiting| waiting.has_room(text));
        if waiting.bytes.is_empty() {
            waiting.append(text);
        } else {
            waiting.push(text);
        }
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
            waiting = self.0.wait(waiting, left);
        }
        true
    }

    /// Waits until everything is written, within the limit. FALSE where something is left.
    pub fn settle_within(&self, limit: &WaitLimit) -> bool {
        self.0.lock().note_left_out();
        self.0.changed.notify_all();
        self.0.wait_within(limit, Waiting::is_settled).is_settled()
    }
}

impl WaitLimit {
    /// Until this flag is set.
    pub fn until(interrupt: &'static AtomicBool) -> WaitLimit {
        WaitLimit { interrupt, left: Mutex::new(AFTER_INTERRUPT) }
    }

    /// How long to wait before this is asked again; zero where the limit is reached.
    fn slice(&self) -> Duration {
        if !self.interrupt.load(Ordering::Relaxed) {
            return SLICE;
        }
        SLICE.min(*self.left.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// So much was waited for since the interrupt.
    fn take(&self, waited: Duration) {
        let mut left = self.left.lock().unwrap_or_else(PoisonError::into_inner);
        *left = left.saturating_sub(waited);
    }
}

impl Waiting {
    fn is_settled(&self) -> bool {
        self.bytes.is_empty() && !self.writes
    }

    fn has_room(&self, text: &[u8]) -> bool {
        self.bytes.is_empty() || self.bytes.len() + text.len() <= ROOM
    }

    /// Takes a text for which there is room, or counts it.
    fn push(&mut self, text: &[u8]) {
        if self.bytes.len() + text.len() > ROOM {
            self.left_out += 1;
        } else {
            self.append(text);
        }
    }

    fn append(&mut self, text: &[u8]) {
        self.note_left_out();
        self.bytes.extend_from_slice(text);
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

    fn wait<'a>(&self, waiting: MutexGuard<'a, Waiting>, limit: Duration) -> MutexGuard<'a, Waiting> {
        self.changed.wait_timeout(waiting, limit).unwrap_or_else(PoisonError::into_inner).0
    }

    /// Waits for what is `wanted`, within the limit.
    fn wait_within(&self, limit: &WaitLimit, wanted: impl Fn(&Waiting) -> bool) -> MutexGuard<'_, Waiting> {
        let mut waiting = self.lock();
        while !wanted(&waiting) {
            let interrupted = limit.interrupt.load(Ordering::Relaxed);
            let slice = limit.slice();
            if slice.is_zero() {
                break;
            }
            let began = Instant::now();
            waiting = self.wait(waiting, slice);
            if interrupted {
                limit.take(began.elapsed());
            }
        }
        waiting
    }

    fn write_with(&self, mut write: impl FnMut(&[u8]), mut idle: impl FnMut()) {
        loop {
            let mut waiting = self.lock();
            waiting.writes = false;
            while waiting.bytes.is_empty() {
                self.changed.notify_all();
                waiting = self.wait(waiting, IDLE);
                if waiting.bytes.is_empty() {
                    drop(waiting);
                    idle();
                    waiting = self.lock();
                }
            }
            let bytes = std::mem::take(&mut waiting.bytes);
            waiting.writes = true;
            self.changed.notify_all();
            drop(waiting);
            write(&bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{PipeReader, Read, Write};
    use std::sync::mpsc;

    const SOON: Duration = Duration::from_millis(20);
    const LONG: Duration = Duration::from_secs(60);

    fn queue() -> (LineQueue, PipeReader) {
        let (reader, mut writer) = io::pipe().expect("a pipe");
        let write = move |text: &[u8]| writer.write_all(text).expect("the test reads");
        (LineQueue::start("test", write, || {}).expect("a thread"), reader)
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

    #[test]
    fn who_waits_for_room_loses_nothing_also_of_texts_longer_than_the_room() {
        static NEVER: AtomicBool = AtomicBool::new(false);
        let limit = WaitLimit::until(&NEVER);
        let (queue, mut reader) = queue();
        let texts: Vec<Vec<u8>> = (0..40_u8).map(|n| vec![n; ROOM / 8 * usize::from(n % 10)]).collect();
        let wanted = texts.concat();
        let length = wanted.len();
        let reads = std::thread::spawn(move || {
            let mut read = vec![0; length];
            reader.read_exact(&mut read).expect("all texts");
            read
        });
        texts.iter().for_each(|text| queue.put_within(text, &limit));
        assert!(queue.settle_within(&limit));
        assert!(reads.join().expect("the reader") == wanted, "what came out is not what was put in");
    }

    #[test]
    fn an_interrupt_ends_the_wait_for_room_and_the_seconds_of_all_queues_are_one() {
        static INTERRUPT: AtomicBool = AtomicBool::new(false);
        let limit = WaitLimit::until(&INTERRUPT);
        let (kept, wait) = mpsc::channel::<()>();
        let wait = Arc::new(Mutex::new(wait));
        // They take nothing until the test ends.
        let stuck: Vec<LineQueue> = (0..2)
            .map(|_| {
                let wait = wait.clone();
                LineQueue::start("test", move |_| drop(wait.lock().map(|wait| wait.recv())), || {})
                    .expect("a thread")
            })
            .collect();
        let interrupts = std::thread::spawn(|| {
            std::thread::sleep(2 * SLICE);
            INTERRUPT.store(true, Ordering::Relaxed);
            Instant::now()
        });
        for _ in 0..8 {
            stuck.iter().for_each(|queue| queue.put_within(&vec![b'x'; ROOM], &limit));
        }
        assert!(stuck.iter().all(|queue| !queue.settle_within(&limit)));
        let interrupted = interrupts.join().expect("the other thread");
        let lasted = interrupted.elapsed();
        assert!(lasted >= AFTER_INTERRUPT - SLICE, "readers have their second: {lasted:?}");
        assert!(lasted < AFTER_INTERRUPT * 5, "it is one second, and not one for each text: {lasted:?}");
        // It is bounded, and nothing is lost without a word.
        for queue in &stuck {
            let waiting = queue.0.lock();
            assert!(waiting.bytes.len() <= ROOM + 200, "{}", waiting.bytes.len());
            assert!(waiting.bytes.ends_with(b"because nobody read them\n"));
        }
        drop(kept);
    }
}
