//! The kinds of devices that a board of this machine can have: one entry each.

mod adc;
mod can;
mod counter;
mod generator;
mod gpio;
mod serial;

use document::Diagnostic;

use super::{Look, RealSpec, Used};
use crate::board::Board;
use crate::bus::Bus;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;

/// What the rig does with devices of one kind.
pub(super) trait DeviceDriver: Sync {
    /// Whether the board has such devices.
    fn is_used(&self, spec: &RealSpec) -> bool;

    /// The channels that they serve.
    fn serves(&self, spec: &RealSpec) -> Vec<ChannelId> {
        let _ = spec;
        Vec::new()
    }

    /// Describes their channels, before anything is known of the devices.
    fn describe(&self, table: &ChannelTable, spec: &RealSpec, channels: &mut [Channel]) {
        let _ = (table, spec, channels);
    }

    /// Describes their buses, before anything is known of the devices.
    fn describe_buses(&self, spec: &RealSpec, buses: &mut Vec<Bus>) {
        let _ = (spec, buses);
    }

    /// Looks whether they are there, free and set up as the file says. Nothing is set up, and nothing is kept.
    fn probe(&self, table: &ChannelTable, spec: &RealSpec, look: &mut Look);

    /// The devices of this machine that they are, each of which one user has at a time. What is missing is left out.
    fn occupies(&self, spec: &RealSpec) -> Vec<Used>;

    /// Finds and opens them, outputs at their safe values.
    ///
    /// # Errors
    /// All that is not there, not free, not permitted or cannot be done, by place.
    fn open(
        &self,
        table: &ChannelTable,
        spec: &RealSpec,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>>;
}

/// Every kind, in the order in which a board is opened.
pub(super) const DRIVERS: [&dyn DeviceDriver; 6] =
    [&gpio::Gpio, &can::Can, &serial::Serial, &adc::Adcs, &counter::Counters, &generator::Generators];
