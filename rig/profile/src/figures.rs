//! Durations: what instructions cost and how long the controller's own stages take.

use signal::Span;

/// Modelled execution time of instructions in nanoseconds (controller:PERF-01, controller:PERF-03).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InstructionCosts {
    /// One operation on BOOL.
    pub bool_op: u32,
    /// Addition, subtraction or multiplication of INT.
    pub int_arith: u32,
    /// Addition, subtraction or multiplication of DINT.
    pub dint_arith: u32,
    /// Addition, subtraction or multiplication of REAL.
    pub real_arith: u32,
    /// Division of REAL.
    pub real_div: u32,
    /// Load and store of an INT, both together.
    pub int_load_store: u32,
    /// Load and store of a DINT, both together.
    pub dint_load_store: u32,
    /// Load and store of a REAL, both together.
    pub real_load_store: u32,
}

impl InstructionCosts {
    /// The documented figures, the same in every profile (controller:PERF-01: microseconds per 1000
    /// instructions, which is nanoseconds per instruction).
    pub const DOCUMENTED: InstructionCosts = InstructionCosts {
        bool_op: 75,
        int_arith: 42,
        dint_arith: 41,
        real_arith: 336,
        real_div: 678,
        int_load_store: 64,
        dint_load_store: 49,
        real_load_store: 50,
    };
}

/// Durations of the three steps of BOOTING (rig definition: controller:STATE-01 names the steps without times).
pub const BOOT_STAGES: [Span; 3] = [Span::from_millis(500); 3];

/// The least processor time of a task cycle, empty or not (rig definition): reading inputs and writing outputs are
/// never free, and an empty task can never stop the modelled time.
pub const MINIMUM_CYCLE: Span = Span::from_micros(1);

/// Time from the start of a save of the remanent variables until the image is whole (rig definition, beside the
/// scan: controller:REM-05).
pub const NON_VOLATILE_SAVE: Span = Span::from_millis(1);

/// How long outputs show their initialization values after a download, or in 2014 after a reset or boot too, before
/// their default values follow (rig definition: the document of 2014 says "briefly", the others name only the order).
pub const OUTPUT_INITIALIZATION: Span = Span::from_millis(20);

/// From one attempt to rearm a protected group of outputs to the next (io:OUT-09).
pub const PROTECTION_RETRY: Span = Span::from_secs(1);

/// How long such an attempt drives the outputs before the fault is looked for again (rig definition).
pub const PROTECTION_TEST: Span = Span::from_millis(1);

/// Time from a download or the command to create the boot application until its file is whole (rig definition). Less
/// than any hold-up time, so that a loss of power after the command never finds half a file.
pub const BOOT_APPLICATION_SAVE: Span = Span::from_millis(2);

/// What a controller's clock shows when its power first comes on, in seconds since 1970-01-01 00:00 UTC (rig definition:
/// 2025-01-01 00:00).
pub const CLOCK_AT_FIRST_POWER_ON: u32 = 1_735_689_600;

/// How long tasks of priority 0...24 may take the whole processor (controller:WD-02).
pub const SYSTEM_WATCHDOG_FULL_LOAD: Span = Span::from_secs(1);

/// Intervals below this have the limit of interval + [`SHORT_INTERVAL_TOLERANCE`] (controller:TASK-12).
pub const SHORT_INTERVAL: Span = Span::from_millis(3);

/// How far a cycle of a short interval may exceed it (controller:TASK-12).
pub const SHORT_INTERVAL_TOLERANCE: Span = Span::from_millis(1);

/// Share of a whole that system processing takes after each cycle of a freewheeling task, as a fraction of the
/// cycle's own duration: 3/7 of the cycle is 30 % of cycle and pause together (controller:TASK-21).
pub const FREEWHEELING_PAUSE: (i64, i64) = (3, 7);

/// How long tasks of one priority keep the processor in turn, M241 of 2014 (controller:PRIO-02).
pub const TIME_SLICE: Span = Span::from_millis(2);

/// How often the variables that start event tasks are looked at besides the end of every cycle (rig definition within
/// what controller:TASK-30 leaves open).
pub const TRIGGER_TICK: Span = Span::from_millis(1);

/// The window in which events are counted (controller:TASK-31).
pub const EVENT_WINDOW: Span = Span::from_millis(1);

/// From an event of the hardware to the release of its task (rig definition: with the delays of input and output and
/// 100 instructions the response is the typical 200 us of controller:TASK-44).
pub const EVENT_LATENCY: Span = Span::from_micros(180);

/// The processor time of communication (rig definition: controller:PERF-02 says that it depends on the number of requests,
/// without a figure). Endpoints of every protocol use it, so that a request costs the same whatever brings it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestCosts {
    /// Of a request or of a message that is sent unasked, whatever is in it.
    pub request: Span,
    /// Of each word that it reads or writes, in addition; 16 bits count as a word.
    pub word: Span,
}

impl RequestCosts {
    /// Those of every profile.
    pub const RIG: RequestCosts =
        RequestCosts { request: Span::from_micros(250), word: Span::from_micros(1) };

    /// The processor time of a request with so many words.
    pub const fn of(&self, words: u16) -> Span {
        Span::from_nanos(self.request.as_nanos() + self.word.as_nanos() * words as i64)
    }
}

/// The percentage of the processor that the tasks may take together (controller:WD-01).
pub const OVERLOAD_PERCENT: i64 = 85;

/// How long the tasks may take more than [`OVERLOAD_PERCENT`] (controller:WD-01, controller:WD-05).
pub const SYSTEM_WATCHDOG_OVERLOAD: Span = Span::from_secs(3);

/// How often the load is evaluated (rig definition within the 50 ms of controller:WD-13).
pub const LOAD_PERIOD: Span = Span::from_millis(10);

/// The time over which an overload has to last for it to go on, where no task has a longer interval (rig definition).
pub const LOAD_WINDOW: Span = Span::from_millis(100);

/// How long the task of the lowest priority may wait for the processor (controller:WD-03).
pub const SYSTEM_WATCHDOG_STARVED: Span = Span::from_secs(10);
