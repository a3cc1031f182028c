//! The real-time clock (controller:DEV-22): it goes on without power.

use profile::{CLOCK_AT_FIRST_POWER_ON, Profile};
use signal::Time;

const SECOND: i128 = 1_000_000_000;
const WEEK: i128 = 604_800;

/// What setting the drift answers: done.
pub const RTC_OK: i64 = 0;
/// What setting the drift answers: outside of the limits, and set to the nearer one.
pub const RTC_BAD_DRIFT: i64 = 4;

/// Below so many per cent the battery is low (rig definition: no document has the limit).
const LOW_BATTERY: u8 = 20;

/// The battery as its indicator shows it (plcsystem:PLCR-05).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Battery {
    /// It is good.
    Good,
    /// Its charge is low.
    Low,
    /// It is empty or absent.
    Empty,
}

/// The clock with its battery. It runs on its own quartz, and is corrected by what SetRTCDrift set.
#[derive(Clone, Copy, Debug)]
pub struct Rtc {
    /// Nanoseconds since 1970 at `since`.
    then: i128,
    since: Time,
    /// By so many seconds a week the quartz is fast, or slow below 0.
    drift: i64,
    /// By so many seconds a week it is made faster.
    correction: i64,
    /// Charge of the battery in per cent; 0 where it is empty or absent.
    charge: u8,
    /// The controller has its supply.
    is_supplied: bool,
    /// It had supply or battery all the time since it was set.
    is_kept: bool,
}

impl Default for Rtc {
    fn default() -> Self {
        Rtc::new(0)
    }
}

impl Rtc {
    /// A clock whose quartz is fast by so many seconds a week, or slow below 0, with a full battery.
    pub fn new(drift: i64) -> Rtc {
        Rtc {
            then: CLOCK_AT_FIRST_POWER_ON as i128 * SECOND,
            since: Time::ZERO,
            drift,
            correction: 0,
            charge: 100,
            is_supplied: false,
            is_kept: true,
        }
    }

    /// Nanoseconds since 1970-01-01 00:00 UTC.
    fn nanos(&self, now: Time) -> i128 {
        let passed = i128::from((now - self.since).as_nanos());
        self.then + passed + passed * i128::from(self.drift + self.correction) / WEEK
    }

    /// Seconds since 1970-01-01 00:00 UTC.
    pub fn seconds(&self, now: Time) -> i64 {
        (self.nanos(now) / SECOND) as i64
    }

    /// The same, up to 2106.
    pub(crate) fn date(&self, now: Time) -> u32 {
        u32::try_from(self.seconds(now)).unwrap_or(u32::MAX)
    }

    /// Corrects the clock by so many seconds a week from `now` on, in place of the correction before: [`RTC_OK`], or
    /// [`RTC_BAD_DRIFT`] where the limits of the profile were exceeded and the nearer one was taken.
    pub fn set_drift(&mut self, drift: i64, profile: Profile, now: Time) -> i64 {
        let (least, most) = profile.rtc_drift();
        (self.then, self.since) = (self.nanos(now), now);
        self.correction = drift.clamp(least, most);
        if (least..=most).contains(&drift) { RTC_OK } else { RTC_BAD_DRIFT }
    }

    /// Sets it to so many seconds since 1970-01-01 00:00 UTC (plcsystem:FUN-03).
    pub(crate) fn set(&mut self, seconds: i64, now: Time) {
        (self.then, self.since) = (i128::from(seconds) * SECOND, now);
    }

    /// The charge of the battery in per cent.
    pub(crate) fn charge(&self) -> u8 {
        self.charge
    }

    /// What the indicator of the battery shows of it.
    pub(crate) fn battery(&self) -> Battery {
        match self.charge {
            0 => Battery::Empty,
            charge if charge < LOW_BATTERY => Battery::Low,
            _ => Battery::Good,
        }
    }

    /// The battery has this charge from now on, in per cent: 0 where it is empty or taken out.
    pub(crate) fn set_charge(&mut self, charge: u8) {
        self.charge = charge.min(100);
        self.is_kept &= self.is_supplied || self.charge > 0;
    }

