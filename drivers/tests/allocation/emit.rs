//! Once it has run for a while, a board of generators allocates nothing, on no thread.

use std::sync::Arc;

use crate::generating::{self, Script};
use scanrig_drivers::{Board, BoardEvent, BoardExt, ChannelId, Emission};
use signal::{Span, Time, Value};

pub fn pulses_allocate_nothing() {
    let scripts = [Arc::new(Script::default()), Arc::new(Script::default())];
    let (mut board, at) = generating::board(&generating::file("20 s", false), [&scripts[0], &scripts[1]]);
    scripts.iter().for_each(|script| script.forget(16));
    at.time.restart();
    board.start(Time::ZERO).unwrap();
    let train = Emission::Pulses((0..400).map(|edge| Span::from_micros(edge * 3)).collect());
    let wave = Emission::Square { period: Span::from_micros(100), high: Span::from_micros(30) };
    let mut events: Vec<BoardEvent> = Vec::with_capacity(4_096);
    let mut before = 0;
    for turn in 0..400u32 {
        if turn == 100 {
            before = counting::of_all_threads();
        }
        let now = at.time.now();
        board.emit(now, ChannelId(0), &train).unwrap();
        board.emit(now, ChannelId(1), &wave).unwrap();
        board.write(now, &[(ChannelId(1), Value::Bool(turn % 2 == 0))]).unwrap();
        events.clear();
        let due = now + Span::from_secs(20);
        while events.len() < 400 {
            assert!(at.time.now() < due, "turn {turn}: {:?}", board.health());
            at.bell.wait_until(at.time.stamp(at.time.now() + Span::from_millis(5)));
            board.poll(at.time.now(), &mut events).unwrap();
        }
    }
    assert_eq!(counting::of_all_threads() - before, 0, "allocations in 300 trains of 400 edges");
}
