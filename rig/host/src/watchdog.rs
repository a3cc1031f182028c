//! The kernel's watchdog: a clock that resets the machine unless somebody winds it in time.

use signal::Span;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::os::fd::AsRawFd;
use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt};
use std::path::Path;

/// WDIOC_SETTIMEOUT of `linux/watchdog.h`: `_IOWR('W', 6, int)`.
const SET_TIMEOUT: libc::c_ulong = 0xC004_5706;
/// WDIOC_GETBOOTSTATUS: `_IOR('W', 2, int)`.
const GET_BOOT_STATUS: libc::c_ulong = 0x8004_5702;
/// WDIOF_CARDRESET: the last reset of the machine was the watchdog's.
const CARD_RESET: i32 = 0x20;
/// The major and minor number of `/dev/watchdog`, which is another name of `watchdog0`.
const MISC_WATCHDOG: (u32, u32) = (10, 130);

/// An open watchdog: it runs from its opening, and dropping it does not stop it.
#[derive(Debug)]
pub struct WatchdogDevice {
    device: File,
    timeout: Span,
}

impl WatchdogDevice {
    /// Opens the device, which starts it, and lets it bite `timeout` (whole seconds, at least 1) after the last
    /// feeding. The device may grant another time: [`WatchdogDevice::timeout`].
    ///
    /// # Errors
    /// What the kernel says: EBUSY where another program feeds it; EINVAL for a time that it cannot keep.
    pub fn open(path: &Path, timeout: Span) -> io::Result<WatchdogDevice> {
        // A pipe would wait for its reader: what is no device is refused at once.
        let flags = libc::O_CLOEXEC | libc::O_NONBLOCK;
        let device = OpenOptions::new().write(true).custom_flags(flags).open(path)?;
        if !device.metadata()?.file_type().is_char_device() {
            return Err(io::Error::from_raw_os_error(libc::ENOTTY));
        }
        let seconds = i32::try_from(timeout.as_nanos() / 1_000_000_000).unwrap_or(i32::MAX).max(1);
        let mut dog = WatchdogDevice { device, timeout };
        match dog.number(SET_TIMEOUT, seconds) {
            Ok(granted) => dog.timeout = Span::from_secs(i64::from(granted)),
            Err(error) => {
                // What was started for nothing is stopped again, as far as it can be.
                let _ = dog.stop();
                return Err(error);
            }
        }
        Ok(dog)
    }

    /// How long after the last feeding it bites.
    pub fn timeout(&self) -> Span {
        self.timeout
    }

    /// Winds it.
    ///
    /// # Errors
    /// What the kernel says.
    pub fn feed(&self) -> io::Result<()> {
        (&self.device).write_all(b"\0")
    }

    /// Stops it; a device that cannot be stopped bites later.
    ///
    /// # Errors
    /// What the kernel says.
    pub fn stop(self) -> io::Result<()> {
        (&self.device).write_all(b"V")
    }

    /// Whether the last reset of the machine was this watchdog's.
    ///
    /// # Errors
    /// What the kernel says.
    pub fn has_bitten(&self) -> io::Result<bool> {
        Ok(self.number(GET_BOOT_STATUS, 0)? & CARD_RESET != 0)
    }

    /// A call that takes and gives a number.
    #[allow(unsafe_code)]
    fn number(&self, call: libc::c_ulong, number: i32) -> io::Result<i32> {
        let mut number: libc::c_int = number;
        // SAFETY: both calls read and write one int, which lives for the whole call.
        match unsafe { libc::ioctl(self.device.as_raw_fd(), call as _, &raw mut number) } {
            -1 => Err(io::Error::last_os_error()),
            _ => Ok(number),
        }
    }
}

/// Whether a watchdog, once started, can never be stopped again (`nowayout`), asked without starting it; `None`
/// where the kernel does not say.
pub fn never_stops(path: &Path) -> Option<bool> {
    let device = std::fs::metadata(path).ok()?.rdev();
    let (major, minor) = (rustix::fs::major(device), rustix::fs::minor(device));
    let about = match (major, minor) {
        MISC_WATCHDOG => "/sys/class/watchdog/watchdog0/nowayout".to_owned(),
        _ => format!("/sys/dev/char/{major}:{minor}/nowayout"),
    };
    Some(std::fs::read_to_string(about).ok()?.trim() == "1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_watchdog_is_refused_and_nothing_is_written_to_it() {
        let path = std::env::temp_dir().join(format!("no-watchdog-{}", std::process::id()));
        std::fs::write(&path, "as it was").unwrap();
        let error = WatchdogDevice::open(&path, Span::from_secs(10)).unwrap_err();
        assert_eq!(error.raw_os_error(), Some(libc::ENOTTY));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "as it was");
        std::fs::remove_file(&path).unwrap();
        assert!(WatchdogDevice::open(Path::new("/dev/null"), Span::from_secs(10)).is_err());
        assert_eq!(never_stops(Path::new("/dev/null")), None);
    }
}
