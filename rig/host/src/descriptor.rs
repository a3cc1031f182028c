//! Descriptors of libraries that do not lend them in std's terms.

use std::io;
use std::os::fd::{AsRawFd, BorrowedFd, OwnedFd};

/// A descriptor of its own for what `owner` has open.
///
/// # Errors
/// The process has no descriptor left.
#[allow(unsafe_code)]
pub fn duplicate(owner: &impl AsRawFd) -> io::Result<OwnedFd> {
    // SAFETY: the owner is borrowed for the whole call and keeps its descriptor open; a number that is open no more is
    // refused by the kernel.
    unsafe { BorrowedFd::borrow_raw(owner.as_raw_fd()) }.try_clone_to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duplicate_outlives_its_owner() {
        let owner = std::fs::File::open("/dev/null").unwrap();
        let again = duplicate(&owner).unwrap();
        drop(owner);
        assert!(std::fs::File::from(again).metadata().is_ok());
    }
}
