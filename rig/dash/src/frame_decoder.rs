//! What frames mean, by whoever can read a description of them.

use control::FrameSeen;

/// What a frame says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DecodedFrame {
    /// The message's name.
    pub name: String,
    /// Its signals with their values and units.
    pub fields: Vec<(String, String)>,
}

/// Knows what the frames of a bus mean.
pub trait FrameDecoder: std::fmt::Debug {
    /// What a frame says; none where it is not described.
    fn decode(&self, frame: &FrameSeen) -> Option<DecodedFrame>;
}
