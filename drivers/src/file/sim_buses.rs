//! The buses of a simulated board: CAN buses and serial lines.

use document::{Entry, Fields, Findings};
use signal::{SerialSettings, Span};

use super::buses::{buses, misplaced};
use super::codes;
use super::devices::serial;
use crate::BusId;
use crate::circuit::{BusSpec, BusSpecKind, CanRates, SerialEnd, SerialMedium};

/// The most buses of a board.
const MOST_BUSES: usize = 64;
/// The bit rate where the file says none, bit/s: the one of most machines.
const USUAL: u32 = 250_000;
/// The greatest bit rate of classic CAN, and of the arbitration of CAN FD (ISO 11898-1).
const MOST: u32 = 1_000_000;
/// The greatest bit rate of the data of CAN FD that transceivers are made for (ISO 11898-2, with signal improvement).
const MOST_DATA: u32 = 8_000_000;
/// The longest that a signal takes along a serial line: radio modems need less.
const LONGEST_DELAY: Span = Span::from_secs(10);

/// The keys of a simulated CAN bus. The others say which device of the machine carries a bus, and how.
const CAN_KEYS: &[&str] = &["kind", "bitrate", "data-bitrate", "joins"];
/// Those of a simulated serial line.
const SERIAL_KEYS: &[&str] =
    &["kind", "baud", "data-bits", "parity", "stop-bits", "rs485", "message-gap", "delay", "joins"];
/// What of `rs485` a simulated line has: the rest is about a transceiver.
const RS485_KEYS: &[&str] = &["hears-itself"];

/// The buses of a simulated board; reports what is wrong with them.
pub(super) fn read(fields: &Fields, out: &mut Findings) -> Vec<BusSpec> {
    let mut specs: Vec<BusSpec> = Vec::new();
    for (entry, fields) in buses(fields, out) {
        let is_serial = fields.text("kind") == Some("serial");
        misplaced(&fields, true, if is_serial { SERIAL_KEYS } else { CAN_KEYS }, out);
        if specs.len() >= MOST_BUSES {
            let message = format!("the board has more than {MOST_BUSES} buses");
            out.error(codes::TOO_MANY, entry.key_span.clone(), message, "remove buses");
            break;
        }
        let joins = joined(&fields, &specs, is_serial, out);
        let other = joins.and_then(|bus: BusId| specs.get(usize::from(bus.0)));
        let kind = match is_serial {
            true => serial_end(entry, &fields, other, out).map(BusSpecKind::Serial),
            false => Some(BusSpecKind::Can(can(entry, &fields, other, out))),
        };
        let Some(kind) = kind else { continue };
        if let (BusSpecKind::Serial(end), Some(bus), Some(node)) = (kind, joins, fields.get("joins"))
            && end.medium == SerialMedium::Rs232
            && ends(&specs, bus) > 1
        {
            let help = "give the ends `rs485 = {}`: any number of them share one pair of wires";
            out.bad(codes::BUS_JOIN, node, "a line of RS-232 has two ends", help);
        }
        specs.push(BusSpec { name: entry.key.clone(), kind, joins });
    }
    specs
}

/// Reports keys of `rs485` that are about a transceiver.
fn transceiver(fields: &Fields, out: &mut Findings) {
    for key in fields.table().entries.iter().filter(|key| !RS485_KEYS.contains(&key.key.as_str())) {
        let message = format!("`rs485` of a simulated board has no `{}`", key.key);
        let help = "remove it: a simulated line has no transceiver";
        out.error(codes::BUS_KEY, key.key_span.clone(), message, help);
    }
}

/// The ends on the line of a bus.
fn ends(specs: &[BusSpec], bus: BusId) -> usize {
    let line = |mut bus: BusId| {
        while let Some(joins) = specs.get(usize::from(bus.0)).and_then(|spec| spec.joins) {
            bus = joins;
        }
        bus
    };
    let of = line(bus);
    (0..specs.len() as u16).filter(|place| line(BusId(*place)) == of).count()
}

