//! The command on boards of generators: what it says of them, who may have them, and what becomes of them when it dies.

use devices::{Lab, PATIENCE, PwmChip, Sink, rig, wait_for};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};

const BOARD: &str = r#"format = 1
title = "A train of pulses, a lamp and a fan"
[board]
kind = "real"
[generators]
stream = { kind = "spi", path = "/dev/spidev0.4", buffer = BUFFER }
chip = { kind = "pwm", label = "rig-pwm" }
[channels]
train = { kind = "digital", generator = "stream" }
Q0 = { kind = "digital", generator = "chip", output = 1 }
Q1 = { kind = "digital", generator = "chip", output = 2, safe = true }
[guard]
limit = "1 s"
hold = "1 h"
[realtime]
late = "10 s"
"#;

const PROGRAM: &str = "\
PROGRAM MAIN
VAR
    lamp AT %QX0.0 : BOOL;
    fan AT %QX0.1 : BOOL;
END_VAR
lamp := TRUE;
fan := FALSE;
END_PROGRAM
";

const FOLDER: &str = "/tmp/emitting";
const PROGRAM_FILE: &str = "/tmp/emitting/rig";

fn files(buffer: &str) {
    fs::create_dir_all(FOLDER).unwrap();
    fs::write(Path::new(FOLDER).join("board.toml"), BOARD.replace("BUFFER", buffer)).unwrap();
    fs::write(Path::new(FOLDER).join("main.st"), PROGRAM).unwrap();
    // Rig and guard keep all of the program in memory, and the disk that it lies on is slow page by page.
    if !Path::new(PROGRAM_FILE).exists() {
        fs::copy(rig(), PROGRAM_FILE).unwrap();
    }
}

fn command(args: &[&str]) -> Command {
    let mut command = Command::new(PROGRAM_FILE);
    command.args(args).current_dir(FOLDER).env("XDG_STATE_HOME", FOLDER).stdin(Stdio::null());
    command
}

/// Exit code, standard output, standard error.
fn ran(args: &[&str]) -> (Option<i32>, String, String) {
    let out = command(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (out.status.code(), text(&out.stdout), text(&out.stderr))
}

/// A controller that is kept running. It ends with the test, whatever becomes of that.
struct Played(Child);

impl Drop for Played {
    fn drop(&mut self) {
        // One that has ended needs nothing.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// One whose outputs are driven away from where they rest.
fn playing(chip: &PwmChip) -> Played {
    let path = Path::new(FOLDER).join("said");
    let said = fs::File::create(&path).unwrap();
    let process = command(&["run", "--board", "board.toml", "--program", "main.st"])
        .stdout(said.try_clone().unwrap())
        .stderr(said)
        .spawn();
    let mut played = Played(process.unwrap());
    wait_for("both outputs are driven", PATIENCE * 2, || {
        let ended = played.0.try_wait().unwrap();
        assert!(ended.is_none(), "{ended:?}: {}", fs::read_to_string(&path).unwrap());
        (1..=2).all(|pin| chip.pin(pin).duty > 0)
    });
    assert!((1..=2).all(|pin| chip.pin(pin).duty == chip.pin(pin).period), "all the time");
    played
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_rig_that_is_killed_leaves_its_outputs_at_rest_and_the_next_one_takes_them_over() {
    let (_lab, _sink, chip) = (Lab::enter(), Sink::enter(), PwmChip::enter());
    files("4096");
    drop(playing(&chip));
    wait_for("the guard makes them rest", PATIENCE, || (1..=2).all(|pin| chip.pin(pin).duty == 0));
    assert!(chip.pin(2).enabled && chip.pin(2).inversed, "it rests high");
    // Nobody gave them back.
    assert!(chip.is_held(1) && chip.is_held(2));
    let mut process = playing(&chip);
    let (code, _, said) = ran(&["board", "check", "board.toml"]);
    assert!(code == Some(2) && said.contains("B0232"), "{said}");
    let pid = process.0.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(process.0.wait().unwrap().code(), Some(0));
    assert!((1..=2).all(|pin| chip.pin(pin).duty == 0 && !chip.is_held(pin)));
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn what_a_board_uses_is_looked_at_without_being_touched() {
    let (_lab, sink, chip) = (Lab::enter(), Sink::enter(), PwmChip::enter());
    files("4096");
    let before = [chip.pin(1).changes, chip.pin(2).changes];
    let (code, out, said) = ran(&["board", "check", "board.toml"]);
    let expected = "\
train  emits pulses by /dev/spidev0.4 at 1000000 Hz, free
Q0     emits waves by output 1 of pwmchip0 (rig-pwm), free
Q1     emits waves by output 2 of pwmchip0 (rig-pwm), free
board.toml: all 3 channels can be had
";
    assert_eq!((code, out.as_str()), (Some(0), expected), "{said}");
    let (_, out, _) = ran(&["doctor", "board.toml"]);
    let has =
        |line: &str| assert!(out.lines().any(|found| found.trim() == line), "`{line}` is missing in\n{out}");
    has("good  PWM               pwmchip0");
    has("good  SPI transfers     of up to 4096 bytes, enough for the board's streams");
    assert_eq!([chip.pin(1).changes, chip.pin(2).changes], before);
    assert!(sink.transfers().is_empty() && !chip.is_held(1));
    files("8192");
    let (code, _, said) = ran(&["board", "check", "board.toml"]);
    assert!(code == Some(2) && said.contains("B0235") && said.contains("board.toml:6:1"), "{said}");
    let (code, out, _) = ran(&["doctor", "board.toml"]);
    assert!(code == Some(1) && out.contains("bufsiz=8192"), "{out}");
}
