//! What is under test: the model, and later a real controller on the same wires.

use crate::application::BundleLoader;
use crate::coverage::Collector;
use controller::{
    Command, Config, ConfigError, Controller, Effects, LoadError, NonVolatile, Probe, ProbeId, Refusal,
    State, SystemVariable, TaskFigures, WriteError,
};
use program::{Elementary, Program, Storage};
use signal::{Address, Cause, Kind, Level, Span, Time, Value};
use std::sync::Arc;

/// A power that a subject or a board may have and a plan may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Capability {
    /// Modelled load can be put on a task.
    TaskLoad,
    /// System variables can be read.
    SystemVariables,
    /// Variables, %M and the images can be read and written.
    MemoryAccess,
    /// Run, stop and resets can be commanded.
    Commands,
    /// Inputs and outputs can be forced.
    Force,
    /// The supply can be switched.
    Power,
    /// An application can be downloaded.
    Download,
    /// Electrical faults can be put on lines.
    Faults,
}

impl Capability {
    /// Every capability.
    pub const ALL: [Capability; 8] = [
        Capability::TaskLoad,
        Capability::SystemVariables,
        Capability::MemoryAccess,
        Capability::Commands,
        Capability::Force,
        Capability::Power,
        Capability::Download,
        Capability::Faults,
    ];

    /// The word in a plan's `needs`.
    pub const fn word(self) -> &'static str {
        match self {
            Capability::TaskLoad => "task-load",
            Capability::SystemVariables => "system-variables",
            Capability::MemoryAccess => "memory-access",
            Capability::Commands => "commands",
            Capability::Force => "force",
            Capability::Power => "power",
            Capability::Download => "download",
            Capability::Faults => "faults",
        }
    }

    /// The capability of this word.
    pub fn find(word: &str) -> Option<Capability> {
        Capability::ALL.into_iter().find(|capability| capability.word() == word)
    }
}

/// Something inside the subject that a plan may look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observable {
    /// What the subject calls it.
    pub probe: Probe,
    /// What its values are.
    pub kind: Kind,
}

/// A controller under test.
///
/// The executor lets its program run to the next instant at which anything else happens, then lets its timers act.
/// A controller on real wires runs by itself: its `run` returns the limit at once and it has no timers.
pub trait Subject: Send {
    /// The powers that it gives a plan.
    fn capabilities(&self) -> &'static [Capability];

    /// Switches its supply.
    fn power(&mut self, now: Time, on: bool, effects: &mut Effects);

    /// Lets application code run up to and including `limit`; returns the instant that it reached: earlier when
    /// something happened that the rest of the rig must see first.
    fn run(&mut self, limit: Time, effects: &mut Effects) -> Time;

    /// When it will next do something by itself.
    fn next_timer(&self) -> Option<Time>;

    /// Lets everything act that is due at `now`.
    fn fire(&mut self, now: Time, effects: &mut Effects);

    /// An input terminal has this level from `now` on.
    fn input(&mut self, now: Time, input: usize, level: Level);

    /// Obeys a command.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), Refusal>;

    /// Makes the next `times` cycles of a task take `cycle` of execution time.
    fn overload(&mut self, task: usize, cycle: Span, times: u32);

    /// The place of a task by its name.
    fn task(&self, name: &str) -> Option<usize>;

    /// Name of a task by its place.
    fn task_name(&self, task: usize) -> Option<&str>;

    /// Name of a source file by its place.
    fn file_name(&self, file: u8) -> Option<&str>;

    /// Names that mean something inside the subject, for suggestions.
    fn names(&self) -> Vec<String>;

    /// What a name means inside the subject: a system variable, an address, or a variable's path.
    fn observable(&self, name: &str) -> Option<Observable>;

    /// From now on changes of this are reported as effects.
    fn watch(&mut self, probe: Probe) -> ProbeId;

    /// Its value now.
    fn read(&self, probe: &Probe) -> Value;

    /// Writes a variable or a place in memory.
    ///
    /// # Errors
    /// [`WriteError`] with the reason.
    fn write(
        &mut self,
        now: Time,
        probe: &Probe,
        value: Value,
        cause: Cause,
        effects: &mut Effects,
    ) -> Result<(), WriteError>;

    /// Its state.
    fn state(&self) -> State;

    /// What its tasks did, in the order of the configuration.
    fn figures(&self) -> Vec<(String, Span, TaskFigures)>;
}

/// The model as subject.
#[derive(Debug)]
pub struct Model {
    controller: Controller,
    program: Option<Arc<Program>>,
    tasks: Vec<(String, Span)>,
}

