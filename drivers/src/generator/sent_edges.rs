//! The edges of a stream that was sent, reported a few at a time.

use std::sync::Arc;

use signal::{Span, Time, When};

use super::SentPulses;
use super::bits::{BitClock, BitLayout};
use crate::event_collector::EventCollector;
use crate::{ChannelId, Origin};

/// Edges that one poll reports at most.
pub(super) const AT_ONCE: usize = 256;

/// A stream whose edges are being reported.
#[derive(Debug)]
pub(super) struct SentStream {
    edges: Arc<[Span]>,
    next: usize,
    sent: SentPulses,
}

impl SentStream {
    pub(super) fn new(edges: Arc<[Span]>, sent: SentPulses) -> SentStream {
        SentStream { edges, next: 0, sent }
    }

    /// Whether all was reported.
    pub(super) fn is_over(&self) -> bool {
        self.next >= self.edges.len()
    }

    /// Reports the next edges, as many as that. Gives how many it reported.
    ///
    /// A bit cannot have come before those in front of it had their time since the call began, nor so late that those
    /// after it had not theirs until it ended: the clock is faster than it was set to by what it may be off at most.
    pub(super) fn report(
        &mut self,
        clock: BitClock,
        layout: BitLayout,
        channel: ChannelId,
        most: usize,
        collector: &mut EventCollector<'_>,
    ) -> usize {
        let last = self.edges.len().min(self.next.saturating_add(most));
        for place in self.next..last {
            let at = self.at(clock, layout, self.edges[place], collector);
            collector.changed(channel, at, place % 2 == 0, Origin::Write);
        }
        let reported = last - self.next;
        self.next = last;
        reported
    }

    fn at(&self, clock: BitClock, layout: BitLayout, edge: Span, collector: &EventCollector<'_>) -> When {
        let SentPulses { before, after, bits } = self.sent;
        let bit = layout.lead.saturating_add(clock.bit(edge));
        let earliest = before + clock.shortest(bit);
        // In some modes a bit begins half a period earlier against its clock than in others.
        let behind = bits.saturating_sub(bit.saturating_add(1));
        let latest = (after - clock.shortest(behind)).max(earliest);
        let at: [Time; 2] = [earliest, latest].map(|stamp| collector.time.at(stamp));
        When::within(at[0], at[1])
    }
}
