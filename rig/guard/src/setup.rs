//! How the guard's process makes itself hard to hinder: its own session, deaf to signals that end or stop, locked
//! in memory, before all others, last to be killed when memory is short.

use nix::sys::signal::{SigSet, Signal};
use nix::sys::signalfd::{SfdFlags, SignalFd};
use rustix::io::Errno;

/// Privileges that the guard asked for and did not get.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MissingPrivileges {
    /// Real-time priority: a busy machine can delay it.
    pub priority: bool,
    /// Its memory locked: a machine short of memory can delay it.
    pub memory: bool,
    /// To be spared when memory runs out: the kernel may choose it.
    pub sparing: bool,
}

impl MissingPrivileges {
    /// As a number in a message.
    pub(crate) fn to_number(self) -> i64 {
        i64::from(self.priority) | i64::from(self.memory) << 1 | i64::from(self.sparing) << 2
    }

    /// Back from a message.
    pub(crate) fn from_number(number: i64) -> MissingPrivileges {
        MissingPrivileges { priority: number & 1 != 0, memory: number & 2 != 0, sparing: number & 4 != 0 }
    }
}

/// Sets the process up; threads that it starts later are the same. Gives where SIGTERM is heard.
///
/// # Errors
/// Where even signals cannot be held off.
pub(crate) fn set_up() -> Result<(MissingPrivileges, SignalFd), Errno> {
    let mut deaf = SigSet::empty();
    for signal in [
        Signal::SIGHUP,
        Signal::SIGINT,
        Signal::SIGQUIT,
        Signal::SIGTERM,
        Signal::SIGTSTP,
        Signal::SIGTTIN,
        Signal::SIGTTOU,
        Signal::SIGUSR1,
        Signal::SIGUSR2,
        Signal::SIGPIPE,
    ] {
        deaf.add(signal);
    }
    let plain = |error: nix::errno::Errno| Errno::from_raw_os_error(error as i32);
    deaf.thread_block().map_err(plain)?;
    let mut end = SigSet::empty();
    end.add(Signal::SIGTERM);
    let ends = SignalFd::with_flags(&end, SfdFlags::SFD_NONBLOCK | SfdFlags::SFD_CLOEXEC).map_err(plain)?;
    // The keys of the rig's terminal and its hang-up are not for the guard; a process that leads a group already
    // has neither.
    let _ = rustix::process::setsid();
    // A folder that it stays in could not be unmounted.
    let _ = rustix::process::chdir("/");
    let lacks = MissingPrivileges {
        priority: host::go_before_all().is_err(),
        memory: host::lock_memory().is_err(),
        sparing: std::fs::write("/proc/self/oom_score_adj", "-1000").is_err(),
    };
    Ok((lacks, ends))
}
