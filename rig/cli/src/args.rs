//! The command line of `rig`.

use crate::diff::DiffArgs;
use crate::history::HistoryCommand;
use crate::judge::JudgeArgs;
use crate::output::ColorChoice;
use crate::report::ReportArgs;
use crate::step::StepArgs;
use crate::test::{LeaveArgs, LookArgs};
use crate::wait::WaitArgs;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

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

/// The exit codes, as `--help` and the README list them.
pub const EXIT_CODES: &str = "Exit codes: 0 all passed, 1 a case failed, 2 something is wrong with your files or \
arguments (an empty selection too), 3 inconclusive at worst, 4 an error of the rig itself, 130 interrupted after a \
clean teardown.";

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run test plans; without any, the plans that ship with the rig, on the simulated board.
    Test(TestArgs),
    /// Read plans, boards and programs and say what is wrong with them; nothing moves.
    Check(CheckArgs),
    /// Judge a recorded trace again by its plan, or what another instrument recorded.
    Judge(JudgeArgs),
    /// What each requirement is proven by.
    Requirements(RequirementsArgs),
    /// Draw the reports of a run again, or put the parts of a suite together.
    Report(ReportArgs),
    /// What changed between two runs: verdicts, margins that erode, what they were made from.
    Diff(DiffArgs),
    /// Verdicts, margins and measurements of past runs: what is flaky, and what drifts.
    #[command(subcommand)]
    History(HistoryCommand),
    /// Real boards: find lines, look whether they can be had, watch them, try outputs.
    #[command(subcommand)]
    Board(crate::board::BoardCommand),
    /// Check, try, list and measure a Structured Text program alone.
    #[command(subcommand)]
    Program(ProgramCommand),
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
    Step(StepArgs),
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

/// Which clock a run keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClockChoice {
    /// Jump from event to event: a day of scans in seconds, the same every time.
    Virtual,
    /// The host's clock.
    Real,
}

/// `rig test`.
#[derive(Debug, Args)]
pub struct TestArgs {
    /// Plan files, or folders that are searched for plans.
    #[arg(value_name = "PLAN|DIR")]
    pub plans: Vec<PathBuf>,
    /// The board file to use in place of each plan's own.
    #[arg(long, value_name = "FILE")]
    pub board: Option<PathBuf>,
    /// The clock to run on [default: virtual; real on a board with real lines].
    #[arg(long, value_enum)]
    pub clock: Option<ClockChoice>,
    /// Write the record, the reports and the traces into this folder.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// Cases to run at once in virtual time [default: the number of cores].
    #[arg(long, value_name = "N")]
    pub jobs: Option<std::num::NonZeroUsize>,
    /// Run only the cases that this expression selects: words that the case's name holds, `title:WORD`,
    /// `proves:ID`, `tag:WORD`, `profile:NAME`, joined by `and`, `or`, `not`, with brackets.
    #[arg(long, value_name = "EXPR")]
    pub only: Option<String>,
    /// Give a plan's parameter a value.
    #[arg(long = "param", value_name = "K=V")]
    pub params: Vec<String>,
    /// The seed of everything that is left to chance.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Run every case this many times, each with a seed of its own.
    #[arg(long, value_name = "N", default_value = "1")]
    pub repeat: std::num::NonZeroU32,
    /// Start no further case after the first that did not pass.
    #[arg(long)]
    pub fail_fast: bool,
    /// List the cases and run none.
    #[arg(long)]
    pub list: bool,
    /// Note which statements and branches of the programs ran.
    #[arg(long)]
    pub coverage: bool,
    /// What a run on real lines does when somebody else is on them.
    #[command(flatten)]
    pub wait: WaitArgs,
    /// How the run is shown.
    #[command(flatten)]
    pub look: LookArgs,
    /// What the run leaves.
    #[command(flatten)]
    pub leave: LeaveArgs,
}

/// `rig check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Plans, board files, programs (`.st`), or folders that are searched for plans.
    #[arg(value_name = "FILE|DIR", required_unless_present = "board")]
    pub files: Vec<PathBuf>,
    /// A board file, to be checked and to check the plans on in place of their own.
    #[arg(long, value_name = "FILE")]
    pub board: Option<PathBuf>,
    /// Give a plan's parameter a value.
    #[arg(long = "param", value_name = "K=V")]
    pub params: Vec<String>,
}

/// `rig requirements`.
#[derive(Debug, Args)]
pub struct RequirementsArgs {
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Take the last verdicts from this folder, which `rig test --report DIR` wrote, instead of running the library.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// For a person or for a program.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Columns for a person.
    #[default]
    Table,
    /// JSON for a program.
    Json,
}

/// `rig program`.
#[derive(Debug, Subcommand)]
pub enum ProgramCommand {
    /// Compile and say what is wrong.
    Check {
        /// Structured Text files of one application.
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Run an application alone in virtual time and print its variables.
    Run(ProgramRunArgs),
    /// Print the code with its source lines and the modelled time of each operation.
    Dump {
        /// Structured Text files of one application.
        #[arg(required = true)]
        files: Vec<PathBuf>,
    },
    /// Measure how long the host takes for a scan, and how long the modelled controller does.
    Bench(ProgramBenchArgs),
}

/// `rig program run`.
#[derive(Debug, Args)]
pub struct ProgramRunArgs {
    /// Structured Text files of one application.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// How long to run, in modelled time.
    #[arg(long = "for", value_name = "TIME", default_value = "1 s")]
    pub duration: String,
    /// Interval of the task that runs the PROGRAMs without a task of their own.
    #[arg(long, value_name = "TIME", default_value = "20 ms")]
    pub interval: String,
    /// Set a variable before the first cycle.
    #[arg(long, value_name = "VAR=VALUE")]
    pub set: Vec<String>,
    /// Print these variables in place of all.
    #[arg(long, value_name = "VAR,...")]
    pub print: Vec<String>,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Print which statements and branches ran.
    #[arg(long)]
    pub coverage: bool,
}

/// `rig program bench`.
#[derive(Debug, Args)]
pub struct ProgramBenchArgs {
    /// Structured Text files of one application.
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// How many scans to measure, behind a few to warm up.
    #[arg(long, value_name = "N")]
    pub cycles: u64,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}
