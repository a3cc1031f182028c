//! What a part on an SPI bus is asked, and what its answers mean.

use std::fmt::Debug;

/// The longest frame: bytes between two edges of the chip select.
pub const FRAME: usize = 4;

/// The bytes of a frame.
pub type Bytes = [u8; FRAME];

/// An input of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SpiInput {
    /// Against ground.
    Single(u8),
    /// The first against the second.
    Pair(u8, u8),
}

/// What an input can take, in volts, and the codes that its ends have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Its lower end: code 0.
    pub low: f64,
    /// Its upper end: the code after the last one.
    pub high: f64,
    /// How the part is asked for it.
    pub setting: u8,
}

/// An input as a board wants it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chosen {
    /// The input.
    pub input: SpiInput,
    /// What it is to take.
    pub span: Span,
}

/// A frame of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// What is sent, as long as [`Codec::frame`].
    pub send: Bytes,
    /// The input, by its place, whose code the answer carries.
    pub gives: Option<usize>,
    /// What the answer has to be, where it carries none: bits that count, and their values.
    pub expects: Option<(Bytes, Bytes)>,
}

impl Frame {
    /// A frame whose answer says nothing.
    pub const fn telling(send: Bytes) -> Frame {
        Frame { send, gives: None, expects: None }
    }
}

/// A part: a page of code adds one. Nothing here touches a bus, so that all of it is tested without.
pub trait Codec: Debug + Send + Sync {
    /// What board files call it.
    fn name(&self) -> &'static str;

    /// The SPI modes that it works with; the first is used where the board file names none.
    fn modes(&self) -> &'static [u8];

    /// The fastest clock that it is sure to follow, in Hz.
    fn fastest(&self) -> u32;

    /// Its own reference, in volts; `None` where the board has to give it one.
    fn reference(&self) -> Option<f64>;

    /// How many inputs it has.
    fn inputs(&self) -> u8;

    /// Whether it can compare its input with the other of its pair.
    fn has_pairs(&self) -> bool;

    /// What an input can take, by the reference; the first is used where the board file names none.
    fn spans(&self, input: SpiInput, reference: f64) -> Vec<Span>;

    /// Bits of a code.
    fn bits(&self) -> u8;

    /// Bytes of a frame, at most [`FRAME`].
    fn frame(&self) -> usize;

    /// Frames that set it up for these inputs, once, each a transfer of its own. Those that expect something prove that
    /// the part is there and was understood.
    fn setup(&self, inputs: &[Chosen]) -> Vec<Frame> {
        let _ = inputs;
        Vec::new()
    }

    /// The frames of a sweep over these inputs.
    fn sweep(&self, inputs: &[Chosen]) -> Vec<Frame>;

    /// The code in an answer, from 0 for the lower end of the input's span. `None` for an answer that the part cannot
    /// give.
    fn code(&self, chosen: &Chosen, answer: &Bytes) -> Option<u32>;
}

impl dyn Codec {
    /// The input of this number, or of a name such as `0-1`: the first against the second.
    pub fn input(&self, text: &str) -> Option<SpiInput> {
        let number = |text: &str| -> Option<u8> {
            let plain = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
            plain.then(|| text.parse().ok()).flatten().filter(|number| *number < self.inputs())
        };
        match text.split_once('-') {
            None => number(text).map(SpiInput::Single),
            Some((plus, minus)) => {
                let (plus, minus) = (number(plus)?, number(minus)?);
                (self.has_pairs() && plus ^ 1 == minus).then_some(SpiInput::Pair(plus, minus))
            }
        }
    }

    /// The highest code.
    pub fn highest(&self) -> u32 {
        (1 << self.bits()) - 1
    }
}

impl SpiInput {
    /// The number of the input, or of the first of a pair.
    pub fn number(self) -> u8 {
        match self {
            SpiInput::Single(number) | SpiInput::Pair(number, _) => number,
        }
    }
}
