//! Steps: what a plan does, one entry of [`VERBS`] for each verb.
//!
//! A verb is a type of value (mostly a table of keys), the powers that it needs, and a reader that makes a
//! [`Stimulus`] of a value that was held against the type.

mod application;
mod ask;
mod awaited;
mod case;
mod clock;
mod control;
mod cycle;
mod debug;
mod disturb;
mod drive;
mod encoder;
mod fault;
mod file;
mod load;
mod plant;
mod run;
mod send;
mod sequence;
mod train;
mod wave;

use std::sync::Arc;

use document::{Fields, Findings, KeySpec, KeyType, Node};
use profile::ModuleType;
use signal::{Address, Span};

use crate::frames::can::Databases;
use crate::lang::{Literal, PlanNames};
use crate::signals::frames::NamedFrame;
use crate::table::{TableFault, ValueTable};

pub use ask::Question;
pub use awaited::{AwaitedChange, StepCondition, StepWait};
pub use case::{CasePart, ProgramRef};
pub use cycle::ExactPeriod;
pub use encoder::{Encoder, ShaftMotion};
pub use send::{OutFrame, SendFrames};
pub use sequence::Sequence;
pub use train::{MAX_PULSES, TrainStimulus};
pub use wave::{MAX_SAMPLES, PeriodicWave, StimulusShape, WaveStimulus};

/// A verb of `steps`: `{ id = "busy", at = "start + 1 s", overload = { ... } }`.
#[derive(Debug)]
pub struct StepVerb {
    /// The verb as written.
    pub name: &'static str,
    /// What it does, one sentence, for the schema and the manual.
    pub doc: &'static str,
    /// What its value is.
    pub value: KeyType,
    /// The powers that it needs of rig and subject, words of [`crate::lang::CAPABILITIES`].
    pub needs: &'static [&'static str],
    /// Makes the stimulus of a value that was held against `value`. `None` after it reported what is wrong.
    pub(crate) read: fn(&Node, &dyn StepNames, &mut Findings) -> Option<Stimulus>,
}

/// What a verb's reader may ask of the plan around it, beside instants and signals.
pub(crate) trait StepNames: PlanNames {
    /// The name of a signal of which every change counts; reports one whose trace leaves some out.
    fn whole_signal(&self, node: &Node, out: &mut Findings) -> Option<String>;
    /// The table of this name, a file relative to the plan.
    ///
    /// # Errors
    /// Why there is none.
    fn table(&self, name: &str) -> Result<Arc<ValueTable>, TableFault>;
    /// The DBC files that the plan may name.
    fn databases(&self) -> &Databases;
    /// The frames of this name.
    fn frame(&self, name: &str) -> Option<NamedFrame>;
    /// The names of all frames.
    fn frame_names(&self) -> Vec<&str>;
}

/// The fields of a table that was held against these keys before.
pub(crate) fn table_fields<'n>(node: &'n Node, specs: &'static [KeySpec]) -> Option<Fields<'n>> {
    Some(Fields::checked(node.as_table()?, specs))
}

/// Every verb of `steps`, in alphabetical order.
pub static VERBS: &[StepVerb] = &[
    ask::ASK,
    clock::BATTERY,
    debug::BREAKPOINT,
    fault::CLEAR,
    debug::CLEAR_BREAKPOINTS,
    control::COMMAND,
    application::DOWNLOAD,
    encoder::ENCODER,
    disturb::EXTERNAL_ERROR,
    fault::FAULT,
    file::FILE,
    application::FIRMWARE,
    drive::FORCE,
    disturb::INTERNAL_ERROR,
    disturb::LINK_CUT,
    control::MARK,
    disturb::MODULE_FAULT,
    application::MULTIPLE_DOWNLOAD,
    wave::NOISE,
    debug::ONLINE_CHANGE,
    disturb::OVER_TEMPERATURE,
    load::OVERLOAD,
    application::PLACE_BOOT_APPLICATION,
    control::POWER,
    control::POWER_CUT,
    drive::PULSE,
    wave::RAMP,
    drive::RELEASE,
    application::RESET_ORIGIN_DEVICE,
    debug::RESUME,
    run::RUN,
    send::SEND,
    sequence::SEQUENCE,
    drive::SET,
    clock::SET_CLOCK,
    plant::SET_PLANT,
    disturb::SHORT_CIRCUIT,
    wave::SINE,
    wave::SQUARE,
    debug::STEP_STATEMENT,
    disturb::SUPPLY_BUS,
    disturb::SUPPLY_IO,
    load::SUSPEND,
    control::SWITCH,
    train::TRAIN,
    wave::TRIANGLE,
    drive::WRITE,
];

