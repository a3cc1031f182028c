//! The command line of `rig`: every command with the arguments that its module reads.

use crate::exit::EXIT_CODES;
use crate::output::ColorChoice;
use clap::{Parser, Subcommand};

/// A hardware-in-the-loop test rig for logic controllers: runs test plans against a modelled or a real
/// controller and says with figures whether its behaviour is right.
#[derive(Debug, Parser)]
#[command(name = "rig", version, after_help = EXIT_CODES, disable_help_subcommand = true)]
pub struct Cli {
    /// Whether to dress text in colour. `auto` follows NO_COLOR, CLICOLOR and CLICOLOR_FORCE.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t)]
    pub color: ColorChoice,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run test plans; without any, the plans that ship with the rig, on the simulated board.
    Test(crate::test::TestArgs),
    /// Read plans, boards and programs and say what is wrong with them; nothing moves.
    Check(crate::check::CheckArgs),
    /// Judge a recorded trace again by its plan, or what another instrument recorded.
    Judge(crate::judge::JudgeArgs),
    /// What each requirement is proven by.
    Requirements(crate::requirements::RequirementsArgs),
    /// Draw the reports of a run again, or put the parts of a suite together.
    Report(crate::report::ReportArgs),
    /// What changed between two runs: verdicts, margins that erode, what they were made from.
    Diff(crate::diff::DiffArgs),
    /// Verdicts, margins and measurements of past runs: what is flaky, and what drifts.
    #[command(subcommand)]
    History(crate::history::HistoryCommand),
    /// Real boards: find lines, look whether they can be had, watch them, try outputs.
    #[command(subcommand)]
    Board(crate::board::BoardCommand),
    /// Check, try, list and measure a Structured Text program alone.
    #[command(subcommand)]
    Program(crate::program::ProgramCommand),
    /// Say what this machine can do on real lines, and the line to type that mends what it cannot.
    Doctor(crate::doctor::DoctorArgs),
    /// Measure what this machine and its board can do, for the runs that follow.
    #[command(subcommand)]
    Bench(crate::bench::BenchCommand),
    /// Make a project with a program, a board, plans and jobs for a CI server.
    New(crate::new::NewArgs),
    /// Keep the modelled controller running on a board, until it is interrupted.
    Run(crate::run::RunArgs),
    /// Look at a controller that `rig run` keeps running, and work it, from a shell or a script.
    Ctl(crate::ctl::CtlArgs),
    /// Look at such a controller on this terminal, and work it: inputs, outputs, trends, tasks, buses, plans.
    Dash(crate::dash::DashArgs),
    /// Go through one case step by step, with its signals and claims, in virtual time.
    Step(crate::step::StepArgs),
    /// Say what the code of a finding means, with an example and the mend.
    Explain(crate::explain::ExplainArgs),
    /// Print the JSON Schema of a format, for editors.
    Schema(crate::schema::SchemaArgs),
    /// The plans that ship with the rig.
    #[command(subcommand)]
    Plans(crate::plans::PlansCommand),
    /// Print what a shell needs to complete the command.
    Completions(crate::completions::CompletionsArgs),
    /// Write the pages for `man` into a folder.
    Man(crate::completions::ManArgs),
}
