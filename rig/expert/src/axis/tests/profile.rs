//! When the pulses of one command come, against the formulas of the requirements in real numbers.

use super::*;

/// A motion from rest to rest, in seconds and pulses: the formulas of io:STD-PTO-06 and
/// io:STD-PTO-07, integrated by hand.
struct Oracle {
    /// The velocity that it would begin with if it were long enough.
    wanted: f64,
    first: f64,
    peak: f64,
    last: f64,
    rise: f64,
    cruise: f64,
    fall: f64,
    ratio: f64,
}

impl Oracle {
    fn new(distance: f64, v0: f64, v: f64, vs: f64, a: f64, d: f64, ratio: f64) -> Oracle {
        let (v0, vs) = (if v0 > 0.0 { v0 } else { a / 1e3 }, if vs > 0.0 { vs } else { d / 1e3 });
        let ramps = |p: f64| {
            let up = (p * p - v0.min(p).powi(2)) / (2.0 * a);
            let down = (p * p - vs.min(p).powi(2)) / (2.0 * d);
            up + down
        };
        // The formula of the requirement holds for a peak above the first and the last velocity; one below them begins
        // and ends as it is.
        let formula = ((2.0 * a * d * distance + d * v0 * v0 + a * vs * vs) / (a + d)).sqrt();
        let peak = if ramps(v) <= distance {
            v
        } else if formula >= v0.max(vs) {
            formula
        } else {
            bisect(v, |p| ramps(p) <= distance)
        };
        let (first, last) = (v0.min(peak), vs.min(peak));
        Oracle {
            wanted: v0.min(v),
            first,
            peak,
            last,
            rise: (peak - first) / a,
            cruise: (distance - ramps(peak)).max(0.0) / peak,
            fall: (peak - last) / d,
            ratio,
        }
    }

    /// The part of a ramp's change that is over after a part of its time, and the integral of that.
    fn curve(&self, u: f64) -> (f64, f64) {
        let r = self.ratio;
        if r == 0.0 {
            return (u, u * u / 2.0);
        }
        // The rate: up to 1 / (1 - r / 2) within r / 2, steady, down to 0.
        let top = 1.0 / (1.0 - r / 2.0);
        let (c, j) = (r / 2.0, top / (r / 2.0));
        if u <= c {
            (j * u * u / 2.0, j * u * u * u / 6.0)
        } else if u <= 1.0 - c {
            let (v1, s1) = (j * c * c / 2.0, j * c * c * c / 6.0);
            let w = u - c;
            (v1 + top * w, s1 + v1 * w + top * w * w / 2.0)
        } else {
            let w = 1.0 - u;
            // From the other end: what is missing of 1 is the same curve.
            (1.0 - j * w * w / 2.0, 0.5 - w + j * w * w * w / 6.0)
        }
    }

    fn position(&self, t: f64) -> f64 {
        let ramp = |from: f64, to: f64, time: f64, t: f64| {
            if time == 0.0 { 0.0 } else { from * t + (to - from) * time * self.curve(t / time).1 }
        };
        let (t1, t2) = (self.rise, self.rise + self.cruise);
        if t <= t1 {
            ramp(self.first, self.peak, self.rise, t)
        } else if t <= t2 {
            ramp(self.first, self.peak, self.rise, t1) + self.peak * (t - t1)
        } else {
            ramp(self.first, self.peak, self.rise, t1)
                + self.peak * self.cruise
                + ramp(self.peak, self.last, self.fall, (t - t2).min(self.fall))
        }
    }

    fn end(&self) -> f64 {
        self.rise + self.cruise + self.fall
    }
}

/// The largest number up to `most` that is good, where numbers below a good one are.
fn bisect(most: f64, good: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, most);
    for _ in 0..100 {
        let middle = (low + high) / 2.0;
        if good(middle) { low = middle } else { high = middle }
    }
    low
}

struct Case {
    pulses: i64,
    start: u32,
    velocity: i64,
    stop: u32,
    rise: u32,
    fall: u32,
    ratio: u8,
}

