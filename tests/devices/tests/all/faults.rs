//! Faults on real wires, made by relays; and a bench that one user has at a time.

use devices::{ADC, Adc, Contact, Lab, MAIN, PATIENCE, bind_spi, rig, wait_for};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Output line 8 is wired to input line 0, on whose wire lines 12 to 14 put faults.
const BOARD: &str = r#"
format = 1
[board]
kind = "real"
unresponsive-after = "3 s"
[chips]
main = { label = "rig-gpio" }
[channels]
I0 = { kind = "digital", line = 0 }
Q4 = { kind = "digital", line = 8 }
Q5 = { kind = "digital", line = 9 }
K1 = { kind = "digital", line = 12 }
K2 = { kind = "digital", line = 13 }
K3 = { kind = "digital", line = 14 }
[fault-relays]
I0 = { open = "K1", short-to-ground = "K2", short-to-supply = "K3", settle = "50 ms" }
[guard]
limit = "5 s"
[realtime]
late = "2 s"
"#;

/// Q4 feeds the wire from 1 s to 3 s of the program; Q5 says that nothing arrives.
const PLAN: &str = r#"
format = 1
title = "A wire that is cut and shorted"
board = "board.toml"
program-text = """
PROGRAM MAIN
VAR feed AT %QX0.4 : BOOL; quiet AT %QX0.5 : BOOL; wire AT %IX0.0 : BOOL; END_VAR
feed := TRUE;
quiet := NOT wire;
END_PROGRAM
"""
signals = { wire = "%IX0.0", quiet = "%QX0.5", cutter = "K1" }
steps = [
  { id = "cut", at = "start + 600 ms", fault = { signal = "wire", kind = "open" } },
  { id = "cleared", at = "start + 1600 ms", clear = { signal = "wire" } },
  { id = "short", at = "start + 2600 ms", fault = { signal = "wire", kind = "short-to-ground", duration = "800 ms" } },
  { id = "held", at = "start + 4 s", fault = { signal = "wire", kind = "stuck", value = true, duration = "200 ms" } },
]
expect = [
  { rises = { signal = "cutter", from = "start + 100 ms", within = "100 ms .. 1 s" } },
  { falls = { signal = "wire", from = "start + 100 ms", within = "100 ms .. 1 s" } },
  { rises = { signal = "quiet", from = "cut", within = "0 ms .. 800 ms" } },
  { falls = { signal = "quiet", from = "cleared", within = "0 ms .. 800 ms" } },
  { rises = { signal = "quiet", from = "short", within = "0 ms .. 800 ms" } },
  { value = { of = "wire @ cut.done + 400 ms", is = false } },
  { value = { of = "wire @ cleared.done + 400 ms", is = true } },
  { value = { of = "wire @ short.done - 450 ms", is = false } },
  { stays = { signal = "wire", is = true, from = "held", until = "end" } },
]
ends = "start + 5 s"
"#;

/// A folder of its own, with the board file and the plan.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str, board: &str) -> Folder {
        let folder = std::env::temp_dir().join(format!("faults-{name}"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("board.toml"), board).unwrap();
        std::fs::write(folder.join("wire.toml"), PLAN).unwrap();
        Folder(folder)
    }

    fn path(&self) -> &Path {
        &self.0
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(rig());
        command.args(args).current_dir(self.path()).env("XDG_STATE_HOME", self.path());
        command
    }

    /// Runs the command: its exit code, and what it printed on both ways out.
    fn run(&self, args: &[&str]) -> (i32, String, String) {
        let ran = self.command(args).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (ran.status.code().unwrap(), text(&ran.stdout), text(&ran.stderr))
    }

    fn start(&self, args: &[&str]) -> Child {
        self.command(args).stdout(Stdio::inherit()).spawn().unwrap()
    }
}

