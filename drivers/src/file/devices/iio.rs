//! What a board file says of a converter that the kernel has a driver for.

use std::path::PathBuf;

use document::{Entry, Fields, Findings};

use super::codes;
use crate::adc::SampleSpec;
use crate::adc::iio::{Buffering, FindDevice, IioSpec, MAX_BUFFER};

/// Scans that the kernel keeps, where the board file does not say.
const BUFFER: i64 = 1024;

/// Keys that only a converter on an SPI bus has, and those that only one with a driver of the kernel has.
const OF_SPI: &[&str] = &["part", "speed", "clock-error", "mode", "reference", "oversample", "sequence"];
pub(super) const OF_IIO: &[&str] = &["name", "label", "buffered", "trigger", "buffer", "watermark"];

/// The keys of a converter of `kind = "iio"`.
pub(super) fn iio(entry: &Entry, fields: &Fields, out: &mut Findings) -> Option<IioSpec> {
    for entry in OF_SPI.iter().filter_map(|key| fields.entry(key)) {
        let message = format!("a converter that the kernel reads has no `{}`", entry.key);
        out.error(codes::IIO_KEYS, entry.key_span.clone(), message, "remove it: its driver sees to that");
    }
    let find = match (fields.text("name"), fields.text("label"), fields.text("path")) {
        (Some(name), None, None) => FindDevice::Name(name.to_owned()),
        (None, Some(label), None) => FindDevice::Label(label.to_owned()),
        (None, None, Some(path)) => FindDevice::Path(PathBuf::from(path)),
        _ => {
            let message = format!("the converter `{}` needs one of `name`, `label` and `path`", entry.key);
            let help = "take `name`, which its driver gives it: `rig board scan` shows those of this machine";
            out.error(codes::IIO_KEYS, entry.key_span.clone(), message, help);
            return None;
        }
    };
    let on = match (fields.boolean("buffered"), fields.has("trigger")) {
        (Some(false), true) => {
            let place = fields.entry("trigger").map_or(0..0, |entry| entry.key_span.clone());
            let help = "remove `trigger`, or `buffered = false`";
            out.error(codes::IIO_KEYS, place, "samples that are asked for have no trigger", help);
            return None;
        }
        (on, trigger) => on.unwrap_or(false) || trigger,
    };
    if !on {
        for entry in ["buffer", "watermark"].iter().filter_map(|key| fields.entry(key)) {
            let message = format!("samples that are asked for have no `{}`", entry.key);
            let help = "add `buffered = true`, so that the device samples by itself, or remove it";
            out.error(codes::IIO_KEYS, entry.key_span.clone(), message, help);
        }
        return Some(IioSpec { find, buffered: None });
    }
    let (length, watermark) =
        (fields.integer("buffer").unwrap_or(BUFFER), fields.integer("watermark").unwrap_or(1));
    if watermark > length {
        let node = fields.get("watermark").or_else(|| fields.get("buffer"))?;
        let message = format!("{watermark} scans never are in a buffer of {length}");
        out.bad(codes::IIO_KEYS, node, message, "make `watermark` smaller, or `buffer` larger");
        return None;
    }
    let of_trigger = fields.get("trigger");
    Some(IioSpec {
        find,
        buffered: Some(Buffering {
            trigger: fields.text("trigger").map(str::to_owned),
            trigger_place: of_trigger.map_or(0..0, |node| node.span.clone()),
            length: u32::try_from(length).unwrap_or(MAX_BUFFER),
            watermark: u32::try_from(watermark).unwrap_or(1),
        }),
    })
}

/// Looks whether channels want something of their inputs that only the device's driver sets.
pub(super) fn inputs(samples: &[SampleSpec], out: &mut Findings) {
    for sample in samples.iter().filter(|sample| sample.range.is_some()) {
        let help = "remove it: what the input takes is set by its driver, in the device's files in /sys";
        out.error(
            codes::IIO_KEYS,
            sample.range_place.clone(),
            "the rig sets no range of this converter",
            help,
        );
    }
}
