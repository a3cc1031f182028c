//! Which device a path leads to, and who holds it.

use std::fs;
use std::io::Read;
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

/// A process that has a device open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    /// Its number.
    pub process: u32,
    /// Its name, as `ps` shows it.
    pub name: String,
}

impl std::fmt::Display for Holder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} (process {})", self.name, self.process)
    }
}

/// Who has a device open, but this process; those whom this user may see.
pub fn holders(path: &Path) -> Vec<Holder> {
    let own = std::process::id();
    let mut all = all_holders(path);
    all.retain(|holder| holder.process != own);
    all
}

/// Who has a device open; those whom this user may see.
pub(super) fn all_holders(path: &Path) -> Vec<Holder> {
    let Ok(about) = fs::metadata(path) else { return Vec::new() };
    let open = |process: &u32| {
        let files = fs::read_dir(format!("/proc/{process}/fd")).into_iter().flatten().flatten();
        files
            .filter_map(|file| fs::metadata(file.path()).ok())
            .any(|file| file.file_type().is_char_device() && file.rdev() == about.rdev() && about.rdev() != 0)
    };
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    let mut all: Vec<Holder> = processes
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .filter(open)
        .map(|process| {
            let name = fs::read_to_string(format!("/proc/{process}/comm")).unwrap_or_default();
            Holder { process, name: name.trim().to_owned() }
        })
        .collect();
    let locked = fs::canonicalize(path).ok().and_then(|device| lock(Path::new("/run/lock"), &device));
    all.extend(locked.filter(|holder| all.iter().all(|other| other.process != holder.process)));
    all.sort_by_key(|holder| holder.process);
    all
}

/// Who has locked a device by a file that old terminal programs agree on (Filesystem Hierarchy Standard, 5.9): it holds the
/// number of a process, in ten columns. One whose process is no more means nothing.
fn lock(folder: &Path, device: &Path) -> Option<Holder> {
    let file = folder.join(format!("LCK..{}", device.file_name()?.to_str()?));
    let mut text = String::new();
    // Whatever else lies there under this name is not read to its end.
    fs::File::open(file).ok()?.take(64).read_to_string(&mut text).ok()?;
    let process: u32 = text.split_whitespace().next()?.parse().ok()?;
    let name = fs::read_to_string(format!("/proc/{process}/comm")).ok()?;
    Some(Holder { process, name: name.trim().to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_file_names_its_process_while_that_lives() {
        let folder = std::env::temp_dir().join(format!("locks-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let device = Path::new("/dev/ttyS9");
        let with = |text: &str| {
            fs::write(folder.join("LCK..ttyS9"), text).unwrap();
            lock(&folder, device).map(|holder| holder.process)
        };
        assert_eq!(lock(&folder, device), None);
        let own = std::process::id();
        assert_eq!(with(&format!("{own:>10}\n")), Some(own));
        assert_eq!(with(&format!("{own:>10} minicom root\n")), Some(own));
        // Numbers of processes end far below this.
        for text in ["4294967295\n", "", "\n", "minicom", "-1"] {
            assert_eq!(with(text), None, "{text}");
        }
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn what_is_no_device_has_neither_identity_nor_holders() {
        assert_eq!(Identity::of(Path::new("/dev/nowhere")), None);
        assert_eq!(Identity::of(&std::env::temp_dir()), None);
        assert_eq!(holders(Path::new("/dev/nowhere")), []);
        // A device without a place in the machine is its path.
        assert_eq!(Identity::of(Path::new("/dev/null")), Some(Identity::Path("/dev/null".into())));
    }
}
