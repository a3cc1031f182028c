//! Inputs that the kernel samples by itself, into a buffer with the instant of each scan.

use std::fs::File;
use std::io;
use std::os::fd::AsFd;
use std::path::{Path, PathBuf};

use host::HostInstant;
use rustix::io::Errno;
use signal::Span;

use super::element::Element;
use super::files::{FileError, read, write};
use super::find::named;
use super::info::{IioDevice, IioInput};
use super::scans::{Sampled, Scans};
use super::spec::Buffering;
use super::trigger::Trigger;
use crate::adc::{AT_ONCE, Adc, AdcPace, AdcReading, Resolution};
use crate::codes;
use crate::inventory::{line, names};
use crate::refusal::Refusal;

/// A device whose buffer is filled by a trigger.
#[derive(Debug)]
pub(super) struct BufferedAdc {
    device: String,
    /// Time between two arrivals.
    period: Span,
    node: File,
    scans: Scans,
    spread: u8,
    bytes: Vec<u8>,
    /// Of each input.
    resolutions: Vec<Resolution>,
    /// Ends with this.
    _capture: Capture,
}

/// A buffer that is being filled, until this is dropped.
#[derive(Debug)]
struct Capture {
    folder: PathBuf,
    /// Goes after the buffer that it fills.
    trigger: Trigger,
}

impl BufferedAdc {
    /// Sets the device up and lets it sample these inputs.
    pub(super) fn open(
        root: &Path,
        device: &IioDevice,
        buffering: &Buffering,
        period: Span,
        inputs: &[&IioInput],
        node: File,
    ) -> Result<BufferedAdc, Refusal> {
        let without = |what: &str| {
            let help =
                "leave `buffered`, `trigger`, `buffer` and `watermark` out: each sample is asked for then";
            Refusal::new(codes::IIO_BUFFER, format!("{} {what}", named(device)), help)
        };
        if !device.buffered {
            return Err(without("has no buffer that stamps its samples"));
        }
        let stamp = line(&device.folder.join("scan_elements/in_timestamp_type"));
        let stamp = Element::parse(&stamp).ok_or_else(|| without("has stamps that cannot be read"))?;
        let mut order = Vec::new();
        for (at, input) in inputs.iter().enumerate() {
            let (element, index) = input
                .element
                .ok_or_else(|| without(&format!("cannot put {} into its buffer", input.name)))?;
            order.push((index, Sampled::scaled(at as u16, element, input.scaling)));
        }
        order.sort_by_key(|(index, _)| *index);
        let folder = device.folder.clone();
        // A program that was killed leaves its buffer running.
        set(&folder, "buffer/enable", "0")?;
        set(&folder, "current_timestamp_clock", "monotonic")?;
        choose(&folder, inputs)?;
        let trigger = match &buffering.trigger {
            Some(name) => {
                Trigger::named(root, name).map_err(|refused| refused.at(buffering.trigger_place.clone()))?
            }
            None => Trigger::timer(root, device)?,
        };
        trigger.pace(&folder, period)?;
        let starts = trigger.starts();
        set(&folder, "trigger/current_trigger", &trigger.name)?;
        // From here on, dropping it takes everything back.
        let capture = Capture { folder, trigger };
        set(&capture.folder, "buffer/length", &buffering.length.to_string())?;
        set(&capture.folder, "buffer/watermark", &buffering.watermark.to_string())?;
        set(&capture.folder, "buffer/enable", "1")?;
        let scans =
            Scans::new(order.into_iter().map(|(_, sampled)| sampled).collect(), stamp, period, starts);
        Ok(BufferedAdc {
            device: named(device),
            period: period * i64::from(buffering.watermark),
            bytes: vec![0; scans.size() * AT_ONCE],
            node,
            scans,
            spread: buffering.spread(),
            resolutions: inputs.iter().map(|input| input.resolution()).collect(),
            _capture: capture,
        })
    }
}

impl BufferedAdc {
    /// Bytes of scans that wait; none where there are none.
    fn fetch(&mut self) -> io::Result<usize> {
        match rustix::io::read(&self.node, &mut self.bytes[..]) {
            Err(Errno::AGAIN) => Ok(0),
            other => Ok(other?),
        }
    }
}

/// Sets a file of the device.
fn set(folder: &Path, file: &str, text: &str) -> Result<(), Refusal> {
    write(&folder.join(file), text).map_err(|error| refused(&error))
}

/// What a setting that was refused means.
fn refused(error: &FileError) -> Refusal {
    if error.error.kind() == io::ErrorKind::PermissionDenied {
        return super::denied(&error.to_string());
    }
    let help = match error.error.raw_os_error() == Some(Errno::BUSY.raw_os_error()) {
        true => "somebody else has the device sample: end that program, or the driver that uses it",
        false => "`dmesg` may tell more; without `buffered` and `trigger` each sample is asked for",
    };
    Refusal::new(codes::IIO_SETTING, error.to_string(), help)
}

/// Lets these inputs, the stamp and nothing else into the buffer.
fn choose(folder: &Path, inputs: &[&IioInput]) -> Result<(), Refusal> {
    let scan = folder.join("scan_elements");
    let wanted: Vec<String> = inputs
        .iter()
        .map(|input| format!("in_{}_en", input.name))
        .chain(["in_timestamp_en".to_owned()])
        .collect();
    let switches = || names(&scan).into_iter().filter(|name| name.ends_with("_en"));
    for switch in switches().filter(|switch| !wanted.contains(switch)) {
        if line(&scan.join(&switch)) != "0" {
            set(&scan, &switch, "0")?;
        }
    }
    for switch in &wanted {
        set(&scan, switch, "1")?;
    }
    // A driver may take more inputs than it was given, or fewer.
    for switch in switches() {
        let on = read(&scan.join(&switch)).map_err(|error| refused(&error))? == "1";
        if on != wanted.contains(&switch) {
            let state = if on { "does not leave out" } else { "does not sample" };
            let message = format!("the device {state} {}", switch.trim_end_matches("_en"));
            let help = "it samples certain inputs together only: give all of them a channel, or leave `buffered` out";
            return Err(Refusal::new(codes::IIO_BUFFER, message, help));
        }
    }
    Ok(())
}

impl Adc for BufferedAdc {
    fn device(&self) -> &str {
        &self.device
    }

    fn kind(&self) -> &'static str {
        "iio"
    }

    fn pace(&self) -> AdcPace<'_> {
        AdcPace::Ready(self.node.as_fd(), self.period)
    }

    fn spread(&self) -> u8 {
        self.spread
    }

    fn begin(&mut self) -> io::Result<()> {
        while self.fetch()? == self.bytes.len() {}
        self.scans.begin();
        Ok(())
    }

    /// At most as much as one call brings: what is left can be read at once.
    fn read(&mut self, out: &mut Vec<AdcReading>) -> io::Result<()> {
        let length = self.fetch()?;
        self.scans.take(&self.bytes[..length], HostInstant::now(), out);
        Ok(())
    }

    fn lost(&self) -> u64 {
        self.scans.lost()
    }

    fn resolution(&self, input: u16) -> Resolution {
        self.resolutions.get(usize::from(input)).copied().unwrap_or_default()
    }
}

impl Drop for Capture {
    fn drop(&mut self) {
        // A device that is gone has nothing to be taken back.
        let _ = write(&self.folder.join("buffer/enable"), "0");
        // An empty name is none; a trigger that others use stays set where the kernel wants it so.
        if line(&self.folder.join("trigger/current_trigger")) == self.trigger.name {
            let _ = write(&self.folder.join("trigger/current_trigger"), "\n");
        }
    }
}
