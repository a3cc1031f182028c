//! Where something that travels evenly between two ends is, in whole numbers: the instant at which it passes a place is the one at
//! which its position is there, whatever happened on its way.

/// The whole way, in the unit of positions.
pub(super) const WAY: i128 = 1_000_000_000_000_000_000_000_000_000_000;

/// Positions that are no further apart are one: far above what cutting off at each of many changes adds up to, and far below what
/// the slowest travels in a nanosecond.
pub(super) const SAME: i128 = 1_000_000;

/// How many decimals of a number that is written are taken as they are.
const DECIMALS: i128 = 1_000_000_000_000;

/// How far it comes in some nanoseconds where it takes `time` nanoseconds from end to end; neither below 0.
pub(super) fn travelled(nanos: i64, time: i64) -> i128 {
    if nanos >= time {
        return WAY;
    }
    let (nanos, time) = (i128::from(nanos), i128::from(time));
    nanos * (WAY / time) + nanos * (WAY % time) / time
}

/// The fewest nanoseconds in which it comes so far, which is at most the way.
pub(super) fn nanos_to(distance: i128, time: i64) -> i64 {
    // In two steps, since the product of both takes more bits than there are.
    const HALF: i128 = 1_000_000_000_000_000;
    let time = i128::from(time);
    let low = (distance % HALF * time + HALF - 1) / HALF;
    let nanos = (distance / HALF * time + low + HALF - 1) / HALF;
    i64::try_from(nanos).unwrap_or(i64::MAX)
}

/// The position of a number from 0 up to the whole way, which is `whole`: 1 or 100.
pub(super) fn of(number: f64, whole: i128) -> i128 {
    let number = number.clamp(0.0, whole as f64);
    let unit = WAY / whole;
    // What was written in decimals is meant in decimals.
    let decimals = libm::round(number * DECIMALS as f64);
    if libm::fabs(decimals / DECIMALS as f64 - number) <= 2.0 * f64::EPSILON * number {
        return decimals as i128 * (unit / DECIMALS);
    }
    // In steps of 20 bits, since the product of all with the unit takes more than there are.
    const STEP: u32 = 20;
    let (mut position, mut rest, mut unit) = (0, number, unit);
    for _ in 0..3 {
        rest *= f64::from(1u32 << STEP);
        let bits = libm::floor(rest);
        rest -= bits;
        position += (bits as i128 * unit) >> STEP;
        unit >>= STEP;
    }
    position
}

/// The position in percent.
pub(super) fn percent(position: i128) -> f64 {
    position as f64 / (WAY / 100) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_is_reached_at_its_first_nanosecond() {
        let mut random = signal::Random::new(5);
        for _ in 0..20_000 {
            let bits = 1 + random.below(62);
            let time = 1 + random.below(1 << bits) as i64;
            let distance = WAY / (1 << 40) * i128::from(random.below(1 << 40)) + 1;
            let nanos = nanos_to(distance, time);
            assert!(travelled(nanos, time) >= distance, "{time} {distance}");
            assert!(travelled(nanos - 1, time) < distance, "{time} {distance}");
        }
        assert_eq!(nanos_to(WAY, i64::MAX), i64::MAX);
    }

    #[test]
    fn numbers_are_positions_and_positions_numbers() {
        assert_eq!(of(7.0, 100), 7 * WAY / 100);
        assert_eq!(of(0.1, 1), WAY / 10);
        assert_eq!(of(12.345, 100), 12_345 * WAY / 100_000);
        assert_eq!(of(-3.0, 100), 0);
        assert_eq!(of(300.0, 100), WAY);
        for number in [100.0 / 3.0, 100.0 / 7.0, 1e-5 / 3.0, 0.0] {
            let away = percent(of(number, 100)) - number;
            assert!(away.abs() <= 4.0 * f64::EPSILON * number + 1e-17, "{number}");
        }
    }
}
