//! One converter as the board follows it: what its inputs showed last, whether it still answers.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicI64, AtomicU64, Ordering};

use host::{Bell, Realtime, monotonic};
use rtrb::Consumer;
use rustix::event::{EventfdFlags, eventfd};
use signal::{Span, Time, Value, When};

use super::device::{Device, Known, Opener, Report, Shared};
use super::spec::longest;
use super::{AT_ONCE, Converter, SampleSpec, Shown};
use crate::gpio::telling::Telling;
use crate::{BoardError, BoardEvent, ChannelId, LossReason, Origin};

/// Reports on their way from a device, at least.
const REPORTS: usize = 1_024;

/// A converter at work. Dropping it ends its thread.
#[derive(Debug)]
pub(super) struct Watched {
    pub(super) shared: Arc<Shared>,
    reports: Consumer<Report>,
    pub(super) channels: Vec<ChannelId>,
    /// What messages call it.
    pub(super) device: String,
    /// What each input showed last; `None` before its first reading.
    shown: Vec<Option<Shown>>,
    /// How long a call may last.
    limit: i64,
    lost: Option<LossReason>,
    /// Calls that had failed when the run began.
    failed: u64,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Watched {
    /// Sets a converter to work.
    pub(super) fn start(
        converter: Box<dyn Converter>,
        opener: Opener,
        samples: &[SampleSpec],
        period: Span,
        (limit, retake): (Span, bool),
        (bell, realtime): (&Arc<Bell>, Realtime),
    ) -> std::io::Result<Watched> {
        let shared = Arc::new(Shared {
            active: AtomicBool::new(false),
            starts: AtomicU64::new(0),
            owes: AtomicI64::new(0),
            gone: AtomicI32::new(0),
            gone_at: AtomicI64::new(0),
            failed: AtomicU64::new(0),
            unreported: AtomicU64::new(0),
            noise: samples.iter().map(|_| AtomicU64::new(f64::NAN.to_bits())).collect(),
            stop: AtomicBool::new(false),
            ended: AtomicBool::new(false),
            wake: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
            answer: Bell::new(),
        });
        let (reports, reported) = rtrb::RingBuffer::new(REPORTS.max(samples.len() * 4));
        let of = converter.device().to_owned();
        let name = format!("adc {of}");
        let apart = longest(period, converter.spread()).as_nanos();
        let device = Device {
            found: Vec::with_capacity(samples.len() * AT_ONCE),
            inputs: samples.iter().map(|sample| Known::new(sample.scale.clone())).collect(),
            converter: Some(converter),
            opener,
            shared: shared.clone(),
            reports,
            bell: bell.clone(),
            limit: limit.as_nanos(),
            apart,
            retake,
            started: 0,
            complete: true,
            due: 0,
            failing: None,
            lost: 0,
            told: false,
        };
        let thread = std::thread::Builder::new().name(name).spawn(move || device.run(realtime))?;
        Ok(Watched {
            shared,
            reports: reported,
            channels: samples.iter().map(|sample| sample.channel).collect(),
            device: of,
            shown: vec![None; samples.len()],
            limit: limit.as_nanos(),
            lost: None,
            failed: 0,
            thread: Some(thread),
        })
    }

    /// Asks for a new run. The number of this beginning.
    pub(super) fn ask_start(&mut self) -> u64 {
        let start = self.shared.starts.fetch_add(1, Ordering::AcqRel) + 1;
        self.shared.active.store(true, Ordering::Release);
        self.shared.wake();
        start
    }

    /// Waits until every input was read. FALSE where that is not so in time.
    pub(super) fn await_start(&mut self, start: u64, due: i64, retake: bool) -> bool {
        loop {
            while let Ok(report) = self.reports.pop() {
                match report {
                    Report::Sample { input, shown, .. } => {
                        if let Some(last) = self.shown.get_mut(usize::from(input)) {
                            *last = Some(shown);
                        }
                    }
                    Report::Started { start: done } if done == start => {
                        self.lost = None;
                        self.failed = self.shared.failed.load(Ordering::Acquire);
                        self.shared.unreported.store(0, Ordering::Release);
                        return true;
                    }
                    _ => {}
                }
            }
            if self.is_gone() && !retake || monotonic() >= due {
                return false;
            }
            self.shared.answer.wait_until(due);
        }
    }

    /// Readings are wanted no longer.
    pub(super) fn rest(&self) {
        self.shared.active.store(false, Ordering::Release);
        self.shared.wake();
    }

    pub(super) fn is_gone(&self) -> bool {
        self.shared.gone.load(Ordering::Acquire) != 0
    }

    /// What a start says that gets no readings of it.
    pub(super) fn is_lost(&self) -> BoardError {
        let (reason, stamp) = match self.is_gone() {
            true => (LossReason::Gone, &self.shared.gone_at),
            false => (LossReason::Silent, &self.shared.owes),
        };
        let since = match stamp.load(Ordering::Acquire) {
            0 => Span::ZERO,
            stamp => Span::from_nanos(monotonic().saturating_sub(stamp).max(0)),
        };
        let channel = self.channels.first().copied().unwrap_or(ChannelId(0));
        BoardError::Lost { channel, reason, since }
    }

    /// When the converter counts as silent if it does not answer.
    pub(super) fn overdue(&self) -> Option<i64> {
        let owes = self.shared.owes.load(Ordering::Acquire);
        (self.lost.is_none() && owes != 0).then(|| owes.saturating_add(self.limit))
    }

    /// What all inputs show.
    pub(super) fn present(&self, at: Time, telling: &mut Telling<'_>) {
        for (channel, shown) in self.channels.iter().zip(&self.shown) {
            changed(*channel, When::exactly(at), *shown, telling);
        }
    }

    /// Tells what happened up to now.
    pub(super) fn poll(&mut self, telling: &mut Telling<'_>) {
        let now = telling.time.stamp(telling.now);
        while let Ok(report) = self.reports.peek().copied() {
            if stamp_of(&report) > now {
                telling.ahead(stamp_of(&report));
                break;
            }
            // It is the one that was looked at.
            let _ = self.reports.pop();
            self.report(report, telling);
        }
        let unreported = self.shared.unreported.swap(0, Ordering::AcqRel);
        if unreported > 0 {
            let count = u32::try_from(unreported).unwrap_or(u32::MAX);
            for channel in &self.channels {
                telling.dropped(*channel, telling.now, count);
            }
        }
        self.answers(now, telling);
    }

    fn report(&mut self, report: Report, telling: &mut Telling<'_>) {
        match report {
            Report::Sample { input, from, to, shown } => {
                let input = usize::from(input);
                let (Some(last), Some(channel)) = (self.shown.get_mut(input), self.channels.get(input))
                else {
                    return;
                };
                *last = Some(shown);
                let at = When::within(telling.time.at(from), telling.time.at(to));
                changed(*channel, at, Some(shown), telling);
            }
            Report::Missed { input, count, at } => {
                if let Some(channel) = self.channels.get(usize::from(input)) {
                    telling.dropped(*channel, telling.time.at(at), count);
                }
            }
            Report::Returned { at } => {
                let at = telling.time.at(at);
                if self.lost.is_none() {
                    self.tell(Some(LossReason::Gone), at, telling);
                }
                self.tell(None, at, telling);
            }
            // Was waited for.
            Report::Started { .. } => {}
        }
    }

    /// Whether the converter still answers.
    fn answers(&mut self, now: i64, telling: &mut Telling<'_>) {
        let silent = |owes: i64| owes != 0 && owes.saturating_add(self.limit) < now;
        let reason = match self.lost {
            _ if self.is_gone() => Some(LossReason::Gone),
            // It says itself when it is there again.
            Some(LossReason::Gone) => return,
            _ => silent(self.shared.owes.load(Ordering::Acquire)).then_some(LossReason::Silent),
        };
        if reason != self.lost {
            self.tell(reason, telling.now, telling);
            if reason.is_none() {
                self.present(telling.now, telling);
            }
        }
    }

    fn tell(&mut self, lost: Option<LossReason>, at: Time, telling: &mut Telling<'_>) {
        self.lost = lost;
        for channel in &self.channels {
            telling.tell(match lost {
                Some(reason) => BoardEvent::Lost { channel: *channel, at, reason },
                None => BoardEvent::Returned { channel: *channel, at },
            });
        }
    }

    /// The noise of a channel in its last reading, in its unit.
    pub(super) fn noise(&self, channel: ChannelId) -> Option<f64> {
        let input = self.channels.iter().position(|other| *other == channel)?;
        let noise = f64::from_bits(self.shared.noise.get(input)?.load(Ordering::Acquire));
        noise.is_finite().then_some(noise)
    }

    /// Channels that are lost with the converter.
    pub(super) fn lost_channels(&self) -> u32 {
        if self.lost.is_some() { self.channels.len() as u32 } else { 0 }
    }

    /// Calls that failed since the start.
    pub(super) fn failed_calls(&self) -> u64 {
        self.shared.failed.load(Ordering::Acquire) - self.failed
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        self.shared.wake();
        let due = monotonic().saturating_add(self.limit);
        while !self.shared.ended.load(Ordering::Acquire) {
            // A thread inside a call that hangs is left to it.
            if monotonic() >= due {
                return;
            }
            self.shared.answer.wait_until(due);
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn changed(channel: ChannelId, at: When, shown: Option<Shown>, telling: &mut Telling<'_>) {
    let (value, origin) = match shown {
        Some(Ok(value)) => (value, Origin::Outside),
        Some(Err(gap)) => (Value::Unknown, Origin::Gap(gap)),
        None => (Value::Unknown, Origin::Outside),
    };
    telling.tell(BoardEvent::Changed { channel, at, value, origin });
}

fn stamp_of(report: &Report) -> i64 {
    match *report {
        Report::Sample { to: at, .. } | Report::Missed { at, .. } | Report::Returned { at } => at,
        Report::Started { .. } => i64::MIN,
    }
}
