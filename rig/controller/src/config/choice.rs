//! Options of a controller that are chosen from a list.

use profile::Profile;

/// Which task exchanges what no task uses (controller:PRIO-06, controller:DEV-10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BusCycle {
    /// MAST, the default.
    #[default]
    Mast,
    /// The task at this place.
    Task(usize),
    /// The slowest cyclic task, `<unspecified>`.
    Slowest,
}

/// Always update variables (controller:DEV-10, controller:DEV-12).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AlwaysUpdate {
    /// What no task uses is not updated; the M251's default.
    Disabled,
    /// Enabled 1: what no task uses is updated in the bus cycle task; the only choice of 2019, the default of 2014.
    Unused,
    /// Enabled 2: everything is updated in the bus cycle task too; in 2014 "Update all variables in all devices".
    Always,
}

impl AlwaysUpdate {
    pub(super) const fn default_of(profile: Profile) -> AlwaysUpdate {
        match profile {
            Profile::M241_2014 | Profile::M241_2019 => AlwaysUpdate::Unused,
            Profile::M251_2024 => AlwaysUpdate::Disabled,
        }
    }

    /// Whether the profile has this choice (controller:DEV-10).
    pub(super) const fn exists(self, profile: Profile) -> bool {
        match profile {
            Profile::M241_2014 => !matches!(self, AlwaysUpdate::Disabled),
            Profile::M241_2019 => matches!(self, AlwaysUpdate::Unused),
            Profile::M251_2024 => true,
        }
    }
}

/// Behaviour for outputs in Stop (controller:DEV-10, controller:STOP-03).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OutputsInStop {
    /// Keep current values.
    Keep,
    /// Set all outputs to default, the default.
    #[default]
    Default,
}

/// What outputs do in HALT: the documents grant "Keep current values" to STOPPED only, so both readings can be
/// chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum HaltOutputs {
    /// The same as in STOPPED.
    #[default]
    Configured,
    /// Always the default values.
    Default,
}

/// How outputs that protection switched off come back (io:OUT-07, io:OUT-08).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Rearming {
    /// By themselves, tried every second; the default.
    #[default]
    Automatic,
    /// On a rising edge of the rearming command.
    Manual,
}

/// Starting mode at power-on (controller:DEV-10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum StartingMode {
    /// Start as previous state, the default.
    #[default]
    Previous,
    /// Start in stop.
    Stop,
    /// Start in run.
    Run,
}

/// What the time of a task watchdog measures (controller:WD-10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WatchdogBasis {
    /// From the start of the cycle to its end, with the time in which the task was pre-empted.
    #[default]
    Elapsed,
    /// The processor time of the task alone, for comparison.
    Processor,
}
