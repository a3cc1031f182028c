//! The thread that reads a converter: the only one whose calls may last.

use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use host::{HostInstant, Realtime, ThreadRole};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal::Span;

use super::{Adc, AdcPace, AdcReading, Resolution, Scale, Shown};
use crate::sampled::{SampleTurn, Sampler};

/// What the device found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum AdcReport {
    /// An input shows another quantity, or one that is not known: it came between these stamps.
    Sample { input: u16, from: HostInstant, to: HostInstant, shown: Shown },
    /// So many readings of an input were lost, or came too late for what the channel promises.
    Missed { input: u16, count: u32, at: HostInstant },
    /// Every input was read since this start.
    Started { start: u64 },
    /// It was gone and is there again; what its inputs show follows.
    Returned { at: HostInstant },
}

/// What board and thread share beside the control of its runs.
#[derive(Debug)]
pub(super) struct SharedAdc {
    /// The noise of each input in its last reading, in the unit of its channel: bits of a number, which is none while
    /// there is no reading of several samples.
    pub(super) noise: Vec<AtomicU64>,
    /// Wakes the thread: it can be waited for beside the device.
    pub(super) wake: OwnedFd,
}

impl SharedAdc {
    /// Wakes the thread.
    pub(super) fn wake(&self) {
        // A counter takes eight bytes; it cannot be full.
        let _ = rustix::io::write(&self.wake, &1u64.to_ne_bytes());
    }
}

/// An input and what is known of it.
#[derive(Debug)]
pub(super) struct KnownInput {
    pub(super) scale: Scale,
    /// What was reported last; `None` before the first.
    reported: Option<Shown>,
    /// When its last reading began.
    last: Option<HostInstant>,
}

impl KnownInput {
    pub(super) fn new(scale: Scale) -> KnownInput {
        KnownInput { scale, reported: None, last: None }
    }
}

/// The thread's side of a converter.
pub(super) struct AdcThread {
    pub(super) sampler: Sampler<dyn Adc, AdcReport>,
    pub(super) shared: Arc<SharedAdc>,
    pub(super) inputs: Vec<KnownInput>,
    /// The readings of one call.
    pub(super) found: Vec<AdcReading>,
    /// The longest time between two readings of an input that its channel allows for.
    pub(super) apart: Span,
    /// Readings that the device lost, as it reported last.
    pub(super) lost: u64,
}

impl AdcThread {
    /// The thread.
    pub(super) fn run(mut self, realtime: Realtime) {
        // A refusal is reported once for all threads, by whoever set up the run.
        let _ = realtime.enter(ThreadRole::Devices);
        while !self.sampler.reporter.is_stopped() {
            let until = self.turn();
            self.sampler.reporter.ring();
            self.wait(until);
        }
        drop(self.sampler.device.take());
        self.sampler.reporter.end();
    }

    /// One look at what is asked, and at most one call. Returns until when there is nothing to do.
    fn turn(&mut self) -> HostInstant {
        if self.sampler.starts() {
            self.begin();
        }
        let now = HostInstant::now();
        let turn = self.sampler.turn(now);
        match turn {
            SampleTurn::Read => self.read(now),
            SampleTurn::Wait
                if self.sampler.device.as_ref().is_some_and(|one| one.pace().comes_by_itself()) =>
            {
                self.read(now);
            }
            SampleTurn::Reopen => self.reopen(now),
            SampleTurn::Wait | SampleTurn::Rest => {}
        }
        self.sampler.waits_until(turn)
    }

    /// A new run: what was known is forgotten.
    fn begin(&mut self) {
        self.forget();
        // What waits in the device is from before.
        if let Some(Err(error)) = self.sampler.device.as_mut().map(|converter| converter.begin()) {
            self.sampler.refused(&error);
        }
        self.lost = self.sampler.device.as_ref().map_or(0, |converter| converter.lost());
        self.sampler.read_at_once();
    }

    fn forget(&mut self) {
        for known in &mut self.inputs {
            (known.reported, known.last) = (None, None);
        }
    }

