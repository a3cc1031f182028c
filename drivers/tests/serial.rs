//! Serial lines without the lab: board files, and ports over pseudo-terminals, which have bytes and a far end that can
//! go away, but no bits. Ports of the kernel are tested in the lab.

use std::fs::File;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use document::SourceFile;
use host::{HostInstant, Realtime};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use scanrig_drivers::serial::{
    MessageAssembler, MessageTiming, OpenError, PortSpec, Received, ReceivedMessage, SerialLinesSpec,
    SerialPort, Symbol,
};
use scanrig_drivers::{
    BoardContext, BoardError, BoardExt, BoardFile, BoardKind, BusError, BusEvent, BusId, BusKind, LossReason,
    Terminals, build, open, read,
};
use signal::{
    CanFrame, Parity, SerialErrors, SerialFlaw, SerialMessage, SerialOutput, SerialSettings, Span, Time,
};
use tokio::runtime::{Builder, Runtime};

const PATIENCE: Span = Span::from_secs(20);

/// The far end of a pseudo-terminal, and the path of the near one.
fn pair() -> (File, PathBuf) {
    let far = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&far).unwrap();
    unlockpt(&far).unwrap();
    let near = ptsname(&far, Vec::new()).unwrap();
    (File::from(far), PathBuf::from(near.into_string().unwrap()))
}

fn runtime() -> Runtime {
    Builder::new_current_thread().enable_io().build().unwrap()
}

fn spec(path: PathBuf) -> PortSpec {
    PortSpec { path, line: SerialSettings::default(), rs485: None, low_latency: None, exclusive: true }
}

fn until() -> HostInstant {
    HostInstant::now() + PATIENCE
}

fn file(text: &str) -> Result<BoardFile, Vec<document::Diagnostic>> {
    read(&SourceFile::new("board.toml", text), &|_| Ok(Terminals::default()))
}

fn board_on(path: &std::path::Path, keys: &str) -> BoardFile {
    let path = path.display();
    file(&format!(
        "format = 1\n[board]\nkind = \"real\"\nunresponsive-after = \"1 s\"\n{keys}\n[buses]\n\
         modbus = {{ kind = \"serial\", path = \"{path}\" }}\n"
    ))
    .unwrap()
}

/// A fast port whose messages end late.
fn slow_board_on(path: &std::path::Path) -> BoardFile {
    let path = path.display();
    file(&format!(
        "format = 1\n[board]\nkind = \"real\"\nunresponsive-after = \"20 s\"\n[buses]\n\
         modbus = {{ kind = \"serial\", path = \"{path}\", baud = 4_000_000, message-gap = \"500 ms\" }}\n"
    ))
    .unwrap()
}

#[test]
fn a_serial_line_is_what_its_board_file_says() {
    let board = file(
        "format = 1\n[board]\nkind = \"real\"\n[buses]\nplain = { kind = \"serial\", path = \"/dev/ttyS0\" }\n\
         [buses.modbus]\nkind = \"serial\"\npath = \"/dev/serial/by-id/x\"\nbaud = 250_000\ndata-bits = 7\n\
         parity = \"odd\"\nstop-bits = 2\nlow-latency = true\nexclusive = false\n\
         rs485 = { rts-on-send = \"low\", delay-before = \"2 ms\", delay-after = \"0 ms\", hears-itself = true }\n",
    )
    .unwrap();
    let BoardKind::Real(spec) = &board.kind else { panic!("{:?}", board.kind) };
    let [plain, modbus] = spec.of::<SerialLinesSpec>().unwrap().lines.as_slice() else { panic!("{spec:?}") };
    assert_eq!((plain.port.line, plain.port.exclusive), (SerialSettings::default(), true));
    assert_eq!(plain.port.line.to_string(), "19200 Bd 8E1");
    assert_eq!((plain.port.rs485, plain.port.low_latency), (None, None));
    let line = SerialSettings { baud: 250_000, data_bits: 7, parity: Parity::Odd, stop_bits: 2 };
    assert_eq!((modbus.port.line, modbus.port.exclusive, modbus.bus), (line, false, BusId(1)));
    assert_eq!(modbus.port.low_latency, Some(true));
    let rs485 = modbus.port.rs485.unwrap();
    assert!(rs485.enabled && !rs485.rts_on_send && rs485.rts_after_send && rs485.rx_during_tx);
    assert_eq!((rs485.delay_before, rs485.delay_after, rs485.terminate), (2, 0, false));
    // On paper, the board has its buses on any machine.
    let outline = build(&board, 0).unwrap();
    let named: Vec<_> = outline.bus_list().iter().map(|bus| (bus.name.as_str(), bus.kind)).collect();
    let serial = |settings| BusKind::Serial { settings };
    assert_eq!(named, [("plain", serial(plain.port.line)), ("modbus", serial(modbus.port.line))]);
}

