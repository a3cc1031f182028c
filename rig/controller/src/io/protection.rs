//! Protection of the transistor outputs: groups that switch off on a fault, and how they come back (io:OUT-06...09).

use crate::config::Rearming;
use profile::{ChannelSet, PROTECTION_RETRY, PROTECTION_TEST, Reference};
use signal::Time;

/// What a group is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Driven; a fault is detected at once.
    Driven,
    /// Switched off, until this attempt to rearm where there will be one.
    Off { retry: Time },
    /// Driven as an attempt; whether the fault is still there shows at `until`. The next attempt comes at `retry`.
    Test { until: Time, retry: Time },
}

#[derive(Clone, Copy, Debug)]
struct Group {
    outputs: ChannelSet,
    phase: Phase,
    /// A fault is reported.
    reported: bool,
}

/// The protection of all outputs, with the faults that there are in the world around it.
///
/// A short circuit takes a current only while its output is on. An over-temperature needs none.
#[derive(Clone, Debug)]
pub(super) struct Protection {
    groups: [Group; 3],
    rearming: Rearming,
    /// Outputs with a short circuit at their terminals.
    shorted: ChannelSet,
    /// Outputs that are too hot.
    hot: ChannelSet,
    /// The supply of inputs and outputs is there.
    supplied: bool,
    /// Level of the rearming command at the last write.
    command: bool,
    /// Nothing is wrong and nothing was: nothing to be looked at.
    idle: bool,
    /// When something is due next.
    next: Time,
}

impl Protection {
    pub(super) fn new(reference: &Reference, rearming: Rearming) -> Protection {
        let group = |outputs| Group { outputs, phase: Phase::Driven, reported: false };
        Protection {
            groups: profile::protection_groups(reference).map(group),
            rearming,
            shorted: ChannelSet::EMPTY,
            hot: ChannelSet::EMPTY,
            supplied: true,
            command: false,
            idle: true,
            next: Time::MAX,
        }
    }

    /// Outputs in no group are not protected: nothing is seen of their short circuits.
    pub(super) fn short_circuit(&mut self, output: usize, on: bool) {
        self.shorted.set(output, on);
        self.idle = false;
    }

    pub(super) fn over_temperature(&mut self, output: usize, on: bool) {
        self.hot.set(output, on);
        self.idle = false;
    }

    pub(super) fn supply(&mut self, on: bool) {
        self.supplied = on;
        self.idle = false;
    }

    /// Whether the supply of inputs and outputs is there.
    pub(super) fn supplied(&self) -> bool {
        self.supplied
    }

    /// Every group is driven again and nothing is reported, as after a reset or a boot; faults stay in the world.
    pub(super) fn reset(&mut self) {
        for group in &mut self.groups {
            (group.phase, group.reported) = (Phase::Driven, false);
        }
        (self.command, self.idle, self.next) = (false, false, Time::MAX);
    }

    /// Whether a fault of any group is reported (io:STD-OUT-02).
    #[inline]
    pub(super) fn reported(&self) -> bool {
        !self.idle && self.groups.iter().any(|group| group.reported)
    }

    /// Outputs that protection switches off.
    pub(super) fn off(&self) -> ChannelSet {
        let off = |group: &&Group| matches!(group.phase, Phase::Off { .. });
        self.groups.iter().filter(off).fold(ChannelSet::EMPTY, |all, group| all | group.outputs)
    }

    /// When something is due; [`Time::MAX`] for nothing.
    #[inline]
    pub(super) fn next(&self) -> Time {
        self.next
    }

    /// Looks at all groups at `now`, with what the outputs are commanded and the level of the rearming command.
    #[inline]
    pub(super) fn update(&mut self, now: Time, on: ChannelSet, command: bool) {
        let before = std::mem::replace(&mut self.command, command);
        let rises = command && !before;
        if !self.idle {
            self.update_groups(now, on, rises);
        }
    }

    /// Looks at all groups at `now`, with no write of the outputs.
    pub(super) fn update_without_write(&mut self, now: Time, on: ChannelSet) {
        if !self.idle {
            self.update_groups(now, on, false);
        }
    }

    /// Whether nothing is wrong and nothing was at the last look.
    #[inline]
    pub(super) fn is_quiet(&self) -> bool {
        self.idle
    }

