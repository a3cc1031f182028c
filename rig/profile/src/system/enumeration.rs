//! The enumerations of the system structures and functions (plcsystem: section 9).

use super::member::SINCE_2019;
use crate::{
    ApplicationError, BootProjectStatus, ExchangeCode, IoStatus, ModuleState, PlcCommand, PlcStatus, Profile,
    StopCause, Tm3BusState,
};

/// An enumeration: each value is a WORD.
#[derive(Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// Its name.
    pub name: &'static str,
    /// The names of its values, each with its number; a number may have a second name after its first.
    pub values: &'static [(&'static str, u16)],
    /// The profiles whose controllers have it.
    pub profiles: &'static [Profile],
}

const fn enumeration(name: &'static str, values: &'static [(&'static str, u16)]) -> Enumeration {
    Enumeration { name, values, profiles: &Profile::ALL }
}

impl Enumeration {
    /// The first name of each number.
    pub fn labels(&self) -> impl Iterator<Item = (&'static str, u16)> {
        let is_first =
            |place: usize, number: u16| self.values[..place].iter().all(|(_, known)| *known != number);
        self.values
            .iter()
            .enumerate()
            .filter(move |(place, (_, number))| is_first(*place, *number))
            .map(|(_, one)| *one)
    }
}

/// plcsystem: 9.1.
pub const APPLICATION_ERROR: Enumeration = enumeration(
    "PLC_R_APPLICATION_ERROR",
    &[
        ("PLC_R_APP_ERR_UNKNOWN", ApplicationError::Undefined.code()),
        ("PLC_R_APP_ERR_NOEXCEPTION", ApplicationError::None.code()),
        ("PLC_R_APP_ERR_WATCHDOG", ApplicationError::TaskWatchdog.code()),
        ("PLC_R_APP_ERR_HARDWAREWATCHDOG", ApplicationError::SystemWatchdog.code()),
        ("PLC_R_APP_ERR_IO_CONFIG_ERROR", ApplicationError::IoConfiguration.code()),
        ("PLC_R_APP_ERR_UNRESOLVED_EXTREFS", ApplicationError::UndefinedFunction.code()),
        ("PLC_R_APP_ERR_IEC_TASK_CONFIG_ERROR", ApplicationError::TaskConfiguration.code()),
        ("PLC_R_APP_ERR_ILLEGAL_INSTRUCTION", ApplicationError::UndefinedInstruction.code()),
        ("PLC_R_APP_ERR_ACCESS_VIOLATION", ApplicationError::ReservedMemory.code()),
        ("PLC_R_APP_ERR_DIVIDE_BY_ZERO", ApplicationError::IntegerDivision.code()),
        ("PLC_R_APP_ERR_PROCESSORLOAD_WATCHDOG", ApplicationError::Overload.code()),
        ("PLC_R_APP_ERR_DIVIDE_REAL_BY_ZERO", ApplicationError::RealDivision.code()),
        ("PLC_R_APP_ERR_EXPIO_EVENTS_COUNT_EXCEEDED", ApplicationError::TooManyEvents.code()),
        ("PLC_R_APP_ERR_APPLICATION_VERSION_MISMATCH", ApplicationError::VersionMismatch.code()),
    ],
);

/// plcsystem: 9.2.
pub const BOOT_PROJECT_STATUS: Enumeration = enumeration(
    "PLC_R_BOOT_PROJECT_STATUS",
    &[
        ("PLC_R_NO_BOOT_PROJECT", BootProjectStatus::None.code()),
        ("PLC_R_BOOT_PROJECT_CREATION_IN_PROGRESS", BootProjectStatus::Creating.code()),
        ("PLC_R_DIFFERENT_BOOT_PROJECT", BootProjectStatus::Different.code()),
        ("PLC_R_VALID_BOOT_PROJECT", BootProjectStatus::Valid.code()),
    ],
);

/// plcsystem: 9.3.
pub const IO_STATUS: Enumeration = enumeration(
    "PLC_R_IO_STATUS",
    &[
        ("PLC_R_IO_OK", IoStatus::Ok.code()),
        ("PLC_R_IO_NO_INIT", IoStatus::NotInitialised.code()),
        ("PLC_R_IO_CONF_FAULT", IoStatus::ConfigurationFault.code()),
        ("PLC_R_IO_SHORTCUT_FAULT", IoStatus::ShortCircuit.code()),
        ("PLC_R_IO_POWER_SUPPLY_FAULT", IoStatus::PowerSupply.code()),
        ("PLC_R_IO_BUS_ERROR", IoStatus::BusError.code()),
    ],
);

/// plcsystem: 9.4.
pub const SD_CARD_STATUS: Enumeration = enumeration(
    "PLC_R_SDCARD_STATUS",
    &[("NO_SDCARD", 0), ("SDCARD_READONLY", 1), ("SDCARD_READWRITE", 2), ("SDCARD_ERROR", 3)],
);

/// plcsystem: 9.5.
pub const STATUS: Enumeration = enumeration(
    "PLC_R_STATUS",
    &[
        ("PLC_R_EMPTY", PlcStatus::Empty.code()),
        ("PLC_R_STOPPED", PlcStatus::Stopped.code()),
        ("PLC_R_RUNNING", PlcStatus::Running.code()),
        ("PLC_R_HALT", PlcStatus::Halt.code()),
        ("PLC_R_BREAKPOINT", PlcStatus::Breakpoint.code()),
    ],
);

/// plcsystem: 9.6.
pub const STOP_CAUSE: Enumeration = enumeration(
    "PLC_R_STOP_CAUSE",
    &[
        ("PLC_R_STOP_REASON_UNKNOWN", StopCause::Unknown.code()),
        ("PLC_R_STOP_REASON_HW_WATCHDOG", StopCause::HardwareWatchdog.code()),
        ("PLC_R_STOP_REASON_RESET", StopCause::Reset.code()),
        ("PLC_R_STOP_REASON_EXCEPTION", StopCause::Exception.code()),
        ("PLC_R_STOP_REASON_USER", StopCause::User.code()),
        ("PLC_R_STOP_REASON_IECPROGRAM", StopCause::Program.code()),
        ("PLC_R_STOP_REASON_DELETE", StopCause::Delete.code()),
        ("PLC_R_STOP_REASON_DEBUGGING", StopCause::Debugging.code()),
        ("PLC_R_STOP_FROM_NETWORK_REQUEST", StopCause::Network.code()),
        ("PLC_R_STOP_FROM_INPUT", StopCause::Input.code()),
        ("PLC_R_STOP_FROM_RUN_STOP_SWITCH", StopCause::Switch.code()),
        ("PLC_R_STOP_REASON_RETAIN_MISMATCH", StopCause::RetainMismatch.code()),
        ("PLC_R_STOP_REASON_BOOT_APPLI_MISMATCH", StopCause::BootApplicationMismatch.code()),
        ("PLC_R_STOP_REASON_POWERFAIL", StopCause::PowerFail.code()),
    ],
);

/// plcsystem: 9.7.
pub const TERMINAL_PORT_STATUS: Enumeration = enumeration(
    "PLC_R_TERMINAL_PORT_STATUS",
    &[
        ("TERMINAL_NOT_CONNECTED", 0x00),
        ("TERMINAL_CONNECTION_IN_PROGRESS", 0x01),
        ("TERMINAL_CONNECTED", 0x02),
        ("TERMINAL_ERROR", 0x0F),
    ],
);

/// plcsystem: 9.8.
pub const TM3_BUS_STATE: Enumeration = enumeration(
    "PLC_R_TM3_BUS_STATE",
    &[
        ("TM3_CONF_ERROR", Tm3BusState::ConfigurationError.code()),
        ("TM3_OK", Tm3BusState::Ok.code()),
        ("TM3_POWER_SUPPLY_ERROR", Tm3BusState::PowerSupplyError.code()),
    ],
);

/// plcsystem: 9.9.
pub const COMMAND: Enumeration = enumeration(
    "PLC_W_COMMAND",
    &[
        ("PLC_W_STOP", PlcCommand::Stop as u16),
        ("PLC_W_RUN", PlcCommand::Run as u16),
        ("PLC_W_RESET_COLD", PlcCommand::ResetCold as u16),
        ("PLC_W_RESET_WARM", PlcCommand::ResetWarm as u16),
    ],
);

/// plcsystem: 9.13.
pub const FRAME_PROTOCOL: Enumeration =
    enumeration("ETH_R_FRAME_PROTOCOL", &[("ETH_R_802_3", 0x00), ("ETH_R_ETHERNET_II", 0x01)]);

/// plcsystem: 9.13.
pub const IP_MODE: Enumeration = enumeration(
    "ETH_R_IP_MODE",
    &[("ETH_R_STORED", 0x00), ("ETH_R_BOOTP", 0x01), ("ETH_R_DHCP", 0x02), ("ETH_DEFAULT_IP", 0xFF)],
);

/// plcsystem: 9.14; there is no 2.
pub const DUPLEX_STATUS: Enumeration = enumeration(
    "ETH_R_PORT_DUPLEX_STATUS",
    &[("ETH_R_PORT_HALF_DUPLEX", 0x00), ("ETH_R_FULL_DUPLEX", 0x01), ("ETH_R_PORT_NA_DUPLEX", 0x03)],
);

/// plcsystem: 9.14.
pub const IP_STATUS: Enumeration = enumeration(
    "ETH_R_PORT_IP_STATUS",
    &[
        ("WAIT_FOR_PARAMS", 0x00),
        ("WAIT_FOR_CONF", 0x01),
        ("DATA_EXCHANGE", 0x02),
        ("ETH_ERROR", 0x03),
        ("DUPLICATE_IP", 0x04),
    ],
);

/// plcsystem: 9.14.
pub const LINK_STATUS: Enumeration =
    enumeration("ETH_R_PORT_LINK_STATUS", &[("ETH_R_LINK_DOWN", 0x00), ("ETH_R_LINK_UP", 0x01)]);

/// plcsystem: 9.14, in Mbit/s.
pub const PORT_SPEED: Enumeration = enumeration(
    "ETH_R_PORT_SPEED",
    &[("ETH_R_SPEED_NA", 0), ("ETH_R_SPEED_10_MB", 10), ("ETH_R_100_MB", 100)],
);

/// plcsystem: 9.14.
pub const RUN_IDLE: Enumeration = enumeration("ETH_R_RUN_IDLE", &[("IDLE", 0x00), ("RUN", 0x01)]);

/// plcsystem: 9.15.
pub const EXCHANGE_CODE: Enumeration = enumeration(
    "TM3_ERR_CODE",
    &[
        ("TM3_NO_ERR", ExchangeCode::NoError.code()),
        ("TM3_ERR_FAILED", ExchangeCode::Failed.code()),
        ("TM3_ERR_PARAMETER", ExchangeCode::Parameter.code()),
        ("TM3_ERR_COK", ExchangeCode::Hardware.code()),
        ("TM3_ERR_BUS", ExchangeCode::Bus.code()),
    ],
);

/// plcsystem: 9.17; there is no 4.
pub const MODULE_STATE: Enumeration = enumeration(
    "TM3_MODULE_STATE",
    &[
        (ModuleState::Empty.name(), ModuleState::Empty.code()),
        (ModuleState::ConfigurationError.name(), ModuleState::ConfigurationError.code()),
        (ModuleState::BusError.name(), ModuleState::BusError.code()),
        (ModuleState::Ok.name(), ModuleState::Ok.code()),
        (ModuleState::MissingOptional.name(), ModuleState::MissingOptional.code()),
    ],
);

/// plcsystem: 9.17. The text of the library has the names with IOBUS, that of the bus those without. The controller of 2014
/// has no such choice (plcsystem:TM3V-06).
pub const BUS_ERROR_HANDLING: Enumeration = Enumeration {
    name: "TM3_BUS_W_IOBUSERRMOD",
    values: &[("IOBUS_ERR_ACTIVE", 0), ("IOBUS_ERR_PASSIVE", 1), ("ERR_ACTIVE", 0), ("ERR_PASSIVE", 1)],
    profiles: SINCE_2019,
};

/// Every enumeration.
pub const ENUMERATIONS: &[&Enumeration] = &[
    &APPLICATION_ERROR,
    &BOOT_PROJECT_STATUS,
    &IO_STATUS,
    &SD_CARD_STATUS,
    &STATUS,
    &STOP_CAUSE,
    &TERMINAL_PORT_STATUS,
    &TM3_BUS_STATE,
    &COMMAND,
    &FRAME_PROTOCOL,
    &IP_MODE,
    &DUPLEX_STATUS,
    &IP_STATUS,
    &LINK_STATUS,
    &PORT_SPEED,
    &RUN_IDLE,
    &EXCHANGE_CODE,
    &MODULE_STATE,
    &BUS_ERROR_HANDLING,
];
