//! The thread that talks to a CAN interface: the only one whose calls may last.

use signal::{CanFrame, Span};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::{Bracket, Errno, HostInstant, Realtime, ReceivedDatagram, ThreadRole};
use rtrb::Consumer;
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::adapter::{Adapter, Change};
use super::arrivals::{Arrivals, BATCH};
use super::port::CanPort;
use super::report::Reported;
use super::shared::{CanReport, REPORTS, SharedCan, ThreadConfig};
use super::wire::{Datagram, FD, decode, encode};
use crate::thread::Reporter;
use crate::{BusError, BusState};

/// How long the kernel's full queue is left alone, and how long the thread is without a look at the clocks.
const AGAIN: Span = Span::from_millis(1);
const IDLE: Span = Span::from_millis(100);

/// The thread's side.
pub(super) struct CanThread {
    adapter: Box<dyn Adapter>,
    port: Option<Box<dyn CanPort>>,
    shared: Arc<SharedCan>,
    frames: Consumer<CanFrame>,
    reporter: Reporter<CanReport>,
    /// How long before its stamp a frame may have ended.
    resolution: Span,
    /// An interface that went away is opened again.
    reconnect: bool,
    started: u64,
    state: BusState,
    /// When it left the bus, or the rig tried in vain to bring it back.
    off_since: Option<HostInstant>,
    /// The kernel lets frames pass.
    running: bool,
    /// From the wall clock to the monotonic one, as measured last.
    clocks: Bracket,
    /// Frames that the socket has lost since it was opened.
    dropped: u32,
    /// The frame that the kernel did not take yet.
    pending: Option<CanFrame>,
    /// Own frames that the kernel has and the bus had not, and since when none of them came.
    waiting: u32,
    since: HostInstant,
    late: bool,
    arrivals: Arrivals,
    /// The newest instant that was reported.
    newest: HostInstant,
}

impl CanThread {
    /// Of an open interface, with its ends of both ways.
    pub(super) fn new(
        adapter: Box<dyn Adapter>,
        port: Box<dyn CanPort>,
        shared: Arc<SharedCan>,
        frames: Consumer<CanFrame>,
        reporter: Reporter<CanReport>,
        config: ThreadConfig,
    ) -> CanThread {
        CanThread {
            adapter,
            port: Some(port),
            shared,
            frames,
            reporter,
            resolution: config.resolution,
            reconnect: config.reconnect,
            started: 0,
            state: BusState::ErrorActive,
            off_since: None,
            running: true,
            clocks: Bracket::measure(),
            dropped: 0,
            pending: None,
            waiting: 0,
            since: HostInstant::BOOT,
            late: false,
            arrivals: Arrivals::new(),
            newest: HostInstant::BOOT,
        }
    }

    /// The thread.
    pub(super) fn run(mut self, realtime: Realtime) {
        // A refusal is reported once for all threads, by whoever set up the run.
        let _ = realtime.enter(ThreadRole::Devices);
        loop {
            // What is asked before the stop is seen after it.
            let stop = self.reporter.is_stopped();
            self.turn();
            if stop {
                self.called();
                self.adapter.put_back();
                self.reporter.end();
                return;
            }
            self.wait();
        }
    }

    fn turn(&mut self) {
        let asked = self.shared.asked.load(Ordering::Acquire);
        let starts = self.shared.starts.load(Ordering::Acquire);
        self.look();
        if starts != self.started {
            self.start(starts);
        }
        self.receive();
        self.restart();
        self.send();
        self.overdue();
        self.shared.in_call.clear();
        if self.shared.heard.swap(asked, Ordering::AcqRel) != asked {
            self.reporter.answer();
        }
        self.reporter.ring();
    }

    /// Waits until there is something to do.
    fn wait(&mut self) {
        let soon = self.pending.is_some() || self.reporter.keeps_report();
        let mut left = if soon { AGAIN } else { IDLE.min(self.reporter.limit()) };
        if let Some(due) = self.restarts_at() {
            left = left.min(due.remaining());
        }
        let due = Timespec { tv_sec: 0, tv_nsec: left.as_nanos() };
        let wake = || PollFd::new(&self.shared.wake, PollFlags::IN);
        let source = self.port.as_ref().map(|port| port.source());
        let mut all = [
            wake(),
            self.adapter.source().map_or_else(wake, |fd| PollFd::from_borrowed_fd(fd, PollFlags::IN)),
            source.map_or_else(wake, |fd| PollFd::from_borrowed_fd(fd, PollFlags::IN)),
        ];
        // A wait that was cut short is followed by a turn that finds nothing.
        let _ = poll(&mut all, Some(&due));
        if all[0].revents().contains(PollFlags::IN) {
            let _ = rustix::io::read(&self.shared.wake, &mut [0; 8]);
        }
    }

