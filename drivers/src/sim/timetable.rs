//! When each part of a board next does something by itself.

use signal::Time;

/// The instants at which parts are due, and how many changes are on their way through each: the earliest is found at once, and the
/// parts that are due without a look at the others.
#[derive(Clone, Debug)]
pub(super) struct Timetable {
    /// A heap of the earliest instants: that of place n is the earlier one of those of places 2n and 2n + 1, and the parts begin
    /// at `parts`. A part that is never due has [`Time::MAX`].
    earliest: Vec<Time>,
    parts: usize,
    waiting: Vec<usize>,
    all_waiting: usize,
}

impl Timetable {
    /// Of so many parts, of which none is due.
    pub(super) fn new(parts: usize) -> Timetable {
        let room = parts.next_power_of_two();
        Timetable {
            earliest: vec![Time::MAX; 2 * room],
            parts: room,
            waiting: vec![0; parts],
            all_waiting: 0,
        }
    }

    /// The part of this place is due then, with so many changes on their way through it.
    pub(super) fn set(&mut self, part: usize, due: Option<Time>, waiting: usize) {
        self.all_waiting = self.all_waiting - self.waiting[part] + waiting;
        self.waiting[part] = waiting;
        let mut place = self.parts + part;
        let mut due = due.unwrap_or(Time::MAX);
        while place > 0 && self.earliest[place] != due {
            self.earliest[place] = due;
            due = due.min(self.earliest[place ^ 1]);
            place /= 2;
        }
    }

    /// When the first is due; [`Time::MAX`] for never.
    pub(super) fn first(&self) -> Time {
        self.earliest[1]
    }

    /// The first part from this place on that is due at `now`.
    pub(super) fn due_from(&self, part: usize, now: Time) -> Option<usize> {
        if part >= self.parts {
            return None;
        }
        let mut place = self.parts + part;
        // Up to where something after the part is due, and then down to the first of that.
        while self.earliest[place] > now {
            while place % 2 == 1 {
                place /= 2;
            }
            if place == 0 {
                return None;
            }
            place += 1;
        }
        while place < self.parts {
            place *= 2;
            place += usize::from(self.earliest[place] > now);
        }
        Some(place - self.parts)
    }

    /// How many changes are on their way.
    pub(super) fn waiting(&self) -> usize {
        self.all_waiting
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against a look at every part.
        #[test]
        fn it_finds_what_a_look_at_every_part_finds(
            parts in 1usize..40,
            changes in proptest::collection::vec((0usize..40, proptest::option::of(0i64..20), 0usize..4), 1..60),
        ) {
            let mut table = Timetable::new(parts);
            let mut known = vec![(Time::MAX, 0); parts];
            for (part, due, waiting) in changes {
                let (part, due) = (part % parts, due.map(Time::from_nanos));
                table.set(part, due, waiting);
                known[part] = (due.unwrap_or(Time::MAX), waiting);
                prop_assert_eq!(table.first(), known.iter().map(|(due, _)| *due).min().unwrap());
                prop_assert_eq!(table.waiting(), known.iter().map(|(_, waiting)| waiting).sum::<usize>());
                for now in (-1..21).map(Time::from_nanos) {
                    for from in 0..=parts {
                        let looked = (from..parts).find(|part| known[*part].0 <= now);
                        prop_assert_eq!(table.due_from(from, now), looked);
                    }
                }
            }
        }
    }
}
