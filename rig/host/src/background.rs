//! Work that may take long, such as reading a file of a slow disk, on a thread of its own: whoever wants its result waits for
//! it no longer than it chose to.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::time::{Duration, Instant};

/// Reports to the work whether anybody still waits for it.
#[derive(Clone, Debug, Default)]
pub struct Abandoned(Arc<AtomicBool>);

impl Abandoned {
    /// Nobody waits for the result any more: work of many parts ends between two of them.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Work on a thread of its own. The thread is never joined: one that hangs in the kernel is left to it.
#[derive(Debug)]
pub struct BackgroundTask<T> {
    result: Receiver<T>,
    abandoned: Abandoned,
    until: Instant,
}

/// What became of the work so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskProgress<T> {
    /// It goes on, and there is time left.
    Running,
    /// It is done.
    Done(T),
    /// It did not end within its time, or ended in a panic: there will be no result.
    GivenUp,
}

impl<T: Send + 'static> BackgroundTask<T> {
    /// Starts the work on a thread of this name, whose result is wanted within `limit`.
    ///
    /// # Errors
    /// The machine has no room for another thread.
    pub fn start(
        name: &str,
        limit: Duration,
        work: impl FnOnce(&Abandoned) -> T + Send + 'static,
    ) -> io::Result<BackgroundTask<T>> {
        let (sender, result) = mpsc::sync_channel(1);
        let abandoned = Abandoned::default();
        let asked = abandoned.clone();
        let run = move || {
            // Where nobody waits any more the result is of no use.
            let _ = sender.send(work(&asked));
        };
        std::thread::Builder::new().name(name.to_owned()).spawn(run)?;
        Ok(BackgroundTask { result, abandoned, until: Instant::now() + limit })
    }

    /// What became of it, without a wait.
    pub fn progress(&self) -> TaskProgress<T> {
        match self.result.try_recv() {
            Ok(result) => TaskProgress::Done(result),
            Err(TryRecvError::Empty) if Instant::now() < self.until => TaskProgress::Running,
            Err(_) => TaskProgress::GivenUp,
        }
    }

    /// Waits for the result until its time is over; `None` where there is none by then.
    pub fn wait(self) -> Option<T> {
        let left = self.until.saturating_duration_since(Instant::now());
        self.result.recv_timeout(left).ok()
    }
}

impl<T> Drop for BackgroundTask<T> {
    fn drop(&mut self) {
        self.abandoned.0.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(60);

    #[test]
    fn work_that_ends_has_a_result_and_work_that_hangs_is_given_up_and_learns_it() {
        let task = BackgroundTask::start("short", LONG, |_| 5).expect("a thread");
        assert_eq!(task.wait(), Some(5));
        let (ended, end) = mpsc::channel();
        let task = BackgroundTask::start("endless", Duration::ZERO, move |abandoned| {
            while !abandoned.is_set() {
                std::thread::yield_now();
            }
            ended.send(()).expect("the test waits");
        });
        let task = task.expect("a thread");
        assert_eq!(task.progress(), TaskProgress::GivenUp);
        drop(task);
        end.recv_timeout(LONG).expect("it learned that nobody waits");
    }

    #[test]
    fn work_that_panics_is_given_up_at_once() {
        let task = BackgroundTask::<()>::start("panics", LONG, |_| panic!("as the test wants it"));
        assert_eq!(task.expect("a thread").wait(), None);
    }
}
