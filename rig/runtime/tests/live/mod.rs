//! A rig that is kept running, from where the control socket holds it.

mod allocation;
mod led;
mod plans;
mod real;

use crate::texts::Texts;
use control::{RequestFault, Signal, Status};
use scanrig_runtime::live::{self, LiveRig, PlanSource};
use scanrig_runtime::soft_plc::{SoftPlcReport, SoftPlcSettings};
use scanrig_runtime::suite::FileSource;
use scanrig_runtime::{ClockKind, RunOptions};
use services::control::{Answer, Rig, RigEvent, RigOrder, Ticket};
use signal::{Span, Value};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(60);

/// A lamp that follows a button, a counter, and a flash.
pub const PROGRAM: &str = "PROGRAM MAIN
VAR
    button AT %IX0.0 : BOOL;
    lamp AT %QX0.0 : BOOL;
    flash AT %QX0.1 : BOOL;
    count : INT;
    level : REAL;
    list : ARRAY [0..3] OF INT;
    tick : TON;
END_VAR
lamp := button;
count := count + 1;
tick(IN := NOT tick.Q, PT := T#100ms);
IF tick.Q THEN
    flash := NOT flash;
END_IF;
END_PROGRAM
";

pub const BOARD: &str = "format = 1
[board]
kind = \"simulated\"
[channels]
start = { kind = \"digital\" }
signal = { kind = \"digital\" }
beacon = { kind = \"digital\" }
[bind]
\"%IX0.0\" = \"start\"
\"%QX0.0\" = \"signal\"
\"%QX0.1\" = \"beacon\"
";

pub const PLAN: &str = "format = 1
title = \"A lamp\"
program = \"lamp.st\"
board = \"board.toml\"
expect = [{ state = { stays = \"RUNNING\" } }]
";

/// A case with a step, a claim and a measurement; one that lasts; one that fails.
const PLANS: &[(&str, &str)] = &[
    (
        "press.toml",
        "format = 1
title = \"The lamp follows the button\"
program = \"lamp.st\"
signals = { start = \"start\", lamp = \"signal\" }
ends = \"press + 200 ms\"
steps = [{ id = \"press\", at = \"start + 100 ms\", set = { signal = \"start\", value = true } }]
expect = [{ rises = { signal = \"lamp\", from = \"press\", within = \"0 ms .. 100 ms\" } }]
measure = [{ name = \"lag\", from = \"press\", to = { signal = \"lamp\", edge = \"rises\" }, max = \"100 ms\" }]
",
    ),
    (
        "long.toml",
        "format = 1
title = \"An hour\"
program = \"lamp.st\"
ends = \"start + 1 h\"
expect = [{ state = { stays = \"RUNNING\" } }]
",
    ),
    ("lamp.st", PROGRAM),
];

#[derive(Debug)]
struct Library;

impl PlanSource for Library {
    fn plans(&self, path: Option<&str>, is_wanted: &dyn Fn() -> bool) -> Result<Vec<String>, String> {
        // A disk that does not answer.
        while path == Some("hangs") && is_wanted() {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(vec!["press.toml".into(), "long.toml".into(), "none.toml".into()])
    }

    fn files(&self, _plan: &str) -> &'static dyn FileSource {
        &Texts(PLANS)
    }
}

/// What a rig reported, and the rig.
pub struct Bench<'a> {
    pub rig: &'a mut LiveRig,
    pub reported: Vec<RigEvent>,
    tickets: u64,
}

impl Bench<'_> {
    pub fn signal(&mut self, name: &str) -> Signal {
        self.rig.find(name).unwrap_or_else(|fault| panic!("{fault:?}"))
    }

    /// Hears what the rig reports until something is found in it.
    pub fn until<T>(&mut self, what: &str, mut find: impl FnMut(&RigEvent) -> Option<T>) -> T {
        let began = Instant::now();
        let mut looked = 0;
        loop {
            self.rig.poll(&mut |reported| self.reported.push(reported));
            while let Some(reported) = self.reported.get(looked) {
                looked += 1;
                if let Some(found) = find(reported) {
                    return found;
                }
            }
            assert!(began.elapsed() < PATIENCE, "{what} does not come: {:?}", self.reported);
            std::thread::yield_now();
        }
    }

    pub fn order(&mut self, order: RigOrder) -> Result<Answer, RequestFault> {
        self.tickets += 1;
        let ticket = Ticket(self.tickets);
        self.rig.order(ticket, order)?;
        self.until("an answer", |reported| match reported {
            RigEvent::Answer(of, answer) if *of == ticket => Some(answer.clone()),
            _ => None,
        })
    }

    pub fn read(&mut self, name: &str) -> Value {
        let number = self.signal(name).number;
        match self.order(RigOrder::Read(number)) {
            Ok(Answer::Value(value)) => value,
            other => panic!("{name}: {other:?}"),
        }
    }

    pub fn write(&mut self, name: &str, value: Value) -> Result<Answer, RequestFault> {
        let number = self.signal(name).number;
        self.order(RigOrder::Write(number, value))
    }

    pub fn force(&mut self, name: &str, on: bool) -> Result<Answer, RequestFault> {
        let number = self.signal(name).number;
        self.order(RigOrder::Force(number, Value::Bool(on)))
    }

    pub fn watch(&mut self, name: &str) -> u32 {
        let number = self.signal(name).number;
        self.rig.watch(number).unwrap();
        number
    }

    pub fn advance(&mut self, by: Span) {
        assert_eq!(self.order(RigOrder::Advance(by)), Ok(Answer::Done));
    }

    /// The status when it is as wanted.
    pub fn status(&mut self, what: &str, wanted: impl Fn(&Status) -> bool) -> Status {
        let began = Instant::now();
        loop {
            self.rig.poll(&mut |reported| self.reported.push(reported));
            let status = self.rig.status();
            if wanted(&status) {
                return status;
            }
            assert!(began.elapsed() < PATIENCE, "{what}: {status:#?}");
            std::thread::yield_now();
        }
    }

    /// Every change of a signal so far: when, at the latest, and what.
    pub fn changes(&self, signal: u32) -> Vec<(i64, Value)> {
        let change = |reported: &RigEvent| match reported {
            RigEvent::Change { signal: of, at, value } if *of == signal => {
                Some((at.latest.as_nanos(), *value))
            }
            _ => None,
        };
        self.reported.iter().filter_map(change).collect()
    }
}

/// Keeps a rig running while `act` works it, then stops it.
pub fn with_rig(led: bool, act: impl FnOnce(&mut Bench<'_>)) -> SoftPlcReport {
    with_rig_of(PLAN, BOARD, led, act)
}

/// The same with the program and the settings of this plan, on this board.
pub fn with_rig_of(plan: &str, board: &str, led: bool, act: impl FnOnce(&mut Bench<'_>)) -> SoftPlcReport {
    let texts = Texts(&[("plan.toml", plan), ("lamp.st", PROGRAM), ("board.toml", board)]);
    let (loaded, jobs) = texts.load(1);
    let case = loaded.plan.case(jobs[0].case).unwrap();
    let files = loaded.files(&case, &jobs[0]).unwrap();
    let board = (files.board.clone(), board.to_owned());
    let plans = live::PlanBench { source: Arc::new(Library), board, seed: 1 };
    // As the signal handler's: there as long as the program.
    let interrupt: &AtomicBool = Box::leak(Box::new(AtomicBool::new(false)));
    let (mut rig, port, slot) = live::open(&case, &files, None, led, "0", Some(plans), interrupt).unwrap();
    let port = Mutex::new(port);
    let kind = if led { ClockKind::Virtual } else { ClockKind::Real };
    let options =
        RunOptions { slice: Span::from_millis(10), live: Some(&port), ..RunOptions::new(kind, interrupt) };
    let (sender, _events) = mpsc::sync_channel(1_024);
    let settings = SoftPlcSettings { duration: None, booted: true };
    std::thread::scope(|scope| {
        let scan = scope.spawn(|| live::run_with_plans(&case, &files, &options, settings, &slot, &sender));
        let mut bench = Bench { rig: &mut rig, reported: Vec::new(), tickets: 0 };
        let acted = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| act(&mut bench)));
        interrupt.store(true, Ordering::Relaxed);
        let played = scan.join().unwrap().unwrap_or_else(|found| panic!("{found:#?}"));
        if let Err(panic) = acted {
            std::panic::resume_unwind(panic);
        }
        played
    })
}
