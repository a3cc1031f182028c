//! What a board file says of generators.

use std::ops::Range;
use std::path::PathBuf;

use signal::Span;

use super::bits::{BitClock, BitLayout};
use crate::{ChannelId, PulseCapability};

/// The generators of a board, and the channels behind their outputs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GeneratorsSpec {
    /// The generators.
    pub generators: Vec<GeneratorSpec>,
    /// The outputs behind channels, in the order of the channels.
    pub outputs: Vec<OutputSpec>,
}

impl GeneratorsSpec {
    /// The generators that channels use, with their outputs. One that no channel uses may be missing: it is left alone.
    pub fn used(&self) -> impl Iterator<Item = (&GeneratorSpec, Vec<OutputSpec>)> {
        let all = self.generators.iter().enumerate().map(|(at, generator)| (generator, self.outputs_of(at)));
        all.filter(|(_, outputs)| !outputs.is_empty())
    }

    /// The outputs of a generator, by its place.
    pub fn outputs_of(&self, generator: usize) -> Vec<OutputSpec> {
        self.outputs.iter().filter(|output| output.generator == generator).cloned().collect()
    }
}

/// A device that makes pulses by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GeneratorSpec {
    /// Its name in the board file.
    pub name: String,
    /// Where the file names it.
    pub place: Range<usize>,
    /// What it is.
    pub kind: GeneratorKind,
}

/// What a generator is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GeneratorKind {
    /// The data line of an SPI bus.
    Stream(StreamSpec),
    /// Outputs of a PWM chip.
    Pwm(PwmSpec),
}

impl GeneratorKind {
    /// What it is, in a word for clients.
    pub const fn word(&self) -> &'static str {
        match self {
            GeneratorKind::Stream(_) => "spi",
            GeneratorKind::Pwm(_) => "pwm",
        }
    }

    /// What one of its outputs can emit.
    pub fn emits(&self) -> PulseCapability {
        match self {
            GeneratorKind::Stream(stream) => stream.emits(),
            GeneratorKind::Pwm(pwm) => pwm.emits(),
        }
    }
}

/// The data line of an SPI bus: a stream of bits at the clock of the bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamSpec {
    /// The device of its chip select, as in `/dev/spidev0.4`.
    pub path: PathBuf,
    /// The clock of the bus.
    pub clock: BitClock,
    /// SPI mode, 0 to 3.
    pub mode: u8,
    /// The bus sends the lowest bit of a byte first.
    pub lsb_first: bool,
    /// Bytes that are sent at once, at most.
    pub buffer: u32,
}

impl StreamSpec {
    /// How bits lie in its bytes, for an output that may be turned over.
    pub fn layout(&self, inverted: bool) -> BitLayout {
        BitLayout { lsb_first: self.lsb_first, inverted, lead: LEAD }
    }

    /// Pulses of at least a bit each, for as long as the buffer lasts.
    pub fn emits(&self) -> PulseCapability {
        let last = self.layout(false).last(u64::from(self.buffer));
        PulseCapability {
            shortest: self.clock.period(),
            longest: Span::ZERO,
            resolution: self.clock.period(),
            counted: self.clock.lasts(last),
            endless: false,
        }
    }
}

/// Bits at rest in front of a stream: wherever the bus left its line, it is at rest before the first edge.
const LEAD: u64 = 8;

/// How a PWM chip is found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FindPwm {
    /// By the name of its device, as in `fe20c000.pwm`.
    Label(String),
    /// By its name in the kernel, as in `pwmchip0`.
    Name(String),
    /// By its place in `/sys`, or that of its device; links are followed.
    Path(PathBuf),
}

/// A PWM chip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PwmSpec {
    /// How it is found.
    pub find: FindPwm,
    /// The rate of the clock that it counts periods by, where the file says so.
    pub clock: Option<BitClock>,
    /// The shortest time at one level.
    pub shortest: Span,
    /// The longest period.
    pub longest: Span,
}

impl PwmSpec {
    /// Square waves without end.
    pub fn emits(&self) -> PulseCapability {
        PulseCapability {
            shortest: self.shortest,
            longest: self.longest,
            resolution: self.clock.map_or(Span::from_nanos(1), BitClock::period),
            counted: Span::ZERO,
            endless: true,
        }
    }

    /// A time as the chip counts it: the whole number of its clock's periods that is closest, of which there is one at
    /// least; in nanoseconds, not less, so that a chip that rounds down comes to that number.
    pub fn counted(&self, time: Span) -> u64 {
        let Some(clock) = self.clock else { return u64::try_from(time.as_nanos()).unwrap_or(0) };
        let lasts = clock.lasts_at_least(clock.bit(time).max(1));
        u64::try_from(lasts.as_nanos()).unwrap_or(0)
    }
}

/// The output behind a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputSpec {
    /// The channel.
    pub channel: ChannelId,
    /// Place of its generator in [`GeneratorsSpec::generators`].
    pub generator: usize,
    /// Its number on a chip of several outputs.
    pub output: u16,
    /// Where the file says so.
    pub place: Range<usize>,
    /// A low level is 1.
    pub active_low: bool,
    /// The level at rest.
    pub safe: bool,
}
