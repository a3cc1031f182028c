//! The committed corpora of tests/fuzz, through the functions that are fuzzed, with the stable compiler.

#[path = "../fuzz/targets.rs"]
mod targets;

use std::path::Path;

use crate::project_folder::{list, root};

/// Runs every file of a folder, with those of the folders in it, through a target. Returns how many there were.
fn each(folder: &Path, target: fn(&[u8])) -> usize {
    let mut count = 0;
    for name in list(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            count += each(&path, target);
        } else {
            let bytes = std::fs::read(&path).unwrap();
            let survived = std::panic::catch_unwind(|| target(&bytes));
            assert!(survived.is_ok(), "{} does not survive", path.display());
            count += 1;
        }
    }
    count
}

fn corpus(name: &str, target: fn(&[u8])) {
    let count = each(&root().join("tests/fuzz/corpus").join(name), target);
    assert!(count >= 5, "{name} has only {count} files");
}

#[test]
fn plans() {
    corpus("plan", targets::plan);
    each(&root().join("plans/library"), targets::plan);
    each(&root().join("plans/tests/broken"), targets::plan);
}

#[test]
fn instruments() {
    corpus("instrument", targets::instrument);
}

#[test]
fn boards() {
    corpus("board", targets::board);
    each(&root().join("drivers/tests/broken"), targets::board);
    each(&root().join("plans/library/bench"), targets::board);
}

#[test]
fn programs() {
    corpus("program", targets::program);
    each(&root().join("rig/program/tests/broken"), targets::program);
    each(&root().join("plans/library"), targets::program);
}

#[test]
fn traces() {
    corpus("trace", targets::trace);
}

#[test]
fn captures() {
    corpus("capture", targets::capture);
    each(&root().join("rig/capture/tests/files"), targets::capture);
}

#[test]
fn records() {
    corpus("record", targets::record);
}

#[test]
fn frames() {
    corpus("frames", targets::frames);
}

#[test]
fn words() {
    corpus("words", targets::words);
}

#[test]
fn serial_lines() {
    corpus("serial", targets::serial);
}

#[test]
fn industrial_io() {
    corpus("iio", targets::iio);
}

#[test]
fn can() {
    corpus("can", targets::can);
}

#[test]
fn converters_on_a_bus() {
    corpus("spi", targets::spi);
}

#[test]
fn counters() {
    corpus("counter", targets::counter);
}

#[test]
fn lines_of_counters() {
    corpus("lines", targets::lines);
}

#[test]
fn lines_of_clients() {
    corpus("control", targets::control);
}
