//! Floods of hostile clients, and damaged files, while lines are real: the scan goes on, every end comes, nothing stays
//! driven.

use crate::rig::{Rig, guards};
use devices::{Lab, MAIN, PATIENCE, wait_for};
use rustix::process::Signal;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

const SOCKET: &str = "/tmp/trouble/attacks/rig.sock";

const BOARD: &str = r#"
format = 1
[board]
kind = "real"
unresponsive-after = "5 s"
[control]
socket = "/tmp/trouble/attacks/rig.sock"
on-disconnect = "release"
[chips]
main = { label = "rig-gpio" }
[channels]
Q0 = { kind = "digital", line = 8 }
[guard]
limit = "5 s"
[realtime]
late = "5 s"
"#;

/// The lamp blinks as long as the scan goes on.
const PROGRAM: &str = "
PROGRAM MAIN
VAR
  cycle : UDINT;
  lamp AT %QX0.0 : BOOL;
END_VAR
cycle := cycle + 1;
lamp := cycle MOD 4 < 2;
END_PROGRAM
";

/// Clients at a time, above what the rig takes.
const CLIENTS: usize = 24;

/// The most connections of a client.
const MOST: u64 = 2_000;

const RUN: [&str; 6] = ["run", "--board", "board.toml", "--program", "main.st", "--booted"];

fn files() -> [(&'static str, String); 2] {
    [("board.toml", BOARD.to_owned()), ("main.st", PROGRAM.to_owned())]
}

/// What a client sends: no JSON, half a line, a line without end, requests that are wrong, forced outputs, and many answers
/// that it does not read.
fn hostile(turn: u64) -> Vec<u8> {
    match turn % 8 {
        0 => (0..4_096_u64).map(|n| (n.wrapping_mul(turn | 1) >> 3) as u8).collect(),
        1 => b"{\"do\":".to_vec(),
        2 => vec![b'x'; 2 << 20],
        3 => b"[".repeat(60_000),
        4 => b"{\"id\":1,\"do\":\"status\"}\n".repeat(2_000),
        5 => b"{\"id\":1,\"do\":\"force\",\"values\":[[\"%QX0.0\",true]]}\n{\"id\":2,\"do\":\"no\"}\n".to_vec(),
        6 => b"{\"id\":1,\"do\":\"subscribe\",\"topic\":\"log\"}\n{\"id\":2,\"do\":\"plans\",\"path\":\"/dev\"}\n".to_vec(),
        _ => b"\n\0\xff\xfe\n{}\n[]\nnull\n".to_vec(),
    }
}

/// Clients that send what is hostile, again and again, until this is dropped.
struct Flood {
    over: &'static AtomicBool,
    sent: &'static AtomicU64,
    clients: Vec<thread::JoinHandle<()>>,
}

impl Flood {
    fn begin() -> Flood {
        // One for each flood; it is the program's end that frees them.
        let over: &'static AtomicBool = Box::leak(Box::default());
        let sent: &'static AtomicU64 = Box::leak(Box::default());
        let client = |first: usize| {
            thread::spawn(move || {
                let turns = (first as u64..).take(MOST as usize);
                for turn in turns.take_while(|_| !over.load(Ordering::Relaxed)) {
                    attack(turn);
                    sent.fetch_add(1, Ordering::Relaxed);
                }
            })
        };
        Flood { over, sent, clients: (0..CLIENTS).map(client).collect() }
    }

    fn sent(&self) -> u64 {
        self.sent.load(Ordering::Relaxed)
    }
}

impl Drop for Flood {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        self.clients.drain(..).for_each(|client| drop(client.join()));
    }
}

/// One connection. That the rig cuts it off, or is gone, is no fault of the test.
fn attack(turn: u64) {
    let Ok(mut stream) = UnixStream::connect(SOCKET) else {
        thread::sleep(Duration::from_millis(1));
        return;
    };
    let limit = Some(Duration::from_millis(200));
    if stream.set_write_timeout(limit).and_then(|()| stream.set_read_timeout(limit)).is_ok() {
        let _ = stream.write_all(&hostile(turn));
        if turn.is_multiple_of(3) {
            let _ = stream.read(&mut [0; 512]);
        }
    }
}

/// The lamp changes so often: the scan goes on.
fn blinks(rig: &Rig, times: u32) {
    for change in 0..times {
        let before = MAIN.line(8).value();
        rig.until(&format!("change {change} of the lamp"), || MAIN.line(8).value() != before);
    }
}

fn under_attack() -> (Rig, Flood) {
    let rig = Rig::start("attacks", &files(), &RUN);
    blinks(&rig, 2);
    let flood = Flood::begin();
    rig.until("clients have attacked", || flood.sent() > 200);
    blinks(&rig, 40);
    (rig, flood)
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn clients_that_flood_hold_up_neither_the_scan_nor_its_end() {
    let _lab = Lab::enter();
    let (mut rig, flood) = under_attack();
    rig.signal(Signal::INT);
    // A machine that stands still now and then loses edges, and says so.
    let code = rig.exit_code();
    let lost_edges = code == Some(4) && rig.said().contains("error[R0342]");
    assert!(code == Some(0) || lost_edges, "{code:?}\n{}", rig.said());
    println!("\nfigure: connections of hostile clients: {}", flood.sent());
    assert!(!MAIN.line(8).value() && guards() == 0, "{}", rig.said());
    assert!(!rig.said().contains("panicked"), "{}", rig.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn a_rig_that_is_killed_under_a_flood_leaves_its_outputs_safe() {
    let _lab = Lab::enter();
    let (mut rig, _flood) = under_attack();
    rig.signal(Signal::KILL);
    assert_eq!(rig.exit_code(), None);
    wait_for("the guard says so", PATIENCE, || rig.said().contains("error[R0193]"));
    assert!(!MAIN.line(8).value(), "{}", rig.said());
}

#[test]
#[ignore = "in the lab: tests/lab/devices"]
fn damaged_files_leave_nothing_driven() {
    let _lab = Lab::enter();
    let mut refused = 0;
    for turn in 0..24_usize {
        let [(board, mut text), (main, mut program)] = files();
        // A piece of one of the files is missing, doubled or another character.
        let damaged = if turn % 3 == 0 { &mut program } else { &mut text };
        let place = 7 + turn * (damaged.len() - 30) / 24;
        match turn % 4 {
            0 => damaged.truncate(place),
            1 => damaged.replace_range(place..=place, "\u{1b}"),
            2 => damaged.replace_range(place..place + 9, ""),
            _ => {
                let doubled = damaged[place..place + 9].to_owned();
                damaged.insert_str(place, &doubled);
            }
        }
        let args = [&RUN[..], &["--for", "100 ms"]].concat();
        let mut rig = Rig::start("attacks", &[(board, text), (main, program)], &args);
        let code = rig.exit_code();
        assert!(matches!(code, Some(0 | 2)), "turn {turn}: {code:?}\n{}", rig.said());
        assert!(!rig.said().contains("panicked"), "turn {turn}: {}", rig.said());
        // A refusal names its code.
        assert!(code == Some(0) || rig.said().contains("error["), "turn {turn}: {}", rig.said());
        refused += u32::from(code == Some(2));
        assert!(!MAIN.line(8).value() && guards() == 0, "turn {turn}: {}", rig.said());
    }
    assert!(refused > 12, "{refused} were refused");
}
