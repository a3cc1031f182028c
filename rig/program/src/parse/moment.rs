//! Durations, dates and times of day.

use super::literal::{SourceLiteralFault, number, underscores};
use crate::types::Elementary;

const SECOND: i128 = 1_000_000_000;
const DAY: i128 = 86_400 * SECOND;

/// Type and cell of `T#1h30m`, `LTIME#1.5us`.
pub(crate) fn duration(text: &str) -> Result<(i64, Elementary), SourceLiteralFault> {
    let (prefix, body) = text.split_once('#').unwrap_or(("", text));
    let body = body.to_ascii_lowercase();
    let (nanoseconds, exact) = nanoseconds(&body)?;
    if prefix.eq_ignore_ascii_case("LT") || prefix.eq_ignore_ascii_case("LTIME") {
        if !exact {
            return Err(SourceLiteralFault::FinerThanNanoseconds);
        }
        let cell = i64::try_from(nanoseconds).map_err(|_| SourceLiteralFault::TooLongLong)?;
        return Ok((cell, Elementary::Ltime));
    }
    // Decimals that are finer than the type are cut off, as where LTIME becomes TIME; units that are finer are a slip.
    if nanoseconds % 1_000_000 != 0 && (body.ends_with("us") || body.ends_with("ns")) {
        return Err(SourceLiteralFault::TooFine);
    }
    let cell = u32::try_from(nanoseconds / 1_000_000).map_err(|_| SourceLiteralFault::TooLong)?;
    Ok((i64::from(cell), Elementary::Time))
}

/// Nanoseconds of `1d2h3m4s5ms`, in small letters, and whether they are whole; what is finer is cut off.
fn nanoseconds(body: &str) -> Result<(i128, bool), SourceLiteralFault> {
    const UNITS: [(&str, i128); 7] = [
        ("d", DAY),
        ("h", 3_600 * SECOND),
        ("m", 60 * SECOND),
        ("s", SECOND),
        ("ms", 1_000_000),
        ("us", 1_000),
        ("ns", 1),
    ];
    let mut rest = match body.strip_prefix('-') {
        Some(_) => return Err(SourceLiteralFault::Negative),
        None => body.strip_prefix('+').unwrap_or(body),
    };
    if rest.is_empty() {
        return Err(SourceLiteralFault::Duration);
    }
    let mut total = 0i128;
    let mut units = UNITS.iter();
    let (mut first, mut fraction_seen, mut exact) = (true, false, true);
    while !rest.is_empty() {
        rest = rest.strip_prefix('_').filter(|_| !first).unwrap_or(rest);
        first = false;
        let number_end = rest
            .find(|c: char| !(c.is_ascii_digit() || c == '.' || c == '_'))
            .ok_or(SourceLiteralFault::Duration)?;
        let (digits, after) = rest.split_at(number_end);
        let unit_end = after.find(|c: char| !c.is_ascii_lowercase()).unwrap_or(after.len());
        let (unit, after) = after.split_at(unit_end);
        // Units go down, and only the last number may have a fraction.
        let (_, scale) = units.find(|(name, _)| *name == unit).ok_or(SourceLiteralFault::Duration)?;
        if fraction_seen {
            return Err(SourceLiteralFault::Duration);
        }
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        fraction_seen = digits.contains('.');
        if whole.is_empty() || fraction_seen && fraction.is_empty() {
            return Err(SourceLiteralFault::Duration);
        }
        underscores(fraction)?;
        total += number(whole)? * scale;
        let (part, part_exact) = scaled(fraction, *scale)?;
        total += part;
        exact &= part_exact;
        rest = after;
    }
    Ok((total, exact))
}

/// `0.fraction` times `scale`, and whether that is whole.
fn scaled(fraction: &str, scale: i128) -> Result<(i128, bool), SourceLiteralFault> {
    let (mut sum, mut place) = (0i128, 1i128);
    // Zeros at the end say nothing; more than 18 places cannot be whole in any unit.
    let digits: Vec<char> = fraction.trim_end_matches(['0', '_']).chars().filter(|c| *c != '_').collect();
    let whole = digits.len() <= 18;
    for digit in digits.into_iter().take(18) {
        sum = sum * 10 + i128::from(digit.to_digit(10).ok_or(SourceLiteralFault::Duration)?);
        place *= 10;
    }
    Ok((sum * scale / place, whole && sum * scale % place == 0))
}

