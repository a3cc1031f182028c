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

impl SourceFile {
    /// A text under the name that the user knows.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        SourceFile { name: name.into(), text: text.into() }
    }
}

/// A place with what it has to say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagnosticLabel {
    /// Name of the file.
    pub file: String,
    /// Bytes of the text.
    pub span: Range<usize>,
    /// What is to be said of this place; may be empty.
    pub text: String,
}

/// A finding: a code that has a page, what is wrong, where, and the fix.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// `P0102` for plans, `B....` boards, `S....` programs, `R....` the rig itself.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, one sentence without a final stop.
    pub message: String,
    /// The place first, then further places (for example the row that gave the value).
    pub labels: Vec<DiagnosticLabel>,
    /// What to do about it; may be empty.
    pub help: String,
}

impl Diagnostic {
    /// An error without a place yet.
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Diagnostic {
            code,
            severity: Severity::Error,
            message: message.into(),
            labels: Vec::new(),
            help: String::new(),
        }
    }

    /// A warning without a place yet.
    pub fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Diagnostic { severity: Severity::Warning, ..Self::error(code, message) }
    }

    /// The same with one more place; the first one given is where the finding stands.
    #[must_use]
    pub fn at(mut self, file: impl Into<String>, span: Range<usize>, text: impl Into<String>) -> Self {
        self.labels.push(DiagnosticLabel { file: file.into(), span, text: text.into() });
        self
    }

    /// The same with what to do about it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = help.into();
        self
    }

    /// Whether the file is refused for it.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}
