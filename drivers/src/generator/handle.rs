//! One generator as the board follows it: what it was asked for, what it did, whether it still answers.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use host::HostInstant;
use rtrb::{Consumer, Producer};
use rustix::io::Errno;
use signal::{Span, Time, Value, When};

use super::bits::{BitClock, BitLayout};
use super::board::GeneratorSource;
use super::device::{GeneratorOrder, GeneratorReport, GeneratorThread, NumberedOrder, SharedGenerator};
use super::sent_edges::{AT_ONCE, SentStream};
use super::spec::GeneratorKind;
use crate::board::{BoardError, Call};
use crate::channel::{ChannelId, Emission};
use crate::context::BoardContext;
use crate::device_board::DeviceHandle;
use crate::device_limits::DeviceLimits;
use crate::event::Origin;
use crate::event_collector::EventCollector;
use crate::thread::{DeviceThread, ends};

/// Orders on their way to a device, and reports on their way back.
const ORDERS: usize = 256;

/// An output as the board knows it.
#[derive(Debug)]
pub(super) struct KnownOutput {
    pub(super) channel: ChannelId,
    pub(super) safe: bool,
    /// Its changes are reported.
    senses: bool,
    /// How its pulses become bits; `None` for one that emits waves and keeps levels.
    stream: Option<(BitClock, BitLayout)>,
    /// What it was asked to keep up.
    wanted: Option<GeneratorOrder>,
}

/// A generator at work. Dropping it brings its outputs to rest and ends its thread.
#[derive(Debug)]
pub struct GeneratorHandle {
    shared: Arc<SharedGenerator>,
    asked: Producer<NumberedOrder>,
    reports: Consumer<GeneratorReport>,
    outputs: Vec<KnownOutput>,
    /// What messages call it.
    device: String,
    /// What it is, in a word.
    kind: &'static str,
    /// The number of the last order.
    number: u64,
    /// Pulses that were ordered and not reported yet, by the numbers of their orders.
    waiting: VecDeque<(u64, Arc<[Span]>)>,
    /// Those that were sent and are still to be reported.
    sent: VecDeque<SentStream>,
    thread: DeviceThread,
}

