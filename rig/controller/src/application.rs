//! What the controller asks of an application, and of whoever turns a bundle into one.

use crate::config::RelocationPart;
use crate::location::VariableLocation;
use crate::memory::Memory;
use expert::ExpertFunctions;
use profile::ApplicationError;
use signal::{Span, Time, Value};
use std::any::Any;
use thiserror::Error;

/// The user's code and variables, resumable in modelled time.
///
/// Operations are atomic and take effect when they complete. Whatever is called between two calls of
/// [`Application::resume`], and however its budget is cut, the same operations complete at the same instants.
/// Nothing in here allocates between two calls of [`Application::reset`].
pub trait Application: Send {
    /// The number of tasks that it was built for.
    fn tasks(&self) -> usize;

    /// Starts a cycle of a task, abandoning an unfinished one.
    fn begin(&mut self, task: usize);

    /// Runs a task's cycle from `now` for at most `budget`. Operations complete as long as their cost fits; those
    /// without cost complete with the one before them.
    /// Calls of function blocks reach the expert functions, which are at `now` or before it; where one of these calls
    /// made something due sooner, or is observed, the slice ends after it with [`SliceEnd::Touched`].
    fn resume(
        &mut self,
        task: usize,
        now: Time,
        budget: Span,
        memory: &mut Memory,
        functions: &mut ExpertFunctions,
    ) -> Slice;

    /// Gives variables their initial values, except the kinds that `reset` keeps.
    fn reset(&mut self, reset: VariableReset);

    /// Writes the initial values of located variables into memory. Called after [`Application::reset`]; the bits of
    /// %Q that are written here have a software initialization value (controller:OUT-03).
    fn initialize(&self, memory: &mut Memory);

    /// Whether a variable is associated with `%MW<word>`, which ends the word's automatic retention
    /// (controller:REM-03).
    fn associates(&self, word: u32) -> bool;

    /// Whether a task writes into byte `byte` of %Q (controller:PRIO-05).
    fn writes_output(&self, task: usize, byte: u32) -> bool;

    /// Whether a task writes bit `bit` of %Q (controller:FRC-05). Whole bytes, unless the application knows better.
    fn writes_output_bit(&self, task: usize, bit: u32) -> bool {
        self.writes_output(task, bit / 8)
    }

    /// Whether a task reads bit `bit` of %I (controller:PRIO-04).
    fn reads_input(&self, task: usize, bit: u32) -> bool;

    /// Bytes of an image of the remanent variables.
    fn retained_len(&self) -> usize;

    /// Writes the image of the remanent variables into `out`, which has [`Application::retained_len`] bytes.
    fn save_retained(&self, out: &mut [u8]);

    /// Takes the remanent variables from an image; FALSE, with nothing taken, when it does not fit this application.
    fn restore_retained(&mut self, image: &[u8]) -> bool;

    /// Names, types and places of what [`Application::save_retained`] writes: what another application needs to take
    /// its variables from such an image.
    fn retained_map(&self) -> Vec<u8>;

    /// Takes from the image of another application, which has this map, the persistent variables that both have with
    /// the same path and type (controller:REM-02 note 2). TRUE where this application has every remanent variable of
    /// the map (controller:REM-06); nothing is taken, and FALSE, where map and image do not belong together.
    fn adopt_retained(&mut self, map: &[u8], image: &[u8]) -> bool;

    /// Identity of what is declared: the same for applications that differ in code alone (controller:REM-02 note 1).
    fn declarations(&self) -> u64;

    /// Whether a remanent variable changed since the last call.
    fn retained_dirty(&mut self) -> bool;

    /// Identity of code and variables (controller:STATE-10).
    fn signature(&self) -> u64;

    /// The number of a variable by its path, in any case of letters; `None` where there is no variable of that path or
    /// it is in the controller's memory. Valid as long as the application is. Not to be called inside a scan.
    fn variable(&self, path: &str) -> Option<u32>;

    /// Where a variable is, for the relocation table; `None` for one that does not exist or has a block or an address in
    /// it. Not to be called inside a scan.
    fn locate(&self, path: &str) -> Option<VariableLocation>;

    /// The number of two bytes of an extent, as a WORD, or of one as a BYTE at the end of an odd number: those of register
    /// `word`, from 0, of the extent of `bytes` bytes whose first byte has the number `first`.
    fn word_of(&self, first: u32, bytes: u32, word: u16) -> Option<u32>;

    /// The value of a variable.
    fn read(&self, variable: u32) -> Value;

    /// Writes a variable, cut to its width.
    fn write(&mut self, variable: u32, value: Value);

    /// From now on, a change of the variable ends a slice with [`SliceEnd::Touched`].
    fn watch(&mut self, variable: u32);

    /// Ends [`Application::watch`], also of variables that share its memory.
    fn unwatch(&mut self, variable: u32);

    /// Answers what a task asked for with [`SliceEnd::SystemCall`]; its cycle goes on with the next slice.
    fn answer(&mut self, task: usize, result: i64);

    /// Every task stops with [`SliceEnd::Break`] before the first statement of a line (from 1), or of the next line that
    /// has one: which line that is. `None` where no statement follows in the file, which is given by its place.
    fn breakpoint(&mut self, file: u16, line: u32) -> Option<u32>;

    /// Takes every breakpoint away.
    fn clear_breakpoints(&mut self);

    /// A task stops with [`SliceEnd::Break`] before its next statement.
    fn step(&mut self, task: usize);

    /// Takes over from an application no cycle of which is under way: variables of the same path and type have its
    /// values, the others their initial ones. Whether only code differs; `None` where it cannot, with nothing
    /// changed. Watches and breakpoints start again, and so do the numbers of variables.
    fn succeed(&mut self, old: &mut dyn Application) -> Option<bool>;

