//! What this user's programs may ask of the kernel.

use super::check::DoctorCheck;
use host::HostMachine;
use host::{Realtime, ThreadRole};

const GROUP: &str = "privileges";

/// Highest priority that the rig's processes take: that of the guard.
const HIGHEST: u64 = 99;

/// Priority of the scan where the board file names none.
const SCAN: u8 = 80;

/// The line that gives both.
const LIMITS: &str = "printf '%s - rtprio 99\\n%s - memlock unlimited\\n' \"$USER\" \"$USER\" | \
                      sudo tee /etc/security/limits.d/90-rig.conf";

/// Bits of the effective capabilities.
const CAP_IPC_LOCK: u32 = 14;
const CAP_SYS_NICE: u32 = 23;
const CAP_SYS_RESOURCE: u32 = 24;

/// Everything that is asked of the kernel.
pub fn checks(machine: &HostMachine) -> Vec<DoctorCheck> {
    vec![priority(machine), memory(machine), spared(machine)]
}

fn capable(machine: &HostMachine, bit: u32) -> bool {
    let text = machine.status("CapEff").unwrap_or_default();
    u64::from_str_radix(&text, 16).is_ok_and(|set| set >> bit & 1 == 1)
}

/// The soft limit on a resource; `None` where the kernel does not say.
fn limit(machine: &HostMachine, name: &str) -> Option<u64> {
    let text = machine.read("/proc/self/limits")?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    match line.split_whitespace().next()? {
        "unlimited" => Some(u64::MAX),
        number => number.parse().ok(),
    }
}

fn priority(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "priority";
    let refused = |found: String| {
        DoctorCheck::bad(GROUP, NAME, found)
            .means("without real-time priority any program can hold up the scan")
            .fix(LIMITS)
            .then("log in again")
    };
    let allowed =
        if capable(machine, CAP_SYS_NICE) { Some(HIGHEST) } else { limit(machine, "Max realtime priority") };
    // What the kernel does when asked goes before what its files promise.
    let tried = machine.is_here().then(try_priority);
    match (tried, allowed) {
        (Some(Err(error)), Some(HIGHEST..)) => {
            DoctorCheck::bad(GROUP, NAME, format!("refused in spite of the limits: {error}"))
                .means("a control group without real-time share, or a container, keeps it from you")
        }
        (Some(Err(error)), _) => refused(format!("SCHED_FIFO {SCAN} is refused: {error}")),
        (_, Some(HIGHEST..)) => DoctorCheck::good(GROUP, NAME, "SCHED_FIFO up to 99"),
        (_, Some(most)) if most > u64::from(SCAN) => {
            DoctorCheck::poor(GROUP, NAME, format!("SCHED_FIFO up to {most}"))
                .means("the guard cannot go before everything else with a priority of 99")
                .fix(LIMITS)
                .then("log in again")
        }
        (_, Some(0)) => refused(String::from("SCHED_FIFO is not allowed")),
        (_, Some(most)) => refused(format!("SCHED_FIFO up to {most}, and a scan takes {SCAN}")),
        (_, None) => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
    }
}

/// A thread of its own asks for the priority of a scan, and ends.
fn try_priority() -> std::io::Result<()> {
    let asking = std::thread::spawn(|| Realtime::with_priority(SCAN).enter(ThreadRole::Scan));
    asking.join().unwrap_or_else(|_| Err(std::io::Error::other("the thread that asked ended early")))
}

fn memory(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "locked memory";
    if capable(machine, CAP_IPC_LOCK) {
        return DoctorCheck::good(GROUP, NAME, "as much as there is");
    }
    match limit(machine, "Max locked memory") {
        None => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
        Some(u64::MAX) => DoctorCheck::good(GROUP, NAME, "as much as there is"),
        Some(bytes) => {
            let found = match bytes >> 20 {
                0 => format!("up to {} KiB", bytes >> 10),
                mega => format!("up to {mega} MiB"),
            };
            DoctorCheck::poor(GROUP, NAME, found)
                .means("the rig locks all of its memory or none: what the kernel takes away comes back in the middle of a scan")
                .fix(LIMITS)
                .then("log in again")
        }
    }
}

/// Whether the guard may ask to be the last that the kernel ends.
fn spared(machine: &HostMachine) -> DoctorCheck {
    const NAME: &str = "out of memory";
    if capable(machine, CAP_SYS_RESOURCE) {
        return DoctorCheck::good(GROUP, NAME, "the guard is ended last");
    }
    match machine.status("CapEff") {
        None => DoctorCheck::open(GROUP, NAME, "the kernel does not say"),
        Some(_) => DoctorCheck::poor(GROUP, NAME, "the guard is ended as any other program")
            .means("when memory runs out, the kernel may end the guard together with the rig")
            .fix("sudo setcap cap_sys_nice,cap_ipc_lock,cap_sys_resource+ep \"$(command -v rig)\""),
    }
}
