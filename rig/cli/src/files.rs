//! Files that the command writes: into new folders never over what somebody has there, and each file whole or not at all.

use document::Diagnostic;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::io::Errno;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A folder that something is written into is not empty.
const NOT_EMPTY: &str = "R0150";
/// A file or folder cannot be written.
const NOT_WRITTEN: &str = "R0151";

/// The name of a file of the thousands beside a record until it is whole.
const UNFINISHED: &str = ".rig-unfinished";

/// How long whoever reads a pipe may take nothing out of it.
const PATIENCE: Duration = Duration::from_secs(10);

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
    // One name for the folder: what a killed command left there is gone with the next one, and so is a pipe of that name, which
    // would be waited for.
    let unfinished = path.with_file_name(UNFINISHED);
    let _ = std::fs::remove_file(&unfinished);
    let file = OpenOptions::new().write(true).create_new(true).open(&unfinished);
    let mut buffered = std::io::BufWriter::with_capacity(BUFFER, file.map_err(fail)?);
    let written = fill(&mut buffered).and_then(|()| buffered.flush().map_err(fail));
    let placed = written.and_then(|()| std::fs::rename(&unfinished, path).map_err(fail));
    if placed.is_err() {
        let _ = std::fs::remove_file(&unfinished);
    }
    placed
}

/// Writes into what is no file, such as a pipe or a terminal, and waits for whoever reads there no longer than
/// [`PATIENCE`]: a command that waited without end could not be interrupted.
fn write_stream(path: &Path, mut bytes: &[u8]) -> std::io::Result<()> {
    let flags = i32::try_from((OFlags::NONBLOCK | OFlags::NOCTTY).bits()).unwrap_or(0);
    let mut out = match OpenOptions::new().write(true).custom_flags(flags).open(path) {
        Err(error) if error.raw_os_error() == Some(Errno::NXIO.raw_os_error()) => {
            return Err(std::io::Error::new(ErrorKind::NotConnected, "nobody reads it"));
        }
        opened => opened?,
    };
    let patience = Timespec::try_from(PATIENCE).unwrap_or_default();
    while !bytes.is_empty() {
        match out.write(bytes) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(written) => bytes = &bytes[written..],
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                let mut waiting = [PollFd::new(&out, PollFlags::OUT)];
                match poll(&mut waiting, Some(&patience)) {
                    Ok(0) => {
                        return Err(std::io::Error::new(
                            ErrorKind::TimedOut,
                            "whoever reads it takes nothing",
                        ));
                    }
                    Ok(_) | Err(Errno::INTR) => {}
                    Err(errno) => return Err(errno.into()),
                }
            }
            Err(error) => return Err(error),
        }
    }
    out.flush()
}

/// Writes a text as a file, whole or not at all; into what is no file, such as a pipe, as it comes.
///
/// # Errors
/// Why it cannot be written.
pub fn write_text(path: &Path, text: &str) -> Result<(), String> {
    let fail = |error: std::io::Error| format!("{} cannot be written: {error}", path.display());
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return write_stream(path, text.as_bytes()).map_err(fail);
    }
    write_whole(path, &mut |out| out.write_all(text.as_bytes()).map_err(fail))
}
