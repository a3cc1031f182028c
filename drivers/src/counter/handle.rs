//! One counter as the board follows it: how far it has counted, whether it still answers.

use std::sync::Arc;

use host::{Bell, HostInstant};
use rtrb::Consumer;
use rustix::io::Errno;
use signal::{Time, Value, When};

use super::device::{CounterReport, CounterThread};
use super::{CountStep, CounterSource, CounterSpec, Follower};
use crate::board::BoardError;
use crate::channel::ChannelId;
use crate::context::BoardContext;
use crate::device_board::DeviceHandle;
use crate::device_limits::DeviceLimits;
use crate::event::{BoardEvent, Origin};
use crate::event_collector::EventCollector;
use crate::sampled::{SampleControl, Sampler};
use crate::thread::{DeviceThread, ends};

/// Reports on their way from a device, beside those of its events.
const REPORTS: usize = 1_024;

/// A counter at work. Dropping it ends its thread.
#[derive(Debug)]
pub struct CounterHandle {
    control: Arc<SampleControl>,
    /// Wakes the thread.
    wake: Arc<Bell>,
    reports: Consumer<CounterReport>,
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
        source: CounterSource,
        spec: &CounterSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> std::io::Result<CounterHandle> {
        let (control, wake) = (Arc::<SampleControl>::default(), Arc::<Bell>::default());
        let kept = spec.buffer as usize;
        let (reporter, mut thread, reports) =
            ends(REPORTS + 4 * kept, &context.bell, limits.unresponsive_after);
        let of = source.counter.device().to_owned();
        let apart = spec.longest(limits.unresponsive_after);
        let device = CounterThread {
            follower: Follower::new(spec, source.counter.ceiling(), apart, context.resolution),
            sampler: Sampler::new(source.counter, source.reopen, control.clone(), reporter, limits.reconnect),
            wake: wake.clone(),
            before: 0,
            total: 0,
            events: Vec::with_capacity(2 * kept),
            steps: Vec::with_capacity(2 * kept + 1),
            period: spec.period,
            returning: false,
        };
        let realtime = context.realtime;
        thread.start(format!("count {of}"), move || device.run(realtime))?;
        Ok(CounterHandle { control, wake, reports, channel: source.channel, device: of, count: 0, thread })
    }

    /// Until when an answer is due.
    fn due(&self) -> Option<HostInstant> {
        self.control.due(self.thread.limit())
    }

    /// How far it has counted, since this instant.
    fn count_at(&self, at: When, collector: &mut EventCollector<'_>) {
        let (channel, value, origin) = (self.channel, Value::Int(self.count), Origin::Outside);
        collector.report(BoardEvent::Changed { channel, at, value, origin });
    }

    fn report(&mut self, report: CounterReport, collector: &mut EventCollector<'_>) {
        match report {
            CounterReport::Counted(step) => {
                let at = When::within(collector.time.at(step.from), collector.time.at(step.to));
                if step.doubtful {
                    collector.dropped(self.channel, at.latest, 1);
                }
                if std::mem::replace(&mut self.count, step.total) != step.total {
                    self.count_at(at, collector);
                }
            }
            CounterReport::Missed { at } => collector.dropped(self.channel, collector.time.at(at), 1),
            CounterReport::Returned { at } => {
                let at = collector.time.at(at);
                self.thread.report_return(at, std::iter::once(self.channel), collector);
                self.count_at(When::exactly(at), collector);
            }
            // Was waited for.
            CounterReport::Started { .. } => {}
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
        let start = self.control.ask_start();
        self.wake.ring();
        start
    }

    /// It has when the count was read.
    fn await_start(&mut self, request: u64, due: HostInstant, reconnect: bool) -> bool {
        let reports = &mut self.reports;
        let answer = CounterReport::Started { start: request };
        let has_started = self.thread.await_start(due, reconnect, || {
            std::iter::from_fn(|| reports.pop().ok()).any(|one| one == answer)
        });
        if has_started {
            self.count = 0;
        }
        has_started
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
        self.control.ask_rest();
        self.wake.ring();
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
        let wake = &self.wake;
        self.thread.end(|| wake.ring(), || None);
    }
}

fn stamp_of(report: &CounterReport) -> HostInstant {
    match *report {
        CounterReport::Counted(CountStep { to: at, .. })
        | CounterReport::Missed { at }
        | CounterReport::Returned { at } => at,
        CounterReport::Started { .. } => HostInstant::BOOT,
    }
}