#[test]
fn bytes_go_both_ways_as_they_are() {
    let (mut far, near) = pair();
    let runtime = runtime();
    runtime.block_on(async {
        let mut port = SerialPort::open(&spec(near)).unwrap();
        assert!(port.is_pseudo());
        // A marked byte is the mark itself: 377 has to come through.
        let all: Vec<u8> = (0..=255).collect();
        far.write_all(&all).unwrap();
        let (mut got, mut received) = (Vec::new(), Received::with_room());
        while got.len() < all.len() {
            let before = HostInstant::now();
            assert!(port.receive(until(), &mut received).await.unwrap());
            assert!(received.empty <= received.read && before <= received.read);
            got.extend_from_slice(&received.symbols);
        }
        assert_eq!(got, all.iter().copied().map(Symbol::Byte).collect::<Vec<_>>());
        let sending = port.send(&all, until()).await.unwrap();
        let mut back = vec![0; all.len()];
        far.read_exact(&mut back).unwrap();
        assert_eq!(back, all);
        let (earliest, latest) = port.drain(sending, until()).await.unwrap();
        assert!(sending.begun <= earliest && earliest <= latest && latest <= HostInstant::now());
        assert_eq!(port.counters().unwrap(), None);
    });
}

#[test]
fn a_wait_for_bytes_ends_when_it_is_due_and_says_since_when_nothing_came() {
    let (_far, near) = pair();
    runtime().block_on(async {
        let mut port = SerialPort::open(&spec(near)).unwrap();
        let due = HostInstant::now() + Span::from_millis(3);
        assert!(!port.receive(due, &mut Received::with_room()).await.unwrap());
        assert!(HostInstant::now() >= due);
    });
}

#[test]
fn the_last_look_that_found_nothing_lies_before_the_bytes_were_there() {
    let (mut far, near) = pair();
    runtime().block_on(async {
        let mut port = SerialPort::open(&PortSpec { exclusive: false, ..spec(near.clone()) }).unwrap();
        far.write_all(b"x").unwrap();
        let due = until();
        let other = File::open(near).unwrap();
        while rustix::io::ioctl_fionread(&other).unwrap() == 0 {
            assert!(HostInstant::now() < due, "the byte does not come");
            std::thread::yield_now();
        }
        let there = HostInstant::now();
        let mut received = Received::with_room();
        assert!(port.receive(until(), &mut received).await.unwrap());
        assert!(received.empty < there && there <= received.read, "{received:?}, there at {there:?}");
    });
}

#[test]
fn silence_ends_a_message() {
    let (mut far, near) = pair();
    runtime().block_on(async {
        let mut port = SerialPort::open(&spec(near)).unwrap();
        let mut assembler = MessageAssembler::new(MessageTiming::modbus_rtu(port.line()));
        let mut room = Received::with_room();
        for request in [&b"\x01\x03\x00\x00\x00\x0A\xC5\xCD"[..], b"second", b"\xFF"] {
            far.write_all(request).unwrap();
            let sent = HostInstant::now();
            let mut got = Vec::new();
            let each = |received: &ReceivedMessage| got.push(received.message);
            assert!(port.messages(&mut assembler, until(), &mut room, each).await.unwrap());
            let [message] = got[..] else { panic!("{got:?}") };
            assert_eq!((message.data(), message.is_sound()), (request, true));
            assert!(HostInstant::now() - sent >= port.line().frame_gap());
        }
        let none = |received: &ReceivedMessage| panic!("{received:?}");
        assert!(!port.messages(&mut assembler, HostInstant::now(), &mut room, none).await.unwrap());
    });
}

