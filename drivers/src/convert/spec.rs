//! What a board file says of converters.

use crate::ChannelId;
use signal::Span;
use std::ops::Range;

/// The converters of a board, and the channels behind their inputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConvertersSpec {
    /// The converters.
    pub converters: Vec<ConverterSpec>,
    /// The inputs behind channels, in the order of the channels.
    pub samples: Vec<SampleSpec>,
}

/// A converter.
#[derive(Clone, Debug, PartialEq)]
pub struct ConverterSpec {
    /// Its name in the board file.
    pub name: String,
    /// Where the file names it.
    pub place: Range<usize>,
    /// Time between two readings of an input.
    pub period: Span,
    /// What it is.
    pub kind: ConverterKind,
}

/// What a converter is.
#[derive(Clone, Debug, PartialEq)]
pub enum ConverterKind {
    /// None that the rig can read.
    None,
}

/// How an input is found on its converter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FindInput {
    /// By its number.
    Number(u16),
    /// By its name.
    Name(String),
}

/// The input behind a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleSpec {
    /// The channel.
    pub channel: ChannelId,
    /// Place of its converter in [`ConvertersSpec::converters`].
    pub converter: usize,
    /// The input.
    pub input: FindInput,
    /// Where the file says so.
    pub place: Range<usize>,
}
