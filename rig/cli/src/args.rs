//! The command line of `rig`: every command with the arguments that its module reads.

use crate::exit::EXIT_CODES;
use crate::output::ColorChoice;
use clap::{Parser, Subcommand};

/// A hardware-in-the-loop test rig for logic controllers: runs test plans against a modelled or a real
/// controller and says with figures whether its behaviour is right.
#[derive(Debug, Parser)]
#[command(name = "rig", version, after_help = EXIT_CODES, disable_help_subcommand = true)]
pub struct Cli {
    /// Whether to colour text. `auto` follows NO_COLOR, CLICOLOR and CLICOLOR_FORCE.
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t)]
    pub color: ColorChoice,
    /// What to do.
    #[command(subcommand)]
    pub command: CliCommand,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum CliCommand {
    /// Run test plans; without any, those of the project in the current folder, else those that ship with the rig.
    Test(crate::test::TestArgs),
    /// Check plans, boards and programs and report what is wrong; nothing moves.
    Check(crate::check::CheckArgs),
    /// Judge a recorded trace again by its plan, or what another instrument recorded.
    Judge(crate::judge::JudgeArgs),
    /// List the requirements and the cases that prove them.
    Requirements(crate::requirements::RequirementsArgs),
    /// Render the reports of a run again, or merge the parts of a sharded run.
    Report(crate::report::ReportArgs),
    /// Compare two runs: verdicts, margins that erode, inputs that differ.
    Diff(crate::diff::DiffArgs),
    /// Verdicts, margins and measurements of past runs: what is flaky and what drifts.
    #[command(subcommand)]
    History(crate::history::HistoryCommand),
    /// Real boards: find lines, check that they are available, watch inputs, exercise outputs.
    #[command(subcommand)]
    Board(crate::board::BoardCommand),
    /// Check, run, disassemble and measure a Structured Text program without a board.
    #[command(subcommand)]
    Program(crate::program::ProgramCommand),
    /// Check what this machine can do on real lines, and print the command that fixes what it cannot.
    Doctor(crate::doctor::DoctorArgs),
    /// Measure what this machine and its board can do; later runs use the figures.
    #[command(subcommand)]
    Bench(crate::bench::BenchCommand),
    /// Create a project with a program, a board, plans and jobs for a CI server.
    New(crate::new::NewArgs),
    /// Keep the modelled controller running on a board, until it is interrupted.
    Run(crate::run::RunArgs),
    /// Inspect and operate a controller that `rig run` keeps running, from a shell or a script.
    Ctl(crate::ctl::CtlArgs),
    /// Inspect and operate such a controller on this terminal: inputs, outputs, trends, tasks, buses, plans.
    Dash(crate::dash::DashArgs),
    /// Step through one case, with its signals and claims, in virtual time.
    Step(crate::step::StepArgs),
    /// Explain the code of a finding, with an example and the fix; print what the catalogue says of a module.
    Explain(crate::explain::ExplainArgs),
    /// Print where the inputs and outputs of a plan's controller and modules are: addresses, status bytes, modes.
    Modules(crate::modules::ModulesArgs),
    /// Print the JSON Schema of a format, for editors.
    Schema(crate::schema::SchemaArgs),
    /// The plans that ship with the rig.
    #[command(subcommand)]
    Plans(crate::plans::PlansCommand),
    /// Print the completion script of a shell.
    Completions(crate::completions::CompletionsArgs),
    /// Write the pages for `man` into a folder.
    Man(crate::completions::ManArgs),
}