#[test]
fn a_port_whose_far_end_is_gone_says_so() {
    let (far, near) = pair();
    runtime().block_on(async {
        let mut port = SerialPort::open(&spec(near)).unwrap();
        drop(far);
        let error = port.receive(until(), &mut Received::with_room()).await.unwrap_err();
        assert!(error.is_gone(), "{error}");
        assert!(port.send(b"x", until()).await.unwrap_err().is_gone());
    });
}

#[test]
fn what_is_held_or_is_no_port_is_refused() {
    let (_far, near) = pair();
    let runtime = runtime();
    let _inside = runtime.enter();
    let first = SerialPort::open(&spec(near.clone())).unwrap();
    assert_eq!(SerialPort::open(&spec(near.clone())).unwrap_err(), OpenError::Busy(near.clone()));
    // The first one was not disturbed by the attempt: it is still its own.
    assert_eq!(SerialPort::open(&spec(near.clone())).unwrap_err(), OpenError::Busy(near.clone()));
    drop(first);
    let shared = PortSpec { exclusive: false, ..spec(near.clone()) };
    let _one = SerialPort::open(&shared).unwrap();
    let _other = SerialPort::open(&shared).unwrap();
    assert_eq!(
        SerialPort::open(&spec("/dev/null".into())).unwrap_err(),
        OpenError::NoPort("/dev/null".into())
    );
    let missing = SerialPort::open(&spec("/dev/ttyNOWHERE".into())).unwrap_err();
    assert!(missing.is_gone(), "{missing}");
}

#[test]
fn a_claim_that_a_killed_program_left_on_a_pseudo_terminal_is_not_taken_for_a_holder() {
    if !rustix::process::geteuid().is_root() {
        eprintln!("skipped: the kernel keeps all but root from such a pseudo-terminal");
        return;
    }
    let (_far, near) = pair();
    let runtime = runtime();
    let _inside = runtime.enter();
    // Its file is closed, as the kernel closes those of a killed program, and the flag stays.
    let killed = File::options().read(true).write(true).open(&near).unwrap();
    rustix::termios::ioctl_tiocexcl(&killed).unwrap();
    assert_eq!(SerialPort::open(&spec(near.clone())).unwrap_err(), OpenError::Busy(near.clone()));
    drop(killed);
    SerialPort::open(&spec(near)).unwrap();
}

#[test]
fn a_look_does_not_take_a_file_for_a_port() {
    let file = std::env::temp_dir().join(format!("scanrig-no-port-{}", std::process::id()));
    std::fs::write(&file, "").unwrap();
    for path in ["/dev/null", file.to_str().unwrap()] {
        let board = board_on(path.as_ref(), "");
        let BoardKind::Real(spec) = &board.kind else { panic!("a real board") };
        let look = scanrig_drivers::real::look(&board.channel_table(), spec);
        let codes: Vec<&str> = look.found.iter().map(|found| found.code).collect();
        assert_eq!(codes, ["B0147"], "{path}");
    }
    std::fs::remove_file(file).unwrap();
}

#[test]
fn what_a_port_cannot_do_is_said_by_its_key() {
    let (_far, near) = pair();
    let runtime = runtime();
    let _inside = runtime.enter();
    let key = |spec: PortSpec| match SerialPort::open(&spec).unwrap_err() {
        OpenError::Unable { what, .. } => what.key(),
        other => panic!("{other}"),
    };
    let rs485 = host::Rs485 { enabled: true, rts_on_send: true, ..host::Rs485::default() };
    assert_eq!(key(PortSpec { rs485: Some(rs485), ..spec(near.clone()) }), "rs485");
    assert_eq!(key(PortSpec { low_latency: Some(true), ..spec(near) }), "low-latency");
}

#[test]
fn ports_that_cannot_be_had_are_told_by_place() {
    let refused = |path: &str| {
        let found = open(&board_on(path.as_ref(), ""), &BoardContext::new(Realtime::default())).unwrap_err();
        assert!(!found[0].help.is_empty() && found[0].labels.len() == 1, "{found:?}");
        found[0].code
    };
    assert_eq!(refused("/dev/ttyNOWHERE"), "B0144");
    assert_eq!(refused("/dev/null"), "B0147");
    let (_far, near) = pair();
    let context = BoardContext::new(Realtime::default());
    let _held = open(&board_on(&near, ""), &context).unwrap();
    assert_eq!(refused(near.to_str().unwrap()), "B0145");
}

