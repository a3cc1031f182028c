//! What was found of one thing, how good it is for real lines, and what fixes it.

/// How good a thing is for real lines, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CheckState {
    /// As it should be.
    Good,
    /// Nothing that real lines need, or not known.
    Open,
    /// Works, with a drawback.
    Poor,
    /// Real lines cannot be used, or not in time.
    Bad,
}

impl CheckState {
    /// The word that everybody reads.
    pub const fn word(self) -> &'static str {
        match self {
            CheckState::Good => "good",
            CheckState::Open => "-",
            CheckState::Poor => "poor",
            CheckState::Bad => "bad",
        }
    }
}

/// One thing that was looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DoctorCheck {
    /// What it belongs to.
    pub group: &'static str,
    /// What it is.
    pub name: &'static str,
    /// How good it is.
    pub state: CheckState,
    /// What was found.
    pub found: String,
    /// What follows from it, where it is not good.
    pub means: &'static str,
    /// The command that fixes it.
    pub fix: Option<String>,
    /// What has to be done after it, or what no command can do, as in `log in again`.
    pub then: String,
}

impl DoctorCheck {
    fn new(state: CheckState, group: &'static str, name: &'static str, found: String) -> DoctorCheck {
        DoctorCheck { group, name, state, found, means: "", fix: None, then: String::new() }
    }

    /// A thing that is as it should be.
    pub fn good(group: &'static str, name: &'static str, found: impl Into<String>) -> DoctorCheck {
        DoctorCheck::new(CheckState::Good, group, name, found.into())
    }

    /// A thing that is not there and need not be, or that is not known.
    pub fn open(group: &'static str, name: &'static str, found: impl Into<String>) -> DoctorCheck {
        DoctorCheck::new(CheckState::Open, group, name, found.into())
    }

    /// A thing that works, with a drawback.
    pub fn poor(group: &'static str, name: &'static str, found: impl Into<String>) -> DoctorCheck {
        DoctorCheck::new(CheckState::Poor, group, name, found.into())
    }

    /// A thing without which real lines cannot be used, or not in time.
    pub fn bad(group: &'static str, name: &'static str, found: impl Into<String>) -> DoctorCheck {
        DoctorCheck::new(CheckState::Bad, group, name, found.into())
    }

    /// What follows from it.
    #[must_use]
    pub fn means(mut self, means: &'static str) -> DoctorCheck {
        self.means = means;
        self
    }

    /// The command that fixes it.
    #[must_use]
    pub fn fix(mut self, line: impl Into<String>) -> DoctorCheck {
        self.fix = Some(line.into());
        self
    }

    /// What has to be done after the fix, or in its place.
    #[must_use]
    pub fn then(mut self, then: impl Into<String>) -> DoctorCheck {
        self.then = then.into();
        self
    }
}
