//! Serial lines.

use document::Diagnostic;
use rustix::fs::{Access, access};

use super::DeviceDriver;
use crate::board::Board;
use crate::bus::Bus;
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::real::{Look, RealSpec, Used};
use crate::serial::{self, OpenError, SerialBoard, SerialSpec};

pub(super) struct Serial;

impl DeviceDriver for Serial {
    fn is_used(&self, spec: &RealSpec) -> bool {
        !spec.serial.is_empty()
    }

    fn describe_buses(&self, spec: &RealSpec, buses: &mut Vec<Bus>) {
        serial::describe(&spec.serial, buses);
    }

    fn probe(&self, table: &ChannelTable, spec: &RealSpec, look: &mut Look) {
        for line in &spec.serial {
            let words = port(line).map_err(|error| {
                look.found.push(serial::refused(&error).finding(&table.file, line.place.clone()));
            });
            look.buses.push((line.bus, line.name.clone(), words.ok()));
        }
    }

    /// Ports that the board file shares with others are left out.
    fn occupies(&self, spec: &RealSpec) -> Vec<Used> {
        let exclusive = spec.serial.iter().filter(|line| line.port.exclusive);
        exclusive.filter_map(|line| Used::behind(&line.port.path)).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(SerialBoard::open(table, &spec.serial, spec.limits, context)?))
    }
}

/// A port in words.
fn port(line: &SerialSpec) -> Result<String, OpenError> {
    let path = &line.port.path;
    access(path, Access::READ_OK | Access::WRITE_OK).map_err(|errno| {
        OpenError::Call(serial::SerialError::new(path, serial::SerialCall::Open, &errno.into()))
    })?;
    if line.port.exclusive && !crate::holder::holders(path).is_empty() {
        return Err(OpenError::Busy(path.clone()));
    }
    Ok(format!("serial line on {}, {} Bd, free", path.display(), line.port.line.baud))
}
