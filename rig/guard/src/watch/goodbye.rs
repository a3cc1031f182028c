//! The guard alone, after the death of its rig, and its end.

use super::{Ending, GuardLoop, WatchState, say};
use crate::Reason;
use crate::driver::Trouble;
use crate::takeover::{Listener, TakeoverRequest};
use host::HostInstant;
use signal::Span;

impl GuardLoop<'_> {
    /// The rig is gone since then: the lines are held, and let go when it is time.
    pub(super) fn alone(&mut self, since: HostInstant, now: HostInstant) -> Option<Ending> {
        let safe = self.are_safe(since);
        if !self.said && (safe || now >= since + self.limit) {
            self.said = true;
            self.say(safe, since);
            self.listener = Listener::open();
        }
        if safe {
            self.again = HostInstant::NEVER;
        }
        let over = self.drivers.is_empty() || self.release || now >= since + self.hold;
        // A call that has not come back may still come to a good end, however long it takes.
        let hangs = self.drivers.iter().any(|driver| driver.trouble(since) == Some(Trouble::Hangs));
        // Left to bite, the watchdog ends this process with the machine; until then the lines are held.
        let bites = self.watchdog.is_some() && self.starves(now);
        (over && !hangs && !bites && self.said).then_some(if safe { Ending::LetGo } else { Ending::Unsafe })
    }

    /// Reports to the user, who sees of the rig only that it is gone.
    fn say(&self, safe: bool, since: HostInstant) {
        let Some(reason) = self.page.latched() else { return };
        if self.drivers.is_empty() {
            // A rig that the guard has killed cannot say so itself.
            if reason == Reason::Unresponsive {
                say::report(&say::no_outputs(reason));
            }
            return;
        }
        let (latched, found) = self.page.times();
        let devices: Vec<&str> = self.drivers.iter().map(|driver| driver.device.as_str()).collect();
        say::report(&if safe {
            say::safe(
                reason,
                &devices,
                latched.zip(found).map_or(Span::ZERO, |(latched, found)| found - latched),
            )
        } else {
            say::not_safe(reason, &self.troubles(since), self.watchdog.is_some())
        });
    }

    /// A request of another rig, or of somebody who is none.
    pub(super) fn answer_takeover(&mut self) {
        let Some(takeover) = self.takeover.take() else { return };
        let WatchState::Alone(since) = self.state else { return };
        let devices = || self.drivers.iter().map(|driver| driver.device.as_str());
        match takeover.asks_for(devices()) {
            Some(true) if self.are_safe(since) => {
                for driver in self.drivers.drain(..) {
                    driver.let_go();
                }
                self.release = true;
                takeover.answer(true);
            }
            Some(_) => takeover.answer(false),
            None => drop::<TakeoverRequest>(takeover),
        }
    }

    /// Stops the watchdog: nobody has to be there any more.
    pub(super) fn stop_watchdog(&mut self) {
        if let Some(watchdog) = self.watchdog.take() {
            // One that cannot be stopped was refused at the start; one that breaks now bites.
            let _ = watchdog.watchdog.stop();
        }
    }

    /// Ends.
    pub(super) fn end(mut self, ending: Ending) -> Ending {
        self.stop_watchdog();
        for driver in self.drivers.drain(..) {
            driver.let_go();
        }
        ending
    }
}
