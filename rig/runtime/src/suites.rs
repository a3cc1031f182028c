//! Suite files: `suite.toml` in the folder of a plan and in the folders above it.

use crate::suite::{FileSource, load};
use document::{Diagnostic, SourceFile};
use plans::plan::GlobalChecks;
use std::path::Path;
use std::sync::Arc;

/// The name of a suite file.
pub const SUITE_FILE: &str = "suite.toml";

/// Most folders above a plan: deeper than any project.
const MOST_FOLDERS: usize = 64;

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

/// The folder of a path as it is written; empty for where it is written from.
fn folder_of(path: &str) -> String {
    match path.rfind('/') {
        Some(0) => "/".to_owned(),
        Some(at) => path[..at].to_owned(),
        None => String::new(),
    }
}

/// The folder above a folder.
fn above(folder: &str) -> Option<String> {
    match folder.rsplit('/').next() {
        _ if folder == "/" => None,
        Some("" | ".") if folder.len() < 2 => Some("..".to_owned()),
        Some("..") => Some(format!("{folder}/..")),
        _ => Some(folder_of(folder)),
    }
}

/// The folders that a path is in as it is written, the innermost first; the last one is where it is written from.
pub(crate) fn written(path: &str) -> Vec<String> {
    let ends = |folder: &String| folder.is_empty() || folder.ends_with("..");
    let first = folder_of(path);
    std::iter::successors(Some(first), |folder| above(folder).filter(|_| !ends(folder))).collect()
}

/// The folders of a file on the disk up to that of its repository, or up to the root: the suites of a plan do not
/// depend on where it is run from.
pub(crate) fn on_disk(path: &str) -> Vec<String> {
    let is_last = |folder: &String| {
        let place = if folder.is_empty() { Path::new(".") } else { Path::new(folder) };
        place.join(".git").exists() || is_root(place)
    };
    let folders =
        std::iter::successors(Some(folder_of(path)), |folder| above(folder).filter(|_| !is_last(folder)));
    folders.take(MOST_FOLDERS).collect()
}

fn is_root(folder: &Path) -> bool {
    folder.canonicalize().map_or(true, |folder| folder.parent().is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_in_the_folders_that_it_names() {
        assert_eq!(written("a/b/plan.toml"), ["a/b", "a", ""]);
        assert_eq!(written("plan.toml"), [""]);
        assert_eq!(written("/a/plan.toml"), ["/a", "/"]);
        assert_eq!(above(""), Some("..".to_owned()));
        assert_eq!(above("../a"), Some("..".to_owned()));
        assert_eq!(above(".."), Some("../..".to_owned()));
    }

    #[test]
    fn the_search_ends_at_the_repository_wherever_it_begins() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("work");
        std::fs::create_dir_all(root.join("plans/inner")).unwrap();
        std::fs::create_dir_all(root.join(".git")).unwrap();
        let plan = root.join("plans/inner/lamp.toml");
        let folders = on_disk(&plan.to_string_lossy());
        let wanted: Vec<String> = ["plans/inner", "plans"]
            .iter()
            .map(|inner| root.join(inner).to_string_lossy().into_owned())
            .chain([root.to_string_lossy().into_owned()])
            .collect();
        assert_eq!(folders, wanted);
    }
}
