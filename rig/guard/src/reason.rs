//! Why the guard latched.

use std::fmt;

/// Why the guard latched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The rig gave no sign of life within the limit: it hangs, or it was stopped.
    Unresponsive,
    /// The rig's process ended without a goodbye, or is about to: it has let go of its guard.
    Exited,
    /// The rig said something that no rig says.
    Nonsense,
    /// The rig asked for it.
    Asked,
    /// The outputs did not come to their safe levels when the rig said that they were there.
    Unsafe,
}

impl Reason {
    /// All of them; their places are their numbers less 1.
    const ALL: [Reason; 5] =
        [Reason::Unresponsive, Reason::Exited, Reason::Nonsense, Reason::Asked, Reason::Unsafe];

    /// Its number in the shared page, above 0.
    pub(crate) fn number(self) -> u32 {
        self as u32 + 1
    }

    /// The reason of this number; an unknown one is nonsense.
    pub(crate) fn from_number(number: u32) -> Option<Reason> {
        let place = number.checked_sub(1)? as usize;
        Some(Self::ALL.get(place).copied().unwrap_or(Reason::Nonsense))
    }

    /// Whether the rig is lost: it is killed, since nothing else keeps it from writing.
    pub(crate) fn loses_rig(self) -> bool {
        matches!(self, Reason::Unresponsive | Reason::Exited | Reason::Nonsense)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Reason::Unresponsive => "the rig gave no sign of life within the guard's limit and was killed",
            Reason::Exited => "the rig ended without a goodbye",
            Reason::Nonsense => "the rig sent its guard what no rig sends and was killed",
            Reason::Asked => "the rig could not make its outputs safe by itself",
            Reason::Unsafe => "outputs did not come to their safe levels",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_comes_back_from_its_number() {
        for reason in Reason::ALL {
            assert_eq!(Reason::from_number(reason.number()), Some(reason));
        }
        assert_eq!(Reason::from_number(0), None);
        assert_eq!(Reason::from_number(u32::MAX), Some(Reason::Nonsense));
    }
}
