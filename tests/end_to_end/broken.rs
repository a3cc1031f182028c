//! Every annotated broken file of the repository, as a user meets it: `rig check` refuses it, with the code and the
//! place that its first lines expect, at once and without taking the host's memory.

use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::project_folder::{command, list, root, run};

const FOLDERS: [&str; 3] = ["plans/tests/broken", "drivers/tests/broken", "rig/program/tests/broken"];

/// How long one file may take at most. A check takes milliseconds; the rest is for a host that does much else.
const LONGEST: Duration = Duration::from_secs(10);

/// Peak of resident memory that no check may reach, in KiB.
const MOST_MEMORY: i64 = 64 << 10;

/// Broken boards without a key that tells a board from a plan: given as boards.
const TOLD_TO_BE_BOARDS: [&str; 4] = ["format.toml", "missing_key.toml", "newer_toml.toml", "syntax.toml"];

/// Findings that a check alone cannot show, for they are about terminals that no controller has.
const OF_INVENTED_TERMINALS: [(&str, &str); 1] = [("binding.toml", "B0305 13:10")];

/// Any wire of the ring may be the one that is named.
const ANYWHERE: [&str; 2] = ["ring.toml", "ring_one_way.toml"];

/// Paths of the broken files, relative to the repository.
fn broken_files() -> Vec<String> {
    let mut files = Vec::new();
    for folder in FOLDERS {
        let paths = list(&root().join(folder)).into_iter().map(|name| format!("{folder}/{name}"));
        // A folder among them holds what they name.
        files.extend(paths.filter(|path| root().join(path).is_file()));
    }
    files
}

fn check(path: &str) -> Command {
    let name = path.rsplit('/').next().unwrap();
    let board = path.starts_with("drivers/") && TOLD_TO_BE_BOARDS.contains(&name);
    let args: &[&str] = if board { &["check", "--board", path] } else { &["check", path] };
    command(&root(), args)
}

/// What the first lines of a file expect: `# expect P0101 2:1, P0103 4:7` or `(* expect S0102 4:5 *)`.
fn expected(text: &str) -> Vec<String> {
    let mut expected = Vec::new();
    for line in text.lines() {
        let line = line.strip_prefix("# ").or_else(|| line.strip_prefix("(* ")).unwrap_or_default();
        let Some(places) = line.strip_prefix("expect ") else { break };
        expected.extend(places.trim_end_matches(" *)").split(", ").map(str::to_owned));
    }
    expected.sort();
    expected
}

/// Codes and places that a check reported: `error[P0101]: ...` and the first ` --> path:2:1` after it.
fn reported(output: &str) -> Vec<String> {
    let mut reported = Vec::new();
    let mut code = None;
    for line in output.lines() {
        if let Some(rest) = line.strip_prefix("error[").or_else(|| line.strip_prefix("warning[")) {
            code = rest.split_once(']').map(|(code, _)| code);
        } else if let Some((_, place)) = line.split_once("--> ")
            && let Some(code) = code.take()
        {
            let mut parts = place.rsplitn(3, ':');
            let (column, line) = (parts.next().unwrap(), parts.next().unwrap());
            reported.push(format!("{code} {line}:{column}"));
        }
    }
    reported.sort();
    reported
}

#[test]
fn broken_files_are_refused_at_their_places() {
    let files = broken_files();
    assert!(files.len() >= 40, "{}", files.len());
    let mut wrong = String::new();
    for path in &files {
        let name = path.rsplit('/').next().unwrap();
        let text = std::fs::read_to_string(root().join(path)).unwrap();
        // The tests of the drivers play programs of plants, without files.
        if text.contains("kind = \"program\"") {
            continue;
        }
        let mut expected = expected(&text);
        let ran = run(check(path));
        let mut reported = reported(&ran.err);
        if let Some((_, invented)) = OF_INVENTED_TERMINALS.iter().find(|(file, _)| *file == name) {
            expected.retain(|one| one != invented);
            reported.retain(|one| expected.contains(one));
        }
        if ANYWHERE.contains(&name) {
            for place in expected.iter_mut().chain(&mut reported) {
                place.truncate("B0404".len());
            }
        }
        if ran.code != Some(2) || reported != expected || reported.is_empty() || !ran.out.is_empty() {
            wrong +=
                &format!("{path}: exit {:?}\n  expects {expected:?}\n  reported of {reported:?}\n", ran.code);
        }
        // Every finding has a message; most have a fix.
        assert!(!ran.err.contains("]: \n"), "{path}: {}", ran.err);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn broken_files_take_neither_time_nor_memory() {
    // In a process of its own: the kernel reports to a process the peak of all of its children, not of one. The figure
    // includes what the child takes over from its parent between fork and exec, so the check itself takes less.
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "broken::measure", "--ignored", "--nocapture", "--test-threads", "1"])
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let figures = text.lines().find(|line| line.contains("KiB")).unwrap_or_else(|| panic!("{text}"));
    println!("{figures}");
}

#[test]
#[ignore = "runs in a process of its own, which `broken_files_take_neither_time_nor_memory` starts"]
fn measure() {
    let mut longest = (Duration::ZERO, String::new());
    let files = broken_files();
    for path in &files {
        let began = Instant::now();
        assert_eq!(run(check(path)).code, Some(2), "{path}");
        longest = longest.max((began.elapsed(), path.clone()));
    }
    let usage = nix::sys::resource::getrusage(nix::sys::resource::UsageWho::RUSAGE_CHILDREN).unwrap();
    println!(
        "{} broken files, {} KiB at most, {} ms at most ({})",
        files.len(),
        usage.max_rss(),
        longest.0.as_millis(),
        longest.1
    );
    assert!(usage.max_rss() < MOST_MEMORY, "{} KiB", usage.max_rss());
    assert!(longest.0 < LONGEST, "{longest:?}");
}

#[test]
fn large_and_deep_files_are_refused_without_effort() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| -> PathBuf { folder.path().join(name) };
    let deep = 200_000;
    for (name, text, code) in [
        ("long.toml", format!("format = 1\ntitle = \"{}\"\n", "x".repeat(2 << 20)), "P0003"),
        ("deep.toml", format!("format = 1\nsteps = {}\n", "[".repeat(deep)), "P0003"),
        ("dots.toml", format!("format = 1\n{} = 1\n", ["a"; 100_000].join(".")), "P0003"),
        (
            "deep.st",
            format!("PROGRAM MAIN VAR x : INT; END_VAR x := {}1;\nEND_PROGRAM\n", "(".repeat(deep)),
            "S01",
        ),
        ("ifs.st", format!("PROGRAM MAIN {}\nEND_PROGRAM\n", "IF TRUE THEN ".repeat(deep / 4)), "S01"),
    ] {
        std::fs::write(path(name), text).unwrap();
        let began = Instant::now();
        let ran = run(command(folder.path(), &["check", name]));
        assert!(ran.code == Some(2) && ran.err.contains(code), "{name}: {:?} {:.2000}", ran.code, ran.err);
        assert!(began.elapsed() < LONGEST, "{name}: {:?}", began.elapsed());
        // A message that nobody can read is none.
        assert!(ran.err.len() < 20_000, "{name}: {} bytes", ran.err.len());
    }
}
