//! The thread that reads a converter: the only one whose calls may last.

use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use host::{AtomicInstant, HostInstant, Realtime, Role};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal::Span;

use super::{Adc, Pace, Reading, Resolution, Scale, Shown};
use crate::thread::Reporter;

/// How a converter is opened: at first, and again when it was gone.
pub(super) type Opener = Box<dyn FnMut() -> Option<Box<dyn Adc>> + Send>;

/// What the device found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Report {
    /// An input shows another quantity, or one that is not known: it came between these stamps.
    Sample { input: u16, from: HostInstant, to: HostInstant, shown: Shown },
    /// So many readings of an input were lost, or came too late for what the channel promises.
    Missed { input: u16, count: u32, at: HostInstant },
    /// Every input was read since this start.
    Started { start: u64 },
    /// It was gone and is there again; what its inputs show follows.
    Returned { at: HostInstant },
}

/// What board and thread share.
#[derive(Debug)]
pub(super) struct Shared {
    /// A run goes on: inputs are to be read.
    pub(super) active: AtomicBool,
    /// Number of starts asked for.
    pub(super) starts: AtomicU64,
    /// Since when readings are owed.
    pub(super) owes: AtomicInstant,
    /// The noise of each input in its last reading, in the unit of its channel: bits of a number, which is none while
    /// there is no reading of several samples.
    pub(super) noise: Vec<AtomicU64>,
    /// Wakes the thread: it can be waited for beside the device.
    pub(super) wake: OwnedFd,
}

impl Shared {
    /// Wakes the thread.
    pub(super) fn wake(&self) {
        // A counter takes eight bytes; it cannot be full.
        let _ = rustix::io::write(&self.wake, &1u64.to_ne_bytes());
    }
}

/// An input and what is known of it.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) scale: Scale,
    /// What was reported last; `None` before the first.
    told: Option<Shown>,
    /// When its last reading began.
    last: Option<HostInstant>,
}

impl Known {
    pub(super) fn new(scale: Scale) -> Known {
        Known { scale, told: None, last: None }
    }
}

/// The thread's side of a converter.
pub(super) struct Device {
    pub(super) converter: Option<Box<dyn Adc>>,
    pub(super) opener: Opener,
    pub(super) shared: Arc<Shared>,
    pub(super) reporter: Reporter<Report>,
    pub(super) inputs: Vec<Known>,
    /// The readings of one call.
    pub(super) found: Vec<Reading>,
    /// The longest time between two readings of an input that its channel allows for.
    pub(super) apart: Span,
    /// A device that was gone is opened again.
    pub(super) reconnect: bool,
    pub(super) started: u64,
    /// Whether the start has been answered.
    pub(super) complete: bool,
    /// When the next reading is due.
    pub(super) due: HostInstant,
    /// Readings that the device lost, as it reported last.
    pub(super) lost: u64,
}

impl Device {
    /// The thread.
    pub(super) fn run(mut self, realtime: Realtime) {
        // A refusal is reported once for all threads, by whoever set up the run.
        let _ = realtime.enter(Role::Devices);
        while !self.reporter.is_stopped() {
            let until = self.turn();
            self.reporter.ring();
            self.wait(until);
        }
        drop(self.converter.take());
        self.reporter.end();
    }

    /// One look at what is asked, and at most one call. Says until when there is nothing to do.
    fn turn(&mut self) -> HostInstant {
        let starts = self.shared.starts.load(Ordering::Acquire);
        if starts != self.started {
            self.begin(starts);
        }
        if !self.shared.active.load(Ordering::Acquire) {
            self.shared.owes.clear();
            return HostInstant::NEVER;
        }
        let now = HostInstant::now();
        if now >= self.due {
            match self.converter.is_some() {
                true => self.read(now),
                false => self.look_again(now),
            }
        } else if let Some(Pace::Ready(..)) = self.converter.as_ref().map(|converter| converter.pace()) {
            self.read(now);
        }
        self.due
    }

    /// A new run: what was known is forgotten.
    fn begin(&mut self, start: u64) {
        (self.started, self.complete) = (start, false);
        self.reporter.works();
        self.forget();
        // What waits in the device is from before.
        if let Some(Err(error)) = self.converter.as_mut().map(|converter| converter.begin()) {
            self.refused(&error);
        }
        self.lost = self.converter.as_ref().map_or(0, |converter| converter.lost());
        self.due = HostInstant::now();
    }

    fn forget(&mut self) {
        for known in &mut self.inputs {
            (known.told, known.last) = (None, None);
        }
    }