    /// Asks the device. What it answers lies in `found`.
    fn call(&mut self, now: HostInstant) -> bool {
        self.found.clear();
        let Some(converter) = &mut self.sampler.device else { return false };
        if self.sampler.control.waits_since.get().is_none() {
            self.sampler.control.waits_since.set(now);
        }
        match converter.read(&mut self.found) {
            Err(error) if error.kind() != std::io::ErrorKind::WouldBlock => {
                self.sampler.refused(&error);
                false
            }
            _ => {
                self.sampler.reporter.works();
                true
            }
        }
    }

    fn read(&mut self, now: HostInstant) {
        let answered = self.call(now);
        let after = HostInstant::now();
        let Some(converter) = &self.sampler.device else { return };
        let control = &self.sampler.control;
        let (period, waits_since) = match converter.pace() {
            AdcPace::Asked(period) => (period, None),
            // The next readings are awaited from now on.
            AdcPace::Ready(_, period) if self.found.is_empty() => (period, control.waits_since.get()),
            AdcPace::Ready(_, period) => (period, Some(after + period)),
        };
        let lost = converter.lost();
        control.waits_since.set(waits_since);
        self.sampler.was_read(period, after);
        if answered {
            self.take();
        }
        if lost > self.lost {
            let count = u32::try_from(lost - self.lost).unwrap_or(u32::MAX);
            (0..self.inputs.len()).for_each(|input| self.missed(input, count, after));
            self.lost = lost;
        }
        if self.inputs.iter().all(|known| known.reported.is_some()) {
            self.sampler.answer_start(|start| AdcReport::Started { start });
        }
    }

    /// Reports what the readings show.
    fn take(&mut self) {
        for at in 0..self.found.len() {
            let reading = self.found[at];
            let input = usize::from(reading.input);
            let Some(known) = self.inputs.get_mut(input) else { continue };
            let from = known.last.unwrap_or(reading.before).min(reading.after);
            known.last = Some(reading.before);
            let (resolution, noise) = match &self.sampler.device {
                Some(converter) => (converter.resolution(reading.input), converter.noise(reading.input)),
                None => (Resolution::default(), None),
            };
            let shown = known.scale.quantity(&reading, resolution, noise);
            let news = known.reported.is_none_or(|last| known.scale.differs(last, shown));
            if let (Some(noise), Some(shared)) = (noise, self.shared.noise.get(input)) {
                shared.store(known.scale.noise(reading.value, noise).to_bits(), Ordering::Release);
            }
            let apart = reading.after - from;
            if apart > self.apart {
                let count = apart.as_nanos() / self.apart.as_nanos().max(1);
                self.missed(input, u32::try_from(count).unwrap_or(u32::MAX), reading.after);
            }
            let sample = AdcReport::Sample { input: reading.input, from, to: reading.after, shown };
            if news && self.sampler.reporter.report(sample) {
                self.inputs[input].reported = Some(shown);
            }
        }
    }

    fn missed(&mut self, input: usize, count: u32, at: HostInstant) {
        self.sampler.reporter.report(AdcReport::Missed { input: input as u16, count, at });
    }

    /// Whether a device that was gone is there again.
    fn reopen(&mut self, now: HostInstant) {
        if !self.sampler.reopen(now) {
            return;
        }
        self.lost = self.sampler.device.as_ref().map_or(0, |converter| converter.lost());
        self.forget();
        self.sampler.reporter.returned(AdcReport::Returned { at: HostInstant::now() });
    }

    /// Until somebody wakes the thread, until the device has something, or until then.
    fn wait(&self, until: HostInstant) {
        let left = until.remaining().as_nanos();
        if left == 0 {
            return;
        }
        let timeout = Timespec { tv_sec: left / 1_000_000_000, tv_nsec: left % 1_000_000_000 };
        let active = self.sampler.control.is_active();
        let converter = self.sampler.device.as_ref().filter(|_| active);
        let wake = PollFd::new(&self.shared.wake, PollFlags::IN);
        // An interrupted wait is one that ended early.
        let _ = match converter.map(|converter| converter.pace()) {
            Some(AdcPace::Ready(ready, _)) => {
                poll(&mut [wake, PollFd::from_borrowed_fd(ready, PollFlags::IN)], Some(&timeout))
            }
            _ => poll(&mut [wake], Some(&timeout)),
        };
        // Nothing to be read is no failure.
        let _ = rustix::io::read(&self.shared.wake, &mut [0u8; 8]);
    }
}
