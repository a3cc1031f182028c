//! What subjects and boards can do for a plan.

/// A power that a subject or a board may have and a plan may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Capability {
    /// Modelled load can be put on a task.
    TaskLoad,
    /// System variables can be read.
    SystemVariables,
    /// Variables, %M and the images can be read and written.
    MemoryAccess,
    /// Run, stop and resets can be commanded.
    Commands,
    /// The firmware can be damaged and restored.
    Firmware,
    /// Inputs and outputs can be forced.
    Force,
    /// The supply can be switched.
    Power,
    /// The Run/Stop switch can be moved.
    RunStop,
    /// An application can be downloaded.
    Download,
    /// Electrical faults can be put on lines.
    Faults,
    /// Files and the log can be seen and changed.
    Files,
    /// Registers can be read and written as over the network.
    Registers,
    /// LEDs and the states of output stages can be read.
    Indicators,
}

impl Capability {
    /// Every capability.
    pub const ALL: [Capability; 13] = [
        Capability::TaskLoad,
        Capability::SystemVariables,
        Capability::MemoryAccess,
        Capability::Commands,
        Capability::Firmware,
        Capability::Force,
        Capability::Power,
        Capability::RunStop,
        Capability::Download,
        Capability::Faults,
        Capability::Files,
        Capability::Registers,
        Capability::Indicators,
    ];

    /// The word in a plan's `needs`.
    pub const fn word(self) -> &'static str {
        match self {
            Capability::TaskLoad => "task-load",
            Capability::SystemVariables => "system-variables",
            Capability::MemoryAccess => "memory-access",
            Capability::Commands => "commands",
            Capability::Firmware => "firmware",
            Capability::Force => "force",
            Capability::Power => "power",
            Capability::RunStop => "run-stop",
            Capability::Download => "download",
            Capability::Faults => "faults",
            Capability::Files => "files",
            Capability::Registers => "registers",
            Capability::Indicators => "indicators",
        }
    }

    /// The capability of this word.
    pub fn find(word: &str) -> Option<Capability> {
        Capability::ALL.into_iter().find(|capability| capability.word() == word)
    }
}
