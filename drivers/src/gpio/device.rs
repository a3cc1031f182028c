//! The thread that drives and reads a chip: the only one whose calls may last.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::{Bell, HostInstant, Realtime, ThreadRole};
use rtrb::{Consumer, Producer};
use rustix::event::{PollFd, PollFlags, poll};
use signal::Span;

use super::chip::{SharedChip, sources, timespec};
use super::pace::PulsePace;
use super::port::{GpioPort, LineLevels};

/// Images on their way to the device, and its reports on their way back.
const TURNS: usize = 1_024;

/// What the outputs are to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Image {
    pub(super) bits: u64,
    /// When that was asked for.
    pub(super) asked: HostInstant,
}

/// What the device did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChipReport {
    /// It was driven: between these stamps all outputs took these levels.
    Set { before: HostInstant, after: HostInstant, bits: u64 },
    /// Changes of an output that were asked for and taken back before the device came to them.
    Swallowed { output: u8, count: u32, at: HostInstant },
    /// An input has had this level for a while, and no edge reported it.
    Strayed { input: u8, high: bool, at: HostInstant },
    /// It was driven safe and all its inputs were read, for this start.
    Started { start: u64, before: HostInstant, after: HostInstant, bits: u64, levels: LineLevels },
}

/// The device thread's side of a chip: drives the newest image and reads the levels.
#[derive(Debug)]
pub(super) struct ChipThread {
    port: Arc<dyn GpioPort>,
    shared: Arc<SharedChip>,
    images: Consumer<Image>,
    reports: Producer<ChipReport>,
    /// Is rung when there is something to report.
    bell: Arc<Bell>,
    safe: u64,
    /// What the outputs were driven to last; `None` where that is not known.
    driven: Option<u64>,
    /// The newest image that was asked for and may be driven.
    asked: u64,
    /// Keeps pulses apart.
    pace: PulsePace,
    started: u64,
    /// How long it may be left alone, and how long an edge may take to arrive.
    idle: Span,
    /// The level of each input, by edges.
    levels: u64,
    /// Inputs that read otherwise, each since when.
    astray: u64,
    since: [HostInstant; 64],
    /// There is something that the bell was not rung for.
    unrung: bool,
}

impl ChipThread {
    /// The thread.
    pub(super) fn run(mut self, realtime: Realtime) {
        // A refusal is reported once for all threads, by whoever set up the run.
        let _ = realtime.enter(ThreadRole::Devices);
        loop {
            // What is asked before the stop is seen after it.
            let stop = self.shared.stopped();
            self.turn();
            if stop {
                return;
            }
            let idle = HostInstant::now() + self.idle;
            self.shared.device.wait_until(self.due().map_or(idle, |due| due.min(idle)));
        }
    }

    /// When the next image may be driven, where one waits because of the pulses in it.
    fn due(&self) -> Option<HostInstant> {
        let image = self.images.peek().ok()?;
        Some(self.pace.due(image.bits ^ self.asked, image.asked))
    }

    /// One look at what is asked: at most one call that drives and one that reads.
    pub(super) fn turn(&mut self) {
        if self.shared.is_gone() {
            self.shared.answer.ring();
            return;
        }
        // The order matters: whoever asks to be safe or started latches first, then counts.
        let wanted_safe = self.shared.wanted_safe.load(Ordering::Acquire);
        let starts = self.shared.starts.load(Ordering::Acquire);
        if starts != self.started {
            self.start(starts);
        } else {
            self.drive();
            self.read();
            self.shared.in_call.clear();
        }
        if self.shared.latched.load(Ordering::Acquire) && self.driven == Some(self.safe) {
            self.shared.made_safe.store(wanted_safe, Ordering::Release);
            self.shared.answer.ring();
        }
        if std::mem::take(&mut self.unrung) {
            self.bell.ring();
        }
    }

    /// Drives the newest image, if it is another than the last, or the safe one. Edges of pulses are driven one after
    /// another, however late they are.
    fn drive(&mut self) {
        let mut turned = 0u64;
        let mut again = 0u64;
        let mut taken = 0;
        let mut pulses = None;
        let latched = self.shared.latched.load(Ordering::Acquire);
        let now = HostInstant::now();
        while let Ok(&image) = self.images.peek() {
            let flips = image.bits ^ self.asked;
            if self.pace.times(flips) {
                if !latched && (pulses.is_some() || self.pace.due(flips, image.asked) > now) {
                    break;
                }
                pulses = Some((flips, image.asked));
            }
            // It is the one that was looked at.
            let _ = self.images.pop();
            taken += 1;
            again |= turned & flips;
            turned |= flips;
            self.asked = image.bits;
        }
        if self.shared.latched.load(Ordering::Acquire) {
            self.asked = self.safe;
        } else if again != 0 {
            self.swallowed(again);
        }
        if self.driven == Some(self.asked) {
            self.took(taken);
            return;
        }
        let bits = self.asked;
        let before = HostInstant::now();
        self.shared.in_call.set(before);
        // Now the call is what is waited for.
        self.took(taken);
        let outcome = self.port.set(bits);
        let after = HostInstant::now();
        SharedChip::log_hung(before, self.idle);
        // The call that reads comes next.
        self.shared.in_call.set(after);
        match outcome {
            Ok(()) => {
                self.driven = Some(bits);
                if let Some((flips, asked)) = pulses {
                    self.pace.drove(flips, asked, after);
                }
                self.report(ChipReport::Set { before, after, bits });
            }
            Err(error) => {
                self.driven = None;
                self.refused(&error);
            }
        }
    }

