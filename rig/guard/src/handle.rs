//! The rig's side of its guard.

use crate::page::Page;
use crate::wire::{GuardMessage, PWM, Tag};
use crate::{GuardError, MissingPrivileges, Reason};
use drivers::{Bite, GuardSettings, LineApi, OutputClaim, OutputGuard};
use host::{AtomicInstant, HostInstant, Unstoppable, never_stops};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::{AddressFamily, SocketFlags, SocketType, socketpair};
use rustix::process::{Pid, PidfdFlags, getpid, pidfd_open};
use rustix::time::Timespec;
use signal::Span;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// How long the guard may take to start: all of its program is read from the disk and locked.
const START: Span = Span::from_secs(60);
/// How much longer than the limit an answer may take on a busy machine.
const SLACK: Span = Span::from_secs(3);
/// Signs of life within the limit, at least.
const BEATS: i64 = 4;

/// What became of a sign of life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeartbeatState {
    /// The guard watches.
    Kept,
    /// The guard latched the outputs: nothing that the rig writes counts any more.
    Latched(Reason),
    /// The guard itself gives no sign of life: nobody makes the outputs safe but the rig.
    Unguarded,
}

/// Starts guards.
#[derive(Debug)]
pub struct Guard;

impl Guard {
    /// Starts a guard of this process: `rig guard`, the same program. To be done before anything else that matters:
    /// memory, threads and privileges are still small then.
    ///
    /// # Errors
    /// [`GuardError::Start`], [`GuardError::Watchdog`], [`GuardError::NeverStops`].
    pub fn spawn(settings: &GuardSettings) -> Result<GuardHandle, GuardError> {
        let mut rig = Command::new("/proc/self/exe");
        rig.arg("guard");
        Guard::spawn_as(rig, settings)
    }

    /// The same with a program of which the caller knows that it calls [`crate::serve`] or [`crate::serve_with`].
    ///
    /// # Errors
    /// As [`Guard::spawn`].
    pub fn spawn_as(mut program: Command, settings: &GuardSettings) -> Result<GuardHandle, GuardError> {
        if let Some(dog) = &settings.watchdog
            && never_stops(&dog.path) == Some(true)
        {
            return Err(GuardError::NeverStops { path: dog.path.clone() });
        }
        let (link, other) =
            socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None)?;
        let (page, memory) = Page::create()?;
        let this = pidfd_open(getpid(), PidfdFlags::empty())?;
        let child = program.stdin(Stdio::from(other)).stdout(Stdio::null()).spawn();
        let child = child.map_err(GuardError::Start)?;
        // The command keeps the guard's end of the link open as long as it lives.
        drop(program);
        let exit = i32::try_from(child.id()).ok().and_then(Pid::from_raw).ok_or(Errno::SRCH);
        let exit = match exit.and_then(|process| pidfd_open(process, PidfdFlags::empty())) {
            Ok(exit) => exit,
            Err(error) => {
                end(child);
                return Err(error.into());
            }
        };
        let mut inner = Inner { link, child, exit, unstoppable: None, closed: false, gone: false };
        let (path, after, bite) = match &settings.watchdog {
            Some(dog) => (dog.path.to_string_lossy(), dog.after, dog.bite),
            None => ("".into(), Span::ZERO, Bite::GuardLost),
        };
        let numbers = [
            settings.limit.as_nanos(),
            settings.hold.as_nanos(),
            after.as_nanos(),
            i64::from(bite == Bite::RigLost),
        ];
        let hello = GuardMessage::new(Tag::Hello, numbers).with(&path);
        let answer = match inner.ask(&hello, &[memory.as_fd(), this.as_fd()], START) {
            Ok(answer) => answer,
            Err(error) => {
                // It holds no lines yet, and nobody would end it later.
                end(inner.child);
                return Err(error);
            }
        };
        if answer.tag != Tag::Done {
            inner.reap();
            let number = i32::try_from(answer.numbers[0]).unwrap_or_default();
            let path = path.into_owned().into();
            return Err(GuardError::Watchdog { path, error: std::io::Error::from_raw_os_error(number) });
        }
        let lacks = MissingPrivileges::from_number(answer.numbers[0]);
        let last = AtomicInstant::at(HostInstant::now());
        Ok(GuardHandle { page, limit: settings.limit, lacks, last, inner: Mutex::new(inner) })
    }
}

impl OutputGuard for GuardHandle {
    fn replace(&self, device: &str, lines: Vec<OutputClaim>) -> Result<(), String> {
        GuardHandle::replace(self, device, lines).map_err(|error| error.to_string())
    }
}

/// A guard that watches this process. Dropping it is a goodbye, or, in a panic, a cry for help.
#[derive(Debug)]
pub struct GuardHandle {
    page: Page,
    limit: Span,
    lacks: MissingPrivileges,
    /// When the rig gave its last sign of life.
    last: AtomicInstant,
    inner: Mutex<Inner>,
}

