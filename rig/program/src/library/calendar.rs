//! Days and dates of the Gregorian calendar.

/// Nanoseconds of a day.
pub(super) const DAY: u64 = 86_400_000_000_000;

/// Days of the 400 years after which the calendar repeats.
const ERA: i64 = 146_097;
/// Days from 0000-03-01, where the years of the sums below begin, to 1970-01-01.
const EPOCH: i64 = 719_468;

/// Days from 1970-01-01 to a date. `None` where there is no such date, or the year is outside 1970 to 9999.
pub(crate) fn days_of(year: i64, month: i64, day: i64) -> Option<i64> {
    if !(1970..=9999).contains(&year) || day < 1 || day > days_in(year, month) {
        return None;
    }
    // Years begin in March here, so that the leap day is the last one.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let of_era = year % 400;
    let of_year = (153 * month + 2) / 5 + day - 1;
    Some(year / 400 * ERA + of_era * 365 + of_era / 4 - of_era / 100 + of_year - EPOCH)
}

/// Year, month and day of a number of days, which is not negative, since 1970-01-01.
pub(crate) fn date_of(days: u64) -> (i64, i64, i64) {
    // Far from the limits: no date in 64 bits has more than 2^48 days.
    let days = (days & 0xFFFF_FFFF_FFFF) as i64 + EPOCH;
    let of_era = days % ERA;
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let year = year_of_era + days / ERA * 400;
    if month < 10 { (year, month + 3, day) } else { (year + 1, month - 9, day) }
}

/// Days of a month; 0 where there is no such month.
const fn days_in(year: i64, month: i64) -> i64 {
    match month {
        1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
        4 | 6 | 9 | 11 => 30,
        2 if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        2 => 28,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_date_in_turn() {
        // Against counting day by day with the months' lengths of the calendar, and known days of POSIX time.
        let (mut year, mut month, mut day) = (1970, 1, 1);
        for days in 0..250_000 {
            assert_eq!(date_of(days), (year, month, day));
            assert_eq!(days_of(year, month, day), Some(days as i64));
            day += 1;
            let leap = year % 4 == 0 && year % 100 != 0 || year % 400 == 0;
            let length = [31, if leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
            if day > length[month as usize - 1] {
                (month, day) = (month + 1, 1);
            }
            if month > 12 {
                (year, month) = (year + 1, 1);
            }
        }
        assert_eq!(days_of(2000, 3, 1), Some(11_017));
        assert_eq!(days_of(2038, 1, 19), Some(24_855));
    }

    #[test]
    fn no_such_date() {
        for (year, month, day) in [
            (1969, 12, 31),
            (10_000, 1, 1),
            (2021, 2, 29),
            (2100, 2, 29),
            (2020, 0, 1),
            (2020, 13, 1),
            (2020, 4, 31),
        ] {
            assert_eq!(days_of(year, month, day), None);
        }
        for n in [i64::MIN, i64::MAX, 0, -1] {
            assert_eq!(days_of(n, n, n), None);
            assert_eq!(days_of(2020, 1, n), None);
        }
        date_of(u64::MAX);
    }
}
