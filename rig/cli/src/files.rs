//! Folders that the command fills: never over what somebody has there.

use document::Diagnostic;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A folder that something is written into is not empty.
const NOT_EMPTY: &str = "R0150";
/// A file or folder cannot be written.
const NOT_WRITTEN: &str = "R0151";

/// What stands in the way of writing a file or folder.
pub fn failed(path: &Path, error: &std::io::Error) -> Diagnostic {
    Diagnostic::error(NOT_WRITTEN, format!("`{}` cannot be written: {error}", path.display()))
        .help("name a folder that you may write to")
}

/// Writes files into a new or empty folder, each by its path within it.
///
/// # Errors
/// What stands in the way; nothing was written over.
pub fn write_new(folder: &Path, files: &[(PathBuf, Vec<u8>)]) -> Result<(), Diagnostic> {
    match std::fs::read_dir(folder) {
        Ok(entries) => {
            if let Some(name) =
                entries.map(|entry| entry.map_or_else(|_| "?".into(), |entry| entry.file_name())).min()
            {
                let message = format!("the folder `{}` is not empty", folder.display());
                let help = format!("it has `{}`: name a new folder, or an empty one", name.to_string_lossy());
                return Err(Diagnostic::error(NOT_EMPTY, message).help(help));
            }
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
        Err(error) => return Err(failed(folder, &error)),
    }
    for (path, content) in files {
        let path = folder.join(path);
        let parent = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent).map_err(|error| failed(parent, &error))?;
        // Whatever came into the folder since it was looked at stays, too.
        let mut file = std::fs::File::create_new(&path).map_err(|error| failed(&path, &error))?;
        file.write_all(content).map_err(|error| failed(&path, &error))?;
    }
    Ok(())
}