#[derive(Debug)]
struct Inner {
    link: OwnedFd,
    child: Child,
    exit: OwnedFd,
    unstoppable: Option<Unstoppable>,
    /// The goodbye was said.
    closed: bool,
    /// The guard did not answer: what it says from now on belongs to no request.
    gone: bool,
}

impl GuardHandle {
    /// Gives these lines, and no others, into the guard's charge. They must be safe: the guard drives them to their
    /// safe levels and reads them back, which proves that it can.
    ///
    /// # Errors
    /// [`GuardError::Lines`], [`GuardError::Gone`], [`GuardError::Latched`].
    pub fn hold(&self, lines: Vec<OutputClaim>) -> Result<(), GuardError> {
        let mut inner = self.inner();
        self.done(inner.ask(&GuardMessage::new(Tag::Forget, [0; 4]), &[], self.patience())?)?;
        self.give(&mut inner, lines)
    }

    /// Gives these lines into the guard's charge in place of those of a device that is gone, also while the rig drives.
    /// They must be safe, and the rig does not drive them before this returns.
    ///
    /// # Errors
    /// As [`GuardHandle::hold`].
    pub fn replace(&self, gone: &str, lines: Vec<OutputClaim>) -> Result<(), GuardError> {
        let mut inner = self.inner();
        let release = GuardMessage::new(Tag::Release, [0; 4]).with(gone);
        self.done(inner.ask(&release, &[], self.patience())?)?;
        self.give(&mut inner, lines)
    }

    fn give(&self, inner: &mut Inner, lines: Vec<OutputClaim>) -> Result<(), GuardError> {
        for held in lines {
            let count = match held.api {
                LineApi::V1 { lines } => i64::from(lines),
                LineApi::V2 => 0,
                LineApi::Pwm => PWM,
            };
            let numbers = [count, held.mask.cast_signed(), held.safe.cast_signed(), 0];
            let message = GuardMessage::new(Tag::Hold, numbers).with(&held.device);
            let answer = inner.ask(&message, &[held.claim.as_fd()], self.patience())?;
            if answer.tag != Tag::Done && self.page.latched().is_none() {
                return Err(GuardError::Lines { device: held.device, why: answer.text().to_owned() });
            }
            self.done(answer)?;
        }
        Ok(())
    }

    /// From now on the rig drives, and gives a sign of life at least every [`GuardHandle::beat_every`]. The key that
    /// stops programs (Ctrl-Z) is ignored until [`GuardHandle::disarm`].
    ///
    /// # Errors
    /// [`GuardError::Gone`], [`GuardError::Latched`].
    pub fn arm(&self) -> Result<(), GuardError> {
        let mut inner = self.inner();
        inner.unstoppable = Unstoppable::new().ok();
        let now = HostInstant::now();
        self.page.rig_lives(now);
        self.last.set(now);
        let answer = inner.ask(&GuardMessage::new(Tag::Arm, [0; 4]), &[], self.patience())?;
        self.done(answer)
    }

    /// A sign of life. Never waits and makes no call but to the clock: for the executor's loop, and for nothing that
    /// lives on when that loop does not.
    pub fn beat(&self) -> HeartbeatState {
        let now = HostInstant::now();
        self.page.rig_lives(now);
        // A machine that stood still kept the guard from its sign of life, too: that time does not count.
        let stood = now - self.last.replace(now).unwrap_or(now) - self.beat_every();
        let silent = now - self.page.guard() - stood.max(Span::ZERO);
        match self.page.latched() {
            Some(reason) => HeartbeatState::Latched(reason),
            None if silent > self.limit => HeartbeatState::Unguarded,
            None => HeartbeatState::Kept,
        }
    }

    /// How often there must be a sign of life, well within the limit.
    pub fn beat_every(&self) -> Span {
        Span::from_nanos(self.limit.as_nanos() / BEATS)
    }

    /// The limit that the guard keeps.
    pub fn limit(&self) -> Span {
        self.limit
    }

    /// What the guard asked of the machine and did not get.
    pub fn lacks(&self) -> MissingPrivileges {
        self.lacks
    }

    /// The rig has made its outputs safe and drives no more. The guard drives them itself, too, and reads them back.
    ///
    /// # Errors
    /// [`GuardError::Unsafe`] where they are not safe: the guard then latches. [`GuardError::Gone`],
    /// [`GuardError::Latched`].
    pub fn disarm(&self) -> Result<(), GuardError> {
        let mut inner = self.inner();
        let answer = inner.ask(&GuardMessage::new(Tag::Disarm, [0; 4]), &[], self.patience());
        inner.unstoppable = None;
        self.safe(answer?)
    }

