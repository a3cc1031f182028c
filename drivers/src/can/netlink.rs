//! Questions to the kernel about CAN interfaces, and its news of them.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::netlink::SocketAddrNetlink;
use rustix::net::{AddressFamily, RecvFlags, SendFlags, SocketFlags, SocketType, bind};
use rustix::net::{recv, sendto, socket_with};
use rustix::time::Timespec;

use super::link::{Link, News, read};
use super::order::question;

/// Room for what the kernel reports of an interface: it sends at most a page or two.
const ROOM: usize = 32 * 1024;
/// Membership in the group that gets every change of an interface.
const CHANGES: u32 = 1;
/// How long an answer is waited for: the kernel answers at once, but for somebody who holds up all interfaces.
const PATIENCE: Timespec = Timespec { tv_sec: 2, tv_nsec: 0 };

/// A socket that gets changes of interfaces.
#[derive(Debug)]
pub struct Watch {
    socket: OwnedFd,
    room: Vec<u8>,
}

impl Watch {
    /// From now on.
    ///
    /// # Errors
    /// What the kernel says.
    pub fn start() -> io::Result<Watch> {
        Ok(Watch { socket: open(CHANGES)?, room: vec![0; ROOM] })
    }

    /// The news so far; never waits. `None`: some were lost.
    pub fn news(&mut self) -> Option<Vec<News>> {
        let mut all = Vec::new();
        loop {
            match recv(&self.socket, &mut self.room[..], RecvFlags::DONTWAIT) {
                Ok((len, _)) => all.extend(read(&self.room[..len])),
                Err(Errno::NOBUFS) => return None,
                Err(Errno::INTR) => {}
                Err(_) => return Some(all),
            }
        }
    }
}

impl AsFd for Watch {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

fn open(groups: u32) -> io::Result<OwnedFd> {
    let socket = socket_with(AddressFamily::NETLINK, SocketType::RAW, SocketFlags::CLOEXEC, None)?;
    bind(&socket, &SocketAddrNetlink::new(0, groups))?;
    Ok(socket)
}

/// What the interface of this name is.
///
/// # Errors
/// ENODEV where there is none, and what else the kernel says.
pub fn ask(name: &str) -> io::Result<Link> {
    match exchange(&question(name))? {
        News::Is(link) => Ok(link),
        News::Gone(_) => Err(Errno::NODEV.into()),
        News::Refused(code) => Err(io::Error::from_raw_os_error(code)),
    }
}

/// Has the kernel change an interface, and waits until it has.
///
/// # Errors
/// EPERM without the privilege (CAP_NET_ADMIN), and what else the kernel says.
pub(super) fn carry_out(order: &[u8]) -> io::Result<()> {
    match exchange(order)? {
        News::Refused(0) | News::Is(_) => Ok(()),
        News::Gone(_) => Err(Errno::NODEV.into()),
        News::Refused(code) => Err(io::Error::from_raw_os_error(code)),
    }
}

/// The first answer to a message.
fn exchange(message: &[u8]) -> io::Result<News> {
    let socket = open(0)?;
    sendto(&socket, message, SendFlags::empty(), &SocketAddrNetlink::new(0, 0))?;
    let mut room = vec![0; ROOM];
    loop {
        let mut wait = [PollFd::from_borrowed_fd(socket.as_fd(), PollFlags::IN)];
        if poll(&mut wait, Some(&PATIENCE))? == 0 {
            return Err(Errno::TIMEDOUT.into());
        }
        let (len, _) = recv(&socket, &mut room[..], RecvFlags::DONTWAIT)?;
        if let Some(news) = read(&room[..len]).into_iter().next() {
            return Ok(news);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loopback_interface_is_found_and_a_strange_name_is_not() {
        let link = ask("lo").unwrap();
        assert_eq!((link.name.as_str(), link.bits), ("lo", None));
        assert_eq!(ask("no-such-if0").unwrap_err().raw_os_error(), Some(Errno::NODEV.raw_os_error()));
    }
}
