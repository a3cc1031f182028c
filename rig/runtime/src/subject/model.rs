//! The model as subject.

use crate::application::BundleLoader;
use crate::application::catalogue::Catalogue;
use crate::application::coverage::Collector;
use crate::application::variable_numbers::VariableNumbers;
use crate::schedule::FileAction;
use crate::subject::capability::Capability;
use crate::subject::{Disturbances, ExpertFunctionAccess, FileAccess, Observation, PortAccess, Subject};
use controller::{
    Command, CommandError, Config, ConfigError, Controller, Disturbance, Effect, Effects, Endpoint,
    FileError, FileProbe, FrontPanel, JitterCounts, LoadError, NonVolatile, PortEvent, PortMessage, Probe,
    ProbeId, State, TaskFigures, TaskModule, Terminal, WriteError,
};
use plans::steps::FileOperation;
use profile::IoChannel;
use program::Program;
use signal::{Address, Cause, Span, Time, Value, When};
use std::sync::Arc;

/// The model as subject.
#[derive(Debug)]
pub struct ModelledController {
    controller: Controller,
    catalogue: Catalogue,
}

impl ModelledController {
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
    ) -> Result<ModelledController, ConfigError> {
        ModelledController::with_modules(config, program, store, collector, Vec::new())
    }

    /// The same with modules after the embedded inputs and outputs, in the order of their numbers.
    ///
    /// # Errors
    /// [`ConfigError`] for a configuration that the profile does not accept.
    pub fn with_modules(
        config: Config,
        program: Option<Arc<Program>>,
        store: Box<dyn NonVolatile>,
        collector: Option<Collector>,
        modules: Vec<Box<dyn TaskModule>>,
    ) -> Result<ModelledController, ConfigError> {
        let names = VariableNumbers::default();
        let loader = Box::new(BundleLoader::new(config.profile).covered(collector).named(names.clone()));
        let catalogue = Catalogue::new(&config, program, names);
        Ok(ModelledController {
            controller: Controller::with_modules(config, loader, store, modules)?,
            catalogue,
        })
    }

    /// VariableNumbers of further programs mean something too, after those that it knows.
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

    /// What the application of a bundle is taken with a warning for.
    pub fn application_warning(&mut self, bundle: &[u8]) -> Option<controller::Warning> {
        self.controller.application_warning(bundle)
    }

    /// Puts the log entries among new effects into the controller's log, in words (controller:NV-09).
    fn log(&mut self, before: usize, effects: &mut Effects) {
        for place in before..effects.list.len() {
            if let Effect::Log { at, entry } = effects.list[place] {
                let text = crate::subject::log::show(&entry, Some(&self.catalogue));
                self.controller.log_line(at, &text, effects);
            }
        }
    }

    /// The firmware is damaged from the start.
    pub fn damage_firmware(&mut self) {
        self.controller.damage_firmware();
    }

    /// Puts an endpoint at a port, by its number. FALSE, with nothing done, where the reference has no such port or the model
    /// has power.
    pub fn attach_endpoint(&mut self, port: usize, endpoint: Box<dyn Endpoint>) -> bool {
        self.controller.attach_endpoint(port, endpoint)
    }

    /// The controller, to look into.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }
}

impl Subject for ModelledController {
    fn inner(&self) -> Option<&dyn Subject> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Subject> {
        None
    }

