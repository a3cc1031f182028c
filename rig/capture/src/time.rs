//! Instants of files as whole nanoseconds.

use signal::{Decimal, Span, Time};

/// A number of units of ten to the `power` seconds, as the nanoseconds at or before and at or after it. `None` beyond
/// what a time can be.
pub(crate) fn nanos(number: Decimal, power: i32) -> Option<(i64, i64)> {
    let nanos = number.shifted(power.checked_add(9)?);
    if let Some(whole) = nanos.as_whole() {
        let whole = i64::try_from(whole).ok()?;
        return Some((whole, whole));
    }
    // A part of a nanosecond: the float is near enough to find its neighbours.
    let near = nanos.as_f64();
    let below = near.floor();
    if !(-9.0e18..=9.0e18).contains(&below) {
        return None;
    }
    Some((below as i64, (below as i64).saturating_add(1)))
}

/// The instant of a number of units of so many femtoseconds.
pub(crate) fn ticks(count: u64, femtoseconds: u64) -> Option<(Time, Time)> {
    let femtos = u128::from(count) * u128::from(femtoseconds);
    let below = i64::try_from(femtos / 1_000_000).ok()?;
    let above = i64::try_from(femtos.div_ceil(1_000_000)).ok()?;
    Some((Time::from_nanos(below), Time::from_nanos(above)))
}

/// The time between two samples at a rate, whole nanoseconds up.
pub(crate) fn period(rate: u64) -> Span {
    Span::from_nanos(i64::try_from(1_000_000_000u64.div_ceil(rate.max(1))).unwrap_or(i64::MAX))
}

/// A frequency such as `1 MHz` in whole hertz; without a unit hertz are meant.
pub(crate) fn hertz(text: &str) -> Option<u64> {
    let (number, unit) = Decimal::split(text).ok()?;
    let power = match unit.trim() {
        "" | "Hz" => 0,
        "kHz" => 3,
        "MHz" => 6,
        "GHz" => 9,
        _ => return None,
    };
    u64::try_from(number.shifted(power).as_whole()?).ok().filter(|hertz| *hertz > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_nanosecond_have_neighbours() {
        let number = |text| Decimal::split(text).unwrap().0;
        assert_eq!(nanos(number("1.5"), -3), Some((1_500_000, 1_500_000)));
        assert_eq!(nanos(number("-1.2345678901E-03"), 0), Some((-1_234_568, -1_234_567)));
        assert_eq!(nanos(number("1e30"), 0), None);
        assert_eq!(ticks(3, 1_500_000), Some((Time::from_nanos(4), Time::from_nanos(5))));
    }

    #[test]
    fn rates_are_whole_hertz() {
        assert_eq!(
            (hertz("1 MHz"), hertz("200000"), hertz("1.5kHz")),
            (Some(1_000_000), Some(200_000), Some(1_500))
        );
        assert_eq!((hertz("0 Hz"), hertz("fast"), hertz("1 mm")), (None, None, None));
        assert_eq!(period(3), Span::from_nanos(333_333_334));
    }
}
