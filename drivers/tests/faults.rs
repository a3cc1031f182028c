//! Injected faults of the simulated board (the fault list of the I/O specification, 17.6).

use crate::common::*;
use scanrig_drivers::circuit::ChannelSpec;
use scanrig_drivers::{
    Board, BoardError, BoardEvent, BoardExt, Fault, FaultKind, LossReason, SimulatedBoard,
};
use signal::Value;

fn loop_back() -> SimulatedBoard {
    let mut circuit = digital(1, 1);
    circuit.wires.push(wire(0, 1, 0));
    circuit.channels.push(ChannelSpec::analog("temp", "degC"));
    started(&circuit, 0)
}

fn fault(channel: u16, kind: FaultKind) -> Fault {
    Fault { channel: id(channel), kind, lasts: None }
}

#[test]
fn a_stuck_line_follows_its_drivers_again_when_cleared() {
    let mut board = loop_back();
    board.inject(at(10), fault(0, FaultKind::StuckAt(OFF))).unwrap();
    board.write(at(20), &[(id(0), ON)]).unwrap();
    let events = poll(&mut board, 30);
    assert_eq!(changes(&events, 0), [(10, OFF)]);
    assert_eq!(changes(&events, 1), []);
    board.clear_faults(at(40), id(0)).unwrap();
    let events = poll(&mut board, 50);
    assert_eq!(changes(&events, 0), [(40, ON)]);
    assert_eq!(changes(&events, 1), [(40, ON)]);
}

#[test]
fn shorts_and_a_cut_replace_the_level() {
    let mut board = loop_back();
    board.write(at(1), &[(id(0), ON)]).unwrap();
    board.inject(at(2), fault(1, FaultKind::ShortToGround)).unwrap();
    board.inject(at(3), fault(1, FaultKind::ShortToSupply)).unwrap();
    board.inject(at(4), fault(1, FaultKind::Open)).unwrap();
    board.clear_faults(at(5), id(1)).unwrap();
    // The cut input reads its pull.
    assert_eq!(changes(&poll(&mut board, 9), 1), [(1, ON), (2, OFF), (3, ON), (4, OFF), (5, ON)]);
    board.inject(at(10), fault(0, FaultKind::Open)).unwrap();
    let events = poll(&mut board, 10);
    assert_eq!(changes(&events, 0), [(10, Value::HighZ)]);
    assert_eq!(changes(&events, 1), [(10, OFF)]);
}

#[test]
fn a_glitch_has_its_width_and_a_fault_its_span() {
    let mut board = loop_back();
    board.inject(at(10), fault(1, FaultKind::Glitch { value: ON, width: ns(3) })).unwrap();
    let stuck = Fault { lasts: Some(ns(100)), ..fault(1, FaultKind::StuckAt(ON)) };
    assert_eq!(board.next_event(), Some(at(10)));
    board.inject(at(20), stuck).unwrap();
    assert_eq!(changes(&poll(&mut board, 1_000), 1), [(10, ON), (13, OFF), (20, ON), (120, OFF)]);
    assert_eq!(board.next_event(), None);
}

#[test]
fn late_changes_come_later_and_all_come() {
    let mut board = loop_back();
    board.inject(at(10), fault(1, FaultKind::Late(ns(50)))).unwrap();
    board.write(at(20), &[(id(0), ON)]).unwrap();
    board.write(at(21), &[(id(0), OFF)]).unwrap();
    board.write(at(40), &[(id(0), ON)]).unwrap();
    assert_eq!(changes(&poll(&mut board, 80), 1), [(70, ON), (71, OFF)]);
    // What is on its way when the fault is cleared is there at once.
    board.clear_faults(at(85), id(1)).unwrap();
    assert_eq!(changes(&poll(&mut board, 1_000), 1), [(85, ON)]);
}

#[test]
fn a_lost_device_says_nothing_and_reports_its_value_when_it_returns() {
    let mut board = loop_back();
    let lost = Fault { lasts: Some(ns(90)), ..fault(0, FaultKind::Lost) };
    board.inject(at(10), lost).unwrap();
    assert_eq!(board.value(id(0)), Some(Value::Unknown));
    // Written while lost: reaches the line at the return.
    board.write(at(20), &[(id(0), ON)]).unwrap();
    let events = poll(&mut board, 50);
    assert_eq!(events, [BoardEvent::Lost { channel: id(0), at: at(10), reason: LossReason::Injected }]);
    assert_eq!(board.health().lost_on_purpose, 1);
    assert!(board.health().is_sound(), "a loss that was asked for is no trouble of the rig");
    let events = poll(&mut board, 200);
    assert_eq!(events[0], BoardEvent::Returned { channel: id(0), at: at(100) });
    assert_eq!(changes(&events, 0), [(100, ON)]);
    assert_eq!(changes(&events, 1), [(100, ON)]);
    // A device that returns to the same value still reports it.
    board.inject(at(300), lost).unwrap();
    let events = poll(&mut board, 1_000);
    assert_eq!(changes(&events, 0), [(390, ON)]);
    assert_eq!(board.health().lost_on_purpose, 0);
}

#[test]
fn impossible_faults_are_refused() {
    let mut board = loop_back();
    let refused = [
        (fault(9, FaultKind::Open), BoardError::NoChannel(id(9))),
        (fault(2, FaultKind::ShortToSupply), BoardError::NoSuchFault(id(2))),
        (fault(2, FaultKind::StuckAt(ON)), BoardError::NoSuchFault(id(2))),
        (fault(1, FaultKind::StuckAt(Value::Unknown)), BoardError::BadValue(id(1))),
        (fault(1, FaultKind::Late(ns(0))), BoardError::BadFaultTime(id(1))),
        (fault(1, FaultKind::Glitch { value: ON, width: ns(-1) }), BoardError::BadFaultTime(id(1))),
        (Fault { lasts: Some(ns(0)), ..fault(1, FaultKind::Open) }, BoardError::BadFaultTime(id(1))),
    ];
    for (fault, error) in refused {
        assert_eq!(board.inject(at(1), fault), Err(error));
    }
    for _ in 0..8 {
        board.inject(at(2), fault(1, FaultKind::Open)).unwrap();
    }
    let error = BoardError::TooManyFaults { channel: id(1), limit: 8 };
    assert_eq!(board.inject(at(2), fault(1, FaultKind::Open)), Err(error));
}

#[test]
fn an_analog_value_can_be_stuck_and_cut() {
    let mut board = loop_back();
    board.write(at(1), &[(id(2), Value::Real(20.5))]).unwrap();
    board.inject(at(2), fault(2, FaultKind::StuckAt(Value::Int(7)))).unwrap();
    board.clear_faults(at(3), id(2)).unwrap();
    board.inject(at(4), fault(2, FaultKind::Open)).unwrap();
    let expected = [20.5, 7.0, 20.5, 0.0].map(Value::Real);
    let values: Vec<Value> = changes(&poll(&mut board, 9), 2).into_iter().map(|(_, value)| value).collect();
    assert_eq!(values, expected);
}
