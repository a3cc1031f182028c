//! What is reported to the rig when it cannot be guarded.

use crate::Reason;
use std::fmt;
use std::io;
use std::path::PathBuf;

/// Every code of the guard with its title, in order.
pub const CODES: &[(&str, &str)] = &[
    ("R0190", "A guard that cannot be started"),
    ("R0191", "Lines that the guard cannot drive"),
    ("R0192", "A guard that is gone"),
    ("R0193", "Outputs that the guard latched"),
    ("R0194", "A watchdog that cannot be used"),
    ("R0195", "A watchdog that could never be stopped again"),
    ("R0196", "Outputs that cannot be made safe"),
];

/// Why the outputs are not guarded.
#[derive(Debug)]
pub enum GuardError {
    /// The guard's process could not be started, or the page not be shared.
    Start(io::Error),
    /// The guard could not drive lines to their safe levels when it was given them.
    Lines {
        /// The device.
        device: String,
        /// What became of it.
        why: String,
    },
    /// The guard's process is gone or does not answer.
    Gone,
    /// The guard latched the outputs: nothing more can be driven in this run.
    Latched(Reason),
    /// The watchdog could not be opened or set.
    Watchdog {
        /// The device.
        path: PathBuf,
        /// What the kernel said.
        error: io::Error,
    },
    /// The watchdog would reset the machine after every run.
    NeverStops {
        /// The device.
        path: PathBuf,
    },
    /// Outputs did not come to their safe levels.
    Unsafe {
        /// The devices, and why.
        why: String,
    },
}

impl GuardError {
    /// Its code.
    pub fn code(&self) -> &'static str {
        match self {
            GuardError::Start(_) => "R0190",
            GuardError::Lines { .. } => "R0191",
            GuardError::Gone => "R0192",
            GuardError::Latched(_) => "R0193",
            GuardError::Watchdog { .. } => "R0194",
            GuardError::NeverStops { .. } => "R0195",
            GuardError::Unsafe { .. } => "R0196",
        }
    }

    /// What can be done about it.
    pub fn help(&self) -> String {
        match self {
            GuardError::Start(_) => {
                "look at the limits on processes, memory and descriptors (ulimit -a) and whether /proc is mounted"
                    .into()
            }
            GuardError::Lines { .. } | GuardError::Unsafe { .. } => {
                "look at the wiring and at the device's driver (dmesg); the outputs may not be safe now".into()
            }
            GuardError::Gone => {
                "look who ended it (dmesg, journalctl); the board made its outputs safe, run again".into()
            }
            GuardError::Latched(_) => {
                "the outputs are safe; find why the rig hung or died, or give it a longer [guard] limit".into()
            }
            GuardError::Watchdog { path, error } => match error.raw_os_error() {
                Some(number) if number == rustix::io::Errno::BUSY.raw_os_error() => {
                    format!("another program feeds it (fuser {}); stop that program", path.display())
                }
                Some(number) if number == rustix::io::Errno::ACCESS.raw_os_error() => {
                    "give the user of the rig access to it, with a udev rule or as root".into()
                }
                Some(number) if number == rustix::io::Errno::INVAL.raw_os_error() => {
                    "it cannot keep this time; change `bites-after` in [guard]".into()
                }
                _ => "name another watchdog in [guard], or none".into(),
            },
            GuardError::NeverStops { .. } => {
                "load its driver with nowayout=0, or leave it out of [guard]: it would reset the machine after \
                 every run"
                    .into()
            }
        }
    }
}

impl fmt::Display for GuardError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GuardError::Start(error) => write!(f, "the guard cannot be started: {error}"),
            GuardError::Lines { device, why } => write!(f, "the guard cannot drive {device}: {why}"),
            GuardError::Gone => f.write_str("the guard is gone or does not answer"),
            GuardError::Latched(reason) => write!(f, "the guard latched all outputs: {reason}"),
            GuardError::Watchdog { path, error } => {
                write!(f, "the watchdog {} cannot be used: {error}", path.display())
            }
            GuardError::NeverStops { path } => {
                write!(f, "the watchdog {} could never be stopped again", path.display())
            }
            GuardError::Unsafe { why } => write!(f, "outputs did not come to their safe levels: {why}"),
        }
    }
}

impl std::error::Error for GuardError {}

impl From<rustix::io::Errno> for GuardError {
    fn from(error: rustix::io::Errno) -> Self {
        GuardError::Start(error.into())
    }
}
