//! Frames both ways, with their instants.

use std::process::{Command, Stdio};

use devices::Lab;
use drivers::{BoardError, BoardExt, BusEvent};
use signal::{CanFrame, Span};

use super::bench::{Bench, CLASSIC, FAR, NEAR, TROUBLED, fresh};

fn frame(id: u32, data: &[u8]) -> CanFrame {
    CanFrame::classic(id, id > 0x7FF, data).unwrap()
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_frame_is_reported_as_own_by_its_sender_and_as_anothers_on_the_far_side() {
    let _lab = Lab::enter();
    let mut bench = Bench::of(CLASSIC);
    let frames = [frame(0x123, &[1, 2, 3]), frame(0x18FE_F100, &[0xFF; 8]), frame(0, &[])];
    for each in &frames {
        bench.send(NEAR, each);
    }
    bench.until("three frames on both sides", |bench| {
        bench.frames(NEAR).len() == 3 && bench.frames(FAR).len() == 3
    });
    for (place, wanted) in frames.iter().enumerate() {
        let (own, others) = (bench.frames(NEAR)[place], bench.frames(FAR)[place]);
        assert_eq!((own.1, own.2), (*wanted, true));
        assert_eq!((others.1, others.2), (*wanted, false));
    }
    assert!(bench.board.health().is_sound());
}

/// On the controllers of the lab's own: those of the emulator lose their way after such a frame.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_remote_frame_passes_with_the_length_that_it_asks_for() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let mut bench = Bench::of(TROUBLED);
    let all = [CanFrame { remote: true, len: 4, ..frame(0x700, &[]) }, frame(0x701, &[1])];
    for each in &all {
        bench.send(NEAR, each);
    }
    bench.until("both", |bench| bench.frames(FAR).len() == 2);
    let got: Vec<CanFrame> = bench.frames(FAR).iter().map(|(_, frame, _)| *frame).collect();
    assert_eq!(got, all);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn frames_come_with_the_instant_at_which_the_kernel_had_them() {
    let _lab = Lab::enter();
    fresh("restart-ms 0");
    let mut bench = Bench::of(TROUBLED);
    let asked = bench.now();
    bench.send(NEAR, &frame(0x123, &[0x55; 8]));
    bench.until("a frame", |bench| !bench.frames(FAR).is_empty());
    let reported = bench.now();
    let (at, ..) = bench.frames(FAR)[0];
    // 8 bytes at 500 kbit/s take 224 us on the wire, as the controller counts them.
    assert!(at.latest >= asked + Span::from_micros(200), "asked at {asked}, on the bus at {at:?}");
    assert!(
        at.earliest >= asked && at.latest <= reported,
        "asked at {asked}, reported at {reported}: {at:?}"
    );
    // How well the wall clock is known against the monotonic one, beside a compiler.
    assert!(at.latest - at.earliest < Span::from_millis(20), "{at:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn setting_the_wall_clock_moves_no_frame() {
    let _lab = Lab::enter();
    let mut bench = Bench::of(CLASSIC);
    let set = |seconds: i64| {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs();
        super::bench::run(&format!("date -s @{}", now as i64 + seconds));
    };
    set(3_600);
    let asked = bench.now();
    bench.send(NEAR, &frame(1, &[]));
    bench.until("the frame", |bench| !bench.frames(FAR).is_empty());
    set(-3_600);
    bench.send(NEAR, &frame(2, &[]));
    bench.until("another frame", |bench| bench.frames(FAR).len() == 2);
    let reported = bench.now();
    for (at, ..) in bench.frames(FAR) {
        // The instant is inside what is claimed, whatever the wall clock did.
        assert!(at.earliest <= at.latest && at.latest >= asked && at.latest <= reported, "{at:?}");
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn frames_of_can_fd_pass_with_their_flags() {
    let _lab = Lab::enter();
    let buses = "near = { kind = \"can\", interface = \"can2\", bitrate = 500_000, data-bitrate = 2_000_000 }\n\
                 far = { kind = \"can\", interface = \"can3\", bitrate = 500_000, data-bitrate = 2_000_000 }";
    let mut bench = Bench::of(buses);
    let mut long = CanFrame { fd: true, brs: true, len: 64, ..frame(0x321, &[]) };
    for (place, byte) in long.data.iter_mut().enumerate() {
        *byte = place as u8;
    }
    let slow = CanFrame { fd: true, len: 12, ..frame(0x18FE_F100, &[]) };
    let all = [long, slow, frame(5, &[1])];
    for each in &all {
        bench.send(NEAR, each);
    }
    bench.until("three frames", |bench| bench.frames(FAR).len() == 3);
    let got: Vec<CanFrame> = bench.frames(FAR).iter().map(|(_, frame, _)| *frame).collect();
    assert_eq!(got, all);
    let wrong = CanFrame { len: 9, ..long };
    let now = bench.now();
    assert_eq!(bench.board.send(now, NEAR, &wrong), Err(BoardError::BadFrame(NEAR)));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn what_a_bus_cannot_carry_is_refused_at_once() {
    let _lab = Lab::enter();
    let mut bench = Bench::of(CLASSIC);
    let now = bench.now();
    let fd = CanFrame { fd: true, len: 12, ..frame(1, &[]) };
    assert_eq!(bench.board.send(now, NEAR, &fd), Err(BoardError::BadFrame(NEAR)));
    let other = drivers::BusId(7);
    assert_eq!(bench.board.send(now, other, &frame(1, &[])), Err(BoardError::NoBus(other)));
    bench.board.safe(now).unwrap();
    assert_eq!(bench.board.send(now, NEAR, &frame(1, &[])), Err(BoardError::Latched));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn the_kernel_hands_over_only_what_a_bus_accepts() {
    let _lab = Lab::enter();
    let accept = "accept = [\"700/780\", \"18FEF100\"] }";
    fresh("restart-ms 0");
    let buses = TROUBLED.trim_end_matches('}').to_owned() + ", " + accept;
    let mut bench = Bench::of(&buses);
    for id in [0x123, 0x701, 0x18FE_F101, 0x18FE_F100, 0x77F] {
        bench.send(NEAR, &frame(id, &[]));
    }
    bench.until("the last frame", |bench| bench.frames(FAR).iter().any(|(_, frame, _)| frame.id == 0x77F));
    let ids: Vec<u32> = bench.frames(FAR).iter().map(|(_, frame, _)| frame.id).collect();
    assert_eq!(ids, [0x701, 0x18FE_F100, 0x77F]);
    // Nobody would see it on the bus.
    let now = bench.now();
    assert_eq!(bench.board.send(now, FAR, &frame(0x123, &[])), Err(BoardError::BadFrame(FAR)));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_busy_bus_is_heard_whole_and_in_order() {
    let _lab = Lab::enter();
    // These controllers take the time of the wire; the others' queues overflow when frames come without any.
    fresh("restart-ms 0");
    let mut bench = Bench::of(TROUBLED);
    const COUNT: usize = 500;
    let mut sent = 0;
    while sent < COUNT {
        let data = (sent as u32).to_be_bytes();
        let now = bench.now();
        match bench.board.send(now, NEAR, &frame(0x100, &data)) {
            Ok(()) => sent += 1,
            Err(BoardError::BusFull(_)) => bench.until("room", |_| true),
            Err(error) => panic!("{error}"),
        }
    }
    bench.until("all of them", |bench| bench.frames(FAR).len() == COUNT && bench.frames(NEAR).len() == COUNT);
    for bus in [NEAR, FAR] {
        let order = bench.frames(bus);
        let wrong = order.iter().zip(0u32..).position(|((_, frame, _), n)| frame.data() != n.to_be_bytes());
        let around = wrong.map(|at| &order[at.saturating_sub(2)..(at + 4).min(COUNT)]);
        assert_eq!(around, None, "bus {bus:?}, frame {wrong:?}");
        assert!(order.windows(2).all(|two| two[0].0.latest <= two[1].0.latest));
    }
    assert!(
        bench.board.health().is_sound() && !bench.reported(FAR, |e| matches!(e, BusEvent::Dropped { .. }))
    );
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn other_programs_hear_the_rig_and_are_heard() {
    let _lab = Lab::enter();
    let mut bench = Bench::of("near = { kind = \"can\", interface = \"can0\", bitrate = 500_000 }");
    let heard = Command::new("candump").args(["-n", "1", "can1"]).stdout(Stdio::piped()).spawn().unwrap();
    // It listens as soon as it is known: frames are sent until it has one.
    let mut heard = heard;
    bench.until("candump to hear", |_| {
        super::bench::run("cansend can1 5A1#11.22.33");
        heard.try_wait().unwrap().is_some()
    });
    let mut text = String::new();
    std::io::Read::read_to_string(&mut heard.stdout.take().unwrap(), &mut text).unwrap();
    assert!(text.contains("5A1") && text.contains("11 22 33"), "{text}");
    assert!(bench.frames(NEAR).iter().all(|(_, got, own)| *got == frame(0x5A1, &[0x11, 0x22, 0x33]) && !own));
    bench.send(NEAR, &frame(0x123, &[]));
    bench.until("the own frame", |bench| bench.frames(NEAR).iter().any(|(_, _, own)| *own));
}
