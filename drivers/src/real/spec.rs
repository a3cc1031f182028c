//! What a board file says of a board of real devices.

use crate::adc::AdcsSpec;
use crate::can::CanSpec;
use crate::counter::CountersSpec;
use crate::generator::GeneratorsSpec;
use crate::gpio::GpioSpec;
use crate::real::WireRelays;
use crate::serial::SerialSpec;
use signal::Span;

/// How long a call on a device may last, where the board file does not say.
pub const UNRESPONSIVE_AFTER: Span = Span::from_millis(100);

/// A board of real devices as a board file describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct RealSpec {
    /// How long a call on a device may last before the device counts as lost.
    pub unresponsive_after: Span,
    /// A device that went away is taken back when it is there again.
    pub reconnect: bool,
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