/// Type and cell of `D#2024-02-29`, `TOD#12:34:56.789`, `LDT#2024-02-29-12:34:56.789`.
pub(crate) fn date(text: &str) -> Result<(i64, Elementary), SourceLiteralFault> {
    let (prefix, body) = text.split_once('#').unwrap_or(("", text));
    let (long, name) = match prefix.strip_prefix(['L', 'l']) {
        Some(name) => (true, name),
        None => (false, prefix),
    };
    let is = |short: &str, full: &str| name.eq_ignore_ascii_case(short) || name.eq_ignore_ascii_case(full);
    let (total, unit, ty) = if is("D", "DATE") {
        (days(body)? * DAY, SECOND, if long { Elementary::Ldate } else { Elementary::Date })
    } else if is("TOD", "TIME_OF_DAY") {
        (clock(body)?, 1_000_000, if long { Elementary::Ltod } else { Elementary::Tod })
    } else {
        // The third dash divides date and time.
        let (at, _) = body.match_indices('-').nth(2).ok_or(SourceLiteralFault::DateAndTime)?;
        let (date, time) = body.split_at(at);
        let total = days(date)? * DAY + clock(time.trim_start_matches('-'))?;
        (total, SECOND, if long { Elementary::Ldt } else { Elementary::Dt })
    };
    let unit = if long { 1 } else { unit };
    if total % unit != 0 {
        return Err(SourceLiteralFault::FinerThanType);
    }
    let last = if long { i128::from(i64::MAX) } else { i128::from(u32::MAX) };
    let cell = i64::try_from(total / unit).map_err(|_| SourceLiteralFault::OutsideCalendar)?;
    if i128::from(cell) > last { Err(SourceLiteralFault::OutsideCalendar) } else { Ok((cell, ty)) }
}

