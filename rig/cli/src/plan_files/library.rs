//! The plans that ship, built into the binary.

use crate::plan_files::kind::{self, FileKind};
use include_dir::{Dir, include_dir};
use runtime::suite::FileSource;
use runtime::suite::suites::is_suite;
use std::path::{Component, Path, PathBuf};

static LIBRARY: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/../../plans/library");

/// The register of requirements.
pub const REGISTER: &str = include_str!("../../../../plans/requirements.toml");

/// The files of the shipped library.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShippedFiles;

impl FileSource for ShippedFiles {
    fn read(&self, path: &str) -> Result<String, String> {
        let file = LIBRARY.get_file(plain(path)).ok_or("the library has no such file")?;
        file.contents_utf8().map(str::to_owned).ok_or_else(|| "it is no UTF-8 text".to_owned())
    }
}

/// A path without `.` and `..`: a plan may name a program of another folder.
fn plain(path: &str) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in Path::new(path).components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            Component::Normal(name) => plain.push(name),
            _ => {}
        }
    }
    plain
}

/// All files of the library with their paths, sorted by path.
pub fn files() -> Vec<(&'static Path, &'static [u8])> {
    let mut files = Vec::new();
    let mut folders = vec![&LIBRARY];
    while let Some(folder) = folders.pop() {
        files.extend(folder.files().map(|file| (file.path(), file.contents())));
        folders.extend(folder.dirs());
    }
    files.sort_unstable();
    files
}

/// Paths of all shipped plans, sorted.
pub fn plans() -> Vec<String> {
    let mut paths = Vec::new();
    collect(&LIBRARY, &mut paths);
    paths.sort();
    paths
}

fn collect(folder: &Dir<'_>, paths: &mut Vec<String>) {
    for file in folder.files() {
        let text = file.contents_utf8().unwrap_or_default();
        let toml = file.path().extension().is_some_and(|ending| ending == "toml");
        if toml && !is_suite(&file.path().to_string_lossy()) && kind::of(text) == FileKind::Plan {
            paths.push(file.path().to_string_lossy().into_owned());
        }
    }
    folder.dirs().for_each(|inner| collect(inner, paths));
}