/// Polls the board's buses until they report something.
fn told(board: &mut dyn scanrig_drivers::Board, at: &BoardContext) -> Vec<BusEvent> {
    let mut events = Vec::new();
    let deadline = Instant::now() + Duration::from_secs(20);
    while events.is_empty() {
        assert!(Instant::now() < deadline, "the buses have nothing to tell");
        at.bell.wait_until(HostInstant::now() + Span::from_millis(20));
        board.poll_buses(at.time.now(), &mut events).unwrap();
    }
    events
}

#[test]
fn a_line_that_goes_away_is_lost_until_the_next_run() {
    let (far, near) = pair();
    let at = BoardContext::new(Realtime::default());
    let mut board = open(&board_on(&near, ""), &at).unwrap().unwrap();
    let bus = BusId(0);
    assert_eq!(board.bus_list()[0].name, "modbus");
    board.start(at.time.now()).unwrap();
    assert_eq!(
        board.send(at.time.now(), bus, &CanFrame::classic(1, false, &[]).unwrap()),
        Err(BoardError::BadFrame(bus))
    );
    let mut events = Vec::new();
    board.poll_buses(at.time.now(), &mut events).unwrap();
    assert!(events.is_empty() && board.health().is_sound());
    drop(far);
    let events = told(&mut *board, &at);
    assert!(
        matches!(events[..], [BusEvent::Lost { bus: BusId(0), reason: LossReason::Gone, .. }]),
        "{events:?}"
    );
    assert_eq!((board.health().lost, board.health().is_sound()), (1, false));
    // Nobody would send it.
    let refused = board.send_serial(at.time.now(), bus, &SerialOutput::plain(b"x"));
    assert!(
        matches!(refused, Err(BoardError::BusLost { bus: BusId(0), reason: LossReason::Gone, .. })),
        "{refused:?}"
    );
    board.safe(at.time.now()).unwrap();
    assert!(matches!(board.start(at.time.now()), Err(BoardError::BusLost { bus: BusId(0), .. })));
}

#[test]
fn a_long_message_comes_in_parts_and_what_is_left_of_it_is_not_of_the_next_run() {
    let (mut far, near) = pair();
    let at = BoardContext::new(Realtime::default());
    let mut board = open(&slow_board_on(&near), &at).unwrap().unwrap();
    board.start(at.time.now()).unwrap();
    far.write_all(&[b'a'; 600]).unwrap();
    let mut parts = Vec::new();
    while parts.len() < 2 {
        parts.extend(told(&mut *board, &at).into_iter().map(|event| match event {
            BusEvent::SerialMessage { message, own: false, .. } => message,
            other => panic!("{other:?}"),
        }));
    }
    let shapes: Vec<(usize, bool, bool)> =
        parts.iter().map(|part| (part.data().len(), part.continues, part.ends)).collect();
    assert_eq!(shapes, [(256, false, false), (256, true, false)]);
    assert!(parts.iter().all(|part| !part.errors.any()));
    // 88 bytes of it wait for the silence. It is of the run that ends here.
    board.safe(at.time.now()).unwrap();
    board.start(at.time.now()).unwrap();
    far.write_all(b"new").unwrap();
    let events = told(&mut *board, &at);
    let [BusEvent::SerialMessage { message, own: false, .. }] = events[..] else { panic!("{events:?}") };
    assert_eq!((message.data(), message.continues), (&b"new"[..], false));
}

/// Orders outputs of these bytes until the far end, which reads nothing, has stopped them all; how many were taken.
fn fill(board: &mut dyn scanrig_drivers::Board, at: &BoardContext, byte: u8) -> usize {
    let output = SerialOutput::plain(&[byte; 256]);
    let (mut taken, mut refused) = (0, 0);
    while refused < 20 {
        match board.send_serial(at.time.now(), BusId(0), &output) {
            Ok(()) => (taken, refused) = (taken + 1, 0),
            Err(error) => {
                assert_eq!(error, BoardError::BusFull(BusId(0)));
                refused += 1;
                at.bell.wait_until(HostInstant::now() + Span::from_millis(5));
            }
        }
    }
    taken
}

