//! A modelled bus, as data.

use crate::bus::BusId;

/// A simulated bus as data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusSpec {
    /// Its name in the board file.
    pub name: String,
    /// Bit rate of the arbitration and of classic frames, bit/s, above 0.
    pub bitrate: u32,
    /// Bit rate of the data of CAN FD frames; `None`: the bus takes classic frames only.
    pub data_bitrate: Option<u32>,
    /// A bus before it in the list whose wire it is on.
    pub joins: Option<BusId>,
}
