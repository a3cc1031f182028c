//! The system's allocator, counted: for tests and benchmarks that say how often memory was asked for.
//!
//! ```ignore
//! #[global_allocator]
//! static ALLOCATOR: Counting = Counting;
//! ```
//!
//! Not a goal: how much memory there is, which the kernel says.

// An allocator cannot be written without: each call goes on to the system's unchanged.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

static OF_ALL: AtomicU64 = AtomicU64::new(0);

thread_local! {
    static OF_THIS: Cell<u64> = const { Cell::new(0) };
}

/// How often any thread has asked for memory, or for a place of another size.
pub fn of_all_threads() -> u64 {
    OF_ALL.load(Ordering::Relaxed)
}

/// How often this thread has: the harness of tests has threads of its own.
pub fn of_this_thread() -> u64 {
    OF_THIS.get()
}

/// The system's allocator, counted.
#[derive(Clone, Copy, Debug)]
pub struct Counting;

fn count() {
    OF_ALL.fetch_add(1, Ordering::Relaxed);
    OF_THIS.set(OF_THIS.get() + 1);
}

// SAFETY: every call goes to `System` with the arguments that came. `count` neither allocates nor unwinds: its cell needs
// neither to be made nor to be dropped.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise for `layout` is the one that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as above; `place` came from `System`.
        unsafe { System.realloc(place, layout, size) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: as above; `place` came from `System`.
        unsafe { System.dealloc(place, layout) }
    }
}