    fn update_groups(&mut self, now: Time, on: ChannelSet, rises: bool) {
        let (faults, automatic) = (self.faults(on), self.rearming == Rearming::Automatic);
        self.next = Time::MAX;
        let mut quiet = (self.shorted | self.hot).is_empty();
        for group in &mut self.groups {
            let fault = faults.intersects(group.outputs);
            group.phase = match group.phase {
                Phase::Off { .. } if rises && !automatic => {
                    group.reported = false;
                    Phase::Test { until: now.saturating_add(PROTECTION_TEST), retry: Time::MAX }
                }
                Phase::Off { retry } if retry <= now => Phase::Test {
                    until: retry.saturating_add(PROTECTION_TEST),
                    retry: retry.saturating_add(PROTECTION_RETRY),
                },
                Phase::Test { until, .. } if until <= now && !fault => {
                    group.reported = false;
                    Phase::Driven
                }
                Phase::Test { until, retry } if until <= now => {
                    group.reported = true;
                    Phase::Off { retry }
                }
                Phase::Driven if fault => {
                    group.reported = true;
                    let retry = if automatic { now.saturating_add(PROTECTION_RETRY) } else { Time::MAX };
                    Phase::Off { retry }
                }
                phase => phase,
            };
            let due = match group.phase {
                Phase::Driven => Time::MAX,
                Phase::Off { retry } => retry,
                Phase::Test { until, .. } => until,
            };
            self.next = self.next.min(due);
            quiet &= group.phase == Phase::Driven && !group.reported;
        }
        self.idle = quiet;
    }

    /// Outputs whose stages have a fault while they are commanded so.
    fn faults(&self, on: ChannelSet) -> ChannelSet {
        if self.supplied { self.hot | self.shorted & on } else { ChannelSet::EMPTY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::Span;

    fn protection(rearming: Rearming) -> Protection {
        Protection::new(Reference::find("TM241CEC24T").unwrap(), rearming)
    }

    const NONE: ChannelSet = ChannelSet::EMPTY;

    fn group(outputs: std::ops::Range<usize>) -> ChannelSet {
        outputs.collect()
    }

    fn ms(n: i64) -> Time {
        Time::ZERO + Span::from_millis(n)
    }

    // io:OUT-07, io:OUT-09
    #[test]
    fn automatic_attempts_come_every_second() {
        let mut it = protection(Rearming::Automatic);
        it.short_circuit(5, true);
        it.update(ms(5), NONE, false);
        assert_eq!((it.off(), it.reported()), (NONE, false), "no current, no fault");
        it.update(ms(10), ChannelSet::of(5), false);
        assert_eq!((it.off(), it.reported(), it.next()), (group(4..8), true, ms(1_010)));
        it.update(ms(1_010), ChannelSet::of(5), false);
        assert_eq!((it.off(), it.reported(), it.next()), (NONE, true, ms(1_011)));
        it.update(ms(1_011), ChannelSet::of(5), true);
        assert_eq!((it.off(), it.next()), (group(4..8), ms(2_010)), "the command does nothing");
        it.short_circuit(5, false);
        it.update(ms(2_010), ChannelSet::of(5), false);
        it.update(ms(2_011), ChannelSet::of(5), false);
        assert_eq!((it.off(), it.reported(), it.next()), (NONE, false, Time::MAX));
    }

    // io:OUT-08
    #[test]
    fn manual_waits_for_a_rising_edge() {
        let mut it = protection(Rearming::Manual);
        it.over_temperature(0, true);
        it.update(ms(10), NONE, true);
        assert_eq!((it.off(), it.reported(), it.next()), (group(0..4), true, Time::MAX));
        it.update(ms(5_000), NONE, true);
        assert_eq!(it.off(), group(0..4), "no edge");
        it.update(ms(5_100), NONE, false);
        it.update(ms(5_200), NONE, true);
        assert_eq!((it.off(), it.reported(), it.next()), (NONE, false, ms(5_201)));
        it.update(ms(5_201), NONE, true);
        assert_eq!((it.off(), it.reported(), it.next()), (group(0..4), true, Time::MAX));
    }

    #[test]
    fn without_supply_there_is_no_current() {
        let mut it = protection(Rearming::Automatic);
        it.supply(false);
        it.short_circuit(8, true);
        it.update(ms(0), ChannelSet::first(10), false);
        assert_eq!((it.off(), it.reported()), (NONE, false));
        it.supply(true);
        it.update(ms(1), ChannelSet::first(10), false);
        assert_eq!((it.off(), it.reported()), (group(8..10), true));
    }
}
