//! Priorities of threads: what must be on time goes before what can wait.

use crate::refused::{Privilege, Refused};
use rustix::io::Errno;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity, set_current_timer_slack};
use std::fmt;
use std::hint::black_box;
use std::io;
use std::num::NonZeroU64;

/// Stack that a thread has touched before it matters, in bytes: more than the loops of the rig ever need.
const STACK: usize = 256 * 1024;

/// What a thread is for; the order is that of their priorities, highest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ThreadRole {
    /// Takes edges from the kernel.
    Edges,
    /// Runs the scan loop with the steps of the plan.
    Scan,
    /// Talks to devices whose calls may last.
    Devices,
}

/// Processors by their numbers, from 0 to 1023. Empty: all that the rig may use.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct Processors([u64; 16]);

impl Processors {
    /// The most that a number can be.
    pub const MOST: u16 = 1023;

    /// These; numbers beyond [`Processors::MOST`] are left out.
    pub fn new(numbers: impl IntoIterator<Item = u16>) -> Processors {
        let mut all = Processors::default();
        for number in numbers {
            if let Some(word) = all.0.get_mut(usize::from(number / 64)) {
                *word |= 1 << (number % 64);
            }
        }
        all
    }

    /// Whether none is named.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|word| *word == 0)
    }

    /// Their numbers, rising.
    pub fn numbers(&self) -> impl Iterator<Item = u16> + '_ {
        (0..=Self::MOST).filter(|number| self.0[usize::from(number / 64)] >> (number % 64) & 1 == 1)
    }
}

impl fmt::Debug for Processors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.numbers()).finish()
    }
}

impl fmt::Display for Processors {
    /// `1, 3`; `all` where none is named.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, number) in self.numbers().enumerate() {
            write!(f, "{}{number}", if place == 0 { "" } else { ", " })?;
        }
        if self.is_empty() { f.write_str("all") } else { Ok(()) }
    }
}

/// How threads run: with real-time priority and on processors of their own, or as the host likes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Realtime {
    /// SCHED_FIFO priority of the scan loop, from 2 to 97: edges have one more, devices one less. `None`: no
    /// real-time priority.
    pub priority: Option<u8>,
    /// The processors that these threads stay on.
    pub processors: Processors,
}

impl Realtime {
    /// With this priority, on any processor.
    pub fn with_priority(priority: u8) -> Realtime {
        Realtime { priority: Some(priority), ..Realtime::default() }
    }

    /// The priority of a role.
    pub fn priority_of(self, role: ThreadRole) -> Option<u8> {
        self.priority.map(|priority| match role {
            ThreadRole::Edges => priority.saturating_add(1),
            ThreadRole::Scan => priority,
            ThreadRole::Devices => priority.saturating_sub(1),
        })
    }

    /// The calling thread becomes one of this role until it ends: its priority and processors, waits that end without
    /// slack, a stack that is in memory. What the kernel refuses is left out; the thread goes on all the same.
    ///
    /// # Errors
    /// The first that the kernel refused: without the privilege EPERM.
    pub fn enter(self, role: ThreadRole) -> io::Result<()> {
        self.ready(role).map_or(Ok(()), |refused| Err(refused.error.into()))
    }

    /// As [`Realtime::enter`], and the thread is as before when what comes back is dropped.
    pub fn enter_for_now(self, role: ThreadRole) -> Entered {
        let processors = if self.processors.is_empty() { None } else { sched_getaffinity(None).ok() };
        let refused = self.ready(role);
        Entered { processors, priority: self.priority.is_some(), refused, thread: std::marker::PhantomData }
    }

    /// Asks for all; the first that was refused.
    fn ready(self, role: ThreadRole) -> Option<Refused> {
        touch_stack();
        // Without a real-time priority the kernel lets waits end up to 50 us later than they are due.
        let _ = set_current_timer_slack(NonZeroU64::new(1));
        self.all(role).into_iter().flatten().next()
    }

    /// Which privileges the kernel refuses to a thread of this role, tried on a thread of its own.
    pub fn refused(self, role: ThreadRole) -> Vec<Refused> {
        let trial = std::thread::spawn(move || self.all(role).into_iter().flatten().collect());
        trial.join().unwrap_or_default()
    }

    fn all(self, role: ThreadRole) -> [Option<Refused>; 2] {
        let said = |what, answer: Result<(), Errno>| answer.err().map(|error| Refused { what, error });
        let processors = if self.processors.is_empty() { Ok(()) } else { stay_on(&self.processors) };
        let priority =
            self.priority_of(role).map_or(Ok(()), |priority| set_policy(libc::SCHED_FIFO, priority));
        [said(Privilege::Priority, priority), said(Privilege::Processors, processors)]
    }
}

