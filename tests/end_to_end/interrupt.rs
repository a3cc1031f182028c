//! Exit codes 130 and 141: the user stops a run, or no longer reads it; what ran is kept, what runs ends with its outputs safe.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::project_folder::{TestProject, drain};

/// How soon a run must have ended. The plans here go on for hours.
const SOON: Duration = Duration::from_secs(20);

const HOURS: &str = "ends = \"start + 20 h\"\ntimeout = \"24 h\"\n";

fn start(mut command: Command) -> Child {
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn interrupt(child: &Child, signal: Signal) {
    kill(Pid::from_raw(child.id() as i32), signal).unwrap();
}

/// The exit code, of a command that must end now.
pub fn end(mut child: Child) -> Option<i32> {
    let began = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        if began.elapsed() > SOON {
            child.kill().unwrap();
            panic!("the run does not end");
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Waits until the command catches the signal: from then on the cases run.
pub fn wait_for_handler(child: &Child, signal: Signal) {
    let began = Instant::now();
    loop {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or("0");
        let caught = u64::from_str_radix(caught.trim(), 16).unwrap();
        if caught >> (signal as i32 - 1) & 1 == 1 {
            return;
        }
        assert!(began.elapsed() < SOON, "the signal is never caught");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_run_on_the_real_clock_stops_cleanly() {
    let bench = TestProject::new();
    // The first case has nothing to wait for after the controller's boot; the second goes on for hours.
    bench.write(
        "quick.toml",
        "format = 1\ntitle = \"Quick\"\nprogram = \"lamp.st\"\nends = \"start + 10 ms\"\nsignals = { lamp = \"%QX0.4\" }\n\
         expect = [{ stays = { signal = \"lamp\", is = false, from = \"start\", until = \"end\" } }]\n",
    );
    bench.write_lamp("hours.toml", "program =", &format!("{HOURS}program ="));
    let mut child = start(bench.command(&[
        "test",
        "quick.toml",
        "hours.toml",
        "lamp.toml",
        "--clock",
        "real",
        "--report",
        "out",
        "--format",
        "json",
    ]));
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let err = drain(child.stderr.take().unwrap());
    let mut line = String::new();
    while !(line.contains("case-started") && line.contains("\"hours\"")) {
        line.clear();
        assert!(out.read_line(&mut line).unwrap() > 0, "the second case never begins");
    }
    interrupt(&child, Signal::SIGINT);
    let rest = drain(out);
    assert_eq!(end(child), Some(130));
    let (rest, err) = (rest.join().unwrap(), err.join().unwrap());
    assert_eq!(err, "");
    assert!(rest.contains("\"error\"") && rest.contains("interrupted"), "{rest}");
    assert!(rest.contains("skipped") && rest.contains("the run ended before it"), "{rest}");
    // Everything that was seen is kept whole, and nothing is left half written.
    assert_eq!(bench.list("out"), crate::report::OUTPUTS);
    assert_eq!(bench.list("out/traces"), ["hours.trace", "hours.vcd", "quick.trace", "quick.vcd"]);
    let cases = bench.json("out/record.json")["cases"].clone();
    assert_eq!((&cases[1]["verdict"], &cases[1]["reason"]), (&"error".into(), &"interrupted".into()));
    assert_eq!(cases[2]["status"]["is"], "skipped");
    // The trace of the interrupted case says so itself, and ends with the anchor `end`.
    let judged = bench.expect(4, &["judge", "hours.toml", "out/traces/hours.trace"]);
    assert!(judged.out.contains("interrupted"), "{}", judged.out);
    let waves = bench.read("out/traces/hours.vcd");
    let end = waves.lines().find(|line| line.starts_with("$var") && line.contains(" step:end ")).unwrap();
    let end = end.split(' ').nth(3).unwrap().to_owned();
    assert!(waves.lines().any(|line| line.starts_with("b0") && line.ends_with(&format!("1 {end}"))), "{end}");
}

#[test]
fn an_interrupt_does_not_wait_for_the_next_event() {
    let bench = TestProject::new();
    // Without an application nothing happens on the controller for hours.
    bench.write(
        "empty.toml",
        &format!(
            "format = 1\ntitle = \"Nothing happens\"\nprogram = \"lamp.st\"\n{HOURS}settings = {{ initial = \"empty\" }}\n\
             expect = [{{ state = {{ stays = \"EMPTY\", from = \"start\", until = \"end\" }} }}]\n"
        ),
    );
    let child = start(bench.command(&["test", "empty.toml", "--clock", "real"]));
    wait_for_handler(&child, Signal::SIGTERM);
    interrupt(&child, Signal::SIGTERM);
    assert_eq!(end(child), Some(130));
}

#[test]
fn a_run_in_virtual_time_stops_cleanly() {
    let bench = TestProject::new();
    bench.write_lamp("hours.toml", "program =", "ends = \"start + 90 d\"\ntimeout = \"99 d\"\nprogram =");
    bench.write("too.toml", &bench.read("hours.toml"));
    let mut child =
        start(bench.command(&["test", "hours.toml", "too.toml", "--jobs", "2", "--report", "out"]));
    let out = drain(child.stdout.take().unwrap());
    wait_for_handler(&child, Signal::SIGINT);
    interrupt(&child, Signal::SIGINT);
    assert_eq!(end(child), Some(130));
    let out = out.join().unwrap();
    assert!(out.contains("hours") && out.contains("too") && !out.contains("PASS"), "{out}");
    assert_eq!(bench.json("out/record.json")["cases"].as_array().unwrap().len(), 2);
}

#[test]
fn a_measurement_of_hours_shows_what_it_has() {
    let bench = TestProject::new();
    let child = start(bench.command(&["bench", "latency", "--interval", "1 ms", "--count", "100000000"]));
    wait_for_handler(&child, Signal::SIGINT);
    interrupt(&child, Signal::SIGINT);
    assert_eq!(end(child), Some(130));
}

/// A bench with a plan whose lines are so long that two thousand of them are more than a pipe and the rig's own room take.
fn bench_of_long_lines() -> (TestProject, String) {
    let bench = TestProject::new();
    let long = format!("{}.toml", "l".repeat(200));
    bench.write(
        &long,
        "format = 1\ntitle = \"Quick\"\nprogram = \"lamp.st\"\nends = \"start + 10 ms\"\nsignals = { lamp = \"%QX0.4\" }\n\
         expect = [{ stays = { signal = \"lamp\", is = false, from = \"start\", until = \"end\" } }]\n",
    );
    (bench, long)
}

#[test]
fn a_run_whose_words_nobody_reads_ends_all_the_same() {
    let (bench, long) = bench_of_long_lines();
    for format in ["text", "json"] {
        let child = start(bench.command(&["test", &long, "--repeat", "2000", "--format", format]));
        wait_for_handler(&child, Signal::SIGINT);
        interrupt(&child, Signal::SIGINT);
        assert_eq!(end(child), Some(130));
    }
}

const QUICK: &str = "format = 1\ntitle = \"Quick\"\nprogram = \"lamp.st\"\nends = \"start + 10 ms\"\nsignals = { lamp = \"%QX0.4\" }\n\
                     expect = [{ stays = { signal = \"lamp\", is = false, from = \"start\", until = \"end\" } }]\n";

#[test]
fn a_reader_that_closes_its_pipe_ends_the_run() {
    let bench = TestProject::new();
    bench.write("a.toml", QUICK);
    bench.write_lamp("hours.toml", "program =", "ends = \"start + 900 d\"\ntimeout = \"999 d\"\nprogram =");
    for more in [&["--format", "text"][..], &["--format", "json"], &["--clock", "real"]] {
        let args = [&["test", "a.toml", "hours.toml"][..], more].concat();
        let mut child = start(bench.command(&args));
        let err = drain(child.stderr.take().unwrap());
        let mut out = BufReader::new(child.stdout.take().unwrap());
        out.read_line(&mut String::new()).unwrap();
        drop(out);
        assert_eq!(end(child), Some(141), "{more:?}");
        assert_eq!(err.join().unwrap(), "", "{more:?}");
    }
}

#[test]
fn reports_are_whole_whoever_reads_the_lines() {
    let bench = TestProject::new();
    bench.write("a.toml", QUICK);
    for (more, file) in [(["--report", "out"], "out/record.json"), (["--summary", "all.md"], "all.md")] {
        let mut child = start(bench.command(&[&["test", "a.toml", "--repeat", "60"][..], &more].concat()));
        drop(child.stdout.take());
        assert_eq!(end(child), Some(0));
        assert!(bench.read(file).contains("60"), "{file}");
    }
    assert_eq!(bench.json("out/record.json")["totals"]["passed"], 60);
    assert_eq!(bench.list("out"), crate::report::OUTPUTS);
}

#[test]
fn a_run_whose_words_fill_one_pipe_of_both_streams_ends_within_seconds_of_an_interrupt() {
    let (bench, long) = bench_of_long_lines();
    let (_reader, output) = std::io::pipe().unwrap();
    let errors = output.try_clone().unwrap();
    let mut command = bench.command(&["test", &long, "--repeat", "10000", "--format", "json"]);
    let child = command.stdout(output).stderr(errors).spawn().unwrap();
    wait_for_handler(&child, Signal::SIGINT);
    // By now it waits for the reader.
    std::thread::sleep(Duration::from_secs(2));
    let began = Instant::now();
    interrupt(&child, Signal::SIGINT);
    assert_eq!(end(child), Some(130));
    let lasted = began.elapsed();
    assert!(lasted < Duration::from_secs(10), "{lasted:?}");
}

#[test]
fn a_run_whose_words_are_read_slowly_prints_all_of_them() {
    let (bench, long) = bench_of_long_lines();
    let (reader, output) = std::io::pipe().unwrap();
    let errors = output.try_clone().unwrap();
    let mut command = bench.command(&["test", &long, "--repeat", "4000", "--format", "json"]);
    let child = command.stdout(output).stderr(errors).spawn().unwrap();
    drop(command);
    let mut lines = Vec::new();
    for line in BufReader::new(reader).lines() {
        if lines.len() % 400 == 0 {
            std::thread::sleep(Duration::from_millis(20));
        }
        lines.push(line.unwrap());
    }
    assert_eq!(end(child), Some(0));
    let is_whole = |line: &&String| serde_json::from_str::<serde_json::Value>(line).is_ok();
    assert_eq!(lines.iter().filter(is_whole).count(), lines.len());
    assert!(lines.len() >= 4_000, "{}", lines.len());
}
