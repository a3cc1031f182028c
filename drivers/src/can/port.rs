//! A socket on a CAN interface.

use std::fmt;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};

use host::ReceivedDatagram;
use rustix::io::Errno;
use rustix::net::sockopt;
use rustix::net::{SendFlags, send};
use socketcan::{CanAddr, CanFdSocket, CanFilter, CanSocket, Socket, SocketOptions};

use super::spec::CanBusSpec;
use super::wire::FD;

/// Room for frames on their way from the kernel, in bytes as the kernel counts them: some thousand frames.
const ROOM: usize = 4 << 20;
/// Of an identifier in a filter: it has 29 bits.
const EXTENDED: u32 = 0x8000_0000;

/// The way to a bus. None of its calls waits.
pub trait CanPort: Send + fmt::Debug {
    /// The next frame or report.
    ///
    /// # Errors
    /// EAGAIN where there is none; ENETDOWN, ENODEV where the interface went down or away.
    fn receive(&mut self, into: &mut [u8; FD]) -> Result<ReceivedDatagram, Errno>;

    /// Hands a frame to the kernel.
    ///
    /// # Errors
    /// ENOBUFS or EAGAIN where its queue is full; ENETDOWN, ENXIO, ENODEV where the interface is down or away.
    fn send(&mut self, bytes: &[u8]) -> Result<(), Errno>;

    /// Becomes readable when there is something to receive.
    fn source(&self) -> BorrowedFd<'_>;
}

/// A socket of the kernel, of either kind.
#[derive(Debug)]
enum Raw {
    Classic(CanSocket),
    Fd(CanFdSocket),
}

/// A socket that hears the frames of a bus, its own, and the reports of its controller.
#[derive(Debug)]
pub struct KernelPort {
    socket: Raw,
}

impl KernelPort {
    /// Opens the interface of this number.
    ///
    /// # Errors
    /// What the kernel says.
    pub fn open(index: u32, spec: &CanBusSpec) -> io::Result<KernelPort> {
        let address = CanAddr::new(index);
        let socket = match spec.data_bitrate {
            None => Raw::Classic(prepared(CanSocket::open_addr(&address)?, spec)?),
            Some(_) => Raw::Fd(prepared(CanFdSocket::open_addr(&address)?, spec)?),
        };
        let port = KernelPort { socket };
        host::stamp_arrivals(&port)?;
        // More than the system allows only with a privilege; without it, what the system allows.
        if sockopt::set_socket_recv_buffer_size_force(&port, ROOM).is_err() {
            sockopt::set_socket_recv_buffer_size(&port, ROOM)?;
        }
        Ok(port)
    }
}

/// Everything that the bus reports, and nothing of others.
fn prepared<S: Socket + SocketOptions>(socket: S, spec: &CanBusSpec) -> io::Result<S> {
    socket.set_nonblocking(true)?;
    socket.set_recv_own_msgs(true)?;
    socket.set_error_filter_accept_all()?;
    if !spec.accept.is_empty() {
        let filter = |filter: &super::Filter| {
            let kind = if filter.extended { EXTENDED } else { 0 };
            // The kind of identifier counts as well.
            CanFilter::new(filter.id | kind, filter.mask | EXTENDED)
        };
        socket.set_filters(&spec.accept.iter().map(filter).collect::<Vec<CanFilter>>())?;
    }
    Ok(socket)
}

impl AsFd for KernelPort {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match &self.socket {
            Raw::Classic(socket) => socket.as_fd(),
            Raw::Fd(socket) => socket.as_fd(),
        }
    }
}

impl CanPort for KernelPort {
    fn receive(&mut self, into: &mut [u8; FD]) -> Result<ReceivedDatagram, Errno> {
        host::receive(self, into)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), Errno> {
        send(&*self, bytes, SendFlags::DONTWAIT).map(|_| ())
    }

    fn source(&self) -> BorrowedFd<'_> {
        self.as_fd()
    }
}
