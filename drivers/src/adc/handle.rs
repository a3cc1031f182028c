//! One converter as the board follows it: what its inputs showed last, whether it still answers.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use host::HostInstant;
use rtrb::Consumer;
use rustix::event::{EventfdFlags, eventfd};
use rustix::io::Errno;
use signal::{Time, Value, When};

use super::device::{AdcReport, AdcThread, KnownInput, SharedAdc};
use super::spec::longest;
use super::{AT_ONCE, AdcSource, Shown};
use crate::board::BoardError;
use crate::channel::ChannelId;
use crate::context::BoardContext;
use crate::device_board::DeviceHandle;
use crate::device_limits::DeviceLimits;
use crate::event::{BoardEvent, Origin};
use crate::event_collector::EventCollector;
use crate::sampled::{SampleControl, Sampler};
use crate::thread::{DeviceThread, ends};

/// Reports on their way from a device, at least.
const REPORTS: usize = 1_024;

/// A converter at work. Dropping it ends its thread.
#[derive(Debug)]
pub struct AdcHandle {
    control: Arc<SampleControl>,
    shared: Arc<SharedAdc>,
    reports: Consumer<AdcReport>,
    channels: Vec<ChannelId>,
    /// What messages call it.
    device: String,
    /// How it is reached.
    kind: &'static str,
    /// What each input showed last; `None` before its first reading.
    shown: Vec<Option<Shown>>,
    thread: DeviceThread,
}

impl AdcHandle {
    /// Sets a converter to work.
    pub(super) fn start(
        source: AdcSource,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> std::io::Result<AdcHandle> {
        let AdcSource { converter, inputs: samples, period, reopen } = source;
        let control = Arc::<SampleControl>::default();
        let shared = Arc::new(SharedAdc {
            noise: samples.iter().map(|_| AtomicU64::new(f64::NAN.to_bits())).collect(),
            wake: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
        });
        let (reporter, mut thread, reports) =
            ends(REPORTS.max(samples.len() * 4), &context.bell, limits.unresponsive_after);
        let (of, kind) = (converter.device().to_owned(), converter.kind());
        let name = format!("adc {of}");
        let apart = longest(period, converter.spread());
        let device = AdcThread {
            found: Vec::with_capacity(samples.len() * AT_ONCE),
            inputs: samples.iter().map(|sample| KnownInput::new(sample.scale.clone())).collect(),
            sampler: Sampler::new(converter, reopen, control.clone(), reporter, limits.reconnect),
            shared: shared.clone(),
            apart,
            lost: 0,
        };
        let realtime = context.realtime;
        thread.start(name, move || device.run(realtime))?;
        Ok(AdcHandle {
            control,
            shared,
            reports,
            channels: samples.iter().map(|sample| sample.channel).collect(),
            device: of,
            kind,
            shown: vec![None; samples.len()],
            thread,
        })
    }

    /// Until when an answer is due.
    fn due(&self) -> Option<HostInstant> {
        self.control.due(self.thread.limit())
    }

    fn report(&mut self, report: AdcReport, collector: &mut EventCollector<'_>) {
        match report {
            AdcReport::Sample { input, from, to, shown } => {
                let input = usize::from(input);
                let (Some(last), Some(channel)) = (self.shown.get_mut(input), self.channels.get(input))
                else {
                    return;
                };
                *last = Some(shown);
                let at = When::within(collector.time.at(from), collector.time.at(to));
                changed(*channel, at, Some(shown), collector);
            }
            AdcReport::Missed { input, count, at } => {
                if let Some(channel) = self.channels.get(usize::from(input)) {
                    collector.dropped(*channel, collector.time.at(at), count);
                }
            }
            AdcReport::Returned { at } => {
                let at = collector.time.at(at);
                self.thread.report_return(at, self.channels.iter().copied(), collector);
            }
            // Was waited for.
            AdcReport::Started { .. } => {}
        }
    }
}

impl DeviceHandle for AdcHandle {
    const DRIVES: bool = false;

    fn device(&self) -> &str {
        &self.device
    }

    fn kind(&self) -> &'static str {
        self.kind
    }

    fn channels(&self) -> Vec<ChannelId> {
        self.channels.clone()
    }

    fn ask_start(&mut self) -> u64 {
        let start = self.control.ask_start();
        self.shared.wake();
        start
    }

    /// It has when every input was read.
    fn await_start(&mut self, request: u64, due: HostInstant, reconnect: bool) -> bool {
        let (reports, known) = (&mut self.reports, &mut self.shown);
        self.thread.await_start(due, reconnect, || {
            while let Ok(report) = reports.pop() {
                match report {
                    AdcReport::Sample { input, shown, .. } => {
                        if let Some(last) = known.get_mut(usize::from(input)) {
                            *last = Some(shown);
                        }
                    }
                    AdcReport::Started { start: done } if done == request => return true,
                    _ => {}
                }
            }
            false
        })
    }

    fn loss(&self) -> BoardError {
        self.thread.loss(self.channels.first().copied().unwrap_or(ChannelId(0)), self.due())
    }

    fn present(&self, at: Time, collector: &mut EventCollector<'_>) {
        for (channel, shown) in self.channels.iter().zip(&self.shown) {
            changed(*channel, When::exactly(at), *shown, collector);
        }
    }

    fn poll(&mut self, _latched: bool, collector: &mut EventCollector<'_>) -> bool {
        while let Some(report) = collector.next(&mut self.reports, stamp_of) {
            self.report(report, collector);
        }
        let due = self.due();
        let channels = self.channels.iter().copied();
        self.thread.report_overflow(channels.clone(), collector);
        if self.thread.report_presence(due, channels, collector) {
            self.present(collector.now, collector);
        }
        false
    }

    fn overdue(&self) -> Option<HostInstant> {
        self.thread.overdue(self.due())
    }

    /// Nothing is driven: it rests until the next start.
    fn ask_safe(&mut self) -> u64 {
        self.control.ask_rest();
        self.shared.wake();
        0
    }

    fn await_safe(&self, _request: u64, _due: HostInstant) -> Result<(), Errno> {
        Ok(())
    }

    fn lost_channels(&self) -> u32 {
        if self.thread.is_lost() { self.channels.len() as u32 } else { 0 }
    }

    fn failed_calls(&self) -> u64 {
        self.thread.failed_calls()
    }

    fn noise(&self, place: usize) -> Option<f64> {
        let noise = f64::from_bits(self.shared.noise.get(place)?.load(Ordering::Acquire));
        noise.is_finite().then_some(noise)
    }
}

impl Drop for AdcHandle {
    fn drop(&mut self) {
        let shared = &self.shared;
        self.thread.end(|| shared.wake(), || None);
    }
}

fn changed(channel: ChannelId, at: When, shown: Option<Shown>, collector: &mut EventCollector<'_>) {
    let (value, origin) = match shown {
        Some(Ok(value)) => (value, Origin::Outside),
        Some(Err(gap)) => (Value::Unknown, Origin::Gap(gap)),
        None => (Value::Unknown, Origin::Outside),
    };
    collector.report(BoardEvent::Changed { channel, at, value, origin });
}

fn stamp_of(report: &AdcReport) -> HostInstant {
    match *report {
        AdcReport::Sample { to: at, .. } | AdcReport::Missed { at, .. } | AdcReport::Returned { at } => at,
        AdcReport::Started { .. } => HostInstant::BOOT,
    }
}
