//! Which values a variable, a place of memory, an input or an output takes.

use program::Elementary;
use signal::{Address, Size, Span, Value};
use std::fmt;

/// The values that something takes which is written or forced: whatever else it is given it would cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TakenValues {
    /// FALSE and TRUE, also as 0 and 1.
    Level,
    /// Whole numbers from the first to the second.
    Whole(i128, i128),
    /// Nanoseconds of a duration, a time of day or a date, from 0 to the first, in steps of the second: what its type counts.
    Nanoseconds(i64, i64),
    /// Numbers that a REAL or LREAL holds (controller:DT-01).
    Real(Elementary),
    /// Any finite number.
    Number,
}

impl TakenValues {
    /// Those of a word without a type.
    pub const WORD: TakenValues = TakenValues::Whole(-(1 << 15), (1 << 16) - 1);

    /// Those of a place in %I, %Q or %M. Bits have no sign: a word takes the numbers of an INT and those of a UINT.
    pub const fn of_place(address: Address) -> TakenValues {
        match address.size() {
            Size::Bit => TakenValues::Level,
            size => {
                let bits = size.bits();
                TakenValues::Whole(-(1 << (bits - 1)), (1 << bits) - 1)
            }
        }
    }

    /// Those of a variable of this type.
    pub fn of_type(ty: Elementary) -> TakenValues {
        if ty == Elementary::Bool {
            return TakenValues::Level;
        }
        if ty.is_real() {
            return TakenValues::Real(ty);
        }
        let (low, high) = ty.range();
        match ty.nanos() {
            Some(nanos) => {
                let most = i64::try_from(high.saturating_mul(i128::from(nanos)));
                TakenValues::Nanoseconds(most.unwrap_or(i64::MAX), i64::try_from(nanos).unwrap_or(1))
            }
            None => TakenValues::Whole(low, high),
        }
    }

    /// The bits of a value that a bit or a word is forced to; `None` for what it does not take.
    pub fn forced(self, value: Value) -> Option<u64> {
        let number = value.as_int().filter(|_| self.takes(value))?;
        // A word has the bits of a signed number as well as of an unsigned one.
        Some(u64::from(number as u16))
    }

    /// Whether the value is one of them. TRUE and FALSE are no numbers.
    pub fn takes(self, value: Value) -> bool {
        let is_within = |low: i128, high: i128| {
            !matches!(value, Value::Bool(_))
                && value.as_int().is_some_and(|number| (low..=high).contains(&number))
        };
        let number = value.as_real().filter(|number| number.is_finite() && !matches!(value, Value::Bool(_)));
        match self {
            TakenValues::Level => matches!(value.as_int(), Some(0 | 1)),
            TakenValues::Whole(low, high) => is_within(low, high),
            TakenValues::Nanoseconds(most, step) => {
                is_within(0, i128::from(most))
                    && value.as_int().is_some_and(|number| number % i128::from(step.max(1)) == 0)
            }
            TakenValues::Real(ty) => number.is_some_and(|number| ty.holds_real(number)),
            TakenValues::Number => number.is_some(),
        }
    }
}

impl fmt::Display for TakenValues {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            TakenValues::Level => f.write_str("TRUE or FALSE"),
            TakenValues::Whole(low, high) => write!(f, "a whole number from {low} to {high}"),
            TakenValues::Nanoseconds(most, step) => {
                let [least, most, step] = [0, most, step].map(Span::from_nanos);
                write!(f, "a time from {least} to {most} in whole {step}")
            }
            TakenValues::Real(ty) => {
                let (least, most) = ty.magnitudes();
                write!(f, "0 and magnitudes from {least} to {most}")
            }
            TakenValues::Number => f.write_str("a number"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_types_take_what_they_hold() {
        let of = |place: &str| TakenValues::of_place(Address::parse(place).unwrap());
        let whole = |number| Value::Int(number);
        for (taken, least, most) in [
            (of("%MB3"), -128, 255),
            (of("%QW2"), -32_768, 65_535),
            (of("%MD3"), -2_147_483_648, 4_294_967_295),
            (TakenValues::of_type(Elementary::Int), -32_768, 32_767),
            (TakenValues::of_type(Elementary::Word), 0, 65_535),
            (TakenValues::of_type(Elementary::Char), 0, 255),
            (TakenValues::of_type(Elementary::Time), 0, 4_294_967_295_000_000),
            (of("%IX0.0"), 0, 1),
            (TakenValues::of_type(Elementary::Bool), 0, 1),
        ] {
            assert!(taken.takes(whole(least)) && taken.takes(whole(most)), "{taken}");
            assert!(!taken.takes(whole(least - 1)) && !taken.takes(whole(most + 1)), "{taken}");
            assert!(!taken.takes(Value::HighZ) && !taken.takes(Value::Real(1.5)), "{taken}");
            assert_eq!(taken.takes(Value::Bool(true)), taken == TakenValues::Level, "{taken}");
        }
        assert!(of("%ML0").takes(Value::Word(u64::MAX)) && of("%ML0").takes(whole(i64::MIN)));
        let ulint = TakenValues::of_type(Elementary::Ulint);
        assert!(ulint.takes(Value::Word(u64::MAX)) && !ulint.takes(whole(-1)));
        // What a TIME counts are milliseconds.
        let time = TakenValues::of_type(Elementary::Time);
        assert!(time.takes(whole(1_000_000)) && !time.takes(whole(1_500_000)), "{time}");
        assert_eq!(time.to_string(), "a time from 0 s to 4294967.295 s in whole 1 ms");
        let ltime = TakenValues::of_type(Elementary::Ltime);
        assert!(ltime.takes(whole(i64::MAX)) && !ltime.takes(Value::Word(u64::MAX)));
    }

    #[test]
    fn numbers_are_finite_and_of_a_magnitude_that_is_held() {
        let real = TakenValues::of_type(Elementary::Real);
        let long = TakenValues::of_type(Elementary::Lreal);
        assert!(real.takes(Value::Real(-3.4e38)) && real.takes(Value::Int(0)));
        assert!(!real.takes(Value::Real(3.5e38)) && long.takes(Value::Real(3.5e38)));
        for taken in [real, long, TakenValues::Number] {
            for not_taken in
                [Value::Real(f64::NAN), Value::Real(f64::INFINITY), Value::Bool(true), Value::HighZ]
            {
                assert!(!taken.takes(not_taken), "{taken} {not_taken}");
            }
        }
        assert!(TakenValues::Number.takes(Value::Real(1e300)));
    }
}
