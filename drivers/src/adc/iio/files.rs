//! The small files by which the kernel describes a device and takes its settings.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A file of a device refused what was asked of it.
#[derive(Debug)]
pub(super) struct FileError {
    /// The file.
    pub(super) path: PathBuf,
    /// What was written; `None`: it was read.
    pub(super) wrote: Option<String>,
    /// What the kernel said.
    pub(super) error: io::Error,
}

impl std::fmt::Display for FileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let path = self.path.display();
        match &self.wrote {
            Some(text) => write!(f, "{path} does not take \"{text}\": {}", self.error),
            None => write!(f, "{path} cannot be read: {}", self.error),
        }
    }
}

/// The text of a file without the white space around it.
pub(super) fn read(path: &Path) -> Result<String, FileError> {
    let text = fs::read_to_string(path);
    text.map(|text| text.trim().to_owned()).map_err(|error| FileError {
        path: path.to_owned(),
        wrote: None,
        error,
    })
}

/// Writes a file of the kernel. It is never made: a device that went away leaves no file behind.
pub(super) fn write(path: &Path, text: &str) -> Result<(), FileError> {
    let written = fs::File::options()
        .write(true)
        .truncate(true)
        .open(path)
        .and_then(|mut file| io::Write::write_all(&mut file, text.as_bytes()));
    written.map_err(|error| FileError { path: path.to_owned(), wrote: Some(text.to_owned()), error })
}
