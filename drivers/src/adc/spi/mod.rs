//! Converters on an SPI bus, read through `spidev`: one ioctl for a sweep over all inputs.

mod ads868x;
mod choose;
mod codec;
mod device;
mod max111x;
mod mcp3x0x;
mod sweep;

pub use ads868x::{ADS8684, ADS8684_MANUAL, ADS8688, ADS8688_MANUAL};
pub(crate) use choose::part;
pub use choose::{AdcPart, PARTS, SpiSpec, choose};
pub use codec::{Bytes, Chosen, Codec, FRAME, Frame, Span, SpiInput};
pub(crate) use device::claim;
pub use device::{SpiAdc, open};
pub use max111x::{MAX1110, MAX1111, MAX1112, MAX1113};
pub use mcp3x0x::{MCP3004, MCP3008, MCP3204, MCP3208};
pub use sweep::Sweep;
