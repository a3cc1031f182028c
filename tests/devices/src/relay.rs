//! Relays between lines of the lab.

/// What the contact of a relay does to its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// It cuts the line off, which then reads low.
    Open,
    /// It pulls the line low.
    Ground,
    /// It pulls the line high.
    Supply,
}

impl Contact {
    /// As the lab's file has it.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Contact::Open => "open",
            Contact::Ground => "ground",
            Contact::Supply => "supply",
        }
    }
}
