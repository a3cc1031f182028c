//! Where the user's files come from, and the folders that they are in.

use crate::codes;
use document::{Diagnostic, SourceFile};
use std::path::Path;

/// Where plans, programs and board files come from: a disk, or what is built into the binary.
pub trait FileSource: Sync {
    /// The text of a file.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn read(&self, path: &str) -> Result<String, String>;

    /// The bytes of a file, which need not be UTF-8.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read(path).map(String::into_bytes)
    }

    /// Whether there is such a file.
    fn has(&self, path: &str) -> bool {
        self.read(path).is_ok()
    }

    /// The folders that a file is in and whose suites it is of, the innermost first; empty for where paths are
    /// written from.
    fn folders(&self, path: &str) -> Vec<String> {
        written(path)
    }
}

/// Largest file that is read.
const LARGEST_FILE: u64 = 8 << 20;

/// The host's disk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl FileSource for Disk {
    fn read(&self, path: &str) -> Result<String, String> {
        let bytes = self.bytes(path)?;
        if path.to_ascii_lowercase().ends_with(".dbc") && std::str::from_utf8(&bytes).is_err() {
            // Older tools write Latin-1, where each byte is the character of its number.
            return Ok(bytes.into_iter().map(char::from).collect());
        }
        String::from_utf8(bytes)
            .map_err(|error| format!("it is no UTF-8 text (byte {})", error.utf8_error().valid_up_to()))
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        let length = std::fs::metadata(path).map_err(|error| error.to_string())?.len();
        if length > LARGEST_FILE {
            return Err(format!("it has {length} bytes, {LARGEST_FILE} is the most"));
        }
        tracing::debug!(path, length, "a file is read");
        std::fs::read(path).map_err(|error| error.to_string())
    }

    fn has(&self, path: &str) -> bool {
        Path::new(path).is_file()
    }

    fn folders(&self, path: &str) -> Vec<String> {
        on_disk(path)
    }
}

/// A path beside another file.
pub fn beside(file: &str, path: &str) -> String {
    match file.rfind('/') {
        Some(at) if !path.starts_with('/') => format!("{}/{path}", &file[..at]),
        _ => path.to_owned(),
    }
}

/// Reads a user's file into a source.
///
/// # Errors
/// A finding with the path and the reason.
pub fn load(files: &dyn FileSource, path: &str) -> Result<SourceFile, Diagnostic> {
    let text = files
        .read(path)
        .map_err(|why| Diagnostic::error(codes::FILE_NOT_READ, format!("`{path}` cannot be read: {why}")))?;
    Ok(SourceFile::new(path, text))
}

/// Reads a file of Structured Text, in whatever encoding and wrapping it is distributed.
///
/// # Errors
/// A finding with the path and the reason.
pub fn load_program(files: &dyn FileSource, path: &str) -> Result<SourceFile, Diagnostic> {
    let bytes = files
        .bytes(path)
        .map_err(|why| Diagnostic::error(codes::FILE_NOT_READ, format!("`{path}` cannot be read: {why}")))?;
    program::source(path, &bytes)
}

/// Most folders above a plan: deeper than any project.
const MOST_FOLDERS: usize = 64;

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
fn written(path: &str) -> Vec<String> {
    let ends = |folder: &String| folder.is_empty() || folder.ends_with("..");
    let first = folder_of(path);
    std::iter::successors(Some(first), |folder| above(folder).filter(|_| !ends(folder))).collect()
}

/// The folders of a file on the disk up to that of its repository, or up to the root: the suites of a plan do not
/// depend on where it is run from.
fn on_disk(path: &str) -> Vec<String> {
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
