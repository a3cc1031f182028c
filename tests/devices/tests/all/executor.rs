//! The executor on real lines: scans that start on time whatever devices do, and go on without end in the memory that
//! they began with.

mod bench;
mod memory;
#[path = "../../../../rig/runtime/tests/common/texts.rs"]
mod texts;

use std::sync::atomic::Ordering;
use std::time::Duration;

use bench::{Bench, Start};
use devices::{ADC, Adc, Call, Lab, MAIN, MCP3008, PATIENCE, SERIAL_A, bind_spi, wait_for};
use drivers::serial::{PortSpec, SerialPort};
use drivers::{BoardContext, BoardExt, BusId};
use host::{HostInstant, Realtime, ThreadRole};
use memory::{LOOKING, look};
use signal::{CanFrame, SerialSettings, Span, Time};

#[global_allocator]
static COUNTING: counting::Counting = counting::Counting;

const HANG: Duration = Duration::from_secs(1);

/// How late this share of some scans started at most.
fn share(starts: &[Start], percent: usize) -> Span {
    let mut late: Vec<Span> = starts.iter().map(|start| start.late).collect();
    late.sort_unstable();
    late[(late.len() - 1) * percent / 100]
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn scans_start_as_punctually_while_a_device_call_hangs() {
    let lab = Lab::enter();
    punctual("", || lab.stall(MAIN, Call::Set, HANG, 1), || lab.inside(MAIN, Call::Set));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn scans_start_as_punctually_while_an_spi_transfer_hangs() {
    let _lab = Lab::enter();
    bind_spi();
    let adc = MCP3008.reset();
    let devices = "level = { kind = \"analog\", unit = \"V\", input = 0 }
[converters]
adc = { kind = \"spi\", path = \"/dev/spidev0.0\", part = \"mcp3008\", reference = \"3.3 V\", period = \"100 ms\" }
";
    punctual(devices, || adc.stall(HANG, 1), || adc.inside());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn scans_start_as_punctually_while_industrial_io_hangs() {
    let _lab = Lab::enter();
    let adc = Adc::enter();
    let devices = format!(
        "level = {{ kind = \"analog\", unit = \"V\", input = 0 }}
[converters]
adc = {{ kind = \"iio\", name = \"{ADC}\", period = \"100 ms\" }}
"
    );
    punctual(&devices, || adc.stall(HANG, 1), || adc.inside());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn scans_start_as_punctually_while_a_serial_port_hangs() {
    let _lab = Lab::enter();
    let (ask, asked) = std::sync::mpsc::channel();
    let line = SerialSettings::default();
    let spec = PortSpec { path: SERIAL_A.path(), line, rs485: None, low_latency: None, exclusive: true };
    // A thread of the role that ports have on a board.
    let port = std::thread::spawn(move || {
        Realtime::with_priority(80).enter(ThreadRole::Devices).expect("real-time priority");
        let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build().unwrap();
        runtime.block_on(async {
            let mut port = SerialPort::open(&spec).unwrap();
            for () in asked {
                let until = HostInstant::now() + Span::from_nanos(PATIENCE.as_nanos() as i64);
                let sending = port.send(b"request", until).await.unwrap();
                SERIAL_A.stall(HANG);
                port.drain(sending, until).await.unwrap();
                SERIAL_A.stall(Duration::ZERO);
            }
        });
    });
    punctual("", || ask.send(()).unwrap(), || SERIAL_A.inside());
    drop(ask);
    port.join().unwrap();
}

/// The rig's thread of this name sleeps inside a call.
fn sleeps(thread: &str) -> bool {
    let threads = std::fs::read_dir("/proc/self/task").unwrap().flatten();
    // It is `NUMBER (NAME) STATE ...`.
    let mut all = threads.filter_map(|thread| std::fs::read_to_string(thread.path().join("stat")).ok());
    all.any(|stat| stat.contains(&format!("({thread}) D ")))
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn scans_start_as_punctually_while_a_can_controller_hangs() {
    let _lab = Lab::enter();
    let trouble = |what: &str| format!("/sys/class/net/rcan0/trouble/{what}");
    let write = |what: &str, value: &str| std::fs::write(trouble(what), value).unwrap();
    // After each bus-off the rig starts the controller again, a call of a second. The lock of all interfaces is held
    // meanwhile.
    let devices = "[buses]
bus = { kind = \"can\", interface = \"rcan0\", bitrate = 500_000, restart = \"10 ms\" }
";
    let inside = || std::fs::read_to_string(trouble("inside")).unwrap().trim().parse().unwrap();
    let begin = || {
        write("hang_restart_ms", &HANG.as_millis().to_string());
        write("event", "bus-off");
        wait_for("the rig's thread sleeps", PATIENCE, || inside() == 1 && sleeps("can rcan0"));
    };
    punctual(devices, begin, inside);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn scans_start_as_punctually_while_sending_a_can_frame_hangs() {
    let _lab = Lab::enter();
    let text = "format = 1
board = { kind = \"real\", unresponsive-after = \"5 s\" }
buses = { bus = { kind = \"can\", interface = \"rcan0\", bitrate = 500_000 } }
";
    let terminals = |_: &drivers::Subject| Ok(drivers::Terminals::default());
    let file = drivers::read(&document::SourceFile::new("can.toml", text), &terminals).unwrap();
    let at = BoardContext::new(Realtime::with_priority(80));
    let mut board = drivers::open(&file, &at).unwrap().unwrap();
    board.start(Time::ZERO).unwrap();
    let board = std::sync::Mutex::new(board);
    let begin = || {
        std::fs::write("/sys/class/net/rcan0/trouble/hang_ms", HANG.as_millis().to_string()).unwrap();
        let frame = CanFrame::classic(1, false, &[0x55; 8]).unwrap();
        board.lock().unwrap().send(at.time.now(), BusId(0), &frame).unwrap();
    };
    let inside = || std::fs::read_to_string("/sys/class/net/rcan0/trouble/inside").unwrap();
    punctual("", begin, || inside().trim().parse().unwrap());
}

/// Holds how late scans start while a call on a device hangs, three times for a second, against how late they start at
/// other times. `begin` lets the next call hang, `inside` counts how many do. `devices` are on the board beside its lines.
fn punctual(devices: &str, begin: impl Fn() + Sync, inside: impl Fn() -> u32 + Sync) {
    // A scan each 10 ms, whose output turns in each.
    let bench = Bench::beside(devices, Span::from_millis(10), 1, Span::from_secs(12));
    let progress = bench.progress.clone();
    let hang = || {
        // A call that keeps its processor busy leaves nothing of it to a thread without priority, which would see none of
        // a hang of a second.
        Realtime::with_priority(80).enter(ThreadRole::Scan).expect("real-time priority");
        let now = || progress.load(Ordering::Relaxed);
        let mut hung = Vec::new();
        wait_for("the scans", PATIENCE, || now() > 3_000_000_000);
        for turn in 1..=3i64 {
            begin();
            wait_for("a call that hangs", PATIENCE, || inside() == 1);
            let from = now();
            wait_for("its end", PATIENCE, || inside() == 0);
            hung.push((from, now()));
            wait_for("more scans", PATIENCE, || now() > 3_000_000_000 + turn * 2_500_000_000);
        }
        hung
    };
    let (outcome, hung) = std::thread::scope(|scope| {
        let hanging = scope.spawn(hang);
        (bench.run(), hanging.join().unwrap())
    });
    let (mut during, mut other) = (Vec::new(), Vec::new());
    for start in outcome.starts.iter().filter(|start| start.due.as_nanos() > 2_000_000_000) {
        let at = start.due.as_nanos();
        let in_it = hung.iter().any(|(from, to)| (*from..*to).contains(&at));
        if in_it { &mut during } else { &mut other }.push(*start);
    }
    let worst = during.iter().map(|start| start.late).max().unwrap();
    println!(
        "\nfigure: {} scans started while a call hung, {} late in the median, {} for 90 %, {worst} at worst; \
         {} at other times: {} and {}",
        during.len(),
        share(&during, 50),
        share(&during, 90),
        other.len(),
        share(&other, 50),
        share(&other, 90),
    );
    // 3 s, less what it takes the test to see them.
    assert!(during.len() > 150, "{} scans", during.len());
    // Scans that had waited for the device would have been half a second later in the median, and nine tenths of one
    // for 90 %. How late they are without is the machine's affair.
    assert!(share(&during, 50) < share(&other, 50) * 2 + Span::from_millis(50));
    assert!(share(&during, 90) < share(&other, 90) * 2 + Span::from_millis(100));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_hundred_thousand_scans_allocate_nothing_and_lose_no_edge_in_silence() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(8), MAIN.line(0));
    // A scan each 400 us; the output turns in each 50th.
    let bench = Bench::new(Span::from_micros(400), 50, Span::from_secs(41));
    let (progress, counts) = (bench.progress.clone(), bench.counts.clone());
    let looking = || {
        let reached = |second: i64| progress.load(Ordering::Relaxed) > second * 1_000_000_000;
        let patience = Duration::from_secs(150);
        // Before the end, which allocates.
        [6, 40].map(|second| {
            wait_for("more scans", patience, || reached(second));
            look()
        })
    };
    let (outcome, [first, last]) = std::thread::scope(|scope| {
        let looking = scope.spawn(looking);
        (bench.run(), looking.join().unwrap())
    });
    let (made, reported) = counts.output();
    let (seen, lost) = counts.input();
    println!(
        "\nfigure: {} scans; {} asked for, {made} made, {reported} taken back, {seen} seen, {lost} reported lost; \
         {} kB resident, {} kB locked",
        outcome.scans, outcome.asked, last.resident, last.locked
    );
    assert!(outcome.scans >= 100_000, "{} scans", outcome.scans);
    assert!(last.allocations - first.allocations <= LOOKING, "{first:?} {last:?}");
    assert!(last.resident <= first.resident + 256, "{first:?} {last:?}");
    assert!(last.locked <= first.locked + 256, "{first:?} {last:?}");
    // Back to its safe level at the end, where it was at the start.
    let driven_back = made % 2;
    assert_eq!(driven_back, 0, "{made} edges made");
    assert!(made > 1_000, "{made} edges made");
    // Seen or reported lost. A machine that stands still has edges reported twice now and then, late ones after their loss.
    assert!((made..=made + made / 10).contains(&(seen + lost)), "{made} made, {seen} seen, {lost} lost");
    // What a late rig asked for and took back before the device came to it is reported, too; at least some of it.
    assert!(
        made == outcome.asked || made + reported <= outcome.asked && reported > 0,
        "{} asked for",
        outcome.asked
    );
}
