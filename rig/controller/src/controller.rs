//! The controller: its parts, and what can be asked of it.

use crate::change::Pending;
use crate::event::{EventQueue, EventRate};
use crate::external::ExternalErrors;
use crate::files::Files;
use crate::forcing::{Forced, Forcing};
use crate::functions::Functions;
use crate::input::Inputs;
use crate::led::Leds;
use crate::load::Load;
use crate::output::Outputs;
use crate::protection::Protection;
use crate::registers::Registers;
use crate::release::find_trigger;
use crate::remanent::RemanentContext;
use crate::service::FirstCycle;
use crate::system::System;
use crate::system_log::SystemLog;
use crate::task::Task;
use crate::time_slice::find_peers;
use crate::watch::Watches;
use crate::{
    Application, Config, ConfigError, Effects, JitterCounts, LoadError, Loader, Memory, NonVolatile,
    OutputState, Probe, RegisterProbe, State, TaskConfig, TaskFigures, TaskKind, WriteError,
};
use profile::StopCause;
use signal::{Cause, Level, Size, Span, Time, Value};
use std::fmt;

/// A logic controller, without power when it is made.
pub struct Controller {
    pub(crate) config: Config,
    pub(crate) loader: Box<dyn Loader>,
    pub(crate) store: Box<dyn NonVolatile>,
    pub(crate) state: State,
    pub(crate) application: Option<Box<dyn Application>>,
    /// The bundle that it came in.
    pub(crate) bundle: Vec<u8>,
    pub(crate) memory: Memory,
    pub(crate) inputs: Inputs,
    pub(crate) functions: Functions,
    pub(crate) outputs: Outputs,
    pub(crate) forced_inputs: Forced,
    pub(crate) forced_outputs: Forced,
    pub(crate) forcing: Forcing,
    pub(crate) protection: Protection,
    pub(crate) external: ExternalErrors,
    pub(crate) leds: Leds,
    /// The bit of %I that reports faults of the outputs, among the first 32; 0 without outputs.
    pub(crate) status_bit: u32,
    /// The bit of %Q that rearms the outputs, among the first 32; 0 without outputs.
    pub(crate) rearming_bit: u32,
    /// Place of MAST in the configuration.
    pub(crate) mast: usize,
    /// The tasks, highest priority first: a task's place in here is its rank.
    pub(crate) tasks: Vec<Task>,
    /// Processor and scheduling.
    pub(crate) cpu: Processor,
    pub(crate) load: Load,
    /// Events under way, and how many came.
    pub(crate) arrivals: EventQueue,
    pub(crate) event_rate: EventRate,
    pub(crate) external_rate: EventRate,
    /// When the variables are looked at next that start event tasks.
    pub(crate) tick: Time,
    pub(crate) power: Power,
    pub(crate) context: RemanentContext,
    pub(crate) system: System,
    /// The application of an online change that waits for the end of the cycles under way.
    pub(crate) pending: Option<Pending>,
    /// Since when a task is held at a breakpoint, and its place in the configuration.
    pub(crate) held: Option<(Time, usize)>,
    pub(crate) start: FirstCycle,
    /// The program keeps the indicator of the battery dark (controller:LED-05).
    pub(crate) battery_led_inhibited: bool,
    pub(crate) watches: Watches,
    pub(crate) files: Files,
    pub(crate) log: SystemLog,
    pub(crate) registers: Registers,
}

/// The one processor (controller:TASK-03).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Processor {
    /// Up to here application code has taken effect.
    pub at: Time,
    /// An operation is under way since `at` and completes then; it belongs to the task of rank `running`.
    pub in_flight: Option<Time>,
    /// Rank of the task that ran last.
    pub running: usize,
    /// Ranks with a release that waits for its cycle, bit 0 the highest priority.
    pub ready: u32,
    /// Ranks with a cycle under way.
    pub active: u32,
    /// Ranks that sleep or are held back.
    pub held: u32,
    /// A stop waits for the cycles under way.
    pub stopping: Option<StopCause>,
    /// Controller tasks (priority 0...24) have had the processor without a gap in this time (controller:WD-02).
    pub busy_since: Time,
    pub busy_until: Time,
}

