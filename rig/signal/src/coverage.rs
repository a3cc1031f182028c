//! What an interval of values or instants covers: the coverage of a statement of uncertainty.

use std::fmt;

use crate::Decimal;

/// What a stated interval covers, in the terms of the Guide to the expression of uncertainty in measurement (GUM).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Coverage {
    /// A bound that is never passed: what a data sheet guarantees.
    #[default]
    Limits,
    /// The coverage probability, in percent: above 0 and below 100.
    Probability(Decimal),
    /// The coverage factor `k` by which a standard uncertainty was multiplied: above 0.
    Factor(Decimal),
}

impl Coverage {
    /// Reads `limits`, a probability such as `95 %`, or a factor such as `k = 2`. `None` for all else.
    pub fn parse(text: &str) -> Option<Coverage> {
        let text = text.trim();
        if text == "limits" {
            return Some(Coverage::Limits);
        }
        if let Some(factor) = text.strip_prefix('k') {
            let (factor, rest) = Decimal::split(factor.trim_start().strip_prefix('=')?).ok()?;
            return (rest.is_empty() && factor > Decimal::ZERO).then_some(Coverage::Factor(factor));
        }
        let (percent, rest) = Decimal::split(text).ok()?;
        let right = rest == "%" && percent > Decimal::ZERO && percent < Decimal::from(100);
        right.then_some(Coverage::Probability(percent))
    }

    /// What several statements that took part in one figure cover together: each that is not a bound is named, as no
    /// probability follows for all of them. `limits` where all are bounds.
    pub fn together(statements: impl IntoIterator<Item = Coverage>) -> String {
        let mut stated: Vec<Coverage> =
            statements.into_iter().filter(|one| *one != Coverage::Limits).collect();
        stated.sort_unstable();
        stated.dedup();
        if stated.is_empty() {
            return Coverage::Limits.to_string();
        }
        let words: Vec<String> = stated.iter().map(Coverage::to_string).collect();
        words.join(", ")
    }
}

impl fmt::Display for Coverage {
    /// `limits`, `95 %`, `k = 2`. Reads back with [`Coverage::parse`].
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Coverage::Limits => f.write_str("limits"),
            Coverage::Probability(percent) => write!(f, "{percent} %"),
            Coverage::Factor(factor) => write!(f, "k = {factor}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coverage_reads_back() {
        for (text, shown) in [
            ("limits", "limits"),
            ("95 %", "95 %"),
            (" 99.73% ", "99.73 %"),
            ("k = 2", "k = 2"),
            ("k=1.96", "k = 1.96"),
        ] {
            let read = Coverage::parse(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(read.to_string(), shown);
            assert_eq!(Coverage::parse(shown), Some(read));
        }
        for text in ["", "95", "0 %", "100 %", "-5 %", "k", "k 2", "k = 0", "k = two", "limit", "2 V"] {
            assert_eq!(Coverage::parse(text), None, "{text}");
        }
    }

    #[test]
    fn statements_that_are_no_bounds_are_named() {
        let all = |texts: &[&str]| Coverage::together(texts.iter().filter_map(|text| Coverage::parse(text)));
        assert_eq!(all(&[]), "limits");
        assert_eq!(all(&["limits", "limits"]), "limits");
        assert_eq!(all(&["k = 2", "limits", "95 %", "k = 2"]), "95 %, k = 2");
    }
}
