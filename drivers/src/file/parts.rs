//! Wires, plants and faults of a board file.

use std::ops::Range;

use document::{Fields, Findings, Node};
use signal::Span;

use super::bench::Bench;
use super::{codes, keys, number};
use crate::circuit::{Bounce, CircuitError, CircuitFault, CircuitPart, MAX_PARTS, Spacing, WireSpec};
use crate::wrap::Disturbance;
use crate::{ChannelId, plant};

/// Adds the file's wires. Returns the value of each wire that was added.
pub(super) fn wires<'n>(nodes: &'n [Node], bench: &mut Bench, out: &mut Findings) -> Vec<&'n Node> {
    let mut places = Vec::new();
    for node in within_limit(nodes, "wires", out) {
        let Some(table) = node.as_table() else { continue };
        let fields = Fields::check(table, node.span.clone(), "wire", keys::WIRE, out);
        let end = |key: &str, out: &mut Findings| fields.get(key).and_then(|node| bench.channel(node, out));
        let (from, to) = (end("from", out), end("to", out));
        let bounce = fields.inner("bounce").and_then(|bounce| {
            let spacing =
                if bounce.text("spacing") == Some("even") { Spacing::Even } else { Spacing::Random };
            // Numbers beyond 16 bits are refused as bounces just like those above the limit.
            let edges = u16::try_from(bounce.integer("edges")?).unwrap_or(u16::MAX);
            Some(Bounce { edges, over: bounce.duration("over")?, spacing })
        });
        let (Some(from), Some(to)) = (from, to) else { continue };
        let delay = fields.duration("delay").unwrap_or(Span::ZERO);
        let (on, off) = (fields.duration("on-delay"), fields.duration("off-delay"));
        let off_delay = (on.is_some() || off.is_some()).then(|| off.unwrap_or(delay));
        let delay = on.unwrap_or(delay);
        let invert = fields.boolean("invert").unwrap_or(false);
        bench.file.circuit.wires.push(WireSpec { from, to, delay, off_delay, invert, bounce });
        places.push(node);
    }
    places
}

/// Adds the file's plants. Returns the value of each plant that was added.
pub(super) fn plants<'n>(nodes: &'n [Node], bench: &mut Bench, out: &mut Findings) -> Vec<&'n Node> {
    let mut places = Vec::new();
    for node in within_limit(nodes, "plants", out) {
        if let Some(spec) = plant::read(node, bench, out) {
            bench.file.circuit.plants.push(spec);
            places.push(node);
        }
    }
    places
}

fn within_limit<'n>(nodes: &'n [Node], what: &str, out: &mut Findings) -> &'n [Node] {
    match nodes.get(MAX_PARTS) {
        None => nodes,
        Some(first) => {
            let message = format!("the board has more than {MAX_PARTS} {what}");
            out.error(codes::TOO_MANY, first.span.clone(), message, format!("remove {what}"));
            &nodes[..MAX_PARTS]
        }
    }
}

/// The trouble that the board is to make by itself.
pub(super) fn disturbance(fields: &Fields, out: &mut Findings) -> Disturbance {
    let mut chance = |key: &str| {
        let inner = fields.inner(key);
        inner.and_then(|inner| number::chance(inner.get("chance")?, out)).unwrap_or(0)
    };
    let (late_ppm, drop_ppm) = (chance("late"), chance("dropped"));
    let (call_ppm, lose_ppm) = (chance("failed-calls"), chance("lost"));
    let span = |key, inner| fields.inner(key).and_then(|fields| fields.duration(inner)).unwrap_or(Span::ZERO);
    let (late_by, lost_for) = (span("late", "by"), span("lost", "duration"));
    Disturbance { late_ppm, late_by, drop_ppm, call_ppm, lose_ppm, lost_for }
}