impl GeneratorHandle {
    /// Sets a generator to work.
    pub(super) fn start(
        source: GeneratorSource,
        senses: impl Fn(ChannelId) -> bool,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> std::io::Result<GeneratorHandle> {
        let GeneratorSource { generator, kind, outputs, reopen } = source;
        let shared = Arc::<SharedGenerator>::default();
        let (orders, asked) = rtrb::RingBuffer::new(ORDERS);
        let (reporter, mut thread, reports) = ends(ORDERS, &context.bell, limits.unresponsive_after);
        let of = generator.device().to_owned();
        let device = GeneratorThread {
            generator: Some(generator),
            reopen,
            shared: shared.clone(),
            asked,
            reporter,
            reconnect: limits.reconnect,
            rested: 0,
            look: HostInstant::BOOT,
        };
        let realtime = context.realtime;
        thread.start(format!("emit {of}"), move || device.run(realtime))?;
        let known = outputs.iter().map(|output| KnownOutput {
            channel: output.channel,
            safe: output.safe,
            senses: senses(output.channel),
            stream: match &kind {
                GeneratorKind::Stream(stream) => Some((stream.clock, stream.layout(output.active_low))),
                GeneratorKind::Pwm(_) => None,
            },
            wanted: None,
        });
        Ok(GeneratorHandle {
            shared,
            asked: orders,
            reports,
            outputs: known.collect(),
            device: of,
            kind: kind.word(),
            number: 0,
            waiting: VecDeque::with_capacity(ORDERS),
            sent: VecDeque::with_capacity(ORDERS),
            thread,
        })
    }

    /// A run begins: what was before is forgotten.
    fn begin(&mut self) {
        while self.reports.pop().is_ok() {}
        self.waiting.clear();
        self.sent.clear();
        self.thread.begin();
    }

    fn is_gone(&self) -> bool {
        self.thread.is_gone()
    }

    /// Until when an answer is due.
    fn due(&self) -> Option<HostInstant> {
        self.shared.due.get()
    }

    fn order(&mut self, place: usize, order: GeneratorOrder) -> Result<(), BoardError> {
        self.number += 1;
        let pulses = match &order {
            GeneratorOrder::Pulses(edges) => Some(edges.clone()),
            _ => None,
        };
        let epoch = self.shared.epoch.load(Ordering::Acquire);
        let full = pulses.is_some() && self.waiting.len() >= ORDERS;
        if full
            || self
                .asked
                .push(NumberedOrder { number: self.number, output: place as u8, epoch, order })
                .is_err()
        {
            return Err(BoardError::Os { call: Call::Write, code: Errno::AGAIN.raw_os_error() });
        }
        self.waiting.extend(pulses.map(|edges| (self.number, edges)));
        self.shared.orders.ring();
        Ok(())
    }

    fn report(&mut self, report: GeneratorReport, latched: bool, collector: &mut EventCollector<'_>) {
        match report {
            GeneratorReport::Sent { number, sent } => {
                if let Some(edges) = self.take(number) {
                    self.sent.push_back(SentStream::new(edges, sent));
                }
            }
            GeneratorReport::Dropped { number, output, at } => {
                // What was ordered before the start is of no interest.
                let Some(known) = self.outputs.get(usize::from(output)) else { return };
                let (channel, pulses) = (known.channel, known.stream.is_some());
                let edges = self.take(number).map(|edges| edges.len());
                let count = if pulses { edges } else { Some(1) };
                if let Some(count) = count.filter(|_| !latched) {
                    let count = u32::try_from(count).unwrap_or(u32::MAX);
                    collector.dropped(channel, collector.time.at(at), count);
                }
            }
            GeneratorReport::Returned { at } => {
                let at = collector.time.at(at);
                let channels = self.outputs.iter().map(|output| output.channel);
                self.thread.report_return(at, channels, collector);
                self.present(at, collector);
                for output in 0..self.outputs.len() {
                    if let Some(order) = self.outputs[output].wanted.clone().filter(|_| !latched) {
                        // A device that was just opened has room.
                        let _ = self.order(output, order);
                    }
                }
            }
        }
    }

    /// The edges of an order for pulses; `None` where it is not waited for.
    fn take(&mut self, number: u64) -> Option<Arc<[Span]>> {
        let (first, _) = self.waiting.front()?;
        if *first == number { self.waiting.pop_front().map(|(_, edges)| edges) } else { None }
    }

    fn report_edges(&mut self, collector: &mut EventCollector<'_>) -> bool {
        let Some(&KnownOutput { channel, senses, stream: Some((clock, layout)), .. }) = self.outputs.first()
        else {
            return false;
        };
        let mut left = if senses { AT_ONCE } else { 0 };
        while let Some(stream) = self.sent.front_mut() {
            left -= stream.report(clock, layout, channel, left, collector);
            if senses && !stream.is_over() {
                return true;
            }
            self.sent.pop_front();
        }
        false
    }
}

impl DeviceHandle for GeneratorHandle {
    const DRIVES: bool = true;

    fn device(&self) -> &str {
        &self.device
    }

    fn kind(&self) -> &'static str {
        self.kind
    }

    fn channels(&self) -> Vec<ChannelId> {
        self.outputs.iter().map(|output| output.channel).collect()
    }

    /// Asks for rest.
    fn ask_start(&mut self) -> u64 {
        self.ask_safe()
    }

    /// It has when all is at rest: waits as long as pulses that are under way take, too.
    fn await_start(&mut self, request: u64, due: HostInstant, reconnect: bool) -> bool {
        while self.shared.rested.load(Ordering::Acquire) < request {
            let due = self.due().map_or(due, |owed| owed.max(due));
            if self.is_gone() && !reconnect || HostInstant::now() >= due {
                return false;
            }
            self.thread.wait(due);
        }
        self.begin();
        true
    }

    fn loss(&self) -> BoardError {
        let channel = self.outputs.first().map_or(ChannelId(0), |output| output.channel);
        self.thread.loss(channel, self.due())
    }