fn check(case: &Case) {
    let mut config = AxisConfig::new(0, 1);
    (config.start_velocity, config.stop_velocity) = (case.start, case.stop);
    let mut bench = Bench::new(&config);
    bench.now = 5 * MS;
    let ticket =
        bench.order(MotionCommand::By(case.pulses), case.velocity, ramps(case.rise, case.fall, case.ratio));
    bench.settle();
    assert_eq!(bench.axis.phase(ticket), CommandPhase::Done);
    assert_eq!((bench.axis.position(), bench.axis.state()), (case.pulses, AxisState::Standstill));
    let rises = bench.rises(0);
    assert_eq!(rises.len() as i64, case.pulses);
    let oracle = Oracle::new(
        case.pulses as f64,
        case.start.into(),
        case.velocity as f64,
        case.stop.into(),
        f64::from(case.rise) * 1e3,
        f64::from(case.fall) * 1e3,
        f64::from(case.ratio) / 100.0,
    );
    // The direction is given one period of the first velocity before.
    let begin = bench.rises(1)[0];
    assert_eq!(begin, 5 * MS);
    let delay = ((1e9 / oracle.wanted) as i64).max(20_000);
    assert!((rises[0] - begin - delay).abs() <= 1, "{} is not {delay}", rises[0] - begin);
    for (k, at) in (0..).zip(&rises) {
        // Ramps last whole nanoseconds: that is the way of a few of them at the highest velocity, and no more.
        let off = oracle.position((at - rises[0]) as f64 / 1e9) - f64::from(k);
        assert!(off.abs() < 4e-9 * oracle.peak.max(1.0), "pulse {k} is at {k} + {off}");
    }
    let falls: Vec<i64> = bench.waves().iter().filter(|(_, a, _)| !a).skip(1).map(|wave| wave.0).collect();
    for (k, fall) in falls.iter().enumerate() {
        let over = rises.get(k + 1).copied().unwrap_or(rises[0] + (oracle.end() * 1e9) as i64);
        let half = (over - rises[k]) / 2;
        assert!((fall - rises[k] - half).abs() <= 3, "pulse {k} is on for {} of {half}", fall - rises[k]);
    }
}

// io:STD-PTO-06, io:STD-PTO-12
#[test]
fn trapezoids() {
    for (pulses, start, velocity, stop, rise, fall) in [
        (1000, 100, 1000, 100, 10, 10),
        (5000, 0, 10_000, 0, 100, 50),
        // Never gets to its velocity.
        (300, 200, 50_000, 100, 30, 70),
        (20_000, 500, 100_000, 2_000, 1_000, 333),
        // No ramp at all: the first and the last velocity are above it.
        (10, 100, 50, 100, 10, 10),
        // Too short for the way down from a first velocity above the highest.
        (1, 383, 380, 0, 1, 1),
        // Too short to reach its last velocity.
        (3, 10, 1_000, 900, 1, 1),
        (1, 10, 100, 10, 1, 1),
        (2, 0, 100_000, 0, 100_000, 100_000),
    ] {
        check(&Case { pulses, start, velocity, stop, rise, fall, ratio: 0 });
    }
}

// io:STD-PTO-07
#[test]
fn s_curves() {
    for ratio in [1, 33, 50, 100] {
        for (pulses, start, velocity, stop, rise, fall) in [
            (1000, 100, 1000, 100, 10, 10),
            (300, 200, 50_000, 100, 30, 70),
            (20_000, 500, 100_000, 2_000, 1_000, 333),
        ] {
            check(&Case { pulses, start, velocity, stop, rise, fall, ratio });
        }
    }
}

/// Velocities over time that change along straight lines, in seconds and hertz.
struct Lines {
    /// When a line begins, its first velocity, its rate, and the position there.
    lines: Vec<(f64, f64, f64, f64)>,
}

impl Lines {
    fn new(velocity: f64) -> Lines {
        Lines { lines: vec![(0.0, velocity, 0.0, 0.0)] }
    }

