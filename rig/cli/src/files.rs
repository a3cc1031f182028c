//! Files that the command writes: into new folders never over what somebody has there, and each file whole or not at all.

use document::Diagnostic;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// A folder that something is written into is not empty.
const NOT_EMPTY: &str = "R0150";
/// A file or folder cannot be written.
const NOT_WRITTEN: &str = "R0151";

/// Bytes that are written to a file of the thousands beside a record at once.
const BUFFER: usize = 64 << 10;

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

/// Writes a file whole or not at all: a report half written is never found.
///
/// # Errors
/// Why it cannot be written.
pub fn write_whole(
    path: &Path,
    fill: &mut dyn FnMut(&mut dyn std::io::Write) -> Result<(), String>,
) -> Result<(), String> {
    let fail = |error: std::io::Error| format!("{} cannot be written: {error}", path.display());
    let mut file = atomic_write_file::AtomicWriteFile::open(path).map_err(fail)?;
    {
        let mut buffered = std::io::BufWriter::new(&mut file);
        fill(&mut buffered)?;
        std::io::Write::flush(&mut buffered).map_err(fail)?;
    }
    file.commit().map_err(fail)
}

/// Writes a file as [`write_whole`] does, but does not wait until the disk has it: for the thousands of files beside a
/// record. A power cut may leave one of them empty; of a trace it is noticed, since the record has its digest.
///
/// # Errors
/// Why it cannot be written.
pub fn write_whole_unsynced(
    path: &Path,
    fill: &mut dyn FnMut(&mut dyn std::io::Write) -> Result<(), String>,
) -> Result<(), String> {
    let fail = |error: std::io::Error| format!("{} cannot be written: {error}", path.display());
    let folder = path.parent().unwrap_or(Path::new("."));
    // The rights that any new file gets; a temporary file would be its owner's alone.
    let file = tempfile::Builder::new()
        .permissions(std::fs::Permissions::from_mode(0o666))
        .tempfile_in(folder)
        .map_err(fail)?;
    let mut buffered = std::io::BufWriter::with_capacity(BUFFER, file);
    fill(&mut buffered)?;
    let file = buffered.into_inner().map_err(|error| fail(error.into_error()))?;
    file.persist(path).map(drop).map_err(|error| fail(error.error))
}

/// Writes a text as a file, whole or not at all; into what is no file, such as a pipe, as it comes.
///
/// # Errors
/// Why it cannot be written.
pub fn write_text(path: &Path, text: &str) -> Result<(), String> {
    let fail = |error: std::io::Error| format!("{} cannot be written: {error}", path.display());
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return std::fs::write(path, text).map_err(fail);
    }
    write_whole(path, &mut |out| out.write_all(text.as_bytes()).map_err(fail))
}
