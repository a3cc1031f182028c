//! What the two threads of a chip and the board share, and the threads.

use std::os::fd::{BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, AtomicU64, Ordering};

use host::{AtomicInstant, Bell, HostInstant, Realtime};
use rtrb::{Consumer, Producer};
use rustix::event::{EventfdFlags, Timespec, eventfd};
use signal::Span;

use super::device::{ChipReport, ChipThread, Image, device};
use super::edges::{Edges, Note, edges};
use super::pace::PulsePace;
use super::port::GpioPort;

/// What board and threads of a chip share.
#[derive(Debug)]
pub(super) struct SharedChip {
    /// Outputs stay safe, whatever is asked.
    pub(super) latched: AtomicBool,
    /// The latch that the device has carried out: none, or the number of it.
    pub(super) made_safe: AtomicU64,
    /// Number of latches asked for.
    pub(super) wanted_safe: AtomicU64,
    /// Number of starts asked for.
    pub(super) starts: AtomicU64,
    /// Images that the device has dealt with.
    pub(super) taken: AtomicU64,
    /// Since when a call is under way.
    pub(super) in_call: AtomicInstant,
    /// The error that ended the work with the chip; 0 for none.
    gone: AtomicI32,
    /// When that was.
    pub(super) gone_at: AtomicInstant,
    /// Calls that failed.
    pub(super) failed: AtomicU64,
    /// The level after the last edge of each input, and the inputs that had an edge since the device last asked.
    pub(super) seen: AtomicU64,
    pub(super) touched: AtomicU64,
    /// Edges are being read, or were and are not handed on yet.
    pub(super) reading: AtomicBool,
    /// Edges that found no room on their way to the board, by input.
    pub(super) edge_overflows: [AtomicU32; 64],
    /// Whether some did.
    pub(super) overflowed: AtomicBool,
    /// Numbers of edges that have not come yet.
    pub(super) open: AtomicU32,
    /// Reports that found no room.
    pub(super) unreported: AtomicU64,
    stop: AtomicBool,
    /// Threads that are at their end.
    ended: AtomicU32,
    /// Wakes the device thread.
    pub(super) device: Bell,
    /// Wakes whoever waits for the device.
    pub(super) answer: Bell,
}

impl SharedChip {
    pub(super) fn new() -> SharedChip {
        SharedChip {
            latched: AtomicBool::new(true),
            made_safe: AtomicU64::new(0),
            wanted_safe: AtomicU64::new(0),
            starts: AtomicU64::new(0),
            taken: AtomicU64::new(0),
            in_call: AtomicInstant::none(),
            gone: AtomicI32::new(0),
            gone_at: AtomicInstant::none(),
            failed: AtomicU64::new(0),
            seen: AtomicU64::new(0),
            touched: AtomicU64::new(0),
            reading: AtomicBool::new(false),
            edge_overflows: [const { AtomicU32::new(0) }; 64],
            overflowed: AtomicBool::new(false),
            open: AtomicU32::new(0),
            unreported: AtomicU64::new(0),
            stop: AtomicBool::new(false),
            ended: AtomicU32::new(0),
            device: Bell::new(),
            answer: Bell::new(),
        }
    }

    /// Whether the threads are to end.
    pub(super) fn stopped(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// A thread has nothing more to do.
    fn end(&self) {
        self.ended.fetch_add(1, Ordering::AcqRel);
        self.answer.ring();
    }

    /// The chip answered with this error: it is gone if that is what the error says. By the threads of the chip alone, which log
    /// it.
    pub(super) fn refused(&self, error: &std::io::Error) {
        tracing::debug!(%error, "a call on the device failed");
        self.failed.fetch_add(1, Ordering::Relaxed);
        let code = error.raw_os_error().unwrap_or(0);
        if crate::gone::is_gone(code, &[]) {
            self.ends(code);
        }
    }

    /// The chip is gone, or cannot be worked with any more.
    pub(super) fn ends(&self, code: i32) {
        tracing::info!(code, "the device is given up");
        self.gone_at.set(HostInstant::now());
        self.gone.store(code, Ordering::Release);
    }

    /// A call ended that began at `since`: one that lasted longer than `limit` counted as one that hangs.
    pub(super) fn log_hung(since: HostInstant, limit: Span) {
        if tracing::enabled!(tracing::Level::DEBUG) && since.elapsed() > limit {
            tracing::debug!(lasted = %since.elapsed(), "a call on the device hung and has ended");
        }
    }

    /// Whether it is.
    pub(super) fn is_gone(&self) -> bool {
        self.gone.load(Ordering::Acquire) != 0
    }
}

/// The board's side of a chip at work. Dropping it ends the threads; outputs are left safe.
#[derive(Debug)]
pub(super) struct ChipWorker {
    pub(super) shared: Arc<SharedChip>,
    pub(super) images: Producer<Image>,
    pub(super) reports: Consumer<ChipReport>,
    pub(super) notes: Consumer<Note>,
    end: Arc<OwnedFd>,
    /// How long the end of a call is waited for.
    patience: Span,
    threads: Vec<std::thread::JoinHandle<()>>,
}

impl ChipWorker {
    /// A chip whose threads are still to be started.
    pub(super) fn new(
        port: Arc<dyn GpioPort>,
        safe: u64,
        pace: PulsePace,
        bell: &Arc<Bell>,
        unresponsive_after: Span,
    ) -> std::io::Result<(ChipWorker, ChipThread, Edges)> {
        let shared = Arc::new(SharedChip::new());
        let (device, images, reports) =
            device(port.clone(), shared.clone(), bell.clone(), safe, pace, unresponsive_after);
        let end = Arc::new(eventfd(0, EventfdFlags::CLOEXEC)?);
        let (edges, notes) = edges(port, shared.clone(), bell.clone(), end.clone());
        let running = ChipWorker {
            shared,
            images,
            reports,
            notes,
            end,
            patience: unresponsive_after,
            threads: Vec::new(),
        };
        Ok((running, device, edges))
    }