    fn at(&self, t: f64) -> (f64, f64) {
        let (begin, v, a, s) = *self.lines.iter().rfind(|line| line.0 <= t).unwrap();
        let dt = t - begin;
        (v + a * dt, s + v * dt + a * dt * dt / 2.0)
    }

    /// From `t` on to a velocity, and then steady.
    fn change(&mut self, t: f64, to: f64, rise: f64, fall: f64) {
        let (v, s) = self.at(t);
        self.lines.retain(|line| line.0 < t);
        let rate = if to > v { rise } else { -fall };
        self.lines.push((t, v, rate, s));
        let end = t + (to - v) / rate;
        let (_, s) = self.at(end);
        self.lines.push((end, to, 0.0, s));
    }
}

/// Velocities given one after the other, at instants within ramps or after them; then a halt.
fn check_changes(first: i64, changes: &[(i64, i64)], rise: u32, fall: u32) {
    let mut config = AxisConfig::new(0, 1);
    (config.start_velocity, config.stop_velocity) = (50, 70);
    config.output = PulseOutput::ClockwiseCounterclockwise;
    let mut bench = Bench::new(&config);
    let (a, d) = (f64::from(rise) * 1e3, f64::from(fall) * 1e3);
    let mut oracle = Lines::new(50_f64.min(first as f64));
    bench.order(MotionCommand::Velocity(Some(true)), first, ramps(rise, fall, 0));
    oracle.change(0.0, first as f64, a, d);
    let mut peak = first;
    for (wait, hertz) in changes {
        bench.after(*wait);
        bench.order(MotionCommand::Velocity(Some(true)), *hertz, ramps(rise, fall, 0));
        oracle.change(bench.now as f64 / 1e9, *hertz as f64, a, d);
        peak = peak.max(*hertz);
    }
    bench.after(10 * MS);
    let rises = bench.rises(0);
    let most = 3e-9 * (changes.len() + 2) as f64 * peak as f64;
    for (k, at) in (0..).zip(&rises) {
        let off = oracle.at(*at as f64 / 1e9).1 - f64::from(k);
        assert!(off.abs() < most, "pulse {k} is at {k} + {off}");
    }
    let (velocity, position) = oracle.at(bench.now as f64 / 1e9);
    let begun = |position: f64| position.floor() as usize + 1;
    assert!((begun(position - most)..=begun(position + most)).contains(&rises.len()), "{position}");
    // The halt ends with the first whole pulse after the way that it takes to slow down.
    bench.order(MotionCommand::Halt, 0, ramps(rise, fall, 0));
    bench.settle();
    let way = (velocity.powi(2) - 70_f64.min(velocity).powi(2)) / (2.0 * d);
    let pulses = bench.axis.position() as f64 - (position + way);
    assert!((-0.001..1.001).contains(&pulses), "{pulses} pulses too many");
}

// io:STD-PTO-06, io:STD-PTO-08
#[test]
fn velocities_change_from_where_they_are() {
    check_changes(1000, &[(50 * MS, 3000), (20 * MS, 200), (30 * MS, 200), (400 * MS, 5000)], 10, 20);
    check_changes(40, &[(70 * MS, 60), (1, 30)], 1, 1);
}

mod arbitrary {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..Default::default() })]

        // io:STD-PTO-06, io:STD-PTO-07
        #[test]
        fn profiles(
            pulses in 1_i64..3000,
            start in 0_u32..2000,
            velocity in 1_i64..100_000,
            stop in 0_u32..2000,
            rise in 1_u32..5000,
            fall in 1_u32..5000,
            ratio in 0_u8..=100,
        ) {
            prop_assume!(velocity / 80_000 < i64::from(rise.min(fall)));
            check(&Case { pulses, start, velocity, stop, rise, fall, ratio });
        }

        // io:STD-PTO-06, io:STD-PTO-08
        #[test]
        fn changes(
            first in 1_i64..20_000,
            rise in 1_u32..1000,
            fall in 1_u32..1000,
            changes in prop::collection::vec((0_i64..60_000_000, 1_i64..20_000), 0..6),
        ) {
            check_changes(first, &changes, rise, fall);
        }
    }
}
