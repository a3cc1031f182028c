//! The devices of this machine behind a board file.

use std::sync::Arc;

use document::{Entry, Fields, Findings, Node};

use super::bench::Bench;
use super::buses::buses;
use super::{adc, can, codes, counter, generators, keys, lines, relays, serial};
use crate::BusId;
use crate::can::CanSpec;
use crate::device_limits::DeviceLimits;
use crate::real::RealSpec;
use crate::serial::SerialLinesSpec;

/// What only a board of real devices has: tables of the file, keys of its board.
const TABLES: &[&str] = &["chips", "converters", "counters", "fault-relays", "generators"];
const OF_BOARD: &[&str] = &["backend", "check", "consumer", "reconnect", "unresponsive-after"];
/// Of a channel with a GPIO line.
pub(super) const OF_LINE: &[&str] =
    &["chip", "line", "bias", "active-low", "debounce", "drive", "readback", "counts-up-to", "pulses-up-to"];

/// Reports keys of real devices on a simulated board.
pub(super) fn reject_real_only_keys(fields: &Fields, out: &mut Findings) {
    let help = "remove it, or make the board one of kind = \"real\"";
    let mut strange = |fields: &Fields, keys: &[&str]| {
        for entry in keys.iter().filter_map(|key| fields.entry(key)) {
            let message = format!("a simulated board has no `{}`", entry.key);
            out.error(codes::OTHER_BOARD, entry.key_span.clone(), message, help);
        }
    };
    strange(fields, TABLES);
    if let Some(board) = fields.inner("board") {
        strange(&board, OF_BOARD);
    }
    for (_, fields) in channels(fields) {
        strange(&fields, OF_LINE);
        strange(&fields, adc::OF_INPUT);
        strange(&fields, counter::OF_COUNT);
        strange(&fields, generators::OF_OUTPUT);
    }
}

/// The devices of a file whose channels and bindings were read. `None` where something is wrong with them.
pub(super) fn real(fields: &Fields, bench: &mut Bench, out: &mut Findings) -> Option<RealSpec> {
    for entry in ["wires", "plants", "faults"].iter().filter_map(|key| fields.entry(key)) {
        let message = format!("a board of real devices has no `{}`", entry.key);
        let help = "remove it, and wire the lines themselves";
        out.error(codes::OTHER_BOARD, entry.key_span.clone(), message, help);
    }
    let board = fields.inner("board")?;
    let unresponsive_after = board.duration("unresponsive-after").unwrap_or(DeviceLimits::UNRESPONSIVE_AFTER);
    if let Some(node) = board.get("unresponsive-after").filter(|_| unresponsive_after.as_nanos() == 0) {
        out.bad(codes::TIME, node, "every call on a device lasts longer than 0", "write a duration above 0");
    }
    let relays = relays::relays(fields, bench, out);
    let gpio = lines::gpio(fields, bench, out);
    let converters = adc::converters(fields, bench, out);
    let counters = counter::counters(fields, bench, out);
    let generators = generators::generators(fields, bench, out);
    let mut on_can = Vec::new();
    let mut ports = Vec::new();
    for (at, (entry, fields)) in buses(fields, out).into_iter().enumerate() {
        let bus = BusId(at as u16);
        if fields.text("kind") == Some("can") {
            on_can.extend(can::can(entry, &fields, bus, out));
            continue;
        }
        if fields.text("kind") == Some("serial") {
            ports.extend(serial::serial(entry, &fields, bus, out));
            continue;
        }
        let message = format!("no device carries `{}`", entry.key);
        out.error(codes::OTHER_BOARD, entry.key_span.clone(), message, "remove it");
    }
    can::twice(&on_can, out);
    serial::twice(&ports, out);
    let gpio = gpio.filter(|_| !out.has_errors())?;
    Some(RealSpec {
        limits: DeviceLimits { unresponsive_after, reconnect: board.boolean("reconnect").unwrap_or(false) },
        devices: vec![
            Arc::new(gpio),
            Arc::new(CanSpec { buses: on_can }),
            Arc::new(SerialLinesSpec { lines: ports }),
            Arc::new(converters),
            Arc::new(counters),
            Arc::new(generators),
        ],
        relays,
    })
}

/// The channels that the file describes.
pub(super) fn channels<'a>(fields: &Fields<'a>) -> impl Iterator<Item = (&'a Entry, Fields<'a>)> {
    let table = fields.get("channels").and_then(Node::as_table);
    let entries = table.map_or(&[][..], |table| &table.entries);
    entries.iter().filter_map(|entry| Some((entry, Fields::checked(entry.node.as_table()?, keys::CHANNEL))))
}
