//! Serial lines as a part of a board: held for a run, lost with their device, taken back.

use std::time::Instant;

use devices::{Lab, PATIENCE, SERIAL_A, SERIAL_C, wait_for};
use drivers::holders;
use drivers::{
    Board, BoardContext, BoardError, BoardEvent, BoardExt, BusEvent, BusId, LossReason, Terminals, open, read,
};
use host::{HostInstant, Realtime};
use signal::{Span, Value};

struct Bench {
    board: Box<dyn Board>,
    at: BoardContext,
}

impl Bench {
    fn open(keys: &str, more: &str) -> Bench {
        let text = format!(
            "format = 1\n[board]\nkind = \"real\"\nunresponsive-after = \"1 s\"\n{keys}\n[buses]\n\
             modbus = {{ kind = \"serial\", path = \"/dev/rig/serial-a\", rs485 = {{}}, low-latency = true }}\n\
             scales = {{ kind = \"serial\", path = \"/dev/rig/serial-b\", parity = \"none\" }}\n{more}"
        );
        let file = document::SourceFile::new("board.toml", text);
        let file = read(&file, &|_| Ok(Terminals::default())).unwrap_or_else(|found| panic!("{found:#?}"));
        let at = BoardContext::new(Realtime::default());
        let board = open(&file, &at).unwrap_or_else(|found| panic!("{found:#?}")).unwrap();
        Bench { board, at }
    }

    fn start(&mut self) -> Result<(), BoardError> {
        self.board.start(self.at.time.now())
    }

    /// What the buses report, once they do.
    fn reported(&mut self) -> Vec<BusEvent> {
        let mut events = Vec::new();
        let deadline = Instant::now() + PATIENCE;
        while events.is_empty() {
            assert!(Instant::now() < deadline, "the buses have nothing to report");
            self.at.bell.wait_until(HostInstant::now() + Span::from_millis(20));
            self.board.poll_buses(self.at.time.now(), &mut events).unwrap();
        }
        events
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_line_without_its_driver_is_lost_and_comes_back_as_it_was() {
    let _lab = Lab::enter();
    let mut bench = Bench::open("reconnect = true", "");
    bench.start().unwrap();
    let unplugged = SERIAL_A.unplug();
    let events = bench.reported();
    assert!(
        matches!(events[..], [BusEvent::Lost { bus: BusId(0), reason: LossReason::Gone, .. }]),
        "{events:?}"
    );
    assert_eq!(bench.board.health().lost, 1);
    drop(unplugged);
    let events = bench.reported();
    assert!(matches!(events[..], [BusEvent::Returned { bus: BusId(0), .. }]), "{events:?}");
    // As it was: the direction is driven again, and it is the rig's alone.
    let port = std::fs::File::open(SERIAL_A.path()).unwrap();
    assert!(host::rs485(&port).unwrap().enabled && host::is_exclusive(&port).unwrap());
    drop(port);
    bench.board.safe(bench.at.time.now()).unwrap();
    bench.start().unwrap();
    assert!(bench.board.health().is_sound());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_line_that_is_not_to_be_taken_back_is_refused_to_the_next_case() {
    let _lab = Lab::enter();
    let mut bench = Bench::open("reconnect = false", "");
    bench.start().unwrap();
    drop(SERIAL_A.unplug());
    let events = bench.reported();
    assert!(matches!(events[..], [BusEvent::Lost { bus: BusId(0), .. }]), "{events:?}");
    assert!(matches!(bench.start(), Err(BoardError::BusLost { bus: BusId(0), .. })));
    // The next run finds it.
    drop(bench);
    Bench::open("reconnect = false", "").start().unwrap();
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_start_waits_for_a_line_that_is_coming_back() {
    let _lab = Lab::enter();
    let mut bench = Bench::open("reconnect = true", "");
    bench.start().unwrap();
    let unplugged = SERIAL_A.unplug();
    bench.reported();
    bench.board.safe(bench.at.time.now()).unwrap();
    let back = std::thread::spawn(move || drop(unplugged));
    bench.start().unwrap();
    back.join().unwrap();
    assert!(bench.board.health().is_sound());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_board_has_lines_of_both_kinds() {
    let _lab = Lab::enter();
    let more = "[chips]\nmain = { label = \"rig-gpio\" }\n[channels]\n\
                lamp = { kind = \"digital\", line = 3, drives = true }\n";
    let mut bench = Bench::open("", more);
    bench.start().unwrap();
    let names: Vec<&str> = bench.board.bus_list().iter().map(|bus| bus.name.as_str()).collect();
    assert_eq!((names, bench.board.channels().len()), (vec!["modbus", "scales"], 1));
    let lamp = drivers::ChannelId(0);
    bench.board.write(bench.at.time.now(), &[(lamp, Value::Bool(true))]).unwrap();
    let mut events = Vec::new();
    wait_for("the lamp to be lit", PATIENCE, || {
        bench.board.poll(bench.at.time.now(), &mut events).unwrap();
        events.iter().any(|event| {
            matches!(event, BoardEvent::Changed { channel, value: Value::Bool(true), .. } if *channel == lamp)
        })
    });
    assert_eq!(holders(&SERIAL_C.path()), []);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn two_names_of_one_port_are_reported_at_the_second() {
    let _lab = Lab::enter();
    let device = std::fs::canonicalize(SERIAL_A.path()).unwrap();
    let text = format!(
        "format = 1\n[board]\nkind = \"real\"\n[buses]\na = {{ kind = \"serial\", path = \"/dev/rig/serial-a\" }}\n\
         b = {{ kind = \"serial\", path = \"{}\" }}\nc = {{ kind = \"serial\", path = \"/dev/rig/serial-c\", \
         rs485 = {{ terminate = true, delay-after = \"100 ms\" }}, baud = 3_000_000 }}\n",
        device.display()
    );
    let file = document::SourceFile::new("board.toml", text);
    let file = read(&file, &|_| Ok(Terminals::default())).unwrap();
    let found = open(&file, &BoardContext::new(Realtime::default())).unwrap_err();
    let said: Vec<(&str, &str)> = found.iter().map(|one| (one.code, one.message.as_str())).collect();
    assert!(found[0].help.contains("another line of the board"), "{found:#?}");
    let [("B0145", busy), ("B0148", speed)] = said[..] else { panic!("{said:#?}") };
    assert!(busy.contains("held") && speed.contains("cannot do 3000000 Bd"), "{said:#?}");
}
