//! The arguments of `rig program`.

use crate::output::OutputFormat;
use clap::{Args, Subcommand};
use std::path::PathBuf;

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
    pub format: OutputFormat,
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
    /// How many scans to measure, after a few to warm up.
    #[arg(long, value_name = "N")]
    pub cycles: u64,
    /// How to print.
    #[arg(long, value_enum, default_value_t)]
    pub format: OutputFormat,
}
