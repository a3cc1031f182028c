//! A look at the devices of a board that have no lines: whether they are there, free and set up as the file says.

use document::Diagnostic;

use super::RealSpec;
use crate::bus::BusId;
use crate::channel::ChannelId;
use crate::channel_table::ChannelTable;

/// What was found, and what is wrong.
#[derive(Debug, Default)]
pub struct Look {
    /// What is behind a channel that has no line, in words; `None` where it cannot be had.
    pub inputs: Vec<(ChannelId, Option<String>)>,
    /// What a bus is, in words; `None` where it cannot be had.
    pub buses: Vec<(BusId, String, Option<String>)>,
    /// What is wrong, at its place in the file.
    pub found: Vec<Diagnostic>,
}

/// Looks at the devices of a board. Nothing is set up, and nothing is kept.
pub fn look(table: &ChannelTable, spec: &RealSpec) -> Look {
    let mut look = Look::default();
    spec.devices.iter().for_each(|devices| devices.probe(table, &mut look));
    look.buses.sort_by_key(|(bus, ..)| *bus);
    look
}
