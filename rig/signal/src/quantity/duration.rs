//! Durations as a user writes them.

use super::{PlacedQuantity, QuantityError};
use crate::Span;

impl Span {
    /// Reads a duration such as `100 ms`, `100.3ms`, `-2 us` or `1 min 30 s`.
    ///
    /// The number is an exact decimal with optional `_` between digits; units are ns, us (or µs), ms, s,
    /// min, h and d. What is finer than one nanosecond is refused, never rounded.
    ///
    /// # Errors
    /// [`QuantityError`] with the byte of the first fault.
    pub fn parse(text: &str) -> Result<Span, QuantityError> {
        PlacedQuantity::read(text, 0)?.span()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn durations_are_exact() {
        assert_eq!(Span::parse("100.3 ms"), Ok(Span::from_nanos(100_300_000)));
        assert_eq!(Span::parse("0.37ms"), Ok(Span::from_nanos(370_000)));
        assert_eq!(Span::parse("1 min 30 s"), Ok(Span::from_secs(90)));
        assert_eq!(Span::parse("-2 µs"), Ok(Span::from_nanos(-2_000)));
        assert_eq!(Span::parse("1_000 ns"), Ok(Span::from_nanos(1_000)));
        assert_eq!(Span::parse("0.001 d"), Ok(Span::from_nanos(86_400_000_000)));
        assert_eq!(Span::parse("-1s500ms"), Ok(Span::from_nanos(-1_500_000_000)));
    }

    #[test]
    fn faults_name_their_place() {
        use crate::QuantityFault as F;
        for (text, fault, at) in [
            ("", F::Empty, 0),
            ("100", F::MissingUnit, 0),
            ("100 msec", F::NoTime, 4),
            ("5 V", F::NoTime, 2),
            ("0.1 ns", F::TooFine, 0),
            ("300000 d", F::TooLong, 0),
            ("200 d 106700 d", F::TooLong, 0),
            (". ms", F::Number, 0),
            ("1. ms", F::Number, 0),
        ] {
            assert_eq!(Span::parse(text), Err(QuantityError { at, fault }), "{text}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(nanos in any::<i64>()) {
            let span = Span::from_nanos(nanos);
            prop_assert_eq!(Span::parse(&span.to_string()), Ok(span));
        }

        #[test]
        fn no_text_panics(text in "\\PC*") {
            let _ = Span::parse(&text);
        }
    }
}
