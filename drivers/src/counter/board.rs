//! The counters of a board.

use std::path::Path;

use document::Diagnostic;
use signal::{Span, Value};

use super::handle::CounterHandle;
use super::{CountSpec, Counter, CounterSpec, CountersSpec, KernelCounter};
use crate::channel::{Channel, ChannelId, FaultSet, TimestampSource};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::device_board::{DeviceBoard, Reopen, all_opened};
use crate::device_limits::DeviceLimits;
use crate::refusal::Refusal;
use crate::thread::not_started;

/// Describes the channels behind which counters count.
pub fn describe(
    table: &ChannelTable,
    spec: &CountersSpec,
    unresponsive_after: Span,
    resolution: Span,
    channels: &mut [Channel],
) {
    for count in &spec.counts {
        let at = usize::from(count.channel.0);
        let (Some(channel), Some(known), Some(counter)) =
            (channels.get_mut(at), table.channels.get(at), spec.counters.get(count.counter))
        else {
            continue;
        };
        let period = counter.period;
        let (timestamp, resolution, shortest) = match counter.reports_steps() {
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

fn open(counter: &CounterSpec) -> Result<Box<dyn Counter>, Refusal> {
    Ok(Box::new(KernelCounter::open(Path::new("/"), counter)?))
}

/// A counter with the channel that it was opened for, and how it is opened again.
#[derive(Debug)]
pub struct CounterSource {
    /// The counter.
    pub counter: Box<dyn Counter>,
    /// Its channel.
    pub channel: ChannelId,
    /// How it is opened again.
    pub reopen: Reopen<dyn Counter>,
}

/// Counters as a board: its channels say how far they have counted since the start.
pub type CounterBoard = DeviceBoard<CounterHandle>;

impl CounterBoard {
    /// Opens the board's counters.
    ///
    /// # Errors
    /// All that is not there, not permitted or cannot be done, by place.
    pub fn open(
        table: &ChannelTable,
        spec: &CountersSpec,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<CounterBoard, Vec<Diagnostic>> {
        let source = |(count, spec): (&CountSpec, &CounterSpec)| {
            let source = open(spec).map(|counter| {
                let of = spec.clone();
                let reopen = Reopen::new(move || open(&of).ok());
                CounterSource { counter, channel: count.channel, reopen }
            });
            (spec.place.clone(), source)
        };
        let sources = all_opened(&table.file, spec.used().map(source))?;
        CounterBoard::on(table, spec, limits, context, sources)
            .map_err(|error| not_started(&table.file, "the thread of a counter", &error))
    }

    /// A board of counters that are open.
    ///
    /// # Errors
    /// A thread could not be started.
    pub fn on(
        table: &ChannelTable,
        spec: &CountersSpec,
        limits: DeviceLimits,
        context: &BoardContext,
        sources: Vec<CounterSource>,
    ) -> std::io::Result<CounterBoard> {
        let mut channels = table.blank();
        describe(table, spec, limits.unresponsive_after, context.resolution, &mut channels);
        let mut devices = Vec::new();
        for source in sources {
            let count = spec.counts.iter().find(|count| count.channel == source.channel);
            let Some(counter) = count.and_then(|count| spec.counters.get(count.counter)) else {
                continue;
            };
            devices.push(CounterHandle::start(source, counter, limits, context)?);
        }
        Ok(DeviceBoard::new(channels, limits, context, devices, Vec::new()))
    }
}
