//! Once it has run for a while, a board of counters allocates nothing, on no thread.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::scripted_counter::{self, Script};
use scanrig_drivers::{Board, BoardEvent};
use signal::{Span, Time, Value};

pub fn counts_allocate_nothing() {
    let script = Arc::new(Script::default());
    let (mut board, at) = scripted_counter::board(&scripted_counter::file("20 s", "200 us", false), &script);
    at.time.restart();
    board.start(Time::ZERO).unwrap();
    let mut events: Vec<BoardEvent> = Vec::with_capacity(1024);
    let mut before = 0;
    for turn in 1..=1_000 {
        if turn == 300 {
            before = counting::of_all_threads();
        }
        script.value.store(turn, Ordering::Release);
        let wanted = Value::Int(turn as i64);
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
    assert_eq!(counting::of_all_threads() - before, 0, "allocations in 700 counts");
}