#[test]
fn an_output_that_is_stuck_is_given_up_and_what_waits_is_not_sent_in_the_next_run() {
    let (mut far, near) = pair();
    let at = BoardContext::new(Realtime::default());
    let mut board = open(&slow_board_on(&near), &at).unwrap().unwrap();
    board.start(at.time.now()).unwrap();
    let taken = fill(&mut *board, &at, b'a');
    let begun = Instant::now();
    // At this speed an output takes microseconds, and gets a second more.
    while !told(&mut *board, &at)
        .iter()
        .any(|event| matches!(event, BusEvent::Error { error: BusError::SendTimeout, .. }))
    {
        assert!(begun.elapsed() < Duration::from_secs(20), "the output is not given up");
    }
    // Another one is stuck by now. A safe state does not wait for it to be given up.
    let patience = Span::from_secs(10);
    let before = HostInstant::now();
    board.safe(at.time.now()).unwrap();
    assert!(before.elapsed() < patience);
    board.start(at.time.now()).unwrap();
    board.send_serial(at.time.now(), BusId(0), &SerialOutput::plain(&[b'b'; 256])).unwrap();
    let (mut old, mut new, mut room) = (0, 0, [0; 1_024]);
    while new < 256 {
        let count = far.read(&mut room).unwrap();
        old += room[..count].iter().filter(|byte| **byte == b'a').count();
        new += room[..count].iter().filter(|byte| **byte == b'b').count();
    }
    // What waited for the thread is as many as its queue holds, and went nowhere.
    assert!(old <= (taken - 63) * 256, "{old} bytes of {taken} outputs");
}

#[test]
fn what_nobody_reads_does_not_pile_up() {
    let (mut far, near) = pair();
    let at = BoardContext::new(Realtime::default());
    let mut board = open(&board_on(&near, ""), &at).unwrap().unwrap();
    board.start(at.time.now()).unwrap();
    // More than the kernel keeps: this would never end otherwise.
    for _ in 0..64 {
        far.write_all(&[b'x'; 1024]).unwrap();
    }
    board.safe(at.time.now() + Span::from_nanos(1)).unwrap();
}

#[test]
fn what_comes_over_a_line_is_reported_and_what_is_sent_goes_out() {
    let (mut far, near) = pair();
    let at = BoardContext::new(Realtime::default());
    let mut board = open(&board_on(&near, ""), &at).unwrap().unwrap();
    let bus = BusId(0);
    board.start(at.time.now()).unwrap();
    far.write_all(b"hello").unwrap();
    let events = told(&mut *board, &at);
    let [BusEvent::SerialMessage { bus: BusId(0), message, own: false }] = events[..] else {
        panic!("{events:?}")
    };
    assert_eq!((message.data(), message.errors), (&b"hello"[..], SerialErrors::NONE));
    assert!(message.first.earliest <= message.last.latest && message.last.latest <= at.time.now());

    // Only a simulated line shapes single characters.
    let flaw = Some((0, SerialFlaw::Parity));
    let flawed = SerialOutput::Characters { data: vec![1], gap: Span::ZERO, flaw };
    assert_eq!(board.send_serial(at.time.now(), bus, &flawed), Err(BoardError::BadFrame(bus)));
    assert_eq!(
        board.send_serial(at.time.now(), BusId(7), &SerialOutput::plain(b"x")),
        Err(BoardError::NoBus(BusId(7)))
    );
    board.send_serial(at.time.now(), bus, &SerialOutput::plain(b"answer")).unwrap();
    let events = told(&mut *board, &at);
    assert!(
        matches!(events[..], [BusEvent::SerialMessage { message, own: true, .. }] if message.data() == b"answer"),
        "{events:?}"
    );
    let mut got = [0; 6];
    far.read_exact(&mut got).unwrap();
    assert_eq!(&got, b"answer");

    // Nothing goes out of a board that was made safe; what came meanwhile is not of the next run.
    board.safe(at.time.now()).unwrap();
    assert_eq!(board.send_serial(at.time.now(), bus, &SerialOutput::plain(b"x")), Err(BoardError::Latched));
}

