//! The numbers that the controller shows in its system variables.

/// State shown in PLC_R.i_wStatus, register 60012 (controller:STATE-02).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum PlcStatus {
    /// No application.
    Empty = 0x0000,
    /// A valid application, stopped.
    Stopped = 0x0001,
    /// Executing.
    Running = 0x0002,
    /// Stopped by an application error.
    Halt = 0x0004,
    /// Executing, held at a breakpoint.
    Breakpoint = 0x0008,
}

/// What became of the boot project, PLC_R.i_wBootProjectStatus, register 60013 (controller:SYS-01).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum BootProjectStatus {
    /// There is no boot project.
    None = 0x0000,
    /// It is being created.
    Creating = 0x0001,
    /// It differs from the project in memory.
    Different = 0x0002,
    /// It is valid and the same as the project in memory.
    Valid = 0xFFFF,
}

/// A command in PLC_W.q_wPLCControl (controller:CMD-01).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum PlcCommand {
    /// Stop.
    Stop = 0x0001,
    /// Run.
    Run = 0x0002,
    /// Reset cold.
    ResetCold = 0x0004,
    /// Reset warm.
    ResetWarm = 0x0008,
}

/// What PLC_W.q_uiOpenPLCControl passes to from 0 for the command to be executed (controller:CMD-01).
pub const PLC_W_KEY: u16 = 6699;

impl PlcCommand {
    /// The command of this number.
    pub fn from_code(code: u16) -> Option<PlcCommand> {
        let all = [PlcCommand::Stop, PlcCommand::Run, PlcCommand::ResetCold, PlcCommand::ResetWarm];
        all.into_iter().find(|command| *command as u16 == code)
    }
}

/// Why the controller last left RUNNING, PLC_R.i_wLastStopCause, register 60014 (controller:SYS-02).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum StopCause {
    /// Initial value, or it is not known.
    Unknown = 0x00,
    /// Hardware watchdog.
    HardwareWatchdog = 0x01,
    /// Reset.
    Reset = 0x02,
    /// Exception: a reset is needed to enter RUNNING.
    Exception = 0x03,
    /// A user's request.
    User = 0x04,
    /// The program's own request.
    Program = 0x05,
    /// The application was removed.
    Delete = 0x06,
    /// Debugging was entered.
    Debugging = 0x07,
    /// A request from the network, the Web server or a PLC_W command.
    Network = 0x0A,
    /// The Run/Stop input.
    Input = 0x0B,
    /// The Run/Stop switch.
    Switch = 0x0C,
    /// The check of the remanent variables failed at boot.
    RetainMismatch = 0x0D,
    /// The boot application differs from the one that was in memory.
    BootApplicationMismatch = 0x0E,
    /// Power interruption.
    PowerFail = 0x0F,
}

impl StopCause {
    /// The cause of this number.
    pub fn from_code(code: u16) -> Option<StopCause> {
        let all = [
            StopCause::Unknown,
            StopCause::HardwareWatchdog,
            StopCause::Reset,
            StopCause::Exception,
            StopCause::User,
            StopCause::Program,
            StopCause::Delete,
            StopCause::Debugging,
            StopCause::Network,
            StopCause::Input,
            StopCause::Switch,
            StopCause::RetainMismatch,
            StopCause::BootApplicationMismatch,
            StopCause::PowerFail,
        ];
        all.into_iter().find(|cause| cause.code() == code)
    }
}