    /// So many images are dealt with.
    fn took(&self, images: u64) {
        if images > 0 {
            self.shared.taken.fetch_add(images, Ordering::AcqRel);
        }
    }

    /// Some lines went to and fro before the device came to it.
    fn swallowed(&mut self, lines: u64) {
        let at = HostInstant::now();
        for output in (0..64).filter(|output| lines >> output & 1 == 1) {
            self.report(ChipReport::Swallowed { output, count: 2, at });
        }
    }

    fn read(&mut self) {
        if self.shared.in_call.get().is_none() {
            self.shared.in_call.set(HostInstant::now());
        }
        let outcome = self.port.get();
        if let Some(since) = self.shared.in_call.get() {
            SharedChip::log_hung(since, self.idle);
        }
        match outcome {
            Ok(levels) => self.compare(levels),
            Err(error) => self.refused(&error),
        }
    }

    /// What the inputs read must be what their edges reported, or an edge never came.
    fn compare(&mut self, levels: LineLevels) {
        let mut touched = 0;
        if self.shared.touched.load(Ordering::Relaxed) != 0 {
            touched = self.shared.touched.swap(0, Ordering::AcqRel);
            let seen = self.shared.seen.load(Ordering::Acquire);
            self.levels = self.levels & !touched | seen & touched;
        }
        let differ = (self.levels ^ levels.bits) & levels.known;
        self.astray &= !touched & !(levels.known & !differ);
        if differ == 0 {
            return;
        }
        let now = HostInstant::now();
        for input in (0..64u8).filter(|input| differ >> input & 1 == 1) {
            let (bit, place) = (1 << input, usize::from(input));
            if self.astray & bit == 0 {
                self.astray |= bit;
                self.since[place] = now;
            } else if now - self.since[place] >= self.idle && !self.coming() {
                self.levels ^= bit;
                self.astray &= !bit;
                self.report(ChipReport::Strayed { input, high: levels.bits & bit != 0, at: now });
            }
        }
    }

    /// Everything safe, everything read: what a run begins with.
    fn start(&mut self, start: u64) {
        while self.images.pop().is_ok() {
            self.took(1);
        }
        self.asked = self.safe;
        self.pace.begin();
        self.astray = 0;
        self.shared.touched.store(0, Ordering::Release);
        let began = HostInstant::now();
        self.shared.in_call.set(began);
        let driven = self.port.set(self.safe);
        let before = HostInstant::now();
        let outcome = driven.and_then(|()| self.port.survey());
        let after = HostInstant::now();
        SharedChip::log_hung(began, self.idle);
        match outcome {
            Ok(levels) => {
                self.driven = Some(self.safe);
                self.levels = levels.bits;
                let bits = self.safe;
                self.report(ChipReport::Started { start, before, after, bits, levels });
            }
            Err(error) => {
                self.driven = None;
                self.refused(&error);
            }
        }
        self.started = start;
        self.shared.in_call.clear();
        self.shared.answer.ring();
    }

    /// Whether edges are on their way: then the one that is missed may be among them.
    fn coming(&self) -> bool {
        let ready = |source| {
            let mut wait = [PollFd::from_borrowed_fd(source, PollFlags::IN)];
            poll(&mut wait, Some(&timespec(Span::ZERO))).is_ok_and(|count| count > 0)
        };
        sources(&*self.port).any(ready)
            || self.shared.reading.load(Ordering::Acquire)
            || self.shared.touched.load(Ordering::Acquire) != 0
    }

    fn report(&mut self, report: ChipReport) {
        self.unrung = true;
        if self.reports.push(report).is_err() {
            self.shared.unreported.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn refused(&mut self, error: &std::io::Error) {
        self.unrung = true;
        self.shared.refused(error);
    }
}

/// The device's side of a chip, and the ends of the queues to and from it.
pub(super) fn device(
    port: Arc<dyn GpioPort>,
    shared: Arc<SharedChip>,
    bell: Arc<Bell>,
    safe: u64,
    pace: PulsePace,
    idle: Span,
) -> (ChipThread, Producer<Image>, Consumer<ChipReport>) {
    let (images, asked) = rtrb::RingBuffer::new(TURNS);
    let (reports, reported) = rtrb::RingBuffer::new(TURNS);
    let device = ChipThread {
        port,
        shared,
        images: asked,
        reports,
        bell,
        safe,
        driven: Some(safe),
        asked: safe,
        pace,
        started: 0,
        idle,
        levels: 0,
        astray: 0,
        since: [HostInstant::BOOT; 64],
        unrung: false,
    };
    (device, images, reported)
}
