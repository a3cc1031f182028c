//! Once it has run for a while, a board of converters allocates nothing, on no thread.

mod scripted;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use scanrig_drivers::{Board, BoardEvent};
use scripted::Script;
use signal::{Span, Time, Value};

static ALLOCATED: AtomicU64 = AtomicU64::new(0);

/// Counts what is asked of the system's allocator.
struct Counting;

// SAFETY: every call goes to the system's allocator as it came.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATED.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise about the layout is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer came from `alloc` above with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn readings_allocate_nothing() {
    let script = Arc::new(Script::default());
    let (mut board, at) = scripted::board(&scripted::file("20 s", "200 us", false, ""), &script);
    at.time.restart();
    board.start(Time::ZERO).unwrap();
    let mut events: Vec<BoardEvent> = Vec::with_capacity(1024);
    let mut before = 0;
    for turn in 0..2_000u32 {
        if turn == 500 {
            before = ALLOCATED.load(Ordering::Relaxed);
        }
        let wanted = Value::Real(f64::from(turn) + 1.0);
        script.show(2, f64::from(turn) + 1.0);
        let due = at.time.now() + Span::from_secs(20);
        let mut told = false;
        while !told && at.time.now() < due {
            events.clear();
            board.poll(at.time.now(), &mut events).unwrap();
            told = events
                .iter()
                .any(|event| matches!(event, BoardEvent::Changed { value, .. } if *value == wanted));
            if !told {
                at.bell.wait_until(at.time.stamp(at.time.now() + Span::from_millis(5)));
            }
        }
        assert!(told, "turn {turn}: {:?}", board.health());
    }
    assert_eq!(ALLOCATED.load(Ordering::Relaxed) - before, 0, "allocations in 1 500 readings that changed");
}
