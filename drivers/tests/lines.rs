//! Lines and wires of the simulated board.

use crate::common::*;
use proptest::prelude::*;
use scanrig_drivers::circuit::{Bounce, ChannelSpec, CircuitFault, CircuitPart, Pull, Spacing, WireSpec};
use scanrig_drivers::{Board, BoardError, BoardEvent, BoardExt, Fault, FaultKind, Origin, SimulatedBoard};
use signal::{Time, Value};

#[test]
fn the_first_poll_reports_every_line() {
    let mut circuit = digital(1, 2);
    circuit.channels[2].pull = Pull::Up;
    circuit.channels.push(ChannelSpec::analog("temp", "degC"));
    let mut board = SimulatedBoard::new(&circuit, 0).unwrap();
    assert_eq!(board.next_event(), None);
    assert_eq!(board.write(at(0), &[]), Err(BoardError::NotStarted));
    board.start(at(7)).unwrap();
    assert_eq!(board.next_event(), Some(at(7)));
    let events = poll(&mut board, 7);
    let values: Vec<Vec<(i64, Value)>> = (0..4).map(|n| changes(&events, n)).collect();
    assert_eq!(values, [[(7, Value::HighZ)], [(7, OFF)], [(7, ON)], [(7, Value::Real(0.0))]]);
    assert_eq!(board.next_event(), None);
}

#[test]
fn a_write_is_reported_and_a_wire_carries_it_after_its_delay() {
    let mut circuit = digital(1, 1);
    circuit.wires.push(wire(0, 1, 1_000));
    let mut board = started(&circuit, 0);
    board.write(at(100), &[(id(0), ON)]).unwrap();
    assert_eq!(board.next_event(), Some(at(100)));
    let events = poll(&mut board, 100);
    assert_eq!(changes(&events, 0), [(100, ON)]);
    assert!(matches!(events[0], BoardEvent::Changed { origin: Origin::Write, .. }));
    assert_eq!(board.next_event(), Some(at(1_100)));
    // Transport delay: a pulse shorter than the delay arrives too.
    board.write(at(150), &[(id(0), OFF)]).unwrap();
    let events = poll(&mut board, 5_000);
    assert_eq!(changes(&events, 1), [(1_100, ON), (1_150, OFF)]);
    assert_eq!(board.next_event(), None);
}

#[test]
fn high_impedance_goes_through_wires_but_not_through_an_inverting_one() {
    let mut circuit = digital(1, 3);
    circuit.wires.push(wire(0, 1, 0));
    circuit.wires.push(wire(1, 2, 0));
    circuit.wires.push(WireSpec { invert: true, ..wire(0, 3, 0) });
    circuit.channels[2].pull = Pull::Up;
    let mut board = started(&circuit, 0);
    // Undriven: each input reads its own pull; the break contact is closed.
    assert_eq!([1, 2, 3].map(|n| board.value(id(n)).unwrap()), [OFF, ON, ON]);
    board.write(at(10), &[(id(0), OFF)]).unwrap();
    assert_eq!([1, 2, 3].map(|n| board.value(id(n)).unwrap()), [OFF, OFF, ON]);
    board.write(at(20), &[(id(0), ON)]).unwrap();
    assert_eq!([1, 2, 3].map(|n| board.value(id(n)).unwrap()), [ON, ON, OFF]);
}

#[test]
fn a_driven_one_wins_and_the_contention_is_counted() {
    let mut circuit = digital(2, 1);
    circuit.wires.push(wire(0, 2, 0));
    circuit.wires.push(wire(1, 2, 0));
    let mut board = started(&circuit, 0);
    board.write(at(1), &[(id(0), ON), (id(1), OFF)]).unwrap();
    assert_eq!(board.value(id(2)), Some(ON));
    assert_eq!(board.health().contentions, 1);
    board.write(at(2), &[(id(0), OFF)]).unwrap();
    assert_eq!(board.value(id(2)), Some(OFF));
    board.write(at(3), &[(id(2), ON)]).unwrap();
    assert_eq!(board.value(id(2)), Some(ON));
    assert_eq!(board.health().contentions, 2);
}

#[test]
fn writes_at_once_make_no_glitch() {
    // One source takes over from the other in one write: the line behind both never falls.
    let mut circuit = digital(2, 1);
    circuit.wires.push(wire(0, 2, 0));
    circuit.wires.push(wire(1, 2, 0));
    let mut board = started(&circuit, 0);
    board.write(at(1), &[(id(0), ON)]).unwrap();
    board.write(at(2), &[(id(0), OFF), (id(1), ON)]).unwrap();
    assert_eq!(changes(&poll(&mut board, 3), 2), [(1, ON)]);
}

