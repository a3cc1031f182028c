//! Guard and rig as processes, with files in place of lines: whatever becomes of the rig, the levels in the files
//! become safe and stay so.
//!
//! This program plays all parts: without arguments of its own it is the test, as `rig` it does what it is asked, and
//! as `guard` it is the guard.

mod files;
mod rig;
mod tests;

use std::process::ExitCode;

#[global_allocator]
static COUNTING: counting::Counting = counting::Counting;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.first().map(String::as_str) {
        Some("guard") => scanrig_guard::serve_with(&files::open),
        Some("rig") => rig::run(&words[1..]),
        _ => tests::run(&words),
    }
}
