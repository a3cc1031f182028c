//! The judge of an alarm: did its condition last too long, in every placement of the events or in some?
//!
//! Two stretches are followed: that in which the condition certainly holds and that in which it may. A stretch that
//! certainly holds from its latest beginning to its earliest end for the delay is a raised alarm; one that may hold
//! from its earliest beginning to its latest end for as long may be one.

use record::Figure;
use signal::{SignalInfo, Span, Value};

use super::{Alarm, AlarmRule, ConditionState};
use crate::expect::{delay_words, span_range, unclear};
use crate::lang::Anchor;
use crate::monitor::{Finding, Monitor, TimedValue, UncertainWindow};

/// A time for which the condition lasted.
#[derive(Clone, Copy, Debug)]
struct ConditionTime {
    start: TimedValue,
    /// Least and greatest length, nanoseconds.
    length: (i64, i64),
    /// Whether it ended before the case did.
    over: bool,
}

/// The judge.
pub(super) struct AlarmMonitor {
    alarm: Alarm,
    rule: AlarmRule,
    info: SignalInfo,
    window: UncertainWindow,
    /// The end of the case is still to come.
    open: bool,
    phase: ConditionState,
    /// The change since which the condition certainly holds.
    certain: Option<TimedValue>,
    /// The change since which it may.
    possible: Option<TimedValue>,
    /// The first stretch that raised the alarm, the first that may have, and the longest other one.
    raised: Option<ConditionTime>,
    doubtful: Option<ConditionTime>,
    longest: Option<ConditionTime>,
    /// The value that was nearest to the limit.
    nearest: Option<(f64, TimedValue)>,
    last: Option<TimedValue>,
}

impl AlarmMonitor {
    pub(super) fn new(
        alarm: &Alarm,
        rule: AlarmRule,
        info: &SignalInfo,
        window: UncertainWindow,
        open: bool,
    ) -> AlarmMonitor {
        AlarmMonitor {
            alarm: alarm.clone(),
            rule,
            info: info.clone(),
            window,
            open,
            phase: ConditionState::Unknown,
            certain: None,
            // Nothing is known before the first event.
            possible: Some(TimedValue::NOTHING),
            raised: None,
            doubtful: None,
            longest: None,
            nearest: None,
            last: None,
        }
    }

    /// The part of a stretch that lies in the window: least and greatest length, and whether it lies there in every
    /// placement. At the instants of `start` and `end` themselves the order of the trace counts.
    fn length(&self, start: &TimedValue, end: Option<&TimedValue>) -> Option<((i64, i64), bool)> {
        let (from, until) = (&self.window.from, &self.window.until);
        let (least_end, most_end) =
            end.map_or((until.a, until.b), |end| (end.a.min(until.a), end.b.min(until.b)));
        let most = most_end.saturating_sub(start.a.max(from.a));
        let least = least_end.saturating_sub(start.b.max(from.b));
        let can =
            start.before(until) <= until.b && end.is_none_or(|end| end.after(from) >= from.a) && most >= 0;
        let begun = start.b.saturating_add(i64::from(start.place >= until.place)) <= until.a;
        let over = |end: &TimedValue| end.a.saturating_sub(i64::from(end.place < from.place)) >= from.b;
        can.then(|| ((least, most), begun && end.is_none_or(over)))
    }

    /// The condition no longer certainly holds.
    fn end_certain(&mut self, end: Option<&TimedValue>) {
        let Some(start) = self.certain.take() else { return };
        let Some((length, inside)) = self.length(&start, end) else { return };
        let lasted = ConditionTime { start, length, over: end.is_some() };
        if inside && length.0 >= self.alarm.delay.as_nanos() {
            self.raised.get_or_insert(lasted);
        } else if self.longest.is_none_or(|longest| longest.length.1 < length.1) {
            self.longest = Some(lasted);
        }
    }

    /// The condition no longer may hold.
    fn end_possible(&mut self, end: Option<&TimedValue>) {
        let Some(start) = self.possible.take() else { return };
        let Some((length, _)) = self.length(&start, end) else { return };
        if length.1 >= self.alarm.delay.as_nanos() {
            self.doubtful.get_or_insert(ConditionTime { start, length, over: end.is_some() });
        }
    }

