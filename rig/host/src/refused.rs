//! What the kernel did not let the rig do for its punctuality, in words.

use rustix::io::Errno;
use std::fmt;

/// Something that makes waits end on time and that the kernel can refuse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Privilege {
    /// Threads that go before all that is not real-time.
    Priority,
    /// Threads that stay on processors of their own.
    Processors,
    /// Memory that is never taken away and fetched again.
    Memory,
    /// Processors that do not fall into sleep out of which they wake late.
    Awake,
}

impl Privilege {
    /// Every one.
    pub const ALL: [Privilege; 4] =
        [Privilege::Priority, Privilege::Processors, Privilege::Memory, Privilege::Awake];

    /// What it is called in a record.
    pub const fn name(self) -> &'static str {
        match self {
            Privilege::Priority => "Real-time priority",
            Privilege::Processors => "Processors of its own",
            Privilege::Memory => "Memory locked",
            Privilege::Awake => "Deep sleep held off",
        }
    }
}

/// A privilege that the kernel refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Which.
    pub what: Privilege,
    /// What the kernel said.
    pub error: Errno,
}

impl Refused {
    /// What to do about it.
    pub fn fix(&self) -> &'static str {
        match (self.what, self.error) {
            (Privilege::Priority, _) => {
                "allow it: a line `@realtime - rtprio 98` in /etc/security/limits.d/rig.conf and the user in \
                 that group, or `setcap cap_sys_nice,cap_ipc_lock+ep` on the binary of the rig"
            }
            (Privilege::Processors, _) => "name processors that exist and that the rig may use: see `nproc`",
            (Privilege::Memory, _) => {
                "allow it: a line `@realtime - memlock unlimited` in /etc/security/limits.d/rig.conf and the user \
                 in that group, or `setcap cap_sys_nice,cap_ipc_lock+ep` on the binary of the rig"
            }
            (Privilege::Awake, Errno::NOENT) => {
                "this kernel has no /dev/cpu_dma_latency: boot it with `cpuidle.off=1`, or leave it as it is where \
                 the processors do not sleep deeply"
            }
            (Privilege::Awake, _) => {
                "let the user write /dev/cpu_dma_latency: a udev rule \
                 `KERNEL==\"cpu_dma_latency\", GROUP=\"realtime\", MODE=\"0660\"`"
            }
        }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.what {
            Privilege::Priority => "threads with real-time priority",
            Privilege::Processors => "threads on processors of their own",
            Privilege::Memory => "memory that stays in place",
            Privilege::Awake => "processors that do not sleep deeply",
        };
        let error = std::io::Error::from(self.error);
        write!(f, "the kernel does not allow {what}: {error}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_says_what_and_why_and_its_mend() {
        let refused = Refused { what: Privilege::Priority, error: Errno::PERM };
        let words = refused.to_string();
        assert!(words.contains("real-time priority") && words.contains("not permitted"), "{words}");
        for what in Privilege::ALL {
            assert!(!Refused { what, error: Errno::PERM }.fix().is_empty());
        }
    }
}
