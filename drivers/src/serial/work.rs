//! The thread that holds a port: it receives messages, sends outputs, and opens a port again that went away.

use std::future::{Future, poll_fn};
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::task::Poll;

use host::{AtomicInstant, Bell, HostInstant, Realtime, Role};
use tokio::runtime::Runtime;
use tokio::sync::Notify;

use rtrb::{Consumer, Producer, RingBuffer};
use signal::{MAX_SERIAL_DATA, SerialErrors, SerialMessage, SerialOutput, Span, Time, When};

use super::find::Identity;
use super::frames::{Frames, Framing, LineFrame};
use super::timer::Timer;
use super::{PortSpec, Received, SerialError, SerialPort};

/// How often a port that is away is looked for.
const EVERY: Span = Span::from_millis(100);

/// Messages that nobody took yet: some seconds of a busy line.
const REPORTS: usize = 1_024;

/// Outputs that wait for the thread.
const ORDERS: usize = 64;

/// The instants of a message whose stamps the board turns into its time.
const NOWHERE: When = When { earliest: Time::ZERO, latest: Time::ZERO };

/// How much longer than on the line an output may take to be sent.
const PATIENCE: Span = Span::from_secs(1);

/// What became of characters on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Passed {
    /// They were received.
    Received,
    /// They were sent.
    Sent,
    /// They were not sent in time.
    NotSent,
}

/// Characters on the line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Report {
    /// What became of them.
    pub(super) passed: Passed,
    /// When the first of them began: not before, and by then.
    pub(super) first: (HostInstant, HostInstant),
    /// When the last of them ended, or when that was given up: not before, and by then.
    pub(super) last: (HostInstant, HostInstant),
    /// They.
    pub(super) message: SerialMessage,
}

/// What the thread is asked to send: characters, or a break.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    data: [u8; MAX_SERIAL_DATA],
    /// 0 for a break.
    len: u16,
    /// How long a break lasts.
    lasts: Span,
}

impl Order {
    /// `None` for what a port cannot do: gaps between characters, and characters that are wrong on purpose.
    pub(super) fn of(output: &SerialOutput) -> Option<Order> {
        let mut bytes = [0; MAX_SERIAL_DATA];
        match output {
            SerialOutput::Characters { data, gap: Span::ZERO, flaw: None } if !data.is_empty() => {
                bytes.get_mut(..data.len())?.copy_from_slice(data);
                Some(Order { data: bytes, len: u16::try_from(data.len()).ok()?, lasts: Span::ZERO })
            }
            SerialOutput::Break(lasts) if *lasts > Span::ZERO => {
                Some(Order { data: bytes, len: 0, lasts: *lasts })
            }
            SerialOutput::Characters { .. } | SerialOutput::Break(_) => None,
        }
    }

    fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }
}

/// The ends of the queues between board and thread.
pub(super) struct Queues {
    pub(super) reports: Producer<Report>,
    pub(super) orders: Consumer<Order>,
}

