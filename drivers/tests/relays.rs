//! Fault relays: what is driven when, whatever faults are asked for and however long the relays take.

use proptest::prelude::*;
use scanrig_drivers::circuit::{ChannelSpec, Circuit, Pull};
use scanrig_drivers::real::{FaultRelays, WireRelays};
use scanrig_drivers::{Board, BoardError, BoardEvent, BoardExt, ChannelId, Fault, FaultKind, SimulatedBoard};
use signal::{Span, Time, Value, When};

const SETTLE: Span = Span::from_millis(10);

/// Channel 0 with all three relays, 1 to 3; channel 4 with one to the supply, 5, to be kept apart from channel 0.
fn board() -> FaultRelays<SimulatedBoard> {
    let channel = |name: &str| ChannelSpec::digital(name, Pull::Down);
    let channels = ["I0", "K1", "K2", "K3", "Q0", "K4"].map(channel).to_vec();
    let circuit = Circuit { channels, ..Circuit::default() };
    let all = WireRelays {
        channel: ChannelId(0),
        relays: [Some(ChannelId(1)), Some(ChannelId(2)), Some(ChannelId(3))],
        settle: SETTLE,
        ground_is_one: false,
        apart: vec![1],
    };
    let one = WireRelays {
        channel: ChannelId(4),
        relays: [None, None, Some(ChannelId(5))],
        apart: vec![0],
        ..all.clone()
    };
    let mut board = FaultRelays::new(SimulatedBoard::new(&circuit, 1).unwrap(), &[all, one], None);
    board.start(at_ms(0)).unwrap();
    board
}

fn at_ms(ms: i64) -> Time {
    Time::ZERO + Span::from_millis(ms)
}

fn fault(channel: u16, kind: FaultKind, lasts: Option<i64>) -> Fault {
    Fault { channel: ChannelId(channel), kind, lasts: lasts.map(Span::from_millis) }
}

/// The moves of relays up to this instant: when, which one, where to.
fn moves(board: &mut impl Board, until: i64) -> Vec<(i64, u16, bool)> {
    let (mut events, mut moves) = (Vec::new(), Vec::new());
    while let Some(next) = board.next_event().filter(|next| *next <= at_ms(until)) {
        board.poll(next, &mut events).unwrap();
    }
    board.poll(at_ms(until), &mut events).unwrap();
    for event in events {
        if let BoardEvent::Changed {
            channel: ChannelId(relay @ (1..=3 | 5)),
            at,
            value: Value::Bool(on),
            ..
        } = event
        {
            moves.push(((at.latest - Time::ZERO).as_nanos() / 1_000_000, relay, on));
        }
    }
    moves
}

/// Polls away what the start reports.
fn begun() -> FaultRelays<SimulatedBoard> {
    let mut board = board();
    assert_eq!(moves(&mut board, 0).len(), 4, "the relays are told off at the start");
    board
}

#[test]
fn a_fault_drives_its_relay_and_its_end_lets_it_go() {
    let mut board = begun();
    board.inject(at_ms(5), fault(0, FaultKind::Open, Some(40))).unwrap();
    assert_eq!(
        (board.fault_settled_at(ChannelId(0)), board.fault_switching_time(ChannelId(0))),
        (None, SETTLE)
    );
    assert_eq!(moves(&mut board, 14), [(5, 1, true)]);
    assert_eq!(board.fault_settled_at(ChannelId(0)), None);
    assert_eq!(moves(&mut board, 15), []);
    assert_eq!(
        board.fault_settled_at(ChannelId(0)),
        Some(When::within(at_ms(5), at_ms(15))),
        "the contact has settled"
    );
    assert_eq!(moves(&mut board, 44), []);
    assert_eq!(moves(&mut board, 60), [(45, 1, false)]);
    assert_eq!(board.next_event(), None);
}

