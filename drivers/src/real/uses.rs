//! Which devices of this machine a board uses, by what they are and not by what the board file calls them.

use std::path::Path;

use super::RealSpec;
use crate::adc::{AdcKind, iio};
use crate::counter::CounterSpec;
use crate::generator::{self, GeneratorKind};
use crate::{can, counter, gpio};

/// A device of this machine that a board uses, or some lines of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Used {
    /// Its name on this machine, as in `gpiochip0`, `ttyUSB0`, `net:can0`, `spidev0.0`, `iio:device0`. It has no slash.
    pub device: String,
    /// The numbers of its lines; `None`: the device as a whole.
    pub lines: Option<Vec<u32>>,
}

impl Used {
    fn whole(device: impl Into<String>) -> Used {
        Used { device: device.into(), lines: None }
    }

    /// One of the counts of a counter; `None` where there is none now. Others of the same device are free.
    fn count(root: &Path, spec: &CounterSpec) -> Option<Used> {
        let (device, count) = counter::look(root, spec).ok()?;
        // The events of a device go to one user alone.
        let whole = !spec.events.is_empty();
        let lines = (!whole).then(|| vec![u32::from(count.number)]);
        Some(Used { device: device.number, lines })
    }

    /// The device behind a path; `None` where there is none now.
    fn behind(path: &Path) -> Option<Used> {
        let device = path.canonicalize().ok()?;
        let below = device.strip_prefix("/dev").unwrap_or(&device);
        Some(Used::whole(below.to_str()?.trim_start_matches('/').replace('/', "-")))
    }
}

/// The devices of a board that one user has at a time. What is missing is left out. So are virtual CAN buses, which are there
/// to join programs, and serial ports that the board file shares with others.
pub fn uses(spec: &RealSpec) -> Vec<Used> {
    let chips = gpio::uses(&spec.gpio).into_iter();
    let mut used: Vec<Used> =
        chips.map(|(chip, lines)| Used { device: chip.name, lines: Some(lines) }).collect();
    let exclusive = spec.serial.iter().filter(|line| line.port.exclusive);
    used.extend(exclusive.filter_map(|line| Used::behind(&line.port.path)));
    for bus in &spec.can.buses {
        let is_real = can::ask(&bus.interface).is_ok_and(|link| !link.is_virtual());
        used.extend(is_real.then(|| Used::whole(format!("net:{}", bus.interface))));
    }
    for (at, converter) in spec.converters.converters.iter().enumerate() {
        // One that no channel uses is not opened.
        if spec.converters.inputs_of(at).is_empty() {
            continue;
        }
        used.extend(match &converter.kind {
            AdcKind::Spi(spi) => Used::behind(&spi.path),
            AdcKind::Iio(spec) => {
                iio::find(Path::new("/"), spec).ok().map(|device| Used::whole(device.number))
            }
        });
    }
    for count in &spec.counters.counts {
        let counter = spec.counters.counters.get(count.counter);
        used.extend(counter.and_then(|counter| Used::count(Path::new("/"), counter)));
    }
    for (at, generator) in spec.generators.generators.iter().enumerate() {
        let outputs = spec.generators.outputs_of(at);
        if outputs.is_empty() {
            continue;
        }
        used.extend(match &generator.kind {
            GeneratorKind::Stream(stream) => Used::behind(&stream.path),
            GeneratorKind::Pwm(pwm) => generator::find(Path::new("/"), pwm).ok().map(|chip| Used {
                device: chip.name,
                lines: Some(outputs.iter().map(|output| u32::from(output.output)).collect()),
            }),
        });
    }
    // What is named twice is refused when it is opened; here it must not meet itself.
    let mut once: Vec<Used> = Vec::new();
    for device in used {
        if !once.contains(&device) {
            once.push(device);
        }
    }
    once
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_known_by_its_place_whatever_path_leads_there() {
        assert_eq!(Used::behind(Path::new("/dev/null")), Some(Used::whole("null")));
        assert_eq!(Used::behind(Path::new("/dev/../dev/./null")), Some(Used::whole("null")));
        assert_eq!(Used::behind(Path::new("/dev/nowhere")), None);
        let elsewhere = Used::behind(&std::env::temp_dir()).unwrap().device;
        assert!(!elsewhere.contains('/') && !elsewhere.is_empty(), "{elsewhere}");
    }
}
