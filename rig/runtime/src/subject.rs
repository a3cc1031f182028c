//! What is under test: the model, or a real controller on the same wires (`external.rs`).

use crate::application::BundleLoader;
pub use crate::capability::Capability;
use crate::coverage::Collector;
use crate::functions;
use crate::hook::HookError;
use crate::inputs;
use crate::names::Names;
use crate::schedule::FileAct;
use controller::{
    Command, Config, ConfigError, Controller, Disturbance, Effect, Effects, FileError, FileFact, Led,
    LedPattern, LoadError, NonVolatile, OutputState, Probe, ProbeId, Refusal, State, SystemType,
    SystemVariable, TaskFigures, WriteError,
};
use expert::ExpertConfig;
use plans::steps::FileDeed;
use program::{Elementary, Program, Storage};
use signal::{Address, Cause, Kind, Level, Span, Time, Value, When};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Something inside the subject that a plan may look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observable {
    /// What the subject calls it.
    pub probe: Probe,
    /// What its values are.
    pub kind: Kind,
}

impl Observable {
    /// The names of its values, where they have any.
    pub fn labels(&self) -> Vec<(i64, String)> {
        match self.probe {
            Probe::Led(_) => {
                LedPattern::ALL.iter().map(|pattern| (pattern.number(), pattern.name().to_owned())).collect()
            }
            Probe::Output(_) => {
                OutputState::ALL.iter().map(|state| (state.number(), state.name().to_owned())).collect()
            }
            Probe::Expert { fact, .. } => functions::labels(fact),
            _ => Vec::new(),
        }
    }
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

    /// Brings the case's program into it, which takes as long as it takes on the host.
    ///
    /// # Errors
    /// [`HookError`] with what the command said.
    fn load(&mut self, _interrupt: &AtomicBool) -> Result<(), HookError> {
        Ok(())
    }

    /// The rig has something to say that is no part of what it judges: a device was lost, or is back.
    fn notice(&mut self, _at: Time, _text: &str) {}

    /// The program is there, by `now`.
    fn loaded(&mut self, _now: Time, _effects: &mut Effects) {}

    /// Takes the case's program away, behind the case.
    ///
    /// # Errors
    /// [`HookError`] with what the command said.
    fn unload(&mut self, _interrupt: &AtomicBool) -> Result<(), HookError> {
        Ok(())
    }

    /// The longest that it takes from its supply into the state in which a case begins.
    fn patience(&self) -> Span {
        Span::from_secs(60)
    }

    /// The case begins. The earliest instant at which the subject can have come into the state that it begins in, and
    /// what shows of it, where that is not what the executor sees.
    fn begin(&mut self) -> Option<(Time, Value)> {
        None
    }

    /// What reports its state, where [`Effect::State`] does not.
    fn state_probe(&self) -> Option<ProbeId> {
        None
    }

    /// Lets application code run up to and including `limit`; returns the instant that it reached: earlier when
    /// something happened that the rest of the rig must see first.
    fn run(&mut self, limit: Time, effects: &mut Effects) -> Time;

    /// Whether its program has something to compute now: time that passes brings outputs, not only timers.
    fn is_computing(&self) -> bool {
        false
    }

    /// Whether the rig itself plays it: what the rig does late, it does late.
    fn is_played(&self) -> bool {
        false
    }

    /// When it will next do something by itself.
    fn next_timer(&self) -> Option<Time>;

    /// Lets everything act that is due at `now`.
    fn fire(&mut self, now: Time, effects: &mut Effects);

    /// An input terminal has this level from `now` on; its line changed `at` the instant before.
    fn input(&mut self, now: Time, at: When, input: usize, level: Level, effects: &mut Effects);

    /// Obeys a command.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), Refusal>;

    /// Does something to a file, as a user or as the application would.
    ///
    /// # Errors
    /// [`FileError`] with the reason.
    fn file(&mut self, now: Time, act: &FileAct, effects: &mut Effects) -> Result<(), FileError>;

    /// What shows a fact of files or of the log.
    fn file_probe(&mut self, fact: FileFact) -> Probe;

    /// Lets something go wrong around it, or mends it.
    fn disturb(&mut self, now: Time, disturbance: Disturbance, effects: &mut Effects);

    /// Makes the next `times` cycles of a task take `cycle` of execution time.
    fn overload(&mut self, task: usize, cycle: Span, times: u32);

    /// Keeps a task from the processor until `until`.
    fn suspend(&mut self, task: usize, until: Time);

    /// The place of a task by its name.
    fn task(&self, name: &str) -> Option<usize>;

    /// Name of a task by its place.
    fn task_name(&self, task: usize) -> Option<&str>;

    /// Name of an expert function by its place.
    fn function_name(&self, _function: usize) -> Option<&str> {
        None
    }