    /// Asks the device. What it says lies in `found`.
    fn call(&mut self, now: HostInstant) -> bool {
        self.found.clear();
        let Some(converter) = &mut self.converter else { return false };
        if self.shared.owes.get().is_none() {
            self.shared.owes.set(now);
        }
        match converter.read(&mut self.found) {
            Err(error) if error.kind() != std::io::ErrorKind::WouldBlock => {
                self.refused(&error);
                false
            }
            _ => {
                self.reporter.works();
                true
            }
        }
    }

    fn read(&mut self, now: HostInstant) {
        let answered = self.call(now);
        let after = HostInstant::now();
        let Some(converter) = &self.converter else { return };
        let (period, owes) = match converter.pace() {
            Pace::Asked(period) => (period, None),
            // The next readings are owed from now on.
            Pace::Ready(_, period) if self.found.is_empty() => (period, self.shared.owes.get()),
            Pace::Ready(_, period) => (period, Some(after + period)),
        };
        let lost = converter.lost();
        self.shared.owes.set(owes);
        // As often as asked for on the whole; what was slept through is not made up for.
        self.due += period;
        if self.due <= after {
            self.due = after + period;
        }
        if answered {
            self.take();
        }
        if lost > self.lost {
            let count = u32::try_from(lost - self.lost).unwrap_or(u32::MAX);
            (0..self.inputs.len()).for_each(|input| self.missed(input, count, after));
            self.lost = lost;
        }
        if !self.complete && self.inputs.iter().all(|known| known.told.is_some()) {
            self.complete = true;
            self.reporter.insist(Report::Started { start: self.started });
        }
    }

    /// What the readings tell.
    fn take(&mut self) {
        for at in 0..self.found.len() {
            let reading = self.found[at];
            let input = usize::from(reading.input);
            let Some(known) = self.inputs.get_mut(input) else { continue };
            let from = known.last.unwrap_or(reading.before).min(reading.after);
            known.last = Some(reading.before);
            let (resolution, noise) = match &self.converter {
                Some(converter) => (converter.resolution(reading.input), converter.noise(reading.input)),
                None => (Resolution::default(), None),
            };
            let shown = known.scale.quantity(&reading, resolution, noise);
            let news = known.told.is_none_or(|told| known.scale.differs(told, shown));
            if let (Some(noise), Some(shared)) = (noise, self.shared.noise.get(input)) {
                shared.store(known.scale.noise(reading.value, noise).to_bits(), Ordering::Release);
            }
            let apart = reading.after - from;
            if apart > self.apart {
                let count = apart.as_nanos() / self.apart.as_nanos().max(1);
                self.missed(input, u32::try_from(count).unwrap_or(u32::MAX), reading.after);
            }
            let sample = Report::Sample { input: reading.input, from, to: reading.after, shown };
            if news && self.reporter.report(sample) {
                self.inputs[input].told = Some(shown);
            }
        }
    }

    fn missed(&mut self, input: usize, count: u32, at: HostInstant) {
        self.reporter.report(Report::Missed { input: input as u16, count, at });
    }

    fn refused(&mut self, error: &std::io::Error) {
        if self.reporter.refused(error) {
            self.converter = None;
            self.shared.owes.clear();
            self.due = HostInstant::now() + self.reporter.limit();
        }
    }

    /// Whether a device that was gone is there again.
    fn look_again(&mut self, now: HostInstant) {
        self.due = if self.reconnect { now + self.reporter.limit() } else { HostInstant::NEVER };
        if !self.reconnect {
            return;
        }
        self.converter = (self.opener)();
        if let Some(converter) = &self.converter {
            self.lost = converter.lost();
            self.forget();
            self.reporter.returned(Report::Returned { at: HostInstant::now() });
            self.due = HostInstant::now();
        }
    }

    /// Until somebody wakes the thread, until the device has something, or until then.
    fn wait(&self, until: HostInstant) {
        let left = until.remaining().as_nanos();
        if left == 0 {
            return;
        }
        let timeout = Timespec { tv_sec: left / 1_000_000_000, tv_nsec: left % 1_000_000_000 };
        let active = self.shared.active.load(Ordering::Acquire);
        let converter = self.converter.as_ref().filter(|_| active);
        let wake = PollFd::new(&self.shared.wake, PollFlags::IN);
        // An interrupted wait is one that ended early.
        let _ = match converter.map(|converter| converter.pace()) {
            Some(Pace::Ready(ready, _)) => {
                poll(&mut [wake, PollFd::from_borrowed_fd(ready, PollFlags::IN)], Some(&timeout))
            }
            _ => poll(&mut [wake], Some(&timeout)),
        };
        // Nothing to be read is no failure.
        let _ = rustix::io::read(&self.shared.wake, &mut [0u8; 8]);
    }
}
