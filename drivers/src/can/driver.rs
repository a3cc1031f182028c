//! What the rig does with the CAN buses of a board.

use std::sync::Arc;

use document::Diagnostic;

use super::{CanBoard, CanBusSpec, CanSpec};
use crate::board::Board;
use crate::bus::Bus;
use crate::channel::ChannelId;
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::device_limits::DeviceLimits;
use crate::real::{DeviceSpec, Look, Used};

impl DeviceSpec for CanSpec {
    fn is_used(&self) -> bool {
        !self.buses.is_empty()
    }

    fn describe_buses(&self, buses: &mut Vec<Bus>) {
        super::describe(self, buses);
    }

    fn probe(&self, table: &ChannelTable, look: &mut Look) {
        for bus in &self.buses {
            let words = interface(&table.file, bus).map_err(|found| look.found.push(found)).ok();
            look.buses.push((bus.bus, bus.name.clone(), words));
        }
    }

    /// Virtual buses are left out: they are there to join programs.
    fn occupies(&self) -> Vec<Used> {
        let is_real = |bus: &&CanBusSpec| super::ask(&bus.interface).is_ok_and(|link| !link.is_virtual());
        let real = self.buses.iter().filter(is_real);
        real.map(|bus| Used::whole(format!("net:{}", bus.interface))).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(CanBoard::open(table, self, limits, context)?))
    }

    fn with_channels(&self, _number: &dyn Fn(ChannelId) -> Option<ChannelId>) -> Arc<dyn DeviceSpec> {
        Arc::new(self.clone())
    }
}

/// An interface in words.
fn interface(file: &str, bus: &CanBusSpec) -> Result<String, Diagnostic> {
    super::find(file, bus)?;
    let mut words = format!("CAN bus on {}", bus.interface);
    // It was there a moment ago.
    if let Ok(link) = super::ask(&bus.interface) {
        words += &super::words(&link);
    }
    if bus.configure {
        words += ", set up by the rig";
    }
    Ok(words)
}
