//! A serial port: bytes with their harm and the stamps of the looks at them, sending, breaks, counters.

use std::fs::File;
use std::future::poll_fn;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use host::{AtomicInstant, HostInstant, LineCounters, line_counters, transmitter_is_empty};
use rustix::io::Errno;
use rustix::termios::{QueueSelector, tcflush};
use signal::{SerialSettings, Span};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio_serial::{SerialPort as _, SerialStream};

use super::assembler::{MessageAssembler, ReceivedMessage};
use super::marks::{Marks, Symbol};
use super::open::{OpenError, open};
use super::timer::Timer;
use super::{PortSpec, SerialCall, SerialError};

/// Bytes of one read: as many as the kernel keeps of a port.
const READ: usize = 4_096;

/// What one read of a port gave.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Received {
    /// What came, oldest first.
    pub symbols: Vec<Symbol>,
    /// The last look before it that found nothing.
    pub empty: HostInstant,
    /// When it was read.
    pub read: HostInstant,
}

impl Received {
    /// Room for what one read can give.
    pub fn with_room() -> Received {
        Received { symbols: Vec::with_capacity(READ + 1), ..Received::default() }
    }
}

/// Bytes on their way out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sending {
    /// When the first of them was handed to the kernel.
    pub begun: HostInstant,
    /// How many they are.
    pub bytes: usize,
}

/// An open serial port, on a current-thread tokio runtime. Nothing here waits but the calls that say so.
#[derive(Debug)]
pub struct SerialPort {
    stream: SerialStream,
    control: File,
    timer: Timer,
    spec: PortSpec,
    pseudo: bool,
    marks: Marks,
    raw: Box<[u8]>,
    empty: HostInstant,
    in_call: Arc<AtomicInstant>,
}

impl SerialPort {
    /// Opens a port as its board file says. What had been received before is thrown away.
    ///
    /// # Errors
    /// Why not.
    ///
    /// # Panics
    /// Outside of a tokio runtime with input and output.
    pub fn open(spec: &PortSpec) -> Result<SerialPort, OpenError> {
        SerialPort::watched(spec, Arc::default())
    }

    /// As [`SerialPort::open`]; `in_call` is, while a call on the device is under way, since when it is.
    pub(super) fn watched(spec: &PortSpec, in_call: Arc<AtomicInstant>) -> Result<SerialPort, OpenError> {
        let empty = HostInstant::now();
        let opened = open(spec)?;
        let failed = |call| move |error: std::io::Error| SerialError::new(&spec.path, call, &error);
        let timer = Timer::new().map_err(failed(SerialCall::Open))?;
        tcflush(&opened.control, QueueSelector::IOFlush)
            .map_err(|errno| SerialError::of(&spec.path, SerialCall::Open, errno))?;
        Ok(SerialPort {
            stream: opened.stream,
            control: opened.control,
            timer,
            spec: spec.clone(),
            pseudo: opened.pseudo,
            marks: Marks::default(),
            raw: vec![0; READ].into_boxed_slice(),
            empty,
            in_call,
        })
    }

    /// How it was set up.
    pub fn spec(&self) -> &PortSpec {
        &self.spec
    }

    /// How it carries bytes.
    pub fn line(&self) -> &SerialSettings {
        &self.spec.line
    }

    /// It is a pseudo-terminal: no bits, no parity, no time on the line, no breaks, no counters.
    pub fn is_pseudo(&self) -> bool {
        self.pseudo
    }

    /// Marks how long a call on the device takes.
    fn call<T>(&mut self, call: impl FnOnce(&mut SerialPort) -> T) -> T {
        self.in_call.set(HostInstant::now());
        let outcome = call(self);
        self.in_call.clear();
        outcome
    }

