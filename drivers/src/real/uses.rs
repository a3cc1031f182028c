//! Which devices of this machine a board uses, by what they are and not by what the board file calls them.

use std::path::Path;

use super::RealSpec;

/// A device of this machine that a board uses, or some lines of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Used {
    /// Its name on this machine, as in `gpiochip0`, `ttyUSB0`, `net:can0`, `spidev0.0`, `iio:device0`. It has no slash.
    pub device: String,
    /// The numbers of its lines; `None`: the device as a whole.
    pub lines: Option<Vec<u32>>,
}

impl Used {
    /// A device as a whole.
    pub fn whole(device: impl Into<String>) -> Used {
        Used { device: device.into(), lines: None }
    }

    /// The device behind a path; `None` where there is none now.
    pub fn behind(path: &Path) -> Option<Used> {
        let device = path.canonicalize().ok()?;
        let below = device.strip_prefix("/dev").unwrap_or(&device);
        Some(Used::whole(below.to_str()?.trim_start_matches('/').replace('/', "-")))
    }
}

/// The devices of a board that one user has at a time, each once. What is missing is left out.
pub fn uses(spec: &RealSpec) -> Vec<Used> {
    // What is named twice is refused when it is opened; here it must not meet itself.
    let mut once: Vec<Used> = Vec::new();
    for device in spec.devices.iter().flat_map(|devices| devices.occupies()) {
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
