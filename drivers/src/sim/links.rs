//! What is connected to the lines of a simulated board.

use signal::Value;

use crate::ChannelId;
use crate::circuit::Plant;
use crate::course::Course;

/// A plant and the lines that it drives.
#[derive(Debug)]
pub(super) struct PlantAt {
    pub(super) name: String,
    pub(super) plant: Box<dyn Plant>,
    pub(super) outputs: Vec<ChannelId>,
    /// What the outputs drive.
    pub(super) driving: Vec<Value>,
}

/// The input of a plant at a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlantEnd {
    pub(super) plant: usize,
    pub(super) port: usize,
    /// Whether it takes how the line goes on, besides its value: not where what it does comes back to the plant that drives
    /// the line, since neither of the two has a closed form then.
    pub(super) takes_courses: bool,
}

/// What is connected to a line.
#[derive(Debug, Default)]
pub(super) struct Links {
    pub(super) wires_in: Vec<usize>,
    pub(super) plants_in: Vec<(usize, usize)>,
    pub(super) wires_out: Vec<usize>,
    pub(super) plants_out: Vec<PlantEnd>,
    /// How the line goes on, as its plants last took it.
    pub(super) course: Option<Course>,
    /// The count that the line reports, and the lines of those that it is a signal of.
    pub(super) tally: Option<usize>,
    pub(super) tallies_out: Vec<ChannelId>,
}
