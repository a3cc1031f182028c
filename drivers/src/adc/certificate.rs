//! What a calibration rests on, and for how long.

use std::fmt;
use std::time::{SystemTime, UNIX_EPOCH};

/// A day of the Gregorian calendar; the order is that of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Date {
    year: u16,
    month: u8,
    day: u8,
}

impl Date {
    /// Reads `2026-01-31`. `None` for anything else, and for days that there are not.
    pub fn parse(text: &str) -> Option<Date> {
        let mut parts = text.split('-');
        let mut part = |digits: usize| -> Option<u16> {
            let text = parts.next().filter(|text| text.len() == digits)?;
            text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok()).flatten()
        };
        let (year, month, day) = (part(4)?, part(2)? as u8, part(2)? as u8);
        let date = Date { year, month, day };
        (parts.next().is_none() && (1..=12).contains(&month) && (1..=date.days()).contains(&day))
            .then_some(date)
    }

    /// Days of its month.
    fn days(self) -> u8 {
        let leap =
            self.year.is_multiple_of(4) && (!self.year.is_multiple_of(100) || self.year.is_multiple_of(400));
        match self.month {
            2 if leap => 29,
            2 => 28,
            4 | 6 | 9 | 11 => 30,
            _ => 31,
        }
    }

    /// Today, by the machine's clock in UTC.
    pub fn today() -> Date {
        let days = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() / 86_400);
        Date::behind_1970(days)
    }

    /// So many days behind 1970-01-01.
    fn behind_1970(mut days: u64) -> Date {
        let mut date = Date { year: 1970, month: 1, day: 1 };
        loop {
            let here = u64::from(date.days());
            if days < here || date.year == u16::MAX {
                return Date { day: (days.min(here - 1) + 1) as u8, ..date };
            }
            days -= here;
            date = match date.month {
                12 => Date { year: date.year + 1, month: 1, day: 1 },
                month => Date { month: month + 1, ..date },
            };
        }
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

/// When and by whom a channel was calibrated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Certificate {
    /// When.
    pub date: Option<Date>,
    /// The last day on which it counts.
    pub expires: Option<Date>,
    /// By whom.
    pub by: Option<String>,
    /// Its number.
    pub number: Option<String>,
}

impl Certificate {
    /// Whether it does not count on this day.
    pub fn is_expired(&self, today: Date) -> bool {
        self.expires.is_some_and(|last| last < today)
    }
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("calibrated")?;
        if let Some(date) = self.date {
            write!(f, " {date}")?;
        }
        if let Some(by) = &self.by {
            write!(f, " by {by}")?;
        }
        if let Some(number) = &self.number {
            write!(f, ", certificate {number}")?;
        }
        self.expires.map_or(Ok(()), |last| write!(f, ", until {last}"))
    }
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

    #[test]
    fn the_days_since_1970_are_counted_with_leap_years() {
        for (days, text) in
            [(0, "1970-01-01"), (59, "1970-03-01"), (11_016, "2000-02-29"), (20_454, "2026-01-01")]
        {
            assert_eq!(Date::behind_1970(days).to_string(), text);
        }
    }

    #[test]
    fn a_certificate_counts_up_to_its_last_day() {
        let expires = Date::parse("2026-06-30");
        let certificate = Certificate { expires, ..Certificate::default() };
        let expired = |text| certificate.is_expired(Date::parse(text).unwrap());
        assert_eq!((expired("2026-06-30"), expired("2026-07-01")), (false, true));
        assert!(!Certificate::default().is_expired(Date::today()));
    }
}
