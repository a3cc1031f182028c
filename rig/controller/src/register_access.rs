//! How protocols reach the controller's memory, and what it says of itself.

use crate::registers::RegisterError;
use crate::state::State;
use signal::Area;

/// The memory of a controller as protocols see it, at the one instant at which a step takes effect.
///
/// The documents promise consistency of single words, and of whole blocks only where they say so (ethernet:MBS-07,
/// ethernet:MSD-08, serial-can:MSS-06). Everything that one step reads or writes is of one instant, between two operations of
/// the application. An endpoint that is to show how words of one request differ asks for a step for each.
pub trait RegisterAccess {
    /// The state of the controller.
    fn state(&self) -> State;

    /// Reads registers from `first` on: %MW, the system variables and the relocation table (controller:MEM-06).
    ///
    /// # Errors
    /// [`RegisterError`]; `out` is then not to be used.
    fn read_registers(&self, first: u16, out: &mut [u16]) -> Result<(), RegisterError>;

    /// Writes registers from `first` on; all of them or none (controller:MEM-07).
    ///
    /// # Errors
    /// [`RegisterError`]; nothing is written then.
    fn write_registers(&mut self, first: u16, values: &[u16]) -> Result<(), RegisterError>;

    /// Reads bits of an area from bit `first` on, counted from %IX0.0, %QX0.0 or %MX0.0 (ethernet:MBS-06).
    ///
    /// # Errors
    /// [`RegisterError`] beyond the end of the area; `out` is then not to be used.
    fn read_bits(&self, area: Area, first: u32, out: &mut [bool]) -> Result<(), RegisterError>;

    /// Writes bits of %Q or %M; all of them or none. A task that writes the same bit of %Q overrides it with its next cycle
    /// (ethernet:MBS-06).
    ///
    /// # Errors
    /// [`RegisterError`] beyond the end of the area, and for %I; nothing is written then.
    fn write_bits(&mut self, area: Area, first: u32, values: &[bool]) -> Result<(), RegisterError>;

    /// What the controller is.
    fn identification(&self) -> Identification;
}

/// What a controller says of itself (ethernet:MBS-30).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identification {
    /// The vendor's name.
    pub vendor: &'static str,
    /// The vendor's number (controller:SYS-06).
    pub vendor_id: u16,
    /// The reference, as in `TM241CEC24T`.
    pub reference: &'static str,
    /// Its number.
    pub product_id: u16,
    /// The version of the firmware, as in 1.0.0.0.
    pub firmware: [u8; 4],
    /// The serial number.
    pub serial_number: u32,
}
