//! The part of the rig: does what its words say, one after the other, and says what became of each.

use crate::files::{MASK, held, levels, write};
use drivers::GuardSettings;
use scanrig_guard::{Guard, GuardError, GuardHandle, HeartbeatState};
use signal::Span;
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, ExitCode};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// `rig FOLDER LIMIT_MS HOLD_MS WORD...`
pub fn run(words: &[String]) -> ExitCode {
    let folder = Path::new(&words[0]);
    let millis = |word: &String| Span::from_millis(word.parse().unwrap());
    let settings = GuardSettings { limit: millis(&words[1]), hold: millis(&words[2]), watchdog: None };
    let mut program = Command::new("/proc/self/exe");
    program.arg("guard");
    let handle = Guard::spawn_as(program, &settings).unwrap();
    let mut devices: Vec<String> = Vec::new();
    let mut handle = Some(handle);
    for word in &words[3..] {
        let guard = handle.as_ref();
        let said = match word.as_str() {
            "hold" => outcome(guard.unwrap().hold(devices.iter().map(|name| held(folder, name)).collect())),
            "arm" => outcome(guard.unwrap().arm()),
            "drive" => {
                drive(folder, &devices);
                "drove".into()
            }
            // Writes for ever from a thread of its own, as fast as it can.
            "race" => {
                let (folder, devices) = (folder.to_owned(), devices.clone());
                std::thread::spawn(move || {
                    loop {
                        drive(&folder, &devices);
                    }
                });
                "races".into()
            }
            // Lives until the test says otherwise.
            "live" => live(guard.unwrap()),
            // Gives no sign of life until the test says otherwise.
            "hang" => {
                say("hangs");
                let _ = std::io::stdin().read(&mut [0]);
                "hung".into()
            }
            "safe" => {
                for device in &devices {
                    write(&file(folder, device), crate::files::SAFE).unwrap();
                }
                "safe".into()
            }
            "stays" => stays(folder, &devices),
            "disarm" => outcome(guard.unwrap().disarm()),
            "trip" => outcome(guard.unwrap().trip()),
            "close" => outcome(handle.take().unwrap().close()),
            "panic" => panic!("as asked"),
            "exit" => std::process::exit(7),
            device => {
                devices.push(device.into());
                continue;
            }
        };
        say(&said);
    }
    ExitCode::SUCCESS
}

fn file(folder: &Path, device: &str) -> File {
    OpenOptions::new().write(true).open(folder.join(device)).unwrap()
}

/// All lines to the levels that are not safe.
fn drive(folder: &Path, devices: &[String]) {
    for device in devices {
        write(&file(folder, device), !crate::files::SAFE & MASK).unwrap();
    }
}

/// Whether everything stays as it was driven for a while.
fn stays(folder: &Path, devices: &[String]) -> String {
    let until = Instant::now() + Duration::from_millis(8);
    while Instant::now() < until {
        if devices.iter().any(|device| levels(folder, device) == crate::files::SAFE) {
            return "undone".into();
        }
    }
    "stayed".into()
}

fn live(guard: &GuardHandle) -> String {
    let over = Arc::new(AtomicBool::new(false));
    let reported = over.clone();
    std::thread::spawn(move || {
        let _ = std::io::stdin().read(&mut [0]);
        reported.store(true, Ordering::Release);
    });
    say("lives");
    let every = Duration::from_nanos(guard.beat_every().as_nanos().unsigned_abs());
    while !over.load(Ordering::Acquire) {
        match guard.beat() {
            HeartbeatState::Kept => std::thread::sleep(every),
            HeartbeatState::Unguarded => return "unguarded".into(),
            HeartbeatState::Latched(reason) => return format!("{reason:?}"),
        }
    }
    "lived".into()
}

fn outcome(result: Result<(), GuardError>) -> String {
    result.map_or_else(|error| format!("{} {error}", error.code()), |()| "done".into())
}

fn say(word: &str) {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{word}").unwrap();
    out.flush().unwrap();
}
