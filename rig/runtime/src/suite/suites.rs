//! Suite files: `suite.toml` in the folder of a plan and in the folders above it.

use crate::codes;
use crate::suite::file_source::{FileSource, load};
use document::{Diagnostic, SourceFile};
use plans::plan::{GlobalChecks, SUITE_KEYS};
use std::path::Path;
use std::sync::Arc;

/// The name of a suite file.
pub const SUITE_FILE: &str = "suite.toml";

/// Whether a path is that of a suite file, which is no plan.
pub fn is_suite(path: &str) -> bool {
    Path::new(path).file_name().is_some_and(|name| name == SUITE_FILE)
}

/// Whether a file, which need not be there, is one of a suite: a suite file lies beside it or in a folder above.
pub fn is_of_suite(files: &dyn FileSource, path: &str) -> bool {
    files.folders(path).iter().any(|folder| files.has(&of_folder(folder)))
}

/// Reads a suite file.
///
/// # Errors
/// Findings in it.
pub fn load_suite(
    files: &dyn FileSource,
    path: &str,
    sources: &mut Vec<SourceFile>,
) -> Result<GlobalChecks, Vec<Diagnostic>> {
    let file = load(files, path).map_err(|found| vec![found])?;
    if sources.iter().all(|known| known.name != file.name) {
        sources.push(file.clone());
    }
    GlobalChecks::of_suite(&file)
}

/// The suites that a plan is of, the outermost first.
pub(crate) fn suites_of(
    files: &dyn FileSource,
    plan: &str,
    sources: &mut Vec<SourceFile>,
) -> Result<Vec<Arc<GlobalChecks>>, Vec<Diagnostic>> {
    let mut suites = Vec::new();
    for folder in files.folders(plan).into_iter().rev() {
        let path = of_folder(&folder);
        if let Some(found) = misnamed(files, &folder, plan, sources) {
            return Err(vec![found]);
        }
        if files.has(&path) {
            if files.is_foreign(&path, plan) {
                return Err(vec![foreign(&path)]);
            }
            suites.push(Arc::new(load_suite(files, &path, sources)?));
        }
    }
    Ok(suites)
}

/// A file that was meant as the suite file of a folder and is called otherwise: it would be passed over. A plan, and what
/// this plan includes, may have any name.
fn misnamed(files: &dyn FileSource, folder: &str, plan: &str, sources: &[SourceFile]) -> Option<Diagnostic> {
    files.names(folder).into_iter().filter(|name| is_nearly(name)).find_map(|name| {
        let path = if folder.is_empty() { name.clone() } else { in_folder(folder, &name) };
        if path == plan || sources.iter().any(|known| known.name == path) {
            return None;
        }
        let text = files.read(&path).ok()?;
        is_meant_as_suite(&path, text).then(|| {
            Diagnostic::error(
                codes::SUITE_MISNAMED,
                format!("`{path}` is not read: a suite file is called `{SUITE_FILE}`"),
            )
            .help(format!("rename it to `{SUITE_FILE}`; give a file that plans include another name"))
        })
    })
}

/// Whether a name is that of a suite file but for one letter, or for capitals.
fn is_nearly(name: &str) -> bool {
    name != SUITE_FILE
        && document::distance(&name.to_lowercase(), SUITE_FILE).is_some_and(|letters| letters <= 1)
}

/// Whether a file has nothing but what a suite file has. One that is no TOML yet may be one.
fn is_meant_as_suite(path: &str, text: String) -> bool {
    let Ok(root) = document::toml::parse(&SourceFile::new(path, text), plans::TOML) else { return true };
    let is_known = |key: &str| SUITE_KEYS.iter().any(|spec| spec.name == key);
    root.entries.iter().all(|entry| is_known(&entry.key))
        && ["invariants", "alarms"].iter().any(|key| root.get(key).is_some())
}

/// That the suite file beside a plan is somebody else's.
fn foreign(path: &str) -> Diagnostic {
    let message = format!(
        "`{path}` belongs to another user, in a folder that all users share: it is not taken as the suite of the plan"
    );
    Diagnostic::error(codes::SUITE_OF_ANOTHER_USER, message)
        .help("move the plan into a folder of your own, with the suite file if it is meant")
}

/// The suite file of a folder.
fn of_folder(folder: &str) -> String {
    if folder.is_empty() { SUITE_FILE.to_owned() } else { in_folder(folder, SUITE_FILE) }
}

fn in_folder(folder: &str, name: &str) -> String {
    format!("{}/{name}", folder.trim_end_matches('/'))
}
