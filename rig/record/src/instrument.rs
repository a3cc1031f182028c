//! What an instrument, or a board, says of its own errors, beside the verdicts that rest on it.

use serde::{Deserialize, Serialize};

/// The instrument that recorded what a case was judged by, as its file describes it: that of a capture, or the board itself.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct InstrumentRecord {
    /// The file, as the user named it.
    pub file: String,
    /// Its title; may be empty.
    pub title: String,
    /// SHA-256 of the file, 64 hexadecimal digits.
    pub sha256: String,
    /// What it states, in the order of the file.
    pub statements: Vec<InstrumentStatement>,
}

/// One statement of an instrument file or a board file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct InstrumentStatement {
    /// What it is of: `timebase` or `board`, or the name of a device or a channel.
    pub of: String,
    /// The key: `resolution`, `accuracy.plus`.
    pub key: String,
    /// The value as the file has it: `10 ns`.
    pub value: String,
}
