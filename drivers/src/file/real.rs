//! The devices of this machine behind a board file.

use document::{Fields, Findings};

use super::bench::Bench;
use super::buses::buses;
use super::devices::{READERS, channels};
use super::{codes, delays, relays};
use crate::device_limits::DeviceLimits;
use crate::real::RealSpec;

/// What only a board of real devices has beside the tables of its devices, and the keys of its board.
const TABLES: &[&str] = &["fault-relays"];
const OF_BOARD: &[&str] = &["backend", "check", "consumer", "reconnect", "unresponsive-after"];

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
    READERS.iter().for_each(|reader| strange(fields, reader.tables));
    if let Some(board) = fields.inner("board") {
        strange(&board, OF_BOARD);
    }
    for (_, fields) in channels(fields) {
        READERS.iter().for_each(|reader| strange(&fields, reader.channel_keys));
        strange(&fields, delays::KEYS);
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
    for (entry, fields) in buses(fields, out) {
        let kind = fields.text("kind");
        if !READERS.iter().any(|reader| reader.bus_kind.is_some() && reader.bus_kind == kind) {
            let message = format!("no device carries `{}`", entry.key);
            out.error(codes::OTHER_BOARD, entry.key_span.clone(), message, "remove it");
        }
    }
    // Which channels are relays decides which lines are driven.
    let relays = relays::relays(fields, bench, out);
    let devices = READERS.iter().filter_map(|reader| (reader.read)(fields, bench, out)).collect();
    let limits = DeviceLimits { unresponsive_after, reconnect: board.boolean("reconnect").unwrap_or(false) };
    (!out.has_errors()).then_some(RealSpec { limits, devices, relays })
}