    /// Name of a source file by its place.
    fn file_name(&self, file: u16) -> Option<&str>;

    /// The source files of the programs that it may get, with their places in their programs.
    fn source_files(&self) -> Vec<(u16, String)>;

    /// Names that mean something inside the subject, for suggestions.
    fn names(&self) -> Vec<String>;

    /// What a name means inside the subject: a system variable, an address, or a variable's path.
    fn observable(&self, name: &str) -> Option<Observable>;

    /// The least and the greatest value that a whole number inside can have; `None` for times, real numbers and what
    /// is not known.
    fn bounds(&self, _name: &str) -> Option<(i128, i128)> {
        None
    }

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
    /// What its variables' names mean: the case's own program, then those that steps bring.
    programs: Vec<Arc<Program>>,
    names: Names,
    /// Names and intervals; 0 for a task that is not cyclic.
    tasks: Vec<(String, Span)>,
    functions: ExpertConfig,
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
        let names = Names::default();
        let loader = Box::new(BundleLoader::new(config.profile).covered(collector).named(names.clone()));
        let tasks = config.tasks.iter();
        let tasks = tasks.map(|task| (task.name.clone(), task.interval().unwrap_or(Span::ZERO))).collect();
        let functions = config.expert.clone();
        Ok(Model {
            controller: Controller::new(config, loader, store)?,
            programs: program.into_iter().collect(),
            names,
            tasks,
            functions,
        })
    }

    /// Names of further programs mean something too, behind those that it knows.
    pub fn know(&mut self, programs: Vec<Arc<Program>>) {
        self.programs.extend(programs);
    }

    /// Prepares the storage as if this application had been downloaded and the controller left in state `left`.
    ///
    /// # Errors
    /// [`LoadError`] where the application is not valid.
    pub fn commission(&mut self, bundle: &[u8], left: State) -> Result<(), LoadError> {
        self.controller.commission(bundle, left)
    }

    /// Puts the log entries among new effects into the controller's log, in words (controller:NV-09).
    fn log(&mut self, before: usize, effects: &mut Effects) {
        for place in before..effects.list.len() {
            if let Effect::Log { at, entry } = effects.list[place] {
                let text = crate::log::show(&entry, self);
                self.controller.log_line(at, &text, effects);
            }
        }
    }

    /// The firmware is damaged from the start.
    pub fn damage_firmware(&mut self) {
        self.controller.damage_firmware();
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
        let before = effects.list.len();
        if on {
            self.controller.power_on(now, effects);
        } else {
            self.controller.power_off(now, effects);
        }
        self.log(before, effects);
    }

    fn run(&mut self, limit: Time, effects: &mut Effects) -> Time {
        let before = effects.list.len();
        let reached = self.controller.run(limit, effects);
        self.log(before, effects);
        reached
    }

    fn is_computing(&self) -> bool {
        self.controller.is_computing()
    }

    fn is_played(&self) -> bool {
        true
    }

    fn next_timer(&self) -> Option<Time> {
        self.controller.next_timer()
    }

    fn fire(&mut self, now: Time, effects: &mut Effects) {
        let before = effects.list.len();
        self.controller.fire(now, effects);
        self.log(before, effects);
    }

    fn input(&mut self, now: Time, _at: When, input: usize, level: Level, _effects: &mut Effects) {
        self.controller.input(now, input, level);
    }

    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), Refusal> {
        let before = effects.list.len();
        let answer = self.controller.command(now, command.clone(), effects);
        self.log(before, effects);
        answer
    }

    fn file(&mut self, now: Time, act: &FileAct, effects: &mut Effects) -> Result<(), FileError> {
        let (path, user) = (act.path.as_str(), act.user);
        match &act.deed {
            FileDeed::Put(bytes) => self.controller.put_file(now, path, bytes, user, effects),
            FileDeed::Fill(bytes) => self.controller.put_file(now, path, &vec![0; *bytes], user, effects),
            FileDeed::Log(entry) => self.controller.log_data(now, path, entry, effects),
            FileDeed::Remove => self.controller.remove_file(now, path, user, effects),
        }
    }

    fn file_probe(&mut self, fact: FileFact) -> Probe {
        self.controller.file_probe(fact)
    }

    fn disturb(&mut self, now: Time, disturbance: Disturbance, effects: &mut Effects) {
        self.controller.disturb(now, disturbance, effects);
    }

    fn overload(&mut self, task: usize, cycle: Span, times: u32) {
        self.controller.overload(task, cycle, times);
    }

    fn suspend(&mut self, task: usize, until: Time) {
        self.controller.suspend(task, until);
    }

    fn task(&self, name: &str) -> Option<usize> {
        self.tasks.iter().position(|(task, _)| task.eq_ignore_ascii_case(name))
    }

    fn task_name(&self, task: usize) -> Option<&str> {
        self.tasks.get(task).map(|(name, _)| name.as_str())
    }

    fn function_name(&self, function: usize) -> Option<&str> {
        self.functions.functions.get(function).map(|function| function.name.as_str())
    }

    fn file_name(&self, file: u16) -> Option<&str> {
        self.programs.first()?.files().get(usize::from(file)).map(String::as_str)
    }

    fn source_files(&self) -> Vec<(u16, String)> {
        let files = |program: &Arc<Program>| program.files().to_vec();
        self.programs.iter().flat_map(|program| (0..).zip(files(program))).collect()
    }

    fn names(&self) -> Vec<String> {
        let variables = self.programs.iter().flat_map(|program| program.variables());
        let variables = variables.map(|variable| variable.path.clone());
        let variables = variables.chain(inputs::names(self.controller.reference().input_count()));
        let variables = variables.chain(functions::names(&self.functions));
        let leds = Led::ALL.iter().flat_map(|led| ["", ".lit"].map(|end| format!("LED.{}{end}", led.name())));
        let system = SystemVariable::ALL.iter().map(|variable| variable.name().to_owned());
        variables.chain(system).chain(leds).collect()
    }

    fn observable(&self, name: &str) -> Option<Observable> {
        if let Some(variable) = SystemVariable::find(name) {
            let kind = if variable.ty() == SystemType::Bool { Kind::Bool } else { Kind::Word };
            return Some(Observable { probe: Probe::System(variable), kind });
        }
        if let Some(found) = indicator(name, self.controller.reference().output_count()) {
            return Some(found);
        }
        if let Some(found) = inputs::observable(name, self.controller.reference().input_count()) {
            return Some(found);
        }
        if let Some(found) = functions::observable(name, &self.functions) {
            return Some(found);
        }
        if name.starts_with('%') {
            return Address::parse(name).ok().map(of_address);
        }
        let variable = self.programs.iter().find_map(|program| program.find(name))?;
        if !variable.dimensions.is_empty() {
            return None;
        }
        Some(match variable.storage {
            // The memory knows no types: what is located is its bits.
            Storage::Located(address) => of_address(address),
            Storage::Cell(_) => Observable {
                probe: Probe::Variable(self.names.number(&variable.path, variable.ty)),
                kind: kind_of(variable.ty),
            },
        })
    }

    fn bounds(&self, name: &str) -> Option<(i128, i128)> {
        if let Some(variable) = SystemVariable::find(name) {
            let bits = match variable.ty() {
                SystemType::Bool => 1,
                SystemType::Word | SystemType::Uint => 16,
                SystemType::Dword => 32,
                SystemType::Lword => 64,
            };
            return Some((0, (1 << bits) - 1));
        }
        if indicator(name, self.controller.reference().output_count()).is_some()
            || inputs::observable(name, self.controller.reference().input_count()).is_some()
            || functions::observable(name, &self.functions).is_some()
        {
            return None;
        }
        // Of several programs the value may be of any.
        let mut variables = self.programs.iter().filter_map(|program| program.find(name));
        let first = variables.next()?;
        if variables.any(|other| other.ty != first.ty) {
            return None;
        }
        match first.storage {
            Storage::Located(address) => Some((0, (1i128 << address.size().bits()) - 1)),
            Storage::Cell(_) => match first.ty {
                Elementary::Bool
                | Elementary::Sint
                | Elementary::Usint
                | Elementary::Int
                | Elementary::Uint
                | Elementary::Dint
                | Elementary::Udint
                | Elementary::Lint
                | Elementary::Ulint
                | Elementary::Byte
                | Elementary::Word
                | Elementary::Dword
                | Elementary::Lword => Some(first.ty.range()),
                _ => None,
            },
        }
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

/// `LED.RUN`, `LED.RUN.lit` or `OUTPUT.Q0`, in any case of letters.
fn indicator(name: &str, outputs: usize) -> Option<Observable> {
    let upper = name.to_ascii_uppercase();
    if let Some(led) = upper.strip_prefix("LED.") {
        let (led, lit) = match led.strip_suffix(".LIT") {
            Some(led) => (Led::find(led)?, true),
            None => (Led::find(led)?, false),
        };
        return Some(match lit {
            true => Observable { probe: Probe::LedLit(led), kind: Kind::Bool },
            false => Observable { probe: Probe::Led(led), kind: Kind::State },
        });
    }
    let output = upper.strip_prefix("OUTPUT.Q")?.parse().ok().filter(|output| *output < outputs)?;
    Some(Observable { probe: Probe::Output(output), kind: Kind::State })
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
