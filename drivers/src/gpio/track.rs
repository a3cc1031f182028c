//! Which edges of a claim were lost, from the kernel's numbers.
//!
//! The kernel numbers an edge twice: among all interrupts of the claim, and among the edges of its line that reached
//! the buffer. A gap in a line's numbers is edges that the full buffer lost. A gap in the claim's numbers that no line
//! explains is interrupts that came while the one before was still served, and became one edge with it. Edges of
//! different lines may come a little out of order, so that such a gap counts only when it stays.

use super::Edge;
use host::HostInstant;
use signal::Span;

/// Gaps that are open at once; the oldest counts as lost when there are more.
const MOST_GAPS: usize = 64;

/// Numbers of a claim that have not come yet.
#[derive(Clone, Copy, Debug)]
struct Gap {
    first: u32,
    count: u32,
    /// The line of the edge after it: the likeliest to have lost them.
    line: u8,
    /// When it showed.
    since: HostInstant,
}

/// Edges of one line that are lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lost {
    pub(super) line: u8,
    pub(super) count: u32,
}

/// Follows the numbers of one claim.
#[derive(Debug)]
pub(super) struct Tracker {
    /// The last number of each line.
    lines: [u32; 64],
    /// The highest number of the claim.
    high: u32,
    gaps: Vec<Gap>,
    /// Edges given up as lost, whose line was a guess.
    guessed: u32,
    /// How long a gap may stay open.
    patience: Span,
}

impl Tracker {
    pub(super) fn new(patience: Span) -> Tracker {
        Tracker { lines: [0; 64], high: 0, gaps: Vec::with_capacity(MOST_GAPS), guessed: 0, patience }
    }

    /// Takes note of an edge. What was lost before it, as far as it is certain; `older` gets a gap that had to
    /// be given up for want of room. `now` is asked only when a gap opens.
    pub(super) fn see(
        &mut self,
        edge: &Edge,
        now: impl Fn() -> HostInstant,
        mut older: impl FnMut(Lost),
    ) -> u32 {
        let Some((of_claim, of_line)) = edge.numbers else { return 0 };
        let step = of_claim.wrapping_sub(self.high) as i32;
        if step > 0 {
            let count = step as u32 - 1;
            if count > 0 {
                if self.gaps.len() == MOST_GAPS {
                    older(self.give_up(0));
                }
                let first = self.high.wrapping_add(1);
                self.gaps.push(Gap { first, count, line: edge.input, since: now() });
            }
            self.high = of_claim;
        } else {
            self.came(of_claim);
        }
        let last = &mut self.lines[usize::from(edge.input) % 64];
        let missed = of_line.wrapping_sub(*last).wrapping_sub(1);
        *last = of_line;
        // Numbers that go back are none that were missed.
        if (missed as i32) <= 0 { 0 } else { self.explain(edge.input, missed) }
    }

    /// Whether some numbers have not come yet.
    pub(super) fn open(&self) -> u32 {
        self.gaps.iter().map(|gap| gap.count).sum()
    }

    /// When the oldest gap counts as lost.
    pub(super) fn due(&self) -> Option<HostInstant> {
        self.gaps.first().map(|gap| gap.since + self.patience)
    }

    /// The next gap that was open for too long.
    pub(super) fn settle(&mut self, now: HostInstant) -> Option<Lost> {
        self.due().filter(|due| *due <= now).map(|_| self.give_up(0))
    }

    fn give_up(&mut self, at: usize) -> Lost {
        let gap = self.gaps.remove(at);
        self.guessed = self.guessed.saturating_add(gap.count);
        Lost { line: gap.line, count: gap.count }
    }

    /// A number came late.
    fn came(&mut self, number: u32) {
        let Some(at) = self.gaps.iter().position(|gap| number.wrapping_sub(gap.first) < gap.count) else {
            return;
        };
        let gap = self.gaps[at];
        let before = number.wrapping_sub(gap.first);
        let after = gap.count - before - 1;
        match (before, after) {
            (0, 0) => {
                self.gaps.remove(at);
            }
            (0, _) => self.gaps[at] = Gap { first: gap.first.wrapping_add(1), count: after, ..gap },
            (_, 0) => self.gaps[at].count = before,
            _ if self.gaps.len() < MOST_GAPS => {
                self.gaps[at].count = before;
                self.gaps.insert(at + 1, Gap { first: number.wrapping_add(1), count: after, ..gap });
            }
            // How many are missing is what matters.
            _ => self.gaps[at].count -= 1,
        }
    }

