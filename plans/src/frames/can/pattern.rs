//! Which frames of a bus are meant.

use std::fmt;

use crate::frames::DataPattern;

/// The greatest identifier of 11 bits, and of 29.
pub const MAX_ID: u32 = 0x7FF;
/// See [`MAX_ID`].
pub const MAX_EXTENDED_ID: u32 = 0x1FFF_FFFF;

/// Who sent a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FrameSender {
    /// Whoever it was.
    #[default]
    Any,
    /// This very bus of the rig.
    Own,
    /// Another node.
    Others,
}

impl FrameSender {
    /// The words in plans.
    pub const NAMES: &[&str] = &["any", "own", "others"];

    /// The one of this word.
    pub fn find(name: &str) -> Option<FrameSender> {
        [FrameSender::Any, FrameSender::Own, FrameSender::Others]
            .into_iter()
            .zip(Self::NAMES)
            .find_map(|(from, known)| (*known == name).then_some(from))
    }
}

/// What is known of a frame that was on a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameView<'a> {
    /// Its identifier.
    pub id: u32,
    /// The identifier has 29 bits.
    pub extended: bool,
    /// A remote frame.
    pub remote: bool,
    /// A CAN FD frame.
    pub fd: bool,
    /// Its data; none of a remote frame.
    pub data: &'a [u8],
    /// The rig sent it on this bus.
    pub own: bool,
}

/// The frames that a name stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramePattern {
    /// The bus, by its name in the board file.
    pub bus: String,
    /// The identifier.
    pub id: u32,
    /// Which bits of it count.
    pub mask: u32,
    /// Whether it has 29 bits.
    pub extended: bool,
    /// Whether remote frames are meant, or frames of data.
    pub remote: bool,
    /// Whether CAN FD frames are meant, or classic ones; `None`: both.
    pub fd: Option<bool>,
    /// Their data.
    pub data: DataPattern,
    /// Who sends them.
    pub from: FrameSender,
    /// Whether a frame that is sent has its data at the data bit rate.
    pub brs: bool,
    /// Name of the message in a DBC file, where it comes from one.
    pub message: Option<String>,
    /// Number of data bytes of that message, for what is sent.
    pub length: Option<u8>,
}

impl FramePattern {
    /// Whether a frame is meant.
    #[inline]
    pub fn matches(&self, frame: &FrameView<'_>) -> bool {
        let sender = match self.from {
            FrameSender::Any => true,
            FrameSender::Own => frame.own,
            FrameSender::Others => !frame.own,
        };
        frame.id & self.mask == self.id & self.mask
            && frame.extended == self.extended
            && frame.remote == self.remote
            && self.fd.is_none_or(|fd| fd == frame.fd)
            && sender
            && (frame.remote || self.data.matches(frame.data))
    }

    /// Whether it stands for one identifier only.
    pub fn is_one(&self) -> bool {
        let all = if self.extended { MAX_EXTENDED_ID } else { MAX_ID };
        self.mask & all == all
    }
}

impl fmt::Display for FramePattern {
    /// `machine 701#05`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = if self.extended { 8 } else { 3 };
        write!(f, "{} {:0width$X}", self.bus, self.id)?;
        if !self.is_one() {
            write!(f, "/{:0width$X}", self.mask)?;
        }
        match (self.remote, self.data.is_any()) {
            (true, _) => f.write_str("#R"),
            (false, true) => Ok(()),
            (false, false) => write!(f, "#{}", self.data),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern() -> FramePattern {
        FramePattern {
            bus: String::from("machine"),
            id: 0x180,
            mask: 0x780,
            extended: false,
            remote: false,
            fd: None,
            data: DataPattern::parse("05 *").unwrap(),
            from: FrameSender::Others,
            brs: false,
            message: None,
            length: None,
        }
    }

    #[test]
    fn each_part_of_a_pattern_counts() {
        let frame = FrameView { id: 0x1AB, extended: false, remote: false, fd: true, data: &[5], own: false };
        assert!(pattern().matches(&frame));
        for wrong in [
            FrameView { id: 0x2AB, ..frame },
            FrameView { extended: true, ..frame },
            FrameView { remote: true, ..frame },
            FrameView { data: &[6], ..frame },
            FrameView { own: true, ..frame },
        ] {
            assert!(!pattern().matches(&wrong), "{wrong:?}");
        }
        assert!(!FramePattern { fd: Some(false), ..pattern() }.matches(&frame));
        assert!(FramePattern { mask: MAX_ID, id: 0x1AB, ..pattern() }.is_one());
    }

    #[test]
    fn a_pattern_is_shown_as_analyzers_do() {
        assert_eq!(pattern().to_string(), "machine 180/780#05 *");
        let one = FramePattern { mask: MAX_ID, data: DataPattern::ANY, ..pattern() };
        assert_eq!(one.to_string(), "machine 180");
    }
}
