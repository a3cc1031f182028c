//! Sessions of sigrok (`.sr`), which sigrok-cli and PulseView write: an archive with `metadata`, the samples of all
//! logic channels in `logic-1-1`, `logic-1-2`, ..., and those of each analog channel in `analog-1-N-1`, ....

use crate::builder::{CaptureBuilder, FEWER, too_many_changes, too_many_channels};
use crate::time::{hertz, period as period_of};
use crate::zip::{self, ZipEntry};
use crate::{Capture, CaptureError, ChannelType, Knowledge};
use signal::{Span, Time, Value, When};
use std::collections::BTreeSet;

/// The most bytes of samples that are unpacked.
const MAX_UNPACKED: usize = 1 << 30;

/// Bytes of one sample of all logic channels.
const MAX_UNIT: usize = 8;

/// Reads a session.
///
/// # Errors
/// [`CaptureError`] with the file of the archive.
pub fn read(bytes: &[u8], period: Option<Span>) -> Result<Capture, CaptureError> {
    let entries = zip::entries(bytes)?;
    let all: usize = entries.iter().fold(0, |sum, entry| sum.saturating_add(entry.size()));
    if all > MAX_UNPACKED {
        let what = format!("more than {MAX_UNPACKED} bytes of samples");
        return Err(CaptureError::whole(what, "capture for a shorter time, or with fewer samples a second"));
    }
    let find = |name: &str| entries.iter().find(|entry| entry.name == name);
    let Some(metadata) = find("metadata") else {
        return Err(CaptureError::whole(
            "no sigrok session: it has no `metadata`",
            "save it with sigrok or PulseView",
        ));
    };
    if let Some(version) = find("version") {
        let version = version.unpack(bytes)?;
        if version.trim_ascii() != b"2" {
            let what = format!("version {} of the format", String::from_utf8_lossy(&version).trim());
            return Err(CaptureError::entry("version", what, "save it with sigrok 0.3 or later: version 2"));
        }
    }
    let text = metadata.unpack(bytes)?;
    let device = Device::read(&String::from_utf8_lossy(&text), period)?;
    let mut builder = CaptureBuilder::default();
    let mut samples = 0;
    if !device.logic.is_empty() {
        samples = device.logic_samples(bytes, &entries, &mut builder)?;
    }
    for (number, name) in &device.analog {
        let taken = device.analog_samples(bytes, &entries, (*number, name), &mut builder)?;
        samples = samples.max(taken);
    }
    let CaptureBuilder { channels, mut changes, .. } = builder;
    changes.sort_by_key(|change| change.at.latest);
    let end = device.instant(samples);
    Ok(Capture {
        channels,
        changes,
        knowledge: Knowledge::Sampled(device.period()),
        span: [Time::ZERO, Time::from_nanos(end)],
        end: When::exactly(Time::from_nanos(end)),
        notes: Vec::new(),
    })
}

/// How fast the device sampled.
#[derive(Clone, Copy, Debug)]
enum Pace {
    Rate(u64),
    Every(Span),
}

/// The device of a session.
#[derive(Debug)]
struct Device {
    pace: Pace,
    unit: usize,
    file: String,
    /// Number of the channel from 1, and its name.
    logic: Vec<(usize, String)>,
    analog: Vec<(usize, String)>,
}

impl Device {
    fn read(text: &str, period: Option<Span>) -> Result<Device, CaptureError> {
        let wrong = |what: String, fix| CaptureError::entry("metadata", what, fix);
        let mut device = Device {
            pace: Pace::Rate(0),
            unit: 1,
            file: "logic-1".into(),
            logic: Vec::new(),
            analog: Vec::new(),
        };
        let mut rate = None;
        let mut devices = 0;
        for line in text.lines().map(str::trim) {
            if line.starts_with("[device ") {
                devices += 1;
            }
            let Some((key, value)) = line.split_once('=') else { continue };
            let number = |prefix: &str| key.strip_prefix(prefix).and_then(|n| n.parse::<usize>().ok());
            if let Some(number) = number("probe") {
                device.logic.push((number, value.to_owned()));
            } else if let Some(number) = number("analog") {
                device.analog.push((number, value.to_owned()));
            }
            match key {
                "samplerate" => rate = hertz(value),
                "unitsize" => device.unit = value.parse().unwrap_or(0),
                "capturefile" => value.clone_into(&mut device.file),
                _ => {}
            }
        }
        for numbers in [&device.logic, &device.analog] {
            let mut known = BTreeSet::new();
            // The samples of a channel would be unpacked once for each of its names.
            if let Some((number, name)) = numbers.iter().find(|(number, _)| !known.insert(*number)) {
                return Err(wrong(
                    format!("`{name}` is a second channel {number}"),
                    "save it with sigrok or PulseView",
                ));
            }
        }
        if devices > 1 {
            return Err(wrong(format!("{devices} devices"), "save one device alone"));
        }
        if !(1..=MAX_UNIT).contains(&device.unit) {
            return Err(wrong(
                format!("`unitsize` is not 1 to {MAX_UNIT}"),
                "sessions have up to 64 logic channels",
            ));
        }
        if device.logic.iter().any(|(number, _)| *number == 0 || *number > device.unit * 8) {
            return Err(wrong("a channel is outside of the samples' bits".into(), "save it again"));
        }
        device.pace = match (period, rate) {
            (Some(period), _) => Pace::Every(period),
            (None, Some(rate)) => Pace::Rate(rate),
            (None, None) => {
                return Err(wrong(
                    "no `samplerate`".into(),
                    "say the time between two samples with --period",
                ));
            }
        };
        Ok(device)
    }

