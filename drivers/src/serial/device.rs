//! The thread that holds a port: it receives messages, sends outputs, and opens a port again that went away.

use std::future::{Future, poll_fn};
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::task::Poll;

use host::{AtomicInstant, HostInstant, Realtime, ThreadRole};
use rtrb::Consumer;
use signal::{MAX_SERIAL_DATA, SerialMessage, SerialOutput, SerialSettings, Span};
use tokio::runtime::Runtime;
use tokio::sync::Notify;

use super::assembler::{MessageAssembler, MessageTiming, ReceivedMessage, UNSET};
use super::find::Identity;
use super::timer::Timer;
use super::{PortSpec, Received, SerialError, SerialPort};
use crate::thread::Reporter;

/// How often a port that is away is looked for.
const EVERY: Span = Span::from_millis(100);

/// How much longer than on the line an output may take to be sent.
const PATIENCE: Span = Span::from_secs(1);

/// What the thread has to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::large_enum_variant, reason = "copied between queues that never allocate")]
pub(super) enum Event {
    /// Characters, or a break.
    Message {
        /// When the first of them began: not before, and by then.
        first: (HostInstant, HostInstant),
        /// When the last of them ended: not before, and by then.
        last: (HostInstant, HostInstant),
        /// They; its own instants are 0.
        message: SerialMessage,
        /// The rig sent them.
        own: bool,
    },
    /// An output was given up.
    NotSent {
        /// When.
        at: HostInstant,
    },
    /// The port was gone and is there again.
    Returned {
        /// Since when.
        at: HostInstant,
    },
}

/// An event, and the run that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SerialReport {
    pub(super) run: u64,
    pub(super) event: Event,
}

/// What is to be sent: characters, or a break.
#[derive(Clone, Copy, Debug)]
pub(super) struct SerialOrder {
    /// The run that it belongs to.
    run: u64,
    data: [u8; MAX_SERIAL_DATA],
    /// 0 for a break.
    len: u16,
    /// How long a break lasts.
    lasts: Span,
}

impl SerialOrder {
    /// `None` for what a port cannot do: gaps between characters, and characters that are wrong on purpose.
    pub(super) fn of(run: u64, output: &SerialOutput) -> Option<SerialOrder> {
        let mut bytes = [0; MAX_SERIAL_DATA];
        match output {
            SerialOutput::Characters { data, gap: Span::ZERO, flaw: None } if !data.is_empty() => {
                bytes.get_mut(..data.len())?.copy_from_slice(data);
                Some(SerialOrder {
                    run,
                    data: bytes,
                    len: u16::try_from(data.len()).ok()?,
                    lasts: Span::ZERO,
                })
            }
            SerialOutput::Break(lasts) if *lasts > Span::ZERO => {
                Some(SerialOrder { run, data: bytes, len: 0, lasts: *lasts })
            }
            SerialOutput::Characters { .. } | SerialOutput::Break(_) => None,
        }
    }

    fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }

    const fn is_break(&self) -> bool {
        self.len == 0
    }

    /// How long it takes on a line.
    fn lasts_on(&self, line: &SerialSettings) -> Span {
        if self.is_break() { self.lasts } else { line.lasts(u64::from(self.len)) }
    }
}

/// What board and thread share.
#[derive(Debug, Default)]
pub(super) struct SharedPort {
    /// Since when a call is under way, if one is.
    pub(super) in_call: Arc<AtomicInstant>,
    /// The run that was asked for last.
    pub(super) run: AtomicU64,
    /// Nothing is sent, whatever is asked.
    pub(super) latched: AtomicBool,
    /// Starts and safe states that were asked for, and how many of them the thread has seen to.
    pub(super) asked: AtomicU64,
    pub(super) heard: AtomicU64,
    /// Wakes the thread.
    pub(super) wake: Notify,
}

