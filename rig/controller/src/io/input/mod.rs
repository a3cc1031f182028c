//! The embedded inputs: filters, latches, and the edges that raise events or run and stop the controller.

mod channel;
#[cfg(test)]
mod tests;

use crate::config::Config;
use crate::probe::InputProbe;
use channel::Channel;
use signal::{Level, Span, Time, Value};

/// An edge that the controller has to act on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InputEvent {
    /// The event of this input.
    Event(usize),
    /// The Run/Stop input turned to this level.
    RunStop(bool),
    /// This input is driven faster than its profile allows.
    Overdriven(usize),
}

/// Most edges that wait at one instant: two per input and an overdriven terminal each.
const MOST_ACCEPTED: usize = 96;

/// All embedded inputs. In the masks, bit n stands for In.
#[derive(Clone, Debug)]
pub(in crate::io) struct Inputs {
    channels: Vec<Channel>,
    /// Levels behind the filters.
    filtered: u32,
    /// Channels that have to be evaluated.
    moving: u32,
    roles: Roles,
    /// Latches that hold a pulse.
    latched: u32,
    /// The controller runs, so latches and events do (controller:STOP-05).
    operating: bool,
    /// The next falling edge raises no event (io:EIO-11).
    first_fall: u32,
    /// Whether inputs that are on at power-on ignore it.
    ignores_first_fall: bool,
    /// Events raised, by input.
    events: Vec<u32>,
    speed: Speed,
    accepted: Vec<InputEvent>,
    /// When an attentive channel has to be looked at next.
    next: Time,
}

/// What the inputs are for.
#[derive(Clone, Copy, Debug, Default)]
struct Roles {
    latch: u32,
    rising: u32,
    falling: u32,
    /// Events on both edges.
    both: u32,
    run_stop: u32,
    /// Observed.
    watched: u32,
}

impl Roles {
    /// Inputs whose turns are acted on when they happen, not when somebody looks.
    const fn attentive(&self) -> u32 {
        self.rising | self.falling | self.run_stop | self.watched
    }
}

/// How fast the regular inputs are driven.
#[derive(Clone, Debug)]
struct Speed {
    /// The shortest period of a regular input.
    period: Span,
    /// The regular inputs.
    regular: u32,
    /// Last rising edge at each terminal.
    rose: Vec<Time>,
    /// Driven faster.
    over: u32,
}

impl Inputs {
    /// The inputs of a configuration that was checked.
    pub(in crate::io) fn new(config: &Config) -> Inputs {
        let mut roles = Roles::default();
        let mut regular = 0;
        let advanced = config.advanced_inputs();
        let used = config.expert.inputs();
        let channels: Vec<Channel> = profile::inputs(config.reference)
            .map(|input| {
                let own = config.inputs.get(input.index).copied().unwrap_or_default();
                let bit = 1 << input.index;
                roles.latch |= if own.latch { bit } else { 0 };
                if let Some(edges) = own.event {
                    let (up, down) = (edges.includes(true), edges.includes(false));
                    roles.rising |= if up { bit } else { 0 };
                    roles.falling |= if down { bit } else { 0 };
                    roles.both |= if up && down { bit } else { 0 };
                }
                roles.rising |= advanced & bit;
                regular |= if input.kind == profile::InputKind::Regular { bit } else { 0 };
                Channel::new(input.delay, &own, used & bit != 0)
            })
            .collect();
        roles.run_stop = config.run_stop_input.map_or(0, |input| 1 << input);
        let hertz = config.profile.regular_input_hertz().unwrap_or(u32::MAX);
        let count = channels.len();
        Inputs {
            channels,
            filtered: 0,
            moving: 0,
            roles,
            latched: 0,
            operating: false,
            first_fall: 0,
            ignores_first_fall: config.profile == profile::Profile::M241_2019,
            events: vec![0; count],
            speed: Speed {
                period: Span::from_nanos(1_000_000_000 / i64::from(hertz)),
                regular,
                rose: vec![Time::MIN; count],
                over: 0,
            },
            accepted: Vec::with_capacity(MOST_ACCEPTED),
            next: Time::MAX,
        }
    }

    /// A 1 for every input.
    pub(in crate::io) fn mask(&self) -> u32 {
        ((1u64 << self.channels.len()) - 1) as u32
    }

    /// The inputs' electronics come up at `now`: everything behind the terminals starts from 0.
    pub(in crate::io) fn power_on(&mut self, now: Time) {
        (self.filtered, self.moving, self.latched, self.first_fall) = (0, 0, 0, 0);
        self.accepted.clear();
        self.events.fill(0);
        for (n, channel) in self.channels.iter_mut().enumerate() {
            self.moving |= u32::from(channel.power_on(now)) << n;
        }
        if self.ignores_first_fall {
            self.first_fall = self.moving & self.roles.both;
        }
        self.plan(now);
    }

    /// The controller runs from `now` on, or no longer does. Latches begin empty.
    pub(in crate::io) fn operate(&mut self, now: Time, operating: bool) {
        self.evaluate(now);
        if self.operating != operating {
            (self.operating, self.latched) = (operating, 0);
        }
    }

