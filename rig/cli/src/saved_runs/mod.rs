//! Runs on disk: read again by folder or record; the folder that a new run writes, and where a run came from.

pub mod provenance;
pub mod report_folder;

use document::Diagnostic;
use record::{MAX_JSON_BYTES, RunRecord};
use std::path::{Path, PathBuf};

/// A run, with the folder that its traces are beside.
#[derive(Debug)]
pub struct SavedRun {
    /// As the user named it.
    pub name: String,
    /// Where its record is.
    pub folder: PathBuf,
    /// Its record.
    pub record: RunRecord,
}

/// Reads a run by its folder or its record.
///
/// # Errors
/// A finding with the path and the reason.
pub fn load(path: &Path) -> Result<SavedRun, Diagnostic> {
    let (file, folder) = if path.is_file() {
        (path.to_owned(), path.parent().unwrap_or(Path::new("")).to_owned())
    } else {
        (path.join("record.json"), path.to_owned())
    };
    let text = text(&file).map_err(|why| {
        Diagnostic::error("R0160", format!("`{}` cannot be read: {why}", file.display()))
            .help("name the folder that `rig test --report` wrote")
    })?;
    let record = RunRecord::from_json(&text)
        .map_err(|error| Diagnostic::error(error.code(), format!("`{}`: {error}", file.display())))?;
    Ok(SavedRun { name: path.display().to_string(), folder, record })
}

/// The text of a file, no more of it than a record may have.
fn text(path: &Path) -> Result<String, String> {
    let bytes = document::file::read(path, MAX_JSON_BYTES as u64).map_err(|fault| fault.to_string())?;
    String::from_utf8(bytes).map_err(|_| String::from("it is no UTF-8 text"))
}
