//! What can be commanded and written, and why it is refused (controller: section 14.4).

use crate::application::LoadError;
use crate::state::State;
use signal::Address;
use thiserror::Error;

/// A command of a user or a tool.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// Start the application (controller:RUN-01).
    Run,
    /// Stop the application (controller:STP-01). Cycles under way are finished first; no new one starts.
    Stop,
    /// Reset warm (controller:RW-01).
    ResetWarm,
    /// Reset cold (controller:RC-01).
    ResetCold,
    /// Reset origin (controller:RO-01).
    ResetOrigin,
    /// Reset origin device (controller:ROD-01).
    ResetOriginDevice(DeviceReset),
    /// Reboot by script (controller:RB-01).
    Reboot,
    /// Load an application and make it the boot application (controller:DL-02).
    Download(Vec<u8>),
    /// Load an application and leave the boot application as it is (controller:NV-02, controller:STATE-12).
    DownloadToMemory(Vec<u8>),
    /// Load an application as one of several that are downloaded together (controller:TR-19, controller:TR-20).
    MultipleDownload {
        /// The application.
        bundle: Vec<u8>,
        /// Start all applications after download or online change.
        start: bool,
    },
    /// Make the application in memory the boot application (controller:STATE-13).
    CreateBootApplication,
    /// Put a boot application into the non-volatile memory by SD card or FTP (controller:DL-03).
    PlaceBootApplication(Vec<u8>),
    /// Remove the application (controller:TR-27).
    DeleteApplication,
    /// Damage the firmware, or restore it from an SD card (controller:TR-02, controller:TR-25).
    Firmware {
        /// It is valid from then on.
        valid: bool,
    },
    /// Force the value of an input or output (controller:FRC-01).
    Force {
        /// Its place in %I or %Q.
        address: Address,
        /// Its value: 0 or 1, or the counts of an analogue channel.
        value: u64,
    },
    /// End the forcing of an input or output, by its place in %I or %Q.
    Unforce(Address),
    /// Move the Run/Stop switch: TRUE to Run (controller:RS-01).
    Switch(bool),
    /// Go on with another application that keeps the values of its variables (controller:TR-17, controller:TR-18).
    OnlineChange(Vec<u8>),
    /// Hold the tasks where one comes to the first statement of a line (controller:TR-22).
    Breakpoint {
        /// Place of the source file in the application.
        file: u16,
        /// Line in that file, from 1.
        line: u32,
    },
    /// Go on from a breakpoint.
    Resume,
    /// Go on from a breakpoint to the next statement of the task that came to it.
    StepStatement,
    /// Take every breakpoint away, and go on.
    ClearBreakpoints,
    /// A programming tool connects (controller:FRC-01).
    LogIn,
    /// The programming tool disconnects (controller:FRC-03).
    LogOut {
        /// Whether forcing stays.
        keep_forcing: bool,
    },
    /// Show or no longer show which controller it is: every indicator flashes (controller:LED-03).
    Identify(bool),
    /// Set the real-time clock (plcsystem:FUN-03).
    SetClock {
        /// Seconds since 1970-01-01 00:00 UTC.
        seconds: i64,
    },
}

/// What reset origin device resets, each for itself (controller:ROD-01).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceReset {
    /// Users and groups return to their defaults.
    pub user_management: bool,
    /// Application, its files and the remanent variables.
    pub plc_logic: bool,
    /// Certificates of the Web and FTP servers.
    pub certificates: bool,
}

/// Why a command was not obeyed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum CommandError {
    /// Not possible in this state (controller:TR-24, controller:TR-28).
    #[error("not possible in state {0}")]
    State(State),
    /// HALT by an error inside the controller (controller:WD-14, controller:TR-13).
    #[error("HALT by an error inside the controller ends only by a power cycle")]
    NeedsPowerCycle,
    /// The Run/Stop switch is at Stop.
    #[error("the Run/Stop switch is at Stop")]
    SwitchAtStop,
    /// The Run/Stop input is 0.
    #[error("the Run/Stop input is 0")]
    RunStopInput,
    /// A stop is under way: a cycle is being finished.
    #[error("a stop is under way")]
    Stopping,
    /// No input or output is at this place.
    #[error("no input or output of the controller is at {0}")]
    NoChannel(Address),
    /// No more channels of modules can be forced at once.
    #[error("64 channels of modules are forced, which is as many as there can be")]
    TooManyForced,
    /// An expert function drives the output (io:OUT-21).
    #[error("an expert function drives Q{0}")]
    ExpertOutput(usize),
    /// No programming tool is connected (controller:FRC-01).
    #[error("no programming tool is connected")]
    NotConnected,
    /// The controller does not know this command.
    #[error("the controller has no such command")]
    NoSuchCommand,
    /// The downloaded application is not valid. The old one is already erased: the state is EMPTY
    /// (controller:DL-04).
    #[error("the application is not valid: {0}")]
    Application(#[source] LoadError),
    /// The application of an online change is not valid; the old one runs on.
    #[error("the application is not valid: {0}")]
    Change(#[source] LoadError),
    /// No statement stands in the line or after it.
    #[error("no statement stands in line {line} or after it")]
    NoStatement {
        /// The line.
        line: u32,
    },
}

/// Why a value was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum WriteError {
    /// No service answers in this state, or there is no application.
    #[error("cannot be written in state {0}")]
    State(State),
    /// The probe can only be read.
    #[error("can only be read: write a variable or a %M, %Q or %I address")]
    ReadOnly,
    /// The value is no number.
    #[error("the value is no number")]
    NotANumber,
    /// The register cannot be written (controller:MEM-07).
    #[error("the register is closed to writing, exception 02")]
    IllegalAddress,
}
