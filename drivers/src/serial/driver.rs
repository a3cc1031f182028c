//! What the rig does with the serial lines of a board.

use std::sync::Arc;

use document::Diagnostic;
use rustix::fs::{Access, access};

use super::{OpenError, SerialBoard, SerialCall, SerialError, SerialLinesSpec, SerialSpec};
use crate::board::Board;
use crate::bus::Bus;
use crate::channel::ChannelId;
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::device_file::device_file;
use crate::device_limits::DeviceLimits;
use crate::real::{DeviceSpec, Look, Used};

impl DeviceSpec for SerialLinesSpec {
    fn is_used(&self) -> bool {
        !self.lines.is_empty()
    }

    fn describe_buses(&self, buses: &mut Vec<Bus>) {
        super::describe(&self.lines, buses);
    }

    fn probe(&self, table: &ChannelTable, look: &mut Look) {
        for line in &self.lines {
            let words = port(line).map_err(|error| {
                look.found.push(super::refused(&error).finding(&table.file, line.place.clone()));
            });
            look.buses.push((line.bus, line.name.clone(), words.ok()));
        }
    }

    /// Ports that the board file shares with others are left out.
    fn occupies(&self) -> Vec<Used> {
        let exclusive = self.lines.iter().filter(|line| line.port.exclusive);
        exclusive.filter_map(|line| Used::behind(&line.port.path)).collect()
    }

    fn open(
        &self,
        table: &ChannelTable,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>> {
        Ok(Box::new(SerialBoard::open(table, &self.lines, limits, context)?))
    }

    fn with_channels(&self, _number: &dyn Fn(ChannelId) -> Option<ChannelId>) -> Arc<dyn DeviceSpec> {
        Arc::new(self.clone())
    }
}

/// A port in words.
fn port(line: &SerialSpec) -> Result<String, OpenError> {
    let path = &line.port.path;
    access(path, Access::READ_OK | Access::WRITE_OK)
        .map_err(|errno| OpenError::Call(SerialError::new(path, SerialCall::Open, &errno.into())))?;
    if !device_file(path).may_be("tty") {
        return Err(OpenError::NoPort(path.clone()));
    }
    if line.port.exclusive && !crate::holder::holders(path).is_empty() {
        return Err(OpenError::Busy(path.clone()));
    }
    Ok(format!("serial line on {}, {} Bd, free", path.display(), line.port.line.baud))
}
