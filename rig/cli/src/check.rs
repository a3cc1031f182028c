//! `rig check`.

use crate::args::CheckArgs;
use crate::exit::Exit;
use crate::library;
use crate::output;
use crate::test::{find, parameters};
use profile::Profile;
use runtime::suite::{self, Disk, Files};
use std::path::Path;

/// Reads files and says what is wrong with them.
pub fn run(args: &CheckArgs) -> Exit {
    let parameters = match parameters(&args.params) {
        Ok(parameters) => parameters,
        Err(exit) => return exit,
    };
    let paths = match find(&args.files) {
        Ok(paths) => paths,
        Err(exit) => return exit,
    };
    let mut wrong = 0usize;
    for path in &paths {
        if check(path, &parameters) {
            output::print(&format!("{path}: no errors\n"));
        } else {
            wrong += 1;
        }
    }
    if wrong == 0 { Exit::Passed } else { Exit::UserFiles }
}

/// Whether a file has no errors.
fn check(path: &str, parameters: &[(String, String)]) -> bool {
    let mut sources = Vec::new();
    let text = Disk.read(path).unwrap_or_default();
    let found = if Path::new(path).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("st")) {
        match suite::load(&Disk, path) {
            Err(found) => vec![found],
            Ok(source) => {
                sources.push(source);
                runtime::application::compile(&sources, Profile::default())
                    .map_or_else(|found| found, |program| program.warnings)
            }
        }
    } else if library::is_board(&text) {
        suite::load_board(&Disk, path, &mut sources).map_or_else(|found| found, |_| Vec::new())
    } else {
        check_plan(path, parameters, &mut sources)
    };
    output::findings(&found, &sources);
    !found.iter().any(document::Diagnostic::is_error)
}

/// A plan with its programs: every name that it uses is looked up as a run would, without running.
fn check_plan(
    path: &str,
    parameters: &[(String, String)],
    sources: &mut Vec<document::SourceFile>,
) -> Vec<document::Diagnostic> {
    let loaded = match suite::load_plan(&Disk, path, None, parameters, 1, sources) {
        Ok(loaded) => loaded,
        Err(found) => return found,
    };
    let mut found = loaded.plan.warnings.clone();
    for job in loaded.jobs(0, 1, 1) {
        let Some(case) = loaded.plan.case(job.case) else { continue };
        let checked = loaded.files(&case, &job).and_then(|files| runtime::case::check_case(&case, &files));
        if let Err(more) = checked {
            for one in more {
                if !found.contains(&one) {
                    found.push(one);
                }
            }
        }
        if found.len() > 50 {
            break;
        }
    }
    found
}