/// A command to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanCommand {
    /// Run.
    Run,
    /// Stop.
    Stop,
    /// Reset warm.
    ResetWarm,
    /// Reset cold.
    ResetCold,
    /// Reset origin.
    ResetOrigin,
    /// Reboot by script.
    Reboot,
    /// Make the application in memory the boot application.
    CreateBootApplication,
    /// Remove the application.
    DeleteApplication,
    /// A programming tool connects.
    Login,
    /// The programming tool disconnects and ends forcing.
    Logout,
    /// The programming tool disconnects and keeps forcing.
    LogoutKeepForcing,
    /// Every indicator begins to flash.
    IdentifyOn,
    /// The indicators show again what they are for.
    IdentifyOff,
}

/// What goes wrong around the controller or in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisturbanceKind {
    /// A short circuit at an output.
    ShortCircuit(Address),
    /// An output is too hot.
    OverTemperature(Address),
    /// The supply of inputs and outputs is off.
    NoIoSupply,
    /// A part outside of the controller is in error: its bit of PLC_R.i_lwSystemFault_1.
    External(u8),
    /// The controller itself is in error.
    Internal(InternalErrorKind),
    /// Something is wrong with an expansion module.
    Module {
        /// Its index in TM3_MODULE_R.
        index: u8,
        /// What is wrong.
        fault: ModuleFaultKind,
    },
    /// The expansion bus has no supply.
    NoBusSupply,
    /// Transmitter and receiver are not joined.
    NoBusLink,
    /// The battery of the clock has this charge, in per cent; 0 where it is empty or taken out.
    Battery(u8),
}

/// What is wrong with an expansion module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModuleFaultKind {
    /// It does not answer, for so many exchanges; `None`: until it is taken back.
    Silent(Option<u32>),
    /// It is pulled out.
    Pulled,
    /// Another module is in its place; none where that is over.
    Replaced(Option<&'static ModuleType>),
    /// It does not answer, and disturbs the modules beside it.
    Disturbs,
    /// Its own supply is off.
    Unsupplied,
}

/// What goes wrong inside the controller (controller:ERR-01, controller:WD-14).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InternalErrorKind {
    /// The hardware's watchdog expires: HALT that only a power cycle ends.
    HardwareWatchdog,
    /// An error of the firmware: HALT that only a power cycle ends.
    Firmware,
    /// An exception of firmware or hardware that cannot be managed: a system error.
    FirmwareException,
}

impl InternalErrorKind {
    /// Every kind.
    pub const ALL: [InternalErrorKind; 3] = [
        InternalErrorKind::HardwareWatchdog,
        InternalErrorKind::Firmware,
        InternalErrorKind::FirmwareException,
    ];

    /// Its name in a plan.
    pub const fn name(self) -> &'static str {
        match self {
            InternalErrorKind::HardwareWatchdog => "hardware-watchdog",
            InternalErrorKind::Firmware => "firmware",
            InternalErrorKind::FirmwareException => "firmware-exception",
        }
    }
}

/// What is done to a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileOperation {
    /// It is written whole.
    Put(Vec<u8>),
    /// It is written with so many bytes of 0.
    Fill(usize),
    /// An entry is added to it.
    Log(String),
    /// It is removed.
    Remove,
}

