//! The CAN buses of a board file on this machine's interfaces.

use std::sync::Arc;

use document::{Entry, Fields, Findings, Node};
use signal::Span;

use super::{DeviceReader, buses, codes};
use crate::BusId;
use crate::can::{CanBusSpec, CanSpec, Filter};

/// CAN buses.
pub(super) const READER: DeviceReader = DeviceReader {
    tables: &[],
    channel_keys: &[],
    bus_kind: Some(KIND),
    read: |fields, _, out| Some(Arc::new(CanSpec { buses: read(fields, out) })),
};

const KIND: &str = "can";

/// The keys of a CAN bus on a real board.
pub(in crate::file) const KEYS: &[&str] = &[
    "kind",
    "interface",
    "bitrate",
    "sample-point",
    "data-bitrate",
    "data-sample-point",
    "accept",
    "restart",
    "listen-only",
    "configure",
];

/// The longest name of an interface.
const LONGEST: usize = 15;
/// The most patterns of identifiers that a bus accepts: the kernel takes no more.
const MOST_FILTERS: usize = 512;
const MILLISECOND: i64 = 1_000_000;

/// The CAN buses of a file. What is wrong with them is reported.
fn read(fields: &Fields, out: &mut Findings) -> Vec<CanBusSpec> {
    let all = buses::of_kind(fields, KIND);
    let read: Vec<CanBusSpec> =
        all.filter_map(|(entry, fields, bus)| can(entry, &fields, bus, out)).collect();
    twice(&read, out);
    read
}

/// A CAN bus, `bus` its place among the buses. `None` where something is wrong with it.
fn can(entry: &Entry, fields: &Fields, bus: BusId, out: &mut Findings) -> Option<CanBusSpec> {
    let before = out.errors();
    buses::misplaced(fields, false, KEYS, out);
    let interface = interface(entry, fields, out);
    let bitrate = number(fields, "bitrate");
    if bitrate.is_none() && fields.get("bitrate").is_none() {
        let message = format!("the bit rate of `{}` is not said", entry.key);
        let help = "add `bitrate`, as in `bitrate = 500_000`: the rig checks that the interface has it";
        out.error(codes::BUS_KEY, entry.key_span.clone(), message, help);
    }
    let data_bitrate = number(fields, "data-bitrate");
    if let (Some(slow), Some(fast), Some(node)) = (bitrate, data_bitrate, fields.get("data-bitrate"))
        && fast < slow
    {
        let help = format!("write {slow} or more");
        out.bad(codes::CAN_VALUE, node, "the data of a frame are not slower than its beginning", help);
    }
    let sample_point = sample_point(fields, "sample-point", out);
    let data_sample_point = sample_point_of_data(fields, out);
    let accept = accept(fields, out);
    let restart = restart(fields, out);
    let (interface, interface_place) = interface?;
    let spec = CanBusSpec {
        bus,
        name: entry.key.clone(),
        place: entry.key_span.clone(),
        interface_place,
        interface,
        bitrate: bitrate?,
        sample_point,
        data_bitrate,
        data_sample_point,
        accept,
        restart,
        listen_only: fields.boolean("listen-only").unwrap_or(false),
        configure: fields.boolean("configure").unwrap_or(false),
    };
    (out.errors() == before).then_some(spec)
}

/// Reports interfaces that carry two buses.
fn twice(buses: &[CanBusSpec], out: &mut Findings) {
    for (at, bus) in buses.iter().enumerate() {
        if let Some(first) = buses[..at].iter().find(|first| first.interface == bus.interface) {
            let message = format!("{} is the interface of `{}` already", bus.interface, first.name);
            let help = "give each bus an interface of its own";
            out.error(codes::CAN_TWICE, bus.interface_place.clone(), message, help);
        }
    }
}

fn interface(entry: &Entry, fields: &Fields, out: &mut Findings) -> Option<(String, std::ops::Range<usize>)> {
    let Some(node) = fields.get("interface") else {
        let message = format!("the CAN bus `{}` has no interface", entry.key);
        let help = "add `interface`, as in `interface = \"can0\"`";
        out.error(codes::BUS_KEY, entry.key_span.clone(), message, help);
        return None;
    };
    let name = node.as_text()?;
    let fits = (1..=LONGEST).contains(&name.len())
        && name.bytes().all(|byte| byte.is_ascii_graphic() && !b"/:%".contains(&byte));
    if !fits {
        let help = "write the name that `ip link` shows, as in can0";
        out.bad(codes::CAN_VALUE, node, "no interface has this name", help);
        return None;
    }
    Some((name.to_owned(), node.span.clone()))
}

fn number(fields: &Fields, key: &str) -> Option<u32> {
    fields.integer(key).and_then(|number| u32::try_from(number).ok())
}

/// In thousandths, as the kernel has it.
fn sample_point(fields: &Fields, key: &str, out: &mut Findings) -> Option<u32> {
    let number = fields.number(key)?;
    let thousandths = (number * 1_000.0).round();
    if !(1.0..1_000.0).contains(&thousandths) {
        let help = "write a number above 0 and below 1, as in 0.875";
        out.bad(codes::CAN_VALUE, fields.get(key)?, "a bit is looked at somewhere inside", help);
        return None;
    }
    Some(thousandths as u32)
}

fn sample_point_of_data(fields: &Fields, out: &mut Findings) -> Option<u32> {
    let point = sample_point(fields, "data-sample-point", out)?;
    if fields.get("data-bitrate").is_none() {
        let help = "add `data-bitrate`, or remove it";
        out.bad(codes::CAN_VALUE, fields.get("data-sample-point")?, "the bus has no fast data", help);
    }
    Some(point)
}

fn accept(fields: &Fields, out: &mut Findings) -> Vec<Filter> {
    let patterns = fields.each("accept");
    if let (true, Some(node)) = (patterns.len() > MOST_FILTERS, fields.get("accept")) {
        let help = "join patterns by a mask, as in \"700/780\"";
        out.bad(codes::CAN_VALUE, node, format!("the kernel takes {MOST_FILTERS} patterns at most"), help);
        return Vec::new();
    }
    let read = |node: &Node| {
        let filter = node.as_text().and_then(Filter::parse);
        if filter.is_none() && node.as_text().is_some() {
            let help = "write up to three hexadecimal digits, or eight of an extended identifier, and the bits that \
                        count after a slash: \"701\", \"700/780\", \"18FEF100\"";
            out.bad(codes::CAN_VALUE, node, "this is no pattern of identifiers", help);
        }
        filter
    };
    patterns.iter().filter_map(read).collect()
}

fn restart(fields: &Fields, out: &mut Findings) -> Option<Span> {
    let restart = fields.duration("restart")?;
    let nanos = restart.as_nanos();
    if nanos <= 0 || nanos % MILLISECOND != 0 || nanos / MILLISECOND > i64::from(u32::MAX) {
        let help = "write it in whole milliseconds, as in \"100 ms\"";
        out.bad(codes::CAN_VALUE, fields.get("restart")?, "the kernel counts in milliseconds", help);
        return None;
    }
    Some(restart)
}
