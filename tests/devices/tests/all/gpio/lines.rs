//! Levels go out and come in, as the board file says.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::bench::{BOTH, Bench};
use devices::{AUX, Lab, MAIN, PATIENCE, wait_for};
use drivers::gpio::{Bias, Drive, LineInfo};
use drivers::{BoardEvent, LineApi, Origin};
use signal::{Span, Time, Value};

/// A line of the lab's main chip, as everybody sees it.
fn listed(number: usize) -> LineInfo {
    let chips = drivers::gpio::list().unwrap();
    let main = chips.into_iter().flatten().find(|chip| chip.label == MAIN.label()).unwrap();
    main.lines[number].clone()
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn levels_go_out_and_come_in() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(1), MAIN.line(2));
    for backend in BOTH {
        MAIN.line(0).pull(true);
        let mut bench = Bench::of_main(
            backend,
            "out = { kind = \"digital\", line = 1, drives = true }\n\
             back = { kind = \"digital\", line = 2 }\nhand = { kind = \"digital\", line = 0 }\n\
             other = { kind = \"digital\", line = 3, drives = true, safe = true }",
        );
        assert!(MAIN.line(3).value(), "{backend}: an output is safe from its claim on");
        bench.start();
        assert_eq!((bench.level("hand"), bench.level("back")), (Some(true), Some(false)), "{backend}");
        assert_eq!((bench.level("out"), bench.level("other")), (Some(false), Some(true)), "{backend}");
        bench.write(&[("out", true), ("other", false)]);
        bench.until_level("back", true);
        bench.until_level("out", true);
        assert!(MAIN.line(1).value() && !MAIN.line(3).value(), "{backend}");
        MAIN.line(0).pull(false);
        bench.until_level("hand", false);
        // What the rig did is known between two instants, and its wire followed within them or a little later.
        let (mut out, mut back) = (None, None);
        for event in &bench.events {
            let BoardEvent::Changed { channel, at, value: Value::Bool(true), origin } = event else {
                continue;
            };
            if *channel == bench.channel("out") {
                assert_eq!(*origin, Origin::Write);
                out = Some(*at);
            }
            if *channel == bench.channel("back") {
                assert_eq!(*origin, Origin::Outside);
                back = Some(*at);
            }
        }
        let (out, back) = (out.unwrap(), back.unwrap());
        assert!(
            Time::ZERO < out.earliest && out.earliest < out.latest && out.earliest <= back.latest,
            "{backend}"
        );
        let now = bench.now();
        bench.board.safe(now).unwrap();
        assert!(!MAIN.line(1).value() && MAIN.line(3).value(), "{backend}");
        let health = bench.board.health();
        assert!(health.is_sound() && health.latched_safe, "{backend}: {health:?}");
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn lines_are_set_up_as_the_board_file_says() {
    let _lab = Lab::enter();
    for backend in BOTH {
        // What an open output that lets go is pulled to.
        MAIN.line(6).pull(true);
        let text = Bench::main(
            backend,
            "door = { kind = \"digital\", line = \"DOOR\", bias = \"pull-up\" }\n\
             low = { kind = \"digital\", line = 4, active-low = true }\n\
             valve = { kind = \"digital\", chip = \"main\", line = \"VALVE\", drives = true, active-low = true }\n\
             open = { kind = \"digital\", line = 6, drives = true, drive = \"open-drain\", safe = true }",
        );
        let text = text.replace("kind = \"real\"", "kind = \"real\"\nconsumer = \"rig-of-the-test\"");
        let mut bench = Bench::open(&text);
        bench.start();
        for number in [24, 4, 26, 6] {
            let line = listed(number);
            assert!(line.used && line.consumer.as_deref() == Some("rig-of-the-test"), "{backend}: {line:?}");
        }
        assert_eq!(listed(24).bias, Some(Bias::PullUp), "{backend}");
        assert_eq!(listed(6).drive, Some(Drive::OpenDrain), "{backend}");
        assert!(listed(4).active_low);
        // A pull is a level that nobody drives; a low level is 1 where the file says so.
        assert_eq!((bench.level("door"), bench.level("low")), (Some(true), Some(true)), "{backend}");
        assert!(MAIN.line(26).value(), "{backend}: the valve is safe at the high level");
        assert!(MAIN.line(6).value(), "{backend}");
        bench.write(&[("valve", true), ("open", false)]);
        bench.until_level("valve", true);
        assert!(!MAIN.line(26).value() && !MAIN.line(6).value(), "{backend}");
        MAIN.line(4).pull(true);
        bench.until_level("low", false);
        // Letting go of an open output is its high level. Where it goes then the lab does not model.
        let (now, open) = (bench.now(), bench.channel("open"));
        bench.board.write(now, &[(open, Value::HighZ)]).unwrap();
        bench.until_level("open", true);
        drop(bench);
        assert!(!listed(26).used, "{backend}: the lines are free again");
        MAIN.line(4).pull(false);
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn the_kernel_debounces() {
    let _lab = Lab::enter();
    let mut bench = Bench::of_main(
        "v2",
        "a = { kind = \"digital\", line = 0, debounce = \"50 ms\" }\nb = { kind = \"digital\", line = 1 }",
    );
    bench.start();
    for _ in 0..4 {
        MAIN.line(0).pull(true);
        MAIN.line(0).pull(false);
    }
    MAIN.line(0).pull(true);
    let pulled = bench.now();
    bench.until_level("a", true);
    assert_eq!((bench.seen("a").changes, bench.seen("a").dropped), (1, 0));
    let id = bench.channel("a");
    let channel = bench.board.channels()[usize::from(id.0)].clone();
    assert!(channel.resolution >= Span::from_millis(50) && channel.shortest_pulse == Span::from_millis(50));
    let changed = bench.events.iter().rev().find_map(|event| match event {
        BoardEvent::Changed { channel, at, .. } if *channel == id => Some(*at),
        _ => None,
    });
    // The change itself lies before the time for which it had to last; how long before, a busy lab does not keep.
    let at = changed.unwrap();
    assert!(at.latest >= pulled + Span::from_millis(40), "{at:?} after {pulled}");
    assert!(at.latest - at.earliest >= Span::from_millis(50), "{at:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_line_that_is_read_back_stands_for_its_output() {
    let lab = Lab::enter();
    lab.wire_inverted(MAIN.line(1), MAIN.line(2));
    for backend in BOTH {
        let mut bench = Bench::of_main(
            backend,
            "out = { kind = \"digital\", line = 1, readback = 2 }\nb = { kind = \"digital\", line = 3 }",
        );
        bench.start();
        assert_eq!(bench.level("out"), Some(true), "{backend}: what the wire says, not what was driven");
        bench.write(&[("out", true)]);
        bench.until_level("out", false);
        assert_eq!(bench.seen("out").changes, 1, "{backend}: the write itself is no event");
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn each_start_begins_anew() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(1), MAIN.line(2));
    for backend in BOTH {
        let mut bench = Bench::of_main(
            backend,
            "out = { kind = \"digital\", line = 1, drives = true }\nback = { kind = \"digital\", line = 2 }",
        );
        for _ in 0..20 {
            bench.events.clear();
            bench.start();
            assert_eq!((bench.level("out"), bench.level("back")), (Some(false), Some(false)), "{backend}");
            for high in [true, false, true] {
                bench.write(&[("out", high)]);
                // The edge may be reported before the write that made it.
                bench.until_level("out", high);
                bench.until_level("back", high);
            }
            assert_eq!((bench.seen("out").changes, bench.seen("back").changes), (3, 3), "{backend}");
            let times: Vec<Time> = bench.events.iter().map(BoardEvent::latest).collect();
            assert!(times.iter().all(|at| *at >= Time::ZERO), "{backend}: {times:?}");
            let now = bench.now();
            bench.board.safe(now).unwrap();
            bench.until_level("back", false);
            let health = bench.board.health();
            assert!(!MAIN.line(1).value() && health.is_sound(), "{backend}: {health:?} {:?}", bench.events);
            let (now, out) = (bench.now(), bench.channel("out"));
            let refused = bench.board.write(now, &[(out, Value::Bool(true))]);
            assert_eq!(refused, Err(drivers::BoardError::Latched));
            assert!(!MAIN.line(1).value(), "{backend}: a late write does nothing");
        }
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_claim_can_be_held_beside_the_board() {
    let _lab = Lab::enter();
    let lines = "x = { kind = \"digital\", line = 4, drives = true, active-low = true }\n\
                 y = { kind = \"digital\", line = 5, drives = true }\n\
                 z = { kind = \"digital\", line = 6, drives = true, safe = true }";
    for (backend, api, safe) in [("v2", LineApi::V2, 0b100), ("v1", LineApi::V1 { lines: 3 }, 0b101)] {
        let bench = Bench::of_main(backend, lines);
        let held = bench.board.output_claims().unwrap();
        assert_eq!(held.len(), 1, "{backend}");
        assert_eq!((held[0].api, held[0].mask, held[0].safe), (api, 0b111, safe), "{backend}");
        assert!(held[0].device.contains(MAIN.label()), "{}", held[0].device);
        drop(bench);
        assert!(listed(5).used, "{backend}: the held claim outlives the board");
        drop(held);
        assert!(!listed(5).used, "{backend}");
    }
}

/// How often the outputs of a trace change.
const SCANS: usize = 40;

/// A tracer of this very process, and the file that it writes.
struct Tracer(Child, String);

impl Tracer {
    fn attach(name: &str) -> Tracer {
        let calls = format!("/tmp/calls.{name}");
        let own = std::process::id().to_string();
        let strace = Command::new("strace")
            .args(["-f", "-q", "-e", "trace=ioctl", "-o", &calls, "-p", &own])
            .stderr(Stdio::null())
            .spawn()
            .expect("strace");
        let traced = |task: &fs::DirEntry| {
            let status = fs::read_to_string(task.path().join("status")).unwrap_or_default();
            status.lines().any(|line| line.strip_prefix("TracerPid:").is_some_and(|pid| pid.trim() != "0"))
        };
        wait_for("every thread is traced", PATIENCE, || {
            fs::read_dir("/proc/self/task").unwrap().flatten().all(|task| traced(&task))
        });
        Tracer(strace, calls)
    }

    /// The calls that were made since.
    fn end(mut self) -> String {
        let ended = Command::new("kill").args(["-INT", &self.0.id().to_string()]).status().unwrap();
        assert!(ended.success());
        self.0.wait().unwrap();
        fs::read_to_string(&self.1).unwrap()
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_scan_is_one_call_that_sets_and_one_that_gets() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(16), MAIN.line(2));
    for backend in BOTH {
        let mut text = Bench::main(backend, "");
        text = text.replace("[channels]", "aux = { label = \"rig-gpio-aux\" }\n[channels]");
        for line in 0..16 {
            let out = 16 + line;
            text += &format!(
                "out{line} = {{ kind = \"digital\", chip = \"main\", line = {out}, drives = true }}\n"
            );
            text += &format!("in{line} = {{ kind = \"digital\", chip = \"main\", line = {line} }}\n");
        }
        for line in 0..3 {
            text += &format!(
                "far{line} = {{ kind = \"digital\", chip = \"aux\", line = {line}, drives = true }}\n"
            );
        }
        let mut bench = Bench::open(&text);
        bench.start();
        let tracer = Tracer::attach(backend);
        let begin = Instant::now();
        for scan in 0..SCANS {
            let high = scan % 2 == 0;
            bench.write(&[("out0", high), ("out7", high), ("out15", high), ("far0", high), ("far2", high)]);
            bench.until_level("out15", high);
            bench.until_level("far2", high);
            bench.until_level("in2", high);
        }
        let took = begin.elapsed();
        let calls = tracer.end();
        let count = |name: &str| calls.lines().filter(|line| line.contains(name)).count();
        let (set, get) = match backend {
            "v2" => (count("GPIO_V2_LINE_SET_VALUES_IOCTL"), count("GPIO_V2_LINE_GET_VALUES_IOCTL")),
            _ => (count("GPIOHANDLE_SET_LINE_VALUES_IOCTL"), count("GPIOHANDLE_GET_LINE_VALUES_IOCTL")),
        };
        println!(
            "figure: {backend}: {SCANS} scans of two chips, {set} calls that set, {get} that get, in {took:?}"
        );
        assert_eq!(set, 2 * SCANS, "{backend}: calls that set");
        // A chip that nothing is asked of for 5 s is read as well.
        let idle = 2 * (1 + took.as_secs() as usize / 5);
        assert!((2 * SCANS - 2..=2 * SCANS + idle).contains(&get), "{backend}: {get} calls that get");
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_lone_input_is_claimed_with_the_outputs() {
    let lab = Lab::enter();
    lab.wire(AUX.line(3), AUX.line(2));
    let text = "format = 1\n[board]\nkind = \"real\"\nbackend = \"v2\"\n[chips]\naux = { label = \"rig-gpio-aux\" }\n\
                [channels]\na = { kind = \"digital\", line = 0, drives = true, safe = true }\n\
                in = { kind = \"digital\", line = 2 }\n\
                b = { kind = \"digital\", line = 3, drives = true }\n\
                c = { kind = \"digital\", line = 4, drives = true, safe = true }\n";
    let mut bench = Bench::open(text);
    bench.start();
    let held = bench.board.output_claims().unwrap();
    assert_eq!((held[0].mask, held[0].safe), (0b1101, 0b1001));
    for (high, levels) in [(true, [true, true, true]), (false, [true, false, true])] {
        bench.write(&[("b", high)]);
        bench.until_level("in", high);
        let read = [0, 3, 4].map(|line| AUX.line(line).value());
        assert_eq!(read, levels);
    }
    bench.write(&[("a", false), ("c", false)]);
    bench.until_level("c", false);
    assert!(!AUX.line(0).value() && !AUX.line(4).value());
    // What becomes one edge with another shows: the numbers are those of a claim of several lines.
    let edges = 2_000u32;
    for _ in 0..edges / 2 {
        AUX.line(2).pull(true);
        AUX.line(2).pull(false);
    }
    let due = Instant::now() + Duration::from_millis(300);
    bench.until("all edges are accounted for", |bench| {
        let seen = bench.seen("in");
        Instant::now() >= due && seen.changes + seen.dropped >= 2 + u64::from(edges)
    });
}
