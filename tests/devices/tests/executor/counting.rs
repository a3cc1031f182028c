//! How much memory there is, and how often it was asked for.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};

/// Of all threads.
static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

struct Counting;

// SAFETY: every call goes to `System` with the arguments that came, and counting neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise for `layout` is the one that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: as above; `place` came from `System`.
        unsafe { System.realloc(place, layout, size) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: as above; `place` came from `System`.
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

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
    Found { allocations: ALLOCATIONS.load(Ordering::Relaxed), resident, locked }
}
