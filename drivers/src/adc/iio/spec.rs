//! What a board file says of a converter that the kernel has a driver for.

use std::ops::Range;
use std::path::PathBuf;

/// The most scans that the kernel is asked to keep.
pub const MAX_BUFFER: u32 = 65_536;

/// A converter of the industrial I/O subsystem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IioSpec {
    /// Which device it is.
    pub find: FindDevice,
    /// How its samples are taken; `None`: each when it is asked for.
    pub buffered: Option<Buffering>,
}

/// How a device is found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FindDevice {
    /// By what its driver calls it, as in `ads8688`.
    Name(String),
    /// By what the description of the board calls it.
    Label(String),
    /// By its node, as in `/dev/iio:device0`, or its place in `/sys`.
    Path(PathBuf),
}

impl Buffering {
    /// How many periods may pass between the beginning of one sample and the end of the next where none is lost: a sample
    /// ends before the next stamp, which is two periods after the stamp before it and may be late. With a trigger of
    /// somebody else it may have begun a period before its own stamp.
    pub fn spread(&self) -> u8 {
        if self.trigger.is_some() { 4 } else { 3 }
    }
}

/// Samples that the kernel takes by itself and keeps until they are read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Buffering {
    /// What starts each scan: a trigger of this name, or a timer that the rig makes.
    pub trigger: Option<String>,
    /// Where the file names the trigger; empty where it does not.
    pub trigger_place: Range<usize>,
    /// How many scans the kernel keeps.
    pub length: u32,
    /// How many scans come at once.
    pub watermark: u32,
}
