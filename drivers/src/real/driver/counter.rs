//! Counters.

use std::path::Path;

use document::Diagnostic;
use signal::Span;

use super::DeviceDriver;
use crate::board::Board;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::counter::{self, CountSpec, CounterBoard, CounterSpec};
use crate::real::{Look, RealSpec, Used};

pub(super) struct Counters;

/// The counts of a board with their counters.
fn used(spec: &RealSpec) -> impl Iterator<Item = (&CountSpec, &CounterSpec)> {
    let counter = |count: &CountSpec| spec.counters.counters.get(count.counter);
    spec.counters.counts.iter().filter_map(move |count| Some((count, counter(count)?)))
}

impl DeviceDriver for Counters {
    fn is_used(&self, spec: &RealSpec) -> bool {
        !spec.counters.counts.is_empty()
    }

    fn serves(&self, spec: &RealSpec) -> Vec<ChannelId> {
        spec.counters.counts.iter().map(|count| count.channel).collect()
    }

    fn describe(&self, table: &ChannelTable, spec: &RealSpec, channels: &mut [Channel]) {
        counter::describe(table, &spec.counters, spec.limits.unresponsive_after, Span::ZERO, channels);
    }

    fn probe(&self, table: &ChannelTable, spec: &RealSpec, look: &mut Look) {
        for (count, counter) in used(spec) {
            let words = match counter::look(Path::new("/"), counter) {
                Ok((device, hardware)) => {
                    let function = counter.function.map_or(&*hardware.function, |function| function.kernel());
                    Some(format!("count {} of {}, {function}", hardware.number, counter::named(&device)))
                }
                Err(refusal) => {
                    look.found.push(refusal.finding(&table.file, counter.place.clone()));
                    None
                }
            };
            look.inputs.push((count.channel, words));
        }
    }

    /// The other counts of a device are free, unless it reports events: those go to one user alone.
    fn occupies(&self, spec: &RealSpec) -> Vec<Used> {
        let device = |(_, counter): (_, &CounterSpec)| {
            let (device, count) = counter::look(Path::new("/"), counter).ok()?;
            let whole = !counter.events.is_empty();
            let lines = (!whole).then(|| vec![u32::from(count.number)]);
            Some(Used { device: device.number, lines })
        };
        used(spec).filter_map(device).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(CounterBoard::open(table, &spec.counters, spec.limits, context)?))
    }
}
