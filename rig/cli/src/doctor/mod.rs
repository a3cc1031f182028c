//! `rig doctor`: what this machine can do on real lines, and the line to type where it cannot.

mod check;
mod devices;
mod figures;
mod kernel;
mod privileges;
mod processors;
mod safety;
mod settings;
mod used;

use crate::exit::Exit;
use crate::output;
use crate::output::Format;
use check::{Check, State};
use clap::Args;
use host::Machine;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

/// The exit codes, as `--help` lists them.
const EXIT_CODES: &str = "Exit codes: 0 fit for real lines, 3 fit with drawbacks, 1 not fit, 2 something is wrong with \
your arguments.";

/// `rig doctor`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct DoctorArgs {
    /// A board file: devices that it does not use do not count.
    #[arg(value_name = "BOARD")]
    board: Option<PathBuf>,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Look at the machine whose files stand below this folder.
    #[arg(long, value_name = "DIR", hide = true)]
    root: Option<PathBuf>,
}

/// Looks at everything and says what was found.
pub fn run(args: &DoctorArgs) -> Exit {
    let machine = args.root.as_deref().map_or_else(Machine::here, Machine::below);
    let groups = [
        kernel::checks,
        processors::checks,
        privileges::checks,
        safety::checks,
        devices::checks,
        settings::checks,
        figures::checks,
    ];
    let mut checks = groups.iter().flat_map(|group| group(&machine)).collect::<Vec<_>>();
    if let Some(board) = &args.board {
        match used::devices(board) {
            Ok(mut used) => {
                used::judge(&mut checks, &used, &machine);
                used::measured(&mut checks, &mut used, &machine);
            }
            Err(exit) => return exit,
        }
    }
    let worst = checks.iter().map(|check| check.state).max().unwrap_or(State::Open);
    match args.format {
        Format::Table => output::print(&table(&checks, worst)),
        Format::Json => output::print(&format!("{:#}\n", document(&machine, &checks, worst))),
    }
    match worst {
        State::Good | State::Open => Exit::Passed,
        State::Poor => Exit::Inconclusive,
        State::Bad => Exit::Failed,
    }
}

/// The names of what is in a state.
fn names(checks: &[Check], state: State) -> Vec<&'static str> {
    checks.iter().filter(|check| check.state == state).map(|check| check.name).collect()
}

/// For a person: group by group, with what to type.
fn table(checks: &[Check], worst: State) -> String {
    let mut text = String::new();
    let mut group = "";
    for check in checks {
        if check.group != group {
            group = check.group;
            let _ = writeln!(text, "{group}");
        }
        let _ = writeln!(text, "  {:<4}  {:<16}  {}", check.state.word(), check.name, check.found);
        if !check.means.is_empty() {
            let _ = writeln!(text, "        {}", check.means);
        }
        if let Some(mend) = &check.mend {
            let _ = writeln!(text, "        $ {mend}");
        }
        if !check.then.is_empty() {
            let then = if check.mend.is_some() { "then " } else { "" };
            let _ = writeln!(text, "        {then}{}", check.then);
        }
    }
    let (bad, poor) = (names(checks, State::Bad), names(checks, State::Poor));
    let _ = match worst {
        State::Bad => writeln!(text, "not fit for real lines: {}", bad.join(", ")),
        State::Poor => writeln!(text, "fit for real lines, with drawbacks: {}", poor.join(", ")),
        State::Good | State::Open => writeln!(text, "fit for real lines"),
    };
    text
}

/// For a program.
fn document(machine: &Machine, checks: &[Check], worst: State) -> serde_json::Value {
    let verdict = match worst {
        State::Bad => "unfit",
        State::Poor => "drawbacks",
        State::Good | State::Open => "fit",
    };
    let identity: serde_json::Map<String, serde_json::Value> =
        machine.identity().into_iter().map(|(name, text)| (name, text.into())).collect();
    let checks: Vec<serde_json::Value> = checks
        .iter()
        .map(|check| {
            let state = if check.state == State::Open { "open" } else { check.state.word() };
            json!({
                "group": check.group,
                "name": check.name,
                "state": state,
                "found": check.found,
                "means": check.means,
                "mend": check.mend,
                "then": check.then,
            })
        })
        .collect();
    json!({ "verdict": verdict, "machine": identity, "checks": checks })
}
