//! Requests of the rig that are answered when the lines are safe, or not in time.

use super::{GuardLoop, WatchState};
use crate::Reason;
use crate::driver::{Driver, Trouble};
use crate::wire::{GuardMessage, Tag};
use host::HostInstant;
use signal::Span;

/// How long lines may take to be found safe where the rig waits for it and does not drive: a busy
/// machine is no fault of theirs.
const PATIENCE: Span = Span::from_secs(1);

/// A request that waits for the lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct PendingRequest {
    what: Tag,
    /// Drives that began before do not count.
    since: HostInstant,
    /// When it is answered in any case.
    pub until: HostInstant,
}

impl GuardLoop<'_> {
    /// Drives the lines safe, and answers when they are. While the rig drives, lines that are new are driven alone.
    pub(super) fn expect(&mut self, what: Tag, now: HostInstant) {
        let until = now + self.limit.max(PATIENCE);
        self.pending = Some(PendingRequest { what, since: now, until });
        match self.drivers.last().filter(|_| self.state == WatchState::Armed) {
            Some(new) => new.order(),
            None => self.drive(now),
        }
    }

    /// Whether the lines that a request is about are safe since then.
    fn is_met(&self, pending: &PendingRequest) -> bool {
        let since = pending.since;
        match pending.what {
            Tag::Hold => self.drivers.last().is_none_or(|new| new.is_safe(since)),
            // A device that is gone can be driven by nobody, and the rig knows that it is: between two cases the others
            // stay what the rig may drive.
            Tag::Disarm => self.drivers.iter().all(|driver| driver.is_safe(since) || driver.is_gone(since)),
            _ => self.are_safe(since),
        }
    }

    /// Answers a request that can be answered. TRUE where it was the goodbye.
    pub(super) fn answer(&mut self, now: HostInstant) -> bool {
        let Some(pending) = self.pending else { return false };
        // An order that is still under way would undo what the rig does with the answer.
        let safe = self.is_met(&pending) && self.drivers.iter().all(Driver::is_idle);
        if !safe && now < pending.until {
            return false;
        }
        self.pending = None;
        if !matches!(self.state, WatchState::Latched(_)) {
            self.again = HostInstant::NEVER;
        }
        if safe {
            // The watchdog is stopped before the rig hears that the guard is done.
            if pending.what == Tag::Close {
                self.stop_watchdog();
            }
            self.reply(Tag::Done, "");
            return pending.what == Tag::Close;
        }
        let mut why = self.troubles(pending.since);
        if why.is_empty() {
            why = Trouble::Hangs.to_string();
        }
        self.reply(Tag::Refused, &why);
        match pending.what {
            // The lines never came into the guard's charge.
            Tag::Hold => {
                if let Some(driver) = self.drivers.pop() {
                    driver.let_go();
                }
            }
            _ => self.latch(Reason::Unsafe, now),
        }
        false
    }

    /// Which devices are not known to be safe, and why.
    pub(super) fn troubles(&self, since: HostInstant) -> String {
        let troubles = self.drivers.iter().filter_map(|driver| {
            driver.trouble(since).map(|trouble| format!("{}: {trouble}", driver.device))
        });
        troubles.collect::<Vec<_>>().join("; ")
    }

    /// Answers the rig. One that does not listen is either gone or hangs, and both are noticed elsewhere.
    pub(super) fn reply(&self, tag: Tag, text: &str) {
        if let Some(link) = &self.link {
            let _ = GuardMessage::new(tag, [0; 4]).with(text).send(link, &[]);
        }
    }
}
