//! What is connected to the lines of a simulated board.

use signal::Value;

use crate::ChannelId;
use crate::plant::Plant;

/// A plant and the lines that it drives.
#[derive(Debug)]
pub(super) struct PlantAt {
    pub(super) plant: Box<dyn Plant>,
    pub(super) outputs: Vec<ChannelId>,
    /// What the outputs drive.
    pub(super) driving: Vec<Value>,
}

/// What is connected to a line.
#[derive(Debug, Default)]
pub(super) struct Links {
    pub(super) wires_in: Vec<usize>,
    pub(super) plants_in: Vec<(usize, usize)>,
    pub(super) wires_out: Vec<usize>,
    pub(super) plants_out: Vec<(usize, usize)>,
    /// The count that the line reports, and the lines of those that it is a signal of.
    pub(super) tally: Option<usize>,
    pub(super) tallies_out: Vec<ChannelId>,
}
