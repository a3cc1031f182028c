//! Which device a path leads to.

use std::fs;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};

use rustix::fs::{major, minor};

/// What a serial port is, beyond the name that it has today.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Identity {
    /// A USB adapter with a serial number: it is the same one in any socket. Vendor, product, serial number, and the
    /// number of the interface of an adapter with several ports.
    Usb {
        /// Vendor and product, as in `0403:6001`.
        kind: String,
        /// Its serial number.
        serial: String,
        /// Which of its interfaces.
        interface: String,
    },
    /// Any other port: the place in the machine where it is plugged or soldered in.
    Place(PathBuf),
    /// The kernel does not say; its path is all that is known.
    Path(PathBuf),
}

impl Identity {
    /// Of the port behind a path; `None` where there is none now.
    pub fn of(path: &Path) -> Option<Identity> {
        let device = fs::canonicalize(path).ok()?;
        let about = fs::metadata(&device).ok()?;
        if !about.file_type().is_char_device() {
            return None;
        }
        let number = (major(about.rdev()), minor(about.rdev()));
        let link = format!("/sys/dev/char/{}:{}/device", number.0, number.1);
        let Ok(place) = fs::canonicalize(link) else { return Some(Identity::Path(device)) };
        Some(usb(&place).unwrap_or(Identity::Place(place)))
    }
}

/// The USB adapter that a device is part of, if it has a serial number.
fn usb(place: &Path) -> Option<Identity> {
    let read =
        |folder: &Path, name| fs::read_to_string(folder.join(name)).ok().map(|text| text.trim().to_owned());
    let interface = place.ancestors().find_map(|folder| read(folder, "bInterfaceNumber"))?;
    let adapter = place.ancestors().find(|folder| folder.join("idVendor").exists())?;
    let serial = read(adapter, "serial").filter(|serial| !serial.is_empty())?;
    let kind = format!("{}:{}", read(adapter, "idVendor")?, read(adapter, "idProduct")?);
    Some(Identity::Usb { kind, serial, interface })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_device_has_no_identity() {
        assert_eq!(Identity::of(Path::new("/dev/nowhere")), None);
        assert_eq!(Identity::of(&std::env::temp_dir()), None);
        // A device without a place in the machine is its path.
        assert_eq!(Identity::of(Path::new("/dev/null")), Some(Identity::Path("/dev/null".into())));
    }
}