/// Supply, boot and the work of a controller that does not run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Power {
    /// The supply is gone; the controller lives until then.
    pub hold_up: Option<Time>,
    /// Step of BOOTING and its end.
    pub stage: Option<(usize, Time)>,
    /// The boot was provoked by a system error.
    pub system_error: bool,
    /// The boot was commanded by a script.
    pub script: bool,
    /// The firmware in non-volatile memory is valid.
    pub firmware: bool,
    /// The boot application is being saved until then.
    pub creating: Option<Time>,
    /// The Run/Stop switch is at Run.
    pub switch_at_run: bool,
    /// Next update of inputs and outputs in STOPPED and HALT.
    pub refresh: Option<Time>,
    /// What the outputs are set to at each of these updates; none to keep what is in %Q.
    pub stop_image: Option<u32>,
    /// Outputs show their initialization values up to then, and these take their default values then.
    pub initialization: Option<(Time, u32)>,
    /// What was written to the outputs, and to which, to be driven where the bus cycle task reads its inputs next
    /// (controller:PRIO-08).
    pub late_write: Option<(u32, u32)>,
}

impl fmt::Debug for Controller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Controller")
            .field("config", &self.config)
            .field("state", &self.state)
            .field("tasks", &self.tasks)
            .field("cpu", &self.cpu)
            .field("power", &self.power)
            .field("system", &self.system)
            .finish_non_exhaustive()
    }
}

