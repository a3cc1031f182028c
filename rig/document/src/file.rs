//! Files of the user, read with a limit.
//!
//! What a path stands for is not known before it is opened: a folder, a pipe that nobody writes into, a device without an
//! end, a file that grows. Every file that the user names is read through this module, which takes regular files alone and
//! never more of them than its caller has room for.

use std::fmt;
use std::fs::{File, FileType, Metadata, OpenOptions};
use std::io::{self, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

use rustix::fs::OFlags;

/// Why a file is not read.
#[derive(Debug)]
pub enum FileFault {
    /// The operating system refuses it.
    Io(io::Error),
    /// It is no regular file; what it is in place of one.
    NotRegular(&'static str),
    /// It has more bytes than are read.
    TooLarge {
        /// How many it has; `None` of one that grew while it was read.
        length: Option<u64>,
        /// The most that are read.
        most: u64,
    },
}

impl FileFault {
    /// Whether there is nothing of this name.
    pub fn is_not_found(&self) -> bool {
        matches!(self, FileFault::Io(error) if error.kind() == io::ErrorKind::NotFound)
    }
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FileFault::Io(error) => error.fmt(f),
            FileFault::NotRegular(what) => write!(f, "it is {what} and no regular file"),
            FileFault::TooLarge { length: Some(length), most } => {
                write!(f, "it has {length} bytes, {most} is the most")
            }
            FileFault::TooLarge { length: None, most } => write!(f, "it has more than {most} bytes"),
        }
    }
}

impl std::error::Error for FileFault {}

impl From<io::Error> for FileFault {
    fn from(error: io::Error) -> Self {
        FileFault::Io(error)
    }
}

/// What is no regular file, in words.
fn other_than_regular(found: FileType) -> Option<&'static str> {
    if found.is_file() {
        None
    } else if found.is_dir() {
        Some("a folder")
    } else if found.is_fifo() {
        Some("a pipe")
    } else if found.is_socket() {
        Some("a socket")
    } else {
        Some("a device")
    }
}

fn regular(about: &Metadata) -> Result<(), FileFault> {
    other_than_regular(about.file_type()).map_or(Ok(()), |what| Err(FileFault::NotRegular(what)))
}

/// Opens a regular file for reading. Never waits: a pipe is not opened at all.
///
/// # Errors
/// [`FileFault::Io`], [`FileFault::NotRegular`].
pub fn open(path: &Path) -> Result<File, FileFault> {
    // Opening a device can do something by itself.
    regular(&std::fs::metadata(path)?)?;
    // What came into its place since then is not waited for.
    let flags = i32::try_from(OFlags::NONBLOCK.bits()).unwrap_or(0);
    let file = OpenOptions::new().read(true).custom_flags(flags).open(path)?;
    regular(&file.metadata()?)?;
    Ok(file)
}

/// The bytes of a regular file that has `most` of them at most.
///
/// # Errors
/// [`FileFault`].
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>, FileFault> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    if length > most {
        return Err(FileFault::TooLarge { length: Some(length), most });
    }
    let bytes = start_of(file, most.saturating_add(1))?;
    if bytes.len() as u64 > most {
        return Err(FileFault::TooLarge { length: None, most });
    }
    Ok(bytes)
}

/// The first bytes of a regular file, `most` of them at most.
///
/// # Errors
/// [`FileFault::Io`], [`FileFault::NotRegular`].
pub fn read_start(path: &Path, most: u64) -> Result<Vec<u8>, FileFault> {
    start_of(open(path)?, most)
}

fn start_of(file: File, most: u64) -> Result<Vec<u8>, FileFault> {
    let mut bytes = Vec::new();
    file.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "abc").unwrap();
        assert_eq!(read(&path, 3).unwrap(), b"abc");
        assert_eq!(read(&path, 2).unwrap_err().to_string(), "it has 3 bytes, 2 is the most");
        assert_eq!(read_start(&path, 2).unwrap(), b"ab");
        assert!(read(&folder.path().join("b"), 3).unwrap_err().is_not_found());
    }

    #[test]
    fn what_is_no_regular_file_is_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let mode = rustix::fs::Mode::from_raw_mode(0o600);
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(&pipe, &link).unwrap();
        let nowhere = folder.path().join("nowhere");
        std::os::unix::fs::symlink(folder.path().join("none"), &nowhere).unwrap();
        for (path, what) in [
            (folder.path(), "it is a folder and no regular file"),
            (&pipe, "it is a pipe and no regular file"),
            (&link, "it is a pipe and no regular file"),
            (Path::new("/dev/zero"), "it is a device and no regular file"),
        ] {
            assert_eq!(read(path, 100).unwrap_err().to_string(), what, "{}", path.display());
        }
        assert!(read(&nowhere, 100).unwrap_err().is_not_found());
        // A file of the kernel says a length of 0 and has more.
        assert!(matches!(
            read(Path::new("/proc/self/maps"), 100),
            Err(FileFault::TooLarge { length: None, most: 100 })
        ));
    }
}
