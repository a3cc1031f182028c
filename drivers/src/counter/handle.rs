//! One counter as the board follows it: how far it has counted, whether it still answers.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::{Bell, Realtime, monotonic};
use rtrb::Consumer;
use signal::{Span, Value, When};

use super::device::{Device, Report, Shared};
use super::{CounterSpec, Follower, Source, Step};
use crate::event_collector::EventCollector;
use crate::thread::{DeviceThread, ends};
use crate::{BoardError, BoardEvent, ChannelId, Origin};

/// Reports on their way from a device, beside those of its events.
const REPORTS: usize = 1_024;

/// A counter at work. Dropping it ends its thread.
#[derive(Debug)]
pub(super) struct CounterHandle {
    shared: Arc<Shared>,
    reports: Consumer<Report>,
    pub(super) channel: ChannelId,
    /// What messages call it.
    pub(super) device: String,
    /// How far it has counted.
    count: i64,
    thread: DeviceThread,
}

impl CounterHandle {
    /// Sets a counter to work.
    pub(super) fn start(
        source: Source,
        spec: &CounterSpec,
        (limit, reconnect): (Span, bool),
        (bell, realtime, resolution): (&Arc<Bell>, Realtime, Span),
    ) -> std::io::Result<CounterHandle> {
        let shared = Arc::new(Shared::default());
        let kept = spec.buffer as usize;
        let (reporter, mut thread, reports) = ends(REPORTS + 4 * kept, bell, limit);
        let of = source.counter.device().to_owned();
        let apart = spec.longest(limit).as_nanos();
        let device = Device {
            follower: Follower::new(spec, source.counter.ceiling(), apart, resolution.as_nanos()),
            counter: Some(source.counter),
            opener: source.again,
            shared: shared.clone(),
            reporter,
            before: 0,
            total: 0,
            events: Vec::with_capacity(2 * kept),
            steps: Vec::with_capacity(2 * kept + 1),
            period: spec.period.as_nanos(),
            reconnect,
            started: 0,
            complete: true,
            due: 0,
        };
        thread.start(format!("count {of}"), move || device.run(realtime))?;
        Ok(CounterHandle { shared, reports, channel: source.channel, device: of, count: 0, thread })
    }

    /// Asks for a new run. The number of this beginning.
    pub(super) fn ask_start(&mut self) -> u64 {
        let start = self.shared.starts.fetch_add(1, Ordering::AcqRel) + 1;
        self.shared.active.store(true, Ordering::Release);
        self.shared.wake.ring();
        start
    }

    /// Waits until it was read. FALSE where that is not so in time.
    pub(super) fn await_start(&mut self, start: u64, due: i64, reconnect: bool) -> bool {
        loop {
            while let Ok(report) = self.reports.pop() {
                if report == (Report::Started { start }) {
                    self.count = 0;
                    self.thread.begin();
                    return true;
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
        self.shared.wake.ring();
    }

    /// What a start says that gets no reading of it.
    pub(super) fn is_lost(&self) -> BoardError {
        self.thread.loss(self.channel, self.due())
    }

    /// Until when an answer is owed; 0 for none.
    fn due(&self) -> i64 {
        match self.shared.owes.load(Ordering::Acquire) {
            0 => 0,
            owes => owes.saturating_add(self.thread.limit()),
        }
    }

    /// When the counter counts as silent if it does not answer.
    pub(super) fn overdue(&self) -> Option<i64> {
        self.thread.overdue(self.due())
    }

    /// How far it has counted.
    pub(super) fn present(&self, at: When, collector: &mut EventCollector<'_>) {
        let (channel, value, origin) = (self.channel, Value::Int(self.count), Origin::Outside);
        collector.tell(BoardEvent::Changed { channel, at, value, origin });
    }

    /// Tells what happened up to now.
    pub(super) fn poll(&mut self, collector: &mut EventCollector<'_>) {
        while let Some(report) = collector.next(&mut self.reports, stamp_of) {
            self.report(report, collector);
        }
        let channel = std::iter::once(self.channel);
        self.thread.report_overflow(channel.clone(), collector);
        if self.thread.report_presence(self.due(), channel, collector) {
            self.present(When::exactly(collector.now), collector);
        }
    }

    fn report(&mut self, report: Report, collector: &mut EventCollector<'_>) {
        match report {
            Report::Counted(step) => {
                let at = When::within(collector.time.at(step.from), collector.time.at(step.to));
                if step.doubtful {
                    collector.dropped(self.channel, at.latest, 1);
                }
                if std::mem::replace(&mut self.count, step.total) != step.total {
                    self.present(at, collector);
                }
            }
            Report::Missed { at } => collector.dropped(self.channel, collector.time.at(at), 1),
            Report::Returned { at } => {
                let at = collector.time.at(at);
                self.thread.report_return(at, std::iter::once(self.channel), collector);
                self.present(When::exactly(at), collector);
            }
            // Was waited for.
            Report::Started { .. } => {}
        }
    }

    /// Whether it is lost.
    pub(super) fn has_gone(&self) -> bool {
        self.thread.is_lost()
    }

    /// Calls that failed since the start.
    pub(super) fn failed_calls(&self) -> u64 {
        self.thread.failed_calls()
    }
}

impl Drop for CounterHandle {
    fn drop(&mut self) {
        let shared = &self.shared;
        self.thread.end(|| shared.wake.ring(), || 0);
    }
}

fn stamp_of(report: &Report) -> i64 {
    match *report {
        Report::Counted(Step { to: at, .. }) | Report::Missed { at } | Report::Returned { at } => at,
        Report::Started { .. } => i64::MIN,
    }
}