#[test]
fn bounce_ends_where_it_belongs() {
    let mut circuit = digital(1, 1);
    let bounce = Bounce { edges: 4, over: ns(1_000), spacing: Spacing::Even };
    circuit.wires.push(WireSpec { bounce: Some(bounce), ..wire(0, 1, 100) });
    let mut board = started(&circuit, 0);
    board.write(at(0), &[(id(0), ON)]).unwrap();
    let events = poll(&mut board, 10_000);
    let expected = [(100, ON), (350, OFF), (600, ON), (850, OFF), (1_100, ON)];
    assert_eq!(changes(&events, 1), expected);
    // A new change ends the bounce that goes on.
    board.write(at(20_000), &[(id(0), OFF)]).unwrap();
    board.write(at(20_300), &[(id(0), ON)]).unwrap();
    let events = poll(&mut board, 30_000);
    let expected = [(20_100, OFF), (20_350, ON), (20_650, OFF), (20_900, ON), (21_150, OFF), (21_400, ON)];
    assert_eq!(changes(&events, 1), expected);
}

#[test]
fn a_start_begins_anew_and_bounces_follow_the_seed() {
    let mut circuit = digital(1, 1);
    let bounce = Bounce { edges: 20, over: ns(1_000_000), spacing: Spacing::Random };
    circuit.wires.push(WireSpec { bounce: Some(bounce), ..wire(0, 1, 100) });
    let run = |board: &mut SimulatedBoard| {
        board.start(at(0)).unwrap();
        board.write(at(10), &[(id(0), ON)]).unwrap();
        board.inject(at(11), Fault { channel: id(1), kind: FaultKind::Late(ns(7)), lasts: None }).unwrap();
        // Left in the middle of the bounce, with changes on their way.
        poll(board, 500_000)
    };
    let mut board = SimulatedBoard::new(&circuit, 1).unwrap();
    let first = run(&mut board);
    assert_eq!(first, run(&mut board));
    assert_ne!(first, run(&mut SimulatedBoard::new(&circuit, 2).unwrap()));
}

/// A relay that picks up after 10 and drops after 3.
#[test]
fn delays_of_on_and_off_differ() {
    let mut circuit = digital(1, 1);
    circuit.wires.push(WireSpec { off_delay: Some(ns(3)), ..wire(0, 1, 10) });
    let mut board = started(&circuit, 0);
    board.write(at(0), &[(id(0), OFF)]).unwrap();
    poll(&mut board, 50);
    let mut end = |writes: &[(i64, Value)], until: i64| {
        for (time, value) in writes {
            board.write(at(*time), &[(id(0), *value)]).unwrap();
        }
        changes(&poll(&mut board, until), 1)
    };
    assert_eq!(end(&[(100, ON), (150, OFF)], 200), [(110, ON), (153, OFF)]);
    // A pulse of 7 arrives as nothing: its end comes with its beginning or before.
    assert!(end(&[(200, ON), (207, OFF)], 250).is_empty());
    assert_eq!(end(&[(250, ON), (258, OFF)], 300), [(260, ON), (261, OFF)]);
    // A gap arrives however short it is, and is longer then: the contact picks up later than it drops.
    assert_eq!(end(&[(300, ON), (350, OFF), (351, ON)], 400), [(310, ON), (353, OFF), (361, ON)]);
    let mut inverting = circuit.clone();
    inverting.wires[0].invert = true;
    let mut board = started(&inverting, 0);
    board.write(at(0), &[(id(0), OFF)]).unwrap();
    poll(&mut board, 50);
    board.write(at(100), &[(id(0), ON)]).unwrap();
    board.write(at(150), &[(id(0), OFF)]).unwrap();
    assert_eq!(changes(&poll(&mut board, 200), 1), [(103, OFF), (160, ON)]);
}

