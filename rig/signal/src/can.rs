//! Frames of CAN buses, and how controllers take part in them (ISO 11898-1).

use std::fmt;

/// The most data bytes of a CAN frame: 8 on classic CAN, 64 with CAN FD (ISO 11898-1).
pub const MAX_CAN_DATA: usize = 64;

/// A CAN frame.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct CanFrame {
    /// Identifier: 11 bits, or 29 of an extended one.
    pub id: u32,
    /// The identifier has 29 bits.
    pub extended: bool,
    /// A remote frame: it asks for data and has none. Never with `fd`.
    pub remote: bool,
    /// A CAN FD frame.
    pub fd: bool,
    /// Its data came at the data bit rate (CAN FD).
    pub brs: bool,
    /// Its sender is error-passive (CAN FD).
    pub esi: bool,
    /// Number of data bytes; of a remote frame the number that is asked for.
    pub len: u8,
    /// The data; 0 after `len`.
    pub data: [u8; MAX_CAN_DATA],
}

impl CanFrame {
    /// A classic data frame. `None` where the identifier does not fit, or the data have more than 8 bytes.
    pub fn classic(id: u32, extended: bool, data: &[u8]) -> Option<CanFrame> {
        let most = if extended { 0x1FFF_FFFF } else { 0x7FF };
        if id > most || data.len() > 8 {
            return None;
        }
        let mut bytes = [0; MAX_CAN_DATA];
        bytes[..data.len()].copy_from_slice(data);
        let len = data.len() as u8;
        Some(CanFrame { id, extended, remote: false, fd: false, brs: false, esi: false, len, data: bytes })
    }

    /// Its data.
    pub fn data(&self) -> &[u8] {
        let len = if self.remote { 0 } else { usize::from(self.len).min(MAX_CAN_DATA) };
        &self.data[..len]
    }
}

impl fmt::Debug for CanFrame {
    /// `701#05`, as analyzers write it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = if self.extended { 8 } else { 3 };
        write!(f, "{:0width$X}#", self.id)?;
        if self.remote {
            return write!(f, "R{}", self.len);
        }
        if self.fd {
            write!(f, "#{:X}", u8::from(self.brs) | u8::from(self.esi) << 1)?;
        }
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

/// How a CAN controller takes part in its bus (ISO 11898-1, fault confinement).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BusState {
    /// As it should.
    ErrorActive,
    /// One of its error counters has reached 96.
    ErrorWarning,
    /// One of its error counters has reached 128.
    ErrorPassive,
    /// It takes no part any more.
    BusOff,
    /// It is switched off, or its cable is gone.
    Stopped,
}

/// What went wrong on a CAN bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BusError {
    /// Nobody acknowledged a frame.
    NoAck,
    /// Another node won the arbitration; the bit at which it was lost, where it is known.
    LostArbitration(Option<u8>),
    /// A bit, stuff, form or CRC error.
    Protocol,
    /// The controller lost frames that it had received.
    ReceiveOverflow,
    /// The controller lost frames that it was to send.
    SendOverflow,
    /// A frame was not sent in time.
    SendTimeout,
    /// The transceiver reports a fault.
    Transceiver,
    /// Anything else that the controller reports.
    Other,
}
