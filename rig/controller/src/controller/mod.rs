//! The controller: its parts, and what can be asked of it.

mod breakpoint;
mod commands;
mod disturbance;
mod edges;
mod exchange;
mod files;
mod forcing;
mod front_panel;
mod functions;
mod internal_error;
mod leds;
mod observe;
mod online_change;
mod ports;
mod registers;
mod scan;
mod startup;
mod system_calls;
mod system_commands;
mod system_variables;
mod tasks;
mod timers;
mod transition;
mod watchdog;

pub use front_panel::FrontPanel;

use crate::external::ExternalErrors;
use crate::files::Files;
use crate::io::EmbeddedIo;
use crate::last_state::LastState;
use crate::led::Leds;
use crate::modules::Modules;
use crate::ports::Ports;
use crate::power::Power;
use crate::probes::ObservedProbes;
use crate::registers::Registers;
use crate::remanent::RemanentContext;
use crate::scheduler::{Scheduler, TaskTrigger};
use crate::system::System;
use crate::{
    Application, Config, ConfigError, Effects, LoadError, Loader, Memory, NonVolatile, Probe, RegisterProbe,
    State, TaskConfig, TaskKind, TaskModule, VariableReset, Warning, WriteError,
};
use online_change::Pending;
use profile::StopCause;
use signal::{Cause, Time, Value};
use std::fmt;

/// A logic controller, without power when it is made.
pub struct Controller {
    config: Config,
    loader: Box<dyn Loader>,
    state: State,
    application: Option<Box<dyn Application>>,
    /// The bundle that it came in.
    bundle: Vec<u8>,
    /// The application of an online change that waits for the end of the cycles under way.
    pending: Option<Pending>,
    memory: Memory,
    io: EmbeddedIo,
    modules: Modules,
    ports: Ports,
    scheduler: Scheduler,
    power: Power,
    remanent: RemanentContext,
    system: System,
    external: ExternalErrors,
    leds: Leds,
    files: Files,
    registers: Registers,
    probes: ObservedProbes,
}

impl fmt::Debug for Controller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Controller")
            .field("config", &self.config)
            .field("state", &self.state)
            .field("scheduler", &self.scheduler)
            .field("power", &self.power)
            .field("system", &self.system)
            .finish_non_exhaustive()
    }
}

impl Controller {
    /// A controller of this configuration, without power, its switch at Run.
    ///
    /// # Errors
    /// [`ConfigError`] where no controller of the profile accepts the configuration.
    pub fn new(
        config: Config,
        loader: Box<dyn Loader>,
        store: Box<dyn NonVolatile>,
    ) -> Result<Controller, ConfigError> {
        Controller::with_modules(config, loader, store, Vec::new())
    }

    /// The same with modules after the embedded I/O, which is module 0, in the order of their numbers.
    ///
    /// # Errors
    /// [`ConfigError`] where no controller of the profile accepts the configuration.
    pub fn with_modules(
        config: Config,
        loader: Box<dyn Loader>,
        store: Box<dyn NonVolatile>,
        modules: Vec<Box<dyn TaskModule>>,
    ) -> Result<Controller, ConfigError> {
        config.check()?;
        Ok(Controller {
            memory: Memory::new(config.profile),
            io: EmbeddedIo::new(&config),
            modules: Modules::new(&config, modules),
            ports: Ports::new(config.reference.ports.len()),
            scheduler: Scheduler::new(&config),
            power: Power::new(config.tool_connected),
            files: Files::new(config.profile, config.reference, store),
            system: System::new(config.clock_drift),
            config,
            loader,
            state: State::Off,
            application: None,
            bundle: Vec::new(),
            pending: None,
            remanent: RemanentContext::default(),
            external: ExternalErrors::default(),
            leds: Leds::default(),
            registers: Registers::default(),
            probes: ObservedProbes::default(),
        })
    }

    /// Prepares the storage as if this application had been downloaded and the controller then left in state `left`
    /// when its power went: with the default starting mode and RUNNING, the next power-on ends in RUNNING. To be
    /// called without power: a controller that is on goes on writing its own storage.
    ///
    /// # Errors
    /// [`LoadError`]; the storage is then as it was.
    pub fn commission(&mut self, bundle: &[u8], left: State) -> Result<(), LoadError> {
        let mut application = self.build(bundle)?;
        application.reset(VariableReset::ALL);
        self.files.store_mut().write(crate::APPLICATION_FILE, bundle);
        let mut context = RemanentContext::default();
        context.newest(self.files.store());
        context.prepare(&*application, true, self.files.store_mut());
        context.save_now(&*application, &Memory::new(self.config.profile), self.files.store_mut());
        let signature = application.signature();
        LastState { state: left, signature, stop_cause: StopCause::Unknown }.save(self.files.store_mut());
        Ok(())
    }

    /// The state. While a stop waits for cycles under way it is still RUNNING.
    pub fn state(&self) -> State {
        self.state
    }

