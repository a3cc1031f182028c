//! `rig board` on real lines.

use devices::{Lab, MAIN, PATIENCE, SimChip, rig, wait_for};
use nix::pty::{OpenptyResult, Winsize, openpty};
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// What a command printed, and its exit code.
struct Ran {
    code: i32,
    out: String,
    err: String,
}

fn run(args: &[&str]) -> Ran {
    let Output { status, stdout, stderr } = Command::new(rig()).args(args).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ran { code: status.code().unwrap(), out: text(stdout), err: text(stderr) }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_scan_names_chips_lines_holders_and_other_devices() {
    let _lab = Lab::enter();
    let ran = run(&["board", "scan"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    for line in [
        "rig-gpio = { label = \"rig-gpio\" } # /dev/gpiochip0, 32 lines, interface v2",
        "rig-gpio-aux = { label = \"rig-gpio-aux\" } # /dev/gpiochip1, 8 lines, interface v2",
        "rig-gpio-0 = { kind = \"digital\", chip = \"rig-gpio\", line = 0, drives = false }",
        "DOOR = { kind = \"digital\", chip = \"rig-gpio\", line = \"DOOR\", drives = false }",
        "rig-gpio-26 = { kind = \"digital\", chip = \"rig-gpio\", line = \"VALVE\", drives = false }",
        "rig-gpio-aux-5 = { kind = \"digital\", chip = \"rig-gpio-aux\", line = \"VALVE\", drives = false }",
        "# HOGGED = { kind = \"digital\", chip = \"rig-gpio-aux\", line = \"HOGGED\", drives = false } # held by lab-hog",
    ] {
        assert!(ran.out.lines().any(|found| found == line), "`{line}` is missing in\n{}", ran.out);
    }
    // Converters and buses are parts of the board; as comments where they could move something, or cannot be used.
    for line in [
        "# spidev0-0 = { kind = \"spi\", path = \"/dev/spidev0.0\", part = ",
        "rig-adc = { kind = \"iio\", name = \"rig-adc\", period = \"100 ms\" } # iio:device0, 4 inputs, can sample",
        "rig-adc-voltage3 = { kind = \"analog\", unit = \"V\", converter = \"rig-adc\", input = \"voltage3\" }",
        "rig-counter-1 = { name = \"rig-counter\", count = 1, ",
        "rig-counter-1-count = { kind = \"count\", counter = \"rig-counter-1\" }",
        "can0 = { kind = \"can\", interface = \"can0\", bitrate = 500000 } # ",
        "can3 = { kind = \"can\", interface = \"can3\", bitrate = 500000, data-bitrate = 2000000 } # ",
        "# vcan0 = { kind = \"can\", interface = \"vcan0\", bitrate = 500000 } # ",
        "# ttyS",
        "# spidev0-4-out = { kind = \"spi\", path = \"/dev/spidev0.4\" } # if nothing is connected",
        "# rig-pwm = { kind = \"pwm\", path = \"/sys/devices/platform/rig-pwm\" } # 4 outputs",
    ] {
        assert!(ran.out.lines().any(|found| found.starts_with(line)), "`{line}` is missing in\n{}", ran.out);
    }
    assert!(
        ran.out.contains("#   watchdog  /dev/watchdog0") && ran.out.contains(" i6300ESB timer"),
        "{}",
        ran.out
    );
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_scan_writes_its_file_once_and_touches_no_line() {
    let lab = Lab::enter();
    let before = fs::read_to_string("/sys/kernel/debug/gpio").unwrap();
    let file = "/tmp/first.toml";
    let _ = fs::remove_file(file);
    let (first, shown) = (run(&["board", "scan", "--output", file]), run(&["board", "scan"]));
    assert_eq!((first.code, first.out.as_str()), (0, "/tmp/first.toml\n"));
    assert_eq!(fs::read_to_string(file).unwrap(), shown.out);
    // It is of use as it is.
    let checked = run(&["check", file]);
    assert_eq!((checked.code, checked.out.as_str()), (0, "/tmp/first.toml: no errors\n"), "{}", checked.err);
    let there = run(&["board", "check", file]);
    let lines = shown.out.lines().filter(|line| line.contains("line = ") && !line.starts_with('#')).count();
    // Four inputs of the converter, and two counts.
    let channels = lines + 4 + 2;
    // Two chips of 32 and 8 lines, one of them held by the kernel, and perhaps one that a test before left as an output.
    assert!((38..=39).contains(&lines), "{}", shown.out);
    assert!(
        there.code == 0 && there.out.ends_with(&format!("all {channels} channels and 6 buses can be had\n")),
        "{}{}",
        there.out,
        there.err
    );
    let watched = run(&["board", "watch", file, "--for", "100 ms"]);
    assert!(
        // Beside compilers an emulated machine may miss a sample.
        [0, 4].contains(&watched.code) && watched.out.contains("  rig-gpio-aux-6  0\n"),
        "{}{}",
        watched.out,
        watched.err
    );
    fs::write(file, "mine").unwrap();
    let again = run(&["board", "scan", "-o", file]);
    assert_eq!(again.code, 2);
    assert!(again.err.contains("error[R0242]: `/tmp/first.toml` is there already"), "{}", again.err);
    assert_eq!(fs::read_to_string(file).unwrap(), "mine");
    assert_eq!(fs::read_to_string("/sys/kernel/debug/gpio").unwrap(), before);
    drop(lab);
}

/// Two inputs that a test pulls, and two outputs.
const BENCH: &str = r#"format = 1
[board]
kind = "real"
[chips]
main = { label = "rig-gpio" }
[channels]
door = { kind = "digital", line = "DOOR" }
low = { kind = "digital", line = 1, active-low = true }
valve = { kind = "digital", line = 8, drives = true, safe = false }
pump = { kind = "digital", line = 9, drives = true, safe = true }
[guard]
limit = "2 s"
"#;

fn write(name: &str, text: &str) -> String {
    let path = format!("/tmp/{name}");
    fs::write(&path, text).unwrap();
    path
}

/// A command that goes on, and the lines that it printed so far.
struct Going {
    child: Child,
    lines: Arc<Mutex<Vec<String>>>,
}

impl Going {
    fn start(args: &[&str]) -> Going {
        let mut child = Command::new(rig()).args(args).stdout(Stdio::piped()).spawn().unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let lines = Arc::new(Mutex::new(Vec::new()));
        let keep = lines.clone();
        std::thread::spawn(move || {
            out.lines().map_while(Result::ok).for_each(|line| keep.lock().unwrap().push(line))
        });
        Going { child, lines }
    }

    /// Waits for a line whose last words are these.
    fn await_line(&self, end: &str) {
        wait_for(end, PATIENCE, || self.lines.lock().unwrap().iter().any(|line| line.ends_with(end)));
    }

    /// Ends it as Ctrl-C does: its exit code and all lines.
    fn interrupt(mut self) -> (Option<i32>, Vec<String>) {
        let pid = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
        let code = self.child.wait().unwrap().code();
        // The reader ends with the pipe, right after the process.
        wait_for("all lines are read", PATIENCE, || Arc::strong_count(&self.lines) == 1);
        let lines = self.lines.lock().unwrap().clone();
        (code, lines)
    }
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_check_says_what_is_there_and_who_holds_what_is_not_free() {
    let _lab = Lab::enter();
    let file = write("bench.toml", BENCH);
    let free = run(&["board", "check", &file]);
    let expected = "\
/dev/gpiochip0 (rig-gpio): 32 lines, interface v2
door   reads line 24 (DOOR), on gpiochip0, free
low    reads line 1, on gpiochip0, free
valve  drives line 8, on gpiochip0, free
pump   drives line 9, on gpiochip0, free
/tmp/bench.toml: all 4 channels can be had
";
    assert_eq!((free.code, free.out.as_str(), free.err.as_str()), (0, expected, ""));
    let watch = Going::start(&["board", "watch", &file]);
    watch.await_line("low  1");
    let held = run(&["board", "check", &file]);
    assert_eq!(held.code, 2);
    assert!(
        held.out.contains("door   not available\n") && held.out.contains("valve  drives line 8"),
        "{}",
        held.out
    );
    assert!(
        held.err.contains("error[B0174]: line 24 (DOOR) of /dev/gpiochip0 (rig-gpio) is held by rig"),
        "{}",
        held.err
    );
    assert!(held.err.contains("bench.toml:7:35"), "{}", held.err);
    assert_eq!(watch.interrupt().0, Some(0));
    assert_eq!(run(&["board", "check", &file]).code, 0);
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_watch_reports_every_change_and_leaves_outputs_alone() {
    let lab = Lab::enter();
    // If an output were claimed, the line that is wired to it would move.
    lab.wire_inverted(MAIN.line(9), MAIN.line(2));
    let watch = Going::start(&["board", "watch", &write("bench.toml", BENCH)]);
    watch.await_line("door  0");
    watch.await_line("low  1");
    // The simulated chip reports a change only when the one before is through.
    for (turn, level) in [true, false, true].into_iter().enumerate() {
        for line in [MAIN.line(24), MAIN.line(1)] {
            line.pull(level);
        }
        wait_for("both changes", PATIENCE, || watch.lines.lock().unwrap().len() == 4 + 2 * turn);
        assert!(MAIN.line(2).value());
    }
    let (code, lines) = watch.interrupt();
    assert_eq!(code, Some(0), "{lines:?}");
    let of = |name: &str| -> Vec<String> {
        let words = lines.iter().map(|line| line.split_whitespace().collect::<Vec<_>>());
        words.filter(|words| words.len() == 4 && words[2] == name).map(|words| words[3].to_owned()).collect()
    };
    assert_eq!(
        (of("door"), of("low")),
        (["0", "1", "0", "1"].map(str::to_owned).into(), ["1", "0", "1", "0"].map(str::to_owned).into())
    );
    let table = lines.iter().position(|line| line.starts_with("channel")).unwrap();
    let row = |at: usize| lines[table + at].split_whitespace().take(4).collect::<Vec<_>>().join(" ");
    assert_eq!((row(1), row(2)), ("door 1 2 1".to_owned(), "low 0 1 2".to_owned()));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_watch_says_that_a_chip_is_gone() {
    let _lab = Lab::enter();
    let chip = SimChip::add("passing", &["", ""]);
    let text = BENCH.replace("rig-gpio", "passing").replace("\"DOOR\"", "0");
    let text: String =
        text.lines().filter(|line| !line.contains("drives")).map(|line| format!("{line}\n")).collect();
    let watch = Going::start(&["board", "watch", &write("passing.toml", &text)]);
    watch.await_line("door  0");
    chip.vanish();
    watch.await_line("door  gone");
    let (code, lines) = watch.interrupt();
    assert_eq!(code, Some(4), "{lines:?}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_exercise_moves_the_outputs_agreed_to_one_at_a_time_and_leaves_them_safe() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(8), MAIN.line(24));
    lab.wire_inverted(MAIN.line(9), MAIN.line(1));
    let file = write("bench.toml", BENCH);
    let ran = run(&["board", "exercise", &file, "--yes", "valve", "--hold", "200 ms"]);
    assert_eq!(ran.code, 0, "{}{}", ran.out, ran.err);
    let reported = |out: &str| -> Vec<String> {
        let words = out.lines().map(|line| line.split(" within").next().unwrap().to_owned());
        words.collect()
    };
    assert_eq!(reported(&ran.out), ["valve", "  to 1: door rises", "  to 0: door falls"]);
    assert!(!MAIN.line(8).value() && !MAIN.line(9).value());
    // A low level of `low` is 1, and its wire inverts: it follows the pump, which is safe when it is driven.
    let ran = run(&["board", "exercise", &file, "--yes", "valve,pump", "--hold", "200 ms"]);
    let both = [
        "valve",
        "  to 1: door rises",
        "  to 0: door falls",
        "pump",
        "  to 0: low falls",
        "  to 1: low rises",
    ];
    assert_eq!((ran.code, reported(&ran.out)), (0, both.map(str::to_owned).into()), "{}", ran.err);
    let nobody = run(&["board", "exercise", &file]);
    assert!(nobody.code == 2 && nobody.err.contains("R0245") && nobody.out.is_empty(), "{}", nobody.err);
}

/// A command on a terminal of its own: what is typed is an answer to each prompt. Returns its exit code and the screen.
fn on_terminal(args: &[&str], typed: &[&str]) -> (Option<i32>, String) {
    let size = Winsize { ws_row: 24, ws_col: 100, ws_xpixel: 0, ws_ypixel: 0 };
    let OpenptyResult { master, slave } = openpty(&size, None).unwrap();
    let side = || Stdio::from(slave.try_clone().unwrap());
    let mut command = Command::new(rig());
    command.args(args).env("TERM", "xterm").stdin(side()).stdout(side()).stderr(side());
    let mut child = command.spawn().unwrap();
    drop((command, slave));
    let mut terminal = File::from(master);
    let (mut screen, mut some, mut typed) = (Vec::new(), [0; 4096], typed.iter());
    // The terminal ends for its reader when nobody has the other side any more.
    while let Ok(n @ 1..) = terminal.read(&mut some) {
        screen.extend_from_slice(&some[..n]);
        if screen.ends_with(b"> ")
            && let Some(line) = typed.next()
        {
            terminal.write_all(format!("{line}\n").as_bytes()).unwrap();
        }
    }
    (child.wait().unwrap().code(), String::from_utf8_lossy(&screen).into_owned())
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn on_a_terminal_lines_are_a_table_and_outputs_are_asked_for() {
    let lab = Lab::enter();
    lab.wire(MAIN.line(8), MAIN.line(24));
    let file = write("bench.toml", BENCH);
    let (code, screen) = on_terminal(&["board", "watch", &file, "--for", "1 s"], &[]);
    // A row of the table is drawn while it lasts, and the whole table stands there at the end.
    assert!(
        code == Some(0) && screen.contains("\u{1b}[2Kdoor                0         0         0  -"),
        "{screen:?}"
    );
    assert!(
        screen.contains("channel         level     rises     falls  last change\r\ndoor                0"),
        "{screen:?}"
    );
    let (code, screen) = on_terminal(&["board", "exercise", &file, "--hold", "100 ms"], &["yes", "no"]);
    assert!(
        code == Some(0) && screen.contains("valve: drive it from 0 to 1 for 100 ms, and back?"),
        "{screen}"
    );
    assert!(
        screen.contains("to 1: door rises within") && screen.contains("to 0: door falls within"),
        "{screen}"
    );
    assert!(screen.contains("pump: drive it from 1 to 0") && !screen.contains("  to 0: low"), "{screen}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_interrupted_exercise_leaves_its_output_safe() {
    let lab = Lab::enter();
    let file = write("bench.toml", BENCH);
    // What the output does is seen on a line that keeps its level when the output is let go.
    lab.wire(MAIN.line(8), MAIN.line(30));
    let exercise = Going::start(&["board", "exercise", &file, "--yes", "valve", "--hold", "5 s"]);
    wait_for("the output is driven", PATIENCE, || MAIN.line(30).value());
    let begin = Instant::now();
    let (code, lines) = exercise.interrupt();
    assert_eq!(code, Some(130), "{lines:?}");
    assert!(!MAIN.line(30).value() && begin.elapsed() < Duration::from_secs(4), "{:?}", begin.elapsed());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_killed_exercise_leaves_its_output_safe() {
    let lab = Lab::enter();
    let file = write("bench.toml", BENCH);
    lab.wire(MAIN.line(8), MAIN.line(30));
    let mut exercise = Going::start(&["board", "exercise", &file, "--yes", "valve", "--hold", "5 s"]);
    wait_for("the output is driven", PATIENCE, || MAIN.line(30).value());
    exercise.child.kill().unwrap();
    exercise.child.wait().unwrap();
    // A line that is let go leaves the one behind its wire as it was, so somebody has driven it.
    wait_for("the output is safe", PATIENCE, || !MAIN.line(30).value());
}
