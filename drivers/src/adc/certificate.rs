//! What a calibration rests on, and for how long.

use signal::calendar::Date;
use std::fmt;
use std::time::{SystemTime, UNIX_EPOCH};

/// Today, by the machine's clock in UTC.
pub fn today() -> Date {
    let days = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() / 86_400);
    i64::try_from(days).ok().and_then(Date::from_days).unwrap_or(Date::LAST)
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
    fn a_certificate_counts_up_to_its_last_day() {
        let expires = Date::parse("2026-06-30");
        let certificate = Certificate { expires, ..Certificate::default() };
        let expired = |text| certificate.is_expired(Date::parse(text).unwrap());
        assert_eq!((expired("2026-06-30"), expired("2026-07-01")), (false, true));
        assert!(!Certificate::default().is_expired(today()));
    }
}
