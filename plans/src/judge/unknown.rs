//! Why a signal was not known: the stretches for which its board gave a reason.

use record::Window;
use signal::{Cause, Event, SignalGap, Span, Value};

/// Stretches that are kept of a signal. A sentence names one; those after are for windows that lie after it.
const MOST: usize = 64;

/// A stretch in which a signal was not known.
#[derive(Clone, Copy, Debug, PartialEq)]
struct UnknownStretch {
    gap: SignalGap,
    /// Its earliest and latest beginning, nanoseconds.
    from: [i64; 2],
    /// Its latest end, nanoseconds; `i64::MAX` while it lasts.
    until: i64,
}

/// When a signal was not known, and why.
#[derive(Clone, Debug, Default)]
pub(super) struct UnknownTimes {
    stretches: Vec<UnknownStretch>,
    /// The last one goes on.
    lasts: bool,
}

impl UnknownTimes {
    /// The next event of the signal.
    #[inline]
    pub(super) fn see(&mut self, event: &Event) {
        if self.lasts || matches!(event.value, Value::Unknown) {
            self.note(event);
        }
    }

    fn note(&mut self, event: &Event) {
        let [from, until] = [event.at.earliest.as_nanos(), event.at.latest.as_nanos()];
        if let (true, Some(last)) = (std::mem::take(&mut self.lasts), self.stretches.last_mut()) {
            last.until = until;
        }
        if let (Value::Unknown, Cause::Gap(gap)) = (event.value, event.cause)
            && self.stretches.len() < MOST
        {
            self.stretches.push(UnknownStretch { gap, from: [from, until], until: i64::MAX });
            self.lasts = true;
        }
    }

    /// The first stretch that can touch a window; without one the first of all.
    fn within(&self, window: Option<&Window>) -> Option<&UnknownStretch> {
        let touches = |stretch: &&UnknownStretch| {
            window.is_none_or(|window| {
                stretch.from[0] <= window.until_ns[1] && stretch.until >= window.from_ns[0]
            })
        };
        self.stretches.iter().find(touches)
    }
}

/// Adds to the reason of an open verdict why its signals were not known then, where a board reasons: `the value is not
/// known at end (`pressure` from 1.2 s: its wire is open)`.
pub(super) fn add_why<'a>(
    signals: impl Iterator<Item = (&'a str, &'a UnknownTimes)>,
    window: Option<&Window>,
    reason: &mut String,
) {
    let mut reasons = Vec::new();
    for (name, unknown) in signals {
        if let Some(stretch) = unknown.within(window) {
            let from = Span::from_nanos(stretch.from[1]);
            reasons.push(format!("`{name}` from {from}: {}", stretch.gap));
        }
    }
    if !reasons.is_empty() {
        reason.push_str(&format!(" ({})", reasons.join("; ")));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use signal::{SignalId, Time, When};

    fn event(ms: i64, value: Value, cause: Cause) -> Event {
        let at = When::exactly(Time::from_nanos(ms * 1_000_000));
        Event { signal: SignalId(0), at, value, cause }
    }

    fn why(unknown: &UnknownTimes, [from, until]: [i64; 2]) -> String {
        let ns = |ms: i64| [ms * 1_000_000; 2];
        let window = Window { from_ns: ns(from), until_ns: ns(until), ..Window::default() };
        let mut reason = String::from("open");
        add_why([("p", unknown)].into_iter(), Some(&window), &mut reason);
        reason
    }

    #[test]
    fn the_reason_is_that_of_the_stretch_that_the_window_meets() {
        let mut unknown = UnknownTimes::default();
        for event in [
            event(0, Value::Real(1.0), Cause::Board),
            event(10, Value::Unknown, Cause::Gap(SignalGap::OpenWire)),
            event(20, Value::Real(1.0), Cause::Board),
            event(30, Value::Unknown, Cause::Board),
            event(40, Value::Unknown, Cause::Gap(SignalGap::Above)),
        ] {
            unknown.see(&event);
        }
        assert_eq!(why(&unknown, [0, 9]), "open");
        assert_eq!(why(&unknown, [15, 15]), "open (`p` from 10 ms: its wire is open)");
        assert_eq!(why(&unknown, [21, 39]), "open", "nobody said why");
        assert_eq!(
            why(&unknown, [50, 60]),
            "open (`p` from 40 ms: at the upper end of its range there may be more)"
        );
    }

    #[test]
    fn a_signal_that_comes_and_goes_keeps_a_bounded_list() {
        let mut unknown = UnknownTimes::default();
        for ms in 0..1_000 {
            unknown.see(&event(2 * ms, Value::Unknown, Cause::Gap(SignalGap::Below)));
            unknown.see(&event(2 * ms + 1, Value::Real(1.0), Cause::Board));
        }
        assert_eq!(unknown.stretches.len(), MOST);
        assert_eq!(why(&unknown, [1_900, 1_910]), "open");
    }
}
