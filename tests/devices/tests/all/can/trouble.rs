//! Buses in trouble: what controllers report, queues that fill up, interfaces that go away.

use devices::Lab;
use drivers::{BoardError, BoardExt, BusError, BusEvent, BusState, LossReason};
use host::{Realtime, ThreadRole};
use signal::{CanFrame, Span};

use super::bench::{Bench, FAR, NEAR, TROUBLED, Trouble, fresh, run};

fn frame(id: u32) -> CanFrame {
    CanFrame::classic(id, false, &[0x55; 8]).unwrap()
}

fn state(state: BusState) -> impl Fn(&BusEvent) -> bool {
    move |event| matches!(event, BusEvent::State { state: now, .. } if *now == state)
}

fn error(error: BusError) -> impl Fn(&BusEvent) -> bool {
    move |event| matches!(event, BusEvent::Error { error: now, .. } if *now == error)
}

fn lost(why: LossReason) -> impl Fn(&BusEvent) -> bool {
    move |event| matches!(event, BusEvent::Lost { reason, .. } if *reason == why)
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_controller_that_goes_bus_off_is_seen_by_its_states_and_sends_again_after_its_restart() {
    let _lab = Lab::enter();
    fresh("restart-ms 100");
    let buses = TROUBLED.replace(" }", ", restart = \"100 ms\" }");
    let mut bench = Bench::of(&buses);
    let spoiled = Trouble::on("rcan0", "fault", "bit-error");
    bench.send(NEAR, &frame(1));
    bench.until("bus-off", |bench| bench.reported(NEAR, state(BusState::BusOff)));
    drop(spoiled);
    let states: Vec<BusState> = bench
        .events
        .iter()
        .filter_map(|event| match event {
            BusEvent::State { bus, state, .. } if *bus == NEAR => Some(*state),
            _ => None,
        })
        .collect();
    assert_eq!(states, [BusState::ErrorWarning, BusState::ErrorPassive, BusState::BusOff]);
    // It waits for the restart.
    bench.send(NEAR, &frame(2));
    bench.until("the frame after the restart", |bench| {
        bench.frames(FAR).iter().any(|(_, got, _)| got.id == 2) && !bench.frames(NEAR).is_empty()
    });
    assert!(bench.reported(NEAR, state(BusState::ErrorActive)));
    let own: Vec<u32> = bench.frames(NEAR).iter().map(|(_, got, _)| got.id).collect();
    assert_eq!(own, [2]);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_frame_that_nobody_acknowledges_leaves_its_sender_error_passive() {
    let _lab = Lab::enter();
    fresh("berr-reporting on");
    let mut bench = Bench::of(TROUBLED);
    let alone = Trouble::on("rcan0", "fault", "no-ack");
    bench.send(NEAR, &frame(1));
    bench.until("error-passive", |bench| bench.reported(NEAR, state(BusState::ErrorPassive)));
    assert!(bench.reported(NEAR, error(BusError::NoAck)) && !bench.reported(NEAR, error(BusError::Protocol)));
    assert!(bench.frames(NEAR).is_empty());
    drop(alone);
    bench.until("the frame", |bench| bench.frames(NEAR).len() == 1 && bench.frames(FAR).len() == 1);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn lost_arbitration_and_an_overflow_are_reported() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let mut bench = Bench::of(TROUBLED);
    let _late = Trouble::on("rcan0", "lose_arbitration", "2");
    bench.send(NEAR, &frame(1));
    bench.until("the frame after a lost arbitration", |bench| {
        bench.frames(FAR).len() == 1 && bench.reported(NEAR, error(BusError::LostArbitration(None)))
    });
    let _full = Trouble::on("rcan1", "event", "rx-overflow");
    let dropped = |event: &BusEvent| matches!(event, BusEvent::Dropped { count: 1, .. });
    bench.until("the overflow", |bench| {
        bench.reported(FAR, error(BusError::ReceiveOverflow)) && bench.reported(FAR, dropped)
    });
    assert!(!bench.board.health().is_sound());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_bus_that_is_never_free_fills_the_queue_and_drains_it_later() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let mut bench = Bench::with("unresponsive-after = \"300 ms\"", TROUBLED);
    let stalled = Trouble::on("rcan0", "fault", "stall");
    let mut sent = 0;
    loop {
        let now = bench.now();
        match bench.board.send(now, NEAR, &frame(sent % 0x700)) {
            Ok(()) => sent += 1,
            Err(error) => {
                assert_eq!(error, BoardError::BusFull(NEAR));
                break;
            }
        }
        assert!(sent < 5_000, "the queue has no end");
    }
    bench.until("a frame that is late", |bench| bench.reported(NEAR, error(BusError::SendTimeout)));
    // A bus that is busy is no device that is lost.
    assert!(!bench.reported(NEAR, |event| matches!(event, BusEvent::Lost { .. })));
    drop(stalled);
    let all = |bench: &Bench, bus| bench.frames(bus).len() == sent as usize;
    bench.until("all of them, also as its own", |bench| all(bench, FAR) && all(bench, NEAR));
    assert!(bench.frames(NEAR).iter().all(|(_, _, own)| *own));
    // The kernel may hand two of them over in the other order: which there are counts, each as often as it was sent.
    let mut wanted: Vec<_> = (0..sent).map(|place| place % 0x700).collect();
    wanted.sort_unstable();
    for bus in [NEAR, FAR] {
        let mut ids: Vec<_> = bench.frames(bus).iter().map(|(_, got, _)| got.id).collect();
        ids.sort_unstable();
        assert_eq!(ids, wanted, "{bus:?}");
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_interface_that_goes_down_is_lost_until_the_next_run() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let mut bench = Bench::of(TROUBLED);
    run("ip link set rcan0 down");
    bench.until("the loss", |bench| bench.reported(NEAR, lost(LossReason::Gone)));
    assert!(!bench.reported(FAR, lost(LossReason::Gone)) && bench.board.health().lost == 1);
    let refused = bench.board.start(signal::Time::ZERO);
    let gone = matches!(refused, Err(BoardError::BusLost { bus: NEAR, reason: LossReason::Gone, .. }));
    assert!(gone && bench.board.bus_device(NEAR) == Some("rcan0"), "{refused:?}");
    fresh("restart-ms 0");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_interface_that_comes_back_is_taken_back_where_the_board_file_says_so() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let mut bench = Bench::with("unresponsive-after = \"5 s\"\nreconnect = true", TROUBLED);
    run("ip link set rcan0 down");
    bench.until("the loss", |bench| bench.reported(NEAR, lost(LossReason::Gone)));
    run("ip link set rcan0 up");
    let back = |event: &BusEvent| matches!(event, BusEvent::Returned { .. });
    bench.until("the return", |bench| bench.reported(NEAR, back));
    assert_eq!(bench.board.health().lost, 0);
    bench.send(NEAR, &frame(3));
    bench.until("a frame", |bench| bench.frames(FAR).iter().any(|(_, got, _)| got.id == 3));
    bench.start();
    bench.send(FAR, &frame(4));
    bench.until("a frame the other way", |bench| bench.frames(NEAR).iter().any(|(_, got, _)| got.id == 4));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_interface_that_is_removed_is_lost_and_a_new_one_of_its_name_taken_back() {
    let _lab = Lab::enter();
    run("ip link del vcan9 2>/dev/null; ip link add dev vcan9 type vcan && ip link set vcan9 up");
    let bus = "near = { kind = \"can\", interface = \"vcan9\", bitrate = 500_000 }";
    let mut bench = Bench::with("unresponsive-after = \"5 s\"\nreconnect = true", bus);
    bench.send(NEAR, &frame(1));
    bench.until("a frame", |bench| bench.frames(NEAR).len() == 1);
    run("ip link del vcan9");
    bench.until("the loss", |bench| bench.reported(NEAR, lost(LossReason::Gone)));
    run("ip link add dev vcan9 type vcan && ip link set vcan9 up");
    bench.until("the return", |bench| {
        bench.reported(NEAR, |event| matches!(event, BusEvent::Returned { .. }))
    });
    bench.send(NEAR, &frame(2));
    bench.until("a frame of the new one", |bench| bench.frames(NEAR).iter().any(|(_, got, _)| got.id == 2));
    run("ip link del vcan9");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_interface_that_comes_back_set_up_otherwise_stays_lost() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let mut bench = Bench::with("unresponsive-after = \"5 s\"\nreconnect = true", TROUBLED);
    run("ip link set rcan0 down");
    bench.until("the loss", |bench| bench.reported(NEAR, lost(LossReason::Gone)));
    run("ip link set rcan0 type can bitrate 250000 && ip link set rcan0 up && ip link set rcan0 down");
    run("ip link set rcan0 type can bitrate 500000 && ip link set rcan0 up");
    bench.until("the return", |bench| {
        bench.reported(NEAR, |event| matches!(event, BusEvent::Returned { .. }))
    });
    let returns = |bench: &Bench| {
        bench.events.iter().filter(|event| matches!(event, BusEvent::Returned { .. })).count()
    };
    assert_eq!(returns(&bench), 1);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_call_that_hangs_makes_its_bus_silent_and_holds_up_nobody() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let buses = format!("{TROUBLED}\nother = {{ kind = \"can\", interface = \"vcan0\", bitrate = 1 }}");
    let mut bench = Bench::with("unresponsive-after = \"300 ms\"", &buses);
    // The call keeps its processor busy: who is to go on meanwhile has to have the priority of a scan.
    Realtime::with_priority(80).enter(ThreadRole::Scan).expect("real-time priority");
    let _hangs = Trouble::on("rcan0", "hang_ms", "1500");
    let other = drivers::BusId(2);
    let asked = bench.now();
    bench.send(NEAR, &frame(1));
    bench.send(other, &frame(2));
    // The board's own calls come back at once.
    assert!(bench.now() < asked + Span::from_millis(300), "sending took until {}", bench.now());
    bench.until("silence", |bench| bench.reported(NEAR, lost(LossReason::Unresponsive)));
    let reported = bench.events.iter().find(|event| lost(LossReason::Unresponsive)(event)).unwrap().latest();
    assert!(reported >= asked + Span::from_millis(300), "{reported}");
    bench.until("the return", |bench| {
        bench.reported(NEAR, |event| matches!(event, BusEvent::Returned { .. }))
    });
    bench.until("the frames", |bench| bench.frames(FAR).len() == 1 && bench.frames(other).len() == 1);
}