    /// What became of the interface.
    fn look(&mut self) {
        self.called();
        match self.adapter.change() {
            Change::None => {}
            Change::Down => self.lose(),
            Change::Up { running } => {
                self.running = running;
                self.back();
            }
            Change::Flapped => {
                self.lose();
                self.back();
            }
        }
    }

    /// It is there again.
    fn back(&mut self) {
        if self.port.is_none() && self.reconnect {
            self.open();
        }
    }

    /// A call begins.
    fn called(&self) {
        self.shared.in_call.set(HostInstant::now());
    }

    fn open(&mut self) {
        if let Ok((port, state)) = self.adapter.open() {
            self.port = Some(port);
            (self.dropped, self.waiting, self.pending, self.running) = (0, 0, None, true);
            let at = HostInstant::now();
            self.reporter.returned(CanReport::Returned { at });
            self.is(at, state);
        }
    }

    fn lose(&mut self) {
        let Some(mut port) = self.port.take() else { return };
        // What came before is reported before. The socket reports the loss first.
        let (mut bytes, mut refused) = ([0; FD], 0);
        while refused < 2 {
            match port.receive(&mut bytes) {
                Ok(received) => self.take(&bytes, received, self.clocks),
                Err(_) => refused += 1,
            }
        }
        (self.waiting, self.pending) = (0, None);
        self.reporter.mark_gone(Errno::NETDOWN.raw_os_error());
    }

    /// What a run begins with: nothing from before.
    fn start(&mut self, start: u64) {
        self.started = start;
        while self.frames.pop().is_ok() {}
        self.pending = None;
        self.back();
        self.called();
        let mut bytes = [0; FD];
        let state = self.adapter.state();
        if let Some(port) = &mut self.port {
            // The queue is that of a second at most; what comes meanwhile belongs to the run.
            for _ in 0..REPORTS {
                match port.receive(&mut bytes) {
                    Ok(received) => {
                        self.dropped = received.dropped;
                        self.waiting = self.waiting.saturating_sub(u32::from(received.own));
                    }
                    Err(_) => break,
                }
            }
            self.state = state.unwrap_or(self.state);
            self.off();
        }
        // What the kernel has had since before this run it still has: nobody could tell it from what the run sends.
        (self.clocks, self.late) = (Bracket::measure(), false);
        // The board makes room while it waits.
        self.reporter.insist(CanReport::Started { start, state: self.state, waiting: self.waiting > 0 });
    }

    fn receive(&mut self) {
        let before = self.clocks;
        self.clocks = Bracket::measure();
        let clocks = before.or(self.clocks);
        let mut refused = None;
        let mut bytes = [0; FD];
        for _ in 0..BATCH {
            self.called();
            let Some(port) = &mut self.port else { break };
            match port.receive(&mut bytes) {
                Ok(received) => self.arrivals.put((bytes, received)),
                Err(Errno::AGAIN) => break,
                Err(Errno::INTR) => {}
                Err(error) => {
                    refused = Some(error);
                    break;
                }
            }
        }
        for at in 0..BATCH {
            let Some((bytes, received)) = self.arrivals.get(at) else { break };
            self.take(&bytes, received, clocks);
        }
        self.arrivals.clear();
        if let Some(error) = refused {
            self.refused(error);
        }
    }