/// What a fault does to a line.
#[derive(Clone, Debug, PartialEq)]
pub enum LineFault {
    /// It keeps this value.
    Stuck(Literal),
    /// It is cut.
    Open,
    /// It is at 0 V.
    ShortToGround,
    /// It is at the supply.
    ShortToSupply,
    /// It has this value for this time.
    Glitch {
        /// The value.
        value: Literal,
        /// The time, above 0.
        width: Span,
    },
    /// Every change comes this much later.
    Late(Span),
    /// Its device is gone.
    Lost,
}

/// What a step does.
#[derive(Clone, Debug, PartialEq)]
pub enum Stimulus {
    /// Drives lines, all at once.
    Set(Vec<(String, Literal)>),
    /// Drives a line, then drives it back to what it was.
    Pulse {
        /// The line.
        signal: String,
        /// What it is driven to.
        value: Literal,
        /// For how long, above 0.
        width: Span,
    },
    /// Forces an input or output of the controller.
    Force {
        /// The input or output.
        signal: String,
        /// The forced value.
        value: Literal,
    },
    /// Ends forcing.
    Release {
        /// The input or output.
        signal: String,
    },
    /// Writes a variable or a place of memory.
    Write {
        /// The variable or place.
        of: String,
        /// The value.
        value: Literal,
    },
    /// Commands the controller.
    Command(PlanCommand),
    /// Sets the real-time clock.
    SetClock {
        /// Seconds since 1970-01-01 00:00 UTC.
        seconds: i64,
    },
    /// Moves the Run/Stop switch: TRUE to Run.
    Switch(bool),
    /// Downloads an application.
    Download {
        /// `None`: the case's own program again.
        program: Option<ProgramRef>,
        /// Whether it becomes the boot application too (controller:STATE-12).
        boot: bool,
    },
    /// Damages the firmware (FALSE), or restores it from an SD card.
    Firmware(bool),
    /// Downloads an application as one of several.
    MultipleDownload {
        /// `None`: the case's own program again.
        program: Option<ProgramRef>,
        /// Start all applications after download or online change.
        start: bool,
    },
    /// Puts a boot application into the controller by SD card or FTP; `None`: the case's own program.
    PlaceBootApplication(Option<ProgramRef>),
    /// Resets the selected parts of the device to their origin.
    ResetOriginDevice {
        /// Users and groups.
        user_management: bool,
        /// Application and variables.
        plc_logic: bool,
        /// Certificates.
        certificates: bool,
    },
    /// Switches the supply off, and on again after this time, above 0.
    PowerCut(Span),
    /// Switches the supply on or off.
    Power(bool),
    /// The next cycles of a task take this long in all.
    Overload {
        /// Name of the task.
        task: String,
        /// Time of execution of one cycle.
        cycle: Span,
        /// How many cycles.
        times: u32,
    },
    /// A task does not get the processor for this long, above 0.
    Suspend {
        /// Name of the task.
        task: String,
        /// For how long.
        lasts: Span,
    },
    /// Sets a parameter of a plant of the board.
    SetPlant {
        /// Name of the plant.
        plant: String,
        /// Name of the parameter.
        parameter: String,
        /// What it is from then on.
        value: Literal,
        /// For how long; `None`: until another step sets it.
        lasts: Option<Span>,
    },
    /// Puts a fault on a line.
    Fault {
        /// The line.
        signal: String,
        /// The fault.
        kind: LineFault,
        /// For how long; `None`: until it is cleared.
        lasts: Option<Span>,
    },
    /// Writes or removes a file of the controller.
    File {
        /// Its path.
        path: String,
        /// What is done to it.
        deed: FileOperation,
        /// Whether the application does it, in place of a user.
        by_application: bool,
    },
    /// Takes every fault off a line.
    Clear {
        /// The line.
        signal: String,
    },
    /// Something goes wrong around the controller, or is fixed.
    Disturb {
        /// What.
        what: DisturbanceKind,
        /// Whether it begins.
        on: bool,
        /// For how long; `None`: until another step fixes it.
        lasts: Option<Span>,
    },
    /// Emits a train of pulses.
    Train(TrainStimulus),
    /// Drives a line with values that change by a rule.
    Wave(WaveStimulus),
    /// Emits what an encoder emits as it turns.
    Encoder(Encoder),
    /// Drives lines with the values of a table.
    Sequence(Sequence),
    /// Holds the tasks where one comes to the first statement of a line.
    Breakpoint {
        /// Line, from 1.
        line: u32,
        /// The source as the plan names it; `None`: the first one.
        file: Option<String>,
    },
    /// Takes every breakpoint away.
    ClearBreakpoints,
    /// Tasks that are held go on.
    Resume,
    /// A task that is held goes on to its next statement.
    StepStatement,
    /// Another program takes over.
    OnlineChange(ProgramRef),
    /// Runs a group: its steps are further steps of the case.
    Run {
        /// The group.
        group: String,
    },
    /// Puts frames on a bus.
    Send(Box<SendFrames>),
    /// Asks a person.
    Ask(Question),
    /// Nothing: marks an instant.
    Mark,
}

