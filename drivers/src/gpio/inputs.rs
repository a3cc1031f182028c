//! The inputs of a chip as their edges report them.

use host::HostInstant;
use signal::{Span, Time, When};

use super::edges::Note;
use super::port::LineLevels;
use crate::event_collector::EventCollector;
use crate::{ChannelId, Origin};

/// One input line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Input {
    pub(super) channel: ChannelId,
    /// How long before its stamp an edge may have happened.
    pub(super) resolution: Span,
    /// Whether anybody wants to see it.
    pub(super) senses: bool,
    /// The output of the same channel, which this line reads back.
    pub(super) output: Option<u8>,
}

/// An input and what is known of it.
#[derive(Clone, Copy, Debug)]
struct Known {
    line: Input,
    /// Its last event.
    last: Time,
    /// Until when an edge may come whose level a reading has found.
    found: HostInstant,
}

/// The inputs of a chip. Bits are places in its claim.
#[derive(Debug)]
pub(super) struct Inputs {
    lines: Vec<Known>,
    levels: u64,
    /// Inputs without an edge since the start.
    fresh: u64,
    /// Inputs whose level was found by reading.
    strayed: u64,
    /// When the start began to read, and until when an edge may come whose level it read.
    began: HostInstant,
    surveyed: HostInstant,
}

impl Inputs {
    pub(super) fn new(lines: Vec<Input>) -> Inputs {
        let lines = lines
            .into_iter()
            .map(|line| Known { line, last: Time::ZERO, found: HostInstant::BOOT })
            .collect();
        Inputs {
            lines,
            levels: 0,
            fresh: 0,
            strayed: 0,
            began: HostInstant::BOOT,
            surveyed: HostInstant::BOOT,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.lines.len()
    }

    /// The channel of each.
    pub(super) fn channels(&self) -> impl Iterator<Item = ChannelId> + '_ {
        self.lines.iter().map(|known| known.line.channel)
    }

    /// A run begins with these levels, read from `began` on; edges up to `surveyed` may report what was read.
    pub(super) fn start(&mut self, levels: LineLevels, began: HostInstant, surveyed: HostInstant) {
        (self.levels, self.fresh, self.strayed) = (levels.bits, levels.known, 0);
        (self.began, self.surveyed) = (began, surveyed);
    }

    /// The levels as they are.
    pub(super) fn present(&self, at: When, collector: &mut EventCollector<'_>) {
        for (place, Known { line, .. }) in
            self.lines.iter().enumerate().filter(|(_, known)| known.line.senses)
        {
            collector.changed(line.channel, at, self.levels >> place & 1 == 1, Origin::Outside);
        }
    }

    /// An edge, or the loss of some. `wanted` is what the outputs were asked to be.
    pub(super) fn edge(&mut self, note: &Note, wanted: u64, collector: &mut EventCollector<'_>) {
        let place = usize::from(note.input);
        let (Some(known), true) = (self.lines.get_mut(place), note.stamp >= self.began) else { return };
        let line = &known.line;
        let at = collector.time.at(note.stamp);
        collector.dropped(line.channel, at, note.lost);
        let Some(high) = note.high else { return };
        let bit = 1u64 << note.input;
        let (fresh, strayed) = (self.fresh & bit != 0, self.strayed & bit != 0);
        self.fresh &= !bit;
        self.strayed &= !bit;
        if (self.levels & bit != 0) == high {
            // A reading may have found the level already whose edge comes now. At any other time an edge to the level
            // that the line has is one whose direction the kernel was too late to see.
            let read = fresh && note.stamp <= self.surveyed || strayed && note.stamp <= known.found;
            if !read {
                collector.dropped(line.channel, at, 1);
            }
            return;
        }
        self.levels ^= bit;
        known.last = at;
        if line.senses {
            // The rig itself made it change, where the channel drives another line to this level.
            let own = line.output.is_some_and(|output| (wanted >> output & 1 == 1) == high);
            let origin = if own { Origin::Write } else { Origin::Outside };
            let at = When::within(at.saturating_add(-line.resolution), at);
            collector.changed(line.channel, at, high, origin);
        }
    }

    /// An input has had this level for a while, and no edge reported it.
    pub(super) fn stray(
        &mut self,
        input: u8,
        high: bool,
        stamp: HostInstant,
        collector: &mut EventCollector<'_>,
    ) {
        let (place, bit) = (usize::from(input), 1u64 << input);
        let Some(known) = self.lines.get_mut(place).filter(|_| (self.levels & bit != 0) != high) else {
            return;
        };
        let line = known.line;
        let at = collector.time.at(stamp);
        collector.dropped(line.channel, at, 1);
        self.levels ^= bit;
        self.strayed |= bit;
        let before = std::mem::replace(known, Known { line, last: at, found: stamp });
        if line.senses {
            collector.changed(line.channel, When::within(before.last.min(at), at), high, Origin::Outside);
        }
    }
}
