//! What a board file says of a board of real devices.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use document::Diagnostic;

use super::{Look, Used, WireRelays};
use crate::board::Board;
use crate::bus::Bus;
use crate::channel::{Channel, ChannelId};
use crate::channel_table::ChannelTable;
use crate::context::BoardContext;
use crate::device_limits::DeviceLimits;

/// The devices of one kind that a board has, and what the rig does with them.
pub trait DeviceSpec: Any + Debug + Send + Sync {
    /// Whether the board has such devices.
    fn is_used(&self) -> bool;

    /// The channels that they serve.
    fn serves(&self) -> Vec<ChannelId> {
        Vec::new()
    }

    /// Describes their channels, before anything is known of the devices.
    fn describe(&self, table: &ChannelTable, limits: DeviceLimits, channels: &mut [Channel]) {
        let _ = (table, limits, channels);
    }

    /// Describes their buses, before anything is known of the devices.
    fn describe_buses(&self, buses: &mut Vec<Bus>) {
        let _ = buses;
    }

    /// Looks whether they are there, free and set up as the file says. Nothing is set up, and nothing is kept.
    fn probe(&self, table: &ChannelTable, look: &mut Look);

    /// The devices of this machine that they are, each of which one user has at a time. What is missing is left out.
    fn occupies(&self) -> Vec<Used>;

    /// Finds and opens them, outputs at their safe values.
    ///
    /// # Errors
    /// All that is not there, not free, not permitted or cannot be done, by place.
    fn open(
        &self,
        table: &ChannelTable,
        limits: DeviceLimits,
        context: &BoardContext,
    ) -> Result<Box<dyn Board>, Vec<Diagnostic>>;

    /// The same devices with some of their channels alone, each by the number that it gets, and with all their buses.
    fn with_channels(&self, number: &dyn Fn(ChannelId) -> Option<ChannelId>) -> Arc<dyn DeviceSpec>;
}

/// A board of real devices as a board file describes it.
#[derive(Clone, Debug)]
pub struct RealSpec {
    /// How long a device may take, and what becomes of one that is gone.
    pub limits: DeviceLimits,
    /// Its devices, by kind, in the order in which they are opened.
    pub devices: Vec<Arc<dyn DeviceSpec>>,
    /// Relays that put faults on wires.
    pub relays: Vec<WireRelays>,
}

impl RealSpec {
    /// The devices of this kind.
    pub fn of<S: DeviceSpec>(&self) -> Option<&S> {
        self.devices.iter().find_map(|devices| (devices.as_ref() as &dyn Any).downcast_ref())
    }
}
