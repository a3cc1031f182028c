//! The CAN buses of a simulated board.

use document::{Fields, Findings};

use super::buses::buses;
use super::codes;
use crate::BusId;
use crate::circuit::BusSpec;

/// The most buses of a board.
const MOST_BUSES: usize = 64;
/// The bit rate where the file says none, bit/s: the one of most machines.
const USUAL: u32 = 250_000;
/// The greatest bit rate of classic CAN, and of the arbitration of CAN FD (ISO 11898-1).
const MOST: u32 = 1_000_000;
/// The greatest bit rate of the data of CAN FD that transceivers are made for (ISO 11898-2, with signal improvement).
const MOST_DATA: u32 = 8_000_000;

/// The keys of a simulated CAN bus. The others say which device of the machine carries a bus, and how.
const KEYS: &[&str] = &["kind", "bitrate", "data-bitrate", "joins"];

/// The buses of a simulated board; reports what is wrong with them.
pub(super) fn read(fields: &Fields, out: &mut Findings) -> Vec<BusSpec> {
    let mut specs: Vec<BusSpec> = Vec::new();
    for (entry, fields) in buses(fields, out) {
        if fields.text("kind") == Some("serial") {
            let help = "remove it, or make the board one of kind = \"real\"";
            out.error(codes::BUS_KIND, entry.key_span.clone(), "a simulated board has no serial lines", help);
            continue;
        }
        for key in fields.table().entries.iter().filter(|key| !KEYS.contains(&key.key.as_str())) {
            let message = format!("a simulated bus has no `{}`", key.key);
            out.error(codes::BUS_KEY, key.key_span.clone(), message, "remove it: the bus is made, not found");
        }
        if specs.len() >= MOST_BUSES {
            let message = format!("the board has more than {MOST_BUSES} buses");
            out.error(codes::TOO_MANY, entry.key_span.clone(), message, "remove buses");
            break;
        }
        let joins = joined(&fields, &specs, out);
        let other = joins.and_then(|bus: BusId| specs.get(usize::from(bus.0)));
        let (bitrate, data_bitrate) = match other {
            Some(other) => (other.bitrate, other.data_bitrate),
            None => (USUAL, None),
        };
        let bitrate = rate(&fields, "bitrate", MOST, out).unwrap_or(bitrate);
        let data_bitrate = rate(&fields, "data-bitrate", MOST_DATA, out).or(data_bitrate);
        if let Some(node) = fields.get("data-bitrate").filter(|_| data_bitrate < Some(bitrate)) {
            let message = "data cannot be slower than the arbitration";
            out.bad(codes::BUS_RATE, node, message, "write a rate from `bitrate` up, or remove it");
        }
        if let (Some(other), Some(node)) = (other, fields.get("joins"))
            && (other.bitrate, other.data_bitrate) != (bitrate, data_bitrate)
        {
            let message = format!("`{}` and `{}` differ in their bit rates", entry.key, other.name);
            out.bad(codes::BUS_JOIN, node, message, "leave the bit rates to the first: one wire has one");
        }
        specs.push(BusSpec { name: entry.key.clone(), bitrate, data_bitrate, joins });
    }
    specs
}

/// The bus whose wire this one is on.
fn joined(fields: &Fields, before: &[BusSpec], out: &mut Findings) -> Option<BusId> {
    let node = fields.get("joins")?;
    let name = node.as_text()?;
    let place = before.iter().position(|spec| spec.name == name);
    if place.is_none() {
        let help = match document::suggest(name, before.iter().map(|spec| spec.name.as_str())) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => String::from("name a bus that stands before this one"),
        };
        out.bad(codes::BUS_JOIN, node, format!("no bus `{name}` stands before this one"), help);
    }
    place.and_then(|place| u16::try_from(place).ok()).map(BusId)
}

/// A bit rate.
fn rate(fields: &Fields, key: &str, most: u32, out: &mut Findings) -> Option<u32> {
    let number = fields.integer(key)?;
    let rate = u32::try_from(number).ok().filter(|rate| (1..=most).contains(rate));
    if let (None, Some(node)) = (rate, fields.get(key)) {
        let message = format!("{number} bit/s is not a bit rate of CAN");
        out.bad(codes::BUS_RATE, node, message, format!("write bits per second, up to {most}"));
    }
    rate
}
