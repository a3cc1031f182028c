//! The real-time clock (controller:DEV-22): it goes on without power.

use profile::{CLOCK_AT_FIRST_POWER_ON, Profile};
use signal::Time;

const SECOND: i128 = 1_000_000_000;
const WEEK: i128 = 604_800;

/// What setting the drift answers: done.
pub const RTC_OK: i64 = 0;
/// What setting the drift answers: outside of the limits, and set to the nearer one.
pub const RTC_BAD_DRIFT: i64 = 4;

/// The clock, corrected by so many seconds a week. No battery of the model is ever empty.
#[derive(Clone, Copy, Debug)]
pub struct Rtc {
    /// Nanoseconds since 1970 at `since`.
    then: i128,
    since: Time,
    drift: i64,
}

impl Default for Rtc {
    fn default() -> Self {
        Rtc { then: CLOCK_AT_FIRST_POWER_ON as i128 * SECOND, since: Time::ZERO, drift: 0 }
    }
}

impl Rtc {
    /// Nanoseconds since 1970-01-01 00:00 UTC.
    fn nanos(&self, now: Time) -> i128 {
        let passed = i128::from((now - self.since).as_nanos());
        self.then + passed + passed * i128::from(self.drift) / WEEK
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
        *self = Rtc { then: self.nanos(now), since: now, drift: drift.clamp(least, most) };
        if (least..=most).contains(&drift) { RTC_OK } else { RTC_BAD_DRIFT }
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
}
