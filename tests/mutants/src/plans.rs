//! The plans, what each of them costs, and which mutations it comes across.

use crate::Outcome;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::scope;
use std::time::{Duration, Instant};

/// A plan that passes without a mutation.
#[derive(Debug)]
pub struct Plan {
    pub path: PathBuf,
    pub cost: Duration,
    /// The mutations whose place the controller came to.
    pub seen: BTreeSet<usize>,
}

/// All plans in a folder, those that cost least first.
///
/// A mutation changes nothing in a plan that never comes to its place: it need not be run.
pub fn find(rig: &Path, place: &Path, folder: &Path) -> Outcome<Vec<Plan>> {
    let (mut folders, mut files) = (vec![folder.to_path_buf()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            let is_plan = || fs::read_to_string(&path).is_ok_and(|text| is_plan(&text));
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "toml") && is_plan() {
                files.push(path);
            }
        }
    }
    files.sort();
    let (next, plans, failed) = (AtomicUsize::new(0), Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    scope(|scope| {
        for _ in 0..crate::AT_ONCE {
            scope.spawn(|| {
                loop {
                    let n = next.fetch_add(1, Ordering::Relaxed);
                    let Some(path) = files.get(n) else { break };
                    match survey(rig, &place.join(format!("seen-{n}")), path) {
                        Ok(plan) => plans.lock().expect("no panic").push(plan),
                        Err(error) => {
                            failed.lock().expect("no panic").push(format!("{}: {error}", path.display()))
                        }
                    }
                }
            });
        }
    });
    let failed = failed.into_inner().expect("no panic");
    if !failed.is_empty() {
        return Err(failed.join("\n").into());
    }
    let mut plans = plans.into_inner().expect("no panic");
    plans.sort_by_key(|plan| plan.cost);
    Ok(plans)
}

/// Board files and parts that plans share lie among the plans: only plans claim or measure something under a title.
fn is_plan(text: &str) -> bool {
    let has = |keys: &[&str]| {
        let mut names = text.lines().map(|line| line.trim_start_matches('[').trim_start());
        names.any(|line| keys.iter().any(|key| line.starts_with(key)))
    };
    has(&["title"]) && has(&["expect", "measure", "refused", "warned"])
}

fn survey(rig: &Path, seen: &Path, path: &Path) -> Outcome<Plan> {
    let _ = fs::remove_file(seen);
    let begin = Instant::now();
    let status = Command::new(rig)
        .args(["test", "--jobs", "1"])
        .arg(path)
        .env("RIG_MUTANT", "seen")
        .env("RIG_MUTANT_SEEN", seen)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()?;
    let cost = begin.elapsed();
    if !status.success() {
        return Err(format!("does not pass without a mutation: {status}").into());
    }
    // A plan that is refused at check comes to few places or none.
    let text = fs::read_to_string(seen).unwrap_or_default();
    let _ = fs::remove_file(seen);
    let seen = text.lines().map(str::parse).collect::<Result<_, _>>()?;
    Ok(Plan { path: path.to_path_buf(), cost, seen })
}