/// A thread of a role, until this is dropped.
#[derive(Debug)]
#[must_use = "the thread is as before when this is dropped"]
pub struct Entered {
    processors: Option<CpuSet>,
    priority: bool,
    /// What the kernel refused, if anything.
    pub refused: Option<Refused>,
    /// It belongs to its thread.
    thread: std::marker::PhantomData<*const ()>,
}

impl Drop for Entered {
    fn drop(&mut self) {
        // What the thread was before it may be again: this asks for no privilege.
        if self.priority {
            let _ = set_policy(libc::SCHED_OTHER, 0);
        }
        if let Some(processors) = &self.processors {
            let _ = sched_setaffinity(None, processors);
        }
        // 0 is the slack that the thread was made with.
        let _ = set_current_timer_slack(None);
    }
}

/// The calling thread stays on these processors.
fn stay_on(processors: &Processors) -> Result<(), Errno> {
    let mut set = CpuSet::new();
    for number in processors.numbers() {
        let number = usize::from(number);
        if number >= CpuSet::MAX_CPU {
            return Err(Errno::INVAL);
        }
        set.set(number);
    }
    sched_setaffinity(None, &set)
}

/// Fetches the stack that will be needed, so that no access to it ever waits for memory.
#[inline(never)]
fn touch_stack() {
    let mut stack = [0u8; STACK];
    for page in stack.chunks_mut(4096) {
        page[0] = 1;
    }
    black_box(&stack);
}

/// The calling thread, and the threads that it starts from now on, take the highest real-time priority that they
/// may: for the guard, which sleeps until something is wrong.
///
/// # Errors
/// What the kernel says: without any privilege EPERM. The thread goes on as it was.
pub fn go_before_all() -> Result<(), Errno> {
    let allowed = rustix::process::getrlimit(rustix::process::Resource::Rtprio).current;
    let allowed = allowed.and_then(|allowed| u8::try_from(allowed).ok());
    set_policy(libc::SCHED_FIFO, HIGHEST).or_else(|refused| match allowed {
        Some(allowed @ 1..HIGHEST) => set_policy(libc::SCHED_FIFO, allowed),
        _ => Err(refused),
    })
}

/// The highest priority of SCHED_FIFO.
const HIGHEST: u8 = 99;

/// Neither std nor rustix sets a scheduling policy.
#[allow(unsafe_code)]
fn set_policy(policy: i32, priority: u8) -> Result<(), Errno> {
    let wanted = libc::sched_param { sched_priority: i32::from(priority) };
    // SAFETY: the structure is read only and lives for the whole call; 0 is the calling thread.
    match unsafe { libc::sched_setscheduler(0, policy, &raw const wanted) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error().raw_os_error().map_or(Errno::INVAL, Errno::from_raw_os_error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_priority_nothing_is_asked_of_the_kernel() {
        assert!(Realtime::default().enter(ThreadRole::Scan).is_ok());
        assert!(Realtime::default().refused(ThreadRole::Edges).is_empty());
    }

    #[test]
    fn edges_go_before_the_scan_and_the_scan_before_devices() {
        let of = |role| Realtime::with_priority(80).priority_of(role).unwrap();
        assert!(
            of(ThreadRole::Edges) > of(ThreadRole::Scan) && of(ThreadRole::Scan) > of(ThreadRole::Devices)
        );
    }

    #[test]
    fn a_processor_that_is_not_there_is_refused_and_named() {
        let nowhere = Realtime { processors: Processors::new([1023]), ..Realtime::default() };
        let refused = nowhere.refused(ThreadRole::Scan);
        assert_eq!(refused.iter().map(|refused| refused.what).collect::<Vec<_>>(), [Privilege::Processors]);
    }

    #[test]
    fn a_thread_is_as_before_when_its_role_ends() {
        let before = sched_getaffinity(None).unwrap();
        let first = (0..CpuSet::MAX_CPU).find(|cpu| before.is_set(*cpu)).unwrap() as u16;
        let one = Realtime { processors: Processors::new([first]), ..Realtime::default() };
        {
            let entered = one.enter_for_now(ThreadRole::Scan);
            assert_eq!(entered.refused, None);
            assert_eq!(sched_getaffinity(None).unwrap().count(), 1);
        }
        assert_eq!(sched_getaffinity(None).unwrap(), before);
    }

    #[test]
    fn processors_are_shown_by_their_numbers() {
        assert_eq!(Processors::new([3, 1]).to_string(), "1, 3");
        assert_eq!(Processors::default().to_string(), "all");
    }
}