    /// When a sample was taken, nanoseconds.
    fn instant(&self, sample: u64) -> i64 {
        let nanos = match self.pace {
            Pace::Rate(rate) => (u128::from(sample) * 1_000_000_000).div_ceil(u128::from(rate.max(1))),
            Pace::Every(period) => u128::from(sample) * u128::from(period.as_nanos().unsigned_abs()),
        };
        i64::try_from(nanos).unwrap_or(i64::MAX)
    }

    fn period(&self) -> Span {
        match self.pace {
            Pace::Rate(rate) => period_of(rate),
            Pace::Every(period) => period,
        }
    }

    /// Between the sample before and this one; at the first one exactly.
    fn when(&self, sample: u64) -> When {
        let latest = self.instant(sample);
        let earliest = if sample == 0 { latest } else { latest.saturating_sub(self.period().as_nanos()) };
        When::within(Time::from_nanos(earliest), Time::from_nanos(latest))
    }

    fn logic_samples(
        &self,
        bytes: &[u8],
        entries: &[ZipEntry],
        builder: &mut CaptureBuilder,
    ) -> Result<u64, CaptureError> {
        let mut channels = Vec::new();
        for (number, name) in &self.logic {
            let channel = builder.channel(name, "", ChannelType::Bit);
            let channel = channel.ok_or_else(|| CaptureError::whole(too_many_channels(), "save fewer"))?;
            channels.push((number - 1, channel));
        }
        let (mut sample, mut last) = (0u64, None);
        for entry in parts(entries, &self.file) {
            let data = entry.unpack(bytes)?;
            if data.len() % self.unit != 0 {
                return Err(CaptureError::entry(&entry.name, "it ends within a sample", "save it again"));
            }
            for unit in data.chunks_exact(self.unit) {
                let word = unit.iter().rev().fold(0u64, |word, byte| word << 8 | u64::from(*byte));
                if last != Some(word) {
                    for (bit, channel) in &channels {
                        let value = Value::Bool(word >> bit & 1 == 1);
                        if !builder.change(*channel, self.when(sample), value) {
                            return Err(CaptureError::entry(&entry.name, too_many_changes(), FEWER));
                        }
                    }
                    last = Some(word);
                }
                sample += 1;
            }
        }
        Ok(sample)
    }

    fn analog_samples(
        &self,
        bytes: &[u8],
        entries: &[ZipEntry],
        (number, name): (usize, &str),
        builder: &mut CaptureBuilder,
    ) -> Result<u64, CaptureError> {
        let channel = builder.channel(name, "", ChannelType::Real);
        let channel = channel.ok_or_else(|| CaptureError::whole(too_many_channels(), "save fewer"))?;
        let mut sample = 0;
        for entry in parts(entries, &format!("analog-1-{number}")) {
            for bytes in entry.unpack(bytes)?.chunks_exact(4) {
                let real = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                let value = if real.is_finite() { Value::Real(f64::from(real)) } else { Value::Unknown };
                if !builder.change(channel, self.when(sample), value) {
                    return Err(CaptureError::entry(&entry.name, too_many_changes(), FEWER));
                }
                sample += 1;
            }
        }
        Ok(sample)
    }
}

/// The parts of a stream of samples, `NAME-1`, `NAME-2`, ..., in order.
fn parts<'a>(entries: &'a [ZipEntry], name: &str) -> Vec<&'a ZipEntry> {
    let number = |entry: &ZipEntry| entry.name.strip_prefix(name)?.strip_prefix('-')?.parse::<u64>().ok();
    let mut parts: Vec<(u64, &ZipEntry)> =
        entries.iter().filter_map(|entry| Some((number(entry)?, entry))).collect();
    parts.sort_by_key(|(number, _)| *number);
    parts.into_iter().map(|(_, entry)| entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_that_of_one_channel() {
        let session =
            |analog: &str| format!("[device 1]\nsamplerate=1 kHz\ntotal analog=2\nanalog1=a\n{analog}=b\n");
        assert!(Device::read(&session("analog2"), None).is_ok());
        let error = Device::read(&session("analog01"), None).unwrap_err();
        assert!(error.to_string().contains("`b` is a second channel 1"), "{error}");
    }
}
