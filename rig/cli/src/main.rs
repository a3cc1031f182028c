//! The `rig` command: a thin layer that reads arguments and files, calls the crates, prints and sets the exit code.

mod args;
mod bench;
mod bench_lock;
mod board;
mod check;
mod code_pages;
mod completions;
mod ctl;
mod dash;
mod diff;
mod doctor;
mod duration;
mod event_log;
mod exit;
mod explain;
mod files;
mod history;
mod judge;
mod new;
mod operator;
mod output;
mod plan_files;
mod plans;
mod program;
mod report;
mod requirements;
mod rig_address;
mod run;
mod saved_runs;
mod schema;
mod selection;
mod step;
mod test;

use args::{Cli, Command};
use clap::{CommandFactory, Parser};
use exit::Exit;
use std::process::ExitCode;

fn main() -> ExitCode {
    // The guard's process is this program, started by the rig itself: no command of a user's, and nothing is done
    // before it.
    if std::env::args_os().nth(1).is_some_and(|word| word == "guard") {
        return guard::serve();
    }
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no fault; everything else is the user's argument.
            let code = if error.use_stderr() { Exit::UserFiles } else { Exit::Passed };
            let _ = error.print();
            return code.into();
        }
    };
    output::choose_color(cli.color);
    // The dashboard has the screen for itself.
    if !matches!(cli.command, Command::Dash(_)) {
        event_log::start();
    }
    let exit = match cli.command {
        Command::Test(args) => test::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Judge(args) => judge::run(&args),
        Command::Requirements(args) => requirements::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Diff(args) => diff::run(&args),
        Command::History(command) => history::run(&command),
        Command::Board(command) => board::run(&command),
        Command::Program(command) => program::run(&command),
        Command::Doctor(args) => doctor::run(&args),
        Command::Bench(command) => bench::run(&command),
        Command::New(args) => new::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Ctl(args) => ctl::run(&args),
        Command::Dash(args) => dash::run(&args),
        Command::Step(args) => step::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Plans(command) => plans::run(&command),
        Command::Completions(args) => completions::run(&args, Cli::command()),
        Command::Man(args) => completions::man(&args, Cli::command()),
    };
    exit.into()
}
