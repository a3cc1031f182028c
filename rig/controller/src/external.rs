//! What goes wrong around the controller and in it: external errors (controller:ERR-01), faults at the outputs, the supply
//! of inputs and outputs, errors of its own. What goes wrong around it does not change the state by itself
//! (controller:TR-23).

use profile::ModuleType;

/// Something that goes wrong in the world around the controller, or is over, or in the controller itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// A short circuit at an output; it takes a current while the output is on.
    ShortCircuit {
        /// The output: n for Qn.
        output: usize,
        /// TRUE when it begins, FALSE when it is over.
        on: bool,
    },
    /// An output is too hot.
    OverTemperature {
        /// The output: n for Qn.
        output: usize,
        /// TRUE when it begins, FALSE when it is over.
        on: bool,
    },
    /// The supply of inputs and outputs is there, or not.
    IoSupply(bool),
    /// A part outside of the controller is in error: its bit of PLC_R.i_lwSystemFault_1 (controller:SYS-04).
    ExternalError {
        /// The bit.
        bit: u8,
        /// TRUE when it begins, FALSE when it is over.
        on: bool,
    },
    /// The controller itself is in error (controller:ERR-01, controller:WD-14).
    InternalError(InternalError),
    /// Something is wrong with a module on the expansion bus, or is over.
    Module {
        /// Its index in TM3_MODULE_R.
        index: usize,
        /// What is wrong.
        fault: ModuleFault,
    },
    /// The expansion bus has its supply, or not (io:HW-04).
    BusSupply(bool),
    /// Transmitter and receiver of the expansion bus are joined, or not.
    BusLink(bool),
    /// The battery of the clock has another charge (plcsystem:PLCR-05).
    Battery {
        /// Per cent, at most 100; 0 where it is empty or taken out.
        charge: u8,
    },
}

/// What goes wrong with a module on the expansion bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModuleFault {
    /// It does not answer for so many exchanges (io:ERR-01); none until it is said to answer again, which is 0.
    Silent(Option<u32>),
    /// It is pulled out, or put back. Modules after it are not reached in between.
    Pulled(bool),
    /// Another module is in its place; with none, that which was there at first (io:OPT-04, io:OPT-06).
    Replaced(Option<&'static ModuleType>),
    /// It does not answer and disturbs the exchange with the modules beside it, or stops (io:ERR-15).
    Disturbs(bool),
    /// Its own supply is off, or there again; nothing for a module without one ([`ModuleType::has_own_supply`]).
    Unsupplied(bool),
}

/// What goes wrong inside the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InternalError {
    /// The hardware's own watchdog expires and the application is halted: only a power cycle ends this HALT
    /// (controller:WD-14).
    HardwareWatchdog,
    /// The firmware finds an error of its own and halts the application: only a power cycle ends this HALT
    /// (controller:WD-14).
    Firmware,
    /// An exception of firmware or hardware that cannot be managed: a system error (controller:ERR-01, controller:TR-12).
    FirmwareException,
}

/// The bits of PLC_R.i_lwSystemFault_1 that stand for something: TM3 (0 and 1), Ethernet IF1 and IF2, CAN 1, TM4, SD
/// card, firewall, DHCP server, OPC UA server. The others are reserved (controller:SYS-04; bit 0 is too, but the
/// text of the expansion bus uses it).
pub const FAULT_BITS: &[u8] = &[0, 1, 2, 3, 6, 9, 10, 11, 12, 13];

const TM4_BIT: u8 = 9;
const BUS_BITS: u64 = 0b11;

/// The errors of parts outside of the controller.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ExternalErrors {
    /// A 1 for every part in error.
    faults: u64,
}

impl ExternalErrors {
    pub(crate) fn set(&mut self, bit: u8, on: bool) {
        if FAULT_BITS.contains(&bit) {
            self.faults = if on { self.faults | 1 << bit } else { self.faults & !(1 << bit) };
        }
    }

    /// PLC_R.i_lwSystemFault_1: a 0 for every part in error. Bits 0 and 1 are of the expansion bus (io:ERR-02), bit 9 of that
    /// of TM4.
    pub(crate) const fn word(self, is_bus_wrong: bool, is_tm4_wrong: bool) -> u64 {
        let bus = if is_bus_wrong { BUS_BITS } else { 0 };
        let tm4 = if is_tm4_wrong { 1 << TM4_BIT } else { 0 };
        !(self.faults | bus | tm4)
    }

    /// Whether any part is in error.
    pub(crate) const fn is_any(self) -> bool {
        self.faults != 0
    }

    /// Whether the TM4 bus is in error.
    pub(crate) const fn tm4(self) -> bool {
        self.faults >> TM4_BIT & 1 == 1
    }
}
