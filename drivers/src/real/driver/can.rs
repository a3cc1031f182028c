//! CAN buses.

use document::Diagnostic;

use super::DeviceDriver;
use crate::board::Board;
use crate::bus::Bus;
use crate::can::{self, CanBoard, CanBusSpec};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::real::{Look, RealSpec, Used};

pub(super) struct Can;

impl DeviceDriver for Can {
    fn is_used(&self, spec: &RealSpec) -> bool {
        !spec.can.buses.is_empty()
    }

    fn describe_buses(&self, spec: &RealSpec, buses: &mut Vec<Bus>) {
        can::describe(&spec.can, buses);
    }

    fn probe(&self, table: &ChannelTable, spec: &RealSpec, look: &mut Look) {
        for bus in &spec.can.buses {
            let words = interface(&table.file, bus).map_err(|found| look.found.push(found)).ok();
            look.buses.push((bus.bus, bus.name.clone(), words));
        }
    }

    /// Virtual buses are left out: they are there to join programs.
    fn occupies(&self, spec: &RealSpec) -> Vec<Used> {
        let is_real = |bus: &&CanBusSpec| can::ask(&bus.interface).is_ok_and(|link| !link.is_virtual());
        let real = spec.can.buses.iter().filter(is_real);
        real.map(|bus| Used::whole(format!("net:{}", bus.interface))).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(CanBoard::open(table, &spec.can, spec.limits, context)?))
    }
}

/// An interface in words.
fn interface(file: &str, bus: &CanBusSpec) -> Result<String, Diagnostic> {
    can::find(file, bus)?;
    let mut words = format!("CAN bus on {}", bus.interface);
    // It was there a moment ago.
    if let Ok(link) = can::ask(&bus.interface) {
        words += &can::words(&link);
    }
    if bus.configure {
        words += ", set up by the rig";
    }
    Ok(words)
}
