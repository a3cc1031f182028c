//! An axis on a bench: what its outputs do, decoded without its help.

mod homing;
mod profile;
mod sequences;
mod states;

use super::*;
use signal::Span;

pub const MS: i64 = 1_000_000;
pub const S: i64 = 1_000_000_000;

/// An axis, the time, and everything that its outputs did.
pub struct Bench {
    pub axis: Axis,
    pub now: i64,
    fx: ExpertEffects,
    pub log: Vec<(i64, ExpertEffect)>,
    a: u8,
    b: u8,
}

impl Bench {
    /// An axis with power.
    pub fn new(config: &AxisConfig) -> Bench {
        assert_eq!(config.check(), []);
        let mut bench = Bench {
            axis: Axis::new(config, 0),
            now: 0,
            fx: ExpertEffects::new(),
            log: Vec::new(),
            a: config.a,
            b: config.b.unwrap_or(255),
        };
        bench.axis.operate(bench.time(), ExpertOperation::Running, &mut bench.fx);
        bench.axis.power(bench.time(), true, &mut bench.fx);
        bench
    }

    pub fn time(&self) -> Time {
        Time::from_nanos(self.now)
    }

    fn collect(&mut self) {
        let mut place = 0;
        while let Some((at, effect)) = self.fx.take(place) {
            self.log.push((at.as_nanos(), effect));
            place += 1;
        }
    }

    /// Lets time pass, event by event.
    pub fn until(&mut self, at: i64) {
        while self.axis.next().as_nanos() <= at {
            let next = self.axis.next();
            self.axis.fire(next, &mut self.fx);
            self.collect();
        }
        self.now = at;
    }

    /// Lets time pass until nothing more happens by itself.
    pub fn settle(&mut self) {
        while self.axis.next() < Time::MAX {
            self.until(self.axis.next().as_nanos());
        }
    }

    /// Lets so many things happen, if as many do.
    pub fn events(&mut self, most: u64) {
        for _ in 0..most {
            if self.axis.next() < Time::MAX {
                self.until(self.axis.next().as_nanos());
            }
        }
    }

    pub fn after(&mut self, nanos: i64) {
        self.until(self.now + nanos);
    }

    pub fn try_order(&mut self, order: MotionCommand, hertz: i64, ramps: Ramps) -> Result<u32, AxisFault> {
        self.give(AxisCommand {
            order,
            velocity: hertz * HERTZ,
            ramps,
            mode: BufferMode::Aborting,
            delay: Span::ZERO,
        })
    }

    pub fn give(&mut self, command: AxisCommand) -> Result<u32, AxisFault> {
        let ticket = self.axis.command(self.time(), command, &mut self.fx);
        self.collect();
        ticket
    }

    pub fn order(&mut self, order: MotionCommand, hertz: i64, ramps: Ramps) -> u32 {
        self.try_order(order, hertz, ramps).unwrap()
    }

    pub fn input(&mut self, input: u8, high: bool) {
        self.axis.edge(self.time(), input, high, &mut self.fx);
        self.collect();
    }

    pub fn with(&mut self, body: impl FnOnce(&mut Axis, Time, &mut ExpertEffects)) {
        body(&mut self.axis, Time::from_nanos(self.now), &mut self.fx);
        self.collect();
    }

    /// When an output went on.
    pub fn rises(&self, output: u8) -> Vec<i64> {
        let rises = self.log.iter().filter(|(_, fx)| *fx == ExpertEffect::Output { output, on: true });
        rises.map(|(at, _)| *at).collect()
    }

    /// The levels of A and B after each change.
    pub fn waves(&self) -> Vec<(i64, bool, bool)> {
        let (mut a, mut b) = (false, false);
        let mut waves = Vec::new();
        for (at, fx) in &self.log {
            if let ExpertEffect::Output { output, on } = fx {
                if *output == self.a {
                    assert_ne!(a, *on, "an edge that is none at {at}");
                    a = *on;
                } else if *output == self.b {
                    assert_ne!(b, *on, "an edge that is none at {at}");
                    b = *on;
                } else {
                    continue;
                }
                waves.push((*at, a, b));
            }
        }
        waves
    }

    /// The position that a drive gets to by the outputs.
    pub fn decoded(&self, output: PulseOutput) -> i64 {
        let mut position = 0;
        let (mut a, mut b) = (false, false);
        for (_, next_a, next_b) in self.waves() {
            position += match output {
                PulseOutput::PulseDirection if next_a && !a => {
                    if next_b {
                        1
                    } else {
                        -1
                    }
                }
                PulseOutput::Pulse if next_a && !a => 1,
                PulseOutput::ClockwiseCounterclockwise => i64::from(next_a && !a) - i64::from(next_b && !b),
                // A quarter each.
                PulseOutput::Quadrature => {
                    let phase = |a: bool, b: bool| match (a, b) {
                        (false, false) => 0,
                        (true, false) => 1,
                        (true, true) => 2,
                        (false, true) => 3,
                    };
                    match (phase(next_a, next_b) - phase(a, b) + 4) % 4 {
                        1 => 1,
                        3 => -1,
                        other => panic!("a jump of {other} quarters"),
                    }
                }
                _ => 0,
            };
            (a, b) = (next_a, next_b);
        }
        if output == PulseOutput::Quadrature {
            assert_eq!(position % 4, 0, "a part of a pulse");
            position /= 4;
        }
        position
    }
}

/// Ramps in hertz a millisecond.
pub fn ramps(rise: u32, fall: u32, jerk_ratio: u8) -> Ramps {
    use super::ramp::RampRate;
    Ramps { rise: RampRate::hertz_per_ms(rise), fall: RampRate::hertz_per_ms(fall), jerk_ratio }
}
