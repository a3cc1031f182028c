//! The `rig` command: a thin layer that reads arguments and files, calls the crates, prints and sets the exit code.

mod args;
mod check;
mod exit;
mod find;
mod judge;
mod kind;
mod library;
mod output;
mod parameters;
mod program;
mod provenance;
mod requirements;
mod select;
mod store;
mod test;

use args::{Cli, Command, ProgramCommand};
use clap::Parser;
use exit::Exit;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no fault; everything else is the user's argument.
            let code = if error.use_stderr() { Exit::UserFiles } else { Exit::Passed };
            let _ = error.print();
            return code.into();
        }
    };
    let exit = match cli.command {
        Command::Test(args) => test::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Judge(args) => judge::run(&args),
        Command::Requirements(args) => requirements::run(&args),
        Command::Program(ProgramCommand::Check { files }) => program::check(&files),
        Command::Program(ProgramCommand::Run(args)) => program::run(&args),
        Command::Program(ProgramCommand::Dump { files }) => program::dump(&files),
        Command::Program(ProgramCommand::Bench(args)) => program::bench(&args),
    };
    exit.into()
}
