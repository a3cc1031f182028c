//! What is wrong with a capture.

use std::fmt;

/// Where in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CapturePlace {
    /// The file as a whole.
    Whole,
    /// A line, from 1.
    Line(u64),
    /// A file in the archive.
    Entry(String),
}

/// Why a file is no capture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptureError {
    /// Where.
    pub place: CapturePlace,
    /// What is wrong.
    pub what: String,
    /// What to do about it; may be empty.
    pub fix: &'static str,
}

impl CaptureError {
    /// Something wrong with the whole file.
    pub(crate) fn whole(what: impl Into<String>, fix: &'static str) -> CaptureError {
        CaptureError { place: CapturePlace::Whole, what: what.into(), fix }
    }

    /// Something wrong in a line.
    pub(crate) fn line(line: u64, what: impl Into<String>, fix: &'static str) -> CaptureError {
        CaptureError { place: CapturePlace::Line(line), what: what.into(), fix }
    }

    /// Something wrong with a file in the archive.
    pub(crate) fn entry(name: &str, what: impl Into<String>, fix: &'static str) -> CaptureError {
        CaptureError { place: CapturePlace::Entry(name.to_owned()), what: what.into(), fix }
    }
}

impl fmt::Display for CaptureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            CapturePlace::Whole => f.write_str(&self.what),
            CapturePlace::Line(line) => write!(f, "line {line}: {}", self.what),
            CapturePlace::Entry(name) => write!(f, "{name}: {}", self.what),
        }
    }
}

impl std::error::Error for CaptureError {}
