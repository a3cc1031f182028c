//! What other instruments recorded: value change dumps, CSV tables, sigrok sessions.
//!
//! What an instrument says of its own errors is put into the instants and levels of a capture ([`InstrumentErrors`],
//! [`LevelRule`]).
//!
//! Each reader takes bytes of any origin and gives a [`Capture`] or says what is wrong where; it neither panics nor
//! takes memory or time without bound. A change is known to lie between the last instant at which the instrument saw
//! the old value and the first at which it saw the new one.
//!
//! Goals: every instant as exact as the file has it and no more exact. Not goals: what the channels mean (that is the
//! runtime's), writing such files (that is the reports').

mod builder;
pub mod csv;
pub mod error;
mod instrument;
mod levels;
pub mod sigrok;
mod time;
pub mod vcd;
pub mod zip;

pub use error::{CaptureError, CapturePlace};
pub use instrument::{ChannelErrors, InstrumentErrors, TimebaseErrors};
pub use levels::{LevelRule, ReadingError};

use signal::{SignalRecording, Span, Value, When};

/// The most bytes of a file that is read.
pub const MAX_FILE: u64 = 256 << 20;

/// The most channels of a capture.
pub const MAX_CHANNELS: usize = 4_096;

/// The most changes of a capture.
pub const MAX_CHANGES: usize = 4_000_000;

/// How the instrument came to know of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knowledge {
    /// The file says for each change what is known: a file of the rig's own.
    Own,
    /// Every change is there, to within this.
    Edges(Span),
    /// Seen at samples this far apart: shorter pulses can be missed.
    Sampled(Span),
}

/// What the values of a channel look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelType {
    /// 0 or 1.
    Bit,
    /// Whole numbers.
    Whole,
    /// Real numbers.
    Real,
}

/// A channel.
#[derive(Clone, Debug, PartialEq)]
pub struct CapturedChannel {
    /// Its name; unique in its capture.
    pub name: String,
    /// Whether the file has several channels of this name, of which the later ones have a number after it here: the name
    /// alone does not say which one is meant.
    pub shares_name: bool,
    /// Its unit, empty where the file has none.
    pub unit: String,
    /// What its values look like.
    pub shape: ChannelType,
    /// How the trace of the rig's own recorded it whose dump this is; `None` in files of other instruments, and in dumps that do
    /// not say it.
    pub recording: Option<SignalRecording>,
}

/// A change of a channel: [`Value::Bool`], [`Value::Word`], [`Value::Int`], [`Value::Real`], or not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CapturedChange {
    /// Place of the channel.
    pub channel: u32,
    /// When, in the file's own time.
    pub at: When,
    /// What it is from then on.
    pub value: Value,
}

/// What an instrument recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// The channels.
    pub channels: Vec<CapturedChannel>,
    /// The changes, in the order of their latest instants.
    pub changes: Vec<CapturedChange>,
    /// How they came to be known.
    pub knowledge: Knowledge,
    /// The first and the last instant that the capture has.
    pub span: [signal::Time; 2],
    /// When it ends: after this nothing is known.
    pub end: When,
    /// What a file of the rig's own says of the trace.
    pub notes: Vec<(String, String)>,
}

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaptureFormat {
    /// A value change dump.
    Vcd,
    /// A table.
    Csv,
    /// A sigrok session.
    Sigrok,
}

impl CaptureFormat {
    /// The format of a file by its first bytes, or else, for tables, by the ending of its name.
    pub fn of(head: &[u8], name: &str) -> Option<CaptureFormat> {
        let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase());
        if head.starts_with(b"PK") {
            return Some(CaptureFormat::Sigrok);
        }
        if head.trim_ascii_start().starts_with(b"$") {
            return Some(CaptureFormat::Vcd);
        }
        matches!(ending.as_deref(), Some("csv" | "tsv")).then_some(CaptureFormat::Csv)
    }
}

/// Reads a capture. `period` is the time between two samples, where the user says it.
///
/// # Errors
/// [`CaptureError`] with the place in the file.
pub fn read(format: CaptureFormat, bytes: &[u8], period: Option<Span>) -> Result<Capture, CaptureError> {
    match format {
        CaptureFormat::Vcd => vcd::read(bytes, period),
        CaptureFormat::Csv => csv::read(bytes, period),
        CaptureFormat::Sigrok => sigrok::read(bytes, period),
    }
}
