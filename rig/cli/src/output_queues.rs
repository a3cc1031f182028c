//! Standard output and standard error of a command, each with a queue in front of it.

use crate::line_queue::{LineQueue, WaitLimit};
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// How long the reader of each stream is waited for at the end of a command that waits for none.
const SETTLE: Duration = Duration::from_secs(1);

/// One of the two streams of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Standard output.
    Output,
    /// Standard error.
    Errors,
}

/// The queues of the two streams.
#[derive(Debug)]
pub struct OutputQueues {
    output: LineQueue,
    errors: LineQueue,
    /// How long readers are waited for; none where nobody waits for them.
    limit: Option<WaitLimit>,
}

impl OutputQueues {
    /// Starts the threads that write, with `write`. Readers are waited for until the interrupt, or not at all. `idle` is called
    /// now and then while nothing waits for standard output.
    ///
    /// # Errors
    /// The machine has no room for two threads.
    pub fn start(
        interrupt: Option<&'static AtomicBool>,
        write: impl Fn(Stream, &[u8]) + Send + Sync + 'static,
        idle: impl FnMut() + Send + 'static,
    ) -> io::Result<OutputQueues> {
        let write = Arc::new(write);
        let also = write.clone();
        Ok(OutputQueues {
            output: LineQueue::start("output", move |text| write(Stream::Output, text), idle)?,
            errors: LineQueue::start("errors", move |text| also(Stream::Errors, text), || {})?,
            limit: interrupt.map(WaitLimit::until),
        })
    }

    /// Whether who prints waits for readers.
    pub fn wait_for_readers(&self) -> bool {
        self.limit.is_some()
    }

    /// Leaves a text for a stream. Where readers are waited for, the other stream is written first: both may be one pipe,
    /// and what was printed first comes first there.
    pub fn put(&self, stream: Stream, text: &[u8]) {
        let (own, other) = match stream {
            Stream::Output => (&self.output, &self.errors),
            Stream::Errors => (&self.errors, &self.output),
        };
        match &self.limit {
            None => own.put(text),
            Some(limit) => {
                // What its reader does not take in time comes later, or not at all.
                let _ = other.settle_within(limit);
                own.put_within(text, limit);
            }
        }
    }

    /// Waits until everything is written: as long as readers are waited for, else for a second each.
    pub fn settle(&self) {
        for queue in [&self.output, &self.errors] {
            // What is left then is nobody's any more.
            let _ = match &self.limit {
                None => queue.settle(SETTLE),
                Some(limit) => queue.settle_within(limit),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn two_streams_of_one_pipe_are_written_in_the_order_of_printing() {
        static NEVER: AtomicBool = AtomicBool::new(false);
        let (written, texts) = mpsc::channel();
        let write = move |stream, text: &[u8]| {
            // One of the two is slow.
            if stream == Stream::Output {
                std::thread::sleep(Duration::from_micros(200));
            }
            written.send((stream, text.to_vec())).expect("the test waits");
        };
        let queues = OutputQueues::start(Some(&NEVER), write, || {}).expect("two threads");
        let printed: Vec<(Stream, Vec<u8>)> = (0..400_u16)
            .map(|number| {
                (if number % 3 == 0 { Stream::Errors } else { Stream::Output }, number.to_le_bytes().to_vec())
            })
            .collect();
        printed.iter().for_each(|(stream, text)| queues.put(*stream, text));
        queues.settle();
        let written: Vec<u8> = texts.try_iter().flat_map(|(_, text)| text).collect();
        assert_eq!(written, printed.into_iter().flat_map(|(_, text)| text).collect::<Vec<u8>>());
    }
}
