//! What the tests of boards share.

use scanrig_drivers::circuit::{ChannelSpec, Circuit, Pull, WireSpec};
use scanrig_drivers::{Board, BoardEvent, ChannelId, SimulatedBoard};
use signal::{Span, Time, Value};

pub const ON: Value = Value::Bool(true);
pub const OFF: Value = Value::Bool(false);

pub fn at(nanos: i64) -> Time {
    Time::from_nanos(nanos)
}

pub fn ns(nanos: i64) -> Span {
    Span::from_nanos(nanos)
}

pub fn id(n: u16) -> ChannelId {
    ChannelId(n)
}

pub fn wire(from: u16, to: u16, delay: i64) -> WireSpec {
    WireSpec { from: id(from), to: id(to), delay: ns(delay), off_delay: None, invert: false, bounce: None }
}

/// Digital channels without pull (outputs) and with pull-down (inputs), in this order.
pub fn digital(outputs: u16, inputs: u16) -> Circuit {
    let mut circuit = Circuit::default();
    circuit.channels.extend((0..outputs).map(|n| ChannelSpec::digital(format!("Q{n}"), Pull::None)));
    circuit.channels.extend((0..inputs).map(|n| ChannelSpec::digital(format!("I{n}"), Pull::Down)));
    circuit
}

/// A board that is started at 0 and whose first values were read.
pub fn started(circuit: &Circuit, seed: u64) -> SimulatedBoard {
    let mut board = SimulatedBoard::new(circuit, seed).expect("a good circuit");
    board.start(at(0)).expect("starts");
    poll(&mut board, 0);
    board
}

pub fn poll(board: &mut dyn Board, now: i64) -> Vec<BoardEvent> {
    let mut out = Vec::new();
    board.poll(at(now), &mut out).expect("polls");
    out
}

/// The changes of one channel as nanoseconds and values.
pub fn changes(events: &[BoardEvent], of: u16) -> Vec<(i64, Value)> {
    let changed = |event: &BoardEvent| match *event {
        BoardEvent::Changed { channel, at, value, .. } if channel == id(of) => {
            Some((at.latest.as_nanos(), value))
        }
        _ => None,
    };
    events.iter().filter_map(changed).collect()
}
