use scanrig_drivers::circuit::Circuit;
use scanrig_drivers::circuit::{BusSpecKind, SerialEnd, SerialMedium};
use scanrig_drivers::{Board, BoardExt, BusId, BusSpec, SimulatedBoard};
use signal::{SerialOutput, SerialSettings, Span, Time};

/// Messages back and forth on a simulated line, over and over.
pub fn messages_allocate_nothing() {
    let end = SerialEnd {
        settings: SerialSettings::default(),
        medium: SerialMedium::Rs485 { hears_itself: true },
        delay: Span::from_micros(20),
        message_gap: Span::from_millis(2),
    };
    let mut circuit = Circuit::default();
    for (name, joins) in [("a", None), ("b", Some(BusId(0)))] {
        circuit.buses.push(BusSpec { name: name.into(), kind: BusSpecKind::Serial(end), joins });
    }
    let mut board = SimulatedBoard::new(&circuit, 0).unwrap();
    board.start(Time::ZERO).unwrap();
    let output = SerialOutput::plain(&[0x5A; 40]);
    let mut events = Vec::with_capacity(64);
    let (mut before, mut messages) = (0, 0);
    for turn in 0..600_u16 {
        if turn == 100 {
            before = counting::of_all_threads();
        }
        let now = Time::ZERO + Span::from_millis(100 * i64::from(turn));
        board.send_serial(now, BusId(turn % 2), &output).unwrap();
        while let Some(next) = board.next_event() {
            board.poll_buses(next, &mut events).unwrap();
            messages += events.len();
            events.clear();
        }
    }
    // Sent, heard by itself, and heard by the other.
    assert_eq!(messages, 1_800);
    assert_eq!(counting::of_all_threads() - before, 0, "allocations in 500 messages");
}
