//! An alarm while the case runs.

use signal::{Span, Time, Value, When};

use super::{AlarmRule, ConditionState};

/// Follows an alarm's condition. Takes no memory while it does.
#[derive(Clone, Debug)]
pub struct AlarmWatch {
    rule: AlarmRule,
    delay: Span,
    phase: ConditionState,
    /// The case has begun.
    begun: bool,
    /// Since when the condition certainly holds, once the case has begun.
    since: Option<Time>,
    /// It was raised, and the condition has not been over since.
    raised: bool,
}

impl AlarmWatch {
    pub(super) fn new(rule: AlarmRule, delay: Span) -> AlarmWatch {
        AlarmWatch { rule, delay, phase: ConditionState::Off, begun: false, since: None, raised: false }
    }

    /// The case begins: what lasted before does not count.
    pub fn start(&mut self, at: Time) {
        self.begun = true;
        if self.phase == ConditionState::On {
            self.since = Some(at);
        }
    }

    /// The signal has this value from now on. TRUE where the condition ends by it and had lasted long enough.
    #[inline]
    pub fn see(&mut self, at: When, value: Value) -> bool {
        let phase = self.rule.next(self.phase, value);
        if phase == self.phase {
            return false;
        }
        self.phase = phase;
        let raised = self.is_due(at.earliest);
        self.raised |= raised;
        self.since = (phase == ConditionState::On && self.begun).then_some(at.latest);
        if phase == ConditionState::Off {
            self.raised = false;
        }
        raised
    }

    /// When it will be raised if nothing changes.
    #[inline]
    pub fn due(&self) -> Option<Time> {
        self.since.filter(|_| !self.raised).map(|since| since.saturating_add(self.delay))
    }

    fn is_due(&self, now: Time) -> bool {
        self.due().is_some_and(|due| due <= now)
    }

    /// It is `now`. TRUE where the alarm is raised at this instant.
    pub fn pass(&mut self, now: Time) -> bool {
        let raised = self.is_due(now);
        self.raised |= raised;
        raised
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Number;

    fn watch(delay: i64) -> AlarmWatch {
        AlarmWatch::new(AlarmRule::limit(true, Number::Int(6), Number::Int(5), 0.0), Span::from_nanos(delay))
    }

    fn at(nanos: i64) -> When {
        When::exactly(Time::from_nanos(nanos))
    }

    #[test]
    fn it_is_raised_once_when_the_condition_lasted() {
        let mut watch = watch(100);
        watch.start(Time::from_nanos(0));
        assert!(!watch.see(at(10), Value::Int(7)));
        assert_eq!(watch.due(), Some(Time::from_nanos(110)));
        assert!(!watch.see(at(50), Value::Int(5)));
        assert_eq!(watch.due(), None);
        assert!(!watch.see(at(60), Value::Int(7)));
        assert!(!watch.pass(Time::from_nanos(159)));
        assert!(watch.pass(Time::from_nanos(160)));
        assert!(!watch.pass(Time::from_nanos(161)) && watch.due().is_none());
        assert!(!watch.see(at(170), Value::Int(0)) && !watch.see(at(180), Value::Int(7)));
        assert!(watch.pass(Time::from_nanos(280)));
    }

    #[test]
    fn an_end_at_the_very_instant_is_too_late() {
        let mut watch = watch(100);
        watch.start(Time::from_nanos(0));
        watch.see(at(10), Value::Int(7));
        assert!(watch.see(at(110), Value::Int(0)));
    }

    #[test]
    fn what_lasted_before_the_start_does_not_count() {
        let mut watch = watch(100);
        watch.see(at(0), Value::Int(7));
        assert_eq!(watch.due(), None);
        watch.start(Time::from_nanos(1_000));
        assert_eq!(watch.due(), Some(Time::from_nanos(1_100)));
    }
}