/// The wire and its relays, whose contacts move 5 ms after their coils.
fn wired() -> Lab {
    let lab = Lab::enter();
    lab.wire(MAIN.line(8), MAIN.line(0));
    for (line, contact) in [(12, Contact::Open), (13, Contact::Ground), (14, Contact::Supply)] {
        lab.relay(MAIN.line(line), contact, MAIN.line(0), Duration::from_millis(5));
    }
    lab
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_plan_cuts_and_shorts_a_real_wire() {
    let _lab = wired();
    let folder = Folder::new("plan", BOARD);
    let (code, out, err) = folder.run(&["test", "wire.toml", "--report", "out"]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(out.contains("1 passed") || out.contains("pass"), "{out}");
    assert!((12..=14).all(|line| !MAIN.line(line).value()), "the relays are off after the run");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_fault_that_no_relay_makes_is_not_applicable() {
    let _lab = wired();
    let folder = Folder::new("lacking", &BOARD.replace("short-to-ground = \"K2\", ", ""));
    let (code, out, err) = folder.run(&["test", "wire.toml"]);
    let reason = "the board has no relay that brings the fault \"short to ground\" about on `I0`";
    assert!(out.contains(reason) && !out.contains("pass "), "{code} {out}{err}");
    // A relay that takes too long for what the plan asks for.
    std::fs::write(folder.path().join("board.toml"), BOARD.replace("\"50 ms\"", "\"101 ms\"")).unwrap();
    let (code, out, err) = folder.run(&["test", "wire.toml"]);
    let reason = "the relays of `I0` settle within 101 ms: they cannot make a fault of 200 ms";
    assert!(out.contains(reason), "{code} {out}{err}");
    let (code, out, err) = folder.run(&["check", "wire.toml"]);
    assert!(format!("{out}{err}").contains(reason), "{code} {out}{err}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_rig_that_is_killed_leaves_no_fault_on_a_wire() {
    let _lab = wired();
    let folder = Folder::new("killed", &BOARD.replace("limit = \"5 s\"", "limit = \"1 s\""));
    let plan = PLAN.replace("start + 1600 ms", "start + 60 s").replace("start + 5 s", "start + 90 s");
    std::fs::write(folder.path().join("wire.toml"), plan).unwrap();
    let mut child = folder.start(&["test", "wire.toml"]);
    wait_for("the relay is on", PATIENCE, || MAIN.line(12).value());
    wait_for("the wire is cut", PATIENCE, || MAIN.line(8).value() && !MAIN.line(0).value());
    child.kill().unwrap();
    child.wait().unwrap();
    wait_for("the relay is off", PATIENCE, || !MAIN.line(12).value());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn an_exercise_shows_which_relay_does_what() {
    let _lab = wired();
    MAIN.line(0).pull(true);
    let folder = Folder::new("exercise", BOARD);
    let args = ["board", "exercise", "board.toml", "--yes", "K1,K3", "--hold", "100 ms"];
    let (code, out, err) = folder.run(&args);
    assert_eq!(code, 0, "{out}{err}");
    for line in ["K1, which opens the wire of I0\n", "K3, which shorts the wire of I0 to the supply\n"] {
        assert!(out.contains(line), "`{line}` is missing in\n{out}");
    }
    assert!(out.contains("I0 rises within"), "{out}");
    let (_, out, _) = folder.run(&["board", "check", "board.toml"]);
    assert!(out.contains("free; shorts the wire of I0 to ground\n"), "{out}");
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_second_user_sees_who_has_the_bench_and_may_wait() {
    let _lab = wired();
    let folder = Folder::new("users", &BOARD.replace("limit = \"5 s\"", "limit = \"1 s\""));
    let plan = PLAN.replace("start + 1600 ms", "start + 60 s").replace("start + 5 s", "start + 90 s");
    std::fs::write(folder.path().join("wire.toml"), plan).unwrap();
    let mut first = folder.start(&["test", "wire.toml"]);
    wait_for("the relay is on", PATIENCE, || MAIN.line(12).value());
    // Other words for the same lines, and not all of them.
    let board = BOARD.replace("label = \"rig-gpio\"", "path = \"/dev/rig/gpio0\"");
    let board = board.replace("Q5 = { kind = \"digital\", line = 9 }\n", "");
    std::fs::write(folder.path().join("other.toml"), board).unwrap();
    let exercise = ["board", "exercise", "other.toml", "--yes", "Q4", "--hold", "100 ms"];
    let (code, out, err) = folder.run(&exercise);
    let process = format!("with `rig test wire.toml`, process {}", first.id());
    assert!(code == 2 && out.is_empty() && err.contains("error[R0280]"), "{code} {out}{err}");
    assert!(err.contains(&process) && err.contains("has had line 0 of gpiochip0 for "), "{err}");
    // Whoever waits has it when the first one is gone, however that went.
    let waits = [&exercise[..], &["--wait", "60 s"]].concat();
    let mut second = folder.command(&waits).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = [0; 25];
    std::io::Read::read_exact(second.stderr.as_mut().unwrap(), &mut said).unwrap();
    assert_eq!(std::str::from_utf8(&said).unwrap(), "note: waiting for the ben");
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(second.wait().unwrap().success());
}

/// A board of buses and converters.
fn board_of(buses: &str, channels: &str, converters: &str) -> String {
    format!(
        "format = 1
[board]
kind = \"real\"
unresponsive-after = \"5 s\"
[buses]
{buses}
[channels]
{channels}
[converters]
{converters}
[guard]
limit = \"5 s\"
[realtime]
late = \"10 s\"
"
    )
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn every_kind_of_device_has_one_user_and_other_benches_run_beside() {
    let _lab = Lab::enter();
    let _adc = Adc::enter();
    bind_spi();
    let can = |interface: &str| {
        format!("can = {{ kind = \"can\", interface = \"{interface}\", bitrate = 500_000 }}\n")
    };
    let serial = |port: &str| format!("line = {{ kind = \"serial\", path = \"/dev/rig/{port}\" }}\n");
    let input = |converter: &str| {
        format!(
            "{converter} = {{ kind = \"analog\", unit = \"V\", input = 0, converter = \"{converter}\" }}\n"
        )
    };
    let spi =
        "spi = { kind = \"spi\", path = \"/dev/spidev0.0\", part = \"mcp3008\", reference = \"3.3 V\" }\n";
    let iio = format!("iio = {{ kind = \"iio\", name = \"{ADC}\" }}\n");
    let all = board_of(
        &(can("can0") + &serial("serial-a")),
        &(input("spi") + &input("iio")),
        &(spi.to_owned() + &iio),
    );
    let folder = Folder::new("devices", &all);
    let plan = |lasts: &str| {
        format!(
            "format = 1
title = \"Time goes by\"
program-text = \"PROGRAM MAIN VAR END_VAR END_PROGRAM\"
ends = \"start + {lasts}\"
expect = [{{ state = {{ stays = \"RUNNING\", from = \"start\", until = \"end\" }} }}]
"
        )
    };
    std::fs::write(folder.path().join("long.toml"), plan("100 s")).unwrap();
    std::fs::write(folder.path().join("short.toml"), plan("100 ms")).unwrap();
    let [locks, others] = ["locks", "others"].map(|name| folder.path().join(name));
    for locks in [&locks, &others] {
        std::fs::create_dir_all(locks).unwrap();
    }
    let long = ["test", "long.toml", "--board", "board.toml"];
    let mut first = folder.command(&long).env("RIG_LOCK_DIR", &locks).stdout(Stdio::null()).spawn().unwrap();
    let process = first.id().to_string();
    let holds = |device: &str| {
        let lock = std::fs::read(locks.join(format!("{device}.lock"))).unwrap_or_default();
        lock.starts_with(process.as_bytes())
    };
    wait_for("the first user", PATIENCE * 3, || holds("iio:device0"));
    let second = |board: &str, locks: &Path| {
        std::fs::write(folder.path().join("other.toml"), board).unwrap();
        let args = ["test", "short.toml", "--board", "other.toml"];
        let ran = folder.command(&args).env("RIG_LOCK_DIR", locks).output().unwrap();
        (ran.status.code().unwrap(), String::from_utf8_lossy(&ran.stderr).into_owned())
    };
    for (device, board) in [
        ("can0", board_of(&can("can0"), "", "")),
        ("ttyS", board_of(&serial("serial-a"), "", "")),
        ("spidev0.0", board_of("", &input("spi"), spi)),
        ("iio:device0", board_of("", &input("iio"), &iio)),
    ] {
        let (code, said) = second(&board, &locks);
        let words = [
            "error[R0280]".to_owned(),
            format!(" has had {device}"),
            format!("`rig test long.toml --board board.toml`, process {process}"),
        ];
        assert!(code == 2 && words.iter().all(|words| said.contains(words)), "{device}: {code} {said}");
    }
    // Whoever does not ask for locks meets the device itself.
    let (code, said) = second(&board_of("", &input("spi"), spi), &others);
    let words =
        format!("is held by `rig test long.toml --board board.toml` (process {process}, running for ");
    assert!(code == 2 && said.contains("error[B0128]") && said.contains(&words), "{code} {said}");
    // Other devices, and a bus that is there to join programs, are anybody's.
    let (code, said) = second(&board_of(&(can("rcan1") + &serial("serial-c")), "", ""), &locks);
    // How sure its verdict is lies with the machine.
    assert!([0, 3].contains(&code) && !said.contains("error["), "{code} {said}");
    assert!(first.try_wait().unwrap().is_none(), "the first one goes on");
    first.kill().unwrap();
    first.wait().unwrap();
}
