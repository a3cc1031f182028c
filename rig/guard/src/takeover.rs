//! Lines that the guard of a rig that is gone still holds, asked for by the next rig.
//!
//! A guard that is alone listens on a socket in the abstract space, under a name of its own; the next rig finds them
//! in the kernel's table. Only the same user, or root, is heard.

use crate::wire::{GuardMessage, Tag};
use host::HostInstant;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::sockopt::socket_peercred;
use rustix::net::{
    AddressFamily, SocketAddrUnix, SocketFlags, SocketType, accept_with, bind, connect, listen, socket_with,
};
use rustix::process::{geteuid, getpid};
use rustix::time::Timespec;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

/// What the names of guards that are alone begin with.
const NAME: &str = "scanrig-guard/";
/// How long another guard may take to let go.
const PATIENCE: Timespec = Timespec { tv_sec: 1, tv_nsec: 0 };

fn socket() -> Result<OwnedFd, Errno> {
    let flags = SocketFlags::CLOEXEC | SocketFlags::NONBLOCK;
    socket_with(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None)
}

/// Whether the process at the other end may ask for lines.
fn is_one_of_us(peer: &OwnedFd) -> bool {
    socket_peercred(peer).is_ok_and(|peer| peer.uid.is_root() || peer.uid == geteuid())
}

/// Where a guard that is alone can be asked.
#[derive(Debug)]
pub(crate) struct Listener(OwnedFd);

impl Listener {
    /// Without a socket the lines are let go when it is time.
    pub fn open() -> Option<Listener> {
        let name = format!("{NAME}{}", getpid().as_raw_nonzero());
        let address = SocketAddrUnix::new_abstract_name(name.as_bytes()).ok()?;
        let socket = socket().ok()?;
        bind(&socket, &address).ok()?;
        listen(&socket, 4).ok()?;
        Some(Listener(socket))
    }

    /// Somebody who asks.
    pub fn accept(&self) -> Option<TakeoverRequest> {
        let takeover = accept_with(&self.0, SocketFlags::CLOEXEC | SocketFlags::NONBLOCK).ok()?;
        is_one_of_us(&takeover).then_some(TakeoverRequest(takeover))
    }
}

impl AsFd for Listener {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Somebody who asks for lines.
#[derive(Debug)]
pub(crate) struct TakeoverRequest(OwnedFd);

impl TakeoverRequest {
    /// Whether it asks for one of these devices; `None` where it asks for nothing.
    pub fn asks_for<'a>(&self, mut devices: impl Iterator<Item = &'a str>) -> Option<bool> {
        let (message, _) = GuardMessage::receive(&self.0).ok()??;
        (message.tag == Tag::TakeOver).then(|| devices.any(|device| device == message.text()))
    }

    /// Says whether it got them.
    pub fn answer(self, got: bool) {
        let tag = if got { Tag::Done } else { Tag::Refused };
        let _ = GuardMessage::new(tag, [0; 4]).send(&self.0, &[]);
    }
}

impl AsFd for TakeoverRequest {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Asks the guards of rigs that are gone to let go of a device ([`drivers::OutputClaim::device`]). Gives how many did:
/// with more than none, its lines can be claimed now.
pub fn take_over(device: &str) -> usize {
    let Ok(table) = std::fs::read_to_string("/proc/net/unix") else { return 0 };
    let names = table.lines().filter_map(|line| line.rsplit(' ').next()?.strip_prefix('@'));
    names.filter(|name| name.starts_with(NAME) && ask(name, device).unwrap_or(false)).count()
}

/// Asks one guard.
fn ask(name: &str, device: &str) -> Result<bool, Errno> {
    let guard = socket()?;
    connect(&guard, &SocketAddrUnix::new_abstract_name(name.as_bytes())?)?;
    if !is_one_of_us(&guard) {
        return Ok(false);
    }
    GuardMessage::new(Tag::TakeOver, [HostInstant::now().as_nanos(), 0, 0, 0])
        .with(device)
        .send(&guard, &[])?;
    poll(&mut [PollFd::new(&guard, PollFlags::IN)], Some(&PATIENCE))?;
    Ok(GuardMessage::receive(&guard)?.is_some_and(|(answer, _)| answer.tag == Tag::Done))
}
