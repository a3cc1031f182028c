//! Pulses: a motion in one direction as edges of the outputs, and the position that they add up to.

use super::config::{AxisConfig, PulseOutput};
use super::profile::{MotionBegin, MotionProfile};
use super::ramp::PULSE;
use crate::{ExpertEffect, ExpertEffects};
use signal::{Span, Time};

/// As many pulses as nobody counts.
pub const ENDLESS: u64 = u64::MAX;

/// A motion in one direction. Its position counts from the beginning of the first of its pulses that matter: pulse k,
/// from 1 on, begins where the position is k - 1 (io:STD-PTO-06).
#[derive(Clone, Debug)]
struct TrainSegment {
    profile: MotionProfile,
    /// When the profile begins.
    start: Time,
    /// Its pulses, and how many of them have begun.
    total: u64,
    begun: u64,
}

/// What a pulse train did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrainEvent {
    /// A pulse began.
    Pulse,
    /// An edge within a pulse.
    Edge,
    /// The last pulse of the motion is over.
    Over,
}

/// What is going on at an instant.
#[derive(Clone, Copy, Debug)]
pub struct MotionState {
    /// Whether positions get larger.
    pub forward: bool,
    /// In units of velocity.
    pub velocity: i64,
    /// The position within the current pulse.
    pub within: i128,
    /// Whether there is a current pulse, or the instant is that of the next.
    pub pulse: bool,
}

/// The outputs of an axis, and its position.
#[derive(Clone, Debug)]
pub struct PulseTrain {
    output: PulseOutput,
    a: u8,
    b: u8,
    backlash: u32,
    /// The level of B for larger positions.
    positive: bool,
    delay: Option<i64>,
    /// Bit 0 for A, bit 1 for B.
    levels: u8,
    leg: Option<TrainSegment>,
    forward: bool,
    /// Whether there was a motion: before the first one no side of the play is known.
    moved: bool,
    /// From when on pulses may come after a change of direction.
    ready: Time,
    /// Pulses that still go into the play of the mechanics (io:STD-PTO-02).
    play: u32,
    position: i64,
    pulses: u64,
    /// The velocity at which the last motion ended, and the instant where the next one may go on with it.
    exit: i64,
    rolls: Time,
    /// When the current pulse began, when it is over, which of its edges comes next, and when that comes.
    began: Time,
    over: Time,
    part: i64,
    due: Time,
}

impl PulseTrain {
    pub fn new(config: &AxisConfig) -> PulseTrain {
        PulseTrain {
            output: config.output,
            a: config.a,
            b: config.b.unwrap_or(config.a),
            backlash: if config.output == PulseOutput::Quadrature { config.backlash } else { 0 },
            positive: !config.direction_inverted,
            delay: config.direction_delay.map(|delay| delay.as_nanos()),
            levels: 0,
            leg: None,
            forward: true,
            moved: false,
            ready: Time::MIN,
            play: 0,
            position: 0,
            pulses: 0,
            exit: 0,
            rolls: Time::MIN,
            began: Time::MIN,
            over: Time::MAX,
            part: 0,
            due: Time::MAX,
        }
    }

    /// When it does something next; [`Time::MAX`] for never.
    #[inline]
    pub const fn due(&self) -> Time {
        self.due
    }

    /// The sum of all pulses that began, with their directions.
    pub const fn position(&self) -> i64 {
        self.position
    }

    /// All pulses that began.
    pub const fn pulses(&self) -> u64 {
        self.pulses
    }

    /// Gives the position another number.
    pub fn set_position(&mut self, position: i64) {
        self.position = position;
    }

    /// When the last pulse began, or the motion under way.
    pub fn latest(&self) -> Time {
        self.leg.as_ref().map_or(self.began, |leg| self.began.max(leg.start))
    }

    /// Whether positions get larger with its pulses.
    pub const fn forward(&self) -> bool {
        self.forward
    }

