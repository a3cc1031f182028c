//! The guard on real lines, seen from outside: whatever becomes of a rig, its outputs become safe and stay so.

use devices::{AUX, Call, Lab, Line, MAIN, PATIENCE, program, wait_for};
use host::{WatchdogDevice, never_stops};
use rustix::process::{Pid, Signal, kill_process};
use signal::Span;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

const DOG: &str = "/dev/watchdog";
/// The limit of the guards, in milliseconds: longer than an emulated machine stands still while others compile, or the
/// guard would be right to act before the test has done anything.
const LIMIT: u64 = 1_000;
/// How long the guard of a dead rig holds the lines where a test looks at them, in milliseconds. The lines go back to
/// their pulls when they are let go, and some of those pulls are not the safe levels.
const HOLD: u64 = 60_000;
/// How much later than its limit the guard may be found to have acted, on an emulated machine that stands still for
/// hundreds of milliseconds while others compile.
const SLACK: Duration = Duration::from_millis(800);
/// The same for the middle one of many.
const USUAL: Duration = Duration::from_millis(150);

/// Lines that `guarded` drives, and their safe levels.
fn outputs() -> [(Line, bool); 5] {
    let main = |number, safe| (MAIN.line(number), safe);
    [main(8, true), main(9, false), main(10, true), main(11, false), (AUX.line(0), false)]
}

fn all(safe: bool) -> bool {
    outputs().iter().all(|(line, level)| (line.value() == *level) == safe)
}

/// `guarded` at work.
struct Rig {
    process: Child,
    reported: Option<ChildStdin>,
    says: BufReader<ChildStdout>,
    said: &'static Path,
}

impl Rig {
    fn start(api: &str, hold: u64, dog: &str, words: &str) -> Rig {
        Rig::with_limit(LIMIT, api, hold, dog, words)
    }

    fn with_limit(limit: u64, api: &str, hold: u64, dog: &str, words: &str) -> Rig {
        let said = Path::new("/tmp/said");
        let mut process = Command::new(program("guarded"))
            .args([api, &limit.to_string(), &hold.to_string(), dog])
            .args(words.split(' '))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(File::create(said).unwrap())
            .spawn()
            .unwrap();
        let reported = process.stdin.take();
        let says = BufReader::new(process.stdout.take().unwrap());
        Rig { process, reported, says, said }
    }

    /// One whose outputs are driven away from their safe levels, and that lives.
    fn driving(api: &str, hold: u64, dog: &str) -> Rig {
        Rig::start(api, hold, dog, "hold arm drive live").lives()
    }

    fn lives(mut self) -> Rig {
        self.until("lives");
        assert!(all(false), "it does not drive");
        self
    }

    fn says(&mut self) -> String {
        let mut line = String::new();
        self.says.read_line(&mut line).unwrap();
        line.trim_end().into()
    }

    fn until(&mut self, word: &str) {
        loop {
            let line = self.says();
            assert!(!line.is_empty(), "it ended before it said {word}: {}", self.said());
            assert!(!line.starts_with("R0"), "before {word}: {line}");
            if line == word {
                return;
            }
        }
    }

    fn go_on(&mut self) {
        self.reported = None;
    }

    fn pid(&self) -> Pid {
        Pid::from_child(&self.process)
    }

    fn signal(&self, signal: Signal) {
        kill_process(self.pid(), signal).unwrap();
    }

    fn said(&self) -> String {
        std::fs::read_to_string(self.said).unwrap()
    }

    /// Its guard: its one child.
    fn guard(&self) -> Pid {
        let parent = format!("PPid:\t{}", self.process.id());
        let status = |name: &str| std::fs::read_to_string(format!("/proc/{name}/status")).unwrap_or_default();
        let names = std::fs::read_dir("/proc").unwrap().flatten();
        let mut names = names.filter_map(|entry| entry.file_name().into_string().ok());
        let child = names.find(|name| status(name).lines().any(|line| line == parent));
        Pid::from_raw(child.expect("it has a guard").parse().unwrap()).unwrap()
    }

    fn is_dead(&mut self) -> bool {
        self.process.try_wait().unwrap().is_some()
    }
}

/// The next one finds the lines free.
impl Drop for Rig {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        if !thread::panicking() {
            wait_for("the lines are let go", PATIENCE, || {
                guard::take_over(MAIN.label());
                guards() == 0
            });
        }
    }
}

/// How many guards there are.
fn guards() -> usize {
    let names = std::fs::read_dir("/proc").unwrap().flatten().map(|entry| entry.path().join("cmdline"));
    names.filter(|path| std::fs::read(path).is_ok_and(|words| words.ends_with(b"\0guard\0"))).count()
}

/// The outputs become safe within a time, counted from `since`, and stay so.
fn become_safe(what: &str, since: Instant, within: Duration) -> Duration {
    let mut took = since.elapsed();
    while !all(true) {
        assert!(took < PATIENCE, "{what}: the outputs never became safe");
        took = since.elapsed();
    }
    stay_safe(Duration::from_millis(30));
    assert!(took <= within, "{what}: safe after {took:?}, where {within:?} is the limit");
    took
}

