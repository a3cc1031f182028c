//! From what a board file says to a part and its inputs.

use std::path::PathBuf;

use super::super::FindInput;
use super::codec::{Chosen, Codec};
use super::{
    ADS8684, ADS8684_MANUAL, ADS8688, ADS8688_MANUAL, MAX1110, MAX1111, MAX1112, MAX1113, MCP3004, MCP3008,
    MCP3204, MCP3208,
};
use crate::adc::SampleSpec;
use crate::codes;
use crate::refusal::Refusal;
use signal::ClockError;

/// A part that the rig can read.
pub type AdcPart = &'static dyn Codec;

/// Every part, in the order in which messages name them. A new one is added here.
pub const PARTS: [AdcPart; 10] =
    [&MCP3004, &MCP3008, &MCP3204, &MCP3208, &ADS8684, &ADS8688, &MAX1110, &MAX1111, &MAX1112, &MAX1113];

/// Those that go through their inputs by themselves, and the same given each.
const MANUAL: [(AdcPart, AdcPart); 2] = [(&ADS8684, &ADS8684_MANUAL), (&ADS8688, &ADS8688_MANUAL)];

/// A converter on an SPI bus as a board file describes it.
#[derive(Clone, Debug)]
pub struct SpiSpec {
    /// Its device, as in `/dev/spidev0.0`.
    pub path: PathBuf,
    /// What it is.
    pub part: AdcPart,
    /// Clock rate, in Hz.
    pub speed: u32,
    /// How far that may be off.
    pub clock_error: ClockError,
    /// SPI mode, 0 to 3.
    pub mode: u8,
    /// Its reference, in volts.
    pub reference: f64,
    /// Sweeps that make a reading: their mean.
    pub oversample: u16,
}

impl PartialEq for SpiSpec {
    fn eq(&self, other: &SpiSpec) -> bool {
        let key =
            |spec: &SpiSpec| (spec.path.clone(), spec.speed, spec.clock_error, spec.mode, spec.oversample);
        key(self) == key(other)
            && self.reference == other.reference
            && std::ptr::addr_eq(self.part, other.part)
    }
}

/// The part of this name; `manual` for one that is given each input. `None` where there is none, or none that can be
/// given it.
pub(crate) fn part(name: &str, manual: bool) -> Option<AdcPart> {
    let found = PARTS.into_iter().find(|part| part.name() == name)?;
    match manual {
        false => Some(found),
        true => MANUAL.into_iter().find(|(by_itself, _)| by_itself.name() == name).map(|(_, told)| told),
    }
}

/// How close a range must come to one of the part's.
const CLOSE: f64 = 0.002;

/// The input that a channel wants.
///
/// # Errors
/// The part has no such input, or not with this range.
pub fn choose(spec: &SpiSpec, sample: &SampleSpec) -> Result<Chosen, Refusal> {
    let text = match &sample.input {
        FindInput::Number(number) => number.to_string(),
        FindInput::Name(name) => name.clone(),
    };
    let part = spec.part;
    let Some(input) = part.input(&text) else {
        let pairs = if part.has_pairs() { ", and pairs such as \"0-1\"" } else { "" };
        let help = format!("the inputs of {} are 0 to {}{pairs}", part.name(), part.inputs() - 1);
        let message = format!("{} has no input `{text}`", part.name());
        return Err(Refusal::new(codes::INPUT, message, help).at(sample.place.clone()));
    };
    let spans = part.spans(input, spec.reference);
    let whole = |low: f64, high: f64| (high - low).abs() * CLOSE;
    let found = match sample.range {
        None => spans.first().copied(),
        Some((low, high)) => spans.iter().copied().find(|span| {
            let close = whole(span.low, span.high);
            (span.low - low).abs() <= close && (span.high - high).abs() <= close
        }),
    };
    found.map(|span| Chosen { input, span }).ok_or_else(|| {
        let ranges: Vec<String> = spans
            .iter()
            .map(|span| format!("\"{:.6} V .. {:.6} V\"", Short(span.low), Short(span.high)))
            .collect();
        let message = format!("{} has no such range with a reference of {} V", part.name(), spec.reference);
        let help = format!("its ranges are {}", ranges.join(", "));
        Refusal::new(codes::RANGE, message, help).at(sample.range_place.clone())
    })
}

/// A number without the zeros after its last digit.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = format!("{:.*}", f.precision().unwrap_or(6), self.0);
        f.write_str(text.trim_end_matches('0').trim_end_matches('.'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ChannelId;
    use crate::adc::Scale;
    use crate::adc::spi::SpiInput;

    fn spec(name: &str, manual: bool) -> SpiSpec {
        let part = part(name, manual).unwrap();
        let reference = part.reference().unwrap_or(3.3);
        SpiSpec {
            path: "/dev/spidev0.0".into(),
            part,
            speed: 1_000_000,
            clock_error: ClockError::NONE,
            mode: 0,
            reference,
            oversample: 1,
        }
    }

    fn sample(input: FindInput, range: Option<(f64, f64)>) -> SampleSpec {
        let scale = Scale::default();
        SampleSpec {
            channel: ChannelId(0),
            converter: 0,
            input,
            place: 1..2,
            range,
            range_place: 3..4,
            scale,
            accuracy_place: 0..0,
            certificate: None,
            certificate_place: 0..0,
        }
    }

    #[test]
    fn inputs_are_numbers_or_pairs_that_the_part_has() {
        let choose = |part: &str, input: FindInput| {
            choose(&spec(part, false), &sample(input, None)).map(|chosen| chosen.input)
        };
        assert_eq!(choose("mcp3008", FindInput::Number(7)), Ok(SpiInput::Single(7)));
        assert_eq!(choose("mcp3008", FindInput::Name("3-2".into())), Ok(SpiInput::Pair(3, 2)));
        for (part, input) in
            [("mcp3004", "4"), ("mcp3008", "1-2"), ("ads8688", "0-1"), ("mcp3008", "x"), ("mcp3008", "+1")]
        {
            let refused = choose(part, FindInput::Name(input.into())).unwrap_err();
            assert_eq!((refused.code, refused.place), (codes::INPUT, Some(1..2)), "{part} {input}");
        }
    }

    #[test]
    fn a_range_is_one_of_the_parts_own() {
        let choose = |part: &str, range| choose(&spec(part, false), &sample(FindInput::Number(1), range));
        assert_eq!(choose("ads8688", Some((0.0, 10.24))).unwrap().span.setting, 5);
        assert_eq!(choose("ads8688", None).unwrap().span.setting, 0);
        assert_eq!(choose("max1111", Some((-1.024, 1.024))).unwrap().span.setting, 0);
        let refused = choose("ads8688", Some((0.0, 3.3))).unwrap_err();
        assert_eq!((refused.code, refused.place.clone()), (codes::RANGE, Some(3..4)));
        assert!(refused.help.contains("\"-10.24 V .. 10.24 V\""), "{}", refused.help);
    }

    #[test]
    fn only_parts_with_a_sequence_can_be_told_of_each_input() {
        assert_eq!(part("ads8688", true).unwrap().name(), "ads8688");
        assert!(part("mcp3008", true).is_none() && part("mcp3000", false).is_none());
        assert_ne!(spec("ads8688", true), spec("ads8688", false));
    }
}
