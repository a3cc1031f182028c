//! A case on the lab's lines, in parts: its clock and its board are looked over the shoulder.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};

use controller::TaskKind;
use drivers::{Board, BoardContext, BoardError, BoardEvent, BoardExt, Channel, ChannelId, Health};
use host::{Punctual, Realtime, ThreadRole};
use scanrig_runtime::executor::clock::{Clock, HostClock};
use scanrig_runtime::subject::SubjectExt;
use scanrig_runtime::subject::model::ModelledController;
use signal::{Span, Time, Value};

use super::texts::{Parted, Texts};

/// The start of a scan: when it was due, and how late it was.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    pub due: Time,
    pub late: Span,
}

/// Edges of the output and of the input that it may be wired to.
#[derive(Debug, Default)]
pub struct Counts {
    edges: [AtomicU64; 2],
    dropped: [AtomicU64; 2],
}

impl Counts {
    /// Edges that the output made, and those that were asked for and taken back before the device came to them.
    pub fn output(&self) -> (u64, u64) {
        (self.edges[0].load(Ordering::Relaxed), self.dropped[0].load(Ordering::Relaxed))
    }

    /// Edges that the input saw, and those that it reported as lost.
    pub fn input(&self) -> (u64, u64) {
        (self.edges[1].load(Ordering::Relaxed), self.dropped[1].load(Ordering::Relaxed))
    }
}

/// What a run left.
#[derive(Debug)]
pub struct Outcome {
    pub starts: Vec<Start>,
    pub scans: u64,
    /// Turns of the output that the program asked for.
    pub asked: u64,
}

/// A case on the lab's lines: an output that turns, line 8, and an input, line 0.
#[derive(Debug)]
pub struct Bench {
    model: ModelledController,
    parts: Parted,
    at: BoardContext,
    /// How far the case is, in nanoseconds.
    pub progress: Arc<AtomicI64>,
    pub counts: Arc<Counts>,
    _punctual: Punctual,
}