    /// The rig cannot make its outputs safe: the guard latches, drives them, and goes on driving them until this
    /// process is gone. The rig must not write any more.
    ///
    /// # Errors
    /// [`GuardError::Unsafe`] where the guard could not, either; [`GuardError::Gone`], [`GuardError::Latched`] where
    /// it had latched already.
    pub fn trip(&self) -> Result<(), GuardError> {
        let mut inner = self.inner();
        let answer = inner.ask(&GuardMessage::new(Tag::Trip, [0; 4]), &[], self.patience());
        inner.unstoppable = None;
        self.safe(answer?)
    }

    /// The goodbye: the guard makes the outputs safe once more, stops the watchdog, lets go of the lines and ends.
    ///
    /// # Errors
    /// [`GuardError::Unsafe`]: the guard stays, goes on trying, and lets the watchdog bite. [`GuardError::Gone`].
    pub fn close(&self) -> Result<(), GuardError> {
        let mut inner = self.inner();
        if std::mem::replace(&mut inner.closed, true) {
            return Ok(());
        }
        let answer = inner.ask(&GuardMessage::new(Tag::Close, [0; 4]), &[], self.patience());
        inner.unstoppable = None;
        let answer = answer?;
        if answer.tag != Tag::Done {
            return Err(GuardError::Unsafe { why: answer.text().to_owned() });
        }
        inner.reap();
        Ok(())
    }

    fn patience(&self) -> Span {
        self.limit + SLACK
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A request that only a latch can refuse.
    fn done(&self, answer: GuardMessage) -> Result<(), GuardError> {
        match (answer.tag, self.page.latched()) {
            (Tag::Done, _) => Ok(()),
            (_, Some(reason)) => Err(GuardError::Latched(reason)),
            (_, None) => Err(GuardError::Gone),
        }
    }

    /// A request that is refused with words where the outputs are not safe.
    fn safe(&self, answer: GuardMessage) -> Result<(), GuardError> {
        if answer.tag == Tag::Refused && !answer.text().is_empty() {
            return Err(GuardError::Unsafe { why: answer.text().to_owned() });
        }
        self.done(answer)
    }
}

impl Drop for GuardHandle {
    fn drop(&mut self) {
        // In a panic nobody knows what the rig's board still does: the guard latches, and sees this process die.
        let _ = if std::thread::panicking() && !self.inner().closed { self.trip() } else { self.close() };
    }
}

impl Inner {
    /// Asks and waits for the answer.
    fn ask(
        &mut self,
        message: &GuardMessage,
        descriptors: &[BorrowedFd],
        patience: Span,
    ) -> Result<GuardMessage, GuardError> {
        if self.gone {
            return Err(GuardError::Gone);
        }
        let sent = message.send(&self.link, descriptors);
        let answered = sent.is_ok() && is_ready(self.link.as_fd(), patience);
        match answered.then(|| GuardMessage::receive(&self.link)) {
            Some(Ok(Some((answer, _)))) => Ok(answer),
            _ => {
                self.gone = true;
                Err(GuardError::Gone)
            }
        }
    }

    /// Waits for the end of a guard that is ending; one that does not come to its end is left to the system.
    fn reap(&mut self) {
        if is_ready(self.exit.as_fd(), SLACK) {
            let _ = self.child.wait();
        }
    }
}

/// Ends a guard that has not started.
fn end(mut child: Child) {
    // One that has ended already cannot be killed, which is as well; a killed one ends as soon as the kernel lets it.
    let _ = child.kill();
    let _ = child.wait();
}

/// Waits until there is something to read or the time is over.
fn is_ready(descriptor: BorrowedFd, patience: Span) -> bool {
    let until = HostInstant::now() + patience;
    loop {
        let left = until.remaining().as_nanos();
        let left = Timespec { tv_sec: left / 1_000_000_000, tv_nsec: left % 1_000_000_000 };
        match poll(&mut [PollFd::from_borrowed_fd(descriptor, PollFlags::IN)], Some(&left)) {
            Err(Errno::INTR) => {}
            ready => return ready.is_ok_and(|count| count > 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_guard_that_gives_no_answer_when_it_starts_is_ended() {
        let number = std::env::temp_dir().join(format!("scanrig-no-guard-{}", std::process::id()));
        let mut program = Command::new("sh");
        // It closes the link and stays.
        program.args(["-c", "echo $$ > \"$0\"; exec 0<&-; exec sleep 1000"]).arg(&number);
        let refused = Guard::spawn_as(program, &GuardSettings::default()).map(drop);
        assert!(matches!(refused, Err(GuardError::Gone)), "{refused:?}");
        let process = std::fs::read_to_string(&number).expect("it began");
        std::fs::remove_file(number).expect("its number");
        assert!(!std::path::Path::new("/proc").join(process.trim()).exists(), "it is still there");
    }
}