#[test]
fn one_relay_opens_before_another_closes() {
    let mut board = begun();
    board.inject(at_ms(0), fault(0, FaultKind::ShortToGround, None)).unwrap();
    board.inject(at_ms(2), fault(0, FaultKind::ShortToSupply, Some(100))).unwrap();
    // The first one settles, opens, settles; then the second closes. After its end the older fault is back.
    let expected = [(0, 2, true), (10, 2, false), (20, 3, true), (102, 3, false), (112, 2, true)];
    assert_eq!(moves(&mut board, 150), expected);
    board.clear_faults(at_ms(150), ChannelId(0)).unwrap();
    assert_eq!(moves(&mut board, 200), [(150, 2, false)]);
}

#[test]
fn a_wire_that_can_be_seen_tells_when_it_is_shorted() {
    let mut board = begun();
    let level = |board: &mut FaultRelays<SimulatedBoard>, ms, high| {
        board.write(at_ms(ms), &[(ChannelId(0), Value::Bool(high))]).unwrap();
        moves(board, ms);
        board.fault_settled_at(ChannelId(0))
    };
    board.inject(at_ms(0), fault(0, FaultKind::ShortToGround, None)).unwrap();
    moves(&mut board, 1);
    // What the world does to the wire meanwhile is not yet the short, whose level is 0.
    assert_eq!(level(&mut board, 2, true), None);
    assert_eq!(level(&mut board, 3, false), Some(When::exactly(at_ms(3))));
    // Asked for once more it is there already; and of a wire that opens any change shows it.
    moves(&mut board, 20);
    board.inject(at_ms(20), fault(0, FaultKind::ShortToGround, None)).unwrap();
    assert_eq!(board.fault_settled_at(ChannelId(0)), Some(When::exactly(at_ms(20))));
    board.clear_faults(at_ms(21), ChannelId(0)).unwrap();
    moves(&mut board, 22);
    assert_eq!(board.fault_settled_at(ChannelId(0)), None);
    assert_eq!(level(&mut board, 23, true), Some(When::exactly(at_ms(23))));
}

#[test]
fn a_level_is_held_and_a_glitch_is_one_only_where_relays_have_the_time() {
    let mut board = begun();
    board.inject(at_ms(0), fault(0, FaultKind::StuckAt(Value::Bool(true)), Some(20))).unwrap();
    assert_eq!(moves(&mut board, 40), [(0, 3, true), (20, 3, false)]);
    let glitch = |ms| FaultKind::Glitch { value: Value::Bool(false), width: Span::from_millis(ms) };
    board.inject(at_ms(40), fault(0, glitch(20), None)).unwrap();
    assert_eq!(moves(&mut board, 80), [(40, 2, true), (60, 2, false)]);
    let none = Err(BoardError::NoSuchFault(ChannelId(0)));
    assert_eq!(board.inject(at_ms(80), fault(0, glitch(19), None)), none);
    assert_eq!(board.inject(at_ms(80), fault(0, FaultKind::Open, Some(19))), none);
    assert_eq!(board.inject(at_ms(80), fault(0, FaultKind::Late(SETTLE), None)), none);
    let none = Err(BoardError::NoSuchFault(ChannelId(4)));
    assert_eq!(board.inject(at_ms(80), fault(4, FaultKind::StuckAt(Value::Bool(false)), None)), none);
    let none = Err(BoardError::NoSuchFault(ChannelId(1)));
    assert_eq!(board.inject(at_ms(80), fault(1, FaultKind::Open, None)), none);
}

#[test]
fn wires_that_keep_apart_have_no_fault_together() {
    let mut board = begun();
    board.inject(at_ms(0), fault(0, FaultKind::ShortToGround, Some(30))).unwrap();
    let apart = BoardError::FaultsApart { channel: ChannelId(4), other: ChannelId(0) };
    assert_eq!(board.inject(at_ms(10), fault(4, FaultKind::ShortToSupply, None)), Err(apart));
    // The fault is over, its relay on its way back: the other waits for it.
    assert_eq!(moves(&mut board, 32), [(0, 2, true), (30, 2, false)]);
    board.inject(at_ms(32), fault(4, FaultKind::ShortToSupply, None)).unwrap();
    assert_eq!(moves(&mut board, 60), [(40, 5, true)]);
    let apart = BoardError::FaultsApart { channel: ChannelId(0), other: ChannelId(4) };
    assert_eq!(board.inject(at_ms(60), fault(0, FaultKind::Open, None)), Err(apart));
}