    fn failed(&self, call: SerialCall) -> impl Fn(std::io::Error) -> SerialError + '_ {
        move |error| SerialError::new(&self.spec.path, call, &error)
    }

    /// Reads what is there, or waits. `into` is written only when something was read.
    pub fn poll_receive(
        &mut self,
        cx: &mut Context<'_>,
        into: &mut Received,
    ) -> Poll<Result<(), SerialError>> {
        let read = self.call(|port| {
            let mut buffer = ReadBuf::new(&mut port.raw);
            let read = Pin::new(&mut port.stream).poll_read(cx, &mut buffer);
            read.map_ok(|()| buffer.filled().len())
        });
        match read {
            Poll::Ready(Ok(0)) => {
                // A terminal in raw mode has an end only when it is hung up.
                Poll::Ready(Err(SerialError::of(&self.spec.path, SerialCall::Receive, Errno::IO)))
            }
            Poll::Ready(Ok(bytes)) => {
                into.read = HostInstant::now();
                into.empty = self.empty;
                into.symbols.clear();
                for byte in &self.raw[..bytes] {
                    self.marks.take(*byte, |symbol| into.symbols.push(symbol));
                }
                Poll::Ready(Ok(()))
            }
            Poll::Ready(Err(error)) => Poll::Ready(Err(self.failed(SerialCall::Receive)(error))),
            Poll::Pending => match self.look() {
                Ok(_) => Poll::Pending,
                Err(error) => Poll::Ready(Err(error)),
            },
        }
    }

    /// Whether nothing waits to be read, and then when that was.
    fn look(&mut self) -> Result<Option<HostInstant>, SerialError> {
        let looked = HostInstant::now();
        match self.call(|port| port.stream.bytes_to_read()) {
            Ok(0) => {
                self.empty = looked;
                Ok(Some(looked))
            }
            Ok(_) => Ok(None),
            Err(_) => Err(SerialError::last(&self.spec.path, SerialCall::Receive)),
        }
    }

    /// Waits until something was received, at most until then. FALSE when nothing came.
    ///
    /// # Errors
    /// What the kernel says; [`SerialError::is_gone`] when the port is there no more.
    pub async fn receive(&mut self, until: HostInstant, into: &mut Received) -> Result<bool, SerialError> {
        self.timer.set(until).map_err(self.failed(SerialCall::Receive))?;
        poll_fn(|cx| {
            match self.poll_receive(cx, into) {
                Poll::Ready(outcome) => return Poll::Ready(outcome.map(|()| true)),
                Poll::Pending => {}
            }
            match self.timer.poll(cx) {
                Poll::Ready(Ok(())) => Poll::Ready(Ok(false)),
                Poll::Ready(Err(error)) => Poll::Ready(Err(self.failed(SerialCall::Receive)(error))),
                Poll::Pending => Poll::Pending,
            }
        })
        .await
    }

    /// Waits for a message that silence ends or for a full part of a long one, at most until then; the message under way is
    /// waited for longer. Hands on each that is complete; FALSE where there was none.
    ///
    /// # Errors
    /// As [`SerialPort::receive`].
    pub async fn messages(
        &mut self,
        assembler: &mut MessageAssembler,
        until: HostInstant,
        room: &mut Received,
        mut each: impl FnMut(&ReceivedMessage),
    ) -> Result<bool, SerialError> {
        loop {
            let due = assembler.due();
            if self.receive(due.unwrap_or(until), room).await? {
                let mut any = false;
                assembler.take(room, |message| {
                    any = true;
                    each(message);
                });
                if any {
                    return Ok(true);
                }
                continue;
            }
            let Some(looked) = self.look()? else { continue };
            match assembler.quiet(looked) {
                Some(message) => {
                    each(&message);
                    return Ok(true);
                }
                None if due.is_none() => return Ok(false),
                None => {}
            }
        }
    }

    /// Hands bytes to the kernel, waiting while it has no room, at most until then. They are on the line later: see
    /// [`SerialPort::drain`].
    ///
    /// # Errors
    /// As [`SerialPort::receive`]; ETIMEDOUT when there was no room by then: some of them may be with the kernel, see
    /// [`SerialPort::discard_output`].
    pub async fn send(&mut self, bytes: &[u8], until: HostInstant) -> Result<Sending, SerialError> {
        let begun = HostInstant::now();
        self.timer.set(until).map_err(self.failed(SerialCall::Send))?;
        let mut left = bytes;
        while !left.is_empty() {
            let written =
                poll_fn(|cx| match self.call(|port| Pin::new(&mut port.stream).poll_write(cx, left)) {
                    Poll::Pending => self.timer.poll(cx).map(|ended| ended.and(Err(Errno::TIMEDOUT.into()))),
                    written => written,
                });
            match written.await {
                Ok(0) => return Err(SerialError::of(&self.spec.path, SerialCall::Send, Errno::IO)),
                Ok(count) => left = left.get(count..).unwrap_or_default(),
                Err(error) => return Err(self.failed(SerialCall::Send)(error)),
            }
        }
        Ok(Sending { begun, bytes: bytes.len() })
    }

    /// Waits until the last bit has left the port, at most until then. The interval in which it did: not before
    /// its bits had time to, and seen by then. The kernel reports to nobody when that is, so it is looked for about as often
    /// as characters pass.
    ///
    /// # Errors
    /// As [`SerialPort::receive`]; ETIMEDOUT when it is not over by then.
    pub async fn drain(
        &mut self,
        sending: Sending,
        until: HostInstant,
    ) -> Result<(HostInstant, HostInstant), SerialError> {
        let lasts = if self.pseudo { Span::ZERO } else { self.spec.line.lasts(sending.bytes as u64) };
        let earliest = sending.begun + lasts;
        loop {
            let left = self.call(|port| port.stream.bytes_to_write());
            let left = left.map_err(|_| SerialError::last(&self.spec.path, SerialCall::Drain))?;
            let sent = left == 0 && self.transmitted()?;
            let now = HostInstant::now();
            if sent {
                return Ok((earliest.min(now), now));
            }
            if now >= until {
                return Err(SerialError::of(&self.spec.path, SerialCall::Drain, Errno::TIMEDOUT));
            }
            let next = (now + self.spec.line.lasts(u64::from(left).max(1))).min(until);
            self.timer.wait_until(next).await.map_err(self.failed(SerialCall::Drain))?;
        }
    }

    /// Takes back what was sent and the hardware does not have yet.
    ///
    /// # Errors
    /// As [`SerialPort::receive`].
    pub fn discard_output(&mut self) -> Result<(), SerialError> {
        self.discard(QueueSelector::OFlush)
    }

    /// Forgets what was received and not read yet.
    ///
    /// # Errors
    /// As [`SerialPort::receive`].
    pub fn discard_input(&mut self) -> Result<(), SerialError> {
        self.discard(QueueSelector::IFlush)?;
        self.marks = Marks::default();
        Ok(())
    }

    fn discard(&mut self, queue: QueueSelector) -> Result<(), SerialError> {
        let discarded = self.call(|port| tcflush(&port.control, queue));
        discarded.map_err(|errno| SerialError::of(&self.spec.path, SerialCall::Discard, errno))
    }

    /// Whether the hardware has sent all that the kernel gave it, where its driver says so.
    fn transmitted(&mut self) -> Result<bool, SerialError> {
        match self.call(|port| transmitter_is_empty(&port.control)) {
            Err(error) if error.raw_os_error() == Some(Errno::NOTTY.raw_os_error()) => Ok(true),
            other => other.map_err(self.failed(SerialCall::Drain)),
        }
    }

    /// Holds the line at 0 for so long. What is still to be sent goes first.
    ///
    /// # Errors
    /// As [`SerialPort::drain`].
    pub async fn send_break(&mut self, lasts: Span, until: HostInstant) -> Result<(), SerialError> {
        self.drain(Sending { begun: HostInstant::now(), bytes: 0 }, until).await?;
        let set = self.call(|port| port.stream.set_break());
        set.map_err(|_| SerialError::last(&self.spec.path, SerialCall::Break))?;
        let held = Held { stream: &self.stream };
        let over = self.timer.wait_until(HostInstant::now() + lasts).await;
        drop(held);
        over.map_err(self.failed(SerialCall::Break))
    }

    /// What the port counted since it is there; `None` where its driver does not count.
    ///
    /// # Errors
    /// As [`SerialPort::receive`].
    pub fn counters(&mut self) -> Result<Option<LineCounters>, SerialError> {
        match self.call(|port| line_counters(&port.control)) {
            Err(error) if error.raw_os_error() == Some(Errno::NOTTY.raw_os_error()) => Ok(None),
            Err(error) => Err(self.failed(SerialCall::Counters)(error)),
            Ok(counters) => Ok(Some(counters)),
        }
    }
}

impl Drop for SerialPort {
    fn drop(&mut self) {
        // Closing a port waits for what is not sent, for up to half a minute: nobody wants it any more.
        let _ = tcflush(&self.control, QueueSelector::OFlush);
    }
}

/// A line that is held at 0 until this is dropped.
struct Held<'a> {
    stream: &'a SerialStream,
}

impl Drop for Held<'_> {
    fn drop(&mut self) {
        // A port that refuses this is gone.
        let _ = self.stream.clear_break();
    }
}
