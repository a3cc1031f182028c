//! One finding about a user's file.

use std::ops::Range;

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Worth knowing; the file is used.
    Warning,
    /// The file is refused.
    Error,
}

/// A text of the user, by the name that the user knows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// Path as the user gave it.
    pub name: String,
    /// The whole text.
    pub text: String,
}

/// A place with what it has to say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Name of the file.
    pub file: String,
    /// Bytes of the text.
    pub span: Range<usize>,
    /// What is to be said of this place; may be empty.
    pub text: String,
}

/// A finding: a code that has a page, what is wrong, where, and the mend.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// `P0102` for plans, `B....` boards, `S....` programs, `R....` the rig itself.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, one sentence without a final stop.
    pub message: String,
    /// The place first, then further places (for example the row that gave the value).
    pub labels: Vec<Label>,
    /// What to do about it; may be empty.
    pub help: String,
}