    /// What all outputs whose changes are reported are at rest.
    fn present(&self, at: Time, collector: &mut EventCollector<'_>) {
        for output in self.outputs.iter().filter(|output| output.senses) {
            collector.changed(output.channel, When::exactly(at), output.safe, Origin::Write);
        }
    }

    fn poll(&mut self, latched: bool, collector: &mut EventCollector<'_>) -> bool {
        while let Some(report) = collector.next(&mut self.reports, stamp_of) {
            self.report(report, latched, collector);
        }
        let due = self.due();
        let channels = self.outputs.iter().map(|output| output.channel);
        self.thread.report_overflow(channels.clone(), collector);
        if self.thread.report_presence(due, channels, collector) {
            self.present(collector.now, collector);
        }
        self.report_edges(collector)
    }

    fn overdue(&self) -> Option<HostInstant> {
        self.thread.overdue(self.due())
    }

    fn ask_safe(&mut self) -> u64 {
        self.outputs.iter_mut().for_each(|output| output.wanted = None);
        self.shared.ask_rest()
    }

    /// Pulses that are under way by then cannot be called back: they end at rest by themselves.
    fn await_safe(&self, request: u64, due: HostInstant) -> Result<(), Errno> {
        while self.shared.rested.load(Ordering::Acquire) < request {
            let now = HostInstant::now();
            if self.is_gone() {
                return Err(Errno::NODEV);
            }
            if now >= due {
                return if self.due().is_some_and(|owed| owed > now) { Ok(()) } else { Err(Errno::TIMEDOUT) };
            }
            self.thread.wait(due);
        }
        Ok(())
    }

    fn lost_channels(&self) -> u32 {
        if self.thread.is_lost() { self.outputs.len() as u32 } else { 0 }
    }

    fn failed_calls(&self) -> u64 {
        self.thread.failed_calls()
    }

    fn takes(&self, place: usize, value: Value) -> Result<(), BoardError> {
        let Some(known) = self.outputs.get(place) else { return Ok(()) };
        match value {
            Value::HighZ => Ok(()),
            // Between two streams the line is at rest, and nothing else can be had.
            Value::Bool(high) if known.stream.is_none() || high == known.safe => Ok(()),
            _ => Err(BoardError::BadValue(known.channel)),
        }
    }

    /// Let go of, it rests.
    fn write(&mut self, place: usize, value: Value) -> Result<(), BoardError> {
        let Some(known) = self.outputs.get_mut(place) else { return Ok(()) };
        let high = match value {
            Value::Bool(high) => high,
            _ => known.safe,
        };
        if known.stream.is_some() {
            // Pulses that did not begin do not; those under way go to their end.
            if !self.waiting.is_empty() {
                self.shared.epoch.fetch_add(1, Ordering::AcqRel);
            }
            return Ok(());
        }
        let before = match known.wanted {
            None => Some(known.safe),
            Some(GeneratorOrder::Level(before)) => Some(before),
            Some(_) => None,
        };
        if before == Some(high) {
            return Ok(());
        }
        known.wanted = Some(GeneratorOrder::Level(high));
        self.order(place, GeneratorOrder::Level(high))
    }

    fn emit(&mut self, place: usize, emission: &Emission) -> Result<(), BoardError> {
        let order = match emission {
            Emission::Square { period, high } => GeneratorOrder::Square { period: *period, high: *high },
            Emission::Pulses(edges) => GeneratorOrder::Pulses(edges.clone()),
        };
        if let Some(known) = self.outputs.get_mut(place) {
            known.wanted = Some(order.clone()).filter(|_| known.stream.is_none());
        }
        self.order(place, order)
    }
}

impl Drop for GeneratorHandle {
    fn drop(&mut self) {
        let _ = self.shared.ask_rest();
        let shared = &self.shared;
        // Pulses that are under way go to their end, and when a call that hangs ends, rest is all that it finds.
        self.thread.end(|| shared.orders.ring(), || shared.due.get());
    }
}

fn stamp_of(report: &GeneratorReport) -> HostInstant {
    match *report {
        GeneratorReport::Sent { sent, .. } => sent.after,
        GeneratorReport::Dropped { at, .. } | GeneratorReport::Returned { at } => at,
    }
}
