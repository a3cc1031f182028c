//! Verdicts and how they combine.

use serde::{Deserialize, Serialize};
use std::fmt;

/// What a claim, a measurement, a case or a run came to, in the order of TTCN-3:
/// none < pass < inconclusive < fail < error. Several verdicts combine to the greatest.
///
/// A case that does not apply has no verdict at all: see [`crate::CaseStatus::NotApplicable`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing was judged.
    #[default]
    None,
    /// It holds for every placement of the events inside their intervals.
    Pass,
    /// It holds for some placements only, or there is no evidence.
    Inconclusive,
    /// It holds for no placement.
    Fail,
    /// The rig's own trouble; says nothing of the controller.
    Error,
}

impl Verdict {
    /// The combination of all: the greatest, or [`Verdict::None`] of nothing.
    pub fn fold(verdicts: impl IntoIterator<Item = Verdict>) -> Verdict {
        verdicts.into_iter().max().unwrap_or(Verdict::None)
    }

    /// The combination of two: the greater.
    pub fn and(self, other: Verdict) -> Verdict {
        self.max(other)
    }

    /// The word used in every file and report.
    pub const fn word(self) -> &'static str {
        match self {
            Verdict::None => "none",
            Verdict::Pass => "pass",
            Verdict::Inconclusive => "inconclusive",
            Verdict::Fail => "fail",
            Verdict::Error => "error",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.word())
    }
}

#[cfg(test)]
mod tests {
    use super::Verdict::{self, *};

    #[test]
    fn the_worst_wins_and_nothing_is_no_pass() {
        assert_eq!(Verdict::fold([Pass, Inconclusive, Pass]), Inconclusive);
        assert_eq!(Verdict::fold([Fail, Inconclusive]), Fail);
        assert_eq!(Verdict::fold([Fail, Error]), Error);
        assert_eq!(Verdict::fold([None, Pass]), Pass);
        assert_eq!(Verdict::fold([]), None);
    }
}
