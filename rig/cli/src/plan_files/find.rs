//! The files of a command line: as given, or searched for in folders.

use crate::exit::ExitStatus;
use crate::output;
use crate::plan_files::kind::{self, FileKind};
use runtime::suite::suites::is_suite;
use std::path::{Component, Path, PathBuf};

/// Files of paths: files as given, folders searched for plans in the order of names.
pub fn find(paths: &[PathBuf]) -> Result<Vec<String>, ExitStatus> {
    let mut found = Vec::new();
    for path in paths {
        let here = at(path, &|| true);
        if here.is_empty() {
            let message = format!("{} holds no plan", path.display());
            return Err(output::refuse(
                "R0230",
                message,
                "a plan is a file NAME.toml that begins with `format = 1`",
            ));
        }
        found.extend(here);
    }
    Ok(found)
}

/// The file of a path, or the plans of a folder in the order of names. The search ends early where `is_wanted` says that
/// nobody waits for it.
pub fn at(path: &Path, is_wanted: &dyn Fn() -> bool) -> Vec<String> {
    if !path.is_dir() {
        return vec![tidy(path)];
    }
    let mut found = Vec::new();
    search(path, 0, is_wanted, &mut found);
    found
}

fn search(folder: &Path, depth: usize, is_wanted: &dyn Fn() -> bool, found: &mut Vec<String>) {
    // Deeper than any project; ends circles of links.
    if depth > 32 || !is_wanted() {
        return;
    }
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            search(&path, depth + 1, is_wanted, found);
        } else if !is_suite(&path.to_string_lossy()) && is_plan(&path) {
            found.push(tidy(&path));
        }
    }
}

/// In a folder of a user's project other TOML files stand about. One that is no plan yet is taken for one, so that it is not
/// passed over in silence.
fn is_plan(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "toml")
        && std::fs::read_to_string(path)
            .is_ok_and(|text| matches!(kind::of(&text), FileKind::Plan | FileKind::Unclear))
}

/// A path without `.`: cases are named by it, and one plan has one name.
fn tidy(path: &Path) -> String {
    let parts: PathBuf = path.components().filter(|part| *part != Component::CurDir).collect();
    parts.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_has_one_name() {
        for path in ["a/lamp.toml", "./a/lamp.toml", "a/./lamp.toml", "a//lamp.toml"] {
            assert_eq!(tidy(Path::new(path)), "a/lamp.toml");
        }
        assert_eq!(tidy(Path::new("../lamp.toml")), "../lamp.toml");
        assert_eq!(tidy(Path::new("/lamp.toml")), "/lamp.toml");
    }
}
