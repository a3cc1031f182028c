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

/// How long tasks of priority 0...24 may take the whole processor (controller:WD-02).
pub const SYSTEM_WATCHDOG_FULL_LOAD: Span = Span::from_secs(1);

/// Intervals below this have the limit of interval + [`SHORT_INTERVAL_TOLERANCE`] (controller:TASK-12).
pub const SHORT_INTERVAL: Span = Span::from_millis(3);

/// How far a cycle of a short interval may exceed it (controller:TASK-12).
pub const SHORT_INTERVAL_TOLERANCE: Span = Span::from_millis(1);