impl SharedPort {
    /// Has the thread look at what is asked; the number of this request.
    pub(super) fn ask(&self) -> u64 {
        let request = self.asked.fetch_add(1, Ordering::AcqRel) + 1;
        self.wake.notify_one();
        request
    }

    /// Whether an order of this run is still to be carried out.
    fn wants(&self, run: u64) -> bool {
        !self.latched.load(Ordering::Acquire) && self.run.load(Ordering::Acquire) == run
    }
}

/// The thread's side of a port.
pub(super) struct SerialThread {
    pub(super) spec: PortSpec,
    /// What the port was when it was opened.
    pub(super) identity: Option<Identity>,
    pub(super) timing: MessageTiming,
    pub(super) shared: Arc<SharedPort>,
    pub(super) orders: Consumer<SerialOrder>,
    pub(super) reporter: Reporter<SerialReport>,
    /// A port that was gone is opened again.
    pub(super) reconnect: bool,
    /// How the thread runs while it has a port.
    pub(super) realtime: Realtime,
    /// The run under way.
    pub(super) run: u64,
}

/// Why a port is held no longer.
enum Over {
    Stopped,
    Gone(SerialError),
}

impl SerialThread {
    /// The thread.
    pub(super) fn run(mut self, runtime: &Runtime, port: SerialPort) {
        runtime.block_on(self.serve(port));
        self.reporter.end();
    }

    async fn serve(&mut self, port: SerialPort) {
        let mut received = Received::with_room();
        let mut held = Some(port);
        while let Some(mut port) = held.take() {
            // A refusal is reported once for all threads, by whoever set up the run. Looking for a port that is away reads
            // many files, and can wait for everybody else.
            let entered = self.realtime.enter_for_now(ThreadRole::Devices);
            let over = self.hold(&mut port, &mut received).await;
            drop(entered);
            let Over::Gone(error) = over else { return };
            self.reporter.gives_up(&error.io());
            self.reporter.ring();
            // What is closed may be slow to go.
            self.timed(|| drop(port));
            if !self.reconnect {
                return;
            }
            held = self.look_again().await;
            if held.is_some() {
                let event = Event::Returned { at: HostInstant::now() };
                self.reporter.returned(SerialReport { run: self.run, event });
                self.reporter.ring();
                self.reporter.answer();
            }
        }
    }

    fn timed<T>(&self, call: impl FnOnce() -> T) -> T {
        self.shared.in_call.set(HostInstant::now());
        let outcome = call();
        self.shared.in_call.clear();
        outcome
    }

    /// Receives and sends until the port goes away.
    async fn hold(&mut self, port: &mut SerialPort, received: &mut Received) -> Over {
        let mut assembler = MessageAssembler::new(self.timing);
        while !self.reporter.is_stopped() {
            // The order matters: whoever asks sets what is asked first, then counts.
            let asked = self.shared.asked.load(Ordering::Acquire);
            let run = self.shared.run.load(Ordering::Acquire);
            if run != self.run {
                // What came before a run is not of it.
                self.run = run;
                self.reporter.works();
                assembler.clear();
                if let Err(error) = port.discard_input() {
                    return Over::Gone(error);
                }
            }
            if self.shared.heard.swap(asked, Ordering::AcqRel) != asked {
                self.reporter.answer();
            }
            while let Ok(order) = self.orders.pop() {
                if self.shared.wants(order.run)
                    && let Err(error) = self.send(port, &order).await
                {
                    return Over::Gone(error);
                }
            }
            // A wake that came while something was sent is gone.
            if self.reporter.is_stopped() || self.shared.asked.load(Ordering::Acquire) != asked {
                continue;
            }
            if let Err(error) = self.receive(port, &mut assembler, received).await {
                return Over::Gone(error);
            }
        }
        Over::Stopped
    }

