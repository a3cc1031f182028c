//! What the rig does with the GPIO lines of a board.

use std::sync::Arc;

use document::Diagnostic;

use super::{GpioBoard, GpioSpec, LineSpec};
use crate::board::Board;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::device_limits::DeviceLimits;
use crate::real::{DeviceSpec, Look, Used};

impl DeviceSpec for GpioSpec {
    fn is_used(&self) -> bool {
        !self.lines.is_empty()
    }

    fn serves(&self) -> Vec<ChannelId> {
        self.lines.iter().map(|line| line.channel).collect()
    }

    fn describe(&self, table: &ChannelTable, _limits: DeviceLimits, channels: &mut [Channel]) {
        super::describe(table, self, channels);
    }

    /// Lines are looked at one by one by [`find`](super::find): a look has nothing to add.
    fn probe(&self, _table: &ChannelTable, _look: &mut Look) {}

    fn occupies(&self) -> Vec<Used> {
        let lines = super::uses(self).into_iter();
        lines.map(|(chip, lines)| Used { device: chip.name, lines: Some(lines) }).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(GpioBoard::open(table, self, limits, context)?))
    }

    fn with_channels(&self, number: &dyn Fn(ChannelId) -> Option<ChannelId>) -> Arc<dyn DeviceSpec> {
        let line = |line: &LineSpec| Some(LineSpec { channel: number(line.channel)?, ..line.clone() });
        let lines = self.lines.iter().filter_map(line).collect();
        Arc::new(GpioSpec { lines, ..self.clone() })
    }
}