    /// Whether pulses of the motion are still to come.
    pub fn goes_on(&self) -> bool {
        self.leg.as_ref().is_some_and(|leg| leg.begun < leg.total)
    }

    /// What is going on; None at rest, and before the first pulse.
    pub fn course(&self, now: Time) -> Option<MotionState> {
        if self.rolls == now {
            return Some(MotionState { forward: self.forward, velocity: self.exit, within: 0, pulse: false });
        }
        let leg = self.leg.as_ref().filter(|leg| leg.begun > 0)?;
        let time = (now - leg.start).as_nanos();
        let within = leg.profile.position(time) - PULSE * i128::from(leg.begun - 1);
        Some(MotionState {
            forward: self.forward,
            velocity: leg.profile.velocity(time),
            within: within.clamp(0, PULSE),
            pulse: true,
        })
    }

    /// Whether it gets faster (above 0), slower (below 0) or neither; None at rest.
    pub fn trend(&self, now: Time) -> Option<i64> {
        let leg = self.leg.as_ref().filter(|leg| leg.start <= now)?;
        Some(leg.profile.trend((now - leg.start).as_nanos()))
    }

    /// When the motion has its steady velocity.
    pub fn steady(&self) -> Time {
        self.leg
            .as_ref()
            .map_or(Time::MAX, |leg| leg.start.saturating_add(Span::from_nanos(leg.profile.steady())))
    }

    /// How many pulses it takes to a position that many pulses away: those into the play come first.
    pub fn pulses_to(&self, forward: bool, pulses: u64) -> u64 {
        pulses.saturating_add(u64::from(self.play_towards(forward)))
    }

    fn play_towards(&self, forward: bool) -> u32 {
        if self.moved && forward != self.forward { self.backlash - self.play } else { self.play }
    }

    /// Begins a motion from rest.
    pub fn begin(
        &mut self,
        now: Time,
        forward: bool,
        pulses: u64,
        first_velocity: i64,
        profile: impl FnOnce(i128, i128, MotionBegin) -> MotionProfile,
        fx: &mut ExpertEffects,
    ) {
        self.play = self.play_towards(forward);
        self.forward = forward;
        self.moved = true;
        if self.output == PulseOutput::PulseDirection {
            let level = forward == self.positive;
            if level != (self.levels & B != 0) {
                self.set(now, B, level, fx);
                let period = PULSE / i128::from(first_velocity.max(1));
                let period = i64::try_from(period).unwrap_or(i64::MAX);
                let delay = self.delay.unwrap_or(period).max(LEAST_DELAY);
                self.ready = now.saturating_add(Span::from_nanos(delay));
            }
        }
        let start = now.max(self.ready);
        let profile = profile(0, distance(pulses), MotionBegin::Rest(first_velocity));
        self.leg = Some(TrainSegment { profile, start, total: pulses, begun: 0 });
        self.over = start;
        self.part = self.parts();
        self.due = start;
    }

    /// Gives the motion that is under way another course from `now` on: after the current pulse `more` pulses.
    pub fn turn(
        &mut self,
        now: Time,
        more: u64,
        profile: impl FnOnce(i128, i128, MotionBegin) -> MotionProfile,
    ) {
        let Some(course) = self.course(now) else { return };
        let begun = u64::from(course.pulse);
        let total = more.saturating_add(begun);
        let profile =
            profile(course.within, distance(total) - course.within, MotionBegin::Moving(course.velocity));
        self.leg = Some(TrainSegment { profile, start: now, total, begun });
        if course.pulse {
            self.plan_pulse(now);
        } else {
            self.over = now;
            self.due = now;
        }
    }

    /// A motion that begins at `now`, where the last one is over, goes on with its velocity.
    pub fn roll(&mut self, now: Time) {
        self.rolls = now;
    }

    /// Forgets a motion whose first pulse is still to come.
    pub fn withdraw(&mut self) {
        self.leg = None;
        self.due = Time::MAX;
    }

