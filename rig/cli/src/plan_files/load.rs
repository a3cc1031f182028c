//! Plans with everything that they name.

use crate::exit::ExitStatus;
use crate::output;
use crate::plan_files::Parameters;
use crate::plan_files::find::find;
use crate::plan_files::kind::{self, FileKind};
use crate::plan_files::library::{self, ShippedFiles};
use document::{Diagnostic, SourceFile};
use drivers::file::BoardFile;
use runtime::suite::suites::is_suite;
use runtime::suite::{self, Disk, FileSource, LoadedPlan};
use std::path::{Path, PathBuf};

/// A file that is named as a plan and is none.
const NO_PLAN: &str = "R0235";

/// What the command line names.
#[derive(Clone, Copy, Debug)]
pub struct LoadRequest<'a> {
    /// Plans and folders of plans; none for the plans that ship.
    pub plans: &'a [PathBuf],
    /// The board file in place of each plan's own.
    pub board: Option<&'a Path>,
    /// Values of parameters, `name=value`.
    pub params: &'a [String],
    /// The seed.
    pub seed: u64,
}

/// Reads plans, and prints what is wrong with them.
///
/// # Errors
/// How the command ends: all findings are printed.
pub fn load(request: &LoadRequest<'_>, sources: &mut Vec<SourceFile>) -> Result<Vec<LoadedPlan>, ExitStatus> {
    let mut parameters = Parameters::read(request.params)?;
    let board: Option<(BoardFile, String)> = match request.board {
        None => None,
        Some(path) => match suite::load_board(&Disk, &path.to_string_lossy(), sources) {
            Ok(board) => {
                output::findings(&board.0.warnings, sources);
                Some(board)
            }
            Err(found) => {
                output::findings(&found, sources);
                return Err(ExitStatus::UserFiles);
            }
        },
    };
    let shipped = request.plans.is_empty();
    let files: &dyn FileSource = if shipped { &ShippedFiles } else { &Disk };
    let paths = if shipped { library::plans() } else { find(request.plans)? };
    let mut loaded = Vec::new();
    let (mut wrong, mut shown) = (false, Vec::new());
    for path in &paths {
        if let Some((what, help)) = other_than_plan(files, path) {
            let found = Diagnostic::error(NO_PLAN, format!("`{path}` is {what} and no plan")).help(help);
            output::new_findings(&[found], &mut shown, sources);
            wrong = true;
            continue;
        }
        // What cannot be read is reported by the loading.
        let own = parameters.of_plan(files, path);
        match suite::load_plan(files, path, board.as_ref(), &own, request.seed, sources) {
            Ok(plan) => {
                output::findings(&plan.plan.warnings, sources);
                let of_suites: Vec<Diagnostic> = plan.suite_warnings().cloned().collect();
                output::new_findings(&of_suites, &mut shown, sources);
                loaded.push(plan);
            }
            Err(found) => {
                output::new_findings(&found, &mut shown, sources);
                wrong = true;
            }
        }
    }
    if wrong {
        return Err(ExitStatus::UserFiles);
    }
    parameters.finish()?;
    Ok(loaded)
}

/// What a file is that was named as a plan and is none, and what to do; `None` for a plan, and for what may become one.
fn other_than_plan(files: &dyn FileSource, path: &str) -> Option<(&'static str, &'static str)> {
    if is_suite(path) {
        return Some(("a suite file", "name the plans below it, or their folder"));
    }
    if Path::new(path).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("st")) {
        return Some((
            "a program",
            "name a plan that has it as its `program`; `rig program run` runs it alone",
        ));
    }
    match kind::of(&files.read(path).ok()?) {
        FileKind::Board => {
            Some(("a board file", "name plans; with `--board FILE` they run on it in place of their own"))
        }
        FileKind::Instrument => Some(("an instrument file", "`rig judge --instrument FILE` takes it")),
        FileKind::Plan | FileKind::Included | FileKind::Unclear | FileKind::Neither => None,
    }
}