    /// One datagram.
    fn take(&mut self, bytes: &[u8; FD], received: ReceivedDatagram, clocks: Bracket) {
        let now = HostInstant::now();
        let (mut earliest, mut latest) = (now, now);
        if let Some(wall) = received.wall {
            // Clocks are known a little better or worse from time to time; frames stay in order.
            let (low, high) = clocks.instants(wall);
            latest = high.max(self.newest).min(now);
            earliest = (low - self.resolution).min(latest);
        }
        self.newest = latest;
        let lost = received.dropped.wrapping_sub(self.dropped);
        if lost > 0 {
            self.dropped = received.dropped;
            // Which frames they were nobody knows: own ones among them will not be reported.
            self.waiting = 0;
            self.report(CanReport::Dropped { at: latest, count: lost });
        }
        match bytes.get(..received.len).and_then(decode) {
            Some(Datagram::Frame(frame)) => {
                if received.own {
                    (self.waiting, self.since, self.late) = (self.waiting.saturating_sub(1), now, false);
                }
                self.report(CanReport::Frame { earliest, latest, frame, own: received.own });
            }
            Some(Datagram::Report(classes, details)) => {
                let reported = Reported::read(classes, &details);
                for error in reported.errors() {
                    self.report(CanReport::Error { at: latest, error });
                    if error == BusError::ReceiveOverflow {
                        self.report(CanReport::Dropped { at: latest, count: 1 });
                    }
                }
                if let Some(state) = reported.state {
                    self.is(latest, state);
                }
            }
            // Nothing that this kernel is known to write: it counts as lost.
            None => self.report(CanReport::Dropped { at: latest, count: 1 }),
        }
    }

    /// How the controller takes part.
    fn is(&mut self, at: HostInstant, state: BusState) {
        if state == BusState::BusOff {
            // The controller forgets what it had.
            self.waiting = 0;
        }
        if state != self.state {
            self.state = state;
            self.off();
            self.report(CanReport::State { at, state });
        }
    }

    /// Notes since when the controller is off the bus, if it is.
    fn off(&mut self) {
        self.off_since = Some(HostInstant::now()).filter(|_| self.state == BusState::BusOff);
    }

    /// When the rig starts the controller again, if it is to.
    fn restarts_at(&self) -> Option<HostInstant> {
        let (since, after) = (self.off_since?, self.adapter.restarts_after()?);
        self.port.as_ref().map(|_| since + after)
    }

    /// Starts a controller again that has been off the bus for so long.
    fn restart(&mut self) {
        if self.restarts_at().is_none_or(|due| HostInstant::now() < due) {
            return;
        }
        self.called();
        if self.adapter.restart().is_err() {
            self.reporter.failed();
        }
        // It reports that it is back, else it is tried again.
        self.off_since = Some(HostInstant::now());
    }

    fn send(&mut self) {
        if self.shared.latched.load(Ordering::Acquire) {
            while self.frames.pop().is_ok() {}
            self.pending = None;
            return;
        }
        // The kernel would drop frames of a controller that is off the bus without a word, and for a moment after it.
        if self.state == BusState::BusOff || !self.running {
            return;
        }
        for _ in 0..BATCH {
            let Some(frame) = self.pending.take().or_else(|| self.frames.pop().ok()) else { return };
            self.called();
            let Some((bytes, len)) = encode(&frame) else { continue };
            let Some(port) = &mut self.port else {
                self.reporter.failed();
                continue;
            };
            match port.send(&bytes[..len]) {
                Ok(()) => {
                    if self.waiting == 0 {
                        self.since = HostInstant::now();
                    }
                    self.waiting += 1;
                }
                Err(Errno::NOBUFS | Errno::AGAIN | Errno::INTR) => {
                    self.pending = Some(frame);
                    return;
                }
                Err(error) => return self.refused(error),
            }
        }
        // There may be more: the next turn comes at once.
        if !self.frames.is_empty() {
            let _ = rustix::io::write(&self.shared.wake, &1u64.to_ne_bytes());
        }
    }

    /// Frames that wait for the bus for too long.
    fn overdue(&mut self) {
        if self.waiting > 0 && !self.late && HostInstant::now() - self.since > self.reporter.limit() {
            self.late = true;
            self.report(CanReport::Error { at: HostInstant::now(), error: BusError::SendTimeout });
        }
    }

    fn refused(&mut self, error: Errno) {
        if crate::gone::is_gone(error.raw_os_error(), &[Errno::NETDOWN]) {
            self.lose();
        } else {
            self.reporter.failed();
        }
    }

    fn report(&mut self, report: CanReport) {
        // What finds no room is counted.
        let _ = self.reporter.report(report);
    }
}
