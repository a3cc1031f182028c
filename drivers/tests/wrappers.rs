//! The wrappers around a board.

use crate::common::*;
use proptest::prelude::*;
use scanrig_drivers::wrap::Entry;
use scanrig_drivers::{Board, BoardError, BoardEvent, Disturbance, Faulty, SimulatedBoard, Traced};
use signal::{Span, Value};

fn board() -> SimulatedBoard {
    let mut circuit = digital(1, 1);
    circuit.wires.push(wire(0, 1, 5));
    SimulatedBoard::new(&circuit, 0).unwrap()
}

/// Toggles Q0 every 100 ns and polls wherever the board says that something happens; calls that fail are made
/// again.
fn run(disturbance: Disturbance, seed: u64, toggles: i64) -> (Vec<BoardEvent>, Faulty<SimulatedBoard>, u64) {
    let mut board = Faulty::new(board(), disturbance, seed);
    board.start(at(0)).unwrap();
    let (mut events, mut refused) = (Vec::new(), 0);
    let mut poll = |board: &mut Faulty<SimulatedBoard>, until: i64, refused: &mut u64| {
        while let Some(next) = board.next_event().filter(|next| next.as_nanos() <= until) {
            let before = events.len();
            match board.poll(next, &mut events) {
                Ok(()) => {
                    assert!(events.len() > before || board.next_event() != Some(next), "a poll for nothing")
                }
                Err(error) => {
                    assert!(matches!(error, BoardError::Os { .. }));
                    *refused += 1;
                }
            }
        }
    };
    for n in 1..=toggles {
        let now = n * 100;
        poll(&mut board, now - 1, &mut refused);
        while board.write(at(now), &[(id(0), Value::Bool(n % 2 == 1))]).is_err() {
            refused += 1;
            if refused > 100_000 {
                break;
            }
            if disturbance.call_ppm == 0 {
                break;
            }
        }
    }
    poll(&mut board, i64::MAX / 4, &mut refused);
    (events, board, refused)
}

#[test]
fn without_disturbance_nothing_differs() {
    let (events, board, _) = run(Disturbance::default(), 1, 50);
    // Two first values, then each toggle on both lines.
    assert_eq!(events.len(), 2 + 50 + 50);
    assert!(board.health().is_sound());
}

#[test]
fn a_lost_device_comes_back_with_its_present_value() {
    let disturbance = Disturbance { lose_ppm: 100_000, lost_for: ns(250), ..Disturbance::default() };
    let (events, board, _) = run(disturbance, 3, 200);
    let lost = events.iter().filter(|event| matches!(event, BoardEvent::Lost { .. })).count();
    assert!(lost > 3);
    for (place, event) in events.iter().enumerate() {
        let BoardEvent::Returned { channel, at } = event else { continue };
        let next = events[place + 1..].iter().find(|event| event.channel() == *channel).unwrap();
        assert!(matches!(next, BoardEvent::Changed { at: when, .. } if when.latest == *at));
    }
    assert_eq!(board.health().lost, 0, "all are back");
}

#[test]
fn a_device_that_is_away_cannot_be_written() {
    let disturbance = Disturbance { lose_ppm: 1_000_000, lost_for: ns(1_000), ..Disturbance::default() };
    let mut board = Faulty::new(board(), disturbance, 0);
    board.start(at(0)).unwrap();
    poll(&mut board, 0);
    board.write(at(10), &[(id(0), ON)]).unwrap();
    poll(&mut board, 10);
    assert!(matches!(board.write(at(20), &[(id(0), OFF)]), Err(BoardError::Os { .. })));
    assert!(!board.health().is_sound());
    poll(&mut board, 2_000);
    board.write(at(2_000), &[(id(0), OFF)]).unwrap();
}

proptest! {
    /// The same seed gives the same trouble; every change is reported, or its loss is.
    #[test]
    fn trouble_follows_from_the_seed(seed in any::<u64>(), late in 0u32..500_000, drop in 0u32..500_000, call in 0u32..300_000) {
        let disturbance = Disturbance {
            late_ppm: late,
            late_by: Span::from_nanos(700),
            drop_ppm: drop,
            call_ppm: call,
            ..Disturbance::default()
        };
        let (events, board, refused) = run(disturbance, seed, 60);
        let (again, _, _) = run(disturbance, seed, 60);
        prop_assert_eq!(&events, &again);
        let mut changed = 0;
        let mut dropped = 0u64;
        for event in &events {
            match event {
                BoardEvent::Changed { .. } => changed += 1,
                BoardEvent::Dropped { count, .. } => dropped += u64::from(*count),
                other => prop_assert!(false, "{:?}", other),
            }
        }
        prop_assert_eq!(changed + dropped, 2 + 60 + 60);
        prop_assert_eq!(dropped, board.health().dropped);
        prop_assert_eq!(refused, board.health().failed_calls);
        prop_assert!(events.windows(2).all(|pair| pair[0].latest() <= pair[1].latest()), "oldest first");
        // The true instant of a late change lies within its interval, and a channel's changes keep their order.
        for n in 0..2 {
            let delay = if n == 1 { 5 } else { 0 };
            let mut before = -1;
            for event in events.iter().filter(|event| event.channel() == id(n)) {
                let BoardEvent::Changed { at, .. } = event else { continue };
                let true_at = at.earliest.as_nanos();
                prop_assert!(true_at == 0 || true_at % 100 == delay);
                prop_assert!(true_at > before);
                prop_assert!(at.latest - at.earliest <= Span::from_nanos(700));
                before = true_at;
            }
        }
    }
}

#[test]
fn the_trace_of_a_board_is_bounded() {
    let mut board = Traced::new(board(), 3);
    board.start(at(0)).unwrap();
    board.write(at(1), &[(id(0), ON)]).unwrap();
    assert!(board.write(at(2), &[(id(7), ON)]).is_err());
    let entries: Vec<_> = board.entries().map(|(_, entry)| *entry).collect();
    let expected = [
        Entry::Write { channel: id(0), value: ON },
        Entry::Write { channel: id(7), value: ON },
        Entry::Failed(BoardError::NoChannel(id(7))),
    ];
    assert_eq!(entries, expected);
    poll(&mut board, 10);
    let counts = board.counts();
    assert_eq!((counts.starts, counts.writes, counts.polls, counts.events, counts.failed), (1, 2, 1, 4, 1));
    assert_eq!(board.entries().count(), 3);
}
