//! Waits on a current-thread runtime that end at an instant of the host: tokio's own end at whole milliseconds,
//! which is longer than the silences of a serial line.

use std::io;
use std::os::fd::OwnedFd;
use std::task::{Context, Poll, ready};

use host::HostInstant;
use rustix::time::{Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, Timespec};
use rustix::time::{timerfd_create, timerfd_settime};
use tokio::io::unix::AsyncFd;

/// A timer of the kernel.
#[derive(Debug)]
pub(super) struct Timer {
    timer: AsyncFd<OwnedFd>,
}

impl Timer {
    /// A timer that is not set. Panics outside of a runtime with input and output.
    pub(super) fn new() -> io::Result<Timer> {
        let timer =
            timerfd_create(TimerfdClockId::Monotonic, TimerfdFlags::CLOEXEC | TimerfdFlags::NONBLOCK)?;
        // What its unsafe heir asks for is what an owned descriptor always gives: it stays open, and the same.
        #[allow(deprecated)]
        let timer = AsyncFd::new(timer)?;
        Ok(Timer { timer })
    }

    /// Lets it end at this instant; what it was set to before is forgotten.
    pub(super) fn set(&self, due: HostInstant) -> io::Result<()> {
        // 0 would mean never.
        let stamp = due.as_nanos().max(1);
        let at = Timespec { tv_sec: stamp / 1_000_000_000, tv_nsec: stamp % 1_000_000_000 };
        let once = Itimerspec { it_interval: Timespec { tv_sec: 0, tv_nsec: 0 }, it_value: at };
        timerfd_settime(&self.timer, TimerfdTimerFlags::ABSTIME, &once)?;
        Ok(())
    }

    /// Whether it has ended since it was set.
    pub(super) fn poll(&self, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        loop {
            let mut ready = ready!(self.timer.poll_read_ready(cx))?;
            let ended = ready.try_io(|timer| {
                let mut times = [0; 8];
                Ok(rustix::io::read(timer, &mut times)?)
            });
            match ended {
                Ok(outcome) => return Poll::Ready(outcome.map(drop)),
                Err(_not_yet) => {}
            }
        }
    }

    /// Waits until then.
    pub(super) async fn wait_until(&self, due: HostInstant) -> io::Result<()> {
        self.set(due)?;
        std::future::poll_fn(|cx| self.poll(cx)).await
    }
}
