//! Protection of the transistor outputs: groups that switch off on a fault, and how they come back (io:OUT-06...09).

use crate::config::Rearming;
use profile::{PROTECTION_RETRY, PROTECTION_TEST, Reference};
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
    /// Its outputs, bit n for Qn.
    outputs: u32,
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
    shorted: u32,
    /// Outputs that are too hot.
    hot: u32,
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
            shorted: 0,
            hot: 0,
            supplied: true,
            command: false,
            idle: true,
            next: Time::MAX,
        }
    }

    /// Outputs in no group are not protected: nothing is seen of their short circuits.
    pub(super) fn short_circuit(&mut self, output: usize, on: bool) {
        set(&mut self.shorted, output, on);
        self.idle = false;
    }

    pub(super) fn over_temperature(&mut self, output: usize, on: bool) {
        set(&mut self.hot, output, on);
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
    pub(super) fn off(&self) -> u32 {
        let off = |group: &&Group| matches!(group.phase, Phase::Off { .. });
        self.groups.iter().filter(off).fold(0, |mask, group| mask | group.outputs)
    }

    /// When something is due; [`Time::MAX`] for nothing.
    #[inline]
    pub(super) fn next(&self) -> Time {
        self.next
    }

    /// Looks at all groups at `now`, with what the outputs are commanded and the level of the rearming command.
    #[inline]
    pub(super) fn update(&mut self, now: Time, on: u32, command: bool) {
        let before = std::mem::replace(&mut self.command, command);
        let rises = command && !before;
        if !self.idle {
            self.update_groups(now, on, rises);
        }
    }

    /// Looks at all groups at `now`, with no write of the outputs.
    pub(super) fn update_without_write(&mut self, now: Time, on: u32) {
        if !self.idle {
            self.update_groups(now, on, false);
        }
    }

    /// Whether nothing is wrong and nothing was at the last look.
    #[inline]
    pub(super) fn is_quiet(&self) -> bool {
        self.idle
    }

    fn update_groups(&mut self, now: Time, on: u32, rises: bool) {
        let (faults, automatic) = (self.faults(on), self.rearming == Rearming::Automatic);
        self.next = Time::MAX;
        let mut quiet = self.shorted | self.hot == 0;
        for group in &mut self.groups {
            let fault = faults & group.outputs != 0;
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
    fn faults(&self, on: u32) -> u32 {
        if self.supplied { self.hot | self.shorted & on } else { 0 }
    }
}

fn set(mask: &mut u32, output: usize, on: bool) {
    let bit = 1u32.checked_shl(output as u32).unwrap_or(0);
    *mask = if on { *mask | bit } else { *mask & !bit };
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::Span;

    fn protection(rearming: Rearming) -> Protection {
        Protection::new(Reference::find("TM241CEC24T").unwrap(), rearming)
    }

    fn ms(n: i64) -> Time {
        Time::ZERO + Span::from_millis(n)
    }

    // io:OUT-07, io:OUT-09
    #[test]
    fn automatic_attempts_come_every_second() {
        let mut it = protection(Rearming::Automatic);
        it.short_circuit(5, true);
        it.update(ms(5), 0, false);
        assert_eq!((it.off(), it.reported()), (0, false), "no current, no fault");
        it.update(ms(10), 1 << 5, false);
        assert_eq!((it.off(), it.reported(), it.next()), (0xF0, true, ms(1_010)));
        it.update(ms(1_010), 1 << 5, false);
        assert_eq!((it.off(), it.reported(), it.next()), (0, true, ms(1_011)));
        it.update(ms(1_011), 1 << 5, true);
        assert_eq!((it.off(), it.next()), (0xF0, ms(2_010)), "the command does nothing");
        it.short_circuit(5, false);
        it.update(ms(2_010), 1 << 5, false);
        it.update(ms(2_011), 1 << 5, false);
        assert_eq!((it.off(), it.reported(), it.next()), (0, false, Time::MAX));
    }

    // io:OUT-08
    #[test]
    fn manual_waits_for_a_rising_edge() {
        let mut it = protection(Rearming::Manual);
        it.over_temperature(0, true);
        it.update(ms(10), 0, true);
        assert_eq!((it.off(), it.reported(), it.next()), (0xF, true, Time::MAX));
        it.update(ms(5_000), 0, true);
        assert_eq!(it.off(), 0xF, "no edge");
        it.update(ms(5_100), 0, false);
        it.update(ms(5_200), 0, true);
        assert_eq!((it.off(), it.reported(), it.next()), (0, false, ms(5_201)));
        it.update(ms(5_201), 0, true);
        assert_eq!((it.off(), it.reported(), it.next()), (0xF, true, Time::MAX));
    }

    #[test]
    fn without_supply_there_is_no_current() {
        let mut it = protection(Rearming::Automatic);
        it.supply(false);
        it.short_circuit(8, true);
        it.update(ms(0), 0x3FF, false);
        assert_eq!((it.off(), it.reported()), (0, false));
        it.supply(true);
        it.update(ms(1), 0x3FF, false);
        assert_eq!((it.off(), it.reported()), (0x300, true));
    }
}
