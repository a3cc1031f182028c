//! Suite files: `suite.toml` in the folder of a plan and in the folders above it.

use crate::suite::file_source::{FileSource, load};
use document::{Diagnostic, SourceFile};
use plans::plan::GlobalChecks;
use std::path::Path;
use std::sync::Arc;

/// The name of a suite file.
pub const SUITE_FILE: &str = "suite.toml";

/// Whether a path is that of a suite file, which is no plan.
pub fn is_suite(path: &str) -> bool {
    Path::new(path).file_name().is_some_and(|name| name == SUITE_FILE)
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
        let path = if folder.is_empty() { SUITE_FILE.to_owned() } else { in_folder(&folder, SUITE_FILE) };
        if files.has(&path) {
            suites.push(Arc::new(load_suite(files, &path, sources)?));
        }
    }
    Ok(suites)
}

fn in_folder(folder: &str, name: &str) -> String {
    format!("{}/{name}", folder.trim_end_matches('/'))
}
