//! What steps and their case have in common: its program, and the part of it that a step belongs to.

/// The program of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProgramRef {
    /// Structured Text files, as written: relative to the plan's folder.
    Files(Vec<String>),
    /// Structured Text in the plan itself, with the byte of the plan at which it begins (where the plan has
    /// it as it is).
    Text {
        /// The source.
        text: String,
        /// Byte of the plan, `None` if escapes stand in it.
        at: Option<usize>,
    },
    /// None: the controller starts without an application.
    None,
}

/// A part of a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CasePart {
    /// Before the steps proper, which wait for all of it.
    Setup,
    /// The steps proper.
    #[default]
    Main,
    /// After the case, however it ended.
    Teardown,
}

impl CasePart {
    /// The word in records.
    pub const fn word(self) -> &'static str {
        match self {
            CasePart::Setup => "setup",
            CasePart::Main => "main",
            CasePart::Teardown => "teardown",
        }
    }
}
