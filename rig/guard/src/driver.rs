//! One thread for each claim on lines: a call that hangs on one device keeps no other from being made safe.

use crate::lines::OutputLines;
use host::{AtomicInstant, Bell, HostInstant};
use rustix::io::{Errno, write};
use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, Ordering};
use std::thread::{Builder, JoinHandle};

/// Stack of a thread that makes two calls; it is locked in memory.
const STACK: usize = 128 * 1024;

/// The outcome of driving lines that read back another level than they were driven to.
const OTHERWISE: i32 = -1;

/// What a claim's thread and the guard share.
#[derive(Debug)]
struct Shared {
    bell: Bell,
    /// Orders given and orders carried out; equal while the thread has nothing to do.
    wanted: AtomicU32,
    served: AtomicU32,
    /// When the last order that was carried out began, and what became of it: 0, [`OTHERWISE`] or an error number.
    began: AtomicInstant,
    outcome: AtomicI32,
    over: AtomicBool,
    /// Signalled each time that an order was carried out.
    finished: Arc<OwnedFd>,
}

/// A claim on lines with its thread.
#[derive(Debug)]
pub(crate) struct Driver {
    /// The device, as messages name it.
    pub device: String,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Driver {
    /// Takes charge of lines whose safe levels are `safe`, and drives nothing yet.
    pub fn start(
        device: String,
        mut lines: Box<dyn OutputLines>,
        safe: u64,
        finished: &Arc<OwnedFd>,
    ) -> io::Result<Driver> {
        let shared = Arc::new(Shared {
            bell: Bell::new(),
            wanted: AtomicU32::new(0),
            served: AtomicU32::new(0),
            began: AtomicInstant::none(),
            outcome: AtomicI32::new(0),
            over: AtomicBool::new(false),
            finished: finished.clone(),
        });
        let own = shared.clone();
        let thread = Builder::new().name("lines".into()).stack_size(STACK).spawn(move || {
            while !own.over.load(Ordering::Acquire) {
                own.bell.wait_until(HostInstant::NEVER);
                own.carry_out(&mut *lines, safe);
            }
        })?;
        Ok(Driver { device, shared, thread: Some(thread) })
    }

    /// Orders the lines to be driven safe and read back: at once, and once more if the thread is at it now.
    pub fn order(&self) {
        self.shared.wanted.fetch_add(1, Ordering::AcqRel);
        self.shared.bell.ring();
    }

    /// Whether all orders were carried out.
    pub fn is_idle(&self) -> bool {
        self.shared.served.load(Ordering::Acquire) == self.shared.wanted.load(Ordering::Acquire)
    }

    /// Whether the lines were found safe by an order that began at `since` or later.
    pub fn is_safe(&self, since: HostInstant) -> bool {
        self.shared.began.get() >= Some(since) && self.shared.outcome.load(Ordering::Acquire) == 0
    }

    /// Whether the device was found to be gone by an order that began at `since` or later.
    pub fn is_gone(&self, since: HostInstant) -> bool {
        let gone = [Errno::NODEV, Errno::NXIO].map(Errno::raw_os_error);
        self.shared.began.get() >= Some(since) && gone.contains(&self.shared.outcome.load(Ordering::Acquire))
    }

    /// Why the lines are not known to be safe since then.
    pub fn trouble(&self, since: HostInstant) -> Option<Trouble> {
        if self.shared.began.get() < Some(since) {
            return Some(Trouble::Hangs);
        }
        match self.shared.outcome.load(Ordering::Acquire) {
            0 => None,
            OTHERWISE => Some(Trouble::ReadsOtherwise),
            number => Some(Trouble::Refused(number)),
        }
    }

    /// Lets go of the lines. Only of an idle one can be said when.
    pub fn let_go(mut self) {
        let idle = self.is_idle();
        self.shared.over.store(true, Ordering::Release);
        self.shared.bell.ring();
        if let Some(thread) = self.thread.take().filter(|_| idle) {
            // A thread that panicked let go, too.
            let _ = thread.join();
        }
    }
}

/// Why lines are not known to be safe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    /// The call has not come back.
    Hangs,
    /// The device says that the lines have other levels.
    ReadsOtherwise,
    /// The call failed with this error number.
    Refused(i32),
}

impl std::fmt::Display for Trouble {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Trouble::Hangs => f.write_str("the call that drives its lines does not come back"),
            Trouble::ReadsOtherwise => f.write_str("its lines read other levels than they are driven to"),
            Trouble::Refused(number) => {
                write!(f, "driving its lines failed: {}", io::Error::from_raw_os_error(*number))
            }
        }
    }
}

impl Shared {
    /// Drives until every order given is carried out.
    fn carry_out(&self, lines: &mut dyn OutputLines, safe: u64) {
        loop {
            let wanted = self.wanted.load(Ordering::Acquire);
            if wanted == self.served.load(Ordering::Acquire) {
                return;
            }
            let began = HostInstant::now();
            let outcome = match lines.drive(safe).and_then(|()| lines.read()) {
                Ok(read) if read == safe => 0,
                Ok(_) => OTHERWISE,
                Err(error) => error.raw_os_error().filter(|number| *number > 0).unwrap_or(i32::MAX),
            };
            // The outcome before its time: who sees the time sees an outcome at least as new.
            self.outcome.store(outcome, Ordering::Release);
            self.began.set(began);
            self.served.store(wanted, Ordering::Release);
            // A full counter has somebody to wake already.
            let _ = write(&*self.finished, &1u64.to_ne_bytes());
        }
    }
}
