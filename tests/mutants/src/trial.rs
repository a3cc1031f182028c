//! Runs the plans against mutants, two at a time.

use crate::plans::{self, Plan};
use crate::{AT_ONCE, Outcome};
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{scope, sleep};
use std::time::{Duration, Instant};

/// A mutant that takes this many times as long as its plans without it hangs.
const PATIENCE: u32 = 4;

/// Draws mutants, the same for the same seed (Fisher and Yates, splitmix64).
pub fn draw<'a>(all: &[&'a str], count: usize, mut seed: u64) -> Vec<&'a str> {
    let mut random = move || {
        seed = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (seed ^ seed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    };
    let mut all = all.to_vec();
    for n in 0..count.min(all.len()) {
        let left = (all.len() - n) as u64;
        all.swap(n, n + (random() % left) as usize);
    }
    all.truncate(count);
    all
}

/// Tries each mutant, prints those that no plan notices, and the totals.
pub fn run(mutants: &[&str], place: &Path, folder: &Path) -> Outcome<()> {
    let begin = Instant::now();
    let rig = place.join("build/release/rig");
    let plans = plans::find(&rig, place, folder)?;
    println!("{} plans pass without a mutation; {:.0} s", plans.len(), begin.elapsed().as_secs_f64());
    let (next, killers, survivors) = (AtomicUsize::new(0), Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                while let Some(line) = mutants.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let number = line.split('\t').next().unwrap_or_default();
                    match trial(number, &rig, place, &plans) {
                        Ok(Fate::Killed(reason)) => {
                            killers.lock().expect("no panic").push(format!("{line}\t{reason}"));
                        }
                        Ok(Fate::Survives { plans }) => {
                            eprintln!("survives {plans} plans: {line}");
                            survivors.lock().expect("no panic").push(format!("{line}\t{plans} plans"));
                        }
                        Err(error) => eprintln!("{number}: {error}"),
                    }
                }
            });
        }
    });
    let mut killers = killers.into_inner().expect("no panic");
    let mut survivors = survivors.into_inner().expect("no panic");
    killers.sort();
    survivors.sort();
    fs::write(place.join("killed.tsv"), killers.join("\n"))?;
    println!("survivors: number, place, operator, before, after, plans that come to it");
    for line in &survivors {
        println!("{line}");
    }
    let of = mutants.len();
    let percent = 100.0 * killers.len() as f64 / of as f64;
    println!("killed: {} of {of}, {percent:.1} %; {:.0} s", killers.len(), begin.elapsed().as_secs_f64());
    if killers.len() + survivors.len() < of {
        return Err("some mutants could not be run".into());
    }
    Ok(())
}

enum Fate {
    Killed(String),
    Survives { plans: usize },
}

/// Runs the plans that come to the mutant's place, the cheap ones first, each until a case does not pass.
fn trial(number: &str, rig: &Path, place: &Path, plans: &[Plan]) -> Outcome<Fate> {
    let mutant: usize = number.parse()?;
    let plans: Vec<&Plan> = plans.iter().filter(|plan| plan.seen.contains(&mutant)).collect();
    let mut left = &plans[..];
    // Few at first: most mutants are noticed at once.
    let mut count = 10;
    while !left.is_empty() {
        let (some, others) = left.split_at(count.min(left.len()));
        if let Some(reason) = batch(number, rig, place, some)? {
            return Ok(Fate::Killed(reason));
        }
        (left, count) = (others, count * 3);
    }
    Ok(Fate::Survives { plans: plans.len() })
}

/// What killed the mutant; none where every plan passes.
fn batch(number: &str, rig: &Path, place: &Path, plans: &[&Plan]) -> Outcome<Option<String>> {
    let cost: Duration = plans.iter().map(|plan| plan.cost).sum();
    let limit = (cost * PATIENCE).max(Duration::from_secs(15));
    let out = place.join(format!("out-{number}"));
    let begin = Instant::now();
    // Memory is bounded, too: a mutant may collect events without end.
    let mut child = Command::new("sh")
        .args(["-c", "ulimit -v 4000000; exec \"$0\" test --fail-fast --jobs 1 \"$@\""])
        .arg(rig)
        .args(plans.iter().map(|plan| &plan.path))
        .env("RIG_MUTANT", number)
        .stdin(Stdio::null())
        .stdout(File::create(&out)?)
        .stderr(Stdio::null())
        .spawn()?;
    let status = loop {
        match child.try_wait()? {
            Some(status) => break Some(status),
            None if begin.elapsed() > limit => {
                child.kill()?;
                child.wait()?;
                break None;
            }
            None => sleep(Duration::from_millis(10)),
        }
    };
    let text = fs::read(&out)?;
    fs::remove_file(&out)?;
    let text = String::from_utf8_lossy(&text);
    Ok(match status {
        None => Some("no end".into()),
        Some(status) if status.success() => None,
        Some(status) => {
            let not_passed = text.lines().find(|line| !line.trim_start().starts_with("PASS"));
            Some(format!("{status}: {}", not_passed.unwrap_or("nothing printed").trim()))
        }
    })
}
