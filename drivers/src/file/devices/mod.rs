//! The kinds of devices that a board file can describe: one entry each.

mod adc;
pub(super) mod can;
pub(super) mod counter;
pub(super) mod generators;
mod iio;
mod lines;
pub(super) mod serial;
mod spi;

use std::sync::Arc;

use document::{Entry, Fields, Findings, Node};

use super::bench::Bench;
use super::{buses, codes, keys, number};
use crate::real::DeviceSpec;

/// How the devices of one kind are described.
pub(super) struct DeviceReader {
    /// The tables of the file that describe them.
    pub(super) tables: &'static [&'static str],
    /// The keys of a channel that only theirs have.
    pub(super) channel_keys: &'static [&'static str],
    /// The `kind` of the buses that they carry.
    pub(super) bus_kind: Option<&'static str>,
    /// Reads what a file says of them whose channels and bindings were read. What is wrong is reported; `None` where nothing
    /// can be made of it.
    pub(super) read: fn(&Fields<'_>, &mut Bench<'_>, &mut Findings) -> Option<Arc<dyn DeviceSpec>>,
}

/// Every kind, in the order in which a board is opened.
pub(super) const READERS: [DeviceReader; 6] =
    [lines::READER, can::READER, serial::READER, adc::READER, counter::READER, generators::READER];

/// The channels that the file describes.
pub(super) fn channels<'a>(fields: &Fields<'a>) -> impl Iterator<Item = (&'a Entry, Fields<'a>)> {
    let table = fields.get("channels").and_then(Node::as_table);
    let entries = table.map_or(&[][..], |table| &table.entries);
    entries.iter().filter_map(|entry| Some((entry, Fields::checked(entry.node.as_table()?, keys::CHANNEL))))
}