    fn capabilities(&self) -> &'static [Capability] {
        &Capability::ALL
    }

    fn is_model(&self) -> bool {
        true
    }

    fn state(&self) -> State {
        self.controller.state()
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

    fn next_timer(&self) -> Option<Time> {
        self.controller.next_timer()
    }

    fn fire(&mut self, now: Time, effects: &mut Effects) {
        let before = effects.list.len();
        self.controller.fire(now, effects);
        self.log(before, effects);
    }

    fn terminal(&self, address: Address) -> Option<Terminal> {
        self.controller.terminal(address)
    }

    fn set_input(&mut self, now: Time, _at: When, terminal: Terminal, value: Value, _effects: &mut Effects) {
        self.controller.input(now, terminal, value);
    }

    fn output(&self, terminal: Terminal) -> Value {
        self.controller.read(&Probe::Terminal(terminal))
    }

    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), CommandError> {
        let before = effects.list.len();
        let answer = self.controller.command(now, command.clone(), effects);
        self.log(before, effects);
        answer
    }

    // Who reads its log has that of the rig too.
    fn notice(&mut self, _at: Time, _text: &str) {}

    fn report_unsettled(&mut self, now: Time, effects: &mut Effects) {
        self.controller.report_unsettled(now, effects);
    }

    fn catalogue(&self) -> Option<&Catalogue> {
        Some(&self.catalogue)
    }

    fn observation(&self) -> Option<&dyn Observation> {
        Some(self)
    }

    fn observation_mut(&mut self) -> Option<&mut dyn Observation> {
        Some(self)
    }

    fn files(&mut self) -> Option<&mut dyn FileAccess> {
        Some(self)
    }

    fn disturbances(&mut self) -> Option<&mut dyn Disturbances> {
        Some(self)
    }

    fn expert_functions(&mut self) -> Option<&mut dyn ExpertFunctionAccess> {
        Some(self)
    }

    fn ports(&mut self) -> Option<&mut dyn PortAccess> {
        Some(self)
    }
}

impl Observation for ModelledController {
    fn watch(&mut self, probe: Probe) -> ProbeId {
        self.controller.watch(probe)
    }

    fn reserve(&mut self, watches: usize) {
        self.controller.reserve_watches(watches);
    }

    fn unwatch(&mut self, probe: ProbeId) {
        self.controller.unwatch(probe);
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

    fn front(&self) -> Option<FrontPanel> {
        Some(self.controller.front_panel())
    }

    fn task_status(&self, task: usize) -> Option<(TaskFigures, JitterCounts)> {
        Some((self.controller.task_figures(task)?, *self.controller.task_jitter(task)?))
    }
}

impl FileAccess for ModelledController {
    fn file(&mut self, now: Time, act: &FileAction, effects: &mut Effects) -> Result<(), FileError> {
        let (path, user) = (act.path.as_str(), act.user);
        match &act.deed {
            FileOperation::Put(bytes) => self.controller.put_file(now, path, bytes, user, effects),
            FileOperation::Fill(bytes) => {
                self.controller.put_file(now, path, &vec![0; *bytes], user, effects)
            }
            FileOperation::Log(entry) => self.controller.log_data(now, path, entry, effects),
            FileOperation::Remove => self.controller.remove_file(now, path, user, effects),
        }
    }

    fn file_probe(&mut self, fact: FileProbe) -> Probe {
        self.controller.file_probe(fact)
    }
}

impl Disturbances for ModelledController {
    fn disturb(&mut self, now: Time, disturbance: Disturbance, effects: &mut Effects) {
        self.controller.disturb(now, disturbance, effects);
    }

    fn overload(&mut self, task: usize, cycle: Span, times: u32) {
        self.controller.overload(task, cycle, times);
    }

    fn suspend(&mut self, task: usize, until: Time) {
        self.controller.suspend(task, until);
    }
}

impl PortAccess for ModelledController {
    fn receive(&mut self, now: Time, port: usize, event: &PortEvent, effects: &mut Effects) {
        let before = effects.list.len();
        self.controller.receive(now, port, event, effects);
        self.log(before, effects);
    }

    fn take_output(&mut self, port: usize) -> Option<PortMessage> {
        self.controller.take_output(port)
    }
}

impl ExpertFunctionAccess for ModelledController {
    fn offload_pulses(&mut self, outputs: &[IoChannel]) {
        self.controller.offload_pulses(outputs);
    }

    fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        self.controller.report_missed_edges(now, input, edges);
    }

    fn count(&mut self, now: Time, input: usize, steps: i64) {
        self.controller.count(now, input, steps);
    }
}
