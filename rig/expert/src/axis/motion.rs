//! Where an axis shall go, as a row of motions in one direction each.

use super::config::AxisConfig;
use super::profile::{MotionEnd, MotionProfile, Ramps};
use super::ramp::{HERTZ, PULSE, RampRate};
use super::train::{ENDLESS, MotionState, PulseTrain, TrainEvent};
use crate::ExpertEffects;
use signal::Time;

/// What an axis shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionTarget {
    /// Stay where it is.
    Rest,
    /// Come to rest.
    Stop,
    /// Get to a velocity, in units, and keep it; 0 is no pulses.
    Velocity { forward: bool, velocity: i64 },
    /// Get to a position; at the end it has this velocity, or is at rest where that is 0.
    Position { target: i64, velocity: i64, end: i64 },
}

/// What became of an aim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionProgress {
    /// A motion begins, or goes on after a pulse that began.
    Moves,
    /// The velocity is reached.
    Steady,
    /// The position is reached, or the axis is at rest.
    Arrived,
}

/// Pulses towards an aim.
#[derive(Clone, Debug)]
pub struct Motion {
    pub train: PulseTrain,
    aim: MotionTarget,
    ramps: Ramps,
    start_velocity: i64,
    stop_velocity: i64,
    /// Whether the motion under way only ends so that the next one can begin.
    turning: bool,
    /// When the velocity of the aim is reached, until that was reported.
    steady: Time,
    /// Whether that was reported.
    in_velocity: bool,
}

impl Motion {
    pub fn new(config: &AxisConfig) -> Motion {
        let rate = RampRate::hertz_per_ms(1);
        Motion {
            train: PulseTrain::new(config),
            aim: MotionTarget::Rest,
            ramps: Ramps { rise: rate, fall: rate, jerk_ratio: 0 },
            start_velocity: i64::from(config.start_velocity) * HERTZ,
            stop_velocity: i64::from(config.stop_velocity) * HERTZ,
            turning: false,
            steady: Time::MAX,
            in_velocity: false,
        }
    }

    /// The first and the last velocity, in units; 0 for what the ramps give (io:STD-PTO-06).
    pub fn set_velocities(&mut self, start: i64, stop: i64) {
        (self.start_velocity, self.stop_velocity) = (start, stop);
    }

    pub const fn aim(&self) -> MotionTarget {
        self.aim
    }

    /// Whether the velocity of the aim is reached.
    pub const fn in_velocity(&self) -> bool {
        self.in_velocity
    }

    /// When it does something next; [`Time::MAX`] for never.
    #[inline]
    pub fn next(&self) -> Time {
        self.train.due().min(self.steady)
    }

    /// Does the first thing that is due.
    #[inline]
    pub fn fire(&mut self, fx: &mut ExpertEffects) -> Option<MotionProgress> {
        if self.steady <= self.train.due() {
            self.steady = Time::MAX;
            self.in_velocity = true;
            return Some(MotionProgress::Steady);
        }
        let now = self.train.due();
        match self.train.fire(fx) {
            TrainEvent::Pulse => Some(MotionProgress::Moves),
            TrainEvent::Edge => None,
            TrainEvent::Over if self.turning => {
                self.turning = false;
                self.depart(now, fx)
            }
            TrainEvent::Over => {
                if matches!(self.aim, MotionTarget::Position { end: 1.., .. }) {
                    self.train.roll(now);
                }
                self.arrive()
            }
        }
    }

    fn arrive(&mut self) -> Option<MotionProgress> {
        if let MotionTarget::Velocity { .. } = self.aim {
            // Velocity 0 is a velocity too (io:STD-PTO-08).
            self.in_velocity = true;
            return Some(MotionProgress::Steady);
        }
        self.aim = MotionTarget::Rest;
        Some(MotionProgress::Arrived)
    }

    fn first_velocity(&self) -> i64 {
        if self.start_velocity > 0 { self.start_velocity } else { self.ramps.rise.behind_one_ms() }
    }

    fn last_velocity(&self) -> i64 {
        if self.stop_velocity > 0 { self.stop_velocity } else { self.ramps.fall.behind_one_ms() }
    }

