//! What a trend recorded, and who reads and writes files: the dashboard itself knows no format.

use crate::frame_decoder::FrameDecoder;
use control::{RequestFault, SignalKind, WireValue};

/// What was recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrendRecording {
    /// The signals.
    pub tracks: Vec<RecordedSignal>,
    /// Their changes, in the order of their latest instants.
    pub samples: Vec<RecordedChange>,
    /// The first and the last instant that it covers, nanoseconds.
    pub span: (i64, i64),
}

/// A signal.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedSignal {
    /// Its name.
    pub name: String,
    /// The unit of its values; empty for none.
    pub unit: String,
    /// What its values are.
    pub kind: SignalKind,
    /// The names of its values, where they have any.
    pub labels: Vec<(i64, String)>,
}

/// A change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedChange {
    /// The place of its track.
    pub track: usize,
    /// The earliest and the latest instant, nanoseconds.
    pub when: (i64, i64),
    /// The value from then on.
    pub value: WireValue,
}

/// Reads and writes files. The ending of a path says the format.
pub trait TrendFiles: std::fmt::Debug {
    /// The formats that it writes, as the endings of paths.
    fn extensions(&self) -> &[&str];

    /// Writes one; a file that is there is not overwritten.
    ///
    /// # Errors
    /// An ending that is not known, a file that is there or cannot be written.
    fn save(&self, path: &str, recording: &TrendRecording) -> Result<(), RequestFault>;

    /// Reads one.
    ///
    /// # Errors
    /// A file that cannot be read or understood.
    fn load(&self, path: &str) -> Result<TrendRecording, RequestFault>;

    /// Reads what frames mean.
    ///
    /// # Errors
    /// A file that cannot be read or understood.
    fn decoder(&self, path: &str) -> Result<Box<dyn FrameDecoder>, RequestFault>;
}