    /// For [`Application::succeed`].
    fn as_any(&mut self) -> &mut dyn Any;
}

/// What a program can ask of the controller (controller:LIB-03).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SystemCall {
    /// To sleep for so many milliseconds (controller:TASK-52).
    WaitSleep,
    /// The interval of the running task in microseconds (controller:TASK-13).
    GetTaskCycle,
    /// To set it (controller:TASK-13).
    SetTaskCycle,
    /// Whether MAST is in its first cycle since RUNNING was entered (controller:TASK-53).
    FirstMastCycle,
    /// The same after a cold start.
    FirstMastColdCycle,
    /// The same after a warm start.
    FirstMastWarmCycle,
    /// Whether an input or output is forced (controller:STATE-03).
    HasForcedIo,
    /// Status bytes of an expansion module (io:DIAG-06): its index, the first byte and how many, eight bits each.
    ModuleInternalStatus,
    /// The clock, in seconds since 1970 (controller:DEV-22).
    GetRtc,
    /// To correct the clock by so many seconds a week (controller:DEV-22).
    SetRtcDrift,
    /// To keep the indicator of the battery dark (controller:LED-05).
    InhibitBatteryLed,
    /// The code of the last exchange with the expansion module of this index (io:DIAG-04).
    ModuleBusStatus,
    /// The version of its firmware (io:DIAG-05).
    ModuleFirmware,
}

/// What a call of [`Application::resume`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slice {
    /// Modelled time of the operations that completed, 0...budget.
    pub used: Span,
    /// Why it returned.
    pub end: SliceEnd,
}

/// Why a slice ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SliceEnd {
    /// The next operation does not fit into what is left of the budget: it has begun at now + used and will complete
    /// at now + used + `next`.
    Budget {
        /// Cost of that operation, more than what is left.
        next: Span,
    },
    /// The cycle is complete.
    Done,
    /// A watched variable or place changed at now + used, or an expert function; the cycle goes on with the next call.
    Touched,
    /// A statement with a breakpoint comes next; the cycle goes on with the next call.
    Break,
    /// The program asks for something at now + used; the cycle goes on after [`Application::answer`].
    SystemCall {
        /// What it asks for.
        call: SystemCall,
        /// What it asks with; 0 where there is nothing.
        argument: i64,
    },
    /// The operation completing at now + used is an error; the cycle is over.
    Fault(ApplicationFault),
}

/// An error of the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ApplicationFault {
    /// The code that the system variable shows (controller:SYS-03).
    pub error: ApplicationError,
    /// How the controller reacts (controller:ERR-01).
    pub class: FaultClass,
    /// Place of the source file in the application.
    pub file: u16,
    /// Line in that file, from 1.
    pub line: u32,
}

/// Class of an application's error (controller:ERR-01).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FaultClass {
    /// The controller goes to HALT.
    Application,
    /// The controller reboots into EMPTY.
    System,
}

/// Which remanent variables a reset keeps (controller:REM-02). Others get their initial values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VariableReset {
    /// RETAIN variables keep their values.
    pub keep_retain: bool,
    /// PERSISTENT and RETAIN PERSISTENT variables keep their values.
    pub keep_persistent: bool,
}

impl VariableReset {
    /// Every variable is initialised.
    pub(crate) const ALL: VariableReset = VariableReset { keep_retain: false, keep_persistent: false };
    /// Reset warm.
    pub(crate) const WARM: VariableReset = VariableReset { keep_retain: true, keep_persistent: true };
    /// Reset cold.
    pub(crate) const COLD: VariableReset = VariableReset { keep_retain: false, keep_persistent: true };
}

/// Turns an application bundle into an application. Called at boot and download, never inside a scan.
pub trait Loader: Send {
    /// Builds the application of a bundle.
    ///
    /// # Errors
    /// [`LoadError`]; the controller then treats the bundle as an invalid application (controller:TR-04,
    /// controller:DL-04).
    fn load(&mut self, bundle: &[u8]) -> Result<Box<dyn Application>, LoadError>;
}

/// Why a bundle is no valid application of this controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LoadError {
    /// The bytes are no application bundle, or a damaged one.
    #[error("the application bundle is foreign, cut off or damaged")]
    Bundle,
    /// The program does not compile.
    #[error("the program of the bundle has {errors} errors")]
    Program {
        /// Number of errors.
        errors: usize,
    },
    /// The bundle was built for another number of tasks.
    #[error("the bundle was built for {found} tasks, the controller is configured with {expected}")]
    Tasks {
        /// Tasks of the controller's configuration.
        expected: usize,
        /// Tasks of the bundle.
        found: usize,
    },
    /// More remanent data than the store holds (controller:MEM-08).
    #[error("{bytes} bytes of remanent variables, the store holds {}", profile::REMANENT_BYTES)]
    Remanent {
        /// Bytes that the application asks for.
        bytes: usize,
    },
    /// A row of the relocation table does not fit (controller:REL-02).
    #[error("row {} of the {part} part of the relocation table is beyond its {} words", row + 1, profile::TABLE_WORDS)]
    Relocation {
        /// Its part.
        part: RelocationPart,
        /// Its place in that part, from 0.
        row: usize,
    },
    /// The variable that starts an event task is missing (controller:TASK-30).
    #[error("the application has no variable that starts the event task {task}")]
    Trigger {
        /// The task, by its place in the configuration.
        task: usize,
    },
    /// Two tasks write outputs of one byte, which these profiles refuse (controller:PRIO-05).
    #[error("outputs of %QB{byte} are written by tasks {} and {}: use one task", tasks.0, tasks.1)]
    SharedOutputByte {
        /// Byte of %Q.
        byte: u32,
        /// The tasks, by their places in the configuration.
        tasks: (usize, usize),
    },
}
