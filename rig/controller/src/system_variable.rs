//! The system variables: a table of their names and types.

use profile::{MODULE_INDICES, Profile};

/// Type of a system variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SystemType {
    /// BOOL.
    Bool,
    /// BYTE.
    Byte,
    /// WORD.
    Word,
    /// UINT.
    Uint,
    /// DWORD.
    Dword,
    /// LWORD.
    Lword,
}

impl SystemType {
    /// Bits of a value.
    pub const fn bits(self) -> u32 {
        match self {
            SystemType::Bool => 1,
            SystemType::Byte => 8,
            SystemType::Word | SystemType::Uint => 16,
            SystemType::Dword => 32,
            SystemType::Lword => 64,
        }
    }

    /// The name in Structured Text.
    pub const fn name(self) -> &'static str {
        match self {
            SystemType::Bool => "BOOL",
            SystemType::Byte => "BYTE",
            SystemType::Word => "WORD",
            SystemType::Uint => "UINT",
            SystemType::Dword => "DWORD",
            SystemType::Lword => "LWORD",
        }
    }
}

/// The table: in the order of the structures, with what a plan and a program call them.
macro_rules! system_variables {
    ($($(#[$doc:meta])+ $variant:ident = $name:literal: $ty:ident,)+) => {
        /// A system variable. What begins with `PLC_R.` is read, what begins with `PLC_W.` or `TM3_BUS_W.` is written
        /// (controller:STATE-02, controller:SYS-01...06, controller:CMD-01).
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum SystemVariable {
            $($(#[$doc])+ $variant,)+
            /// The internal ID code of the expansion module at an index (io:DIAG-01).
            ModuleId(u8),
            /// The state of the expansion module at an index (io:DIAG-01, io:DIAG-03).
            ModuleState(u8),
        }

        /// Those that are no members of an array.
        const SINGLE: &[SystemVariable] = &[$(SystemVariable::$variant,)+];

        impl SystemVariable {
            /// The name, as in `PLC_R.i_wStatus`.
            pub const fn name(self) -> &'static str {
                match self {
                    $(SystemVariable::$variant => $name,)+
                    SystemVariable::ModuleId(index) => MODULE_NAMES[index as usize % MODULE_INDICES][0],
                    SystemVariable::ModuleState(index) => MODULE_NAMES[index as usize % MODULE_INDICES][1],
                }
            }

            /// Its type.
            pub const fn ty(self) -> SystemType {
                match self {
                    $(SystemVariable::$variant => SystemType::$ty,)+
                    SystemVariable::ModuleId(_) | SystemVariable::ModuleState(_) => SystemType::Word,
                }
            }
        }
    };
}

system_variables! {
    /// The vendor: 101A hex (controller:SYS-06).
    VendorId = "PLC_R.i_wVendorID": Word,
    /// The state (controller:STATE-02).
    Status = "PLC_R.i_wStatus": Word,
    /// How the boot application stands to the one in memory (controller:SYS-01).
    BootProjectStatus = "PLC_R.i_wBootProjectStatus": Word,
    /// Why RUNNING was left last (controller:SYS-02).
    LastStopCause = "PLC_R.i_wLastStopCause": Word,
    /// The last error of the application (controller:SYS-03).
    LastApplicationError = "PLC_R.i_wLastApplicationError": Word,
    /// A 0 for every error (controller:SYS-04).
    SystemFault1 = "PLC_R.i_lwSystemFault_1": Lword,
    /// Status of the embedded inputs and outputs (controller:SYS-06).
    IoStatus1 = "PLC_R.i_wIOStatus1": Word,
    /// Status of the expansion modules (controller:SYS-06).
    IoStatus2 = "PLC_R.i_wIOStatus2": Word,
    /// Another name of the status of the embedded inputs and outputs.
    LocalIoStatus = "PLC_R.i_wLocalIOStatus": Word,
    /// The battery of the clock in per cent: 100 is full (controller:SYS-06).
    ClockBatteryStatus = "PLC_R.i_wClockBatterystatus": Word,
    /// When RUNNING was left last, in seconds since 1970 (controller:RB-06).
    LastStopTime = "PLC_R.i_dwLastStopTime": Dword,
    /// When the power went last, in seconds since 1970 (controller:RB-06).
    LastPowerOffDate = "PLC_R.i_dwLastPowerOffDate": Dword,
    /// A clock of 10 ms (controller:SYS-05).
    Clock10Ms = "PLC_R.i_x10msClk": Bool,
    /// A clock of 100 ms.
    Clock100Ms = "PLC_R.i_x100msClk": Bool,
    /// A clock of 1 s.
    Clock1S = "PLC_R.i_x1sClk": Bool,
    /// Whether the fitted expansion modules are the configured ones (io:DIAG-03).
    Tm3BusState = "PLC_R.i_uiTM3BusState": Uint,
    /// How many events configured inputs raised, 0 in an M251 (plcsystem:PLCR-11).
    EventsCounter = "PLC_R.i_uiEventsCounter": Uint,
    /// Which input is the Run/Stop input: n for In, FF hex for none; 0 in an M251 (plcsystem:PLCR-11).
    RunStopInput = "PLC_R.i_ExpertIO_RunStop_Input": Byte,
    /// The key that has the command executed (controller:CMD-01).
    OpenPlcControl = "PLC_W.q_uiOpenPLCControl": Uint,
    /// The command (controller:CMD-01).
    PlcControl = "PLC_W.q_wPLCControl": Word,
    /// 1 for passive handling of errors on the expansion bus, 0 for active (io:ERR-05).
    BusErrorPassive = "TM3_BUS_W.q_wIOBusErrPassiv": Word,
    /// From 0 to 1 it restarts the expansion bus (io:ERR-16).
    BusRestart = "TM3_BUS_W.q_wIOBusRestart": Word,
}

/// The names of the members of TM3_MODULE_R, by index.
macro_rules! module_names {
    ($($index:literal)+) => {
        [$([
            concat!("TM3_MODULE_R[", $index, "].i_wProductID"),
            concat!("TM3_MODULE_R[", $index, "].i_wModuleState"),
        ],)+]
    };
}

const MODULE_NAMES: [[&str; 2]; MODULE_INDICES] = module_names!(0 1 2 3 4 5 6 7 8 9 10 11 12 13);

impl SystemVariable {
    /// Every system variable, those of a structure in its order.
    pub const ALL: &[SystemVariable] = &{
        let mut all = [SystemVariable::VendorId; SINGLE.len() + 2 * MODULE_INDICES];
        let mut at = 0;
        while at < SINGLE.len() {
            all[at] = SINGLE[at];
            at += 1;
        }
        let mut index = 0;
        while index < MODULE_INDICES {
            all[SINGLE.len() + 2 * index] = SystemVariable::ModuleId(index as u8);
            all[SINGLE.len() + 2 * index + 1] = SystemVariable::ModuleState(index as u8);
            index += 1;
        }
        all
    };

    /// The system variable of this name, in any case of letters.
    pub fn find(name: &str) -> Option<SystemVariable> {
        SystemVariable::ALL.iter().copied().find(|variable| variable.name().eq_ignore_ascii_case(name))
    }

    /// Whether programs and plans write it.
    pub fn is_written(self) -> bool {
        self.name().starts_with("PLC_W.") || self.is_of_bus()
    }

    /// Whether it is a command to the expansion bus.
    pub const fn is_of_bus(self) -> bool {
        matches!(self, SystemVariable::BusErrorPassive | SystemVariable::BusRestart)
    }

    /// Whether a controller of this profile has it: in 2014 nothing commands the expansion bus (plcsystem:TM3V-06).
    pub fn exists(self, profile: Profile) -> bool {
        !(self.is_of_bus() && profile == Profile::M241_2014)
    }
}
