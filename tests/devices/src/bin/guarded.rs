//! A rig in miniature for the tests of the guard: claims lines of the lab's two chips, starts `rig guard` for itself,
//! and does what its words say, one after the other, saying what became of each.
//!
//!     guarded v1|v2 LIMIT_MS HOLD_MS WATCHDOG,SECONDS,BITE|- WORD...

use devices::{AUX, Chip, MAIN, program};
use drivers::{Bite, GuardSettings, LineApi, OutputClaim, WatchdogSettings};
use gpiocdev_uapi::{v1, v2};
use guard::{Guard, GuardError, GuardHandle, HeartbeatState};
use signal::Span;
use std::fs::File;
use std::io::{Read, Write};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Lines of the main chip, and their safe levels as bits.
const LINES: [u32; 4] = [8, 9, 10, 11];
const SAFE: u64 = 0b0101;
/// A line of the other chip, safe when low.
const OTHER: [u32; 1] = [0];

/// Claimed output lines.
struct Claim {
    chip: Chip,
    lines: File,
    api: LineApi,
    count: u32,
    safe: u64,
}

impl Claim {
    fn take(api: &str, chip: Chip, offsets: &[u32], safe: u64) -> Claim {
        let device = File::options().read(true).write(true).open(chip.path()).unwrap();
        let count = offsets.len() as u32;
        let (lines, api) = if api == "v1" {
            let request = v1::HandleRequest {
                offsets: v2::Offsets::from_slice(offsets),
                flags: v1::HandleRequestFlags::OUTPUT,
                values: v1_values(safe),
                consumer: v2::Name::from_bytes(b"guarded"),
                num_lines: count,
                ..v1::HandleRequest::default()
            };
            (v1::get_line_handle(&device, request).unwrap(), LineApi::V1 { lines: count as u8 })
        } else {
            let request = v2::LineRequest {
                offsets: v2::Offsets::from_slice(offsets),
                consumer: v2::Name::from_bytes(b"guarded"),
                config: v2::LineConfig { flags: v2::LineFlags::OUTPUT, ..v2::LineConfig::default() },
                num_lines: count,
                ..v2::LineRequest::default()
            };
            (v2::get_line(&device, request).unwrap(), LineApi::V2)
        };
        let claim = Claim { chip, lines, api, count, safe };
        claim.set(safe);
        claim
    }

    fn mask(&self) -> u64 {
        (1 << self.count) - 1
    }

    fn set(&self, levels: u64) {
        match self.api {
            LineApi::V1 { .. } => v1::set_line_values(&self.lines, &v1_values(levels)),
            LineApi::V2 => {
                let values = v2::LineValues { bits: levels, mask: self.mask() };
                v2::set_line_values(&self.lines, &values)
            }
            LineApi::Pwm => unreachable!("claims are of GPIO lines"),
        }
        .unwrap();
    }

    /// As a scan does it: one call, whatever the levels are.
    fn get(&self) {
        match self.api {
            LineApi::V1 { .. } => v1::get_line_values(&self.lines, &mut v1_values(0)),
            LineApi::V2 => {
                v2::get_line_values(&self.lines, &mut v2::LineValues { bits: 0, mask: self.mask() })
            }
            LineApi::Pwm => unreachable!("claims are of GPIO lines"),
        }
        .unwrap();
    }

    fn drive(&self) {
        self.set(!self.safe & self.mask());
    }

    fn held(&self) -> OutputClaim {
        OutputClaim {
            device: self.chip.label().into(),
            claim: self.lines.try_clone().unwrap().into(),
            api: self.api,
            mask: self.mask(),
            safe: self.safe,
        }
    }
}

fn v1_values(levels: u64) -> v1::LineValues {
    let mut values = v1::LineValues::default();
    for (line, value) in values.0.iter_mut().enumerate() {
        *value = (levels >> line & 1) as u8;
    }
    values
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [api, limit, hold, dog, words @ ..] = &words[..] else { panic!("too few words") };
    let millis = |word: &String| Span::from_millis(word.parse().unwrap());
    let watchdog = dog.split_once(',').map(|(path, rest)| {
        let (after, bite) = rest.split_once(',').unwrap();
        let bite = if bite == "rig-lost" { Bite::RigLost } else { Bite::GuardLost };
        WatchdogSettings {
            path: path.into(),
            after: Span::from_secs(after.parse().unwrap()),
            bite,
            place: 0..0,
        }
    });
    let settings = GuardSettings { limit: millis(limit), hold: millis(hold), watchdog };
    let mut rig = Command::new(program("rig"));
    rig.arg("guard");
    let guard = match Guard::spawn_as(rig, &settings) {
        Ok(guard) => guard,
        Err(error) => return say(&outcome(Err(error))),
    };
    let claims = Arc::new([Claim::take(api, MAIN, &LINES, SAFE), Claim::take(api, AUX, &OTHER, 0)]);
    let mut guard = Some(guard);
    for word in words {
        let handle = guard.as_ref();
        let said = match word.as_str() {
            "hold" => outcome(handle.unwrap().hold(claims.iter().map(Claim::held).collect())),
            "arm" => outcome(handle.unwrap().arm()),
            "drive" => {
                claims.iter().for_each(Claim::drive);
                "drove".into()
            }
            // Writes for ever from a thread of its own, as fast as it can.
            "race" => {
                let claims = claims.clone();
                std::thread::spawn(move || {
                    loop {
                        claims.iter().for_each(Claim::drive);
                    }
                });
                "races".into()
            }
            // Gives signs of life until the test ends its input.
            "live" => live(handle.unwrap()),
            // The scan's own call on the device, which the test has made hang.
            "get" => {
                say("calls");
                claims[0].get();
                "returned".into()
            }
            "set" => {
                say("calls");
                claims[0].drive();
                "returned".into()
            }
            // Takes memory until there is none left, and lives as long as it does.
            "exhaust" => {
                say("exhausts");
                let mut taken = Vec::new();
                loop {
                    handle.unwrap().beat();
                    taken.push(vec![1u8; 256 * 1024]);
                }
            }
            "safe" => {
                claims.iter().for_each(|claim| claim.set(claim.safe));
                "safe".into()
            }
            "disarm" => outcome(handle.unwrap().disarm()),
            "trip" => outcome(handle.unwrap().trip()),
            "close" => outcome(guard.take().unwrap().close()),
            "panic" => panic!("as asked"),
            "exit" => std::process::exit(7),
            word => panic!("{word}?"),
        };
        say(&said);
    }
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