/// A CAN bus, on the wire of `other` if there is one.
fn can(entry: &Entry, fields: &Fields, other: Option<&BusSpec>, out: &mut Findings) -> CanRates {
    let joined = other.and_then(|other| match other.kind {
        BusSpecKind::Can(rates) => Some((other, rates)),
        BusSpecKind::Serial(_) => None,
    });
    let usual = CanRates { bitrate: USUAL, data_bitrate: None };
    let CanRates { bitrate, data_bitrate } = joined.map_or(usual, |(_, rates)| rates);
    let bitrate = rate(fields, "bitrate", MOST, out).unwrap_or(bitrate);
    let data_bitrate = rate(fields, "data-bitrate", MOST_DATA, out).or(data_bitrate);
    if let Some(node) = fields.get("data-bitrate").filter(|_| data_bitrate < Some(bitrate)) {
        let message = "data cannot be slower than the arbitration";
        out.bad(codes::BUS_RATE, node, message, "write a rate from `bitrate` up, or remove it");
    }
    let rates = CanRates { bitrate, data_bitrate };
    if let (Some((other, of_other)), Some(node)) = (joined, fields.get("joins"))
        && of_other != rates
    {
        let message = format!("`{}` and `{}` differ in their bit rates", entry.key, other.name);
        out.bad(codes::BUS_JOIN, node, message, "leave the bit rates to the first: one wire has one");
    }
    rates
}

/// An end of a serial line, that of `other` if there is one. What it leaves out it has from there.
fn serial_end(
    entry: &Entry,
    fields: &Fields,
    other: Option<&BusSpec>,
    out: &mut Findings,
) -> Option<SerialEnd> {
    let joined = other.and_then(|other| match other.kind {
        BusSpecKind::Serial(end) => Some((other, end)),
        BusSpecKind::Can(_) => None,
    });
    let settings =
        serial::settings(fields, joined.map_or_else(SerialSettings::default, |(_, end)| end.settings));
    let medium = match fields.inner("rs485") {
        Some(inner) => {
            transceiver(&inner, out);
            SerialMedium::Rs485 { hears_itself: inner.boolean("hears-itself").unwrap_or(false) }
        }
        None => SerialMedium::Rs232,
    };
    if let (Some((other, end)), Some(node)) = (joined, fields.get("joins"))
        && (end.medium == SerialMedium::Rs232) != (medium == SerialMedium::Rs232)
    {
        let message = format!("only one of `{}` and `{}` is on RS-485", entry.key, other.name);
        out.bad(codes::BUS_JOIN, node, message, "give both ends a table `rs485`, or none");
    }
    let delay = fields.duration("delay").unwrap_or(Span::ZERO);
    if let Some(node) = fields.get("delay").filter(|_| delay.is_negative() || delay > LONGEST_DELAY) {
        out.bad(codes::SERIAL_VALUE, node, "no line delays like this", "write a duration from 0 to 10 s");
        return None;
    }
    Some(SerialEnd { settings, medium, delay, message_gap: serial::message_gap(fields, &settings, out)? })
}

/// The bus whose wire this one is on.
fn joined(fields: &Fields, before: &[BusSpec], is_serial: bool, out: &mut Findings) -> Option<BusId> {
    let node = fields.get("joins")?;
    let name = node.as_text()?;
    let same = |spec: &&BusSpec| matches!(spec.kind, BusSpecKind::Serial(_)) == is_serial;
    let place = before.iter().position(|spec| spec.name == name && same(&spec));
    if place.is_none() {
        let known = before.iter().filter(same).map(|spec| spec.name.as_str());
        let help = match document::suggest(name, known) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => String::from("name a bus of the same kind that stands before this one"),
        };
        let message = format!("no bus `{name}` of this kind stands before this one");
        out.bad(codes::BUS_JOIN, node, message, help);
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
