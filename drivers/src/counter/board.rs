//! The counters of a board.

use std::path::Path;

use document::Diagnostic;
use signal::{Span, Value};

use super::device::Opener;
use super::handle::CounterHandle;
use super::{Counter, CountersSpec, KernelCounter};
use crate::channel::{Channel, ChannelId, FaultSet, TimestampSource};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::device_board::DeviceBoard;
use crate::device_limits::DeviceLimits;
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
        let (mut sources, mut found) = (Vec::new(), Vec::new());
        for count in &spec.counts {
            let Some(counter) = spec.counters.get(count.counter) else { continue };
            match KernelCounter::open(Path::new("/"), counter) {
                Ok(opened) => {
                    let of = counter.clone();
                    let again = move || -> Option<Box<dyn Counter>> {
                        Some(Box::new(KernelCounter::open(Path::new("/"), &of).ok()?))
                    };
                    let (counter, channel) = (Box::new(opened), count.channel);
                    sources.push(Source { counter, channel, again: Box::new(again) });
                }
                Err(refusal) => found.push(refusal.finding(&table.file, counter.place.clone())),
            }
        }
        if !found.is_empty() {
            return Err(found);
        }
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
        sources: Vec<Source>,
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
