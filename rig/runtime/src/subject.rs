//! What is under test: the model, or a real controller on the same wires (`external.rs`).

use crate::application::BundleLoader;
pub use crate::capability::Capability;
use crate::catalogue::Catalogue;
use crate::coverage::Collector;
use crate::functions;
use crate::hook::HookError;
use crate::schedule::FileAction;
use crate::variable_numbers::VariableNumbers;
use controller::{
    Command, CommandError, Config, ConfigError, Controller, Disturbance, Effect, Effects, FileError,
    FileProbe, FrontPanel, JitterCounts, LedPattern, LoadError, NonVolatile, OutputState, Probe, ProbeId,
    State, TaskFigures, WriteError,
};
use plans::steps::FileDeed;
use program::Program;
use signal::{Cause, Kind, Level, Span, Time, Value, When};
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

    /// What stands behind these outputs, bit n for Qn, makes square waves by itself: those of its functions are told as
    /// [`Effect::Wave`]. Before it has power.
    fn offload_pulses(&mut self, _outputs: u32) {}

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
    fn startup_limit(&self) -> Span {
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
    fn is_model(&self) -> bool {
        false
    }

    /// When it will next do something by itself.
    fn next_timer(&self) -> Option<Time>;

    /// Lets everything act that is due at `now`.
    fn fire(&mut self, now: Time, effects: &mut Effects);

    /// An input terminal has this level from `now` on; its line changed `at` the instant before.
    fn input(&mut self, now: Time, at: When, input: usize, level: Level, effects: &mut Effects);

    /// So many changes of an input terminal's line are known to be missing before `now`.
    fn report_missed_edges(&mut self, _now: Time, _input: usize, _edges: u32) {}

    /// Hardware behind an input terminal counted so many steps more by `now`, below 0 backwards. Only a model has terminals
    /// that counts can be given to.
    fn count(&mut self, _now: Time, _input: usize, _steps: i64) {}

    /// Obeys a command.
    ///
    /// # Errors
    /// [`CommandError`] with the reason.
    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), CommandError>;

    /// Does something to a file, as a user or as the application would.
    ///
    /// # Errors
    /// [`FileError`] with the reason.
    fn file(&mut self, now: Time, act: &FileAction, effects: &mut Effects) -> Result<(), FileError>;

    /// What shows a fact of files or of the log.
    fn file_probe(&mut self, fact: FileProbe) -> Probe;

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

    /// VariableNumbers that mean something inside the subject, for suggestions.
    fn names(&self) -> Vec<String>;

    /// What its names mean, where the rig plays it.
    fn catalogue(&self) -> Option<&Catalogue> {
        None
    }

    /// What a name means inside the subject: a system variable, an address, or a variable's path.
    fn observable(&self, name: &str) -> Option<Observable>;

    /// The least and the greatest value that a whole number inside can have; `None` for times, real numbers and what
    /// is not known.
    fn bounds(&self, _name: &str) -> Option<(i128, i128)> {
        None
    }

    /// From now on changes of this are reported as effects.
    fn watch(&mut self, probe: Probe) -> ProbeId;

    /// There will be so many of these at once: that takes no memory later.
    fn reserve(&mut self, _watches: usize) {}

    /// Ends [`Subject::watch`].
    fn unwatch(&mut self, _probe: ProbeId) {}

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

    /// What is on its front, and what is forced; nothing is known of a real controller.
    fn front(&self) -> Option<FrontPanel> {
        None
    }

    /// What a task did, by its place.
    fn task_status(&self, _task: usize) -> Option<(TaskFigures, JitterCounts)> {
        None
    }

    /// What its tasks did, in the order of the configuration.
    fn figures(&self) -> Vec<(String, Span, TaskFigures)>;
}

/// The model as subject.
#[derive(Debug)]
pub struct Model {
    controller: Controller,
    catalogue: Catalogue,
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
        let names = VariableNumbers::default();
        let loader = Box::new(BundleLoader::new(config.profile).covered(collector).named(names.clone()));
        let catalogue = Catalogue::new(&config, program, names);
        Ok(Model { controller: Controller::new(config, loader, store)?, catalogue })
    }

    /// VariableNumbers of further programs mean something too, behind those that it knows.
    pub fn add_programs(&mut self, programs: Vec<Arc<Program>>) {
        self.catalogue.add_programs(programs);
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

    fn is_model(&self) -> bool {
        true
    }

    fn offload_pulses(&mut self, outputs: u32) {
        self.controller.offload_pulses(outputs);
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

    fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        self.controller.report_missed_edges(now, input, edges);
    }

    fn count(&mut self, now: Time, input: usize, steps: i64) {
        self.controller.count(now, input, steps);
    }

    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), CommandError> {
        let before = effects.list.len();
        let answer = self.controller.command(now, command.clone(), effects);
        self.log(before, effects);
        answer
    }

    fn file(&mut self, now: Time, act: &FileAction, effects: &mut Effects) -> Result<(), FileError> {
        let (path, user) = (act.path.as_str(), act.user);
        match &act.deed {
            FileDeed::Put(bytes) => self.controller.put_file(now, path, bytes, user, effects),
            FileDeed::Fill(bytes) => self.controller.put_file(now, path, &vec![0; *bytes], user, effects),
            FileDeed::Log(entry) => self.controller.log_data(now, path, entry, effects),
            FileDeed::Remove => self.controller.remove_file(now, path, user, effects),
        }
    }

    fn file_probe(&mut self, fact: FileProbe) -> Probe {
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
        self.catalogue.tasks().iter().position(|task| task.name.eq_ignore_ascii_case(name))
    }

    fn task_name(&self, task: usize) -> Option<&str> {
        self.catalogue.tasks().get(task).map(|task| task.name.as_str())
    }

    fn function_name(&self, function: usize) -> Option<&str> {
        self.catalogue.functions().functions.get(function).map(|function| function.name.as_str())
    }

    fn file_name(&self, file: u16) -> Option<&str> {
        self.catalogue.programs().first()?.files().get(usize::from(file)).map(String::as_str)
    }

    fn source_files(&self) -> Vec<(u16, String)> {
        let files = |program: &Arc<Program>| program.files().to_vec();
        self.catalogue.programs().iter().flat_map(|program| (0..).zip(files(program))).collect()
    }

    fn names(&self) -> Vec<String> {
        self.catalogue.names()
    }

    fn observable(&self, name: &str) -> Option<Observable> {
        self.catalogue.observable(name)
    }

    fn bounds(&self, name: &str) -> Option<(i128, i128)> {
        self.catalogue.bounds(name)
    }

    fn catalogue(&self) -> Option<&Catalogue> {
        Some(&self.catalogue)
    }

    fn watch(&mut self, probe: Probe) -> ProbeId {
        self.controller.watch(probe)
    }

    fn reserve(&mut self, watches: usize) {
        self.controller.reserve_watches(watches);
    }

    fn unwatch(&mut self, probe: ProbeId) {
        self.controller.unwatch(probe);
    }

    fn front(&self) -> Option<FrontPanel> {
        Some(self.controller.front_panel())
    }

    fn task_status(&self, task: usize) -> Option<(TaskFigures, JitterCounts)> {
        Some((self.controller.task_figures(task)?, *self.controller.task_jitter(task)?))
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
        let named = self.catalogue.tasks().iter().enumerate();
        named
            .filter_map(|(place, task)| {
                let interval = task.interval().unwrap_or(Span::ZERO);
                Some((task.name.clone(), interval, self.controller.task_figures(place)?))
            })
            .collect()
    }
}
