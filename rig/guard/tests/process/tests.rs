//! The tests.

use crate::files::{MASK, SAFE, allocations, levels, write};
use rustix::process::{Pid, Signal, kill_process};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitCode, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// How long anything may take on a machine that has other things to do.
const DEADLINE: Duration = Duration::from_secs(20);
/// The limit of the guards, in milliseconds: long enough for a busy machine not to mistake a slow rig for a dead one.
const LIMIT: u32 = 400;

type Test = (&'static str, fn());

const TESTS: &[Test] = &[
    ("a_rig_that_is_killed", a_rig_that_is_killed),
    ("a_rig_that_is_stopped", a_rig_that_is_stopped),
    ("a_rig_that_hangs_while_one_of_its_threads_writes", a_rig_that_hangs_while_one_of_its_threads_writes),
    ("a_rig_that_panics_or_ends_without_a_goodbye", a_rig_that_panics_or_ends_without_a_goodbye),
    ("a_goodbye_leaves_nothing_behind", a_goodbye_leaves_nothing_behind),
    ("nothing_is_expected_of_a_rig_that_does_not_drive", nothing_is_expected_of_a_rig_that_does_not_drive),
    (
        "a_device_that_hangs_keeps_no_other_from_being_safe",
        a_device_that_hangs_keeps_no_other_from_being_safe,
    ),
    ("a_rig_that_may_drive_is_not_undone", a_rig_that_may_drive_is_not_undone),
    ("lines_that_the_guard_cannot_drive_are_refused", lines_that_the_guard_cannot_drive_are_refused),
    (
        "outputs_that_are_not_safe_when_they_should_be_latch",
        outputs_that_are_not_safe_when_they_should_be_latch,
    ),
    ("a_rig_that_asks_stays_alive", a_rig_that_asks_stays_alive),
    ("a_guard_that_dies_is_noticed", a_guard_that_dies_is_noticed),
    ("the_next_rig_takes_the_lines_over", the_next_rig_takes_the_lines_over),
    ("a_machine_that_stands_still_is_no_rig_that_hangs", a_machine_that_stands_still_is_no_rig_that_hangs),
    ("keys_and_signals_stop_neither", keys_and_signals_stop_neither),
    ("the_guard_is_nobodys_command", the_guard_is_nobodys_command),
];

/// Runs the tests whose names hold the first word that is no option.
pub fn run(words: &[String]) -> ExitCode {
    let filter = words.iter().find(|word| !word.starts_with('-')).map_or("", String::as_str);
    for (name, test) in TESTS.iter().filter(|(name, _)| name.contains(filter)) {
        print!("test {name} ... ");
        let _ = std::io::stdout().flush();
        // A test that fails panics, and ends the run.
        test();
        println!("ok");
    }
    ExitCode::SUCCESS
}

/// A rig at work, and a folder with its devices.
struct Rig {
    folder: PathBuf,
    process: Child,
    reported: Option<ChildStdin>,
    says: BufReader<ChildStdout>,
}

impl Rig {
    /// A rig that does what the words say. Words before the first `hold` are its devices.
    fn start(name: &str, hold: u32, words: &str) -> Rig {
        let folder = std::env::temp_dir().join(format!("guard-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for device in words.split(' ').take_while(|word| *word != "hold") {
            write(&File::create(folder.join(device)).unwrap(), SAFE).unwrap();
        }
        let mut process = Command::new(std::env::current_exe().unwrap())
            .arg("rig")
            .arg(&folder)
            .args([LIMIT.to_string(), hold.to_string()])
            .args(words.split(' '))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(File::create(folder.join("said")).unwrap())
            .spawn()
            .unwrap();
        let reported = process.stdin.take();
        let says = BufReader::new(process.stdout.take().unwrap());
        Rig { folder, process, reported, says }
    }

    /// The next line that it says.
    fn says(&mut self) -> String {
        let mut line = String::new();
        self.says.read_line(&mut line).unwrap();
        line.trim_end().into()
    }

    /// Waits until it says this.
    fn until(&mut self, word: &str) {
        loop {
            let line = self.says();
            assert!(!line.is_empty(), "it ended before it said {word}: {}", self.said());
            if line == word {
                return;
            }
        }
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.process), signal).unwrap();
    }

    /// Lets it go on after `live` or `hang`.
    fn go_on(&mut self) {
        self.reported = None;
    }

    fn end(&mut self) -> ExitStatus {
        eventually("the rig ends", || self.process.try_wait().unwrap())
    }

    /// What rig and guard said on their standard error.
    fn said(&self) -> String {
        std::fs::read_to_string(self.folder.join("said")).unwrap()
    }

    /// The process that guards it.
    fn guard(&self) -> Pid {
        let id = self.process.id();
        let children = std::fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap();
        Pid::from_raw(children.trim().parse().unwrap()).unwrap()
    }

    /// The levels become safe, and stay so.
    fn becomes_safe(&self, device: &str) {
        eventually("the levels are safe", || (levels(&self.folder, device) == SAFE).then_some(()));
        let until = Instant::now() + Duration::from_millis(50);
        while Instant::now() < until {
            assert_eq!(levels(&self.folder, device), SAFE, "a write came late");
        }
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn eventually<T>(what: &str, mut condition: impl FnMut() -> Option<T>) -> T {
    let until = Instant::now() + DEADLINE;
    loop {
        if let Some(value) = condition() {
            return value;
        }
        assert!(Instant::now() < until, "this never came: {what}");
        std::thread::yield_now();
    }
}

fn is_there(process: Pid) -> bool {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", process.as_raw_nonzero()));
    stat.is_ok_and(|stat| !stat.contains(") Z "))
}

fn gone(process: Pid) {
    eventually("the guard ends", || (!is_there(process)).then_some(()));
}

fn a_rig_that_is_killed() {
    let mut rig = Rig::start("killed", 0, "valve heater hold arm drive live");
    rig.until("lives");
    let guard = rig.guard();
    assert_eq!(levels(&rig.folder, "heater"), !SAFE & MASK);
    rig.signal(Signal::KILL);
    rig.becomes_safe("valve");
    rig.becomes_safe("heater");
    gone(guard);
    let said = rig.said();
    assert!(said.starts_with("error[R0193]: the rig ended without a goodbye"), "{said}");
    assert!(said.contains("valve, heater: found safe"), "{said}");
    // Between taking charge of its last lines and driving them when the rig died, the guard allocated nothing.
    let counts = allocations(&rig.folder, "heater");
    assert_eq!(counts[1], counts[0], "{counts:?}");
}

fn a_rig_that_is_stopped() {
    let mut rig = Rig::start("stopped", 0, "valve hold arm drive live");
    rig.until("lives");
    let guard = rig.guard();
    rig.signal(Signal::STOP);
    rig.becomes_safe("valve");
    gone(guard);
    assert!(rig.end().code().is_none(), "it was killed");
    assert!(rig.said().contains("no sign of life"), "{}", rig.said());
}

fn a_rig_that_hangs_while_one_of_its_threads_writes() {
    let mut rig = Rig::start("races", 0, "valve hold arm race hang");
    rig.until("hangs");
    rig.end();
    rig.becomes_safe("valve");
    assert!(rig.said().contains("no sign of life"), "{}", rig.said());
}

fn a_rig_that_panics_or_ends_without_a_goodbye() {
    for word in ["panic", "exit"] {
        let mut rig = Rig::start(word, 0, &format!("valve hold arm drive {word}"));
        rig.end();
        rig.becomes_safe("valve");
        // On a busy machine the words of a panic can last longer than the limit, which is then the reason.
        eventually("the guard says why", || rig.said().contains("error[R0193]").then_some(()));
    }
}

fn a_goodbye_leaves_nothing_behind() {
    let mut rig = Rig::start("goodbye", 60_000, "valve hold arm drive live disarm close");
    rig.until("lives");
    let guard = rig.guard();
    rig.go_on();
    rig.until("lived");
    assert_eq!((rig.says(), rig.says()), ("done".into(), "done".into()));
    assert!(rig.end().success());
    assert_eq!(levels(&rig.folder, "valve"), SAFE, "the guard makes sure");
    assert!(!is_there(guard));
    assert_eq!(rig.said(), "");
}

fn nothing_is_expected_of_a_rig_that_does_not_drive() {
    let mut rig = Rig::start("idle", 0, "valve hold arm drive live safe disarm hang arm live disarm close");
    rig.until("lives");
    rig.go_on();
    rig.until("hangs");
    // Standard input is at its end, so every wait after is over at once: what counts is that the rig lives on.
    assert!(rig.end().success(), "{}", rig.said());
    let mut rig = Rig::start("silent", 0, "valve hold hang close");
    rig.until("hangs");
    std::thread::sleep(Duration::from_millis(u64::from(LIMIT) * 2));
    rig.go_on();
    rig.until("hung");
    assert_eq!(rig.says(), "done");
}

fn a_device_that_hangs_keeps_no_other_from_being_safe() {
    let mut rig = Rig::start("slow", 0, "valve slow-expander hold arm drive live");
    rig.until("lives");
    rig.signal(Signal::KILL);
    rig.becomes_safe("valve");
    assert_ne!(levels(&rig.folder, "slow-expander"), SAFE, "it takes a second");
    rig.becomes_safe("slow-expander");
}

/// A drive that the guard had ordered before it answered must not come after the answer.
fn a_rig_that_may_drive_is_not_undone() {
    let turns = 60;
    let words = "arm drive stays safe disarm ".repeat(turns);
    let mut rig = Rig::start("told", 0, &format!("tardy hold {words}close"));
    for _ in 0..turns {
        rig.until("drove");
        assert_eq!(rig.says(), "stayed");
    }
    assert!(rig.end().success());
}

fn lines_that_the_guard_cannot_drive_are_refused() {
    let mut rig = Rig::start("broken", 0, "valve broken hold close");
    let said = rig.says();
    assert!(
        said.starts_with("R0191 the guard cannot drive broken: broken: driving its lines failed"),
        "{said}"
    );
    assert_eq!(rig.says(), "done");
}

fn outputs_that_are_not_safe_when_they_should_be_latch() {
    let mut rig = Rig::start("stubborn", 0, "stubborn hold arm drive safe disarm arm");
    rig.until("safe");
    let said = rig.says();
    assert!(said.starts_with("R0196") && said.contains("stubborn: its lines read other levels"), "{said}");
    let said = rig.says();
    assert!(said.starts_with("R0193"), "{said}");
    rig.end();
    eventually("the guard says why", || rig.said().contains("R0196").then_some(()));
}

fn a_rig_that_asks_stays_alive() {
    let mut rig = Rig::start("asks", 0, "valve hold arm drive trip drive hang arm close");
    rig.until("drove");
    assert_eq!(rig.says(), "done");
    rig.until("hangs");
    // What the rig wrote after its request does not stay.
    rig.becomes_safe("valve");
    rig.go_on();
    rig.until("hung");
    assert!(rig.says().starts_with("R0193"));
    assert_eq!(rig.says(), "done");
    assert!(rig.end().success());
}

fn a_guard_that_dies_is_noticed() {
    let mut rig = Rig::start("alone", 0, "valve hold arm drive live disarm");
    rig.until("lives");
    kill_process(rig.guard(), Signal::KILL).unwrap();
    assert_eq!(rig.says(), "unguarded");
    assert!(rig.says().starts_with("R0192"));
    assert!(rig.end().success());
}

fn the_next_rig_takes_the_lines_over() {
    // Another run of these tests may ask at the same time.
    let device = format!("valve-{}", std::process::id());
    let mut rig = Rig::start("over", 3_600_000, &format!("{device} hold arm drive live"));
    rig.until("lives");
    let guard = rig.guard();
    assert_eq!(scanrig_guard::take_over(&device), 0, "its rig lives");
    rig.signal(Signal::KILL);
    rig.becomes_safe(&device);
    assert_eq!(scanrig_guard::take_over("heater"), 0, "another device");
    assert!(is_there(guard));
    eventually("the guard lets go", || (scanrig_guard::take_over(&device) == 1).then_some(()));
    gone(guard);
}

fn a_machine_that_stands_still_is_no_rig_that_hangs() {
    for first_to_wake in [true, false] {
        let mut rig = Rig::start("still", 0, "valve hold arm drive live disarm close");
        rig.until("lives");
        let guard = rig.guard();
        let all = [guard, Pid::from_child(&rig.process)];
        all.iter().for_each(|process| kill_process(*process, Signal::STOP).unwrap());
        std::thread::sleep(Duration::from_millis(u64::from(LIMIT) * 2));
        let (first, second) = if first_to_wake { (all[0], all[1]) } else { (all[1], all[0]) };
        kill_process(first, Signal::CONT).unwrap();
        kill_process(second, Signal::CONT).unwrap();
        rig.go_on();
        rig.until("lived");
        assert_eq!((rig.says(), rig.says()), ("done".into(), "done".into()), "{}", rig.said());
    }
}

fn keys_and_signals_stop_neither() {
    let mut rig = Rig::start("keys", 0, "valve hold arm drive live disarm close");
    rig.until("lives");
    let guard = rig.guard();
    for signal in [Signal::TERM, Signal::INT, Signal::HUP, Signal::TSTP] {
        kill_process(guard, signal).unwrap();
    }
    rig.signal(Signal::TSTP);
    rig.go_on();
    rig.until("lived");
    assert_eq!((rig.says(), rig.says()), ("done".into(), "done".into()));
    assert!(rig.end().success(), "{}", rig.said());
}

fn the_guard_is_nobodys_command() {
    let here = std::env::current_exe().unwrap();
    let run = |stdin: Stdio| {
        let mut process =
            Command::new(&here).arg("guard").stdin(stdin).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = String::new();
        process.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        (process.wait().unwrap().code(), said)
    };
    let (code, said) = run(File::open(Path::new("/dev/null")).unwrap().into());
    assert_eq!(code, Some(2));
    assert!(said.contains("started by the rig itself"), "{said}");
}
