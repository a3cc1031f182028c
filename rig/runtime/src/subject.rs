//! What is under test: the model (`model.rs`), or a real controller on the same wires (`external.rs`).

use crate::capability::Capability;
use crate::catalogue::Catalogue;
use crate::hook::HookError;
use crate::observable::Observable;
use crate::schedule::FileAction;
use controller::{
    Command, CommandError, Disturbance, Effects, FileError, FileProbe, FrontPanel, JitterCounts, Probe,
    ProbeId, State, TaskFigures, WriteError,
};
use signal::{Cause, Level, Span, Time, Value, When};
use std::sync::atomic::AtomicBool;

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
    /// [`controller::Effect::Wave`]. Before it has power.
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

    /// What reports its state, where [`controller::Effect::State`] does not.
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