/// The last application error, PLC_R.i_wLastApplicationError, register 60015 (controller:SYS-03).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum ApplicationError {
    /// None.
    None = 0x0000,
    /// A task's watchdog expired.
    TaskWatchdog = 0x0010,
    /// A system watchdog expired.
    SystemWatchdog = 0x0011,
    /// Wrong parameters of an input or output.
    IoConfiguration = 0x0012,
    /// A function is not defined.
    UndefinedFunction = 0x0018,
    /// Wrong parameters of a task.
    TaskConfiguration = 0x0025,
    /// An instruction is not defined.
    UndefinedInstruction = 0x0050,
    /// Access to reserved memory.
    ReservedMemory = 0x0051,
    /// Integer division by zero.
    IntegerDivision = 0x0102,
    /// The application's tasks take too much of the processor.
    Overload = 0x0105,
    /// Division of a REAL by zero.
    RealDivision = 0x0152,
    /// Too many events on expert inputs and outputs.
    TooManyEvents = 0x4E20,
    /// The application is of another version.
    VersionMismatch = 0x4E21,
    /// None of the others.
    Undefined = 0xFFFF,
}

/// State of inputs and outputs as in PLC_R.i_wIOStatus1 (controller:SYS-06, io:OUT-12).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum IoStatus {
    /// In order.
    Ok = 0xFFFF,
    /// Not initialised.
    NotInitialised = 0x0001,
    /// Wrong configuration.
    ConfigurationFault = 0x0002,
    /// Short circuit.
    ShortCircuit = 0x0003,
    /// The supply of the inputs and outputs is missing.
    PowerSupply = 0x0004,
    /// Expansion bus error (rig definition: the documents name it without a number).
    BusError = 0x0005,
}

/// State of an expansion module, `TM3_MODULE_R[i].i_wModuleState` (io:DIAG-03, plcsystem: 9.17). There is no 04.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum ModuleState {
    /// TM3_EMPTY: no module is configured at this index.
    Empty = 0x00,
    /// TM3_CONF_ERROR: another module than the configured one answers.
    ConfigurationError = 0x01,
    /// TM3_BUS_ERROR: the module does not communicate.
    BusError = 0x02,
    /// TM3_OK: the last exchange was successful.
    Ok = 0x03,
    /// TM3_MISSING_OPT_MOD: the module is optional and is not there.
    MissingOptional = 0x05,
}

/// State of the expansion bus, PLC_R.i_uiTM3BusState (io:DIAG-03, plcsystem: 9.8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum Tm3BusState {
    /// TM3_CONF_ERROR: what is fitted is not what is configured.
    ConfigurationError = 1,
    /// TM3_OK: what is fitted is what is configured.
    Ok = 3,
    /// TM3_POWER_SUPPLY_ERROR: the bus has no power.
    PowerSupplyError = 4,
}

/// How an exchange with an expansion module went, TM3_ERR_CODE (io:DIAG-03, plcsystem: 9.15).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum ExchangeCode {
    /// TM3_NO_ERR: the last one succeeded.
    NoError = 0x00,
    /// TM3_ERR_FAILED: it did not.
    Failed = 0x01,
    /// TM3_ERR_PARAMETER: there is no such module.
    Parameter = 0x02,
    /// TM3_ERR_COK: an error of the hardware of a module.
    Hardware = 0x03,
    /// TM3_ERR_BUS: an error of the bus.
    Bus = 0x04,
}

/// What TM3_GetModuleFWVersion gives where it cannot read the version (io:DIAG-05).
pub const NO_FIRMWARE_VERSION: u16 = 0xFFFF;

/// The number behind each code.
macro_rules! codes {
    ($($name:ident),*) => {$(
        impl $name {
            /// The number as the system variable shows it.
            pub const fn code(self) -> u16 {
                self as u16
            }
        }
    )*};
}

codes!(
    PlcStatus,
    BootProjectStatus,
    StopCause,
    ApplicationError,
    IoStatus,
    ModuleState,
    Tm3BusState,
    ExchangeCode
);

impl ModuleState {
    /// Its name in the documents.
    pub const fn name(self) -> &'static str {
        match self {
            ModuleState::Empty => "TM3_EMPTY",
            ModuleState::ConfigurationError => "TM3_CONF_ERROR",
            ModuleState::BusError => "TM3_BUS_ERROR",
            ModuleState::Ok => "TM3_OK",
            ModuleState::MissingOptional => "TM3_MISSING_OPT_MOD",
        }
    }
}
