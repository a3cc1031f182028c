//! Edges as the bits of a stream: what a line has to be sent, bit by bit, so that its edges come at given times.

use signal::{ClockError, Span};

const SECOND: i128 = 1_000_000_000;

/// The clock of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitClock {
    hz: u32,
    error: ClockError,
}

impl BitClock {
    /// So many bits a second, at least one.
    pub fn new(hz: u32) -> BitClock {
        BitClock { hz: hz.max(1), error: ClockError::NONE }
    }

    /// The same, and its rate may be off.
    #[must_use]
    pub fn off_by(self, error: ClockError) -> BitClock {
        BitClock { error, ..self }
    }

    /// Bits a second.
    pub fn hz(self) -> u32 {
        self.hz
    }

    /// How many bits lie before the one that begins closest to this time, from 0 on; of two that are as close the later one.
    pub fn bit(self, at: Span) -> u64 {
        let twice = i128::from(at.as_nanos().max(0)) * i128::from(self.hz) * 2 + SECOND;
        u64::try_from(twice / (2 * SECOND)).unwrap_or(u64::MAX)
    }

    /// How long so many bits last, not rounded up.
    pub fn lasts(self, bits: u64) -> Span {
        span(i128::from(bits) * SECOND / i128::from(self.hz))
    }

    /// How long so many bits last at the shortest, by what the rate may be off.
    pub fn shortest(self, bits: u64) -> Span {
        let lasts = self.lasts(bits);
        lasts - self.error.of(lasts)
    }

    /// How long so many bits last, rounded up.
    pub fn lasts_at_least(self, bits: u64) -> Span {
        let (hz, whole) = (i128::from(self.hz), i128::from(bits) * SECOND);
        span((whole + hz - 1) / hz)
    }

    /// The shortest time, in whole nanoseconds, that is no less than a bit: edges so far apart are never one.
    pub fn period(self) -> Span {
        self.lasts_at_least(1)
    }
}

/// So many nanoseconds.
fn span(nanos: i128) -> Span {
    i64::try_from(nanos).map_or(Span::MAX, Span::from_nanos)
}

/// How bits lie in bytes and what they mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitLayout {
    /// The first bit of a byte on the wire is its lowest, not its highest.
    pub lsb_first: bool,
    /// A bit of 0 is a high level of the channel.
    pub inverted: bool,
    /// Bits at rest before time 0.
    pub lead: u64,
}

impl BitLayout {
    /// Bytes for edges of which the last comes at this bit: the line is at rest in the last bit of all.
    pub fn bytes(self, last: u64) -> u64 {
        self.lead.saturating_add(last) / 8 + 1
    }

    /// The greatest bit at which an edge can come in so many bytes.
    pub fn last(self, bytes: u64) -> u64 {
        (bytes * 8).saturating_sub(self.lead + 1)
    }

    /// Writes levels into the bytes of a stream: low before the first edge, high after it, and so on; after an even
    /// number of edges low up to the end of the last byte. Gives the number of bytes, of which there is at least one.
    /// `None`: the bytes are too few, or two edges fall into one bit, or are out of order or odd in number.
    pub fn write(self, clock: BitClock, edges: &[Span], bytes: &mut [u8]) -> Option<usize> {
        let last = edges.last().map_or(0, |edge| clock.bit(*edge));
        let used = usize::try_from(self.bytes(last)).ok().filter(|used| *used <= bytes.len())?;
        let bytes = &mut bytes[..used];
        bytes.fill(if self.inverted { 0xff } else { 0 });
        let mut free = 0;
        let mut pairs = edges.chunks_exact(2);
        for pair in &mut pairs {
            let (up, down) = (clock.bit(pair[0]), clock.bit(pair[1]));
            if up < free || down <= up || down > last {
                return None;
            }
            free = down + 1;
            self.flip(bytes, self.lead + up, self.lead + down);
        }
        pairs.remainder().is_empty().then_some(used)
    }

    /// Turns the bits from one to before another.
    fn flip(self, bytes: &mut [u8], from: u64, to: u64) {
        let (first, last) = ((from / 8) as usize, (to / 8) as usize);
        let (head, tail) = (self.mask(from % 8, 8), self.mask(0, to % 8));
        if first == last {
            bytes[first] ^= head & tail;
            return;
        }
        bytes[first] ^= head;
        bytes[first + 1..last].iter_mut().for_each(|byte| *byte ^= 0xff);
        // A stretch that ends with a byte has nothing in the next one, which need not be there.
        if tail != 0 {
            bytes[last] ^= tail;
        }
    }

