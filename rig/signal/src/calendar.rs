//! Days and instants of the Gregorian calendar in UTC, as reports, certificates and lock files write them.
//!
//! It is arithmetic alone: nothing in here knows which day it is.

use std::fmt;

/// Seconds of a day: UTC as the host counts it has no leap seconds.
const DAY: i64 = 86_400;

/// A day of the Gregorian calendar, from 0000-01-01 to 9999-12-31; the order is that of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Date {
    year: u16,
    month: u8,
    day: u8,
}

impl Date {
    /// The last day that is written with four digits of the year.
    pub const LAST: Date = Date { year: 9_999, month: 12, day: 31 };

    /// Reads `2026-01-31`. `None` for anything else, and for days that do not exist.
    pub fn parse(text: &str) -> Option<Date> {
        let mut parts = text.split('-');
        let mut part = |digits: usize| -> Option<u16> {
            let text = parts.next().filter(|text| text.len() == digits)?;
            text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
        };
        let (year, month, day) = (part(4)?, part(2)? as u8, part(2)? as u8);
        let date = Date { year, month, day };
        (parts.next().is_none() && (1..=12).contains(&month) && (1..=date.days_of_month()).contains(&day))
            .then_some(date)
    }

    /// The day so many days after 1970-01-01, or before it; `None` outside of the years 0 to 9999.
    pub fn from_days(days: i64) -> Option<Date> {
        // Counted from 1 March of year 0, so that the leap day is the last day of its year.
        let day = days.checked_add(719_468)?;
        let (era, of_era) = (day.div_euclid(146_097), day.rem_euclid(146_097));
        let year_of_era = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
        let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let from_march = (5 * of_year + 2) / 153;
        let day = of_year - (153 * from_march + 2) / 5 + 1;
        let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
        let year = era * 400 + year_of_era + i64::from(month <= 2);
        let year = u16::try_from(year).ok().filter(|year| *year <= 9_999)?;
        Some(Date { year, month: month as u8, day: day as u8 })
    }

    /// The days since 1970-01-01, negative before it.
    pub fn days(self) -> i64 {
        let (year, month, day) = (i64::from(self.year), i64::from(self.month), i64::from(self.day));
        let year = if month <= 2 { year - 1 } else { year };
        let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
        365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + of_year - 719_468
    }

