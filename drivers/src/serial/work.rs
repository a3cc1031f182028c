//! The thread that holds a port, and what it shares with the board.

use std::future::{Future, poll_fn};
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU32, AtomicU64, Ordering};
use std::task::Poll;

use host::{Bell, Realtime, Role, monotonic};
use tokio::runtime::Runtime;
use tokio::sync::Notify;

use super::find::Identity;
use super::timer::Timer;
use super::{PortSpec, Received, SerialPort};

/// How often a port that is away is looked for, in nanoseconds.
const EVERY: i64 = 100_000_000;

/// What the board and the thread of a port share.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// The port is away.
    pub(super) gone: AtomicBool,
    /// Since which stamp it is, if it is.
    pub(super) since: AtomicI64,
    /// How often it went away.
    pub(super) losses: AtomicU32,
    /// The stamp since when a call is under way; 0 for none.
    pub(super) in_call: Arc<AtomicI64>,
    /// Calls that failed.
    pub(super) failed: AtomicU64,
    stop: AtomicBool,
    ended: AtomicBool,
    wake: Notify,
    /// Wakes whoever waits for the thread.
    pub(super) answer: Bell,
}

/// The thread's side of a port.
#[derive(Debug)]
pub(super) struct Worker {
    pub(super) spec: PortSpec,
    /// What the port was when it was opened.
    pub(super) identity: Option<Identity>,
    pub(super) shared: Arc<Shared>,
    /// Is rung when there is something to tell.
    pub(super) bell: Arc<Bell>,
    /// It is taken back when it is there again.
    pub(super) reconnect: bool,
    /// How the thread runs while it has a port.
    pub(super) realtime: Realtime,
}

/// Why a port is held no longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Over {
    Stopped,
    Gone,
}

impl Worker {
    /// The thread.
    pub(super) fn run(self, runtime: &Runtime, port: SerialPort) {
        runtime.block_on(self.serve(port));
        self.shared.ended.store(true, Ordering::Release);
        self.shared.answer.ring();
    }

    async fn serve(&self, port: SerialPort) {
        let mut received = Received::with_room();
        let mut held = Some(port);
        while let Some(mut port) = held.take() {
            // A refusal is told once for all threads, by whoever set up the run. Looking for a port that is away reads
            // many files, and can wait for everybody else.
            let entered = self.realtime.enter_for_now(Role::Devices);
            let over = self.hold(&mut port, &mut received).await;
            drop(entered);
            if over == Over::Stopped {
                return;
            }
            self.shared.since.store(monotonic(), Ordering::Release);
            self.shared.losses.fetch_add(1, Ordering::AcqRel);
            self.shared.failed.fetch_add(1, Ordering::Relaxed);
            self.gone(true);
            // What is closed may be slow to go.
            self.timed(|| drop(port));
            if !self.reconnect {
                return;
            }
            held = self.take_back().await;
            if held.is_some() {
                self.gone(false);
            }
        }
    }

    fn gone(&self, gone: bool) {
        self.shared.gone.store(gone, Ordering::Release);
        self.bell.ring();
        self.shared.answer.ring();
    }

    fn timed<T>(&self, call: impl FnOnce() -> T) -> T {
        self.shared.in_call.store(monotonic(), Ordering::Release);
        let outcome = call();
        self.shared.in_call.store(0, Ordering::Release);
        outcome
    }

    /// Empties the port until it goes away: nobody listens yet, and what nobody reads would be told as lost later.
    async fn hold(&self, port: &mut SerialPort, received: &mut Received) -> Over {
        loop {
            let mut woken = pin!(self.shared.wake.notified());
            let outcome = poll_fn(|cx| match woken.as_mut().poll(cx) {
                Poll::Ready(()) => Poll::Ready(None),
                Poll::Pending => port.poll_receive(cx, received).map(Some),
            });
            match outcome.await {
                None if self.stopped() => return Over::Stopped,
                None | Some(Ok(())) => {}
                Some(Err(_)) => return Over::Gone,
            }
        }
    }

    /// Looks for the port until it is there again: the same one, and as it was. `None` when the board is gone first.
    async fn take_back(&self) -> Option<SerialPort> {
        // Without a timer nothing can be waited for.
        let timer = Timer::new().ok()?;
        loop {
            if self.stopped() {
                return None;
            }
            if Identity::of(&self.spec.path) == self.identity
                && let Ok(port) =
                    self.timed(|| SerialPort::watched(&self.spec, Arc::clone(&self.shared.in_call)))
            {
                return Some(port);
            }
            timer.set(monotonic().saturating_add(EVERY)).ok()?;
            let mut woken = pin!(self.shared.wake.notified());
            poll_fn(|cx| match woken.as_mut().poll(cx) {
                Poll::Ready(()) => Poll::Ready(()),
                Poll::Pending => timer.poll(cx).map(drop),
            })
            .await;
        }
    }

    fn stopped(&self) -> bool {
        self.shared.stop.load(Ordering::Acquire)
    }
}

/// The board's side of a port at work. Dropping it ends the thread and closes the port.
#[derive(Debug)]
pub(super) struct Running {
    pub(super) shared: Arc<Shared>,
    /// How long the end of a call is waited for, in nanoseconds.
    patience: i64,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Running {
    /// Starts the thread.
    pub(super) fn start(
        worker: Worker,
        runtime: Runtime,
        port: SerialPort,
        patience: i64,
    ) -> std::io::Result<Running> {
        let shared = worker.shared.clone();
        let name = worker.spec.path.file_name().map_or_else(String::new, |name| name.display().to_string());
        let thread = std::thread::Builder::new()
            .name(format!("serial {name}"))
            .spawn(move || worker.run(&runtime, port))?;
        Ok(Running { shared, patience, thread: Some(thread) })
    }
}

#[cfg(test)]
impl Running {
    /// A port whose thread is at its end.
    pub(super) fn ended(shared: Arc<Shared>) -> Running {
        shared.ended.store(true, Ordering::Release);
        Running { shared, patience: 0, thread: None }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        self.shared.wake.notify_one();
        let due = monotonic().saturating_add(self.patience);
        while !self.shared.ended.load(Ordering::Acquire) {
            // A thread inside a call that hangs is left to it: when the call ends, the stop is all that it finds.
            if monotonic() >= due {
                return;
            }
            self.shared.answer.wait_until(due);
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
