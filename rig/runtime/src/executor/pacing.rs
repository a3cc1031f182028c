//! How modelled time follows the clock.

use drivers::{Bus, Channel, TimestampSource};
use signal::{Span, Time};

/// The two ways in which time passes for a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pacing {
    /// From event to event. The board's lines are modelled: they live in the controller's time, and a rig that is late only
    /// knows less exactly when things happened.
    EventDriven,
    /// With the clock. Wires have its time: it passes whether the executor is ready or not.
    WallClock,
}

impl Pacing {
    /// That of a board with these channels and buses, of which it may have buses alone. One that the guard watches has wires,
    /// also where no line of it is used: the guard waits for signs of life by the clock.
    pub(super) fn of(channels: &[Channel], buses: &[Bus], guarded: bool) -> Pacing {
        let virtual_time = |source: TimestampSource| source == TimestampSource::Virtual;
        let modelled = channels.iter().all(|channel| virtual_time(channel.timestamp))
            && buses.iter().all(|bus| virtual_time(bus.timestamp));
        if modelled && !guarded { Pacing::EventDriven } else { Pacing::WallClock }
    }

    /// Whether there are wires, which take their time and move by themselves.
    pub(super) const fn has_wires(self) -> bool {
        matches!(self, Pacing::WallClock)
    }

    /// The board's time of a rig that has come to `now` in modelled time, and to `actual` on its clock.
    #[inline]
    pub(super) const fn board_time(self, now: Time, actual: Time) -> Time {
        match self {
            Pacing::EventDriven => now,
            Pacing::WallClock => actual,
        }
    }

    /// How far the application may run ahead of the clock, of what it may at most: 0 where that changes nothing.
    pub(super) const fn horizon(self, most: Span) -> Span {
        match self {
            Pacing::EventDriven => Span::ZERO,
            Pacing::WallClock => most,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_without_lines_has_the_time_of_whoever_watches_it() {
        assert_eq!(Pacing::of(&[], &[], false), Pacing::EventDriven);
        assert_eq!(Pacing::of(&[], &[], true), Pacing::WallClock);
    }
}