    /// Another aim from `now` on. What is reached without a pulse is reported at once.
    pub fn retarget(
        &mut self,
        now: Time,
        aim: MotionTarget,
        ramps: Ramps,
        fx: &mut ExpertEffects,
    ) -> Option<MotionProgress> {
        self.aim = aim;
        self.ramps = ramps;
        self.turning = false;
        self.in_velocity = false;
        self.steady = Time::MAX;
        let Some(course) = self.train.course(now) else {
            return self.depart(now, fx);
        };
        let last = self.last_velocity();
        match aim {
            MotionTarget::Velocity { forward, velocity } if forward == course.forward && velocity > 0 => {
                self.train.turn(now, ENDLESS, |origin, _, begin| {
                    MotionProfile::endless(origin, begin, velocity, &ramps)
                });
                self.steady = self.train.steady().max(now);
                None
            }
            MotionTarget::Position { target, velocity, end }
                if self.has_room(&course, target, last.max(end)) =>
            {
                let more = self.pulses_to(course.forward, target);
                let end = if end > 0 {
                    // What goes on behind the target need not be slower there than there is room for.
                    MotionEnd::Moving(self.slowest(&course, target, end))
                } else {
                    MotionEnd::Rest(last)
                };
                self.train.turn(now, more, |origin, distance, begin| {
                    MotionProfile::to(origin, distance, begin, velocity, end, &ramps)
                });
                None
            }
            _ => {
                self.turning = !matches!(
                    aim,
                    MotionTarget::Stop | MotionTarget::Rest | MotionTarget::Velocity { velocity: 0, .. }
                );
                self.stop(now, course.within, course.pulse, course.velocity, last);
                None
            }
        }
    }

    /// Slows down to the last velocity; rest comes with the end of a pulse.
    fn stop(&mut self, now: Time, within: i128, pulse: bool, velocity: i64, last: i64) {
        let ramps = self.ramps;
        let way = within + ramps.stopping(velocity, last);
        let pulses = u64::try_from((way + PULSE - 1) / PULSE).unwrap_or(1).max(1);
        self.train.turn(now, pulses - u64::from(pulse), |origin, distance, begin| {
            MotionProfile::to(origin, distance, begin, velocity, MotionEnd::Rest(last), &ramps)
        });
    }

    /// Pulses up to a position in the direction of travel, after the current one.
    fn pulses_to(&self, forward: bool, target: i64) -> u64 {
        let away = if forward { target - self.train.position() } else { self.train.position() - target };
        u64::try_from(away).map_or(0, |away| self.train.pulses_to(forward, away))
    }

    /// Whether a position ahead can be the end of the motion under way.
    fn has_room(&self, course: &MotionState, target: i64, last: i64) -> bool {
        let position = self.train.position();
        let ahead = if course.forward { target >= position } else { target <= position };
        let pulses = self.pulses_to(course.forward, target) + u64::from(course.pulse);
        let room = i128::from(pulses) * PULSE - course.within;
        ahead && self.ramps.stopping(course.velocity, last) <= room
    }

    /// The lowest velocity from `end` on that the motion under way can have at a position ahead.
    fn slowest(&self, course: &MotionState, target: i64, end: i64) -> i64 {
        let (mut low, mut high) = (end, end.max(course.velocity));
        if self.has_room(course, target, low) {
            return low;
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.has_room(course, target, middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }

    /// Begins a motion from rest, if the aim needs one.
    fn depart(&mut self, now: Time, fx: &mut ExpertEffects) -> Option<MotionProgress> {
        let ramps = self.ramps;
        let first = self.first_velocity();
        match self.aim {
            MotionTarget::Velocity { forward, velocity } if velocity > 0 => {
                self.train.begin(
                    now,
                    forward,
                    ENDLESS,
                    first.min(velocity),
                    |origin, _, begin| MotionProfile::endless(origin, begin, velocity, &ramps),
                    fx,
                );
                self.steady = self.train.steady();
                Some(MotionProgress::Moves)
            }
            MotionTarget::Position { target, velocity, end } if target != self.train.position() => {
                let forward = target > self.train.position();
                let pulses = self.train.pulses_to(forward, target.abs_diff(self.train.position()));
                let end =
                    if end > 0 { MotionEnd::Moving(end) } else { MotionEnd::Rest(self.last_velocity()) };
                self.train.begin(
                    now,
                    forward,
                    pulses,
                    first.min(velocity),
                    |origin, distance, begin| {
                        MotionProfile::to(origin, distance, begin, velocity, end, &ramps)
                    },
                    fx,
                );
                Some(MotionProgress::Moves)
            }
            _ => {
                // A motion that had not begun yet is none.
                self.train.withdraw();
                self.arrive()
            }
        }
    }

    /// Ends everything at once (io:STD-PTO-13).
    pub fn cut(&mut self, now: Time, fx: &mut ExpertEffects) {
        self.train.cut(now, fx);
        self.aim = MotionTarget::Rest;
        self.turning = false;
        self.steady = Time::MAX;
        self.in_velocity = false;
    }
}
