//! What the rig does with the counters of a board.

use std::path::Path;
use std::sync::Arc;

use document::Diagnostic;
use signal::Span;

use super::{CountSpec, CounterBoard, CounterSpec, CountersSpec};
use crate::board::Board;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::device_limits::DeviceLimits;
use crate::real::{DeviceSpec, Look, Used};

impl DeviceSpec for CountersSpec {
    fn is_used(&self) -> bool {
        !self.counts.is_empty()
    }

    fn serves(&self) -> Vec<ChannelId> {
        self.counts.iter().map(|count| count.channel).collect()
    }

    fn describe(&self, table: &ChannelTable, limits: DeviceLimits, channels: &mut [Channel]) {
        super::describe(table, self, limits.unresponsive_after, Span::ZERO, channels);
    }

    fn probe(&self, table: &ChannelTable, look: &mut Look) {
        for (count, counter) in self.used() {
            let words = match super::look(Path::new("/"), counter) {
                Ok((device, hardware)) => {
                    let function = counter.function.map_or(&*hardware.function, |function| function.kernel());
                    Some(format!("count {} of {}, {function}", hardware.number, super::named(&device)))
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
    fn occupies(&self) -> Vec<Used> {
        let device = |(_, counter): (_, &CounterSpec)| {
            let (device, count) = super::look(Path::new("/"), counter).ok()?;
            let whole = !counter.events.is_empty();
            let lines = (!whole).then(|| vec![u32::from(count.number)]);
            Some(Used { device: device.number, lines })
        };
        self.used().filter_map(device).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(CounterBoard::open(table, self, limits, context)?))
    }

    fn with_channels(&self, number: &dyn Fn(ChannelId) -> Option<ChannelId>) -> Arc<dyn DeviceSpec> {
        let count = |count: &CountSpec| Some(CountSpec { channel: number(count.channel)?, ..*count });
        let counts = self.counts.iter().filter_map(count).collect();
        Arc::new(CountersSpec { counters: self.counters.clone(), counts })
    }
}
