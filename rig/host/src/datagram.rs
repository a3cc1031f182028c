//! Datagrams of a socket with what the kernel reports beside them.

use std::io;
use std::mem::{size_of, zeroed};
use std::os::fd::{AsFd, AsRawFd};

use rustix::io::Errno;

/// Room for the notes of one datagram: a time and a count take 56 bytes.
const NOTES: usize = 16;

/// A datagram that was received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReceivedDatagram {
    /// Its length on the wire, also where the buffer was too short for it.
    pub len: usize,
    /// When the kernel took it from the device: nanoseconds of the wall clock since 1970.
    pub wall: Option<i64>,
    /// It was sent through this very socket.
    pub own: bool,
    /// How many datagrams found no room in the socket since it was opened, before this one.
    pub dropped: u32,
}

/// Lets the kernel stamp each datagram and count those that find no room.
///
/// # Errors
/// What the kernel says.
pub fn stamp_arrivals(socket: &impl AsFd) -> io::Result<()> {
    for option in [libc::SO_TIMESTAMPNS, libc::SO_RXQ_OVFL] {
        switch_on(socket, option)?;
    }
    Ok(())
}

#[allow(unsafe_code)]
fn switch_on(socket: &impl AsFd, option: libc::c_int) -> io::Result<()> {
    let (socket, on): (_, libc::c_int) = (socket.as_fd().as_raw_fd(), 1);
    let size = size_of::<libc::c_int>() as libc::socklen_t;
    // SAFETY: the kernel reads one int, which lives for the whole call.
    match unsafe { libc::setsockopt(socket, libc::SOL_SOCKET, option, (&raw const on).cast(), size) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

/// Takes the next datagram of a socket; never waits, never allocates.
///
/// # Errors
/// [`Errno::AGAIN`] where there is none, and whatever error the socket has.
#[allow(unsafe_code)]
pub fn receive(socket: &impl AsFd, into: &mut [u8]) -> Result<ReceivedDatagram, Errno> {
    let mut part = libc::iovec { iov_base: into.as_mut_ptr().cast(), iov_len: into.len() };
    // Words, so that the headers of the notes are aligned.
    let mut notes = [0u64; NOTES];
    // SAFETY: the structure is made of numbers and pointers, for which 0 is a value.
    let mut message: libc::msghdr = unsafe { zeroed() };
    message.msg_iov = &raw mut part;
    message.msg_iovlen = 1;
    message.msg_control = notes.as_mut_ptr().cast();
    message.msg_controllen = size_of::<[u64; NOTES]>() as _;
    let flags = libc::MSG_DONTWAIT | libc::MSG_TRUNC;
    // SAFETY: the message points to two buffers with their lengths, which live for the whole call.
    let len = unsafe { libc::recvmsg(socket.as_fd().as_raw_fd(), &raw mut message, flags) };
    let Ok(len) = usize::try_from(len) else {
        let code = io::Error::last_os_error().raw_os_error();
        return Err(code.map_or(Errno::INVAL, Errno::from_raw_os_error));
    };
    let mut received = ReceivedDatagram {
        len,
        own: message.msg_flags & libc::MSG_CONFIRM != 0,
        ..ReceivedDatagram::default()
    };
    // SAFETY: the kernel has set the length of the notes to what it wrote; the buffer is alive and aligned.
    let mut note = unsafe { libc::CMSG_FIRSTHDR(&raw const message) };
    while !note.is_null() {
        // SAFETY: the pointer came from CMSG_FIRSTHDR or CMSG_NXTHDR, so a whole header lies there.
        let header = unsafe { *note };
        // SAFETY: as above; the data lie after the header.
        let data = unsafe { libc::CMSG_DATA(note) };
        // SAFETY: only computes a length.
        let holds = |size: usize| header.cmsg_len as usize >= unsafe { libc::CMSG_LEN(size as u32) } as usize;
        match (header.cmsg_level, header.cmsg_type) {
            (libc::SOL_SOCKET, libc::SCM_TIMESTAMPNS) if holds(size_of::<libc::timespec>()) => {
                // SAFETY: the note holds a whole timespec, as its length says.
                let at = unsafe { data.cast::<libc::timespec>().read_unaligned() };
                received.wall =
                    Some((at.tv_sec as i64).saturating_mul(1_000_000_000).saturating_add(at.tv_nsec as i64));
            }
            (libc::SOL_SOCKET, libc::SO_RXQ_OVFL) if holds(size_of::<u32>()) => {
                // SAFETY: the note holds a whole u32, as its length says.
                received.dropped = unsafe { data.cast::<u32>().read_unaligned() };
            }
            _ => {}
        }
        // SAFETY: message and note are those of above.
        note = unsafe { libc::CMSG_NXTHDR(&raw const message, note) };
    }
    Ok(received)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bracket, HostInstant};
    use std::os::unix::net::UnixDatagram;

    #[test]
    fn a_datagram_comes_with_its_time_and_its_whole_length() {
        let (here, there) = UnixDatagram::pair().unwrap();
        stamp_arrivals(&here).unwrap();
        let mut buffer = [0; 4];
        assert_eq!(receive(&here, &mut buffer), Err(Errno::AGAIN));
        there.send(b"123456").unwrap();
        let got = receive(&here, &mut buffer).unwrap();
        assert_eq!((got.len, &buffer, got.own, got.dropped), (6, b"1234", false, 0));
        let (wall, clocks) = (got.wall.unwrap(), Bracket::measure());
        assert!(clocks.instants(wall).0 <= HostInstant::now(), "{wall} {clocks:?}");
    }
}
