//! `rig board`: what lines this machine has, whether those of a board file can be had, and what they do.

mod activity;
mod check;
mod exercise;
mod real_board_file;
mod scan;
mod scanned_devices;
mod toml_text;
mod traffic;
mod watch;

use crate::exit::ExitStatus;
use clap::Subcommand;

/// `rig board`.
#[derive(Debug, Subcommand)]
pub enum BoardCommand {
    /// Write a first board file from the devices of this machine. Nothing is claimed and nothing moves.
    Scan(scan::BoardScanArgs),
    /// Check that every line, converter, counter and bus of a board file is there and free. Nothing is claimed and nothing moves.
    Check(check::BoardCheckArgs),
    /// Show the inputs and buses of a board as they change, with counts and times. Outputs are left alone.
    Watch(watch::BoardWatchArgs),
    /// Drive one output at a time, with consent for each, and report what comes back.
    Exercise(exercise::ExerciseArgs),
}

/// Carries out the command.
pub fn run(command: &BoardCommand) -> ExitStatus {
    match command {
        BoardCommand::Scan(args) => scan::run(args),
        BoardCommand::Check(args) => check::run(args),
        BoardCommand::Watch(args) => watch::run(args),
        BoardCommand::Exercise(args) => exercise::run(args),
    }
}
