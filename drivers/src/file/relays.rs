//! The relays of a board file that put faults on the wires of its channels.

use std::ops::Range;

use document::{Data, Entry, Fields, Findings, Node};
use signal::{Span, Value};

use super::bench::Bench;
use super::{codes, keys};
use crate::real::{FaultWay, SETTLE, WireRelays};
use crate::{ChannelId, ChannelKind};

/// The times that relays take: below is no relay, above no test.
const SETTLES: (Span, Span) = (Span::from_micros(10), Span::from_secs(10));

/// A relay that the file names.
#[derive(Clone, Debug)]
pub(super) struct Named {
    channel: ChannelId,
    place: Range<usize>,
}

/// The wires with relays, before anything is known of the lines behind them. The bench learns which channels are relays:
/// the rig drives them, although no terminal needs them.
pub(super) fn relays(fields: &Fields, bench: &mut Bench, out: &mut Findings) -> Vec<WireRelays> {
    let mut wires = Vec::new();
    let mut named: Vec<Named> = Vec::new();
    let table = fields.get("fault-relays").and_then(Node::as_table);
    let entries: Vec<(&Entry, Fields)> = table
        .map_or(&[][..], |table| &table.entries)
        .iter()
        .filter_map(|entry| Some((entry, Fields::checked(entry.node.as_table()?, keys::FAULT_RELAYS))))
        .collect();
    let channels: Vec<Option<ChannelId>> = entries.iter().map(|(entry, _)| key(entry, bench, out)).collect();
    for ((entry, fields), channel) in entries.iter().zip(&channels) {
        let Some(channel) = *channel else { continue };
        if wires.iter().any(|wire: &WireRelays| wire.channel == channel) {
            let message = format!("`{}` has its relays already", entry.key);
            out.error(codes::FAULTY_CHANNEL, entry.key_span.clone(), message, "join the two tables");
        }
        if fields_without_relay(fields) {
            let message = format!("`{}` has no relay", entry.key);
            let help = "name the channel of one, as in open = \"K1\"";
            out.error(codes::FAULTY_CHANNEL, entry.key_span.clone(), message, help);
        }
        let mut relays = [None; 3];
        for (relay, way) in relays.iter_mut().zip(FaultWay::ALL) {
            let Some(node) = fields.get(way.key()) else { continue };
            let Some(found) = bench.channel(node, out) else { continue };
            *relay = Some(found);
            named.push(Named { channel: found, place: node.span.clone() });
        }
        wires.push(WireRelays {
            channel,
            relays,
            settle: settle(fields, out),
            ground_is_one: fields.boolean("ground-is-one").unwrap_or(false),
            apart: apart(fields, channel, &channels, bench, out),
        });
    }
    // Who must keep apart from another is kept apart by it.
    for at in 0..wires.len() {
        for other in wires[at].apart.clone() {
            if let Some(other) = wires.get_mut(other).filter(|other| !other.apart.contains(&at)) {
                other.apart.push(at);
            }
        }
    }
    suits(&wires, &named, bench, out);
    for relay in &named {
        // The rig has to see when a relay was driven.
        bench.file.circuit.channels[usize::from(relay.channel.0)].senses = true;
    }
    bench.relays = named.into_iter().map(|relay| relay.channel).collect();
    wires
}

/// The channel that a key of the table names.
fn key(entry: &Entry, bench: &Bench, out: &mut Findings) -> Option<ChannelId> {
    bench.channel(&Node::new(entry.key_span.clone(), Data::Text(entry.key.clone())), out)
}

fn fields_without_relay(fields: &Fields) -> bool {
    FaultWay::ALL.iter().all(|way| !fields.has(way.key()))
}

fn settle(fields: &Fields, out: &mut Findings) -> Span {
    let settle = fields.duration("settle").unwrap_or(SETTLE);
    if let Some(node) = fields.get("settle").filter(|_| !(SETTLES.0..=SETTLES.1).contains(&settle)) {
        let help = format!("it is from {} to {}", SETTLES.0, SETTLES.1);
        out.bad(codes::RELAY_TIME, node, format!("no relay settles in {settle}"), help);
    }
    settle
}

/// Places of the wires that must have no fault at the same time.
fn apart(
    fields: &Fields,
    own: ChannelId,
    wires: &[Option<ChannelId>],
    bench: &Bench,
    out: &mut Findings,
) -> Vec<usize> {
    let mut apart = Vec::new();
    for node in fields.each("apart-from") {
        let Some(channel) = bench.channel(node, out) else { continue };
        match wires.iter().flatten().position(|other| *other == channel) {
            Some(at) if channel != own => apart.push(at),
            _ => {
                let name = &bench.file.circuit.channels[usize::from(channel.0)].name;
                let message = format!("`{name}` is no other channel with fault relays");
                out.bad(codes::FAULTY_CHANNEL, node, message, "name another channel of `fault-relays`");
            }
        }
    }
    apart
}

/// Reports relays that are no outputs of their own, and wires that are those of relays.
fn suits(wires: &[WireRelays], named: &[Named], bench: &Bench, out: &mut Findings) {
    let lines = [bench.file.lines.power, bench.file.lines.run_stop, bench.file.lines.alarm];
    for (at, relay) in named.iter().enumerate() {
        let channel = &bench.file.circuit.channels[usize::from(relay.channel.0)];
        let name = &channel.name;
        let bound = bench.file.bind.iter().find(|binding| binding.channel == relay.channel);
        let message = if channel.kind != ChannelKind::Digital {
            format!("`{name}` is analog, and a relay is on or off")
        } else if let Some(bound) = bound {
            format!("`{name}` is bound to {}", bound.address)
        } else if lines.contains(&Some(relay.channel)) {
            format!("`{name}` is a line of the subject")
        } else if wires.iter().any(|wire| wire.channel == relay.channel) {
            format!("`{name}` is a relay, and cannot have relays itself")
        } else if named[..at].iter().any(|other| other.channel == relay.channel) {
            format!("`{name}` is named twice: a relay has one wire")
        } else if channel.safe == Value::Bool(true) {
            format!("`{name}` would put the fault on when everything is made safe")
        } else if !channel.drives {
            format!("`{name}` is not driven")
        } else {
            continue;
        };
        let help = "give the relay a digital channel of its own that is driven, with 1 for the fault and `safe = false`";
        out.error(codes::FAULT_RELAY, relay.place.clone(), message, help);
    }
}