    /// The value until `end` was the last one.
    fn note(&mut self, end: i64) {
        let Some(last) = self.last else { return };
        let Some(margin) = self.rule.margin(last.value) else { return };
        let nearer = self.nearest.is_none_or(|(least, _)| margin < least);
        if nearer && self.window.can_meet(last.a, end) {
            self.nearest = Some((margin, last));
        }
    }

    /// When the alarm was raised, in words.
    fn raised_words(&self, lasted: &ConditionTime) -> String {
        let (from, delay) = (&self.window.from, self.alarm.delay.as_nanos());
        let least = lasted.start.a.max(from.a).saturating_sub(from.b).max(0).saturating_add(delay);
        let most = lasted.start.b.max(from.b).saturating_sub(from.a).saturating_add(delay);
        format!("the alarm was raised {}", delay_words((least, most), &Anchor::START))
    }

    fn described(&self, lasted: &ConditionTime) -> String {
        let least = lasted.length.0.max(0);
        let most = lasted.length.1;
        let from = &self.window.from;
        let start = &lasted.start;
        let delay = (start.a.saturating_sub(from.b).max(0), start.b.saturating_sub(from.a).max(0));
        let lasting = match lasted.over {
            true => format!("for {}", span_range((least, most))),
            false => format!("for {} until the end", span_range((least, most))),
        };
        format!("{} {lasting}, from {}", self.alarm.words(), delay_words(delay, &Anchor::START))
    }
}

impl Monitor for AlarmMonitor {
    #[inline]
    fn feed(&mut self, _slot: usize, seen: &TimedValue) {
        if self.open {
            self.window.advance(seen.a);
        }
        self.note(seen.b);
        // The first value that is known is beyond the limit or not: there was none to come back from.
        let before = if self.last.is_some() { self.phase } else { ConditionState::Off };
        let phase = self.rule.next(before, seen.value);
        self.last = Some(*seen);
        if phase == self.phase {
            return;
        }
        self.end_certain(Some(seen));
        if phase == ConditionState::Off {
            self.end_possible(Some(seen));
        } else {
            self.possible.get_or_insert(*seen);
        }
        if phase == ConditionState::On {
            self.certain = Some(*seen);
        }
        self.phase = phase;
    }

    fn lost(&mut self, now: i64) -> bool {
        if self.open {
            self.window.advance(now);
        }
        // What lasts now ends now at the earliest.
        let lasts = self.certain.and_then(|start| self.length(&start, None));
        let delay = self.alarm.delay.as_nanos();
        self.raised.is_some()
            || lasts.is_some_and(|((least, _), inside)| inside && least >= delay)
                && self.certain.is_some_and(|start| now.saturating_sub(start.b) >= delay)
    }

    fn finish(mut self: Box<Self>) -> Finding {
        self.note(i64::MAX);
        self.end_certain(None);
        self.end_possible(None);
        let mut finding = Finding {
            can_hold: self.raised.is_none(),
            can_break: self.raised.is_some() || self.doubtful.is_some(),
            window: Some(self.window.shown()),
            ..Finding::default()
        };
        let shown = self.raised.or(self.longest);
        finding.observed = match &shown {
            Some(lasted) => self.described(lasted),
            None => String::from("it was not raised"),
        };
        finding.reason = match (&self.raised, &self.doubtful) {
            (Some(lasted), _) => self.raised_words(lasted),
            (None, Some(doubtful))
                if matches!(doubtful.start.value, Value::Unknown | Value::Measured(..))
                    && self.rule.next(ConditionState::Off, doubtful.start.value)
                        == ConditionState::Unknown =>
            {
                unclear(&self.info, doubtful.start.value, "the case")
            }
            (None, Some(_)) => {
                String::from("whether it lasted long enough is within the uncertainty of the instants")
            }
            (None, None) => String::new(),
        };
        let delay = self.alarm.delay.as_nanos();
        finding.margin = match (&shown, self.nearest) {
            (Some(lasted), _) if self.raised.is_some() || delay > 0 => {
                Some(Figure::span(Span::from_nanos(delay.saturating_sub(lasted.length.1))))
            }
            (_, Some((margin, _))) => Some(Figure::new(margin, self.info.unit.clone())),
            _ => None,
        };
        match (shown, self.nearest) {
            (Some(lasted), _) => finding.decided_by(&lasted.start),
            (None, Some((_, seen))) => finding.decided_by(&seen),
            (None, None) => finding,
        }
    }
}
