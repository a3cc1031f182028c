//! The user's text files: diagnostics with a code and a place, TOML whose every value knows its place, and
//! the tables of keys that the readers (and later the schemas) are made from.

mod diagnostic;

pub use diagnostic::{Diagnostic, Label, Severity, SourceFile};
