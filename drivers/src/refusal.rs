//! Why a device cannot be had.

use std::ops::Range;

use document::Diagnostic;

/// A device that cannot be opened: what a finding says of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Its code.
    pub code: &'static str,
    /// Where, if not at the device itself.
    pub place: Option<Range<usize>>,
    /// What is wrong.
    pub message: String,
    /// What fixes it.
    pub help: String,
}

impl Refusal {
    /// Of the device as a whole.
    pub fn new(code: &'static str, message: impl Into<String>, help: impl Into<String>) -> Refusal {
        Refusal { code, place: None, message: message.into(), help: help.into() }
    }

    /// At another place of the board file.
    #[must_use]
    pub fn at(self, place: Range<usize>) -> Refusal {
        Refusal { place: Some(place), ..self }
    }

    /// The finding in a board file, in which the device is described at `place`.
    pub fn finding(self, file: &str, place: Range<usize>) -> Diagnostic {
        let place = self.place.unwrap_or(place);
        Diagnostic::error(self.code, self.message).at(file.to_owned(), place, "").help(self.help)
    }
}
