//! What a board file says of a board of real devices.

use crate::adc::AdcsSpec;
use crate::can::CanSpec;
use crate::counter::CountersSpec;
use crate::device_limits::DeviceLimits;
use crate::generator::GeneratorsSpec;
use crate::gpio::GpioSpec;
use crate::real::WireRelays;
use crate::serial::SerialSpec;

/// A board of real devices as a board file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct RealSpec {
    /// How long a device may take, and what becomes of one that is gone.
    pub limits: DeviceLimits,
    /// GPIO chips and lines.
    pub gpio: GpioSpec,
    /// Converters and their inputs.
    pub converters: AdcsSpec,
    /// Counters and their channels.
    pub counters: CountersSpec,
    /// Generators and their outputs.
    pub generators: GeneratorsSpec,
    /// CAN buses.
    pub can: CanSpec,
    /// Relays that put faults on wires.
    pub relays: Vec<WireRelays>,
    /// Serial lines.
    pub serial: Vec<SerialSpec>,
}
