//! What a board file says of converters.

use super::{Accuracy, Certificate, Noise, Scale, iio, spi};
use crate::ChannelId;
use signal::{Coverage, Span};
use std::ops::Range;

/// The converters of a board, and the channels behind their inputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AdcsSpec {
    /// The converters.
    pub converters: Vec<AdcSpec>,
    /// The inputs behind channels, in the order of the channels.
    pub samples: Vec<SampleSpec>,
}

impl AdcsSpec {
    /// The converters that channels use, with their inputs. One that no channel uses may be missing: it is left alone.
    pub fn used(&self) -> impl Iterator<Item = (&AdcSpec, Vec<SampleSpec>)> {
        let all = self.converters.iter().enumerate().map(|(at, converter)| (converter, self.inputs_of(at)));
        all.filter(|(_, inputs)| !inputs.is_empty())
    }

    /// The inputs of a converter, by its place.
    pub fn inputs_of(&self, converter: usize) -> Vec<SampleSpec> {
        self.samples.iter().filter(|sample| sample.converter == converter).cloned().collect()
    }
}

impl AdcsSpec {
    /// What the uncertainty of a channel's values covers: its accuracy as the file states it, and the noise of its readings
    /// where a reading is a mean of several.
    pub fn coverage_of(&self, sample: &SampleSpec) -> Vec<Coverage> {
        let Accuracy { of_value, of_range, plus, coverage } = sample.scale.accuracy;
        let stated = (of_value + of_range + plus > 0.0).then_some(coverage);
        let kind = self.converters.get(sample.converter).map(|converter| &converter.kind);
        let noise = match kind {
            Some(AdcKind::Spi(spi)) if spi.oversample > 1 => Some(Noise::coverage()),
            _ => None,
        };
        stated.into_iter().chain(noise).collect()
    }
}

/// A converter.
#[derive(Clone, Debug, PartialEq)]
pub struct AdcSpec {
    /// Its name in the board file.
    pub name: String,
    /// Where the file names it.
    pub place: Range<usize>,
    /// Time between two readings of an input.
    pub period: Span,
    /// What it is.
    pub kind: AdcKind,
}

impl AdcSpec {
    /// The longest time between the beginning of one sample of an input and the end of the next that is not reported as a
    /// loss.
    pub fn longest(&self) -> Span {
        let spread = match &self.kind {
            AdcKind::Iio(iio::IioSpec { buffered: Some(buffering), .. }) => buffering.spread(),
            AdcKind::Iio(_) | AdcKind::Spi(_) => SPREAD,
        };
        longest(self.period, spread)
    }
}

/// How many periods may pass there of a converter that is asked.
pub const SPREAD: u8 = 2;

/// So many periods.
pub(super) fn longest(period: Span, spread: u8) -> Span {
    Span::from_nanos(period.as_nanos().saturating_mul(i64::from(spread)))
}

/// What a converter is.
#[derive(Clone, Debug, PartialEq)]
pub enum AdcKind {
    /// On an SPI bus, read by the rig.
    Spi(spi::SpiSpec),
    /// One that the kernel has a driver for.
    Iio(iio::IioSpec),
}

/// How an input is found on its converter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FindInput {
    /// By its number.
    Number(u16),
    /// By its name.
    Name(String),
}

/// The input behind a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleSpec {
    /// The channel.
    pub channel: ChannelId,
    /// Place of its converter in [`AdcsSpec::converters`].
    pub converter: usize,
    /// The input.
    pub input: FindInput,
    /// Where the file says so.
    pub place: Range<usize>,
    /// What its input is to take, in volts, lowest first; what the converter takes by itself if left out.
    pub range: Option<(f64, f64)>,
    /// Where the file says so.
    pub range_place: Range<usize>,
    /// What the channel shows of it.
    pub scale: Scale,
    /// Where the file says how exact it is.
    pub accuracy_place: Range<usize>,
    /// What its calibration rests on, if it has one.
    pub certificate: Option<Certificate>,
    /// Where the file says so.
    pub certificate_place: Range<usize>,
}
