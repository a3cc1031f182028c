//! A CAN interface of the kernel as something that comes, goes and is opened.

use std::fmt;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};

use rustix::io::Errno;
use signal::Span;

use super::configure::{NotSetUp, configure, is_ready, put_back};
use super::find::restarts_by_rig;
use super::link::{Link, News};
use super::netlink::{Watch, ask, carry_out};
use super::order::restart;
use super::port::{CanPort, KernelPort};
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
    /// Opens it, if it is there as it should be, and reports how its controller takes part.
    ///
    /// # Errors
    /// What the kernel says; EINVAL where it is set up in another way.
    fn open(&mut self) -> io::Result<(Box<dyn CanPort>, BusState)>;

    /// How its controller takes part; `None` where nobody knows.
    fn state(&mut self) -> Option<BusState>;

    /// What became of it since the last question; never waits.
    fn change(&mut self) -> Change;

    /// Becomes readable when something became of it.
    fn source(&self) -> Option<BorrowedFd<'_>>;

    /// How long after bus-off the controller is started again by [`Adapter::restart`], in nanoseconds; `None`: the
    /// kernel does so, or nobody.
    fn restarts_after(&self) -> Option<Span>;

    /// Starts the controller again.
    ///
    /// # Errors
    /// What the kernel says.
    fn restart(&mut self) -> io::Result<()>;

    /// Makes the interface what it was, if the rig has set it up. It is not used any more.
    fn put_back(&mut self);
}

/// An interface of the kernel.
#[derive(Debug)]
pub struct Interface {
    spec: CanBusSpec,
    watch: Watch,
    /// The number of the interface that the rig has set up, or found ready, or tried to set up.
    seen: Option<u32>,
    /// What it was before the rig set it up.
    was: Option<Link>,
    /// The interface that the rig starts again after bus-off.
    restarts: Option<u32>,
    /// What the interface was when it was opened: the first change that is reported of it.
    opened: Option<Change>,
}

impl Interface {
    /// The interface of a bus, there or not.
    ///
    /// # Errors
    /// What the kernel says.
    pub fn new(spec: &CanBusSpec) -> io::Result<Interface> {
        let watch = Watch::start()?;
        Ok(Interface { spec: spec.clone(), watch, seen: None, was: None, restarts: None, opened: None })
    }

    /// Sets an interface up that the rig has not seen before, if the board file leaves that to the rig. One that somebody
    /// changes later stays as it is.
    pub(super) fn prepare(&mut self) -> Result<(), NotSetUp> {
        if !self.spec.configure {
            return Ok(());
        }
        let link = ask(&self.spec.interface).map_err(NotSetUp::Refused)?;
        if self.seen.replace(link.index) == Some(link.index) {
            return Ok(());
        }
        // What the rig had set up before is gone.
        self.was = None;
        if !is_ready(&self.spec, &link) {
            configure(&self.spec, &link)?;
            self.was = Some(link);
            // What the rig did itself is no news.
            let _ = self.watch.news();
        }
        Ok(())
    }
}

/// How a controller that is up takes part. Some drivers never report it, and their interfaces say that they are stopped.
fn taking_part(link: &Link) -> BusState {
    match link.state {
        Some(BusState::Stopped) | None => BusState::ErrorActive,
        Some(state) => state,
    }
}

impl Adapter for Interface {
    fn open(&mut self) -> io::Result<(Box<dyn CanPort>, BusState)> {
        self.prepare()?;
        let link = ask(&self.spec.interface)?;
        if !link.up {
            return Err(Errno::NETDOWN.into());
        }
        if !settings::differences(&self.spec, &link).is_empty() {
            return Err(Errno::INVAL.into());
        }
        let port = KernelPort::open(link.index, &self.spec)?;
        // News from before say that it was down, or away. What became of it since it was opened the second answer says, and
        // a socket whose interface went down meanwhile reports that itself.
        let _ = self.watch.news();
        let now = ask(&self.spec.interface)?;
        if !now.up || now.index != link.index {
            return Err(Errno::NETDOWN.into());
        }
        self.opened = Some(Change::Up { running: now.running });
        self.restarts = Some(link.index).filter(|_| restarts_by_rig(&self.spec, &link));
        Ok((Box::new(port), taking_part(&now)))
    }

    fn state(&mut self) -> Option<BusState> {
        ask(&self.spec.interface).ok().map(|link| taking_part(&link))
    }

    fn change(&mut self) -> Change {
        let is_new = |link: &Link| self.spec.configure && self.seen != Some(link.index);
        let changed = |link: &Link| match link.up || is_new(link) {
            true => Change::Up { running: link.running },
            false => Change::Down,
        };
        let opened = self.opened.take().unwrap_or(Change::None);
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
            None => opened,
        }
    }

    fn source(&self) -> Option<BorrowedFd<'_>> {
        Some(self.watch.as_fd())
    }

    fn restarts_after(&self) -> Option<Span> {
        self.restarts.and(self.spec.restart)
    }

    fn restart(&mut self) -> io::Result<()> {
        let Some(index) = self.restarts else { return Ok(()) };
        match carry_out(&restart(index)) {
            // It is back on the bus: somebody was quicker.
            Err(error) if Errno::from_io_error(&error) == Some(Errno::BUSY) => Ok(()),
            outcome => outcome,
        }
    }

    fn put_back(&mut self) {
        if let Some(was) = self.was.take() {
            put_back(&was);
        }
    }
}

impl Drop for Interface {
    /// Also where the board came to nothing.
    fn drop(&mut self) {
        self.put_back();
    }
}
