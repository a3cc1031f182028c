//! What only some subjects can do. No method has a default: whoever has a capability says what becomes of each.

use crate::schedule::FileAction;
use crate::subject::hook::HookError;
use controller::{
    Disturbance, Effects, FileError, FileProbe, FrontPanel, JitterCounts, Probe, ProbeId, TaskFigures,
    WriteError,
};
use profile::IoChannel;
use signal::{Cause, Span, Time, Value};
use std::sync::atomic::AtomicBool;

/// How a subject gets its program and comes into the state in which a case begins.
pub trait Startup {
    /// Brings the case's program into it, which takes as long as it takes on the host.
    ///
    /// # Errors
    /// [`HookError`] with what the command said.
    fn load(&mut self, interrupt: &AtomicBool) -> Result<(), HookError>;

    /// The program is there, by `now`.
    fn loaded(&mut self, now: Time, effects: &mut Effects);

    /// Takes the case's program away, after the case.
    ///
    /// # Errors
    /// [`HookError`] with what the command said.
    fn unload(&mut self, interrupt: &AtomicBool) -> Result<(), HookError>;

    /// The longest that it takes from its supply into the state in which a case begins.
    fn limit(&self) -> Span;

    /// The case begins. The earliest instant at which the subject can have come into the state that it begins in, and
    /// what shows of it, where that is not what the executor sees.
    fn begin(&mut self) -> Option<(Time, Value)>;

    /// What reports its state, where [`controller::Effect::State`] does not.
    fn state_probe(&self) -> Option<ProbeId>;
}

/// What is inside of a subject: variables, memory, figures of its tasks, its front.
pub trait Observation {
    /// From now on changes of this are reported as effects.
    fn watch(&mut self, probe: Probe) -> ProbeId;

    /// There will be so many of these at once: that takes no memory later.
    fn reserve(&mut self, watches: usize);

    /// Ends [`Observation::watch`].
    fn unwatch(&mut self, probe: ProbeId);

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

    /// What is on its front, and what is forced.
    fn front(&self) -> Option<FrontPanel>;

    /// What a task did, by its place in the configuration.
    fn task_status(&self, task: usize) -> Option<(TaskFigures, JitterCounts)>;
}

/// The files of a subject.
pub trait FileAccess {
    /// Does something to a file, as a user or as the application would.
    ///
    /// # Errors
    /// [`FileError`] with the reason.
    fn file(&mut self, now: Time, act: &FileAction, effects: &mut Effects) -> Result<(), FileError>;

    /// What shows a fact of files or of the log.
    fn file_probe(&mut self, fact: FileProbe) -> Probe;
}

/// What can go wrong inside of a subject and around it.
pub trait Disturbances {
    /// Lets something go wrong around it, or ends that.
    fn disturb(&mut self, now: Time, disturbance: Disturbance, effects: &mut Effects);

    /// Makes the next `times` cycles of a task, by its place in the configuration, take `cycle` of execution time.
    fn overload(&mut self, task: usize, cycle: Span, times: u32);

    /// Keeps a task from the processor until `until`.
    fn suspend(&mut self, task: usize, until: Time);
}

/// Expert functions that hardware of the board can help: it makes their pulses, or counts for them.
pub trait ExpertFunctionAccess {
    /// What is connected to these embedded outputs makes square waves by itself: those of its functions are reported
    /// as [`controller::Effect::Wave`]. Before it has power.
    fn offload_pulses(&mut self, outputs: &[IoChannel]);

    /// So many changes of an input terminal's line are known to be missing before `now`.
    fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32);

    /// Hardware at an input terminal counted so many steps more by `now`, below 0 backwards.
    fn count(&mut self, now: Time, input: usize, steps: i64);
}