/// A bit by its byte and its place in it, among the first 32 of an image.
pub(crate) const fn low_bit((byte, bit): (u32, u32)) -> u32 {
    1 << (8 * byte + bit)
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
        config.check()?;
        let mut tasks: Vec<_> =
            config.tasks.iter().enumerate().map(|(place, task)| Task::new(place, task)).collect();
        tasks.sort_by_key(|task| task.priority);
        find_peers(&mut tasks);
        Ok(Controller {
            memory: Memory::new(config.profile),
            outputs: Outputs::new(profile::outputs(config.reference)),
            functions: Functions::new(&config),
            protection: Protection::new(config.reference, config.rearming),
            external: ExternalErrors::default(),
            leds: Leds::default(),
            status_bit: profile::short_circuit_status(config.reference).map_or(0, low_bit),
            rearming_bit: profile::rearming_command(config.reference).map_or(0, low_bit),
            forcing: Forcing::new(config.tool_connected, tasks.len()),
            inputs: Inputs::new(&config),
            load: Load::new(Time::MIN, &tasks),
            arrivals: EventQueue::new(),
            event_rate: EventRate::new(),
            external_rate: EventRate::new(),
            tick: Time::MAX,
            mast: config.task("MAST").unwrap_or_default(),
            tasks,
            config,
            loader,
            store,
            state: State::Off,
            application: None,
            bundle: Vec::new(),
            forced_inputs: Forced::default(),
            forced_outputs: Forced::default(),
            cpu: Processor {
                at: Time::MIN,
                in_flight: None,
                running: 0,
                ready: 0,
                active: 0,
                held: 0,
                stopping: None,
                busy_since: Time::MIN,
                busy_until: Time::MIN,
            },
            power: Power {
                hold_up: None,
                stage: None,
                system_error: false,
                script: false,
                firmware: true,
                creating: None,
                switch_at_run: true,
                refresh: None,
                stop_image: None,
                initialization: None,
                late_write: None,
            },
            context: RemanentContext::default(),
            system: System::default(),
            pending: None,
            held: None,
            start: FirstCycle::default(),
            battery_led_inhibited: false,
            watches: Watches::default(),
            files: Files::default(),
            log: SystemLog::default(),
            registers: Registers::default(),
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
        application.reset(crate::VariableReset::ALL);
        self.store.write(crate::APPLICATION_FILE, bundle);
        let mut context = RemanentContext::default();
        context.newest(&*self.store);
        context.prepare(&*application, true, &mut *self.store);
        context.save_now(&*application, &Memory::new(self.config.profile), &mut *self.store);
        crate::last_state::save_last_state(&mut *self.store, left, application.signature());
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

    /// The figures of a task by its place in the configuration.
    pub fn task_figures(&self, task: usize) -> Option<TaskFigures> {
        self.tasks.iter().find(|at| at.place == task).map(|at| at.figures)
    }

    /// How late the cycles of a task began, by its place in the configuration.
    pub fn task_jitter(&self, task: usize) -> Option<&JitterCounts> {
        self.tasks.iter().find(|at| at.place == task).map(|at| &at.jitter_counts)
    }

    /// The physical level at terminal I`input` from `now` on. Numbers beyond the reference's inputs are ignored.
    pub fn input(&mut self, now: Time, input: usize, level: Level) {
        self.inputs.set(now, input, level);
        if self.state != State::Off {
            self.functions.edge(now, input, level.is_high());
        }
    }

    /// So many edges at terminal I`input` are known to be missing before `now`: an expert function that counts them is off by
    /// up to so many, and says so (io:STD-HSC-16).
    pub fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        if self.state != State::Off {
            self.functions.report_missed_edges(now, input, edges);
        }
    }

    /// Hardware behind terminal I`input` counted so many steps more by `now`, below 0 backwards. Only inputs that
    /// [`crate::Config::counted`] names are counted at.
    pub fn count(&mut self, now: Time, input: usize, steps: i64) {
        if self.state != State::Off {
            self.functions.count(now, input, steps);
        }
    }

    /// The next `times` cycles of a task take `cycle` of processor time in all, however little the program needs.
    /// The time after the program's last operation can be pre-empted at any nanosecond.
    pub fn overload(&mut self, task: usize, cycle: Span, times: u32) {
        if let Some(task) = self.tasks.iter_mut().find(|at| at.place == task) {
            task.overload = (cycle, times);
        }
    }

    /// What a probe shows now.
    pub fn read(&self, probe: &Probe) -> Value {
        match *probe {
            Probe::State => Value::Int(self.state.number()),
            Probe::Address(at) => {
                let value = self.memory.load(at);
                if at.size() == Size::Bit { Value::Bool(value != 0) } else { Value::Word(value) }
            }
            Probe::Variable(variable) => {
                self.application.as_ref().map_or(Value::Unknown, |it| it.read(variable))
            }
            Probe::System(variable) => self.read_system(variable),
            Probe::TaskFigure { task, figure } => {
                self.task_figures(task).map_or(Value::Unknown, |figures| figures.get(figure))
            }
            Probe::Input { input, part } => self.inputs.show(input, part),
            Probe::Terminal(output) => self.outputs.level(output).map_or(Value::Unknown, Value::from),
            Probe::File(fact) => self.read_file_probe(fact),
            Probe::Register(fact) => self.read_register_probe(fact),
            Probe::Output(output) => {
                self.output_state(output).map_or(Value::Unknown, |state| Value::Int(state.number()))
            }
            Probe::Expert { function, fact } => self.functions.read(function, fact),
            Probe::Led(led) => Value::Int(self.pattern(led).number()),
            Probe::LedLit(led) => Value::Bool(self.lit(led)),
        }
    }

    fn output_state(&self, output: usize) -> Option<OutputState> {
        let level = self.outputs.level(output)?;
        let protected = self.protection.off() >> output & 1 == 1;
        Some(if protected { OutputState::Protected } else { OutputState::from(level) })
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
    pub(crate) fn build(&mut self, bundle: &[u8]) -> Result<Box<dyn Application>, LoadError> {
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
            TaskKind::Event { trigger } => find_trigger(&*application, trigger).is_none(),
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

    /// The first byte of embedded outputs that two tasks write (controller:PRIO-05).
    pub(crate) fn shared_output_byte(&self, application: &dyn Application) -> Option<(u32, (usize, usize))> {
        let bytes = self.config.reference.output_count().div_ceil(8) as u32;
        (0..bytes).find_map(|byte| {
            let mut writers =
                (0..self.config.tasks.len()).filter(|task| application.writes_output(*task, byte));
            Some((byte, (writers.next()?, writers.next()?)))
        })
    }
}
