//! What the guard says of a rig that is gone, on the standard error that it shares with it.

use crate::{GuardError, Reason};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::write;
use rustix::time::Timespec;
use signal::Span;
use std::os::fd::AsFd;

/// All outputs are safe.
pub(super) fn safe(reason: Reason, devices: &[&str], after: Span) -> String {
    let error = GuardError::Latched(reason);
    let after = after.max(Span::ZERO);
    let devices = devices.join(", ");
    format!(
        "error[{}]: {reason}; the guard drove all outputs safe\n  = {devices}: found safe {after} later\n  = help: {}\n",
        error.code(),
        error.help()
    )
}

/// There are none.
pub(super) fn no_outputs(reason: Reason) -> String {
    let error = GuardError::Latched(reason);
    format!("error[{}]: {reason}; it had no outputs\n  = help: {}\n", error.code(), error.help())
}

/// Some are not.
pub(super) fn not_safe(reason: Reason, why: &str, watchdog: bool) -> String {
    let error = GuardError::Unsafe { why: why.to_owned() };
    let bites = if watchdog { "\n  = the watchdog resets the machine" } else { "" };
    format!("error[{}]: {reason}; {error}{bites}\n  = help: {}\n", error.code(), error.help())
}

/// Says it, unless nobody can read it now: a full pipe or a stopped terminal must not hold the guard.
pub(super) fn report(text: &str) {
    let (said, at_once) = (std::io::stderr(), Timespec::default());
    let mut room = [PollFd::from_borrowed_fd(said.as_fd(), PollFlags::OUT)];
    if poll(&mut room, Some(&at_once)).is_ok_and(|count| count > 0) {
        let _ = write(&said, text.as_bytes());
    }
}
