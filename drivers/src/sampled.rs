//! What converters and counters have in common: devices that are read now and then, and that drive nothing.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use host::{AtomicInstant, HostInstant};
use signal::Span;

use crate::device_board::Reopen;
use crate::thread::Reporter;

/// What board and thread share of the runs of such a device. Whoever asks for something wakes the thread.
#[derive(Debug)]
pub(crate) struct SampleControl {
    /// A run goes on: the device is to be read.
    active: AtomicBool,
    /// Number of starts asked for.
    starts: AtomicU64,
    /// Since when an answer of the device is due.
    pub(crate) waits_since: AtomicInstant,
}

impl Default for SampleControl {
    fn default() -> SampleControl {
        SampleControl {
            active: AtomicBool::new(false),
            starts: AtomicU64::new(0),
            waits_since: AtomicInstant::none(),
        }
    }
}

impl SampleControl {
    /// Asks for a new run. The number of this request.
    pub(crate) fn ask_start(&self) -> u64 {
        let start = self.starts.fetch_add(1, Ordering::AcqRel) + 1;
        self.active.store(true, Ordering::Release);
        start
    }

    /// Asks for the end of the run: the device rests until the next start.
    pub(crate) fn ask_rest(&self) {
        self.active.store(false, Ordering::Release);
    }

    /// Until when an answer is due, of which each may take so long.
    pub(crate) fn due(&self, limit: Span) -> Option<HostInstant> {
        Some(self.waits_since.get()? + limit)
    }

    /// Whether a run goes on.
    pub(crate) fn is_active(&self) -> bool {
        self.active.load(Ordering::Acquire)
    }
}

/// The thread's end of such a device: when it is read, given up and opened again.
pub(crate) struct Sampler<D: ?Sized, R> {
    /// The device; none while it is gone.
    pub(crate) device: Option<Box<D>>,
    reopen: Reopen<D>,
    pub(crate) control: Arc<SampleControl>,
    pub(crate) reporter: Reporter<R>,
    /// A device that was gone is opened again.
    reconnect: bool,
    started: u64,
    /// Whether the start has been answered.
    answered: bool,
    /// When the next reading is due.
    due: HostInstant,
}

/// What a thread has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleTurn {
    /// Nothing, until somebody wakes it.
    Rest,
    /// Nothing, until the next reading is due.
    Wait,
    /// The device is to be read.
    Read,
    /// The device is gone: it may be there again.
    Reopen,
}

impl<D: ?Sized, R> Sampler<D, R> {
    pub(crate) fn new(
        device: Box<D>,
        reopen: Reopen<D>,
        control: Arc<SampleControl>,
        reporter: Reporter<R>,
        reconnect: bool,
    ) -> Sampler<D, R> {
        let device = Some(device);
        Sampler {
            device,
            reopen,
            control,
            reporter,
            reconnect,
            started: 0,
            answered: true,
            due: HostInstant::BOOT,
        }
    }

    /// TRUE once for every start that was asked for: what was before is forgotten.
    pub(crate) fn starts(&mut self) -> bool {
        let starts = self.control.starts.load(Ordering::Acquire);
        if starts == self.started {
            return false;
        }
        (self.started, self.answered) = (starts, false);
        self.reporter.works();
        self.read_at_once();
        true
    }

    /// The next reading, or the next look for a device that is gone, is due now.
    pub(crate) fn read_at_once(&mut self) {
        self.due = HostInstant::now();
    }

    /// What is to be done now.
    pub(crate) fn turn(&mut self, now: HostInstant) -> SampleTurn {
        if !self.control.is_active() {
            self.control.waits_since.clear();
            return SampleTurn::Rest;
        }
        match self.device {
            _ if now < self.due => SampleTurn::Wait,
            Some(_) => SampleTurn::Read,
            None => SampleTurn::Reopen,
        }
    }

    /// Until when a thread waits that has done this.
    pub(crate) fn waits_until(&self, turn: SampleTurn) -> HostInstant {
        if turn == SampleTurn::Rest { HostInstant::NEVER } else { self.due }
    }

    /// The device was read. The next reading is as often as asked for on the whole; what was slept through is not made up for.
    pub(crate) fn was_read(&mut self, period: Span, after: HostInstant) {
        self.due += period;
        if self.due <= after {
            self.due = after + period;
        }
    }

    /// Answers the start by this report, once for each.
    pub(crate) fn answer_start(&mut self, report: impl FnOnce(u64) -> R) {
        if !self.answered {
            self.answered = true;
            self.reporter.insist(report(self.started));
        }
    }

    /// A call failed. Gives the device up where it is not there any more, or has failed for too long.
    pub(crate) fn refused(&mut self, error: &io::Error) {
        if self.reporter.refused(error) {
            self.device = None;
            self.control.waits_since.clear();
            self.due = HostInstant::now() + self.reporter.limit();
        }
    }

    /// Whether a device that was gone is there again: then it is read at once.
    pub(crate) fn reopen(&mut self, now: HostInstant) -> bool {
        self.due = if self.reconnect { now + self.reporter.limit() } else { HostInstant::NEVER };
        if self.reconnect {
            self.device = self.reopen.open();
        }
        if self.device.is_some() {
            self.read_at_once();
        }
        self.device.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thread::ends;
    use rustix::io::Errno;

    const LIMIT: Span = Span::from_secs(1);

    fn sampler(reconnect: bool) -> Sampler<u32, u64> {
        let (reporter, _, _) = ends(4, &Arc::default(), LIMIT);
        Sampler::new(Box::new(1), Reopen::new(|| Some(Box::new(2))), Arc::default(), reporter, reconnect)
    }

    #[test]
    fn a_device_is_read_while_a_run_goes_on_and_rests_after_it() {
        let mut sampler = sampler(true);
        assert_eq!((sampler.starts(), sampler.turn(HostInstant::now())), (false, SampleTurn::Rest));
        assert_eq!(sampler.waits_until(SampleTurn::Rest), HostInstant::NEVER);
        assert_eq!(sampler.control.ask_start(), 1);
        assert!(sampler.starts() && !sampler.starts());
        assert_eq!(sampler.turn(HostInstant::now()), SampleTurn::Read);
        // Slept through two periods: the next reading is a period from now.
        let after = sampler.due + Span::from_millis(25);
        sampler.was_read(Span::from_millis(10), after);
        assert_eq!(sampler.turn(after), SampleTurn::Wait);
        assert_eq!(sampler.waits_until(SampleTurn::Wait), after + Span::from_millis(10));
        sampler.control.ask_rest();
        assert_eq!(sampler.turn(HostInstant::NEVER), SampleTurn::Rest);
    }

    #[test]
    fn a_device_that_is_gone_is_opened_again_where_the_file_says_so() {
        for reconnect in [false, true] {
            let mut sampler = sampler(reconnect);
            sampler.control.ask_start();
            sampler.refused(&io::Error::from(Errno::NODEV));
            assert!(sampler.device.is_none());
            assert_eq!(sampler.turn(HostInstant::now()), SampleTurn::Wait);
            let later = HostInstant::now() + LIMIT;
            assert_eq!(sampler.turn(later), SampleTurn::Reopen);
            assert_eq!(sampler.reopen(later), reconnect);
            // It is read at once, or never looked for again.
            let turn = if reconnect { SampleTurn::Read } else { SampleTurn::Wait };
            assert_eq!(sampler.turn(HostInstant::now()), turn);
        }
    }
}
