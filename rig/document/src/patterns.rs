//! Patterns of the small languages inside texts, for schemas. They take all that the readers take, and little more:
//! that units go together, or that an end is not before its beginning, no pattern can say.
//!
//! Written for ECMA 262, without look-ahead, so that every validator has the same idea of them.

/// Somewhere in the text a `$`: a reference, or a `$$`.
pub const REFERENCE: &str = r"\$";

/// A number without a sign.
macro_rules! number {
    () => {
        r"[0-9]+(?:_[0-9]+)*(?:\.[0-9]+(?:_[0-9]+)*)?(?:[eE][+-]?[0-9]+)?"
    };
}

/// A unit of time.
macro_rules! time {
    () => {
        r"(?:ns|[uµμ]s|ms|s|min|h|d)"
    };
}

/// A unit.
macro_rules! unit {
    () => {
        r"[^\s0-9.,;:+±_#$-][^\s.,;:+±_#$-]*"
    };
}

/// A number with or without a unit, or a duration of several parts.
macro_rules! quantity {
    () => {
        concat!(r"[+-]?\s*", number!(), r"(?:\s*", unit!(), r"(?:\s*", number!(), r"\s*", unit!(), r")*)?")
    };
}

/// A duration of at least 0, as in `10 ms` or `1 min 30 s`, without ends.
pub const DURATION: &str =
    concat!(r"\+?\s*", number!(), r"\s*", time!(), r"(?:\s*", number!(), r"\s*", time!(), r")*");

/// A quantity, as in `200 kHz`, or a literal with a prefix, as in `T#5ms`; without ends.
pub const QUANTITY: &str = concat!(quantity!(), r"|[A-Za-z0-9]+#.+");

/// A range of quantities, as in `4 .. 20 mA` or `24 V ± 10 %`, or a single one; without ends.
pub const RANGE: &str = concat!(
    quantity!(),
    r"\s*\.\.(?:\s*",
    quantity!(),
    r")?|\.\.\s*",
    quantity!(),
    "|",
    quantity!(),
    r"(?:\s*(?:±|\+-|\+/-)\s*",
    quantity!(),
    ")?",
);

/// The pattern for a whole text, blanks at its ends aside.
pub(crate) fn whole(pattern: &str) -> String {
    format!(r"^\s*(?:{pattern})\s*$")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use regex::Regex;
    use signal::{Quantity, QuantityRange, Span};

    fn matches(pattern: &str, text: &str) -> bool {
        Regex::new(&whole(pattern)).unwrap().is_match(text)
    }

    #[test]
    fn patterns_tell_what_reads_from_what_does_not() {
        for good in ["10 ms", " 1 min 30 s ", "1s500ms", "0.37 ms", "60_000 ns", "1.5e-3 s", "2 µs", "2 μs"]
        {
            assert!(matches(DURATION, good) && Span::parse(good).is_ok(), "{good}");
        }
        for bad in ["", "10", "10 V", "ms", "- 10 ms", "10 ms 5", "10 m s", "1,5 s", "1. s"] {
            let reads = Span::parse(bad).is_ok_and(|span| !span.is_negative());
            assert!(!matches(DURATION, bad) && !reads, "{bad}");
        }
        for good in ["200 kHz", "-21.5 °C", "60_000", "10 l/min", "5 m3/h", "1 min 30 s", "T#5ms", "16#10"] {
            assert!(matches(QUANTITY, good), "{good}");
        }
        for bad in ["", "kHz", "24 V 3", "1 .. 2", "24 V#"] {
            assert!(!matches(QUANTITY, bad) && Quantity::parse(bad).is_err(), "{bad}");
        }
        for good in ["100 ms .. 100.3 ms", ".. 5 V", "5 ms ..", "4..20 mA", "24 V ± 10 %", "10 ms +/- 1 ms"]
        {
            assert!(matches(RANGE, good) && QuantityRange::parse(good).is_ok(), "{good}");
        }
        for bad in ["", "..", "1 .. 2 .. 3", "± 5 V", "5 ms -> 6 ms", "up to 5 ms"] {
            assert!(!matches(RANGE, bad) && QuantityRange::parse(bad).is_err(), "{bad}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        // The schema must not refuse what the reader takes.
        #[test]
        fn what_reads_is_matched(
            text in "[+]? ?([0-9_.]{1,4} ?(n|u|µ|m)?(s|V|in|h|d|%|bar|°C)? ?){1,3}",
            sign in "( ?\\.\\. ?| ?± ?| ?\\+- ?)",
            other in "[-+]?[0-9]{1,2}(\\.[0-9])?(e-?[0-9])? ?(ms|s|V|%)?",
        ) {
            if Span::parse(&text).is_ok() {
                prop_assert!(matches(DURATION, &text), "{}", text);
            }
            if Quantity::parse(&text).is_ok() {
                prop_assert!(matches(QUANTITY, &text), "{}", text);
            }
            for range in [format!("{text}{sign}{other}"), format!("{sign}{other}"), format!("{other}{sign}")] {
                if QuantityRange::parse(&range).is_ok() {
                    prop_assert!(matches(RANGE, &range), "{}", range);
                }
            }
        }
    }
}
