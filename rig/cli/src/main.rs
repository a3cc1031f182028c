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
mod line_queue;
mod module_page;
mod modules;
mod new;
mod operator;
mod output;
mod output_queues;
mod paragraph;
mod plan_files;
mod plans;
mod program;
mod report;
mod requirements;
mod rig_address;
mod run;
mod run_exit;
mod saved_runs;
mod schema;
mod selection;
mod step;
mod test;
mod typed_lines;

use args::{Cli, CliCommand};
use clap::{CommandFactory, Parser};
use exit::ExitStatus;
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
            let code = if error.use_stderr() { ExitStatus::UserFiles } else { ExitStatus::Passed };
            let _ = error.print();
            return code.into();
        }
    };
    output::choose_color(cli.color);
    // The dashboard has the screen for itself.
    if !matches!(cli.command, CliCommand::Dash(_)) {
        event_log::start();
    }
    let exit = match cli.command {
        CliCommand::Test(args) => test::run(&args),
        CliCommand::Check(args) => check::run(&args),
        CliCommand::Judge(args) => judge::run(&args),
        CliCommand::Requirements(args) => requirements::run(&args),
        CliCommand::Report(args) => report::run(&args),
        CliCommand::Diff(args) => diff::run(&args),
        CliCommand::History(command) => history::run(&command),
        CliCommand::Board(command) => board::run(&command),
        CliCommand::Program(command) => program::run(&command),
        CliCommand::Doctor(args) => doctor::run(&args),
        CliCommand::Bench(command) => bench::run(&command),
        CliCommand::New(args) => new::run(&args),
        CliCommand::Run(args) => run::run(&args),
        CliCommand::Ctl(args) => ctl::run(&args),
        CliCommand::Dash(args) => dash::run(&args),
        CliCommand::Step(args) => step::run(&args),
        CliCommand::Explain(args) => explain::run(&args),
        CliCommand::Modules(args) => modules::run(&args),
        CliCommand::Schema(args) => schema::run(&args),
        CliCommand::Plans(command) => plans::run(&command),
        CliCommand::Completions(args) => completions::run(&args, Cli::command()),
        CliCommand::Man(args) => completions::man(&args, Cli::command()),
    };
    output::finish(exit).into()
}
