//! What a path of a board file is the device of, without opening it: opening a port can move its lines.

use std::fs;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::Path;

use rustix::fs::{major, minor};

/// The subsystem of the kernel that a path is a device of, such as `tty` or `spidev`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum DeviceFile {
    /// It is none, or is not there: a file, a folder, a pipe.
    None,
    /// It is a device; of what the machine does not say.
    Unknown,
    /// It is a device of this subsystem.
    Of(String),
}

/// Looks at a path.
pub(crate) fn device_file(path: &Path) -> DeviceFile {
    let Ok(about) = fs::metadata(path) else { return DeviceFile::None };
    if !about.file_type().is_char_device() {
        return DeviceFile::None;
    }
    let number = about.rdev();
    let subsystem = format!("/sys/dev/char/{}:{}/subsystem", major(number), minor(number));
    let subsystem = fs::read_link(subsystem).ok();
    let name = subsystem.as_deref().and_then(Path::file_name).and_then(|name| name.to_str());
    name.map_or(DeviceFile::Unknown, |name| DeviceFile::Of(name.to_owned()))
}

impl DeviceFile {
    /// Whether it can be a device of this subsystem.
    pub(crate) fn may_be(&self, subsystem: &str) -> bool {
        match self {
            DeviceFile::None => false,
            DeviceFile::Unknown => true,
            DeviceFile::Of(name) => name == subsystem,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_no_device_and_a_device_is_of_one_subsystem() {
        let kind = |path: &str| device_file(Path::new(path));
        assert_eq!(
            (kind("/proc/self/exe"), kind("/"), kind("/nowhere")),
            (DeviceFile::None, DeviceFile::None, DeviceFile::None)
        );
        let null = kind("/dev/null");
        assert!(null.may_be("mem") && (!null.may_be("tty") || null == DeviceFile::Unknown));
    }
}
