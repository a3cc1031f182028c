//! One counter as the board follows it: how far it has counted, whether it still answers.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::HostInstant;
use rtrb::Consumer;
use rustix::io::Errno;
use signal::{Time, Value, When};

use super::device::{Device, Report, Shared};
use super::{CounterSpec, Follower, Source, Step};
use crate::board::BoardError;
use crate::channel::ChannelId;
use crate::context::BoardContext;
use crate::device_board::DeviceHandle;
use crate::device_limits::DeviceLimits;
use crate::event::{BoardEvent, Origin};
use crate::event_collector::EventCollector;
use crate::thread::{DeviceThread, ends};

/// Reports on their way from a device, beside those of its events.
const REPORTS: usize = 1_024;

/// A counter at work. Dropping it ends its thread.
#[derive(Debug)]
pub struct CounterHandle {
    shared: Arc<Shared>,
    reports: Consumer<Report>,
    channel: ChannelId,
    /// What messages call it.
    device: String,
    /// How far it has counted.
    count: i64,
    thread: DeviceThread,
}

impl CounterHandle {
    /// Sets a counter to work.
    pub(super) fn start(
        source: Source,
        spec: &CounterSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> std::io::Result<CounterHandle> {
        let shared = Arc::new(Shared::default());
        let kept = spec.buffer as usize;
        let (reporter, mut thread, reports) =
            ends(REPORTS + 4 * kept, &context.bell, limits.unresponsive_after);
        let of = source.counter.device().to_owned();
        let apart = spec.longest(limits.unresponsive_after);
        let device = Device {
            follower: Follower::new(spec, source.counter.ceiling(), apart, context.resolution),
            counter: Some(source.counter),
            opener: source.again,
            shared: shared.clone(),
            reporter,
            before: 0,
            total: 0,
            events: Vec::with_capacity(2 * kept),
            steps: Vec::with_capacity(2 * kept + 1),
            period: spec.period,
            reconnect: limits.reconnect,
            started: 0,
            complete: true,
            returning: false,
            due: HostInstant::BOOT,
        };
        let realtime = context.realtime;
        thread.start(format!("count {of}"), move || device.run(realtime))?;
        Ok(CounterHandle { shared, reports, channel: source.channel, device: of, count: 0, thread })
    }

    /// Until when an answer is owed.
    fn due(&self) -> Option<HostInstant> {
        Some(self.shared.owes.get()? + self.thread.limit())
    }

    /// How far it has counted, since this instant.
    fn count_at(&self, at: When, collector: &mut EventCollector<'_>) {
        let (channel, value, origin) = (self.channel, Value::Int(self.count), Origin::Outside);
        collector.report(BoardEvent::Changed { channel, at, value, origin });
    }

    fn report(&mut self, report: Report, collector: &mut EventCollector<'_>) {
        match report {
            Report::Counted(step) => {
                let at = When::within(collector.time.at(step.from), collector.time.at(step.to));
                if step.doubtful {
                    collector.dropped(self.channel, at.latest, 1);
                }
                if std::mem::replace(&mut self.count, step.total) != step.total {
                    self.count_at(at, collector);
                }
            }
            Report::Missed { at } => collector.dropped(self.channel, collector.time.at(at), 1),
            Report::Returned { at } => {
                let at = collector.time.at(at);
                self.thread.report_return(at, std::iter::once(self.channel), collector);
                self.count_at(When::exactly(at), collector);
            }
            // Was waited for.
            Report::Started { .. } => {}
        }
    }
}

impl DeviceHandle for CounterHandle {
    const DRIVES: bool = false;

    fn device(&self) -> &str {
        &self.device
    }

    fn kind(&self) -> &'static str {
        "counter"
    }

    fn channels(&self) -> Vec<ChannelId> {
        vec![self.channel]
    }

    fn ask_start(&mut self) -> u64 {
        let start = self.shared.starts.fetch_add(1, Ordering::AcqRel) + 1;
        self.shared.active.store(true, Ordering::Release);
        self.shared.wake.ring();
        start
    }

    /// It has when the count was read.
    fn await_start(&mut self, request: u64, due: HostInstant, reconnect: bool) -> bool {
        loop {
            while let Ok(report) = self.reports.pop() {
                if report == (Report::Started { start: request }) {
                    self.count = 0;
                    self.thread.begin();
                    return true;
                }
            }
            if self.thread.is_gone() && !reconnect || HostInstant::now() >= due {
                return false;
            }
            self.thread.wait(due);
        }
    }

    fn loss(&self) -> BoardError {
        self.thread.loss(self.channel, self.due())
    }

    fn present(&self, at: Time, collector: &mut EventCollector<'_>) {
        self.count_at(When::exactly(at), collector);
    }

    fn poll(&mut self, _latched: bool, collector: &mut EventCollector<'_>) -> bool {
        while let Some(report) = collector.next(&mut self.reports, stamp_of) {
            self.report(report, collector);
        }
        let channel = std::iter::once(self.channel);
        self.thread.report_overflow(channel.clone(), collector);
        if self.thread.report_presence(self.due(), channel, collector) {
            self.present(collector.now, collector);
        }
        false
    }

    fn overdue(&self) -> Option<HostInstant> {
        self.thread.overdue(self.due())
    }

    /// Nothing is driven: it goes on by itself, and nobody looks until the next start.
    fn ask_safe(&mut self) -> u64 {
        self.shared.active.store(false, Ordering::Release);
        self.shared.wake.ring();
        0
    }

    fn await_safe(&self, _request: u64, _due: HostInstant) -> Result<(), Errno> {
        Ok(())
    }

    fn lost_channels(&self) -> u32 {
        u32::from(self.thread.is_lost())
    }

    fn failed_calls(&self) -> u64 {
        self.thread.failed_calls()
    }
}

impl Drop for CounterHandle {
    fn drop(&mut self) {
        let shared = &self.shared;
        self.thread.end(|| shared.wake.ring(), || None);
    }
}

fn stamp_of(report: &Report) -> HostInstant {
    match *report {
        Report::Counted(Step { to: at, .. }) | Report::Missed { at } | Report::Returned { at } => at,
        Report::Started { .. } => HostInstant::BOOT,
    }
}
