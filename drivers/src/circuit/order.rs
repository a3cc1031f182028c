//! In which order the lines of a circuit follow each other.

use signal::Span;

use super::Circuit;
use super::TallySpec;
use crate::ChannelKind;

impl Circuit {
    /// Ranks of the channels: a wire without delay goes from a lower rank to a higher one. The error is a wire
    /// of a ring. Channels of all wires must exist.
    pub(crate) fn order(&self) -> Result<Vec<u16>, usize> {
        let wires =
            self.wires.iter().filter(|wire| wire.delay == Span::ZERO).map(|wire| (wire.from, wire.to));
        let signals = |tally: &TallySpec| {
            let to = tally.channel;
            tally.signals().map(move |from| (from, to))
        };
        let mut waiting = vec![0usize; self.channels.len()];
        let mut out: Vec<Vec<usize>> = vec![Vec::new(); self.channels.len()];
        for (from, to) in wires.chain(self.tallies.iter().flat_map(signals)) {
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
        let mut closing = 0;
        for _ in 0..=self.channels.len() {
            let back = self.wires.iter().position(|wire| {
                wire.delay == Span::ZERO
                    && usize::from(wire.to.0) == at
                    && ranks[usize::from(wire.from.0)] == u16::MAX
            });
            let Some(wire) = back else { break };
            closing = wire;
            at = usize::from(self.wires[wire].from.0);
        }
        Err(closing)
    }
}