impl Model {
    /// A model without power. `program` is what its variables' names mean, if there is one; what runs of the
    /// applications that it loads is added to the collector, if there is one.
    ///
    /// # Errors
    /// [`ConfigError`] for a configuration that the profile does not accept.
    pub fn new(
        config: Config,
        program: Option<Arc<Program>>,
        store: Box<dyn NonVolatile>,
        collector: Option<Collector>,
    ) -> Result<Model, ConfigError> {
        let loader = Box::new(BundleLoader::new(config.profile).covered(collector));
        let tasks = config.tasks.iter().map(|task| (task.name.clone(), task.interval())).collect();
        Ok(Model { controller: Controller::new(config, loader, store)?, program, tasks })
    }

    /// Prepares the storage as if this application had been downloaded and the controller left in state `left`.
    ///
    /// # Errors
    /// [`LoadError`] where the application is not valid.
    pub fn commission(&mut self, bundle: &[u8], left: State) -> Result<(), LoadError> {
        self.controller.commission(bundle, left)
    }

    /// The controller, to look into.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }
}

impl Subject for Model {
    fn capabilities(&self) -> &'static [Capability] {
        &Capability::ALL
    }

    fn power(&mut self, now: Time, on: bool, effects: &mut Effects) {
        if on {
            self.controller.power_on(now, effects);
        } else {
            self.controller.power_off(now, effects);
        }
    }

    fn run(&mut self, limit: Time, effects: &mut Effects) -> Time {
        self.controller.run(limit, effects)
    }

    fn next_timer(&self) -> Option<Time> {
        self.controller.next_timer()
    }

    fn fire(&mut self, now: Time, effects: &mut Effects) {
        self.controller.fire(now, effects);
    }

    fn input(&mut self, now: Time, input: usize, level: Level) {
        self.controller.input(now, input, level);
    }

    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), Refusal> {
        self.controller.command(now, command.clone(), effects)
    }

    fn overload(&mut self, task: usize, cycle: Span, times: u32) {
        self.controller.overload(task, cycle, times);
    }

    fn task(&self, name: &str) -> Option<usize> {
        self.tasks.iter().position(|(task, _)| task.eq_ignore_ascii_case(name))
    }

    fn task_name(&self, task: usize) -> Option<&str> {
        self.tasks.get(task).map(|(name, _)| name.as_str())
    }

    fn file_name(&self, file: u8) -> Option<&str> {
        self.program.as_ref()?.files().get(usize::from(file)).map(String::as_str)
    }

    fn names(&self) -> Vec<String> {
        let variables = self.program.iter().flat_map(|program| program.variables());
        let variables = variables.map(|variable| variable.path.clone());
        variables.chain(SystemVariable::ALL.iter().map(|variable| variable.name().to_owned())).collect()
    }

    fn observable(&self, name: &str) -> Option<Observable> {
        if let Some(variable) = SystemVariable::find(name) {
            return Some(Observable { probe: Probe::System(variable), kind: Kind::Word });
        }
        if name.starts_with('%') {
            return Address::parse(name).ok().map(of_address);
        }
        let variable = self.program.as_ref()?.find(name)?;
        if !variable.dimensions.is_empty() {
            return None;
        }
        Some(match variable.storage {
            // The memory knows no types: what is located is its bits.
            Storage::Located(address) => of_address(address),
            Storage::Cell(cell) => Observable { probe: Probe::Variable(cell.0), kind: kind_of(variable.ty) },
        })
    }

    fn watch(&mut self, probe: Probe) -> ProbeId {
        self.controller.watch(probe)
    }

    fn read(&self, probe: &Probe) -> Value {
        self.controller.read(probe)
    }

    fn write(
        &mut self,
        now: Time,
        probe: &Probe,
        value: Value,
        cause: Cause,
        effects: &mut Effects,
    ) -> Result<(), WriteError> {
        self.controller.write(now, probe, value, cause, effects)
    }

    fn state(&self) -> State {
        self.controller.state()
    }

    fn figures(&self) -> Vec<(String, Span, TaskFigures)> {
        let named = self.tasks.iter().enumerate();
        named
            .filter_map(|(task, (name, interval))| {
                Some((name.clone(), *interval, self.controller.task_figures(task)?))
            })
            .collect()
    }
}

fn of_address(address: Address) -> Observable {
    let kind = if address.bit_len() == 1 { Kind::Bool } else { Kind::Word };
    Observable { probe: Probe::Address(address), kind }
}

fn kind_of(ty: Elementary) -> Kind {
    match ty {
        Elementary::Bool => Kind::Bool,
        Elementary::Real | Elementary::Lreal => Kind::Real,
        Elementary::Byte | Elementary::Word | Elementary::Dword | Elementary::Lword | Elementary::Ulint => {
            Kind::Word
        }
        _ => Kind::Int,
    }
}
