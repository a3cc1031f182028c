//! The counters of a board.

use std::path::Path;

use document::Diagnostic;
use host::monotonic;
use signal::{Span, Time, Value, When};

use super::device::Opener;
use super::handle::CounterHandle;
use super::{Counter, KernelCounter};
use crate::event_collector::EventCollector;
use crate::file::BoardFile;
use crate::real::RealSpec;
use crate::run_state::{RunState, START, drives_none};
use crate::thread::not_started;
use crate::{
    Board, BoardContext, BoardError, BoardEvent, Channel, ChannelId, Descriptions, FaultSet, Health,
    TimestampSource,
};

/// Describes the channels behind which counters count.
pub fn describe(file: &BoardFile, spec: &RealSpec, resolution: Span, channels: &mut [Channel]) {
    let (unresponsive_after, spec) = (spec.unresponsive_after, &spec.counters);
    for count in &spec.counts {
        let at = usize::from(count.channel.0);
        let (Some(channel), Some(known), Some(counter)) =
            (channels.get_mut(at), file.circuit.channels.get(at), spec.counters.get(count.counter))
        else {
            continue;
        };
        let period = counter.period;
        let (timestamp, resolution, shortest) = match counter.tells_steps() {
            true => (TimestampSource::Kernel, resolution, Span::ZERO),
            // No pulse is missed, but a count that was there and is gone again between two readings.
            false => (TimestampSource::Sampled { period }, period, counter.longest(unresponsive_after)),
        };
        *channel = Channel {
            name: known.name.clone(),
            kind: known.kind.clone(),
            drives: false,
            senses: true,
            timestamp,
            resolution,
            shortest_pulse: shortest,
            deadband: 0.0,
            max_pulse_hz: 0,
            emits: None,
            counts_hz: counter.counts_hz,
            faults: FaultSet::NONE,
            safe: Value::HighZ,
        };
    }
}

/// A counter with the channel that it was opened for, and how it is opened again.
pub struct Source {
    /// The counter.
    pub counter: Box<dyn Counter>,
    /// Its channel.
    pub channel: ChannelId,
    /// Opens it again when it was gone; is called on the device's thread.
    pub again: Opener,
}

impl std::fmt::Debug for Source {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Source").field("counter", &self.counter).field("channel", &self.channel).finish()
    }
}

/// Counters as a board: its channels tell how far they have counted since the start. A thread of each counter reads it; no
/// call of the board waits for one but its start.
#[derive(Debug)]
pub struct CounterBoard {
    channels: Vec<Channel>,
    unresponsive_after: Span,
    reconnect: bool,
    context: BoardContext,
    devices: Vec<CounterHandle>,
    run: RunState,
}

impl CounterBoard {
    /// Opens the board's counters.
    ///
    /// # Errors
    /// All that is not there, not permitted or cannot be done, by place.
    pub fn open(
        file: &BoardFile,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<CounterBoard, Vec<Diagnostic>> {
        let (mut sources, mut found) = (Vec::new(), Vec::new());
        for count in &spec.counters.counts {
            let Some(counter) = spec.counters.counters.get(count.counter) else { continue };
            match KernelCounter::open(Path::new("/"), counter) {
                Ok(opened) => {
                    let of = counter.clone();
                    let again = move || -> Option<Box<dyn Counter>> {
                        Some(Box::new(KernelCounter::open(Path::new("/"), &of).ok()?))
                    };
                    let (counter, channel) = (Box::new(opened), count.channel);
                    sources.push(Source { counter, channel, again: Box::new(again) });
                }
                Err(refusal) => found.push(refusal.finding(&file.name, counter.place.clone())),
            }
        }
        if !found.is_empty() {
            return Err(found);
        }
        CounterBoard::on(file, spec, context, sources)
            .map_err(|error| not_started(file, "the thread of a counter", &error))
    }

    /// A board of counters that are open.
    ///
    /// # Errors
    /// A thread could not be started.
    pub fn on(
        file: &BoardFile,
        spec: &RealSpec,
        context: &BoardContext,
        sources: Vec<Source>,
    ) -> std::io::Result<CounterBoard> {
        let mut channels = crate::real::blank(file);
        describe(file, spec, context.resolution, &mut channels);
        let mut devices = Vec::new();
        for source in sources {
            let count = spec.counters.counts.iter().find(|count| count.channel == source.channel);
            let Some(counter) = count.and_then(|count| spec.counters.counters.get(count.counter)) else {
                continue;
            };
            let around = (&context.bell, context.realtime, context.resolution);
            devices.push(CounterHandle::start(
                source,
                counter,
                (spec.unresponsive_after, spec.reconnect),
                around,
            )?);
        }
        Ok(CounterBoard {
            channels,
            unresponsive_after: spec.unresponsive_after,
            reconnect: spec.reconnect,
            context: context.clone(),
            devices,
            run: RunState::default(),
        })
    }
}

impl Board for CounterBoard {
    fn inner(&self) -> Option<&dyn Board> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        None
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Waits until every count was read, as long as a counter may be silent or two seconds.
    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.end();
        let starts: Vec<u64> = self.devices.iter_mut().map(CounterHandle::ask_start).collect();
        let due = monotonic().saturating_add(self.unresponsive_after.max(START).as_nanos());
        for (device, start) in self.devices.iter_mut().zip(starts) {
            if !device.await_start(start, due, self.reconnect) {
                return Err(device.is_lost());
            }
        }
        self.run.begin(now);
        self.run.owes_start();
        Ok(())
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        drives_none(&self.channels, writes)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        self.run.come_to(now)?;
        let mut collector = EventCollector::new(out, &self.context.time, now);
        if let Some(start) = self.run.take_fresh() {
            self.devices.iter().for_each(|device| device.present(When::exactly(start), &mut collector));
        }
        for device in &mut self.devices {
            device.poll(&mut collector);
        }
        self.run.told(collector);
        Ok(())
    }

    /// What lies ahead of the last poll, and when a counter that owes an answer counts as lost.
    fn next_event(&self) -> Option<Time> {
        let owed = self.devices.iter().filter_map(CounterHandle::overdue);
        self.run.next_event(&self.context.time, owed)
    }

    /// Nothing is driven: the counters go on by themselves, and nobody looks until the next start.
    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.run.latch(now);
        self.devices.iter().for_each(CounterHandle::rest);
        Ok(())
    }

    fn health(&self) -> Health {
        Health {
            lost: self.devices.iter().filter(|device| device.has_gone()).count() as u32,
            dropped: self.run.dropped(),
            failed_calls: self.devices.iter().map(CounterHandle::failed_calls).sum(),
            latched_safe: self.run.is_latched(),
            ..Health::default()
        }
    }

    fn descriptions(&self) -> Option<&dyn Descriptions> {
        Some(self)
    }
}

impl Descriptions for CounterBoard {
    fn device(&self, channel: ChannelId) -> Option<&str> {
        let mut devices = self.devices.iter();
        devices.find(|device| device.channel == channel).map(|device| device.device.as_str())
    }

    fn noise(&self, _channel: ChannelId) -> Option<f64> {
        None
    }
}