fn simulated(keys_of_b: &str) -> Box<dyn scanrig_drivers::Board> {
    let text = format!(
        "format = 1\n[board]\nkind = \"simulated\"\n[buses]\na = {{ kind = \"serial\", baud = 9600, rs485 = {{}} }}\n\
         b = {{ kind = \"serial\", joins = \"a\"{keys_of_b} }}\n"
    );
    build(&file(&text).unwrap(), 0).unwrap()
}

/// What `b` hears of two bytes that `a` sends at 1 ms.
fn heard(board: &mut dyn scanrig_drivers::Board) -> SerialMessage {
    board.start(Time::ZERO).unwrap();
    let at = Time::ZERO + Span::from_millis(1);
    board.send_serial(at, BusId(0), &SerialOutput::plain(&[0x11, 0x07])).unwrap();
    let mut events = Vec::new();
    while let Some(next) = board.next_event() {
        board.poll_buses(next, &mut events).unwrap();
    }
    let mut received = events.iter().filter_map(|event| match event {
        BusEvent::SerialMessage { bus: BusId(1), message, own: false } => Some(*message),
        _ => None,
    });
    received.next_back().expect("nothing was heard")
}

#[test]
fn ends_of_a_simulated_line_hear_each_other_as_their_settings_allow() {
    let message = heard(&mut *simulated(", rs485 = {}"));
    // The other end has the settings of the first where it says none: 11 bits of 1/9600 s each.
    assert_eq!((message.data(), message.is_sound()), (&[0x11, 0x07][..], true));
    assert_eq!((message.last.latest - message.first.latest).as_nanos(), 22 * 1_000_000_000 / 9_600);

    let message = heard(&mut *simulated(", rs485 = {}, parity = \"odd\""));
    assert_eq!((message.data(), message.errors.parity), (&[0x11, 0x07][..], 2));
    let message = heard(&mut *simulated(", rs485 = {}, baud = 19_200"));
    assert!(message.errors.any() || message.data() != [0x11, 0x07]);
}

/// What `b` hears of bytes that `a` sends at these milliseconds.
fn heard_of(board: &mut dyn scanrig_drivers::Board, sends: &[(i64, &[u8])]) -> Vec<SerialMessage> {
    let mut events = Vec::new();
    for (millis, bytes) in sends {
        let at = Time::ZERO + Span::from_millis(*millis);
        board.poll_buses(at, &mut events).unwrap();
        board.send_serial(at, BusId(0), &SerialOutput::plain(bytes)).unwrap();
    }
    while let Some(next) = board.next_event() {
        board.poll_buses(next, &mut events).unwrap();
    }
    let message = |event: &BusEvent| match event {
        BusEvent::SerialMessage { bus: BusId(1), message, own: false } => Some(*message),
        _ => None,
    };
    events.iter().filter_map(message).collect()
}