    /// A line lost so many to the full buffer: open gaps of the claim are these. How many were not given up before.
    fn explain(&mut self, line: u8, missed: u32) -> u32 {
        let mut left = missed;
        for own in [true, false] {
            let mut at = 0;
            while at < self.gaps.len() && left > 0 {
                if own && self.gaps[at].line != line {
                    at += 1;
                    continue;
                }
                let taken = self.gaps[at].count.min(left);
                left -= taken;
                self.gaps[at].count -= taken;
                self.gaps[at].first = self.gaps[at].first.wrapping_add(taken);
                if self.gaps[at].count == 0 {
                    self.gaps.remove(at);
                } else {
                    at += 1;
                }
            }
        }
        let guessed = self.guessed.min(left);
        self.guessed -= guessed;
        missed - guessed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Span = Span::from_nanos(10);

    fn at(nanos: i64) -> HostInstant {
        HostInstant::from_nanos(nanos)
    }

    /// Feeds (line, number in the claim, number in the line), all at time 0; then lets all gaps settle. What was lost, by
    /// line.
    fn lost(edges: &[(u8, u32, u32)]) -> Vec<(u8, u32)> {
        let mut tracker = Tracker::new(PATIENCE);
        let mut all: Vec<(u8, u32)> = Vec::new();
        for &(input, of_claim, of_line) in edges {
            let edge = Edge { input, high: true, stamp: at(0), numbers: Some((of_claim, of_line)) };
            let mut older = Vec::new();
            let lost = tracker.see(&edge, || at(0), |gap| older.push((gap.line, gap.count)));
            all.extend(older);
            if lost > 0 {
                all.push((input, lost));
            }
        }
        assert_eq!(tracker.settle(at(9)), None);
        while let Some(gap) = tracker.settle(at(10)) {
            all.push((gap.line, gap.count));
        }
        assert_eq!((tracker.open(), tracker.due()), (0, None));
        all
    }

    #[test]
    fn nothing_is_lost_where_every_number_comes_in_whatever_order() {
        assert_eq!(lost(&[(0, 1, 1), (1, 2, 1), (0, 3, 2)]), []);
        assert_eq!(lost(&[(0, 3, 1), (1, 2, 1), (0, 4, 2), (1, 1, 2)]), []);
        assert_eq!(lost(&[(0, 5, 1), (1, 2, 1), (2, 3, 1), (3, 1, 1), (4, 4, 1)]), []);
    }

    #[test]
    fn a_full_buffer_shows_in_the_numbers_of_the_line() {
        assert_eq!(lost(&[(0, 1, 1), (0, 5, 5)]), [(0, 3)]);
        // The other line's losses show with its next edge.
        assert_eq!(lost(&[(0, 6, 4), (1, 7, 4)]), [(0, 3), (1, 3)]);
    }

    #[test]
    fn interrupts_that_became_one_edge_show_in_the_numbers_of_the_claim_alone() {
        assert_eq!(lost(&[(0, 1, 1), (0, 4, 2)]), [(0, 2)]);
        // One of both kinds.
        assert_eq!(lost(&[(0, 1, 1), (0, 4, 3)]), [(0, 1), (0, 1)]);
    }

    #[test]
    fn what_was_given_up_is_not_counted_again() {
        let mut tracker = Tracker::new(PATIENCE);
        let edge = |input, of_claim, of_line| Edge {
            input,
            high: true,
            stamp: at(0),
            numbers: Some((of_claim, of_line)),
        };
        assert_eq!(tracker.see(&edge(0, 4, 1), || at(0), |_| panic!()), 0);
        assert_eq!(tracker.settle(at(10)), Some(Lost { line: 0, count: 3 }));
        assert_eq!(tracker.see(&edge(1, 5, 3), || at(11), |_| panic!()), 0);
        assert_eq!(tracker.see(&edge(1, 7, 5), || at(12), |_| panic!()), 1);
    }

    #[test]
    fn every_number_is_seen_or_lost_once_however_many_gaps_there_are_and_over_the_end_of_the_numbers() {
        let mut tracker = Tracker::new(PATIENCE);
        tracker.high = u32::MAX - 100;
        tracker.lines[3] = u32::MAX - 7;
        let (mut seen, mut gone) = (0u32, 0u32);
        for step in 1..=1000u32 {
            // Every third number never comes.
            if step % 3 == 0 {
                continue;
            }
            let of_claim = (u32::MAX - 100).wrapping_add(step);
            seen += 1;
            let numbers = Some((of_claim, (u32::MAX - 7).wrapping_add(seen)));
            let edge = Edge { input: 3, high: true, stamp: at(0), numbers };
            let mut older = 0;
            gone += tracker.see(&edge, || at(0), |gap| older += gap.count) + older;
        }
        while let Some(gap) = tracker.settle(at(10)) {
            gone += gap.count;
        }
        assert_eq!((seen, gone), (667, 333));
    }
}
