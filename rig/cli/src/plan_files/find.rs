//! The files of a command line: as given, or searched for in folders.

use crate::exit::ExitStatus;
use crate::output;
use crate::plan_files::kind::{self, FileKind};
use document::file;
use runtime::suite::suites::is_suite;
use std::collections::BTreeSet;
use std::os::unix::fs::MetadataExt;
use std::path::{Component, Path, PathBuf};
use std::{fmt, io};

/// A file or folder that cannot be read.
const FILE_NOT_READ: &str = "R0201";
/// Folders within each other that are searched: deeper than any project.
const MOST_DEPTH: usize = 32;
/// Bytes of a file by which it is seen what it is.
const LOOKED_AT: u64 = 1 << 20;

/// Files of paths: files as given, folders searched for plans in the order of names.
pub fn find(paths: &[PathBuf]) -> Result<Vec<String>, ExitStatus> {
    let mut found = Vec::new();
    for path in paths {
        let here = at(path, &|| true).map_err(|unread| {
            let fix = "give yourself the right to read it, or name the plans themselves";
            output::refuse(FILE_NOT_READ, unread.to_string(), fix)
        })?;
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

/// Whether a plan lies in a folder itself. What cannot be read holds none.
pub fn has_plan(folder: &Path) -> bool {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).any(|path| kind_of(&path) == Some(FileKind::Plan))
}

/// A folder that cannot be searched.
#[derive(Debug)]
pub struct UnreadFolder {
    folder: PathBuf,
    error: io::Error,
}

impl fmt::Display for UnreadFolder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the folder `{}` cannot be searched: {}", self.folder.display(), self.error)
    }
}

/// The file of a path, or the plans of a folder in the order of names. The search ends early where `is_wanted` says that
/// nobody waits for it.
///
/// # Errors
/// The first folder that cannot be read.
pub fn at(path: &Path, is_wanted: &dyn Fn() -> bool) -> Result<Vec<String>, UnreadFolder> {
    if !path.is_dir() {
        return Ok(vec![tidy(path)]);
    }
    let mut search = FolderSearch { is_wanted, visited: BTreeSet::new(), found: Vec::new() };
    search.search(path, 0)?;
    Ok(search.found)
}

/// A search of a folder and those in it.
struct FolderSearch<'a> {
    is_wanted: &'a dyn Fn() -> bool,
    /// The folders that were searched, by device and number: links may lead to one by many ways, or in a circle.
    visited: BTreeSet<(u64, u64)>,
    found: Vec<String>,
}

impl FolderSearch<'_> {
    /// Adds the plans of a folder, and of those in it.
    fn search(&mut self, folder: &Path, depth: usize) -> Result<(), UnreadFolder> {
        let unread = |error| UnreadFolder { folder: folder.to_owned(), error };
        let about = std::fs::metadata(folder).map_err(unread)?;
        if depth > MOST_DEPTH || !(self.is_wanted)() || !self.visited.insert((about.dev(), about.ino())) {
            return Ok(());
        }
        let entries = std::fs::read_dir(folder).map_err(unread)?;
        let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        paths.sort();
        for path in paths {
            if path.is_dir() {
                self.search(&path, depth + 1)?;
            } else if is_plan(&path) {
                self.found.push(tidy(&path));
            }
        }
        Ok(())
    }
}

/// In a folder of a user's project other TOML files stand about. One that is no plan yet is taken for one, so that it is not
/// passed over in silence.
fn is_plan(path: &Path) -> bool {
    matches!(kind_of(path), Some(FileKind::Plan | FileKind::Unclear))
}

/// What a TOML file is that is no suite file; `None` of any other.
fn kind_of(path: &Path) -> Option<FileKind> {
    if path.extension().is_none_or(|ending| ending != "toml") || is_suite(&path.to_string_lossy()) {
        return None;
    }
    Some(match file::read_start(path, LOOKED_AT) {
        Ok(bytes) => kind::of(&String::from_utf8_lossy(&bytes)),
        // What it is cannot be seen: it is taken for a plan, and refused when it is read.
        Err(_) => FileKind::Unclear,
    })
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