#[test]
fn a_contact_that_a_short_pulse_does_not_move_does_not_bounce() {
    let mut circuit = digital(1, 1);
    let bounce = Some(Bounce { edges: 2, over: ns(4), spacing: Spacing::Even });
    circuit.wires.push(WireSpec { off_delay: Some(ns(3)), bounce, ..wire(0, 1, 20) });
    let mut board = started(&circuit, 0);
    board.write(at(0), &[(id(0), OFF)]).unwrap();
    poll(&mut board, 50);
    board.write(at(100), &[(id(0), ON)]).unwrap();
    board.write(at(105), &[(id(0), OFF)]).unwrap();
    assert!(changes(&poll(&mut board, 150), 1).is_empty());
    // The bounce of the change before it goes on.
    board.write(at(200), &[(id(0), ON)]).unwrap();
    board.write(at(300), &[(id(0), OFF)]).unwrap();
    board.write(at(301), &[(id(0), ON)]).unwrap();
    board.write(at(302), &[(id(0), OFF)]).unwrap();
    let on = [(220, ON), (222, OFF), (224, ON)];
    assert_eq!(changes(&poll(&mut board, 400), 1), [&on[..], &[(303, OFF), (305, ON), (307, OFF)]].concat());
}

/// A contact that drops at once: a pulse that is too short leaves it, and a gap of any length arrives.
#[test]
fn one_of_two_delays_may_be_none() {
    let mut circuit = digital(1, 1);
    circuit.wires.push(WireSpec { off_delay: Some(ns(0)), ..wire(0, 1, 10) });
    let mut board = started(&circuit, 0);
    board.write(at(0), &[(id(0), OFF)]).unwrap();
    poll(&mut board, 50);
    for (time, value) in [(100, ON), (105, OFF), (105, ON), (120, OFF), (121, ON)] {
        board.write(at(time), &[(id(0), value)]).unwrap();
    }
    assert_eq!(changes(&poll(&mut board, 200), 1), [(115, ON), (120, OFF), (131, ON)]);
}

#[test]
fn a_wire_with_two_delays_is_checked() {
    let mut circuit = digital(1, 1);
    circuit.wires.push(WireSpec { off_delay: Some(ns(-1)), ..wire(0, 1, 10) });
    assert_eq!(circuit.check()[0].fault, CircuitFault::BadTime);
    circuit.wires[0].off_delay = Some(ns(0));
    circuit.wires.push(wire(1, 0, 0));
    assert_eq!(circuit.check()[0].fault, CircuitFault::Loop);
}

#[test]
fn rings_without_delay_are_refused_and_named() {
    let mut circuit = digital(0, 4);
    circuit.wires = vec![wire(0, 1, 0), wire(1, 2, 0), wire(2, 1, 0), wire(2, 3, 0)];
    let error = SimulatedBoard::new(&circuit, 0).unwrap_err();
    assert_eq!(error.fault, CircuitFault::Loop);
    assert!(matches!(error.part, CircuitPart::Wire(1 | 2)), "{error}");
    circuit.wires[2].delay = ns(1);
    assert!(SimulatedBoard::new(&circuit, 0).is_ok());
    circuit.wires.push(wire(3, 3, 0));
    assert_eq!(SimulatedBoard::new(&circuit, 0).unwrap_err().part, CircuitPart::Wire(4));
}

#[test]
fn a_ring_through_an_inverting_delay_oscillates_and_is_bounded() {
    let mut circuit = digital(0, 1);
    circuit.wires.push(WireSpec { invert: true, ..wire(0, 0, 10) });
    let mut board = SimulatedBoard::new(&circuit, 0).unwrap();
    board.start(at(0)).unwrap();
    let events = poll(&mut board, 100);
    // Undriven, the inverting wire drives 1; it then counts as driven 1, and so on.
    assert!(changes(&events, 0).len() >= 10);
    let mut out = Vec::new();
    let error = board.poll(Time::from_nanos(i64::MAX / 2), &mut out).unwrap_err();
    assert!(matches!(error, BoardError::Storm { .. }), "{error}");
    assert!(!board.health().is_sound());
}

#[test]
fn the_safe_state_is_latched_until_the_next_start() {
    let mut circuit = digital(1, 1);
    circuit.channels[0].safe = OFF;
    let mut board = started(&circuit, 0);
    board.write(at(1), &[(id(0), ON), (id(1), ON)]).unwrap();
    board.safe(at(2)).unwrap();
    assert_eq!(board.write(at(3), &[(id(0), ON)]), Err(BoardError::Latched));
    let events = poll(&mut board, 3);
    assert_eq!(changes(&events, 0), [(1, ON), (2, OFF)]);
    assert_eq!(changes(&events, 1), [(1, ON), (2, OFF)]);
    board.start(at(0)).unwrap();
    board.write(at(3), &[(id(0), ON)]).unwrap();
    assert_eq!(board.value(id(0)), Some(ON));
}

