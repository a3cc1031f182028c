//! Converters on an SPI bus in a board file.

use document::{Entry, Fields, Findings};
use signal::Span;

use super::iio::OF_IIO;
use super::{codes, number};
use crate::adc::spi::{SpiSpec, Sweep, choose, part};
use crate::adc::{AdcSpec, SampleSpec};
use crate::file::clock::of_device;

/// A clock rate that hardly any wiring is too long for.
const USUAL: u32 = 1_000_000;

/// The converter of a table. What is wrong with it is reported.
pub(super) fn spi(entry: &Entry, fields: &Fields, out: &mut Findings) -> Option<SpiSpec> {
    for entry in OF_IIO.iter().filter_map(|key| fields.entry(key)) {
        let message = format!("a converter on an SPI bus has no `{}`", entry.key);
        let help = "remove it, or write kind = \"iio\"";
        out.error(codes::CONVERTER_VALUE, entry.key_span.clone(), message, help);
    }
    let mut lacks = |key: &str, help: &str| {
        let message = format!("the converter `{}` has no `{key}`", entry.key);
        out.error(codes::CONVERTER_VALUE, entry.key_span.clone(), message, help);
    };
    let path = fields.text("path");
    if path.is_none() {
        lacks("path", "add the device of its chip select, as in path = \"/dev/spidev0.0\"");
    }
    let name = fields.text("part");
    if name.is_none() {
        lacks("part", "add what it is, as in part = \"mcp3008\"");
    }
    let (path, name) = (path?, name?);
    let manual = fields.text("sequence") == Some("manual");
    let Some(part) = part(name, manual) else {
        let node = fields.get(if manual { "sequence" } else { "part" })?;
        let help = "remove it: every frame names its input";
        out.bad(codes::CONVERTER_VALUE, node, format!("{name} has no sequence of its own"), help);
        return None;
    };
    let own = part.reference();
    let reference = match fields.get("reference") {
        Some(node) => Some(number::quantity(node, "V", out)?),
        None => own,
    };
    if reference.is_none_or(|volts| volts <= 0.0) {
        let place = fields.get("reference").map_or(entry.key_span.clone(), |node| node.span.clone());
        let message = format!("{name} measures against a reference, of which nothing is said");
        out.error(codes::CONVERTER_VALUE, place, message, "add its voltage, as in reference = \"3.3 V\"");
        return None;
    }
    let speed = match fields.get("speed") {
        None => Some(USUAL.min(part.fastest())),
        Some(node) => {
            let speed = number::quantity(node, "Hz", out)?;
            let fits = speed >= 1.0 && speed <= f64::from(part.fastest());
            if !fits {
                let help = format!("write a rate up to {} Hz", part.fastest());
                out.bad(codes::CONVERTER_VALUE, node, format!("{name} follows no such clock"), help);
            }
            fits.then_some(speed as u32)
        }
    };
    let modes = part.modes();
    let mode = fields.integer("mode").map_or(modes.first().copied(), |mode| u8::try_from(mode).ok());
    if let Some(node) = fields.get("mode").filter(|_| mode.is_none_or(|mode| !modes.contains(&mode))) {
        let modes: Vec<String> = modes.iter().map(u8::to_string).collect();
        let help = format!("its modes are {}", modes.join(" and "));
        out.bad(codes::CONVERTER_VALUE, node, format!("{name} does not work in this SPI mode"), help);
        return None;
    }
    let oversample = fields.integer("oversample").map_or(Some(1), |count| u16::try_from(count).ok());
    Some(SpiSpec {
        path: path.into(),
        part,
        speed: speed?,
        clock_error: of_device(fields, out),
        mode: mode?,
        reference: reference?,
        oversample: oversample?,
    })
}

/// Looks whether the part has the inputs that channels want of it, and the time to read them.
pub(super) fn inputs(converter: &AdcSpec, spec: &SpiSpec, samples: &[SampleSpec], out: &mut Findings) {
    let mut chosen = Vec::new();
    for sample in samples {
        match choose(spec, sample) {
            Ok(input) => chosen.push(input),
            Err(refusal) => {
                let found = refusal.finding(out.file(), converter.place.clone());
                out.push(found);
            }
        }
    }
    let frames = Sweep::new(spec.part, chosen).frames().len();
    let bits = (frames * usize::from(spec.oversample) * spec.part.frame() * 8) as i64;
    let takes = Span::from_nanos(bits.saturating_mul(1_000_000_000) / i64::from(spec.speed.max(1)));
    if !samples.is_empty() && takes >= converter.period {
        let message = format!("reading `{}` takes {takes} on the bus, more than its period", converter.name);
        let help = "take a longer `period`, a faster clock by `speed`, or fewer samples by `oversample`";
        out.error(codes::CONVERTER_VALUE, converter.place.clone(), message, help);
    }
}
