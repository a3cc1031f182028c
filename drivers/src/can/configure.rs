//! Setting an interface up, and back as it was.

use std::io;

use host::Errno;
use thiserror::Error;

use super::link::Link;
use super::netlink::{ask, carry_out};
use super::order::{Setup, nothing, set, up};
use super::settings::differences;
use super::spec::CanBusSpec;

/// Why an interface is not set up as the board file says.
#[derive(Debug, Error)]
pub(super) enum NotSetUp {
    /// The kernel refuses it.
    #[error("the kernel refuses it: {0}")]
    Refused(#[source] io::Error),
    /// It is set up, and these differences stay.
    #[error("these differences stay: {}", .0.join("; "))]
    Differs(Vec<String>),
}

impl From<NotSetUp> for io::Error {
    fn from(why: NotSetUp) -> io::Error {
        match why {
            NotSetUp::Refused(error) => error,
            NotSetUp::Differs(_) => Errno::INVAL.into(),
        }
    }
}

/// Whether the rig has to do something before a bus can use this interface.
pub(super) fn is_ready(spec: &CanBusSpec, link: &Link) -> bool {
    link.up && differences(spec, link).is_empty()
}

/// Whether the rig may change interfaces. Changes nothing.
pub(super) fn may_change(link: &Link) -> bool {
    // An order that the kernel refuses for another reason is one that it would take.
    carry_out(&nothing(link.index)).err().and_then(|error| Errno::from_io_error(&error)) != Some(Errno::PERM)
}

/// Sets up an interface that was like that, and brings it up. On an error it is as it was.
pub(super) fn configure(spec: &CanBusSpec, was: &Link) -> Result<(), NotSetUp> {
    let done = change(was.index, was.up, &Setup::wanted(spec, was), true)
        .and_then(|()| ask(&spec.interface))
        .map_err(NotSetUp::Refused)
        .and_then(|link| match differences(spec, &link) {
            differ if differ.is_empty() => Ok(()),
            differ => Err(NotSetUp::Differs(differ)),
        });
    if done.is_err() {
        put_back(was);
    }
    done
}

/// Makes an interface what it was. One that had no bit rate keeps the one that it got: the kernel cannot take it away.
pub(super) fn put_back(was: &Link) {
    // It may be gone, and somebody else may have taken it down; there is nobody left to report it to.
    let _ = change(was.index, true, &Setup::of(was), was.up);
}

/// An interface is set up while it is down only.
fn change(index: u32, is_up: bool, setup: &Setup, goes_up: bool) -> io::Result<()> {
    if is_up {
        carry_out(&up(index, false))?;
    }
    carry_out(&set(index, setup))?;
    if goes_up { carry_out(&up(index, true)) } else { Ok(()) }
}