    fn days_of_month(self) -> u8 {
        let leap =
            self.year.is_multiple_of(4) && (!self.year.is_multiple_of(100) || self.year.is_multiple_of(400));
        match self.month {
            2 if leap => 29,
            2 => 28,
            4 | 6 | 9 | 11 => 30,
            _ => 31,
        }
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

/// Seconds since 1970 as RFC 3339 has them: `2026-11-21T05:30:00Z`. After the year 9999 the last instant of it.
pub fn rfc3339(seconds: u64) -> String {
    let last = Date::LAST.days() * DAY + DAY - 1;
    let seconds = i64::try_from(seconds).map_or(last, |seconds| seconds.min(last));
    let (date, second) = (Date::from_days(seconds / DAY).unwrap_or(Date::LAST), seconds % DAY);
    format!("{date}T{:02}:{:02}:{:02}Z", second / 3_600, second / 60 % 60, second % 60)
}

/// The seconds since 1970 of an instant `2026-11-21T05:30:00Z`, or with another zone, `2026-11-21T06:30:00+01:00`; a fraction of
/// the second is dropped. `None` for anything else, and for days that do not exist.
pub fn seconds_of(rfc3339: &str) -> Option<i64> {
    if let Some((local, sign, zone)) = zone_of(rfc3339) {
        let ahead = sign * clock_of(&format!("{zone}:00"))?;
        return Some(seconds_of(&format!("{local}Z"))? - ahead);
    }
    let (date, time) = rfc3339.strip_suffix('Z')?.split_once('T')?;
    let whole = time.split_once('.').map_or(time, |(whole, _)| whole);
    Some(Date::parse(date)?.days() * DAY + clock_of(whole)?)
}

/// An instant that ends with a distance from UTC, `+01:00`: what is before it, 1 or -1, and its hours and minutes.
fn zone_of(rfc3339: &str) -> Option<(&str, i64, &str)> {
    let at =
        rfc3339.rfind(['+', '-']).filter(|at| rfc3339.get(..*at).is_some_and(|local| local.contains('T')))?;
    let sign = if rfc3339.as_bytes().get(at) == Some(&b'-') { -1 } else { 1 };
    Some((rfc3339.get(..at)?, sign, rfc3339.get(at + 1..)?))
}

/// The seconds since midnight of `05:30:00`.
fn clock_of(text: &str) -> Option<i64> {
    let mut parts = text.split(':').map(|part| match part.as_bytes() {
        [a, b] if a.is_ascii_digit() && b.is_ascii_digit() => part.parse::<i64>().ok(),
        _ => None,
    });
    let (hour, minute, second) = (parts.next()??, parts.next()??, parts.next()??);
    let valid = hour < 24 && minute < 60 && second < 60 && parts.next().is_none();
    valid.then_some((hour * 60 + minute) * 60 + second)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_read_and_compare() {
        let day = |text| Date::parse(text).unwrap();
        assert!(day("2026-01-31") < day("2026-02-01") && day("2025-12-31") < day("2026-01-01"));
        assert_eq!(day("2024-02-29").to_string(), "2024-02-29");
        for text in
            ["", "2026", "2026-1-31", "2026-02-29", "1900-02-29", "2026-13-01", "2026-01-00", "+026-01-01"]
        {
            assert_eq!(Date::parse(text), None, "{text}");
        }
        assert_eq!(Date::parse("2026-01-01-01"), None);
    }

    /// Counts every day of four centuries and more one by one, by the lengths of the months.
    #[test]
    fn every_day_has_one_number() {
        let mut date = Date::parse("1599-12-31").unwrap();
        for days in date.days()..=Date::parse("2400-03-02").unwrap().days() {
            assert_eq!((date.days(), Date::from_days(days)), (days, Some(date)));
            date = if date.day < date.days_of_month() {
                Date { day: date.day + 1, ..date }
            } else if date.month < 12 {
                Date { month: date.month + 1, day: 1, ..date }
            } else {
                Date { year: date.year + 1, month: 1, day: 1 }
            };
        }
        assert_eq!(Date::parse("1970-01-01").map(Date::days), Some(0));
        assert_eq!(Date::from_days(i64::MAX), None);
    }

    #[test]
    fn instants_are_written_and_read() {
        for (seconds, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (951_868_799, "2000-02-29T23:59:59Z"),
            (4_102_444_800, "2100-01-01T00:00:00Z"),
        ] {
            assert_eq!((rfc3339(seconds).as_str(), seconds_of(text)), (text, i64::try_from(seconds).ok()));
        }
        assert_eq!(rfc3339(u64::MAX), "9999-12-31T23:59:59Z");
        for text in ["00:00:00.5Z", "05:30:00+05:30", "00:00:00-00:00"] {
            assert_eq!(seconds_of(&format!("2100-01-01T{text}")), Some(4_102_444_800), "{text}");
        }
        assert_eq!(seconds_of("2099-12-31T22:00:00-02:00"), Some(4_102_444_800));
        for text in [
            "2026-11-21 05:30",
            "2026-11-21T05:30Z",
            "2026-11-21T24:00:00Z",
            "2026-02-30T00:00:00Z",
            "µ",
            "T+µ",
            "2026-11-21T05:30:00+1:00",
            "2026-11-21T05:30:00+01:00Z",
            "2026-11-21T05:30:00Z+01:00",
        ] {
            assert_eq!(seconds_of(text), None, "{text}");
        }
    }
}