/// An emulated machine that stands still for a while has lost no device.
const BOARD: &str = "format = 1
[board]
kind = \"real\"
unresponsive-after = \"5 s\"
on-loss = \"go-on\"
[chips]
main = { label = \"rig-gpio\" }
[channels]
I0 = { kind = \"digital\", line = 0 }
Q0 = { kind = \"digital\", line = 8, safe = false }
";

impl Bench {
    /// A scan each `interval`; the output turns in each `every`th. The case ends this long after its start.
    pub fn new(interval: Span, every: u32, lasts: Span) -> Bench {
        Bench::beside("", interval, every, lasts)
    }

    /// The same with more devices on its board: further channels, then tables.
    pub fn beside(devices: &str, interval: Span, every: u32, lasts: Span) -> Bench {
        let board = format!("{BOARD}{devices}");
        let program = format!(
            "PROGRAM MAIN
VAR
    out AT %QX0.0 : BOOL;
    n : DINT;
    asked : DINT;
END_VAR
n := n + 1;
IF n MOD {every} = 0 THEN
    out := NOT out;
    asked := asked + 1;
END_IF;
END_PROGRAM
"
        );
        let plan = format!(
            "format = 1
title = \"Scans on real lines\"
program = \"turn.st\"
board = \"board.toml\"
signals = {{ asked = {{ path = \"MAIN.asked\", at-most-every = \"1 h\" }} }}
ends = \"start + {} ms\"
timeout = \"600 s\"
expect = [{{ state = {{ stays = \"RUNNING\", from = \"start\", until = \"end\" }} }}]
",
            lasts.as_nanos() / 1_000_000
        );
        let files =
            [("plan.toml", plan.as_str()), ("turn.st", program.as_str()), ("board.toml", board.as_str())];
        let texts = Texts(&files);
        let (model, mut parts) = texts.parts_with(1, |config| {
            config.tasks[0].kind = TaskKind::Cyclic { interval };
            config.tasks[0].watchdog = None;
        });
        let (loaded, jobs) = texts.load(1);
        let case = loaded.plan.case(jobs[0].case).unwrap();
        let file = loaded.files(&case, &jobs[0]).unwrap().board;
        let at = BoardContext::new(Realtime::with_priority(80));
        let board = drivers::open(&file, &at).unwrap_or_else(|found| panic!("{found:#?}")).unwrap();
        let counts = Arc::new(Counts::default());
        let find = |name: &str| board.find(name).unwrap();
        let channels = [find("Q0"), find("I0")];
        parts.board = Box::new(Counted { board, channels, last: [None; 2], counts: counts.clone() });
        // An emulated machine may stand still for a while; how late it was is what the test looks at.
        parts.late = Span::from_secs(10);
        let progress = Arc::new(AtomicI64::new(0));
        Bench { model, parts, at, progress, counts, _punctual: Punctual::begin() }
    }

    /// Runs the case in this thread.
    pub fn run(mut self) -> Outcome {
        Realtime::with_priority(80).enter(ThreadRole::Scan).expect("real-time priority");
        let (clock, progress) = (HostClock::of(&self.at), self.progress.clone());
        let mut clock = Watched { clock, progress, starts: Vec::with_capacity(1 << 19) };
        let ran = self.parts.run(&mut clock, &mut self.model);
        assert!(ran.start.is_some(), "{:?}", ran.fault);
        self.settle();
        let scans = self.model.figures().iter().map(|(_, _, figures)| figures.cycles).sum();
        let asked = self.model.observable("MAIN.asked").map(|found| self.model.read(&found.probe));
        let Some(Value::Int(asked)) = asked else { panic!("{asked:?}") };
        // The last turn may be that of the safe level after the end.
        let asked = asked as u64 + asked as u64 % 2;
        Outcome { starts: clock.starts, scans, asked }
    }

    /// What the board has still to report.
    fn settle(&mut self) {
        let mut events = Vec::with_capacity(1024);
        devices::wait_for("the last edges", devices::PATIENCE, || {
            events.clear();
            self.parts.board.poll(self.at.time.now(), &mut events).unwrap();
            let ((made, _), (seen, lost)) = (self.counts.output(), self.counts.input());
            // Without a wire the input sees nothing.
            made % 2 == 0 && (seen + lost == 0 || made <= seen + lost)
        });
    }
}

/// A clock that notes how late scans start.
struct Watched {
    clock: HostClock,
    progress: Arc<AtomicI64>,
    starts: Vec<Start>,
}

impl Clock for Watched {
    fn begin(&mut self) {
        self.clock.begin();
    }

    fn wait_until(&mut self, due: Time) -> Time {
        self.clock.wait_until(due)
    }

    /// What is waited for so is the release of the next scan, nearly always.
    fn wait(&mut self, due: Time) -> Time {
        let at = self.clock.wait(due);
        if at >= due && self.starts.len() < self.starts.capacity() {
            self.starts.push(Start { due, late: at - due });
        }
        self.progress.store(at.as_nanos(), Ordering::Relaxed);
        at
    }

    fn rung(&mut self) -> bool {
        self.clock.rung()
    }

    fn now(&mut self) -> Time {
        self.clock.now()
    }

    fn stood_still(&mut self, at: Time) {
        self.clock.stood_still(at);
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn name(&self) -> &'static str {
        "watched"
    }
}

/// A board whose edges are counted.
#[derive(Debug)]
struct Counted {
    board: Box<dyn Board>,
    channels: [ChannelId; 2],
    last: [Option<Value>; 2],
    counts: Arc<Counts>,
}

impl Board for Counted {
    fn inner(&self) -> Option<&dyn Board> {
        Some(&*self.board)
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Board> {
        Some(&mut *self.board)
    }

    fn channels(&self) -> &[Channel] {
        self.board.channels()
    }

    fn start(&mut self, now: Time) -> Result<(), BoardError> {
        self.board.start(now)
    }

    fn write(&mut self, now: Time, writes: &[(ChannelId, Value)]) -> Result<(), BoardError> {
        self.board.write(now, writes)
    }

    fn poll(&mut self, now: Time, out: &mut Vec<BoardEvent>) -> Result<(), BoardError> {
        let first = out.len();
        let polled = self.board.poll(now, out);
        for event in &out[first..] {
            let Some(place) = self.channels.iter().position(|channel| *channel == event.channel()) else {
                continue;
            };
            match *event {
                BoardEvent::Changed { value, .. } => {
                    // The first reports what the line was.
                    let turned = self.last[place].is_some_and(|last| last != value);
                    self.last[place] = Some(value);
                    self.counts.edges[place].fetch_add(u64::from(turned), Ordering::Relaxed);
                }
                BoardEvent::Dropped { count, .. } => {
                    self.counts.dropped[place].fetch_add(u64::from(count), Ordering::Relaxed);
                }
                BoardEvent::Lost { .. } | BoardEvent::Returned { .. } => {}
            }
        }
        polled
    }

    fn next_event(&self) -> Option<Time> {
        self.board.next_event()
    }

    fn safe(&mut self, now: Time) -> Result<(), BoardError> {
        self.board.safe(now)
    }

    fn health(&self) -> Health {
        self.board.health()
    }
}