/// Days from 1970-01-01 to `2024-02-29`.
fn days(text: &str) -> Result<i128, SourceLiteralFault> {
    let mut parts = text.split('-').map(|part| decimal(part, SourceLiteralFault::Date));
    let (Some(year), Some(month), Some(day), None) = (parts.next(), parts.next(), parts.next(), parts.next())
    else {
        return Err(SourceLiteralFault::Date);
    };
    let (year, month, day) = (year?, month?, day?);
    let leap = |year: i128| year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = |month: i128| match month {
        2 => 28 + i128::from(leap(year)),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    if !(1..=12).contains(&month) || day < 1 || day > length(month) {
        return Err(SourceLiteralFault::NoSuchDay);
    }
    if !(1970..=9999).contains(&year) {
        return Err(SourceLiteralFault::OutsideCalendar);
    }
    // Every fourth year before this one was longer by a day, but for three centuries in four.
    let leaps = |year: i128| (year - 1) / 4 - (year - 1) / 100 + (year - 1) / 400;
    let before = (1..month).map(length).sum::<i128>();
    Ok((year - 1970) * 365 + leaps(year) - leaps(1970) + before + day - 1)
}

/// Nanoseconds from midnight to `12:34:56.789`; the seconds may be left out.
fn clock(text: &str) -> Result<i128, SourceLiteralFault> {
    let mut parts = text.split(':');
    let (Some(hour), Some(minute)) = (parts.next(), parts.next()) else {
        return Err(SourceLiteralFault::TimeOfDay);
    };
    let second = parts.next().unwrap_or("0");
    if parts.next().is_some() {
        return Err(SourceLiteralFault::TimeOfDay);
    }
    let (second, fraction) = second.split_once('.').unwrap_or((second, ""));
    let whole = |part| decimal(part, SourceLiteralFault::TimeOfDay);
    let (hour, minute, second) = (whole(hour)?, whole(minute)?, whole(second)?);
    if hour > 23 || minute > 59 || second > 59 {
        return Err(SourceLiteralFault::NoSuchTime);
    }
    if fraction.contains('_') {
        return Err(SourceLiteralFault::TimeOfDay);
    }
    let (part, exact) = scaled(fraction, SECOND).map_err(|_| SourceLiteralFault::TimeOfDay)?;
    if !exact {
        return Err(SourceLiteralFault::FinerThanType);
    }
    Ok(((hour * 60 + minute) * 60 + second) * SECOND + part)
}

/// Up to four digits.
fn decimal(text: &str, fault: SourceLiteralFault) -> Result<i128, SourceLiteralFault> {
    let fine = (1..=4).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
    if fine { text.parse().map_err(|_| fault) } else { Err(fault) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations() {
        // controller:DT-01 - TIME has 32 bits of milliseconds.
        let time = |text| {
            duration(text).map(|(cell, ty)| {
                assert_eq!(ty, Elementary::Time);
                cell
            })
        };
        assert_eq!(time("T#1d2h3m4s5ms"), Ok(93_784_005));
        assert_eq!(time("time#1.5s"), Ok(1_500));
        assert_eq!(time("t#1h_30m"), Ok(5_400_000));
        assert_eq!(time("T#90s"), Ok(90_000));
        assert_eq!(time("T#+1_000ms"), Ok(1_000));
        assert_eq!(time("T#1000us"), Ok(1));
        assert_eq!(time("T#0.50000000000000000000000000000s"), Ok(500));
        assert_eq!(time("T#4294967295ms"), Ok(4_294_967_295));
        assert_eq!(time("T#4294967296ms"), Err(SourceLiteralFault::TooLong));
        assert_eq!(time("T#1s1m"), Err(SourceLiteralFault::Duration));
        assert_eq!(time("T#1s1s"), Err(SourceLiteralFault::Duration));
        assert_eq!(time("T#1.5s1ms"), Err(SourceLiteralFault::Duration));
        assert_eq!(time("T#.5s"), Err(SourceLiteralFault::Duration));
        assert_eq!((time("T#5.5ms"), time("T#0.5ms"), time("T#1m2.3456s")), (Ok(5), Ok(0), Ok(62_345)));
        assert_eq!(time("T#0.3333333333333333333333s"), Ok(333));
        assert_eq!(time("T#1us"), Err(SourceLiteralFault::TooFine));
        assert_eq!(time("T#-1s"), Err(SourceLiteralFault::Negative));
        for text in ["T#", "T#5", "T#s", "T#5x", "T#_5s", "T#1h__5m"] {
            assert!(duration(text).is_err(), "{text}");
        }
    }

    #[test]
    fn long_durations() {
        let ltime = |text| {
            duration(text).map(|(cell, ty)| {
                assert_eq!(ty, Elementary::Ltime);
                cell
            })
        };
        assert_eq!(ltime("LTIME#1d2h3m4s5ms6us7ns"), Ok(93_784_005_006_007));
        assert_eq!(ltime("lt#1.5us"), Ok(1_500));
        assert_eq!(ltime("LTIME#0.5ns"), Err(SourceLiteralFault::FinerThanNanoseconds));
        assert_eq!(ltime("LTIME#9223372036854775807ns"), Ok(i64::MAX));
        assert_eq!(ltime("LTIME#9223372036854775808ns"), Err(SourceLiteralFault::TooLongLong));
        assert_eq!(ltime("LTIME#18446744073709551615d"), Err(SourceLiteralFault::TooLongLong));
        assert_eq!(ltime("LTIME#99999999999999999999d"), Err(SourceLiteralFault::TooLarge));
    }

    #[test]
    fn dates() {
        let day = 86_400i64;
        assert_eq!(date("D#1970-01-01"), Ok((0, Elementary::Date)));
        assert_eq!(date("DATE#1972-3-1"), Ok(((2 * 365 + 31 + 29) * day, Elementary::Date)));
        // `date -u -d 2020-01-31 +%s` of GNU coreutils.
        assert_eq!(date("d#2020-01-31"), Ok((1_580_428_800, Elementary::Date)));
        assert_eq!(date("D#2000-02-29"), Ok((951_782_400, Elementary::Date)));
        assert_eq!(date("D#2106-02-07"), Ok((4_294_944_000, Elementary::Date)));
        assert_eq!(date("D#2106-02-08"), Err(SourceLiteralFault::OutsideCalendar));
        assert_eq!(date("LDATE#2106-02-08"), Ok((4_295_030_400_000_000_000, Elementary::Ldate)));
        assert_eq!(date("LD#2262-04-11"), Ok((9_223_286_400_000_000_000, Elementary::Ldate)));
        assert_eq!(date("LD#2262-04-12"), Err(SourceLiteralFault::OutsideCalendar));
        assert_eq!(date("D#1969-12-31"), Err(SourceLiteralFault::OutsideCalendar));
        assert_eq!(date("D#2023-02-29"), Err(SourceLiteralFault::NoSuchDay));
        assert_eq!(date("D#2100-02-29"), Err(SourceLiteralFault::NoSuchDay));
        assert_eq!(date("D#2023-13-01"), Err(SourceLiteralFault::NoSuchDay));
        assert_eq!(date("D#2023-00-01"), Err(SourceLiteralFault::NoSuchDay));
        for text in ["D#", "D#2023", "D#2023-01", "D#2023-01-01-01", "D#2023-1_0-1", "D#02023-01-01"] {
            assert_eq!(date(text), Err(SourceLiteralFault::Date), "{text}");
        }
    }

    #[test]
    fn times_of_day() {
        assert_eq!(date("TOD#12:34:56.789"), Ok((45_296_789, Elementary::Tod)));
        assert_eq!(date("TIME_OF_DAY#23:59:59.999"), Ok((86_399_999, Elementary::Tod)));
        assert_eq!(date("tod#7:05"), Ok((25_500_000, Elementary::Tod)));
        assert_eq!(date("LTOD#0:0:0.000000001"), Ok((1, Elementary::Ltod)));
        assert_eq!(date("LTIME_OF_DAY#0:0:1"), Ok((1_000_000_000, Elementary::Ltod)));
        assert_eq!(date("TOD#0:0:0.0001"), Err(SourceLiteralFault::FinerThanType));
        assert_eq!(date("LTOD#0:0:0.0000000001"), Err(SourceLiteralFault::FinerThanType));
        for text in ["TOD#24:00:00", "TOD#0:60:0", "TOD#0:0:60"] {
            assert_eq!(date(text), Err(SourceLiteralFault::NoSuchTime), "{text}");
        }
        for text in ["TOD#", "TOD#5", "TOD#1:2:3:4", "TOD#1::2", "TOD#1.5:3"] {
            assert_eq!(date(text), Err(SourceLiteralFault::TimeOfDay), "{text}");
        }
    }

    #[test]
    fn dates_with_times() {
        // `date -u -d '2020-01-31 12:34:56' +%s` of GNU coreutils.
        assert_eq!(date("DT#2020-01-31-12:34:56"), Ok((1_580_474_096, Elementary::Dt)));
        assert_eq!(date("DATE_AND_TIME#2106-02-07-06:28:15"), Ok((4_294_967_295, Elementary::Dt)));
        assert_eq!(date("DT#2106-02-07-06:28:16"), Err(SourceLiteralFault::OutsideCalendar));
        assert_eq!(date("DT#2020-01-31-12:34:56.5"), Err(SourceLiteralFault::FinerThanType));
        assert_eq!(date("LDT#2020-01-31-12:34:56.789"), Ok((1_580_474_096_789_000_000, Elementary::Ldt)));
        assert_eq!(date("LDATE_AND_TIME#1970-01-01-00:00:00.000000001"), Ok((1, Elementary::Ldt)));
        assert_eq!(date("DT#2020-01-31"), Err(SourceLiteralFault::DateAndTime));
    }
}
