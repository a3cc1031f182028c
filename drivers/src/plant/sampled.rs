//! The analog value of a plant: its course, the samples that its output shows, and the comparators on it.

use signal::{Span, Time, Value};

use super::decimals::{Decimals, ShownRange};
use super::switches::{SwitchSpec, Switches};
use crate::course::Course;

/// Nanoseconds between two instants, held at the range and at 0.
fn elapsed(from: Time, to: Time) -> i64 {
    to.as_nanos().saturating_sub(from.as_nanos()).max(0)
}

/// A value that goes on by a course. Its output shows samples on a grid from the start, which end while the value stays.
#[derive(Clone, Debug)]
pub(super) struct SampledValue {
    course: Course,
    switches: Switches,
    sample: Span,
    started: Time,
    next: Option<Time>,
    range: Option<ShownRange>,
    rests_at: Option<Decimals>,
}

impl SampledValue {
    /// A value with these comparators; its outputs are the samples, then the comparators.
    pub(super) fn new(sample: Span, switches: &[SwitchSpec]) -> SampledValue {
        let course = Course::constant(Time::ZERO, 0.0);
        let (switches, started) = (Switches::new(switches), Time::ZERO);
        SampledValue { course, switches, sample, started, next: None, range: None, rests_at: None }
    }

    /// The same of a value with a range.
    pub(super) fn within(self, range: ShownRange) -> SampledValue {
        SampledValue { range: Some(range), switches: self.switches.eased(range.room()), ..self }
    }

    /// The same of a value that comes to rest at such numbers.
    pub(super) fn resting_at(self, decimals: Decimals) -> SampledValue {
        SampledValue { rests_at: Some(decimals), ..self }
    }

    /// What the output shows of a value of this course.
    fn shown(&self, course: &Course, value: f64) -> f64 {
        match (self.range, self.rests_at) {
            (Some(range), _) => range.shown(value),
            (_, Some(decimals)) if course.is_settled_with(value) => decimals.nearest(value),
            _ => value,
        }
    }

    pub(super) fn course(&self) -> &Course {
        &self.course
    }

    pub(super) fn start(&mut self, now: Time, course: Course, outputs: &mut [Value]) {
        self.started = now;
        self.next = None;
        let value = course.value(now);
        outputs[0] = Value::Real(self.shown(&course, value));
        self.switches.start(value, &mut outputs[1..]);
        self.go_on(now, course, outputs[0]);
    }

    /// The value goes on by another course, from where it is; `shown` is what its output shows.
    pub(super) fn go_on(&mut self, now: Time, course: Course, shown: Value) {
        self.course = course;
        self.switches.plan(now, &course);
        // A sample that is due at the very instant of the change still comes then.
        if self.next.is_none_or(|due| due > now) {
            self.plan_sample(now, shown);
        }
    }

    /// The value goes on by another course, from another value: its output shows that at once.
    pub(super) fn jump(&mut self, now: Time, course: Course, output: &mut Value) {
        *output = Value::Real(self.shown(&course, course.value(now)));
        self.next = None;
        self.go_on(now, course, *output);
    }

    /// The value goes on by another course, and nothing is sampled of it until it is followed again.
    pub(super) fn pause(&mut self, course: Course) {
        self.course = course;
        self.next = None;
    }

    fn plan_sample(&mut self, now: Time, shown: Value) {
        // The value of some courses takes time, and it is not asked for twice.
        let value = self.course.value(now);
        self.next = if self.stays(value, shown) { None } else { self.grid(now, 1) };
    }

    /// Whether it stays at this value, which it has, and that is shown.
    fn stays(&self, value: f64, shown: Value) -> bool {
        shown.as_real() == Some(self.shown(&self.course, value)) && self.course.is_settled_with(value)
    }

    /// The instant of the grid after one of its own.
    fn sample_after(&self, at: Time) -> Option<Time> {
        at.as_nanos().checked_add(self.sample.as_nanos()).map(Time::from_nanos)
    }

    /// The instant of the grid so many samples after the last one up to `now`.
    fn grid(&self, now: Time, more: i64) -> Option<Time> {
        let sample = self.sample.as_nanos();
        let at = (elapsed(self.started, now) / sample).checked_add(more)?.checked_mul(sample)?;
        self.started.as_nanos().checked_add(at).map(Time::from_nanos)
    }

    pub(super) fn next(&self) -> Option<Time> {
        self.next.into_iter().chain(self.switches.next()).min()
    }

    /// Shows what is due at `now`.
    pub(super) fn advance(&mut self, now: Time, outputs: &mut [Value]) {
        if self.next == Some(now) {
            let value = self.course.value(now);
            outputs[0] = Value::Real(self.shown(&self.course, value));
            self.next = if self.stays(value, outputs[0]) { None } else { self.sample_after(now) };
        } else if self.next.is_some_and(|due| due <= now) {
            // Where a call spans several samples the output is the newest of them.
            let at = self.grid(now, 0).unwrap_or(now).max(self.course.since());
            outputs[0] = Value::Real(self.shown(&self.course, self.course.value(at)));
            self.plan_sample(now, outputs[0]);
        }
        self.switches.advance(now, &self.course, &mut outputs[1..]);
    }
}
