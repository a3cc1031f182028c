//! The serial lines behind the buses of a board file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use document::{Diagnostic, Entry, Fields, Findings};
use host::Rs485;
use signal::{Parity, SerialSettings, Span};

use super::{DeviceReader, buses, codes};
use crate::BusId;
use crate::serial::{PortSpec, SerialLinesSpec, SerialSpec};

/// Serial lines.
pub(super) const READER: DeviceReader = DeviceReader {
    tables: &[],
    channel_keys: &[],
    bus_kind: Some(KIND),
    read: |fields, _, out| Some(Arc::new(SerialLinesSpec { lines: read(fields, out) })),
};

const KIND: &str = "serial";

/// The longest delay of a transceiver's direction that the kernel takes.
const LONGEST_DELAY: Span = Span::from_millis(100);
const MILLISECOND: i64 = 1_000_000;

/// The keys of a serial line.
pub(in crate::file) const KEYS: &[&str] = &[
    "kind",
    "path",
    "baud",
    "data-bits",
    "parity",
    "stop-bits",
    "message-gap",
    "rs485",
    "low-latency",
    "exclusive",
];

/// The longest silence between two messages of a line.
const LONGEST_GAP: Span = Span::from_secs(60);

/// The serial lines of a file. What is wrong with them is reported.
fn read(fields: &Fields, out: &mut Findings) -> Vec<SerialSpec> {
    let all = buses::of_kind(fields, KIND);
    let read: Vec<SerialSpec> =
        all.filter_map(|(entry, fields, bus)| serial(entry, &fields, bus, out)).collect();
    twice(&read, out);
    read
}

/// A serial line, `bus` its place among the buses. `None` where something is wrong with it.
fn serial(entry: &Entry, fields: &Fields, bus: BusId, out: &mut Findings) -> Option<SerialSpec> {
    buses::misplaced(fields, false, KEYS, out);
    let path = path(entry, fields, out)?;
    let line = settings(fields, SerialSettings::default());
    let message_gap = message_gap(fields, &line, out)?;
    let rs485 = match fields.inner("rs485") {
        Some(fields) => Some(rs485(&fields, out)?),
        None => None,
    };
    let port = PortSpec {
        path,
        line,
        rs485,
        low_latency: fields.boolean("low-latency"),
        exclusive: fields.boolean("exclusive").unwrap_or(true),
    };
    Some(SerialSpec { bus, name: entry.key.clone(), port, message_gap, place: entry.key_span.clone() })
}

/// How a line makes characters of bits; what the file leaves out is as in `default`.
pub(in crate::file) fn settings(fields: &Fields, default: SerialSettings) -> SerialSettings {
    let number = |key, default: u32| {
        fields.integer(key).and_then(|number| u32::try_from(number).ok()).unwrap_or(default)
    };
    SerialSettings {
        baud: number("baud", default.baud).max(1),
        data_bits: number("data-bits", u32::from(default.data_bits)).clamp(5, 8) as u8,
        parity: match fields.text("parity") {
            Some("none") => Parity::None,
            Some("even") => Parity::Even,
            Some("odd") => Parity::Odd,
            _ => default.parity,
        },
        stop_bits: number("stop-bits", u32::from(default.stop_bits)).clamp(1, 2) as u8,
    }
}

/// The silence between two messages: that of Modbus RTU where the file says none.
pub(in crate::file) fn message_gap(
    fields: &Fields,
    line: &SerialSettings,
    out: &mut Findings,
) -> Option<Span> {
    let Some(gap) = fields.duration("message-gap") else {
        return (!fields.has("message-gap")).then(|| line.frame_gap());
    };
    if gap <= Span::ZERO || gap > LONGEST_GAP {
        let help = "write a duration above 0, up to 60 s";
        out.bad(codes::SERIAL_VALUE, fields.get("message-gap")?, "this is no silence between messages", help);
        return None;
    }
    Some(gap)
}

fn path(entry: &Entry, fields: &Fields, out: &mut Findings) -> Option<PathBuf> {
    let help = "write `path = \"/dev/serial/by-id/...\"`, a link that stays when the machine starts again";
    let Some(path) = fields.text("path") else {
        let message = format!("the serial line `{}` has no port", entry.key);
        out.error(codes::SERIAL_PATH, entry.key_span.clone(), message, help);
        return None;
    };
    if !Path::new(path).is_absolute() {
        out.bad(codes::SERIAL_PATH, fields.get("path")?, "this is no path of a device", help);
        return None;
    }
    Some(PathBuf::from(path))
}

fn rs485(fields: &Fields, out: &mut Findings) -> Option<Rs485> {
    let mut delay = |key| {
        let Some(lasts) = fields.duration(key) else { return Some(0) };
        let nanos = lasts.as_nanos();
        if nanos > LONGEST_DELAY.as_nanos() || nanos % MILLISECOND != 0 {
            let help = "write whole milliseconds, at most 100";
            out.bad(codes::SERIAL_VALUE, fields.get(key)?, "the kernel keeps no such delay", help);
            return None;
        }
        u32::try_from(nanos / MILLISECOND).ok()
    };
    let (before, after) = (delay("delay-before"), delay("delay-after"));
    let low_sends = fields.text("rts-on-send") == Some("low");
    Some(Rs485 {
        enabled: fields.boolean("enabled").unwrap_or(true),
        rts_on_send: !low_sends,
        rts_after_send: low_sends,
        rx_during_tx: fields.boolean("hears-itself").unwrap_or(false),
        terminate: fields.boolean("terminate").unwrap_or(false),
        delay_before: before?,
        delay_after: after?,
    })
}

/// A port carries one bus. Paths that lead to one port show when the port is there.
fn twice(lines: &[SerialSpec], out: &mut Findings) {
    for (at, line) in lines.iter().enumerate() {
        let Some(first) = lines[..at].iter().find(|first| first.port.path == line.port.path) else {
            continue;
        };
        let message = format!("the port of `{}` is used already", line.name);
        let found = Diagnostic::error(codes::SERIAL_TWICE, message)
            .at(out.file().to_owned(), line.place.clone(), "")
            .at(out.file().to_owned(), first.place.clone(), "here first")
            .help("give each serial line a port of its own");
        out.push(found);
    }
}
