//! How much memory there is, and how often it was asked for.

/// What it takes to look.
pub const LOOKING: u64 = 16;

/// What was found.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    pub allocations: u64,
    /// In kB.
    pub resident: u64,
    /// In kB.
    pub locked: u64,
}

/// Looks at allocations and memory.
pub fn look() -> Found {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let kilobytes = |field: &str| -> u64 {
        let line = status.lines().find_map(|line| line.strip_prefix(field)).unwrap();
        line.split_whitespace().next().unwrap().parse().unwrap()
    };
    let (resident, locked) = (kilobytes("VmRSS:"), kilobytes("VmLck:"));
    Found { allocations: counting::of_all_threads(), resident, locked }
}
