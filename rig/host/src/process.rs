//! What a whole process does to be on time: memory that stays in place, processors that stay awake.

use crate::refused::{Privilege, Refused};
use rustix::io::Errno;
use rustix::mm::{MlockAllFlags, mlockall, munlockall};
use rustix::process::{Pid, Resource, Signal, getrlimit, kill_process};
use std::fs::File;
use std::io::Write;
use std::process::Child;

/// CAP_IPC_LOCK in the bits of a capability set.
const IPC_LOCK: u32 = 14;

/// Where a wish for processors that wake fast is written; it holds while the file is open.
const LATENCY: &str = "/dev/cpu_dma_latency";

/// The process is ready to be on time, until this is dropped.
#[derive(Debug)]
pub struct Punctual {
    locked: bool,
    awake: Option<File>,
    /// What the kernel refused.
    pub refused: Vec<Refused>,
}

impl Punctual {
    /// Locks the memory of the process, what it will take later included, and keeps its processors out of deep sleep.
    /// What the kernel refuses is left out and reported.
    pub fn begin() -> Punctual {
        let mut refused = Vec::new();
        let locked =
            lock_memory().map_err(|error| refused.push(Refused { what: Privilege::Memory, error })).is_ok();
        let awake = stay_awake();
        let awake = awake.map_err(|error| refused.push(Refused { what: Privilege::Awake, error })).ok();
        Punctual { locked, awake, refused }
    }

    /// Whether the memory is locked.
    pub fn is_locked(&self) -> bool {
        self.locked
    }

    /// Whether the processors stay awake.
    pub fn is_awake(&self) -> bool {
        self.awake.is_some()
    }
}

impl Drop for Punctual {
    fn drop(&mut self) {
        if self.locked {
            // Nothing to be done about a failure, and nothing that depends on it.
            let _ = munlockall();
        }
    }
}

/// Locks all memory of this process, what it will take later included. With a limit on locked memory a lock of what
/// comes later would make allocations fail that succeed without it, so then none is taken.
///
/// # Errors
/// EPERM where a limit holds; what the kernel says.
pub fn lock_memory() -> Result<(), Errno> {
    let limited = getrlimit(Resource::Memlock).current.is_some();
    if limited && !has_capability(IPC_LOCK) {
        return Err(Errno::PERM);
    }
    mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE)
}

/// Asks a process that this one started to end (SIGTERM), so that it can put its things in order. One that has ended is
/// left alone: as long as nobody waited for it its number belongs to nobody else.
///
/// # Errors
/// What the kernel says.
pub fn ask_to_end(child: &Child) -> Result<(), Errno> {
    let Ok(number) = i32::try_from(child.id()) else { return Err(Errno::SRCH) };
    let Some(pid) = Pid::from_raw(number) else { return Err(Errno::SRCH) };
    kill_process(pid, Signal::TERM)
}

/// Whether a capability is in effect, as far as /proc tells.
fn has_capability(bit: u32) -> bool {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else { return false };
    let effective = status.lines().find_map(|line| line.strip_prefix("CapEff:"));
    let effective = effective.and_then(|text| u64::from_str_radix(text.trim(), 16).ok());
    effective.is_some_and(|set| set >> bit & 1 == 1)
}

fn stay_awake() -> Result<File, Errno> {
    let code = |error: std::io::Error| error.raw_os_error().map_or(Errno::IO, Errno::from_raw_os_error);
    let mut file = File::options().write(true).open(LATENCY).map_err(code)?;
    // The longest latency that is accepted, in us, as the kernel's own integer.
    file.write_all(&0i32.to_ne_bytes()).map_err(code)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_refused_is_told_and_what_is_not_holds() {
        let punctual = Punctual::begin();
        let refused = |what| punctual.refused.iter().any(|refused| refused.what == what);
        assert_ne!(punctual.is_locked(), refused(Privilege::Memory));
        assert_ne!(punctual.is_awake(), refused(Privilege::Awake));
    }
}
