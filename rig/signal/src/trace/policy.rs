//! Which changes the trace keeps: recording policies at work.
//!
//! No policy makes the trace say something that was not so. With a deadband a signal is within the band around
//! what the trace says; a change that comes too soon makes the trace say that the value is not known, until the
//! time is over.

use crate::{Event, Policy, Sampling, SignalId, SignalInfo, Span, Time, Value, When};

/// Whether a change of a signal without a limit in time belongs into the trace.
#[inline]
pub(super) fn keeps(policy: Policy, last: Event, event: &Event) -> bool {
    let Policy::Deadband(band) = policy else { return true };
    if let (Some(old), Some(new)) = (last.value.as_int(), event.value.as_int()) {
        // Large whole numbers are floats only nearly.
        return old.abs_diff(new) > band as u128;
    }
    match (last.value.as_real(), event.value.as_real()) {
        // Not a number is no distance: such a change is kept.
        // What is known less well has to be said, as far as the band does not cover it.
        (Some(old), Some(new)) => {
            let wider = (event.value.uncertainty() - last.value.uncertainty()).max(0.0);
            (new - old).abs() + wider > band || (new - old).is_nan()
        }
        _ => true,
    }
}

/// A signal that changed again too soon.
#[derive(Clone, Copy, Debug)]
struct Wait {
    /// Its newest change.
    event: Event,
    /// When the time is over.
    due: Time,
    /// Up to here a change from before `due` can become known.
    open: Time,
}

/// The signals of [`Policy::AtMostEvery`] whose values wait to be recorded.
#[derive(Debug)]
pub(super) struct HeldChange {
    list: Vec<Wait>,
    /// Signals that may have to wait.
    most: usize,
    /// Nothing can be taken up to here: all that is looked at where nobody waits.
    quiet: Time,
}

impl HeldChange {
    pub(super) const fn new() -> HeldChange {
        HeldChange { list: Vec::new(), most: 0, quiet: Time::MAX }
    }

    /// Makes room for one more signal, so that recording never allocates.
    pub(super) fn add_signal(&mut self) {
        self.most += 1;
        self.list.reserve(self.most - self.list.len());
    }

    /// Memory that the list takes.
    pub(super) fn bytes(&self) -> usize {
        self.list.capacity() * size_of::<Wait>()
    }

    /// What is to be recorded of a change: itself, that the value is not known from here on, or nothing.
    pub(super) fn admit(
        &mut self,
        info: &SignalInfo,
        span: Span,
        last: Option<Event>,
        event: Event,
    ) -> Option<Event> {
        if let Some(at) = self.place(event.signal) {
            if event.at.earliest < self.list[at].due {
                self.list[at].event = event;
                return None;
            }
            self.remove(at);
            return Some(event);
        }
        let last = match last {
            Some(last) if last.value == event.value => return None,
            Some(last) => last,
            None => return Some(event),
        };
        let due = last.at.earliest.saturating_add(span);
        if event.at.earliest >= due {
            return Some(event);
        }
        let lag = match info.sampling {
            Sampling::Edges { resolution } => resolution,
            Sampling::Sampled { period } => period,
        };
        let open = due.saturating_add(lag);
        self.quiet = self.quiet.min(open);
        self.list.push(Wait { event, due, open });
        Some(Event { value: Value::Unknown, ..event })
    }

    /// The value that has waited longest for its time to be over before `now`, as it is then.
    #[inline]
    pub(super) fn take(&mut self, now: Time) -> Option<Event> {
        if now <= self.quiet {
            return None;
        }
        let over = self.list.iter().enumerate().filter(|(_, wait)| wait.open < now);
        let (at, _) = over.min_by_key(|(_, wait)| wait.due)?;
        let Wait { event, due, .. } = self.remove(at);
        let at = When::within(event.at.earliest.max(due), event.at.latest.max(due));
        Some(Event { at, ..event })
    }

    fn place(&self, signal: SignalId) -> Option<usize> {
        self.list.iter().position(|wait| wait.event.signal == signal)
    }

    fn remove(&mut self, at: usize) -> Wait {
        let wait = self.list.remove(at);
        self.quiet = self.list.iter().map(|wait| wait.open).min().unwrap_or(Time::MAX);
        wait
    }
}