#[test]
fn nothing_but_a_fault_drives_a_relay_and_safe_lets_all_go() {
    let mut board = begun();
    let relay = ChannelId(2);
    assert!(!board.channels()[2].drives && board.channels()[0].drives);
    assert_eq!(board.write(at_ms(1), &[(relay, Value::Bool(true))]), Err(BoardError::NotDriven(relay)));
    board.inject(at_ms(1), fault(0, FaultKind::ShortToGround, None)).unwrap();
    assert_eq!(moves(&mut board, 5), [(1, 2, true)]);
    board.safe(at_ms(6)).unwrap();
    assert_eq!(moves(&mut board, 100), [(6, 2, false)], "nothing comes back behind a safe state");
    board.start(at_ms(100)).unwrap();
    assert!(moves(&mut board, 200).iter().all(|(_, _, on)| !on));
}

#[test]
fn as_many_faults_as_on_a_simulated_line() {
    let mut board = begun();
    for _ in 0..8 {
        board.inject(at_ms(1), fault(0, FaultKind::Open, None)).unwrap();
    }
    let many = BoardError::TooManyFaults { channel: ChannelId(0), limit: 8 };
    assert_eq!(board.inject(at_ms(1), fault(0, FaultKind::Open, None)), Err(many));
    assert_eq!(
        board.inject(at_ms(1), fault(9, FaultKind::Open, None)),
        Err(BoardError::NoChannel(ChannelId(9)))
    );
}

proptest! {
    /// Whatever is asked for and whenever: of a wire two relays are never on together, each has its time to settle
    /// before another one moves, wires that keep apart are never faulty together, and all of it ends.
    #[test]
    fn no_two_relays_meet(asked in prop::collection::vec((0u8..6, 0i64..40, 20i64..90), 1..30)) {
        let mut board = begun();
        let (mut now, mut all) = (0, Vec::new());
        for (what, wait, lasts) in asked {
            now += wait;
            all.extend(moves(&mut board, now));
            let kind = [FaultKind::Open, FaultKind::ShortToGround, FaultKind::ShortToSupply];
            let outcome = match what {
                0..=2 => board.inject(at_ms(now), fault(0, kind[usize::from(what)], Some(lasts))),
                3 => board.inject(at_ms(now), fault(4, FaultKind::ShortToSupply, Some(lasts))),
                _ => board.clear_faults(at_ms(now), ChannelId(u16::from(what - 4) * 4)),
            };
            let refused = matches!(
                outcome, Err(BoardError::FaultsApart { .. } | BoardError::TooManyFaults { .. })
            );
            prop_assert!(outcome.is_ok() || refused, "{outcome:?}");
        }
        all.extend(moves(&mut board, now + 1_000));
        let mut last = [None::<(i64, bool)>; 6];
        for (at, relay, on) in all {
            let others = (1..6u16).filter(|other| *other != relay);
            for other in others.map(usize::from) {
                if let Some((moved, other_on)) = last[other] {
                    prop_assert!(!on || !other_on, "{relay} meets {other} at {at}");
                    prop_assert!(!on || at >= moved + 10, "{relay} closes at {at}, {other} moved at {moved}");
                }
            }
            if let Some((moved, was)) = last[usize::from(relay)] {
                prop_assert!(was != on && at >= moved + 10, "{relay} moves at {at} and {moved}");
            }
            last[usize::from(relay)] = Some((at, on));
        }
        prop_assert!(last.iter().flatten().all(|(_, on)| !on), "{last:?}");
    }
}
