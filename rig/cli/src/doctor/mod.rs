//! `rig doctor`: what this machine can do on real lines, and the command that fixes what it cannot.

mod board_devices;
mod check;
mod devices;
mod figures;
mod kernel;
mod privileges;
mod processors;
mod safety;
mod settings;

use crate::exit::ExitStatus;
use crate::output;
use crate::output::OutputFormat;
use check::{CheckState, DoctorCheck};
use clap::Args;
use host::HostMachine;
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
    format: OutputFormat,
    /// Look at the machine whose files stand below this folder.
    #[arg(long, value_name = "DIR", hide = true)]
    root: Option<PathBuf>,
}

/// Looks at everything and says what was found.
pub fn run(args: &DoctorArgs) -> ExitStatus {
    let machine = args.root.as_deref().map_or_else(HostMachine::here, HostMachine::below);
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
        match board_devices::devices(board) {
            Ok(mut used) => {
                board_devices::judge(&mut checks, &used, &machine);
                board_devices::measured(&mut checks, &mut used, &machine);
            }
            Err(exit) => return exit,
        }
    }
    let worst = checks.iter().map(|check| check.state).max().unwrap_or(CheckState::Open);
    match args.format {
        OutputFormat::Table => output::print(&table(&checks, worst)),
        OutputFormat::Json => output::print(&format!("{:#}\n", document(&machine, &checks, worst))),
    }
    match worst {
        CheckState::Good | CheckState::Open => ExitStatus::Passed,
        CheckState::Poor => ExitStatus::Inconclusive,
        CheckState::Bad => ExitStatus::Failed,
    }
}

/// The names of what is in a state.
fn names(checks: &[DoctorCheck], state: CheckState) -> Vec<&'static str> {
    checks.iter().filter(|check| check.state == state).map(|check| check.name).collect()
}

/// For a person: group by group, with what to type.
fn table(checks: &[DoctorCheck], worst: CheckState) -> String {
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
        if let Some(fix) = &check.fix {
            let _ = writeln!(text, "        $ {fix}");
        }
        if !check.then.is_empty() {
            let then = if check.fix.is_some() { "then " } else { "" };
            let _ = writeln!(text, "        {then}{}", check.then);
        }
    }
    let (bad, poor) = (names(checks, CheckState::Bad), names(checks, CheckState::Poor));
    let _ = match worst {
        CheckState::Bad => writeln!(text, "not fit for real lines: {}", bad.join(", ")),
        CheckState::Poor => writeln!(text, "fit for real lines, with drawbacks: {}", poor.join(", ")),
        CheckState::Good | CheckState::Open => writeln!(text, "fit for real lines"),
    };
    text
}

/// For a program.
fn document(machine: &HostMachine, checks: &[DoctorCheck], worst: CheckState) -> serde_json::Value {
    let verdict = match worst {
        CheckState::Bad => "unfit",
        CheckState::Poor => "drawbacks",
        CheckState::Good | CheckState::Open => "fit",
    };
    let identity: serde_json::Map<String, serde_json::Value> =
        machine.identity().into_iter().map(|(name, text)| (name, text.into())).collect();
    let checks: Vec<serde_json::Value> = checks
        .iter()
        .map(|check| {
            let state = if check.state == CheckState::Open { "open" } else { check.state.word() };
            json!({
                "group": check.group,
                "name": check.name,
                "state": state,
                "found": check.found,
                "means": check.means,
                "fix": check.fix,
                "then": check.then,
            })
        })
        .collect();
    json!({ "verdict": verdict, "machine": identity, "checks": checks })
}
