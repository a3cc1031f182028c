//! What a board file says of GPIO lines: chips to be found, and the line behind each channel.

use std::ops::Range;
use std::path::PathBuf;

use super::{Backend, Bias, Direction, Drive};
use crate::ChannelId;

/// The most lines of a chip that one claim takes, in either interface of the kernel: inputs and outputs each.
pub const MAX_LINES: usize = 64;

/// The longest name of a holder that the kernel keeps, in bytes.
pub const MAX_CONSUMER: usize = 31;

/// The GPIO lines of a board as a board file describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GpioSpec {
    /// The interface to be used; `None` for the best that the kernel offers.
    pub backend: Option<Backend>,
    /// What the rig calls itself as the holder of lines, where `gpioinfo` shows it.
    pub consumer: String,
    /// The chips.
    pub chips: Vec<ChipSpec>,
    /// The lines behind channels of the board, in the order of the channels.
    pub lines: Vec<LineSpec>,
}

/// How a chip is found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FindChip {
    /// By what its driver calls it, as in `pinctrl-bcm2711`.
    Label(String),
    /// By its name in the kernel, as in `gpiochip0`.
    Name(String),
    /// By its device, as in `/dev/gpiochip0`; links are followed.
    Path(PathBuf),
}

/// A chip of the board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChipSpec {
    /// Its name in the board file.
    pub name: String,
    /// How it is found.
    pub find: FindChip,
    /// Where the file says so.
    pub place: Range<usize>,
}

/// How a line is found on its chip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FindLine {
    /// By its number.
    Number(u32),
    /// By the name that the chip gives it.
    Name(String),
}

/// A line that is named in the board file, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedLine {
    /// How it is found.
    pub find: FindLine,
    /// Where the file says so.
    pub place: Range<usize>,
}

/// The line behind a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineSpec {
    /// The channel.
    pub channel: ChannelId,
    /// Place of its chip in [`GpioSpec::chips`].
    pub chip: usize,
    /// The line.
    pub line: NamedLine,
    /// Which way it goes.
    pub direction: Direction,
    /// Its pull; `None` leaves it as it is.
    pub bias: Option<Bias>,
    /// A low level is 1.
    pub active_low: bool,
    /// How long an input must keep a level before it counts, in microseconds; 0 for at once.
    pub debounce_us: u32,
    /// How an output drives.
    pub drive: Drive,
    /// What an output is driven to when safe.
    pub safe: bool,
    /// The line of the same chip that is wired to an output and reports what it really does.
    pub readback: Option<NamedLine>,
    /// The fastest pulses of which every one is reported, in Hz; `None` where nobody said.
    pub counts_hz: Option<u64>,
    /// The fastest pulses that are emitted on it, in Hz; 0 for none.
    pub pulses_hz: u64,
}