/// Reports what is wrong with the circuit as a whole at the places of its parts.
pub(super) fn circuit(bench: &Bench, wires: &[&Node], plants: &[&Node], out: &mut Findings) {
    for CircuitError { part, fault } in bench.file.circuit.check() {
        let name = |id: ChannelId| match bench.file.circuit.channels.get(usize::from(id.0)) {
            Some(channel) => format!("`{}`", channel.name),
            None => String::from("the channel"),
        };
        let span = match part {
            CircuitPart::Channel(at) => bench.place_of(at),
            CircuitPart::Wire(at) => wires.get(at).map_or(0..0, |node| place(node, fault)),
            CircuitPart::Plant(at) => plants.get(at).map_or(0..0, |node| place(node, fault)),
            CircuitPart::Switch { plant, switch } => {
                let list = plants.get(plant).and_then(|node| node.as_table()?.get("switches")?.as_array());
                list.and_then(|list| list.get(switch)).map_or(0..0, |node| place(node, fault))
            }
        };
        let (code, help) = match fault {
            CircuitFault::TooMany | CircuitFault::DuplicateName { .. } => (codes::TOO_MANY, String::new()),
            CircuitFault::BadSafeValue => (codes::SAFE_VALUE, String::new()),
            CircuitFault::NoChannel(_) => (codes::UNKNOWN_CHANNEL, String::new()),
            CircuitFault::NotDigital(id) if matches!(part, CircuitPart::Channel(_)) => {
                (codes::TALLY, format!("{} is not digital", name(id)))
            }
            CircuitFault::NotDigital(id) => (codes::PLANT_CHANNEL, format!("{} is analog", name(id))),
            CircuitFault::NotAnalog(id) => (codes::PLANT_CHANNEL, format!("{} is not analog", name(id))),
            CircuitFault::NotCount(id) => (codes::TALLY, format!("{} is no count", name(id))),
            CircuitFault::KindsDiffer => {
                (codes::KINDS_DIFFER, "join two digital or two analog channels, or use a plant".into())
            }
            CircuitFault::NotForAnalog => (codes::NOT_FOR_ANALOG, "remove it".into()),
            CircuitFault::TwoSources(id) => {
                (codes::TWO_SOURCES, format!("only one wire or plant can give {} its value", name(id)))
            }
            CircuitFault::BadTime => (codes::TIME, "write a duration above 0".into()),
            CircuitFault::BounceEdges => {
                (codes::BOUNCE, "after an even number of edges the line is where it belongs".into())
            }
            CircuitFault::BounceTime => (codes::BOUNCE, "make `over` longer, or take fewer edges".into()),
            CircuitFault::Loop => (
                codes::RING,
                "give one wire of the ring a `delay`, or put a plant with a time constant into it".into(),
            ),
            CircuitFault::NotFinite => (codes::UNREADABLE, String::new()),
            CircuitFault::NoHysteresis => (codes::HYSTERESIS, "make `off-below` less than `on-above`".into()),
        };
        out.error(code, span, fault.to_string(), help);
    }
}

/// The key of a part's table that a fault is about.
fn place(node: &Node, fault: CircuitFault) -> Range<usize> {
    let Some(table) = node.as_table() else { return node.span.clone() };
    let keys: &[&str] = match fault {
        CircuitFault::KindsDiffer => &["to"],
        CircuitFault::TwoSources(_) | CircuitFault::NotAnalog(_) => &["to", "output"],
        CircuitFault::Loop => &["to"],
        CircuitFault::NotForAnalog => &["invert", "bounce", "on-delay", "off-delay"],
        CircuitFault::BounceEdges | CircuitFault::BounceTime => &["bounce"],
        CircuitFault::NotDigital(_) => &["channel"],
        CircuitFault::NoHysteresis => &["off-below"],
        CircuitFault::BadTime => {
            let zero = |key: &&str| table.get(key).and_then(Node::as_text).is_some_and(is_zero);
            if zero(&"tau") { &["tau"] } else { &["sample"] }
        }
        _ => &[],
    };
    keys.iter().find_map(|key| table.get(key)).map_or_else(|| node.span.clone(), |node| node.span.clone())
}

fn is_zero(text: &str) -> bool {
    Span::parse(text) == Ok(Span::ZERO)
}
