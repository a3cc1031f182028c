//! A board of CAN buses, and the lab's other side of them.

use std::fs;
use std::process::Command;
use std::time::Instant;

use devices::PATIENCE;
use document::{Diagnostic, SourceFile};
use drivers::{Board, BoardContext, BoardExt, BusEvent, BusId, Subject, Terminals, UnknownSubject};
use host::Realtime;
use signal::{CanFrame, Span, Time};

/// A board at work, with the clock that a run would have.
pub struct Bench {
    pub board: Box<dyn Board>,
    pub at: BoardContext,
    pub events: Vec<BusEvent>,
}

/// Two buses on the lab's SJA1000 controllers, which share a wire.
pub const CLASSIC: &str = "near = { kind = \"can\", interface = \"can0\", bitrate = 500_000 }\n\
                           far = { kind = \"can\", interface = \"can1\", bitrate = 500_000 }";

/// Two buses on the lab's controllers with trouble, which share a wire.
pub const TROUBLED: &str = "near = { kind = \"can\", interface = \"rcan0\", bitrate = 500_000 }\n\
                            far = { kind = \"can\", interface = \"rcan1\", bitrate = 500_000 }";

pub const NEAR: BusId = BusId(0);
pub const FAR: BusId = BusId(1);

fn terminals(_: &Subject) -> Result<Terminals, UnknownSubject> {
    Ok(Terminals::default())
}

impl Bench {
    /// A board of these buses (lines of TOML), started. The lab is patient: beside compilers it may stand still.
    pub fn of(buses: &str) -> Bench {
        Bench::with("unresponsive-after = \"5 s\"", buses)
    }

    /// As [`Bench::of`], with other words about the board.
    pub fn with(board: &str, buses: &str) -> Bench {
        let mut bench = Bench::open(board, buses).unwrap_or_else(|found| panic!("{found:#?}"));
        bench.start();
        bench
    }

    pub fn open(board: &str, buses: &str) -> Result<Bench, Vec<Diagnostic>> {
        let text = format!("format = 1\n[board]\nkind = \"real\"\n{board}\n[buses]\n{buses}\n");
        let file = drivers::read(&SourceFile::new("bench.toml", &text), &terminals)
            .unwrap_or_else(|found| panic!("{found:#?}"));
        let at = BoardContext::new(Realtime::with_priority(80));
        let board = drivers::open(&file, &at)?.expect("a real board");
        Ok(Bench { board, at, events: Vec::with_capacity(1 << 16) })
    }

    pub fn start(&mut self) {
        self.at.time.restart();
        self.board.start(Time::ZERO).unwrap();
        self.events.clear();
    }

    pub fn now(&self) -> Time {
        self.at.time.now()
    }

    pub fn send(&mut self, bus: BusId, frame: &CanFrame) {
        let now = self.now();
        self.board.send(now, bus, frame).unwrap();
    }

    /// Polls whenever the board rings, until the condition holds.
    pub fn until(&mut self, what: &str, mut holds: impl FnMut(&Bench) -> bool) {
        let due = Instant::now() + PATIENCE;
        loop {
            let now = self.now();
            self.board.poll_buses(now, &mut self.events).unwrap();
            if holds(self) {
                return;
            }
            let tail = &self.events[self.events.len().saturating_sub(20)..];
            assert!(Instant::now() < due, "never: {what}; {:?}; {tail:?}", self.board.health());
            let next = self.now() + Span::from_millis(20);
            let next = self.board.next_event().map_or(next, |at| at.min(next));
            self.at.bell.wait_until(self.at.time.stamp(next));
        }
    }

    /// Frames that a bus reported: when, what, whether its own.
    pub fn frames(&self, of: BusId) -> Vec<(signal::When, CanFrame, bool)> {
        let frame = |event: &BusEvent| match *event {
            BusEvent::CanFrame { bus, at, frame, own } if bus == of => Some((at, frame, own)),
            _ => None,
        };
        self.events.iter().filter_map(frame).collect()
    }

    /// Whether a bus reported such an event.
    pub fn reported(&self, of: BusId, suits: impl Fn(&BusEvent) -> bool) -> bool {
        self.events.iter().any(|event| event.bus() == of && suits(event))
    }
}

/// Runs a command of the guest.
pub fn run(line: &str) {
    let done = Command::new("sh").args(["-c", line]).output().expect("the guest has a shell");
    assert!(done.status.success(), "{line}: {}", String::from_utf8_lossy(&done.stderr));
}

/// Makes trouble on one of the lab's controllers; taken back when this is dropped.
pub struct Trouble(&'static str);

impl Trouble {
    pub fn on(interface: &'static str, what: &str, value: &str) -> Trouble {
        let path = format!("/sys/class/net/{interface}/trouble/{what}");
        fs::write(&path, value).unwrap_or_else(|error| panic!("{path} refused {value}: {error}"));
        Trouble(interface)
    }
}

impl Drop for Trouble {
    fn drop(&mut self) {
        for (what, value) in [
            ("fault", "none"),
            ("drop", "0"),
            ("lose_arbitration", "0"),
            ("delay_us", "0"),
            ("hang_ms", "0"),
            ("hang_restart_ms", "0"),
            ("hang_stop_ms", "0"),
            ("hang_counters_ms", "0"),
        ] {
            // The interface may be gone.
            let _ = fs::write(format!("/sys/class/net/{}/trouble/{what}", self.0), value);
        }
    }
}

/// Brings the controllers with trouble into their first state: up, without errors, with this much about them.
pub fn fresh(settings: &str) {
    for name in ["rcan0", "rcan1"] {
        drop(Trouble(name));
        run(&format!(
            "ip link set {name} down; ip link set {name} mtu 16; \
             ip link set {name} type can bitrate 500000 restart-ms 0 fd off listen-only off berr-reporting off && \
             ip link set {name} type can {settings} && ip link set {name} up"
        ));
        // A frame is handed to the network by whatever processor its timer runs on: processors that stand still now and then would
        // change the order of frames. So one of them takes all in.
        run(&format!("echo 1 >/sys/class/net/{name}/queues/rx-0/rps_cpus"));
    }
}