    /// The reference that it is.
    pub const fn reference(&self) -> &'static profile::Reference {
        self.config.reference
    }

    /// What a probe shows now.
    pub fn read(&self, probe: &Probe) -> Value {
        match *probe {
            Probe::State => Value::Int(self.state.number()),
            Probe::Address(at) => self.memory.value(at),
            Probe::Variable(variable) => {
                self.application.as_ref().map_or(Value::Unknown, |it| it.read(variable))
            }
            Probe::System(variable) => self.read_system(variable),
            Probe::TaskFigure { task, figure } => {
                self.task_figures(task).map_or(Value::Unknown, |figures| figures.get(figure))
            }
            Probe::Input { input, part } => self.io.read_input(input, part),
            Probe::Terminal(terminal) => self.read_terminal(terminal),
            Probe::File(fact) => self.files.read_probe(fact),
            Probe::Register(fact) => self.read_register_probe(fact),
            Probe::Output(output) => {
                self.io.output_state(output).map_or(Value::Unknown, |state| Value::Int(state.number()))
            }
            Probe::Expert { function, fact } => self.io.read_function(function, fact),
            Probe::Led(led) => Value::Int(self.pattern(led).number()),
            Probe::LedLit(led) => Value::Bool(self.is_lit(led)),
        }
    }

    /// Writes a variable or a place in memory at `now`, between two operations of the application. The places of
    /// located system variables are not part of %MW (controller:MEM-09).
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn write(
        &mut self,
        now: Time,
        probe: &Probe,
        value: Value,
        cause: Cause,
        fx: &mut Effects,
    ) -> Result<(), WriteError> {
        if self.state.status().is_none() {
            return Err(WriteError::State(self.state));
        }
        self.refresh_watches();
        match *probe {
            Probe::Address(at) => {
                let number = value.as_int().ok_or(WriteError::NotANumber)?;
                self.memory.set_cause(cause);
                self.memory.store(at, number as u64);
            }
            Probe::Variable(variable) => {
                let application = self.application.as_mut().ok_or(WriteError::State(self.state))?;
                if matches!(value, Value::HighZ | Value::Unknown) {
                    return Err(WriteError::NotANumber);
                }
                application.write(variable, value);
            }
            Probe::System(variable) => self.write_system(variable, value, now, fx)?,
            Probe::Register(RegisterProbe::Value(register)) => {
                let number = value.as_int().ok_or(WriteError::NotANumber)?;
                self.write_registers(now, register, &[number as u16], cause, fx)
                    .map_err(|_| WriteError::IllegalAddress)?;
            }
            _ => return Err(WriteError::ReadOnly),
        }
        self.observe_memory(now, cause, fx);
        if self.state == State::Stopped {
            self.save_if_dirty(now);
        }
        Ok(())
    }

    /// Builds and checks the application of a bundle.
    pub(super) fn build(&mut self, bundle: &[u8]) -> Result<Box<dyn Application>, LoadError> {
        let application = self.loader.load(bundle)?;
        let (expected, found) = (self.config.tasks.len(), application.tasks());
        if expected != found {
            return Err(LoadError::Tasks { expected, found });
        }
        let bytes = application.retained_len();
        if bytes > profile::REMANENT_BYTES {
            return Err(LoadError::Remanent { bytes });
        }
        if let Err((part, row)) = self.check_relocation(&*application) {
            return Err(LoadError::Relocation { part, row });
        }
        let trigger = |task: &TaskConfig| match &task.kind {
            TaskKind::Event { trigger } => TaskTrigger::find(&*application, trigger).is_none(),
            _ => false,
        };
        if let Some(task) = self.config.tasks.iter().position(trigger) {
            return Err(LoadError::Trigger { task });
        }
        if self.config.profile != profile::Profile::M241_2014
            && let Some((byte, tasks)) = self.shared_output_byte(&*application)
        {
            return Err(LoadError::SharedOutputByte { byte, tasks });
        }
        Ok(application)
    }

    /// What the application of a bundle is taken with a warning for; nothing where it is not valid.
    pub fn application_warning(&mut self, bundle: &[u8]) -> Option<Warning> {
        // One task shares no output, and the later profiles refuse it.
        if self.config.tasks.len() < 2 || self.config.profile != profile::Profile::M241_2014 {
            return None;
        }
        let application = self.build(bundle).ok()?;
        self.warning_of(&*application)
    }

    pub(super) fn warning_of(&self, application: &dyn Application) -> Option<Warning> {
        let (byte, tasks) = self.shared_output_byte(application)?;
        Some(Warning::SharedOutputByte { byte, tasks })
    }

    /// The first byte of embedded outputs that two tasks write (controller:PRIO-05).
    fn shared_output_byte(&self, application: &dyn Application) -> Option<(u32, (usize, usize))> {
        let bytes = self.config.reference.output_count().div_ceil(8) as u32;
        (0..bytes).find_map(|byte| {
            let mut writers =
                (0..self.config.tasks.len()).filter(|task| application.writes_output(*task, byte));
            Some((byte, (writers.next()?, writers.next()?)))
        })
    }
}
