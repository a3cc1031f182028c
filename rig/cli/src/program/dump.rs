//! `rig program dump`.

use super::compile;
use crate::exit::ExitStatus;
use crate::output;
use program::{ListedLine, ListedUnit};
use std::fmt::Write;
use std::path::PathBuf;

/// Prints the code of an application: for each unit its source lines with the operations that they became and the
/// modelled time of each.
pub fn dump(files: &[PathBuf]) -> ExitStatus {
    let (program, sources) = match compile(files) {
        Ok(compiled) => compiled,
        Err(exit) => return exit,
    };
    for (nth, unit) in program.listing(&sources).iter().enumerate() {
        let file = program.files().get(usize::from(unit.file)).map_or("?", String::as_str);
        if nth > 0 {
            output::print("\n");
        }
        output::print(&show(unit, file));
    }
    ExitStatus::Passed
}

fn show(unit: &ListedUnit, file: &str) -> String {
    let mut out = String::new();
    // Writing to a string does not fail.
    let _ = writeln!(out, "{} ({file}), frame of {} bytes", unit.name, unit.frame);
    for line in &unit.lines {
        show_line(&mut out, line);
    }
    out
}

fn show_line(out: &mut String, line: &ListedLine) {
    let cost: u64 = line.steps.iter().map(|step| u64::from(step.cost)).sum();
    let _ = writeln!(out, "{:>6} | {:<60} {cost:>8} ns", line.line, line.text);
    for step in &line.steps {
        let _ = writeln!(out, "       | {:>8}  {:<50} {:>8} ns", step.pc, step.text, step.cost);
    }
}
