//! The board file: which controller is tested, on which board, bound how.

pub mod accuracy;
mod bench;
mod buses;
mod check;
pub mod clock;
pub(crate) mod control;
mod delays;
mod devices;
mod guard;
mod keys;
mod modules;
mod parts;
mod ports;
mod read;
mod real;
mod realtime;
mod relays;
mod sim_buses;
pub mod statements;
mod subject;

use document::{Diagnostic, SourceFile};
use signal::calendar::Date;
use signal::{Address, Area, Coverage};

use crate::adc::{AdcsSpec, Calibrated, calibrated};
use crate::channel_table::ChannelTable;
use crate::circuit::{ChannelSpec, Circuit, CircuitError};
use crate::real::{self as real_devices, OfflineBoard, RealSpec};
use crate::sensor::SensorCurve;
use crate::wrap::{Disturbance, Faulty};
use crate::{Board, BoardContext, ChannelId, LoopbackPair, RealtimeSettings, SimulatedBoard};

use crate::codes;
pub use crate::codes::CODES;
use crate::number;
pub use clock::BoardClock;
pub use control::{ControlSettings, OnDisconnect};
pub use delays::ChannelDelay;
pub use guard::{Bite, GuardSettings, WatchdogSettings};
pub use keys::KEYS;
pub use modules::{ModuleTerminal, ModuleTerminalKind};
pub use ports::{PortBinding, SubjectPort, SubjectPortKind};
pub use read::{read, read_with_programs};
pub use statements::Statement;
pub use subject::{External, Subject, SubjectLines};

/// The terminals of a controller that a board can be bound to, in the order of their numbers, and its ports.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Terminals {
    /// Its embedded inputs: `I0` is the first.
    pub inputs: Vec<Address>,
    /// Its embedded outputs: `Q0` is the first.
    pub outputs: Vec<Address>,
    /// Its ports.
    pub ports: Vec<SubjectPort>,
    /// The references of the modules that can be fitted beside it.
    pub modules: Vec<String>,
}

/// A subject that does not exist, with the names that do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnknownSubject {
    /// No such profile.
    Profile {
        /// The profiles.
        known: Vec<String>,
    },
    /// The profile has no such reference.
    Reference {
        /// The profile's references.
        known: Vec<String>,
    },
}

/// A terminal of the controller and the channel that it is wired to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// The terminal, in the input or output area.
    pub address: Address,
    /// The channel.
    pub channel: ChannelId,
}

/// What is behind the channels.
#[derive(Clone, Debug, Default)]
pub enum BoardKind {
    /// Modelled lines: the circuit.
    #[default]
    Simulated,
    /// Devices of this machine.
    Real(Box<RealSpec>),
}

/// What a case does when a device is lost. It is an `error` in any case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnLoss {
    /// It ends early, through its teardown.
    End,
    /// It goes on with what is left.
    #[default]
    GoOn,
}

/// A board file that was read and is sound.
#[derive(Clone, Debug)]
pub struct BoardFile {
    /// Path as the user gave it; `default board` for the one without a file.
    pub name: String,
    /// Its title; may be empty.
    pub title: String,
    /// The controller under test.
    pub subject: Subject,
    /// Its lines beside its terminals.
    pub lines: SubjectLines,
    /// What kind of board it is.
    pub kind: BoardKind,
    /// The loop by which the rig checks itself before a run on real lines.
    pub check: Option<LoopbackPair>,
    /// The channels, and what else the simulated board is made of.
    pub circuit: Circuit,
    /// Terminals and channels, by address; inputs first. Each address once.
    pub bind: Vec<Binding>,
    /// Channels at terminals of modules that carry what a temperature sensor shows, with its curve.
    pub sensors: Vec<(ChannelId, SensorCurve)>,
    /// Ports of the controller and their buses, in the order of the file. Each port and each bus once.
    pub ports: Vec<PortBinding>,
    /// The references of the modules that are fitted, in the order of the bus; exactly those that are configured if none.
    pub fitted: Option<Vec<String>>,
    /// Trouble that the board is to make by itself, if any.
    pub disturbance: Option<Disturbance>,
    /// How the outputs of a real board are guarded.
    pub guard: GuardSettings,
    /// How punctual a run on real lines has to be.
    pub realtime: RealtimeSettings,
    /// The clock that stamps what the board sees.
    pub clock: BoardClock,
    /// Delays between the terminals and the lines of a real board, by channel.
    pub delays: Vec<ChannelDelay>,
    /// The files of the programs that its plants run, each once: filled in by whoever read them.
    pub programs: Vec<SourceFile>,
    /// What is worth knowing of these programs.
    pub warnings: Vec<Diagnostic>,
    /// What the file states of the errors of what the board sees, in its order.
    pub statements: Vec<Statement>,
    /// What becomes of a case that loses a device.
    pub on_loss: OnLoss,
    /// How the control socket is served while it is kept running.
    pub control: ControlSettings,
}

