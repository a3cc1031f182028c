//! The page of memory that rig and guard share: signs of life, and the latch.

use crate::Reason;
use host::{AtomicInstant, HostInstant};
use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, fcntl_get_seals, fstat, ftruncate, memfd_create};
use rustix::io;
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::os::fd::{AsFd, OwnedFd};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering};

/// What is in the page. All bit patterns are values, so that neither side has to trust the other.
#[repr(C)]
struct Shared {
    /// When the rig last gave a sign of life.
    rig: AtomicInstant,
    /// When the guard last did.
    guard: AtomicInstant,
    /// When the outputs were found safe after the latch closed.
    safe: AtomicInstant,
    /// When the latch closed.
    latched: AtomicInstant,
    /// Why the latch closed, as [`Reason::number`]; 0 while it is open. It never opens again.
    latch: AtomicU32,
}

/// Bytes of the page.
const LENGTH: usize = 4096;

/// The shared page, mapped.
#[derive(Debug)]
pub(crate) struct Page {
    shared: NonNull<Shared>,
}

// SAFETY: what the pointer leads to is only ever reached as shared atomics, and stays mapped while a `Page` lives.
#[allow(unsafe_code)]
unsafe impl Send for Page {}
// SAFETY: as above.
#[allow(unsafe_code)]
unsafe impl Sync for Page {}

impl Page {
    /// A page of zeros, and the descriptor by which another process maps it too. Its size is sealed: nobody can
    /// cut it off below a reader.
    pub fn create() -> io::Result<(Page, OwnedFd)> {
        let memory = memfd_create("rig guard", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)?;
        ftruncate(&memory, LENGTH as u64)?;
        fcntl_add_seals(&memory, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
        Ok((Page::map(&memory)?, memory))
    }

    /// Maps the page that another process made.
    pub fn map(memory: impl AsFd) -> io::Result<Page> {
        let (seals, length) = (fcntl_get_seals(&memory)?, fstat(&memory)?.st_size);
        if !seals.contains(SealFlags::SHRINK) || length != LENGTH as i64 {
            return Err(io::Errno::INVAL);
        }
        #[allow(unsafe_code)]
        // SAFETY: a new mapping of a whole page, at a place of the kernel's choice, cannot touch what others use.
        let place = unsafe {
            let access = ProtFlags::READ | ProtFlags::WRITE;
            mmap(std::ptr::null_mut(), LENGTH, access, MapFlags::SHARED, memory, 0)?
        };
        let shared = NonNull::new(place.cast()).ok_or(io::Errno::NOMEM)?;
        Ok(Page { shared })
    }

    fn shared(&self) -> &Shared {
        #[allow(unsafe_code)]
        // SAFETY: the mapping is readable, writable, aligned to a page, larger than `Shared`, and lives as long as
        // `self`; its size is sealed; every bit pattern is a `Shared`.
        unsafe {
            self.shared.as_ref()
        }
    }

    /// The rig lives at this instant.
    pub fn rig_lives(&self, now: HostInstant) {
        self.shared().rig.set(now);
    }

    /// When the rig last gave a sign of life; [`HostInstant::BOOT`] where it never did.
    pub fn rig(&self) -> HostInstant {
        self.shared().rig.get().unwrap_or_default()
    }

    /// The guard lives at this instant.
    pub fn guard_lives(&self, now: HostInstant) {
        self.shared().guard.set(now);
    }

    /// When the guard last gave a sign of life; [`HostInstant::BOOT`] where it never did.
    pub fn guard(&self) -> HostInstant {
        self.shared().guard.get().unwrap_or_default()
    }

    /// Closes the latch, once: the first reason stays.
    pub fn latch(&self, reason: Reason, now: HostInstant) {
        let shared = self.shared();
        let first =
            shared.latch.compare_exchange(0, reason.number(), Ordering::AcqRel, Ordering::Acquire).is_ok();
        if first {
            shared.latched.set(now);
        }
    }

    /// Why the latch closed.
    pub fn latched(&self) -> Option<Reason> {
        Reason::from_number(self.shared().latch.load(Ordering::Acquire))
    }

    /// The outputs were found safe after the latch closed.
    pub fn is_safe(&self, now: HostInstant) {
        self.shared().safe.set_first(now);
    }

    /// When the latch closed and when the outputs were found safe after it.
    pub fn times(&self) -> (Option<HostInstant>, Option<HostInstant>) {
        (self.shared().latched.get(), self.shared().safe.get())
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        #[allow(unsafe_code)]
        // SAFETY: the mapping is this value's own, and nothing borrows from it any more.
        let _ = unsafe { munmap(self.shared.as_ptr().cast(), LENGTH) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    fn at(nanos: i64) -> HostInstant {
        HostInstant::from_nanos(nanos)
    }

    #[test]
    fn two_mappings_are_one_page_and_the_latch_never_opens_again() {
        let (rig, memory) = Page::create().unwrap();
        let guard = Page::map(&memory).unwrap();
        rig.rig_lives(at(7));
        assert_eq!((guard.rig(), guard.latched()), (at(7), None));
        guard.latch(Reason::Unresponsive, at(9));
        rig.latch(Reason::Exited, at(11));
        guard.is_safe(at(13));
        guard.is_safe(at(15));
        assert_eq!((rig.latched(), rig.times()), (Some(Reason::Unresponsive), (Some(at(9)), Some(at(13)))));
    }

    #[test]
    fn a_page_can_neither_be_cut_off_nor_be_one_that_could_be() {
        let (_page, memory) = Page::create().unwrap();
        assert_eq!(ftruncate(&memory, 0), Err(io::Errno::PERM));
        let loose = memfd_create("loose", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING).unwrap();
        ftruncate(&loose, LENGTH as u64).unwrap();
        assert!(Page::map(&loose).is_err());
        assert!(Page::map(File::open("/dev/null").unwrap()).is_err());
    }
}