#[test]
fn a_refused_write_changes_nothing() {
    let mut circuit = digital(1, 1);
    circuit.channels[1].drives = false;
    circuit.channels.push(ChannelSpec::analog("temp", "degC"));
    let mut board = started(&circuit, 0);
    let refused = [
        (vec![(id(0), ON), (id(9), ON)], BoardError::NoChannel(id(9))),
        (vec![(id(0), ON), (id(1), ON)], BoardError::NotDriven(id(1))),
        (vec![(id(0), ON), (id(2), ON)], BoardError::BadValue(id(2))),
        (vec![(id(0), ON), (id(2), Value::Real(f64::NAN))], BoardError::BadValue(id(2))),
        (vec![(id(0), Value::Real(1.0))], BoardError::BadValue(id(0))),
    ];
    for (writes, error) in refused {
        assert_eq!(board.write(at(1), &writes), Err(error));
    }
    assert!(poll(&mut board, 5).is_empty());
    let backwards = BoardError::Backwards { now: at(4), last: at(5) };
    assert_eq!(board.write(at(4), &[(id(0), ON)]), Err(backwards));
}

/// What a wire's end drives at an instant, from the list of all changes of its beginning.
fn oracle(inputs: &[(i64, bool)], delay: i64, invert: bool, at: i64) -> Value {
    let driven = inputs.iter().rev().find(|(time, _)| time + delay <= at).map(|(_, level)| *level);
    match (driven, invert) {
        (Some(level), invert) => Value::Bool(level != invert),
        (None, true) => ON,
        (None, false) => OFF,
    }
}

proptest! {
    /// However the time between is cut into polls, the same events come in the same order, none is lost, and
    /// each is where the list of writes says.
    #[test]
    fn events_do_not_depend_on_polls(
        gaps in proptest::collection::vec((1i64..400, any::<bool>()), 1..40),
        delays in (0i64..300, 0i64..300),
        inverts in (any::<bool>(), any::<bool>()),
        polls in proptest::collection::vec(1i64..200, 0..60),
        seed in any::<u64>(),
        bouncing in any::<bool>(),
    ) {
        let mut circuit = digital(1, 2);
        let bounce = bouncing.then_some(Bounce { edges: 6, over: ns(50), spacing: Spacing::Random });
        circuit.wires.push(WireSpec { invert: inverts.0, ..wire(0, 1, delays.0) });
        circuit.wires.push(WireSpec { invert: inverts.1, bounce, ..wire(1, 2, delays.1) });
        let mut inputs = Vec::new();
        let mut now = 0;
        for (gap, level) in gaps {
            now += gap;
            inputs.push((now, level));
        }
        let run = |cuts: &[i64]| {
            let mut board = started(&circuit, seed);
            let mut events = Vec::new();
            let (mut cuts, mut cut) = (cuts.iter(), 0);
            for &(time, level) in &inputs {
                while cut < time {
                    if cut > 0 {
                        events.extend(poll(&mut board, cut));
                    }
                    cut += cuts.next().copied().unwrap_or(i64::MAX / 2);
                }
                board.write(at(time), &[(id(0), Value::Bool(level))]).unwrap();
            }
            events.extend(poll(&mut board, now + 1_000));
            prop_assert!(board.next_event().is_none());
            Ok(events)
        };
        let (whole, cut) = (run(&[])?, run(&polls)?);
        prop_assert_eq!(&whole, &cut);
        prop_assert!(whole.windows(2).all(|pair| pair[0].latest() <= pair[1].latest()));
        for n in 1..3 {
            prop_assert!(changes(&whole, n).windows(2).all(|pair| pair[0].1 != pair[1].1));
        }
        // The first wire, by the oracle, at every instant.
        let first = changes(&whole, 1);
        let mut value = if inverts.0 { ON } else { OFF };
        let mut next = first.iter().peekable();
        for instant in 0..now + 1_000 {
            while let Some((_, newer)) = next.next_if(|(time, _)| *time == instant) {
                value = *newer;
            }
            prop_assert_eq!(value, oracle(&inputs, delays.0, inverts.0, instant), "at {}", instant);
        }
        // The second settles on the first's last level.
        if !bouncing {
            let last = changes(&whole, 2).last().map(|(_, value)| *value);
            let end = changes(&whole, 1).last().map(|(_, value)| *value);
            if let (Some(last), Some(Value::Bool(end))) = (last, end) {
                prop_assert_eq!(last, Value::Bool(end != inverts.1));
            }
        }
    }
}
