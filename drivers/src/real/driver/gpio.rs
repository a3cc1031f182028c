//! GPIO lines.

use document::Diagnostic;

use super::DeviceDriver;
use crate::board::Board;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::gpio::{self, GpioBoard};
use crate::real::{Look, RealSpec, Used};

pub(super) struct Gpio;

impl DeviceDriver for Gpio {
    fn is_used(&self, spec: &RealSpec) -> bool {
        !spec.gpio.lines.is_empty()
    }

    fn serves(&self, spec: &RealSpec) -> Vec<ChannelId> {
        spec.gpio.lines.iter().map(|line| line.channel).collect()
    }

    fn describe(&self, table: &ChannelTable, spec: &RealSpec, channels: &mut [Channel]) {
        gpio::describe(table, &spec.gpio, channels);
    }

    /// Lines are looked at one by one by [`gpio::find`]: a look has nothing to add.
    fn probe(&self, _table: &ChannelTable, _spec: &RealSpec, _look: &mut Look) {}

    fn occupies(&self, spec: &RealSpec) -> Vec<Used> {
        let lines = gpio::uses(&spec.gpio).into_iter();
        lines.map(|(chip, lines)| Used { device: chip.name, lines: Some(lines) }).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(GpioBoard::open(table, &spec.gpio, spec.limits, context)?))
    }
}