fn stay_safe(lasts: Duration) {
    let until = Instant::now() + lasts;
    while Instant::now() < until {
        assert!(all(true), "an output changed after the latch");
    }
}

fn is_there(process: Pid) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", process.as_raw_nonzero()));
    stat.is_ok_and(|stat| !stat.contains(") Z "))
}

/// A figure for who runs the tests: on a line of its own.
fn figure(text: &str) {
    println!("\nfigure: {text}");
}

const BOTH: [&str; 2] = ["v1", "v2"];

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_rig_that_is_killed() {
    let _lab = Lab::enter();
    for api in BOTH {
        let mut took = Vec::new();
        for _ in 0..10 {
            let rig = Rig::driving(api, HOLD, "-");
            let since = Instant::now();
            rig.signal(Signal::KILL);
            took.push(become_safe(api, since, SLACK));
            wait_for("the guard says so", PATIENCE, || rig.said().contains("error[R0193]"));
            let said = rig.said();
            assert!(said.contains("without a goodbye") && said.contains("rig-gpio, rig-gpio-aux"), "{said}");
        }
        took.sort();
        assert!(took[5] < USUAL, "{took:?}");
        figure(&format!("{api}: killed to all outputs safe, median {:?}, worst {:?}", took[5], took[9]));
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_rig_that_is_stopped() {
    let _lab = Lab::enter();
    for api in BOTH {
        let mut rig = Rig::driving(api, HOLD, "-");
        let since = Instant::now();
        rig.signal(Signal::STOP);
        let took = become_safe(api, since, Duration::from_millis(LIMIT) + SLACK);
        figure(&format!("{api}: stopped to all outputs safe, {took:?} with a limit of {LIMIT} ms"));
        wait_for("the rig is killed", PATIENCE, || rig.is_dead());
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_rig_that_panics_and_one_that_ends_without_a_goodbye() {
    let _lab = Lab::enter();
    for word in ["panic", "exit"] {
        let mut rig = Rig::start("v2", HOLD, "-", &format!("hold arm drive {word}"));
        rig.until("drove");
        become_safe(word, Instant::now(), SLACK * 4);
        wait_for("it ends", PATIENCE, || rig.is_dead());
        wait_for("the guard says so", PATIENCE, || rig.said().contains("error[R0193]"));
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_scan_stuck_in_a_device_call() {
    let lab = Lab::enter();
    for api in BOTH {
        let mut rig = Rig::start(api, HOLD, "-", "hold arm drive live get");
        rig.until("lives");
        lab.stall(MAIN, Call::Get, Duration::from_secs(4), 1);
        let since = Instant::now();
        rig.go_on();
        rig.until("calls");
        let took = become_safe(api, since, Duration::from_millis(LIMIT) + SLACK);
        println!(
            "figure: {api}: stuck in a reading call to all outputs safe, {took:?} with a limit of {LIMIT} ms"
        );
        assert_eq!(lab.inside(MAIN, Call::Get), 1, "the call came back by itself");
        assert!(!rig.is_dead(), "nothing ends a process inside such a call");
        wait_for("the rig is gone", PATIENCE, || rig.is_dead());
        stay_safe(Duration::from_millis(30));
    }
}

/// The one thing that nobody can help: a write that is inside the kernel. It comes through, and the guard's drive
/// comes right after it.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_write_that_was_inside_the_kernel() {
    let lab = Lab::enter();
    for api in BOTH {
        let mut rig = Rig::start(api, HOLD, "-", "hold arm live set");
        rig.until("lives");
        lab.stall(MAIN, Call::Set, Duration::from_secs(1), 1);
        rig.go_on();
        rig.until("calls");
        wait_for("the write is inside", PATIENCE, || lab.inside(MAIN, Call::Set) == 1);
        assert!(all(true), "nothing has moved yet");
        rig.signal(Signal::KILL);
        let (mut pulse, mut since) = (Duration::ZERO, None);
        while !rig.is_dead() {
            if MAIN.line(9).value() {
                pulse = pulse.max(since.get_or_insert_with(Instant::now).elapsed());
            } else {
                since = None;
            }
        }
        assert_eq!(lab.inside(MAIN, Call::Set), 0);
        become_safe(api, Instant::now(), SLACK);
        figure(&format!("{api}: a write that could not be called back was seen for {pulse:?}"));
        assert!(pulse < SLACK, "{pulse:?}");
    }
}

/// A thread of the rig writes as fast as it can when the latch closes, and a stopped one would write when it goes on.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn late_writes_do_nothing() {
    let _lab = Lab::enter();
    for api in BOTH {
        let mut rig = Rig::start(api, 2_000, "-", "hold arm race live");
        rig.until("lives");
        let guard = rig.guard();
        rig.signal(Signal::STOP);
        become_safe(api, Instant::now(), Duration::from_millis(LIMIT) + SLACK);
        // A kill that has been sent leaves nothing to go on.
        let _ = kill_process(rig.pid(), Signal::CONT);
        stay_safe(Duration::from_millis(200));
        assert!(is_there(guard), "the guard holds the lines");
        wait_for("the guard lets go", PATIENCE, || !is_there(guard));
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn memory_that_runs_out() {
    let _lab = Lab::enter();
    let mut rig = Rig::start("v2", HOLD, "-", "hold arm drive exhaust");
    rig.until("exhausts");
    let guard = rig.guard();
    let adjusted = format!("/proc/{}/oom_score_adj", guard.as_raw_nonzero());
    assert_eq!(std::fs::read_to_string(adjusted).unwrap().trim(), "-1000");
    wait_for("the rig is killed for its memory", PATIENCE * 3, || rig.is_dead());
    become_safe("memory", Instant::now(), SLACK);
    wait_for("the guard says so", PATIENCE, || rig.said().contains("error[R0193]"));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_goodbye_stops_the_watchdog() {
    let _lab = Lab::enter();
    let mut rig =
        Rig::start("v2", 0, &format!("{DOG},2,guard-lost"), "hold arm drive live safe disarm close");
    rig.until("lives");
    // Longer than the watchdog waits: the guard feeds it.
    thread::sleep(Duration::from_secs(3));
    rig.go_on();
    rig.until("safe");
    assert_eq!((rig.says(), rig.says()), ("done".into(), "done".into()));
    wait_for("it ends", PATIENCE, || rig.is_dead());
    assert_eq!(rig.said(), "");
    // The machine would not be there any more.
    thread::sleep(Duration::from_secs(3));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn outputs_that_are_safe_need_no_watchdog() {
    let _lab = Lab::enter();
    let rig = Rig::driving("v2", HOLD, &format!("{DOG},2,guard-lost"));
    rig.signal(Signal::KILL);
    become_safe("watchdog", Instant::now(), SLACK);
    stay_safe(Duration::from_secs(3));
    drop(rig);
    thread::sleep(Duration::from_secs(3));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_watchdog_that_is_none_or_in_use() {
    let _lab = Lab::enter();
    assert_eq!(never_stops(Path::new(DOG)), Some(false));
    let mut rig = Rig::start("v2", 0, "/dev/null,2,guard-lost", "hold");
    let said = rig.says();
    assert!(said.starts_with("R0194 the watchdog /dev/null cannot be used"), "{said}");
    drop(rig);
    let mut first = Rig::driving("v2", HOLD, &format!("{DOG},10,guard-lost"));
    let mut second = Rig::start("v2", 0, &format!("{DOG},10,guard-lost"), "hold");
    let said = second.says();
    assert!(said.starts_with("R0194") && said.contains("busy"), "{said}");
    first.signal(Signal::KILL);
    wait_for("it ends", PATIENCE, || first.is_dead());
    become_safe("watchdog", Instant::now(), SLACK);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn the_next_rig_takes_the_lines_over() {
    let _lab = Lab::enter();
    let rig = Rig::driving("v2", 3_600_000, "-");
    let guard = rig.guard();
    rig.signal(Signal::KILL);
    become_safe("held", Instant::now(), SLACK);
    wait_for("the lines are let go", PATIENCE, || guard::take_over("rig-gpio") == 1);
    wait_for("the guard ends", PATIENCE, || !is_there(guard));
    drop(Rig::driving("v2", 0, "-"));
}

/// Boot 1 kills both; boot 2 finds that the watchdog reset the machine.
#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn resets_when_guard_and_rig_both_die() {
    bites("guard-lost", |_, rig| {
        kill_process(rig.guard(), Signal::KILL).unwrap();
        rig.signal(Signal::KILL);
    });
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn resets_when_an_output_cannot_be_made_safe() {
    bites("guard-lost", |lab, rig| {
        lab.stall(MAIN, Call::Set, Duration::from_secs(30), 1);
        rig.signal(Signal::KILL);
    });
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn resets_when_the_rig_is_lost_and_that_is_wanted() {
    bites("rig-lost", |_, rig| {
        rig.signal(Signal::KILL);
        become_safe("rig-lost", Instant::now(), SLACK);
    });
}

/// In the first boot the rig meets its end, and the watchdog bites; the second boot asks why it came.
fn bites(bite: &str, end: impl FnOnce(&Lab, &Rig)) {
    let lab = Lab::enter();
    if lab.boot() == 1 {
        // A machine that has just come up may stand still for longer than the usual limit.
        let rig = Rig::with_limit(2 * LIMIT, "v2", 0, &format!("{DOG},3,{bite}"), "hold arm drive live");
        let rig = rig.lives();
        end(&lab, &rig);
        wait_for("the watchdog resets the machine", PATIENCE, || false);
    }
    let dog = WatchdogDevice::open(Path::new(DOG), Span::from_secs(60)).unwrap();
    let bitten = dog.has_bitten().unwrap();
    dog.stop().unwrap();
    assert!(bitten, "the machine was reset by something else");
    assert_eq!(lab.boot(), 2);
}