impl Stimulus {
    /// The verb that it is written with.
    pub fn verb(&self) -> &'static str {
        match self {
            Stimulus::Set(_) => "set",
            Stimulus::Pulse { .. } => "pulse",
            Stimulus::Force { .. } => "force",
            Stimulus::Release { .. } => "release",
            Stimulus::Write { .. } => "write",
            Stimulus::Command(_) => "command",
            Stimulus::Switch(_) => "switch",
            Stimulus::Download { .. } => "download",
            Stimulus::Firmware(_) => "firmware",
            Stimulus::MultipleDownload { .. } => "multiple-download",
            Stimulus::PlaceBootApplication(_) => "place-boot-application",
            Stimulus::ResetOriginDevice { .. } => "reset-origin-device",
            Stimulus::PowerCut(_) => "power-cut",
            Stimulus::Power(_) => "power",
            Stimulus::Overload { .. } => "overload",
            Stimulus::Suspend { .. } => "suspend",
            Stimulus::SetPlant { .. } => "set-plant",
            Stimulus::Fault { .. } => "fault",
            Stimulus::File { .. } => "file",
            Stimulus::Clear { .. } => "clear",
            Stimulus::Disturb { what: DisturbanceKind::ShortCircuit(_), .. } => "short-circuit",
            Stimulus::Disturb { what: DisturbanceKind::OverTemperature(_), .. } => "over-temperature",
            Stimulus::Disturb { what: DisturbanceKind::NoIoSupply, .. } => "supply-io",
            Stimulus::Disturb { what: DisturbanceKind::External(_), .. } => "external-error",
            Stimulus::Disturb { what: DisturbanceKind::Internal(_), .. } => "internal-error",
            Stimulus::Disturb { what: DisturbanceKind::Module { .. }, .. } => "module-fault",
            Stimulus::Disturb { what: DisturbanceKind::NoBusSupply, .. } => "supply-bus",
            Stimulus::Disturb { what: DisturbanceKind::NoBusLink, .. } => "link-cut",
            Stimulus::Disturb { what: DisturbanceKind::Battery(_), .. } => "battery",
            Stimulus::SetClock { .. } => "set-clock",
            Stimulus::Train(_) => "train",
            Stimulus::Wave(wave) => wave.verb(),
            Stimulus::Encoder(_) => "encoder",
            Stimulus::Sequence(_) => "sequence",
            Stimulus::Breakpoint { .. } => "breakpoint",
            Stimulus::ClearBreakpoints => "clear-breakpoints",
            Stimulus::Resume => "resume",
            Stimulus::StepStatement => "step-statement",
            Stimulus::OnlineChange(_) => "online-change",
            Stimulus::Run { .. } => "run",
            Stimulus::Send(_) => "send",
            Stimulus::Ask(_) => "ask",
            Stimulus::Mark => "mark",
        }
    }

    /// The powers that it needs of rig and subject.
    pub fn needs(&self) -> &'static [&'static str] {
        let name = self.verb();
        VERBS.iter().find(|verb| verb.name == name).map_or(&[], |verb| verb.needs)
    }

    /// Whether the controller can refuse it.
    pub fn can_be_refused(&self) -> bool {
        matches!(
            self,
            Stimulus::Command(_)
                | Stimulus::Download { .. }
                | Stimulus::File { .. }
                | Stimulus::Firmware(_)
                | Stimulus::Force { .. }
                | Stimulus::MultipleDownload { .. }
                | Stimulus::PlaceBootApplication(_)
                | Stimulus::Release { .. }
                | Stimulus::ResetOriginDevice { .. }
                | Stimulus::SetClock { .. }
                | Stimulus::Breakpoint { .. }
                | Stimulus::Resume
                | Stimulus::StepStatement
                | Stimulus::OnlineChange(_)
                | Stimulus::Write { .. }
        )
    }

    /// How long after its step it is done, 0 where it is done at once.
    pub fn duration(&self) -> Span {
        match self {
            Stimulus::Pulse { width, .. } | Stimulus::Fault { kind: LineFault::Glitch { width, .. }, .. } => {
                *width
            }
            Stimulus::PowerCut(lasts) | Stimulus::Suspend { lasts, .. } => *lasts,
            Stimulus::Fault { lasts: Some(lasts), .. }
            | Stimulus::SetPlant { lasts: Some(lasts), .. }
            | Stimulus::Disturb { lasts: Some(lasts), .. } => *lasts,
            Stimulus::Train(train) => train.length(),
            Stimulus::Wave(wave) => wave.lasts.unwrap_or(Span::ZERO),
            Stimulus::Encoder(encoder) => encoder.length(),
            Stimulus::Sequence(sequence) => sequence.length(),
            Stimulus::Send(send) => send.length(),
            _ => Span::ZERO,
        }
    }

    /// Pulses per time that a line must be able to emit for it, in thousandths of a Hertz.
    pub fn millihertz(&self) -> Option<u64> {
        match self {
            Stimulus::Train(train) => Some(train.millihertz()),
            Stimulus::Wave(wave) => wave.millihertz(),
            Stimulus::Encoder(encoder) => Some(encoder.millihertz()),
            _ => None,
        }
    }

    /// The program that it brings to the controller, where that is not the case's own.
    pub fn program(&self) -> Option<&ProgramRef> {
        match self {
            Stimulus::Download { program, .. }
            | Stimulus::MultipleDownload { program, .. }
            | Stimulus::PlaceBootApplication(program) => program.as_ref(),
            Stimulus::OnlineChange(program) => Some(program),
            _ => None,
        }
    }

    /// The signals that it drives, forces or writes.
    pub fn signals(&self) -> Vec<&str> {
        match self {
            Stimulus::Set(list) => list.iter().map(|(signal, _)| signal.as_str()).collect(),
            Stimulus::Pulse { signal, .. }
            | Stimulus::Force { signal, .. }
            | Stimulus::Release { signal }
            | Stimulus::Write { of: signal, .. }
            | Stimulus::Fault { signal, .. }
            | Stimulus::Clear { signal } => vec![signal],
            Stimulus::Train(train) => vec![&train.signal],
            Stimulus::Wave(wave) => vec![&wave.signal],
            Stimulus::Encoder(encoder) => encoder.lines().collect(),
            Stimulus::Sequence(sequence) => {
                sequence.columns.iter().map(|(_, signal)| signal.as_str()).collect()
            }
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::CAPABILITIES;

    #[test]
    fn verbs_are_in_order_and_need_known_powers() {
        assert!(VERBS.windows(2).all(|pair| pair[0].name < pair[1].name));
        for need in VERBS.iter().flat_map(|verb| verb.needs) {
            assert!(CAPABILITIES.iter().any(|one| one.word == *need), "{need}");
        }
    }
}