    /// The supply is gone: the battery keeps the clock, if it can.
    pub(crate) fn power_off(&mut self) {
        self.is_supplied = false;
        self.is_kept &= self.charge > 0;
    }

    /// The supply is there. Without supply and battery in between, time and correction are lost (io:HW-09, plcsystem:FUN-42): the
    /// clock begins as at its first power-on (rig definition).
    pub(crate) fn power_on(&mut self, now: Time) {
        if !self.is_kept {
            *self = Rtc { since: now, charge: self.charge, ..Rtc::new(self.drift) };
        }
        self.is_supplied = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::Span;

    // controller:DEV-22
    #[test]
    fn a_drift_makes_the_clock_faster_or_slower() {
        let week = Span::from_secs(604_800);
        for (drift, code, gains) in [(0, 0, 0), (73, 0, 73), (-36, 0, -36), (74, 4, 73), (-37, 4, -36)] {
            let mut rtc = Rtc::default();
            let start = Time::ZERO + Span::from_secs(10);
            assert_eq!(rtc.set_drift(drift, Profile::M251_2024, start), code, "{drift}");
            assert_eq!(rtc.seconds(start + week) - rtc.seconds(start), 604_800 + gains, "{drift}");
        }
        let mut rtc = Rtc::default();
        rtc.set_drift(70, Profile::M251_2024, Time::ZERO);
        // The next setting takes the place of the first, from then on.
        rtc.set_drift(0, Profile::M251_2024, Time::ZERO + week);
        assert_eq!(
            rtc.seconds(Time::ZERO + week + week),
            i64::from(CLOCK_AT_FIRST_POWER_ON) + 2 * 604_800 + 70
        );
        assert_eq!(rtc.set_drift(30, Profile::M241_2014, Time::ZERO), RTC_BAD_DRIFT);
    }

    // controller:HW-10, plcsystem:FUN-42
    #[test]
    fn a_correction_makes_up_for_the_drift_of_the_quartz() {
        let week = Span::from_secs(604_800);
        let mut rtc = Rtc::new(10);
        assert_eq!(rtc.seconds(Time::ZERO + week) - rtc.seconds(Time::ZERO), 604_810);
        rtc.set_drift(-10, Profile::M251_2024, Time::ZERO);
        assert_eq!(rtc.seconds(Time::ZERO + week) - rtc.seconds(Time::ZERO), 604_800);
    }

    // io:HW-09, plcsystem:FUN-42
    #[test]
    fn supply_or_battery_keeps_time_and_correction() {
        let at = |seconds| Time::ZERO + Span::from_secs(seconds);
        let first = i64::from(CLOCK_AT_FIRST_POWER_ON);
        // The charge while it is on, while it is off, and what is kept.
        for (on, off, kept) in
            [(100, 100, true), (1, 1, true), (0, 0, false), (0, 100, false), (100, 0, false)]
        {
            let mut rtc = Rtc::default();
            rtc.power_on(at(0));
            rtc.set_drift(70, Profile::M251_2024, at(0));
            rtc.set(1_000_000, at(10));
            rtc.set_charge(on);
            assert_eq!(rtc.seconds(at(20)), 1_000_010);
            rtc.power_off();
            rtc.set_charge(off);
            rtc.power_on(at(604_810));
            let (time, week) = if kept { (1_604_870, 604_870) } else { (first, 604_800) };
            let later = at(604_810 + 604_800);
            assert_eq!((rtc.seconds(at(604_810)), rtc.seconds(later) - time), (time, week), "{on} {off}");
        }
    }

    #[test]
    fn what_the_indicator_of_the_battery_shows() {
        for (charge, shown) in [
            (100, Battery::Good),
            (20, Battery::Good),
            (19, Battery::Low),
            (1, Battery::Low),
            (0, Battery::Empty),
        ] {
            let mut rtc = Rtc::default();
            rtc.set_charge(charge);
            assert_eq!((rtc.charge(), rtc.battery()), (charge, shown));
        }
    }
}