/// What the board and the thread of a port share.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// The port is away.
    pub(super) gone: AtomicBool,
    /// When it went away last.
    pub(super) since: AtomicInstant,
    /// How often it went away.
    pub(super) losses: AtomicU32,
    /// Since when a call is under way.
    pub(super) in_call: Arc<AtomicInstant>,
    /// Calls that failed.
    pub(super) failed: AtomicU64,
    /// Messages that found no room on their way to the board.
    pub(super) overflowed: AtomicU32,
    /// Nothing is sent, whatever is asked.
    pub(super) latched: AtomicBool,
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
    /// How messages are told apart.
    pub(super) framing: Framing,
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
    pub(super) fn run(self, runtime: &Runtime, port: SerialPort, mut queues: Queues) {
        runtime.block_on(self.serve(port, &mut queues));
        self.shared.ended.store(true, Ordering::Release);
        self.shared.answer.ring();
    }

    async fn serve(&self, port: SerialPort, queues: &mut Queues) {
        let mut received = Received::with_room();
        let mut held = Some(port);
        while let Some(mut port) = held.take() {
            // A refusal is told once for all threads, by whoever set up the run. Looking for a port that is away reads
            // many files, and can wait for everybody else.
            let entered = self.realtime.enter_for_now(Role::Devices);
            let over = self.hold(&mut port, &mut received, queues).await;
            drop(entered);
            if over == Over::Stopped {
                return;
            }
            self.shared.since.set(HostInstant::now());
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
        self.shared.in_call.set(HostInstant::now());
        let outcome = call();
        self.shared.in_call.clear();
        outcome
    }

    /// Receives and sends until the port goes away.
    async fn hold(&self, port: &mut SerialPort, received: &mut Received, queues: &mut Queues) -> Over {
        let mut frames = Frames::new(self.framing);
        loop {
            while let Ok(order) = queues.orders.pop() {
                if !self.shared.latched.load(Ordering::Acquire)
                    && self.send(port, order, queues).await.is_err()
                {
                    return Over::Gone;
                }
            }
            let outcome = {
                let mut woken = pin!(self.shared.wake.notified());
                let mut frame = pin!(port.frame(&mut frames, HostInstant::NEVER, received));
                poll_fn(|cx| match woken.as_mut().poll(cx) {
                    Poll::Ready(()) => Poll::Ready(None),
                    Poll::Pending => frame.as_mut().poll(cx).map(Some),
                })
                .await
            };
            match outcome {
                None if self.stopped() => return Over::Stopped,
                None | Some(Ok(None)) => {}
                Some(Ok(Some(frame))) => {
                    let shortest = port.line().lasts(frame.bytes.len() as u64);
                    self.report(queues, received_report(&frame, shortest));
                }
                Some(Err(_)) => return Over::Gone,
            }
        }
    }

    /// Sends, and reports when it was sent. What comes meanwhile waits in the kernel.
    async fn send(
        &self,
        port: &mut SerialPort,
        order: Order,
        queues: &mut Queues,
    ) -> Result<(), SerialError> {
        let begun = HostInstant::now();
        let is_break = order.data().is_empty();
        let lasts = match is_break {
            true => order.lasts,
            false => port.line().lasts(u64::from(order.len)),
        };
        let until = begun + lasts * 2 + PATIENCE;
        let sent = if is_break {
            let sent = port.send_break(order.lasts, until).await;
            sent.map(|()| (begun + lasts, HostInstant::now()))
        } else {
            match port.send(order.data()).await {
                Ok(sending) => port.drain(sending, until).await,
                Err(error) => Err(error),
            }
        };
        let (passed, last) = match sent {
            Ok(last) => (Passed::Sent, last),
            // What the port refuses, such as a break that its driver does not know, does not take the port away.
            Err(error) if !error.is_gone() => {
                self.shared.failed.fetch_add(1, Ordering::Relaxed);
                (Passed::NotSent, (begun, HostInstant::now()))
            }
            Err(error) => return Err(error),
        };
        let first = (begun, (last.1 - lasts).max(begun));
        let mut message = SerialMessage::of(NOWHERE, NOWHERE, order.data());
        message.errors.breaks = u16::from(is_break);
        self.report(queues, Report { passed, first, last, message });
        Ok(())
    }

    fn report(&self, queues: &mut Queues, report: Report) {
        if queues.reports.push(report).is_err() {
            self.shared.overflowed.fetch_add(1, Ordering::AcqRel);
        }
        self.bell.ring();
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
            timer.set(HostInstant::now() + EVERY).ok()?;
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

/// What was received, of characters that take at least so long.
fn received_report(frame: &LineFrame, shortest: Span) -> Report {
    let mut message = SerialMessage::of(NOWHERE, NOWHERE, &frame.bytes);
    message.doubtful = frame.doubtful;
    message.errors = SerialErrors {
        damaged: u16::try_from(frame.damaged).unwrap_or(u16::MAX),
        breaks: u16::try_from(frame.breaks).unwrap_or(u16::MAX),
        // What was too long was cut off.
        overruns: u16::from(frame.overlong),
        ..SerialErrors::NONE
    };
    let last = ((frame.first.0 + shortest).min(frame.last), frame.last);
    Report { passed: Passed::Received, first: frame.first, last, message }
}

/// The board's side of a port at work. Dropping it ends the thread and closes the port.
#[derive(Debug)]
pub(super) struct Running {
    pub(super) shared: Arc<Shared>,
    /// What passed on the line and was not taken yet.
    pub(super) reports: Consumer<Report>,
    orders: Producer<Order>,
    /// How long the end of a call is waited for.
    patience: Span,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Running {
    /// Starts the thread.
    pub(super) fn start(
        worker: Worker,
        runtime: Runtime,
        port: SerialPort,
        patience: Span,
    ) -> std::io::Result<Running> {
        let shared = worker.shared.clone();
        let (reports, to_take) = RingBuffer::new(REPORTS);
        let (to_give, orders) = RingBuffer::new(ORDERS);
        let queues = Queues { reports, orders };
        let name = worker.spec.path.file_name().map_or_else(String::new, |name| name.display().to_string());
        let thread = std::thread::Builder::new()
            .name(format!("serial {name}"))
            .spawn(move || worker.run(&runtime, port, queues))?;
        Ok(Running { shared, reports: to_take, orders: to_give, patience, thread: Some(thread) })
    }

    /// Hands an output to the thread; FALSE where there is no room.
    pub(super) fn order(&mut self, order: Order) -> bool {
        let room = self.orders.push(order).is_ok();
        self.shared.wake.notify_one();
        room
    }
}

#[cfg(test)]
impl Running {
    /// A port whose thread is at its end.
    pub(super) fn ended(shared: Arc<Shared>) -> Running {
        shared.ended.store(true, Ordering::Release);
        let (orders, _) = RingBuffer::new(1);
        Running { shared, reports: RingBuffer::new(1).1, orders, patience: Span::ZERO, thread: None }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        self.shared.wake.notify_one();
        let due = HostInstant::now() + self.patience;
        while !self.shared.ended.load(Ordering::Acquire) {
            // A thread inside a call that hangs is left to it: when the call ends, the stop is all that it finds.
            if HostInstant::now() >= due {
                return;
            }
            self.shared.answer.wait_until(due);
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
