//! The capabilities of a subject for callers who do not care whether it has them.

use super::Subject;
use crate::application::observable::Observable;
use crate::schedule::FileAction;
use crate::subject::hook::HookError;
use controller::{
    Disturbance, Effects, FileError, FileProbe, FrontPanel, JitterCounts, Probe, ProbeId, TaskFigures,
    WriteError,
};
use profile::IoChannel;
use signal::{Cause, Span, Time, Value};
use std::sync::atomic::AtomicBool;

/// What is no probe of a subject: nothing is ever reported of it.
pub const NO_PROBE: ProbeId = ProbeId(u32::MAX);

/// The longest that a subject takes into its first state that says nothing of that.
const STARTUP_LIMIT: Span = Span::from_secs(60);

/// The capabilities of any subject: what it lacks it refuses, or has nothing of. Nobody implements this but the subject
/// itself, by its accessors.
pub trait SubjectExt: Subject {
    /// As [`Startup::load`](super::Startup::load); there is nothing to do for one that has its program.
    ///
    /// # Errors
    /// [`HookError`] with what the command said.
    fn load(&mut self, interrupt: &AtomicBool) -> Result<(), HookError> {
        self.startup().map_or(Ok(()), |startup| startup.load(interrupt))
    }

    /// As [`Startup::loaded`](super::Startup::loaded).
    fn loaded(&mut self, now: Time, effects: &mut Effects) {
        if let Some(startup) = self.startup() {
            startup.loaded(now, effects);
        }
    }

    /// As [`Startup::unload`](super::Startup::unload).
    ///
    /// # Errors
    /// [`HookError`] with what the command said.
    fn unload(&mut self, interrupt: &AtomicBool) -> Result<(), HookError> {
        self.startup().map_or(Ok(()), |startup| startup.unload(interrupt))
    }

    /// As [`Startup::limit`](super::Startup::limit); 60 s for one that does not say.
    fn startup_limit(&mut self) -> Span {
        self.startup().map_or(STARTUP_LIMIT, |startup| startup.limit())
    }

    /// As [`Startup::begin`](super::Startup::begin); the executor sees where another begins.
    fn begin(&mut self) -> Option<(Time, Value)> {
        self.startup()?.begin()
    }

    /// As [`Startup::state_probe`](super::Startup::state_probe).
    fn state_probe(&mut self) -> Option<ProbeId> {
        self.startup()?.state_probe()
    }

    /// As [`Catalogue::observable`](crate::application::catalogue::Catalogue::observable); without a catalogue no name is known.
    fn observable(&self, name: &str) -> Option<Observable> {
        self.catalogue()?.observable(name)
    }

    /// The place of a task by its name; without a catalogue there is no task.
    fn task(&self, name: &str) -> Option<usize> {
        self.catalogue()?.task(name)
    }

    /// What its tasks did, in the order of the configuration: name, interval, figures. Empty where nobody can look.
    fn figures(&self) -> Vec<(String, Span, TaskFigures)> {
        let (Some(catalogue), Some(inside)) = (self.catalogue(), self.observation()) else {
            return Vec::new();
        };
        let named = catalogue.tasks().iter().enumerate();
        named
            .filter_map(|(place, task)| {
                let interval = task.interval().unwrap_or(Span::ZERO);
                Some((task.name.clone(), interval, inside.task_status(place)?.0))
            })
            .collect()
    }

    /// As [`Observation::watch`](super::Observation::watch); [`NO_PROBE`] where nobody can look.
    fn watch(&mut self, probe: Probe) -> ProbeId {
        self.observation_mut().map_or(NO_PROBE, |inside| inside.watch(probe))
    }

    /// As [`Observation::reserve`](super::Observation::reserve).
    fn reserve(&mut self, watches: usize) {
        if let Some(inside) = self.observation_mut() {
            inside.reserve(watches);
        }
    }

    /// As [`Observation::unwatch`](super::Observation::unwatch).
    fn unwatch(&mut self, probe: ProbeId) {
        if let Some(inside) = self.observation_mut() {
            inside.unwatch(probe);
        }
    }

    /// As [`Observation::front`](super::Observation::front); nothing is known of a real controller.
    fn front(&self) -> Option<FrontPanel> {
        self.observation()?.front()
    }

    /// As [`Observation::task_status`](super::Observation::task_status).
    fn task_status(&self, task: usize) -> Option<(TaskFigures, JitterCounts)> {
        self.observation()?.task_status(task)
    }

    /// As [`Observation::read`](super::Observation::read); unknown where nobody can look.
    fn read(&self, probe: &Probe) -> Value {
        self.observation().map_or(Value::Unknown, |inside| inside.read(probe))
    }

    /// As [`Observation::write`](super::Observation::write).
    ///
    /// # Errors
    /// [`WriteError`] with the reason; [`WriteError::State`] where nobody can write.
    fn write(
        &mut self,
        now: Time,
        probe: &Probe,
        value: Value,
        cause: Cause,
        effects: &mut Effects,
    ) -> Result<(), WriteError> {
        let state = self.state();
        let refused = Err(WriteError::State(state));
        self.observation_mut().map_or(refused, |inside| inside.write(now, probe, value, cause, effects))
    }

    /// As [`FileAccess::file`](super::FileAccess::file).
    ///
    /// # Errors
    /// [`FileError`] with the reason; [`FileError::State`] without access to files.
    fn file(&mut self, now: Time, act: &FileAction, effects: &mut Effects) -> Result<(), FileError> {
        let state = self.state();
        self.files().map_or(Err(FileError::State(state)), |files| files.file(now, act, effects))
    }

    /// As [`FileAccess::file_probe`](super::FileAccess::file_probe). A case that asks for files does not run on a subject
    /// without.
    fn file_probe(&mut self, fact: FileProbe) -> Probe {
        self.files().map_or(Probe::State, |files| files.file_probe(fact))
    }

    /// As [`Disturbances::disturb`](super::Disturbances::disturb). A case that needs it does not run on a subject without.
    fn disturb(&mut self, now: Time, disturbance: Disturbance, effects: &mut Effects) {
        if let Some(disturbances) = self.disturbances() {
            disturbances.disturb(now, disturbance, effects);
        }
    }

    /// As [`Disturbances::overload`](super::Disturbances::overload).
    fn overload(&mut self, task: usize, cycle: Span, times: u32) {
        if let Some(disturbances) = self.disturbances() {
            disturbances.overload(task, cycle, times);
        }
    }

    /// As [`Disturbances::suspend`](super::Disturbances::suspend).
    fn suspend(&mut self, task: usize, until: Time) {
        if let Some(disturbances) = self.disturbances() {
            disturbances.suspend(task, until);
        }
    }

    /// As [`ExpertFunctionAccess::offload_pulses`](super::ExpertFunctionAccess::offload_pulses).
    fn offload_pulses(&mut self, outputs: &[IoChannel]) {
        if let Some(functions) = self.expert_functions() {
            functions.offload_pulses(outputs);
        }
    }

    /// As [`ExpertFunctionAccess::report_missed_edges`](super::ExpertFunctionAccess::report_missed_edges).
    fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        if let Some(functions) = self.expert_functions() {
            functions.report_missed_edges(now, input, edges);
        }
    }

    /// As [`ExpertFunctionAccess::count`](super::ExpertFunctionAccess::count).
    fn count(&mut self, now: Time, input: usize, steps: i64) {
        if let Some(functions) = self.expert_functions() {
            functions.count(now, input, steps);
        }
    }
}

impl<S: Subject + ?Sized> SubjectExt for S {}