    /// Starts its threads. What started before the other failed is ended by dropping.
    pub(super) fn start(
        &mut self,
        name: &str,
        device: ChipThread,
        edges: Edges,
        realtime: Realtime,
    ) -> std::io::Result<()> {
        let named = |role: &str| std::thread::Builder::new().name(format!("{role} {name}"));
        let ended = self.shared.clone();
        let edges = move || {
            edges.run(realtime);
            ended.end();
        };
        self.threads.push(named("edges").spawn(edges)?);
        let ended = self.shared.clone();
        let device = move || {
            device.run(realtime);
            ended.end();
        };
        self.threads.push(named("lines").spawn(device)?);
        Ok(())
    }
}

impl Drop for ChipWorker {
    fn drop(&mut self) {
        self.shared.latched.store(true, Ordering::Release);
        self.shared.stop.store(true, Ordering::Release);
        self.shared.device.ring();
        // A counter takes eight bytes; it cannot be full.
        let _ = rustix::io::write(&*self.end, &1u64.to_ne_bytes());
        let due = HostInstant::now() + self.patience;
        let all = self.threads.len() as u32;
        while self.shared.ended.load(Ordering::Acquire) < all {
            // A thread inside a call that hangs is left to it: when the call ends, the latch is all that it finds.
            if HostInstant::now() >= due {
                return;
            }
            self.shared.answer.wait_until(due);
        }
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// What a port's edges come from.
pub(super) fn sources(port: &dyn GpioPort) -> impl Iterator<Item = BorrowedFd<'_>> {
    (0..).map_while(|number| port.source(number))
}

/// A time to wait, in the kernel's terms.
pub(super) fn timespec(span: Span) -> Timespec {
    let nanos = span.as_nanos().max(0);
    Timespec { tv_sec: nanos / 1_000_000_000, tv_nsec: nanos % 1_000_000_000 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Debug;
    use std::sync::Mutex;
    use tracing::field::{Field, Visit};
    use tracing::span::{Attributes, Id, Record};
    use tracing::{Event, Metadata, Subscriber};

    /// The messages that were logged.
    #[derive(Clone, Default)]
    struct Logged(Arc<Mutex<Vec<String>>>);

    impl Visit for Logged {
        fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
            if field.name() == "message" {
                self.0.lock().unwrap().push(format!("{value:?}"));
            }
        }
    }

    impl Subscriber for Logged {
        fn enabled(&self, _metadata: &Metadata<'_>) -> bool {
            true
        }

        fn new_span(&self, _span: &Attributes<'_>) -> Id {
            Id::from_u64(1)
        }

        fn record(&self, _span: &Id, _values: &Record<'_>) {}

        fn record_follows_from(&self, _span: &Id, _follows: &Id) {}

        fn event(&self, event: &Event<'_>) {
            event.record(&mut self.clone());
        }

        fn enter(&self, _span: &Id) {}

        fn exit(&self, _span: &Id) {}
    }

    #[test]
    fn what_becomes_of_a_chip_is_logged() {
        let logged = Logged::default();
        tracing::subscriber::with_default(logged.clone(), || {
            let shared = SharedChip::new();
            shared.refused(&rustix::io::Errno::BUSY.into());
            shared.refused(&rustix::io::Errno::NODEV.into());
            let now = HostInstant::now();
            SharedChip::log_hung(now, Span::from_secs(60));
            SharedChip::log_hung(now - Span::from_secs(2), Span::from_secs(1));
        });
        let failed = "a call on the device failed";
        let hung = "a call on the device hung and has ended";
        assert_eq!(*logged.0.lock().unwrap(), [failed, failed, "the device is given up", hung]);
    }
}
