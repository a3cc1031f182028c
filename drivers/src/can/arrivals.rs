//! Datagrams of one look, in the order in which they came from the bus.
//!
//! On several processors the kernel can hand frames over in another order: each processor has a queue of its own for what
//! its interrupts bring. Its stamps give the order.

use host::ReceivedDatagram;

use super::wire::FD;

/// The most frames of one turn, either way: then the other way has its turn.
pub(super) const BATCH: usize = 256;

/// How far stamps may go back, in nanoseconds, for the order to be at fault. Further, somebody has set the clock.
const ASTRAY: i64 = 10_000_000;

/// A datagram and what the kernel says of it.
pub(super) type Arrival = ([u8; FD], ReceivedDatagram);

/// What came. Takes no memory beyond that of its beginning.
#[derive(Debug)]
pub(super) struct Arrivals(Vec<Arrival>);

impl Arrivals {
    pub(super) fn new() -> Arrivals {
        Arrivals(Vec::with_capacity(BATCH))
    }

    /// Adds one after all that were stamped before it, as it seems.
    pub(super) fn put(&mut self, arrival: Arrival) {
        self.0.push(arrival);
        for at in (1..self.0.len()).rev() {
            let (before, after) = self.0.split_at_mut(at);
            let (Some((_, before)), Some((_, after))) = (before.last_mut(), after.first_mut()) else {
                return;
            };
            let back = before.wall.zip(after.wall).map_or(0, |(before, after)| before.saturating_sub(after));
            if back <= 0 || back > ASTRAY {
                return;
            }
            // How many were lost until then goes with the place, not with the datagram.
            std::mem::swap(&mut before.dropped, &mut after.dropped);
            self.0.swap(at - 1, at);
        }
    }

    /// The one at this place.
    pub(super) fn get(&self, at: usize) -> Option<Arrival> {
        self.0.get(at).copied()
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn order(walls: &[Option<i64>]) -> (Vec<u8>, Vec<u32>) {
        let mut arrivals = Arrivals::new();
        for (n, wall) in (0..).zip(walls) {
            let received =
                ReceivedDatagram { wall: *wall, dropped: u32::from(n), ..ReceivedDatagram::default() };
            arrivals.put(([n; FD], received));
        }
        let all: Vec<Arrival> = (0..).map_while(|at| arrivals.get(at)).collect();
        let numbers = all.iter().map(|(bytes, _)| bytes[0]).collect();
        (numbers, all.iter().map(|(_, received)| received.dropped).collect())
    }

    #[test]
    fn stamps_tell_the_order_and_losses_only_grow() {
        let (numbers, dropped) =
            order(&[Some(5 * MS), Some(7 * MS), Some(6 * MS), Some(7 * MS), Some(4 * MS)]);
        assert_eq!((numbers, dropped), (vec![4, 0, 2, 1, 3], vec![0, 1, 2, 3, 4]));
    }

    #[test]
    fn a_clock_that_was_set_and_a_frame_without_a_stamp_change_no_order() {
        let hour = 3_600_000 * MS;
        assert_eq!(order(&[Some(hour), Some(0), Some(MS)]).0, [0, 1, 2]);
        assert_eq!(order(&[Some(2 * MS), None, Some(MS)]).0, [0, 1, 2]);
    }
}
