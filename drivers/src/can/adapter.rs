//! A CAN interface of the kernel as something that comes, goes and is opened.

use std::fmt;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};

use rustix::io::Errno;

use super::link::{Link, News};
use super::netlink::{Watch, ask};
use super::port::{KernelPort, Port};
use super::settings;
use super::spec::CanBusSpec;
use crate::BusState;

/// What became of an interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// Nothing new.
    None,
    /// It is down, or away.
    Down,
    /// It is there and up.
    Up {
        /// Frames can pass.
        running: bool,
    },
    /// It was down or away, and is up again.
    Flapped,
}

/// An interface that may come and go.
pub trait Adapter: Send + fmt::Debug {
    /// Opens it, if it is there as it should be, and tells how its controller takes part.
    ///
    /// # Errors
    /// What the kernel says; EINVAL where it is set up in another way.
    fn open(&mut self) -> io::Result<(Box<dyn Port>, BusState)>;

    /// How its controller takes part; `None` where nobody knows.
    fn state(&mut self) -> Option<BusState>;

    /// What became of it since the last question; never waits.
    fn change(&mut self) -> Change;

    /// Becomes readable when something became of it.
    fn source(&self) -> Option<BorrowedFd<'_>>;
}

/// An interface of the kernel.
#[derive(Debug)]
pub struct Interface {
    spec: CanBusSpec,
    watch: Watch,
}

impl Interface {
    /// The interface of a bus, there or not.
    ///
    /// # Errors
    /// What the kernel says.
    pub fn new(spec: &CanBusSpec) -> io::Result<Interface> {
        Ok(Interface { spec: spec.clone(), watch: Watch::start()? })
    }
}

/// How a controller that is up takes part. Some drivers never tell, and their interfaces say that they are stopped.
fn taking_part(link: &Link) -> BusState {
    match link.state {
        Some(BusState::Stopped) | None => BusState::ErrorActive,
        Some(state) => state,
    }
}

impl Adapter for Interface {
    fn open(&mut self) -> io::Result<(Box<dyn Port>, BusState)> {
        let link = ask(&self.spec.interface)?;
        if !link.up {
            return Err(Errno::NETDOWN.into());
        }
        if !settings::differences(&self.spec, &link).is_empty() {
            return Err(Errno::INVAL.into());
        }
        Ok((Box::new(KernelPort::open(link.index, &self.spec)?), taking_part(&link)))
    }

    fn state(&mut self) -> Option<BusState> {
        ask(&self.spec.interface).ok().map(|link| taking_part(&link))
    }

    fn change(&mut self) -> Change {
        let changed = |link: &Link| if link.up { Change::Up { running: link.running } } else { Change::Down };
        let Some(news) = self.watch.news() else {
            return ask(&self.spec.interface).map_or(Change::Down, |link| changed(&link));
        };
        let mine = |link: &Link| link.name == self.spec.interface;
        let changes = news.iter().filter_map(|news| match news {
            News::Is(link) if mine(link) => Some(changed(link)),
            News::Gone(link) if mine(link) => Some(Change::Down),
            _ => None,
        });
        let all: Vec<Change> = changes.collect();
        match all.last() {
            Some(Change::Up { .. }) if all.contains(&Change::Down) => Change::Flapped,
            Some(change) => *change,
            None => Change::None,
        }
    }

    fn source(&self) -> Option<BorrowedFd<'_>> {
        Some(self.watch.as_fd())
    }
}
