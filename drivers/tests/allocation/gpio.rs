//! Once it has run for a while, a board of GPIO lines allocates nothing, on no thread.

use std::sync::Arc;

use crate::fake::{self, Fake};
use host::HostInstant;
use scanrig_drivers::{Board, BoardEvent, BoardExt};
use signal::{Span, Time, Value};

pub fn scans_allocate_nothing() {
    let chip = Fake::new();
    let (mut board, at) = fake::board(Arc::clone(&chip) as Arc<_>, "20 s");
    let outs: Vec<_> = (0..fake::LINES).map(|line| board.find(&format!("o{line}")).unwrap()).collect();
    at.time.restart();
    board.start(Time::ZERO).unwrap();
    let mut events: Vec<BoardEvent> = Vec::with_capacity(1024);
    let mut writes = Vec::with_capacity(fake::LINES);
    board.poll(at.time.now(), &mut events).unwrap();
    let mut told = 0u64;
    let mut before = 0;
    for scan in 0..12_000u32 {
        if scan == 2_000 {
            before = counting::of_all_threads();
        }
        let high = scan % 2 == 0;
        writes.clear();
        writes.extend(outs.iter().map(|out| (*out, Value::Bool(high))));
        board.write(at.time.now(), &writes).unwrap();
        chip.edge(high, HostInstant::now());
        // Until outputs and input have been reported.
        let (wanted, due) = (told + 1 + fake::LINES as u64, at.time.now() + Span::from_secs(20));
        while told < wanted && at.time.now() < due {
            events.clear();
            board.poll(at.time.now(), &mut events).unwrap();
            told += events.iter().filter(|event| matches!(event, BoardEvent::Changed { .. })).count() as u64;
            if told < wanted {
                at.bell.wait_until(at.time.stamp(at.time.now() + Span::from_millis(5)));
            }
        }
        assert!(told >= wanted, "scan {scan}: {:?}", board.health());
    }
    assert_eq!(counting::of_all_threads() - before, 0, "allocations in 10 000 scans");
    assert!(board.health().is_sound(), "{:?}", board.health());
}