    /// The bits of a byte from one on the wire to before another.
    fn mask(self, from: u64, to: u64) -> u8 {
        if self.lsb_first {
            (0xff_u16 << from) as u8 & !((0xff_u16 << to) as u8)
        } else {
            (0xff_u16 >> from) as u8 & !((0xff_u16 >> to) as u8)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The level in each bit, looked up edge by edge.
    fn naive(layout: BitLayout, clock: BitClock, edges: &[Span], bits: u64) -> Vec<bool> {
        let level = |bit: u64| {
            let before = |edge: &&Span| layout.lead + clock.bit(**edge) <= bit;
            edges.iter().filter(before).count() % 2 == 1
        };
        (0..bits).map(level).collect()
    }

    /// The bits on the wire.
    fn sent(layout: BitLayout, bytes: &[u8]) -> Vec<bool> {
        let bit = |byte: u8, place: u32| match layout.lsb_first {
            true => byte >> place & 1 == 1,
            false => byte << place & 0x80 != 0,
        };
        bytes.iter().flat_map(|byte| (0..8).map(move |place| bit(*byte, place) != layout.inverted)).collect()
    }

    proptest! {
        #[test]
        fn every_edge_is_at_the_bit_that_is_closest_to_it_and_none_is_lost(
            hz in 1_u32..=50_000_000,
            lsb_first: bool,
            inverted: bool,
            lead in 0_u64..20,
            first in 0_u64..40,
            widths in prop::collection::vec(0_u32..3_000, 0..60),
        ) {
            let clock = BitClock::new(hz);
            let layout = BitLayout { lsb_first, inverted, lead };
            let mut at = clock.lasts(first);
            let mut edges = vec![at];
            for width in &widths {
                // From a bit on, by thousandths of one.
                let more = clock.lasts(u64::from(*width)).as_nanos() / 1_000;
                at = at + clock.period() + Span::from_nanos(more);
                edges.push(at);
            }
            edges.truncate(edges.len() / 2 * 2);
            let mut bytes = vec![0xaa; 256];
            let used = layout.write(clock, &edges, &mut bytes).expect("edges a bit apart are never one");
            prop_assert!(bytes[used..].iter().all(|byte| *byte == 0xaa), "what is behind it is left alone");
            let bits = sent(layout, &bytes[..used]);
            prop_assert_eq!(&bits, &naive(layout, clock, &edges, used as u64 * 8));
            prop_assert!(!bits[bits.len() - 1], "it ends at rest");
            let turns = bits.windows(2).filter(|pair| pair[0] != pair[1]).count();
            prop_assert_eq!(turns + usize::from(bits[0]), edges.len());
            for edge in &edges {
                let bit = clock.bit(*edge);
                let off = i128::from(edge.as_nanos()) * i128::from(hz) - i128::from(bit) * SECOND;
                prop_assert!(2 * off.abs() <= SECOND, "edge at {edge} in bit {bit}");
            }
        }

        #[test]
        fn any_times_are_written_or_refused(
            hz: u32,
            lsb_first: bool,
            lead in 0_u64..20,
            edges in prop::collection::vec(any::<i64>(), 0..20),
            room in 0_usize..40,
        ) {
            let edges: Vec<Span> = edges.into_iter().map(Span::from_nanos).collect();
            let layout = BitLayout { lsb_first, inverted: false, lead };
            let mut bytes = vec![0; room];
            if let Some(used) = layout.write(BitClock::new(hz), &edges, &mut bytes) {
                prop_assert!(used <= room && edges.len().is_multiple_of(2));
            }
        }
    }

    #[test]
    fn what_does_not_fit_or_would_merge_is_refused() {
        let (clock, layout) =
            (BitClock::new(1_000_000), BitLayout { lsb_first: false, inverted: false, lead: 8 });
        let us = |list: &[i64]| list.iter().map(|at| Span::from_micros(*at)).collect::<Vec<_>>();
        let mut bytes = [0; 3];
        assert_eq!(layout.write(clock, &us(&[0, 3]), &mut bytes), Some(2));
        assert_eq!(bytes[..2], [0, 0b1110_0000]);
        assert_eq!(layout.last(3), 15);
        assert_eq!(layout.write(clock, &us(&[0, 15]), &mut bytes), Some(3));
        assert_eq!(layout.write(clock, &us(&[0, 16]), &mut bytes), None, "it would not end at rest");
        assert_eq!(layout.write(clock, &us(&[2, 4, 4, 6]), &mut bytes), None);
        assert_eq!(layout.write(clock, &us(&[4, 2]), &mut bytes), None);
        assert_eq!(layout.write(clock, &us(&[4]), &mut bytes), None);
        assert_eq!(layout.write(clock, &[], &mut bytes), Some(2));
        assert_eq!(
            (BitClock::new(3_000_000).period(), clock.period()),
            (Span::from_nanos(334), Span::from_micros(1))
        );
    }

    #[test]
    fn a_clock_that_may_be_fast_may_take_less_for_its_bits() {
        let clock = BitClock::new(1_000_000);
        let fast = clock.off_by(ClockError::from_parts(100_000_000).unwrap());
        assert_eq!(clock.shortest(20_000), Span::from_millis(20));
        // 100 ppm of 20 ms: 2 us, and a little more for a clock that is fast by as much.
        assert_eq!(fast.shortest(20_000), Span::from_nanos(20_000_000 - 2_001));
        assert_eq!(fast.lasts(20_000), clock.lasts(20_000));
    }
}
