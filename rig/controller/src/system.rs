//! The system variables: a table of their names and types, what they show, and how a program that mentions them sees
//! them.

use crate::clocks::Clocks;
use crate::last_state::Dates;
use crate::{Controller, Rtc};
use profile::{ApplicationError, BootProjectStatus, StopCause};
use signal::Value;

/// Type of a system variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SystemType {
    /// BOOL.
    Bool,
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
    /// The name in Structured Text.
    pub const fn name(self) -> &'static str {
        match self {
            SystemType::Bool => "BOOL",
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
        /// A system variable. What begins with `PLC_R.` is read, what begins with `PLC_W.` is written
        /// (controller:STATE-02, controller:SYS-01...06, controller:CMD-01).
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum SystemVariable {
            $($(#[$doc])+ $variant,)+
        }

        impl SystemVariable {
            /// Every system variable, those of a structure in its order.
            pub const ALL: &[SystemVariable] = &[$(SystemVariable::$variant,)+];

            /// The name, as in `PLC_R.i_wStatus`.
            pub const fn name(self) -> &'static str {
                match self {
                    $(SystemVariable::$variant => $name,)+
                }
            }

            /// Its type.
            pub const fn ty(self) -> SystemType {
                match self {
                    $(SystemVariable::$variant => SystemType::$ty,)+
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
    /// The key that has the command executed (controller:CMD-01).
    OpenPlcControl = "PLC_W.q_uiOpenPLCControl": Uint,
    /// The command (controller:CMD-01).
    PlcControl = "PLC_W.q_wPLCControl": Word,
}

impl SystemVariable {
    /// The system variable of this name, in any case of letters.
    pub fn find(name: &str) -> Option<SystemVariable> {
        SystemVariable::ALL.iter().copied().find(|variable| variable.name().eq_ignore_ascii_case(name))
    }

    /// Whether programs and plans write it.
    pub fn is_written(self) -> bool {
        self.name().starts_with("PLC_W.")
    }
}

/// What the system variables show, as far as it is nowhere else.
#[derive(Clone, Debug)]
pub(crate) struct System {
    pub boot_project: BootProjectStatus,
    pub stop_cause: StopCause,
    pub error: ApplicationError,
    /// When RUNNING was left last, and when the controller went off last (controller:RB-06).
    pub dates: Dates,
    pub rtc: Rtc,
    pub clocks: Clocks,
    /// PLC_W.q_wPLCControl and PLC_W.q_uiOpenPLCControl.
    pub control: u16,
    pub open: u16,
    /// The system variables that the application has too, by their numbers in it.
    links: Vec<(SystemVariable, u32)>,
}

impl Default for System {
    fn default() -> Self {
        System {
            boot_project: BootProjectStatus::None,
            stop_cause: StopCause::Unknown,
            error: ApplicationError::None,
            dates: Dates::default(),
            rtc: Rtc::default(),
            clocks: Clocks::default(),
            control: 0,
            open: 0,
            links: Vec::new(),
        }
    }
}

impl System {
    /// The number of a system variable in the application, where that mentions it.
    pub(crate) fn link(&self, variable: SystemVariable) -> Option<u32> {
        self.links.iter().find(|(known, _)| *known == variable).map(|(_, number)| *number)
    }
}

impl Controller {
    /// What a system variable shows; unknown while no service answers.
    pub(crate) fn read_system(&self, variable: SystemVariable) -> Value {
        let Some(status) = self.state.status() else { return Value::Unknown };
        let system = &self.system;
        Value::Word(match variable {
            SystemVariable::VendorId => u64::from(profile::VENDOR_ID),
            SystemVariable::Status => u64::from(status.code()),
            SystemVariable::BootProjectStatus => u64::from(system.boot_project.code()),
            SystemVariable::LastStopCause => u64::from(system.stop_cause.code()),
            SystemVariable::LastApplicationError => u64::from(system.error.code()),
            SystemVariable::SystemFault1 => self.external.word(),
            SystemVariable::IoStatus1 | SystemVariable::LocalIoStatus => match self.local_io_status() {
                Some(status) => u64::from(status.code()),
                None => return Value::Unknown,
            },
            SystemVariable::IoStatus2 => u64::from(profile::IoStatus::Ok.code()),
            SystemVariable::ClockBatteryStatus => 100,
            SystemVariable::LastStopTime => u64::from(system.dates.stop),
            SystemVariable::LastPowerOffDate => u64::from(system.dates.off),
            SystemVariable::Clock10Ms | SystemVariable::Clock100Ms | SystemVariable::Clock1S => {
                return Value::Bool(system.clocks.level(variable, self.cpu.at));
            }
            SystemVariable::OpenPlcControl => u64::from(system.open),
            SystemVariable::PlcControl => u64::from(system.control),
        })
    }

    /// Looks up the system variables that a new application mentions.
    pub(crate) fn link_system(&mut self) {
        self.system.links.clear();
        let Some(application) = &mut self.application else { return };
        for variable in SystemVariable::ALL {
            if let Some(number) = application.variable(variable.name()) {
                self.system.links.push((*variable, number));
            }
        }
        self.watch_system();
        self.start_clocks();
        self.show_system();
    }

    /// Has the application stop where it writes a system variable.
    pub(crate) fn watch_system(&mut self) {
        let Some(application) = &mut self.application else { return };
        for (variable, number) in &self.system.links {
            if variable.is_written() {
                application.watch(*number);
            }
        }
    }

    /// Shows the program the system variables that it mentions.
    #[inline]
    pub(crate) fn show_system(&mut self) {
        for place in 0..self.system.links.len() {
            let (variable, number) = self.system.links[place];
            let value = self.read_system(variable);
            if !variable.is_written()
                && value != Value::Unknown
                && let Some(application) = &mut self.application
            {
                application.write(number, value);
            }
        }
    }
}