    /// The level at a terminal from `now` on. Numbers beyond the reference's inputs are ignored.
    pub(in crate::io) fn set(&mut self, now: Time, input: usize, level: Level) {
        if input >= self.channels.len() {
            return;
        }
        let high = level.is_high();
        let before = self.filtered;
        // At rest the filter stands at its end, so the time since then adds nothing.
        self.advance(input, now);
        let turned = (before ^ self.filtered) & self.roles.watched != 0;
        let rose = self.channels[input].set(now, high) && high;
        if !high && !self.channels[input].out() {
            // What was on at power-on is off again before it was accepted: no falling edge of it will come.
            self.first_fall &= !(1 << input);
        }
        self.moving |= 1 << input;
        if rose {
            self.check_speed(input, now);
        }
        self.plan(now);
        if turned {
            // The filter turned at the very instant of the change: whoever observes it is to see that.
            self.next = now;
        }
    }

    /// io:REF-03, controller:HW-03: rising edges that come sooner than the period of the highest frequency.
    fn check_speed(&mut self, input: usize, now: Time) {
        let speed = &mut self.speed;
        let soon = now < speed.rose[input].saturating_add(speed.period);
        speed.rose[input] = now;
        let bit = 1 << input;
        if soon && speed.regular & bit != 0 && speed.over & bit == 0 {
            speed.over |= bit;
            self.accepted.push(InputEvent::Overdriven(input));
        }
    }

    /// The levels behind the filters at `now`.
    #[inline]
    pub(in crate::io) fn levels(&mut self, now: Time) -> u32 {
        if self.moving != 0 {
            self.evaluate(now);
        }
        self.filtered
    }

    /// What a task reads at `now`, and which inputs it reads: only MAST reads latched ones, and that read empties
    /// their latches (io:STD-IN-04).
    #[inline]
    pub(in crate::io) fn read(&mut self, now: Time, mast: bool) -> (u32, u32) {
        let levels = self.levels(now);
        if mast {
            (levels | std::mem::take(&mut self.latched), self.mask())
        } else {
            (levels, self.mask() & !self.roles.latch)
        }
    }

    /// The level behind the filter of the Run/Stop input at `now`, where one is configured.
    pub(in crate::io) fn run_stop(&mut self, now: Time) -> Option<bool> {
        let mask = self.roles.run_stop;
        (mask != 0).then(|| self.levels(now) & mask != 0)
    }

    /// Whether terminal I`input` is at 1.
    pub(in crate::io) fn terminal(&self, input: usize) -> bool {
        self.channels.get(input).is_some_and(Channel::terminal)
    }

    /// When something here happens by itself; `Time::MAX` for never.
    #[inline]
    pub(in crate::io) const fn next(&self) -> Time {
        self.next
    }

    /// Brings the attentive inputs to `now`.
    pub(in crate::io) fn fire(&mut self, now: Time) {
        self.evaluate(now);
        self.schedule();
    }

    /// The next edge that the controller has to act on, in the order in which they were accepted.
    pub(in crate::io) fn take(&mut self, place: usize) -> Option<InputEvent> {
        let edge = self.accepted.get(place).copied();
        if edge.is_none() {
            self.accepted.clear();
        }
        edge
    }

    /// Observes an input from now on.
    pub(in crate::io) fn watch(&mut self, input: usize) {
        if input < self.channels.len() {
            self.roles.watched |= 1 << input;
            self.schedule();
        }
    }

    /// What an observer sees of an input; unknown for one that the reference does not have.
    pub(in crate::io) fn show(&self, input: usize, part: InputProbe) -> Value {
        let Some(events) = self.events.get(input) else { return Value::Unknown };
        let bit = |mask: u32| Value::Bool(mask >> input & 1 == 1);
        match part {
            InputProbe::Filtered => bit(self.filtered),
            InputProbe::Latched => bit(self.latched),
            InputProbe::Events => Value::Int(i64::from(*events)),
            InputProbe::Overdriven => bit(self.speed.over),
        }
    }

    fn evaluate(&mut self, now: Time) {
        let mut left = self.moving;
        while left != 0 {
            let n = left.trailing_zeros() as usize;
            left &= left - 1;
            self.advance(n, now);
            if !self.channels[n].moves() {
                self.moving &= !(1 << n);
            }
        }
    }

    fn advance(&mut self, n: usize, now: Time) {
        let bit = 1 << n;
        let Inputs { channels, filtered, roles, latched, first_fall, events, accepted, .. } = self;
        let operating = self.operating;
        channels[n].advance(now, |_, high| {
            *filtered = if high { *filtered | bit } else { *filtered & !bit };
            if operating && high {
                *latched |= bit & roles.latch;
            }
            let ignored = !high && *first_fall & bit != 0;
            if ignored {
                *first_fall &= !bit;
            }
            let wanted = if high { roles.rising } else { roles.falling } & bit != 0;
            if operating && wanted && !ignored {
                events[n] = events[n].wrapping_add(1);
                accepted.push(InputEvent::Event(n));
            }
            if roles.run_stop & bit != 0 {
                accepted.push(InputEvent::RunStop(high));
            }
        });
    }

    /// Works out `next` at `now`. What is accepted already is due at once.
    fn plan(&mut self, now: Time) {
        self.schedule();
        if !self.accepted.is_empty() {
            self.next = now;
        }
    }

    /// Works out when the next attentive input turns.
    fn schedule(&mut self) {
        self.next = Time::MAX;
        let mut left = self.moving & self.roles.attentive();
        while left != 0 {
            let channel = &self.channels[left.trailing_zeros() as usize];
            self.next = self.next.min(channel.next());
            left &= left - 1;
        }
    }
}
