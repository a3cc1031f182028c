//! The guard's process from its start to its end.

use crate::lines::{KernelLines, OutputLines};
use crate::page::Page;
use crate::setup::set_up;
use crate::watch::{Ending, FedWatchdog, GuardLoop, GuardSetup, LinesOpener};
use crate::wire::{GuardMessage, Tag};
use drivers::{Bite, OutputClaim};
use host::{HostInstant, WatchdogDevice};
use rustix::event::{EventfdFlags, PollFd, PollFlags, eventfd, poll};
use rustix::io::Errno;
use rustix::time::Timespec;
use signal::Span;
use std::io::IsTerminal;
use std::os::fd::{AsFd, OwnedFd};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

/// How long the rig may take to introduce itself to the guard that it has just started.
const INTRODUCTION: Timespec = Timespec { tv_sec: 10, tv_nsec: 0 };

/// Runs as the guard of the rig at the other end of standard input, until the rig says goodbye or is gone.
pub fn serve() -> ExitCode {
    serve_with(&|held| Box::new(KernelLines::new(held)))
}

/// As [`serve`], for claims of any kind.
pub fn serve_with(open: &dyn Fn(OutputClaim) -> Box<dyn OutputLines>) -> ExitCode {
    if std::io::stdin().is_terminal() {
        eprintln!("rig guard is started by the rig itself and by nobody else");
        return ExitCode::from(2);
    }
    match introduced(open) {
        Ok(Some(watch)) => match watch.run() {
            Ending::Goodbye | Ending::LetGo => ExitCode::SUCCESS,
            Ending::Unsafe => ExitCode::from(4),
        },
        // The rig knows why; or it is gone, and there is nothing to guard.
        Ok(None) => ExitCode::from(4),
        Err(error) => {
            eprintln!("rig guard is started by the rig itself and by nobody else: {error}");
            ExitCode::from(2)
        }
    }
}

/// Sets up and takes the rig's introduction. `None`: it came to nothing.
fn introduced(open: LinesOpener<'_>) -> Result<Option<GuardLoop<'_>>, Errno> {
    let link: OwnedFd = std::io::stdin().as_fd().try_clone_to_owned().map_err(|_| Errno::BADF)?;
    let (lacks, ends) = set_up()?;
    poll(&mut [PollFd::new(&link, PollFlags::IN)], Some(&INTRODUCTION))?;
    let Some((hello, mut descriptors)) = GuardMessage::receive(&link)? else { return Ok(None) };
    let (Tag::Hello, Some(page), Some(rig)) = (hello.tag, descriptors.next(), descriptors.next()) else {
        return Err(Errno::BADMSG);
    };
    let page = Page::map(page)?;
    let finished = Arc::new(eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?);
    let [limit, hold, after, bite] = hello.numbers;
    let watchdog = match hello.text() {
        "" => None,
        path => match WatchdogDevice::open(Path::new(path), Span::from_nanos(after)) {
            Ok(watchdog) => {
                Some(FedWatchdog::new(watchdog, if bite == 0 { Bite::GuardLost } else { Bite::RigLost }))
            }
            Err(error) => {
                let number = error.raw_os_error().unwrap_or_default();
                GuardMessage::new(Tag::Refused, [i64::from(number), 0, 0, 0]).send(&link, &[])?;
                return Ok(None);
            }
        },
    };
    page.guard_lives(HostInstant::now());
    let (limit, hold) = (Span::from_nanos(limit), Span::from_nanos(hold));
    GuardMessage::new(Tag::Done, [lacks.to_number(), 0, 0, 0]).send(&link, &[])?;
    Ok(Some(GuardLoop::new(GuardSetup { link, rig, page, ends, finished, watchdog, limit, hold }, open)))
}
