//! One converter as the board follows it: what its inputs showed last, whether it still answers.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

use host::{Bell, Realtime, monotonic};
use rtrb::Consumer;
use rustix::event::{EventfdFlags, eventfd};
use signal::{Span, Time, Value, When};

use super::device::{Device, Known, Opener, Report, Shared};
use super::spec::longest;
use super::{AT_ONCE, Adc, SampleSpec, Shown};
use crate::event_collector::EventCollector;
use crate::thread::{DeviceThread, ends};
use crate::{BoardError, BoardEvent, ChannelId, Origin};

/// Reports on their way from a device, at least.
const REPORTS: usize = 1_024;

/// A converter at work. Dropping it ends its thread.
#[derive(Debug)]
pub(super) struct AdcHandle {
    shared: Arc<Shared>,
    reports: Consumer<Report>,
    pub(super) channels: Vec<ChannelId>,
    /// What messages call it.
    pub(super) device: String,
    /// What each input showed last; `None` before its first reading.
    shown: Vec<Option<Shown>>,
    thread: DeviceThread,
}

impl AdcHandle {
    /// Sets a converter to work.
    pub(super) fn start(
        converter: Box<dyn Adc>,
        opener: Opener,
        samples: &[SampleSpec],
        period: Span,
        (limit, reconnect): (Span, bool),
        (bell, realtime): (&Arc<Bell>, Realtime),
    ) -> std::io::Result<AdcHandle> {
        let shared = Arc::new(Shared {
            active: AtomicBool::new(false),
            starts: AtomicU64::new(0),
            owes: AtomicI64::new(0),
            noise: samples.iter().map(|_| AtomicU64::new(f64::NAN.to_bits())).collect(),
            wake: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
        });
        let (reporter, mut thread, reports) = ends(REPORTS.max(samples.len() * 4), bell, limit);
        let of = converter.device().to_owned();
        let name = format!("adc {of}");
        let apart = longest(period, converter.spread()).as_nanos();
        let device = Device {
            found: Vec::with_capacity(samples.len() * AT_ONCE),
            inputs: samples.iter().map(|sample| Known::new(sample.scale.clone())).collect(),
            converter: Some(converter),
            opener,
            shared: shared.clone(),
            reporter,
            apart,
            reconnect,
            started: 0,
            complete: true,
            due: 0,
            lost: 0,
        };
        thread.start(name, move || device.run(realtime))?;
        Ok(AdcHandle {
            shared,
            reports,
            channels: samples.iter().map(|sample| sample.channel).collect(),
            device: of,
            shown: vec![None; samples.len()],
            thread,
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
    pub(super) fn await_start(&mut self, start: u64, due: i64, reconnect: bool) -> bool {
        loop {
            while let Ok(report) = self.reports.pop() {
                match report {
                    Report::Sample { input, shown, .. } => {
                        if let Some(last) = self.shown.get_mut(usize::from(input)) {
                            *last = Some(shown);
                        }
                    }
                    Report::Started { start: done } if done == start => {
                        self.thread.begin();
                        return true;
                    }
                    _ => {}
                }
            }
            if self.thread.is_gone() && !reconnect || monotonic() >= due {
                return false;
            }
            self.thread.wait(due);
        }
    }

    /// Readings are wanted no longer.
    pub(super) fn rest(&self) {
        self.shared.active.store(false, Ordering::Release);
        self.shared.wake();
    }

    /// What a start says that gets no readings of it.
    pub(super) fn is_lost(&self) -> BoardError {
        self.thread.loss(self.channels.first().copied().unwrap_or(ChannelId(0)), self.due())
    }

    /// Until when an answer is owed; 0 for none.
    fn due(&self) -> i64 {
        match self.shared.owes.load(Ordering::Acquire) {
            0 => 0,
            owes => owes.saturating_add(self.thread.limit()),
        }
    }

    /// When the converter counts as silent if it does not answer.
    pub(super) fn overdue(&self) -> Option<i64> {
        self.thread.overdue(self.due())
    }

    /// What all inputs show.
    pub(super) fn present(&self, at: Time, collector: &mut EventCollector<'_>) {
        for (channel, shown) in self.channels.iter().zip(&self.shown) {
            changed(*channel, When::exactly(at), *shown, collector);
        }
    }

    /// Tells what happened up to now.
    pub(super) fn poll(&mut self, collector: &mut EventCollector<'_>) {
        while let Some(report) = collector.next(&mut self.reports, stamp_of) {
            self.report(report, collector);
        }
        let due = self.due();
        let channels = self.channels.iter().copied();
        self.thread.report_overflow(channels.clone(), collector);
        if self.thread.report_presence(due, channels, collector) {
            self.present(collector.now, collector);
        }
    }

    fn report(&mut self, report: Report, collector: &mut EventCollector<'_>) {
        match report {
            Report::Sample { input, from, to, shown } => {
                let input = usize::from(input);
                let (Some(last), Some(channel)) = (self.shown.get_mut(input), self.channels.get(input))
                else {
                    return;
                };
                *last = Some(shown);
                let at = When::within(collector.time.at(from), collector.time.at(to));
                changed(*channel, at, Some(shown), collector);
            }
            Report::Missed { input, count, at } => {
                if let Some(channel) = self.channels.get(usize::from(input)) {
                    collector.dropped(*channel, collector.time.at(at), count);
                }
            }
            Report::Returned { at } => {
                let at = collector.time.at(at);
                self.thread.report_return(at, self.channels.iter().copied(), collector);
            }
            // Was waited for.
            Report::Started { .. } => {}
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
        if self.thread.is_lost() { self.channels.len() as u32 } else { 0 }
    }

    /// Calls that failed since the start.
    pub(super) fn failed_calls(&self) -> u64 {
        self.thread.failed_calls()
    }
}

impl Drop for AdcHandle {
    fn drop(&mut self) {
        let shared = &self.shared;
        self.thread.end(|| shared.wake(), || 0);
    }
}

fn changed(channel: ChannelId, at: When, shown: Option<Shown>, collector: &mut EventCollector<'_>) {
    let (value, origin) = match shown {
        Some(Ok(value)) => (value, Origin::Outside),
        Some(Err(gap)) => (Value::Unknown, Origin::Gap(gap)),
        None => (Value::Unknown, Origin::Outside),
    };
    collector.tell(BoardEvent::Changed { channel, at, value, origin });
}

fn stamp_of(report: &Report) -> i64 {
    match *report {
        Report::Sample { to: at, .. } | Report::Missed { at, .. } | Report::Returned { at } => at,
        Report::Started { .. } => i64::MIN,
    }
}
