//! `rig program`: Structured Text without a controller and without a board.

mod args;
mod bench;
mod check;
mod dump;
mod run;

pub use args::ProgramCommand;

use crate::exit::ExitStatus;
use crate::output::{self, refuse};
use document::{Diagnostic, SourceFile};
use profile::Profile;
use program::Program;
use runtime::instrument::standalone::StandaloneEnd;
use runtime::suite::{self, Disk};
use signal::Span;
use std::path::PathBuf;
use std::sync::Arc;

/// Carries out the command.
pub fn run(command: &ProgramCommand) -> ExitStatus {
    match command {
        ProgramCommand::Check { files } => check::check(files),
        ProgramCommand::Run(args) => run::run(args),
        ProgramCommand::Dump { files } => dump::dump(files),
        ProgramCommand::Bench(args) => bench::bench(args),
    }
}

/// Reads and compiles the files of one application for the default controller, and shows what is found in them.
pub fn compile(files: &[PathBuf]) -> Result<(Arc<Program>, Vec<SourceFile>), ExitStatus> {
    compile_with(files, runtime::application::compile)
}

/// The compiler to be used: one for applications or one for libraries.
type Compiler = fn(&[SourceFile], Profile) -> Result<Program, Vec<Diagnostic>>;

fn compile_with(
    files: &[PathBuf],
    compiler: Compiler,
) -> Result<(Arc<Program>, Vec<SourceFile>), ExitStatus> {
    let mut sources = Vec::new();
    for path in files {
        match suite::load_program(&Disk, &path.to_string_lossy()) {
            Ok(source) => sources.push(source),
            Err(found) => {
                output::findings(&[found], &sources);
                return Err(ExitStatus::UserFiles);
            }
        }
    }
    sources.extend(runtime::application::blocks::generated(&sources));
    match compiler(&sources, Profile::default()) {
        Ok(program) => {
            output::findings(&program.warnings, &sources);
            Ok((Arc::new(program), sources))
        }
        Err(found) => {
            output::findings(&found, &sources);
            Err(ExitStatus::UserFiles)
        }
    }
}

/// A duration above 0 that an option gives.
fn duration(option: &str, text: &str) -> Result<Span, ExitStatus> {
    match Span::parse(text) {
        Ok(span) if span > Span::ZERO => Ok(span),
        Ok(_) => Err(refuse("R0504", format!("{option} {text}: must be above 0"), "")),
        Err(error) => {
            Err(refuse("R0504", format!("{option} {text}: {error}"), "as in `500 ms` or `1 min 30 s`"))
        }
    }
}

/// How a run alone ended, said where that was not well.
pub fn ended(ended: &StandaloneEnd) -> ExitStatus {
    match ended {
        StandaloneEnd::InTime { .. } => ExitStatus::Passed,
        StandaloneEnd::Fault { at, text } => {
            output::error(&format!("the program failed after {at}: {text}"));
            ExitStatus::Failed
        }
        StandaloneEnd::Endless { task, at } => {
            output::error(&format!(
                "{task}: the cycle that began after {at} had not ended at the end of the run"
            ));
            ExitStatus::Failed
        }
    }
}
