//! Counts of modelled lines, as a plan sees them.

use document::SourceFile;
use scanrig_drivers::circuit::Circuit;
use scanrig_drivers::{
    Board, BoardEvent, BoardExt, ChannelKind, Fault, FaultKind, LossReason, SimulatedBoard, Terminals, read,
};
use signal::{Span, Time, Value, When};

const BOARD: &str = r#"format = 1
[channels]
a = { kind = "digital" }
b = { kind = "digital", pull = "up" }
far = { kind = "digital" }
shaft = { kind = "count", of = ["a", "b"], function = "quadrature-x4" }
pulses = { kind = "count", of = ["a"], edge = "falling" }
behind = { kind = "count", of = ["far"], edge = "both" }
[[wires]]
from = "a"
to = "far"
delay = "1 ms"
bounce = { edges = 4, over = "400 us", spacing = "even" }
"#;

fn circuit() -> Circuit {
    let file = read(&SourceFile::new("bench.toml", BOARD), &|_| Ok(Terminals::default()))
        .unwrap_or_else(|found| panic!("{found:#?}"));
    file.circuit
}

fn started(circuit: &Circuit) -> SimulatedBoard {
    let mut board = SimulatedBoard::new(circuit, 1).unwrap();
    board.start(Time::ZERO).unwrap();
    board
}

fn at(micros: i64) -> Time {
    Time::ZERO + Span::from_micros(micros)
}

#[test]
fn a_count_is_told_at_the_instant_of_its_line() {
    let circuit = circuit();
    let mut board = started(&circuit);
    let id = |name: &str| board.find(name).unwrap();
    let (a, b, far) = (id("a"), id("b"), id("far"));
    let (shaft, pulses, behind) = (id("shaft"), id("pulses"), id("behind"));
    let channel = &board.channels()[usize::from(shaft.0)];
    assert_eq!((&channel.kind, channel.drives, channel.senses), (&ChannelKind::Count, false, true));
    let mut events = Vec::new();
    board.poll(Time::ZERO, &mut events).unwrap();
    let first = |events: &[BoardEvent], of| {
        let found = events.iter().filter_map(|event| match *event {
            BoardEvent::Changed { channel, value, at, .. } if channel == of => Some((at, value)),
            _ => None,
        });
        found.collect::<Vec<_>>()
    };
    for count in [shaft, pulses, behind] {
        assert_eq!(first(&events, count), [(When::exactly(Time::ZERO), Value::Int(0))]);
    }
    events.clear();
    // B reads 1 by its pull. A rises, B falls: a quarter back each; A falls: another.
    for (when, channel, level) in [(10, a, true), (20, b, false), (30, a, false), (40, b, true)] {
        board.write(at(when), &[(channel, Value::Bool(level))]).unwrap();
        board.poll(at(when), &mut events).unwrap();
    }
    let counted = |value, when| (When::exactly(at(when)), Value::Int(value));
    assert_eq!(first(&events, shaft), [counted(-1, 10), counted(-2, 20), counted(-3, 30), counted(-4, 40)]);
    assert_eq!(first(&events, pulses), [counted(1, 30)]);
    // The wire bounces: each of its edges counts, where it arrives.
    board.poll(at(5_000), &mut events).unwrap();
    assert_eq!(first(&events, behind).len(), first(&events, far).len());
    assert!(first(&events, behind).len() >= 6, "{events:?}");
    // Both phases at once are no count.
    events.clear();
    board.write(at(6_000), &[(a, Value::Bool(true)), (b, Value::Bool(false))]).unwrap();
    board.poll(at(6_000), &mut events).unwrap();
    assert_eq!(first(&events, shaft), []);
    // A fault of the line counts as it is seen, and a safe state is no count of its own.
    events.clear();
    let stuck = Fault { channel: a, kind: FaultKind::StuckAt(Value::Bool(false)), lasts: None };
    board.inject(at(7_000), stuck).unwrap();
    board.poll(at(7_000), &mut events).unwrap();
    assert_eq!(first(&events, shaft).len(), 1);
    board.safe(at(8_000)).unwrap();
    events.clear();
    board.start(at(9_000)).unwrap();
    board.poll(at(9_000), &mut events).unwrap();
    assert_eq!(first(&events, shaft), [(When::exactly(at(9_000)), Value::Int(0))]);
}

#[test]
fn a_count_that_is_lost_comes_back_with_what_was_counted_meanwhile() {
    let circuit = circuit();
    let mut board = started(&circuit);
    let (a, pulses) = (board.find("a").unwrap(), board.find("pulses").unwrap());
    let mut events = Vec::new();
    let lost = Fault { channel: pulses, kind: FaultKind::Lost, lasts: Some(Span::from_micros(50)) };
    board.inject(at(10), lost).unwrap();
    for (when, level) in [(20, true), (30, false)] {
        board.write(at(when), &[(a, Value::Bool(level))]).unwrap();
    }
    board.poll(at(100), &mut events).unwrap();
    let of: Vec<BoardEvent> = events.into_iter().filter(|event| event.channel() == pulses).collect();
    assert!(
        matches!(
            of[..],
            [
                BoardEvent::Changed { value: Value::Int(0), .. },
                BoardEvent::Lost { reason: LossReason::Injected, .. },
                BoardEvent::Returned { .. },
                BoardEvent::Changed { value: Value::Int(1), .. },
            ]
        ),
        "{of:?}"
    );
    let write = board.write(at(200), &[(pulses, Value::Int(7))]);
    assert!(write.is_err(), "{write:?}");
}
