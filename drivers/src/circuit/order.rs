//! In which order the lines of a circuit follow each other.

use super::Circuit;
use super::{CircuitPart, TallySpec};
use crate::ChannelKind;
use crate::channel::ChannelId;

impl Circuit {
    /// Ranks of the channels: a wire without delay, and a plant that passes on changes at once, goes from a lower rank to a
    /// higher one. The error is a wire or plant of a ring. Channels of all wires and plants must exist.
    pub(crate) fn order(&self) -> Result<Vec<u16>, CircuitPart> {
        let wires = self.wires.iter().filter(|wire| wire.may_be_immediate()).map(|wire| (wire.from, wire.to));
        let signals = |tally: &TallySpec| {
            let to = tally.channel;
            tally.signals().map(move |from| (from, to))
        };
        let through: Vec<(usize, ChannelId, ChannelId)> = self
            .plants
            .iter()
            .enumerate()
            .filter(|(_, plant)| plant.passes_at_once())
            .flat_map(|(place, plant)| {
                let (inputs, outputs) = (plant.inputs(), plant.outputs());
                let pairs =
                    inputs.iter().flat_map(|from| outputs.iter().map(|to| (place, from.channel, to.channel)));
                pairs.collect::<Vec<_>>()
            })
            .collect();
        let mut waiting = vec![0usize; self.channels.len()];
        let mut out: Vec<Vec<usize>> = vec![Vec::new(); self.channels.len()];
        let plants = through.iter().map(|(_, from, to)| (*from, *to));
        for (from, to) in wires.chain(plants).chain(self.tallies.iter().flat_map(signals)) {
            waiting[usize::from(to.0)] += 1;
            out[usize::from(from.0)].push(usize::from(to.0));
        }
        let mut ready: Vec<usize> =
            (0..waiting.len()).rev().filter(|&channel| waiting[channel] == 0).collect();
        let mut ranks = vec![u16::MAX; self.channels.len()];
        let mut rank = 0;
        while let Some(channel) = ready.pop() {
            ranks[channel] = rank;
            rank += 1;
            for &next in &out[channel] {
                waiting[next] -= 1;
                if waiting[next] == 0 {
                    ready.push(next);
                }
            }
        }
        // What has no rank is part of a ring, or depends on one; going back from there along wires without rank ends in the ring.
        let counts = |channel: usize| self.channels[channel].kind == ChannelKind::Count;
        let Some(mut at) = (0..ranks.len()).find(|&channel| ranks[channel] == u16::MAX && !counts(channel))
        else {
            return Ok(ranks);
        };
        let mut closing = CircuitPart::Channel(at);
        for _ in 0..=self.channels.len() {
            let unranked = |channel: ChannelId| ranks[usize::from(channel.0)] == u16::MAX;
            let wire = self.wires.iter().position(|wire| {
                wire.may_be_immediate() && usize::from(wire.to.0) == at && unranked(wire.from)
            });
            let plant = through.iter().find(|(_, from, to)| usize::from(to.0) == at && unranked(*from));
            let back = wire
                .map(|wire| (CircuitPart::Wire(wire), self.wires[wire].from))
                .or_else(|| plant.map(|(plant, from, _)| (CircuitPart::Plant(*plant), *from)));
            let Some((part, from)) = back else { break };
            closing = part;
            at = usize::from(from.0);
        }
        Err(closing)
    }
}