#[test]
fn an_end_of_a_simulated_line_takes_other_settings_from_an_instant_on() {
    let file = SerialSettings { baud: 9_600, ..SerialSettings::default() };
    let other = SerialSettings { baud: 38_400, parity: Parity::Odd, stop_bits: 2, ..file };
    let (at, gap) = (|millis| Time::ZERO + Span::from_millis(millis), Span::from_millis(2));
    let mut board = simulated(", rs485 = {}");
    let sound = |message: &SerialMessage| message.is_sound() && message.data() == [0x11, 0x07];
    let bytes = &[0x11, 0x07][..];
    board.start(Time::ZERO).unwrap();
    // The ends disagree once one of them has other settings, and agree when the other one has them, too. What `a` sends
    // already goes out as it was.
    let [message] = heard_of(&mut *board, &[(1, bytes)])[..] else { panic!("not one message") };
    assert!(sound(&message));
    board.send_serial(at(100), BusId(0), &SerialOutput::plain(bytes)).unwrap();
    board.configure(at(100), BusId(0), &other, gap).unwrap();
    let [before, rest @ ..] = &heard_of(&mut *board, &[(200, bytes)])[..] else {
        panic!("nothing was heard")
    };
    assert!(sound(before) && !rest.iter().any(sound), "{before:?} {rest:?}");
    board.configure(at(300), BusId(1), &other, gap).unwrap();
    let [message] = heard_of(&mut *board, &[(400, bytes)])[..] else { panic!("not one message") };
    assert!(sound(&message));
    assert_eq!((message.last.latest - message.first.latest).as_nanos(), (12 + 11) * 1_000_000_000 / 38_400);
    // What was over by then was heard as before, also if nobody asked meanwhile.
    board.send_serial(at(500), BusId(0), &SerialOutput::plain(bytes)).unwrap();
    board.configure(at(600), BusId(1), &file, gap).unwrap();
    let [before, rest @ ..] = &heard_of(&mut *board, &[(700, bytes)])[..] else {
        panic!("nothing was heard")
    };
    assert!(sound(before) && !rest.iter().any(sound), "{before:?} {rest:?}");
    // A message that it is in the middle of is lost.
    board.configure(at(800), BusId(0), &file, gap).unwrap();
    board.send_serial(at(900), BusId(0), &SerialOutput::plain(bytes)).unwrap();
    board.configure(at(902), BusId(1), &file, gap).unwrap();
    assert!(!heard_of(&mut *board, &[]).iter().any(sound));
    // The next run begins with the file's.
    board.configure(at(1_000), BusId(0), &other, gap).unwrap();
    board.safe(at(1_001)).unwrap();
    assert_eq!(board.configure(at(1_001), BusId(0), &other, gap), Err(BoardError::Latched));
    board.start(Time::ZERO).unwrap();
    let [message] = heard_of(&mut *board, &[(1, bytes)])[..] else { panic!("not one message") };
    assert!(sound(&message));
}

#[test]
fn settings_that_a_line_cannot_have_are_refused() {
    let (now, gap, line) = (Time::ZERO, Span::from_millis(2), SerialSettings::default());
    let mut board = simulated(", rs485 = {}");
    board.start(now).unwrap();
    let refused = Err(BoardError::BadSettings(BusId(0)));
    for bad in [
        SerialSettings { baud: 0, ..line },
        SerialSettings { data_bits: 9, ..line },
        SerialSettings { stop_bits: 0, ..line },
    ] {
        assert_eq!(board.configure(now, BusId(0), &bad, gap), refused, "{bad}");
    }
    assert_eq!(board.configure(now, BusId(0), &line, Span::ZERO), refused);
    assert_eq!(board.configure(now, BusId(7), &line, gap), Err(BoardError::NoBus(BusId(7))));
}

/// A port of this machine is what its board file says.
#[test]
fn a_port_keeps_the_settings_of_its_board_file() {
    let (_far, near) = pair();
    let at = BoardContext::new(Realtime::default());
    let mut board = open(&board_on(&near, ""), &at).unwrap().unwrap();
    board.start(at.time.now()).unwrap();
    let line = SerialSettings::default();
    board.configure(at.time.now(), BusId(0), &line, line.frame_gap()).unwrap();
    let refused = Err(BoardError::BadSettings(BusId(0)));
    let other = SerialSettings { baud: 9_600, ..line };
    assert_eq!(board.configure(at.time.now(), BusId(0), &other, line.frame_gap()), refused);
    assert_eq!(board.configure(at.time.now(), BusId(0), &line, line.frame_gap() + line.frame_gap()), refused);
}

#[test]
fn a_simulated_line_needs_joined_ends_of_its_kind() {
    let codes = |buses: &str| -> Vec<&str> {
        let text = format!("format = 1\n[board]\nkind = \"simulated\"\n[buses]\n{buses}");
        file(&text).err().into_iter().flatten().map(|found| found.code).collect()
    };
    let a = "a = { kind = \"serial\" }\n";
    assert!(codes(&format!("{a}b = {{ kind = \"serial\", joins = \"a\" }}\n")).is_empty());
    let third = format!(
        "{a}b = {{ kind = \"serial\", joins = \"a\" }}\nc = {{ kind = \"serial\", joins = \"b\" }}\n"
    );
    assert_eq!(codes(&third), ["B0112"]);
    assert_eq!(codes(&format!("{a}b = {{ kind = \"serial\", joins = \"a\", rs485 = {{}} }}\n")), ["B0112"]);
    assert_eq!(codes(&format!("{a}b = {{ kind = \"can\", joins = \"a\" }}\n")), ["B0112"]);
}
