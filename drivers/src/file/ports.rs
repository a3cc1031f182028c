//! Which bus of the board each port of the controller is on.

use std::ops::Range;

use document::{Diagnostic, Entry, Fields, Findings, Node, suggest};

use super::{codes, keys};
use crate::BusId;

/// A port of a controller that a board can be bound to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SubjectPort {
    /// Its name, and another one for it; in any case of letters.
    pub names: [String; 2],
    /// What it is on the wire.
    pub kind: SubjectPortKind,
}

/// What a port is on the wire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SubjectPortKind {
    /// A serial line.
    Serial {
        /// It can be RS-232; RS-485 every one can be.
        rs232: bool,
    },
    /// A CAN bus.
    Can,
    /// Something that no bus of a board is, in words: `an Ethernet network`.
    Other(String),
}

/// A port of the controller and the bus that it is on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortBinding {
    /// The port's name, as the controller spells it.
    pub port: String,
    /// The bus: the controller's end of a serial line, its node of a CAN bus.
    pub bus: BusId,
    /// Where the file says so, for what is found later.
    pub place: Range<usize>,
}

/// A bus as far as ports need it.
struct BoundBus<'a> {
    entry: &'a Entry,
    id: BusId,
    fields: Fields<'a>,
}

/// Reads `ports`. What is wrong with the buses themselves is reported where they are read.
pub(super) fn read(
    fields: &Fields<'_>,
    ports: &[SubjectPort],
    simulated: bool,
    out: &mut Findings,
) -> Vec<PortBinding> {
    let entries = |key| fields.get(key).and_then(Node::as_table).map_or(&[][..], |table| &table.entries);
    let buses: Vec<BoundBus<'_>> = (0..)
        .zip(entries("buses"))
        .filter_map(|(place, entry)| {
            let fields = Fields::checked(entry.node.as_table()?, keys::BUS);
            Some(BoundBus { entry, id: BusId(place), fields })
        })
        .collect();
    let mut bound: Vec<PortBinding> = Vec::new();
    for entry in entries("ports") {
        let Some(port) = known_port(entry, ports, out) else { continue };
        let Some(bus) = known_bus(&entry.node, &buses, out) else { continue };
        if !suits(port, bus, &entry.node, simulated, out) {
            continue;
        }
        let name = &port.names[0];
        if let Some(other) = bound.iter().find(|other| other.port == *name) {
            let message = format!("{name} is bound already");
            twice(message, entry.key_span.clone(), other, "keep one of the two", out);
            continue;
        }
        if let Some(other) = bound.iter().find(|other| other.bus == bus.id) {
            let message = format!("{} is on `{}` already", other.port, bus.entry.key);
            let help = "describe an end or a node for each, which `joins` the other";
            twice(message, entry.node.span.clone(), other, help, out);
            continue;
        }
        bound.push(PortBinding { port: name.clone(), bus: bus.id, place: entry.key_span.clone() });
    }
    bound
}

fn twice(message: String, place: Range<usize>, other: &PortBinding, help: &str, out: &mut Findings) {
    let found = Diagnostic::error(codes::PORT_TWICE, message)
        .at(out.file().to_owned(), place, "")
        .at(out.file().to_owned(), other.place.clone(), "here first")
        .help(help);
    out.push(found);
}

/// The port that a key names.
fn known_port<'a>(entry: &Entry, ports: &'a [SubjectPort], out: &mut Findings) -> Option<&'a SubjectPort> {
    let named = |port: &&SubjectPort| port.names.iter().any(|name| name.eq_ignore_ascii_case(&entry.key));
    let found = ports.iter().find(named);
    if found.is_none() {
        let message = format!("the controller has no port `{}`", entry.key);
        let known = ports.iter().flat_map(|port| &port.names).map(String::as_str);
        let all: Vec<&str> = ports.iter().map(|port| port.names[0].as_str()).collect();
        let help = match suggest(&entry.key, known) {
            Some(meant) => format!("did you mean `{meant}`? it has {}", all.join(", ")),
            None => format!("it has {}", all.join(", ")),
        };
        out.error(codes::PORT, entry.key_span.clone(), message, help);
    }
    let found = found?;
    if let SubjectPortKind::Other(what) = &found.kind {
        let message = format!("{} cannot be bound: it is {what}", found.names[0]);
        let help = "remove it: serial lines and CAN buses are what ports are bound to";
        out.error(codes::PORT_NOT_BOUND, entry.key_span.clone(), message, help);
        return None;
    }
    Some(found)
}

/// The bus that a value names.
fn known_bus<'a, 'b>(node: &Node, buses: &'a [BoundBus<'b>], out: &mut Findings) -> Option<&'a BoundBus<'b>> {
    let name = node.as_text()?;
    let found = buses.iter().find(|bus| bus.entry.key == name);
    if found.is_none() {
        let help = match suggest(name, buses.iter().map(|bus| bus.entry.key.as_str())) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => String::from("describe it under `[buses]`"),
        };
        out.bad(codes::PORT_BUS, node, format!("the board has no bus `{name}`"), help);
    }
    found
}

/// Whether a port can be on a bus.
fn suits(port: &SubjectPort, bus: &BoundBus<'_>, node: &Node, simulated: bool, out: &mut Findings) -> bool {
    let (is_serial, name) = (bus.fields.text("kind") == Some("serial"), &port.names[0]);
    let wrong = match port.kind {
        SubjectPortKind::Serial { .. } if !is_serial => {
            Some((format!("{name} is a serial line, `{}` a CAN bus", bus.entry.key), "name a serial line"))
        }
        SubjectPortKind::Can if is_serial => {
            Some((format!("{name} is a CAN bus, `{}` a serial line", bus.entry.key), "name a CAN bus"))
        }
        // What a real port of the machine is on the wire, its adapter says.
        SubjectPortKind::Serial { rs232: false } if simulated && !bus.fields.has("rs485") => {
            let message = format!("{name} is RS-485 alone, `{}` RS-232", bus.entry.key);
            Some((message, "give the ends of the line `rs485 = {}`"))
        }
        _ => None,
    };
    match wrong {
        Some((message, help)) => {
            out.bad(codes::PORT_KIND, node, message, help);
            false
        }
        None => true,
    }
}
