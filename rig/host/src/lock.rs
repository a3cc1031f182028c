//! Locks on parts of a file, which go with the description that was opened, however its process ends.

use rustix::io::Errno;
use std::fs::File;
use std::io;
use std::os::fd::AsRawFd;

/// Locks bytes of a file that is open for writing, until the file is closed. FALSE where another description of the file
/// has some of them locked. Never waits.
///
/// # Errors
/// What the kernel says: the file system knows no locks, or the range is none.
#[allow(unsafe_code)]
pub fn lock_bytes(file: &File, start: u64, length: u64) -> io::Result<bool> {
    let place = |number: u64| libc::off_t::try_from(number).map_err(|_| io::Error::from(Errno::OVERFLOW));
    let wanted = libc::flock {
        l_type: libc::F_WRLCK as libc::c_short,
        l_whence: libc::SEEK_SET as libc::c_short,
        l_start: place(start)?,
        l_len: place(length)?,
        // As the kernel wants it for locks of a description.
        l_pid: 0,
    };
    // SAFETY: the descriptor is that of the file, which is borrowed for the call; the kernel reads `wanted` during it, and
    // no more than a `flock`.
    let done = unsafe { libc::fcntl(file.as_raw_fd(), libc::F_OFD_SETLK, &raw const wanted) };
    if done == 0 {
        return Ok(true);
    }
    let error = io::Error::last_os_error();
    match error.raw_os_error().map(Errno::from_raw_os_error) {
        Some(Errno::AGAIN | Errno::ACCESS) => Ok(false),
        _ => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_locked_once_until_the_file_is_closed() {
        let path = std::env::temp_dir().join(format!("scanrig-lock-{}", std::process::id()));
        let open =
            || File::options().read(true).write(true).create(true).truncate(false).open(&path).unwrap();
        let (one, other) = (open(), open());
        assert!(lock_bytes(&one, 256, 256).unwrap());
        assert!(lock_bytes(&other, 0, 256).unwrap(), "beside it");
        assert!(!lock_bytes(&other, 300, 1).unwrap(), "inside of it");
        drop(one);
        assert!(lock_bytes(&other, 300, 1).unwrap());
        assert!(lock_bytes(&other, u64::MAX, 1).is_err());
        std::fs::remove_file(path).unwrap();
    }
}
