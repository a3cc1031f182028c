//! First-order lag with comparators, in closed form.

use signal::{Span, Time, Value};

use super::Plant;
use crate::circuit::{LagSpec, LagTarget};

/// Time constants after which the value is the target.
const SETTLED: i64 = 40;

/// `y(t) = target + (y0 - target) exp(-(t - t0) / tau)`, sampled for its output, with switches at the computed
/// instants of crossing.
///
/// Input 0 sets the target. Output 0 is the value, sampled every `sample` from the start; outputs 1 and up are
/// the switches, by the true value and not by its samples.
#[derive(Debug)]
pub struct Lag {
    target_of: LagTarget,
    initial: f64,
    tau: Span,
    sample: Span,
    switches: Vec<Switch>,
    started: Time,
    since: Time,
    from: f64,
    target: f64,
    next_sample: Option<Time>,
    outputs: Vec<Value>,
}

#[derive(Clone, Copy, Debug)]
struct Switch {
    on_above: f64,
    off_below: f64,
    on: bool,
    flips: Option<Time>,
}

impl Lag {
    /// The lag of a checked description, not started.
    pub fn new(spec: &LagSpec) -> Self {
        let switch = |spec: &crate::circuit::SwitchSpec| Switch {
            on_above: spec.on_above,
            off_below: spec.off_below,
            on: false,
            flips: None,
        };
        let mut lag = Lag {
            target_of: spec.target,
            initial: spec.initial,
            tau: spec.tau,
            sample: spec.sample,
            switches: spec.switches.iter().map(switch).collect(),
            started: Time::ZERO,
            since: Time::ZERO,
            from: spec.initial,
            target: spec.initial,
            next_sample: None,
            outputs: vec![Value::HighZ; 1 + spec.switches.len()],
        };
        lag.start(Time::ZERO);
        lag
    }

    /// The value at an instant that is not before the last change of the target. After 40 time constants it is
    /// the target itself: what is left is below the rounding of the sum.
    pub fn value(&self, at: Time) -> f64 {
        let elapsed = elapsed(self.since, at);
        if elapsed >= self.tau.as_nanos().saturating_mul(SETTLED) {
            return self.target;
        }
        self.target + (self.from - self.target) * libm::exp(-(elapsed as f64) / self.tau.as_nanos() as f64)
    }

    fn aim(&self, input: Value) -> f64 {
        match self.target_of {
            LagTarget::Levels { low, high } => {
                if input == Value::Bool(true) {
                    high
                } else {
                    low
                }
            }
            LagTarget::Linear { offset, gain } => offset + gain * input.as_real().unwrap_or(0.0),
        }
    }

    /// The first nanosecond after `since` at which the value has reached `level` on its way to the target.
    fn crossing(&self, level: f64) -> Option<Time> {
        let (whole, rest) = (self.from - self.target, level - self.target);
        if rest == 0.0 || (whole > 0.0) != (rest > 0.0) || libm::fabs(rest) >= libm::fabs(whole) {
            return None;
        }
        let nanos = libm::ceil(self.tau.as_nanos() as f64 * libm::log(whole / rest));
        let settled = self.tau.as_nanos().saturating_mul(SETTLED);
        let nanos = if nanos < settled as f64 { (nanos as i64).max(1) } else { settled };
        self.since.as_nanos().checked_add(nanos).map(Time::from_nanos)
    }

    /// Sets when the switches flip after a change of the target at `since`. After a flip there is nothing to
    /// plan: the value moves on, away from the threshold that flips it back.
    fn plan_switches(&mut self) {
        for place in 0..self.switches.len() {
            let Switch { on_above, off_below, on, flips } = self.switches[place];
            // A flip that is due at the very instant of the change still happens then.
            if flips.is_some_and(|due| due <= self.since) {
                continue;
            }
            self.switches[place].flips = match on {
                // Rounding can bring the value to the threshold a nanosecond before the computed crossing.
                false if self.from >= on_above => Some(self.since.saturating_add(Span::from_nanos(1))),
                true if self.from <= off_below => Some(self.since.saturating_add(Span::from_nanos(1))),
                false if self.target > self.from => self.crossing(on_above),
                true if self.target < self.from => self.crossing(off_below),
                _ => None,
            };
        }
    }

    /// Sets the next instant of the grid of samples: none where the output stands at its target for good.
    fn plan_sample(&mut self, now: Time) {
        if self.value(now) == self.target && self.outputs[0].as_real() == Some(self.target) {
            self.next_sample = None;
            return;
        }
        let sample = self.sample.as_nanos();
        let passed = elapsed(self.started, now) / sample;
        let next = passed.checked_add(1).and_then(|count| count.checked_mul(sample));
        self.next_sample =
            next.and_then(|next| self.started.as_nanos().checked_add(next)).map(Time::from_nanos);
    }
}

/// Nanoseconds between two instants, held at the range and at 0.
fn elapsed(from: Time, to: Time) -> i64 {
    to.as_nanos().saturating_sub(from.as_nanos()).max(0)
}

impl Plant for Lag {
    fn start(&mut self, now: Time) {
        self.started = now;
        self.since = now;
        self.from = self.initial;
        self.target = self.aim(Value::HighZ);
        self.outputs[0] = Value::Real(self.initial);
        for (switch, output) in self.switches.iter_mut().zip(&mut self.outputs[1..]) {
            switch.on = self.initial >= switch.on_above;
            switch.flips = None;
            *output = Value::Bool(switch.on);
        }
        self.plan_switches();
        self.plan_sample(now);
    }

    fn input(&mut self, now: Time, _port: usize, value: Value) {
        let target = self.aim(value);
        if target == self.target || !target.is_finite() {
            return;
        }
        self.from = self.value(now);
        self.since = now;
        self.target = target;
        self.plan_switches();
        if self.next_sample.is_none_or(|due| due > now) {
            self.plan_sample(now);
        }
    }

    fn next_event(&self) -> Option<Time> {
        self.switches.iter().filter_map(|switch| switch.flips).chain(self.next_sample).min()
    }

    fn advance(&mut self, now: Time) {
        if self.next_sample.is_some_and(|due| due <= now) {
            // Where a call spans several samples the output is the newest of them.
            let sample = self.sample.as_nanos();
            let grid = Span::from_nanos(elapsed(self.started, now) / sample * sample);
            let at = self.started.saturating_add(grid).max(self.since);
            self.outputs[0] = Value::Real(self.value(at));
            self.plan_sample(now);
        }
        for (switch, output) in self.switches.iter_mut().zip(&mut self.outputs[1..]) {
            if switch.flips.is_some_and(|due| due <= now) {
                switch.on = !switch.on;
                switch.flips = None;
                *output = Value::Bool(switch.on);
            }
        }
    }

    fn outputs(&self) -> &[Value] {
        &self.outputs
    }
}