    /// Ends the motion at once and switches the outputs off (io:STD-PTO-13).
    pub fn cut(&mut self, now: Time, fx: &mut ExpertEffects) {
        self.withdraw();
        self.rolls = Time::MIN;
        self.set(now, A | B, false, fx);
    }

    /// The parts of a pulse between its edges.
    const fn parts(&self) -> i64 {
        match self.output {
            PulseOutput::Quadrature => 4,
            _ => 2,
        }
    }

    /// Does what is due.
    #[inline]
    pub fn fire(&mut self, fx: &mut ExpertEffects) -> TrainEvent {
        let now = self.due;
        if self.part < self.parts() {
            self.edge(now, fx);
            self.part += 1;
            self.schedule(now);
            return TrainEvent::Edge;
        }
        let Some(leg) = self.leg.as_mut().filter(|leg| leg.begun < leg.total) else {
            self.exit = self.leg.take().map_or(0, |leg| leg.profile.velocity(leg.profile.length()));
            self.due = Time::MAX;
            return TrainEvent::Over;
        };
        leg.begun += 1;
        self.rolls = Time::MIN;
        self.pulses += 1;
        if self.play > 0 {
            self.play -= 1;
        } else {
            self.position += if self.forward { 1 } else { -1 };
        }
        let before = (now - self.began).as_nanos();
        self.began = now;
        self.part = 0;
        self.edge(now, fx);
        self.part = 1;
        self.look_ahead(now, before);
        TrainEvent::Pulse
    }

    /// Works out when the current pulse is over, and its edges.
    fn plan_pulse(&mut self, now: Time) {
        self.look_ahead(now, (self.over - self.began).as_nanos());
    }

    #[inline]
    fn look_ahead(&mut self, now: Time, period: i64) {
        let Some(leg) = &mut self.leg else { return };
        let over = if leg.begun < leg.total {
            let guess = (self.began - leg.start).as_nanos().saturating_add(period);
            leg.profile.reach(i128::from(leg.begun) * PULSE, guess)
        } else {
            leg.profile.length()
        };
        self.over = leg.start.saturating_add(Span::from_nanos(over)).max(now);
        self.schedule(now);
    }

    /// Edges share the period evenly (io:STD-PTO-12).
    #[inline]
    fn schedule(&mut self, now: Time) {
        let period = (self.over - self.began).as_nanos();
        let share = match self.parts() {
            2 => period >> 1,
            _ => (i128::from(period) * i128::from(self.part) / 4) as i64,
        };
        self.due = if self.part < self.parts() {
            self.began.saturating_add(Span::from_nanos(share)).max(now)
        } else {
            self.over
        };
    }

    /// The edge at the beginning of a part.
    #[inline]
    fn edge(&mut self, now: Time, fx: &mut ExpertEffects) {
        let (line, on) = match self.output {
            PulseOutput::PulseDirection | PulseOutput::Pulse => (A, self.part == 0),
            PulseOutput::ClockwiseCounterclockwise => (if self.forward { A } else { B }, self.part == 0),
            PulseOutput::Quadrature => {
                let leads = self.part % 2 == 0;
                (if leads == self.forward { A } else { B }, self.part < 2)
            }
        };
        self.set(now, line, on, fx);
    }

    #[inline]
    fn set(&mut self, now: Time, lines: u8, on: bool, fx: &mut ExpertEffects) {
        for (line, output) in [(A, self.a), (B, self.b)] {
            if lines & line != 0 && (self.levels & line != 0) != on {
                self.levels ^= line;
                fx.push(now, ExpertEffect::Output { output, on });
            }
        }
    }
}

const A: u8 = 1;
const B: u8 = 2;

/// Least time between a change of direction and the next pulse, in nanoseconds (io:STD-PTO-01).
pub const LEAST_DELAY: i64 = 20_000;

fn distance(pulses: u64) -> i128 {
    // Beyond 2^53 pulses no motion gets.
    i128::from(pulses.min(1 << 53)) * PULSE
}