impl BoardFile {
    /// The board without a file: a simulated one with a channel `I0`, `I1`, ... for every input and `Q0`, `Q1`,
    /// ... for every output, in the order given; and nothing between them. The subject is the default one.
    pub fn default_for(inputs: &[Address], outputs: &[Address]) -> Self {
        let mut circuit = Circuit::default();
        let mut bind = Vec::new();
        for (letter, addresses) in [('I', inputs), ('Q', outputs)] {
            for (number, address) in addresses.iter().enumerate() {
                let Ok(place) = u16::try_from(circuit.channels.len()) else { break };
                circuit.channels.push(ChannelSpec::default_of(format!("{letter}{number}"), *address));
                bind.push(Binding { address: *address, channel: ChannelId(place) });
            }
        }
        bind.sort_by_key(|binding| binding.address);
        BoardFile {
            name: "default board".into(),
            title: String::new(),
            subject: Subject::default(),
            lines: SubjectLines::default(),
            kind: BoardKind::Simulated,
            check: None,
            circuit,
            bind,
            sensors: Vec::new(),
            ports: Vec::new(),
            fitted: None,
            disturbance: None,
            guard: GuardSettings::default(),
            realtime: RealtimeSettings::default(),
            clock: BoardClock::default(),
            delays: Vec::new(),
            programs: Vec::new(),
            warnings: Vec::new(),
            statements: Vec::new(),
            on_loss: OnLoss::default(),
            control: ControlSettings::default(),
        }
    }

    /// Whether its lines are real ones, which live in the host's time alone.
    pub fn is_real(&self) -> bool {
        matches!(self.kind, BoardKind::Real(_))
    }

    /// Whether a device that went away is opened again when it is there again.
    pub fn reconnects(&self) -> bool {
        matches!(&self.kind, BoardKind::Real(spec) if spec.limits.reconnect)
    }

    /// The channels, as devices need them.
    pub fn channel_table(&self) -> ChannelTable {
        ChannelTable { file: self.name.clone(), channels: self.circuit.channels.clone() }
    }

    /// The calibrated channels as they stand on this day.
    pub fn calibrated(&self, today: Date) -> Vec<Calibrated> {
        match &self.kind {
            BoardKind::Simulated => Vec::new(),
            BoardKind::Real(spec) => {
                let of = |spec| calibrated(&self.channel_table(), spec, today);
                spec.of::<AdcsSpec>().map_or_else(Vec::new, of)
            }
        }
    }

    /// What the uncertainty of the channels' values covers, where that is no bound: `95 %`, as records say it.
    pub fn coverages(&self) -> Vec<(ChannelId, String)> {
        let BoardKind::Real(spec) = &self.kind else { return Vec::new() };
        let Some(spec) = spec.of::<AdcsSpec>() else { return Vec::new() };
        let stated = spec.samples.iter().map(|sample| (sample.channel, spec.coverage_of(sample)));
        let stated = stated.filter(|(_, list)| list.iter().any(|one| *one != Coverage::Limits));
        stated.map(|(channel, list)| (channel, Coverage::together(list))).collect()
    }

    /// The channel that a terminal is wired to.
    pub fn channel_of(&self, address: Address) -> Option<ChannelId> {
        self.bind.iter().find(|binding| binding.address == address).map(|binding| binding.channel)
    }

    /// Whether it follows from what a channel is bound to that the rig drives it: with the model as subject the
    /// controller's outputs, with a real controller its inputs. `None` where nothing is bound to it.
    pub fn is_driven(&self, channel: ChannelId) -> Option<bool> {
        let external = self.subject.is_external();
        let bound = |binding: &&Binding| binding.channel == channel;
        let output = |binding: &Binding| (binding.address.area() == Area::Output) != external;
        let SubjectLines { power, run_stop, alarm } = self.lines;
        let lines = [(power, external), (run_stop, external), (alarm, !external)];
        let lines = lines.into_iter().filter(|(line, _)| *line == Some(channel)).map(|(_, driven)| driven);
        lines.chain(self.bind.iter().filter(bound).map(output)).reduce(|one, other| one | other)
    }

    /// The channel of this name.
    pub fn find(&self, name: &str) -> Option<ChannelId> {
        let place = self.circuit.channels.iter().position(|channel| channel.name == name)?;
        u16::try_from(place).ok().map(ChannelId)
    }
}

/// Builds the board of a file; all that is random on it follows from `seed`. Of real lines it is the [`OfflineBoard`],
/// which touches no device: what a plan can be checked against on any machine.
///
/// # Errors
/// The first of [`Circuit::check`]: none for a file that [`read`] let through.
pub fn build(file: &BoardFile, seed: u64) -> Result<Box<dyn Board>, CircuitError> {
    if let BoardKind::Real(spec) = &file.kind {
        return Ok(Box::new(OfflineBoard::new(&file.channel_table(), spec)));
    }
    let board = SimulatedBoard::new(&file.circuit, seed)?;
    Ok(match file.disturbance {
        Some(disturbance) => Box::new(Faulty::new(board, disturbance, seed)),
        None => Box::new(board),
    })
}

/// Opens the real board of a file: finds and claims its lines, outputs at their safe values. `None` where the file's
/// board is one that [`build`] makes.
///
/// # Errors
/// All that is not there, not free, not permitted or cannot be done, at its place in the file, under [`CODES`].
pub fn open(file: &BoardFile, context: &BoardContext) -> Result<Option<Box<dyn Board>>, Vec<Diagnostic>> {
    match &file.kind {
        BoardKind::Simulated => Ok(None),
        BoardKind::Real(spec) => Ok(Some(real_devices::open(&file.channel_table(), spec, context)?)),
    }
}
