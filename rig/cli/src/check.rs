//! `rig check`.

use crate::code_pages;
use crate::exit::ExitStatus;
use crate::output;
use crate::plan_files::Parameters;
use crate::plan_files::find::find;
use crate::plan_files::kind::{self, FileKind};
use crate::plan_files::project;
use clap::Args;
use document::{Diagnostic, SourceFile};
use drivers::file::BoardFile;
use profile::Profile;
use runtime::application::tasks;
use runtime::suite::instrument_file::load_instrument;
use runtime::suite::suites;
use runtime::suite::{self, Disk, FileSource};
use std::path::{Path, PathBuf};

/// `rig check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Plans, board files, instrument files, programs (`.st`), or folders that are searched for plans [default: the project in
    /// the current folder].
    #[arg(value_name = "FILE|DIR")]
    pub files: Vec<PathBuf>,
    /// A board file, to be checked and to check the plans on in place of their own.
    #[arg(long, value_name = "FILE")]
    pub board: Option<PathBuf>,
    /// Give a plan's parameter a value.
    #[arg(long = "param", value_name = "K=V")]
    pub params: Vec<String>,
}

/// Reads files and says what is wrong with them.
pub fn run(args: &CheckArgs) -> ExitStatus {
    let mut parameters = match Parameters::read(&args.params) {
        Ok(parameters) => parameters,
        Err(exit) => return exit,
    };
    let named = match (args.files.is_empty() && args.board.is_none(), project::folder()) {
        (false, _) => args.files.clone(),
        (true, Some(folder)) => vec![folder],
        (true, None) => {
            let message = "no file is named, and the current folder is no project";
            return output::refuse(
                "R0230",
                message,
                "name plans, board files or folders, or go to a folder with plans",
            );
        }
    };
    let paths = match find(&named) {
        Ok(paths) => paths,
        Err(exit) => return exit,
    };
    let (mut wrong, mut reported) = (false, Vec::new());
    let mut report = |path: &str, found: &[Diagnostic], sources: &[SourceFile]| {
        output::new_findings(found, &mut reported, sources);
        if found.iter().any(Diagnostic::is_error) {
            wrong = true;
        } else {
            output::print(&format!("{path}: no errors\n"));
        }
    };
    let mut board = None;
    if let Some(path) = &args.board {
        let (path, mut sources) = (path.to_string_lossy(), Vec::new());
        match suite::load_board(&Disk, &path, &mut sources) {
            Ok(read) => {
                report(&path, &worth_knowing(&read.0), &sources);
                board = Some(read);
            }
            Err(found) => report(&path, &found, &sources),
        }
    }
    for path in &paths {
        let mut sources = Vec::new();
        let found = check(path, board.as_ref(), &mut parameters, &mut sources);
        report(path, &found, &sources);
    }
    match parameters.finish() {
        Err(exit) => exit,
        Ok(()) if wrong => ExitStatus::UserFiles,
        Ok(()) => ExitStatus::Passed,
    }
}

/// What is wrong with a file.
fn check(
    path: &str,
    board: Option<&(BoardFile, String)>,
    parameters: &mut Parameters,
    sources: &mut Vec<SourceFile>,
) -> Vec<Diagnostic> {
    if Path::new(path).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("st")) {
        return match suite::load_program(&Disk, path) {
            Err(found) => vec![found],
            Ok(source) => {
                sources.push(source);
                let compiled = runtime::application::compile(sources, Profile::default());
                compiled.map_or_else(
                    |found| found,
                    |mut program| {
                        let mut found = std::mem::take(&mut program.warnings);
                        found.extend(runtime::application::notes(&program, Profile::default()));
                        found.extend(tasks::check(&program, Profile::default()).err().unwrap_or_default());
                        found
                    },
                )
            }
        };
    }
    if suites::is_suite(path) {
        let read = suites::load_suite(&Disk, path, sources);
        return read.map_or_else(|found| found, |suite| suite.warnings);
    }
    // What cannot be read is reported by the loading.
    let text = Disk.read(path).unwrap_or_default();
    match kind::of(&text) {
        FileKind::Board => {
            suite::load_board(&Disk, path, sources).map_or_else(|found| found, |read| worth_knowing(&read.0))
        }
        FileKind::Instrument => load_instrument(&Disk, path, sources).err().unwrap_or_default(),
        FileKind::Included => suite::check_included(&Disk, path, sources),
        _ => check_plan(path, board, &parameters.of_plan(&Disk, path), sources),
    }
}

/// What is worth knowing of a board file that can be used: warnings of the programs of its plants, and what it asks of this machine
/// that it does not have, for the file may be for another one.
fn worth_knowing(board: &BoardFile) -> Vec<Diagnostic> {
    let missing =
        board.control.group.as_deref().and_then(|group| services::control::check_group(group).err());
    let found = missing.map(|fault| {
        let code = code_pages::registered(&fault.code).unwrap_or("R0632");
        let at = board.control.group_at.clone();
        Diagnostic::warning(code, fault.message).at(&board.name, at, "").help(fault.help)
    });
    board.warnings.iter().cloned().chain(found).collect()
}

/// A plan with its programs: every name that it uses is looked up as a run would, without running.
fn check_plan(
    path: &str,
    board: Option<&(BoardFile, String)>,
    parameters: &[(String, String)],
    sources: &mut Vec<SourceFile>,
) -> Vec<Diagnostic> {
    let loaded = match suite::load_plan(&Disk, path, board, parameters, 1, sources) {
        Ok(loaded) => loaded,
        Err(found) => return found,
    };
    let mut found = loaded.plan.warnings.clone();
    found.extend(loaded.suite_warnings().cloned());
    for job in loaded.jobs(0, 1, 1) {
        let Some(case) = loaded.plan.case(job.case) else { continue };
        let checked = loaded.files(&case, &job).and_then(|files| runtime::case::check_case(&case, &files));
        let (Ok(more) | Err(more)) = checked;
        for one in more {
            if !found.contains(&one) {
                found.push(one);
            }
        }
        if found.len() > 50 {
            break;
        }
    }
    found
}