    /// Reports messages as they come, until something is asked.
    async fn receive(
        &mut self,
        port: &mut SerialPort,
        assembler: &mut MessageAssembler,
        received: &mut Received,
    ) -> Result<(), SerialError> {
        let outcome = {
            let SerialThread { shared, reporter, run, .. } = self;
            let (line, run) = (*port.line(), *run);
            let report = |message: &ReceivedMessage| {
                reporter.report(SerialReport { run, event: as_received(message, &line) });
            };
            let mut woken = pin!(shared.wake.notified());
            let mut messages = pin!(port.messages(assembler, HostInstant::NEVER, received, report));
            poll_fn(|cx| match woken.as_mut().poll(cx) {
                Poll::Ready(()) => Poll::Ready(Ok(())),
                Poll::Pending => messages.as_mut().poll(cx).map(|outcome| outcome.map(drop)),
            })
            .await
        };
        self.reporter.ring();
        outcome
    }

    /// Sends, and reports when that was done. What comes meanwhile waits in the kernel. Nothing of an output that its run
    /// does not want any more, or that was not sent in time, is left in the kernel.
    async fn send(&mut self, port: &mut SerialPort, order: &SerialOrder) -> Result<(), SerialError> {
        let begun = HostInstant::now();
        let lasts = order.lasts_on(port.line());
        let sent = match self.put_out(port, order, begun + lasts + lasts + PATIENCE).await {
            Some(Ok(last)) => Some(last),
            Some(Err(error)) if error.is_gone() => return Err(error),
            // What the port refuses, such as a break that its driver does not know, does not take the port away.
            Some(Err(_)) => {
                self.reporter.failed();
                None
            }
            None => return port.discard_output(),
        };
        let event = match sent {
            Some(last) => {
                let mut message = SerialMessage::of(UNSET, UNSET, order.data());
                message.errors.breaks = u16::from(order.is_break());
                Event::Message { first: (begun, (last.1 - lasts).max(begun)), last, message, own: true }
            }
            None => {
                port.discard_output()?;
                Event::NotSent { at: HostInstant::now() }
            }
        };
        self.reporter.report(SerialReport { run: order.run, event });
        self.reporter.ring();
        Ok(())
    }

    /// When the last bit of an output left the port; `None` where its run was over before.
    async fn put_out(
        &self,
        port: &mut SerialPort,
        order: &SerialOrder,
        until: HostInstant,
    ) -> Option<Result<(HostInstant, HostInstant), SerialError>> {
        let mut sending = pin!(output(port, order, until));
        loop {
            let mut woken = pin!(self.shared.wake.notified());
            let ended = poll_fn(|cx| match sending.as_mut().poll(cx) {
                Poll::Ready(outcome) => Poll::Ready(Some(outcome)),
                Poll::Pending => woken.as_mut().poll(cx).map(|()| None),
            });
            let ended = ended.await;
            if ended.is_some() {
                return ended;
            }
            if self.reporter.is_stopped() || !self.shared.wants(order.run) {
                return None;
            }
        }
    }

    /// Looks for the port until it is there again: the same one, and as it was. `None` when the board is gone first.
    async fn look_again(&self) -> Option<SerialPort> {
        // Without a timer nothing can be waited for.
        let timer = Timer::new().ok()?;
        while !self.reporter.is_stopped() {
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
        None
    }
}

/// Sends an order. When its last bit left the port: not before, and by then.
async fn output(
    port: &mut SerialPort,
    order: &SerialOrder,
    until: HostInstant,
) -> Result<(HostInstant, HostInstant), SerialError> {
    if order.is_break() {
        let begun = HostInstant::now();
        port.send_break(order.lasts, until).await?;
        return Ok((begun + order.lasts, HostInstant::now()));
    }
    let sending = port.send(order.data(), until).await?;
    port.drain(sending, until).await
}

/// What was received, at the speed of this line.
fn as_received(received: &ReceivedMessage, line: &SerialSettings) -> Event {
    let shortest = line.lasts(received.message.data().len() as u64);
    let last = ((received.first.0 + shortest).min(received.last), received.last);
    Event::Message { first: received.first, last, message: received.message, own: false }
}
