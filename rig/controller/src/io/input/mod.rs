//! The embedded inputs: filters, latches, and the edges that raise events or run and stop the controller.

pub(crate) mod channel;
#[cfg(test)]
mod tests;

use crate::config::Config;
use crate::probe::InputProbe;
use channel::InputChannel;
use profile::ChannelSet;
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

/// All embedded inputs.
#[derive(Clone, Debug)]
pub(in crate::io) struct Inputs {
    channels: Vec<InputChannel>,
    /// Those at 1 after the filters.
    filtered: ChannelSet,
    /// Channels that have to be evaluated.
    moving: ChannelSet,
    roles: Roles,
    /// Latches that hold a pulse.
    latched: ChannelSet,
    /// The controller runs, so latches and events do (controller:STOP-05).
    operating: bool,
    /// The next falling edge raises no event (io:EIO-11).
    first_fall: ChannelSet,
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
    latch: ChannelSet,
    rising: ChannelSet,
    falling: ChannelSet,
    /// Events on both edges.
    both: ChannelSet,
    run_stop: Option<usize>,
    /// Observed.
    watched: ChannelSet,
}

impl Roles {
    /// Inputs whose turns are acted on when they happen, not when somebody looks.
    fn attentive(&self) -> ChannelSet {
        let run_stop = self.run_stop.map_or(ChannelSet::EMPTY, ChannelSet::of);
        self.rising | self.falling | run_stop | self.watched
    }
}

/// How fast the regular inputs are driven.
#[derive(Clone, Debug)]
struct Speed {
    /// The shortest period of a regular input.
    period: Span,
    /// The regular inputs.
    regular: ChannelSet,
    /// Last rising edge at each terminal.
    rose: Vec<Time>,
    /// Driven faster.
    over: ChannelSet,
}

impl Inputs {
    /// The inputs of a configuration that was checked.
    pub(in crate::io) fn new(config: &Config) -> Inputs {
        let mut roles = Roles::default();
        let mut regular = ChannelSet::EMPTY;
        let advanced = config.advanced_inputs();
        let used = config.expert.inputs();
        let channels: Vec<InputChannel> = profile::inputs(config.reference)
            .map(|input| {
                let own = config.inputs.get(input.index).copied().unwrap_or_default();
                let n = input.index;
                roles.latch.set(n, own.latch);
                let raises = |high| own.event.is_some_and(|edges| edges.includes(high));
                let (up, down) = (raises(true), raises(false));
                roles.rising.set(n, up || advanced.contains(n));
                roles.falling.set(n, down);
                roles.both.set(n, up && down);
                regular.set(n, input.kind == profile::InputKind::Regular);
                InputChannel::new(input.delay, &own, used.contains(n))
            })
            .collect();
        roles.run_stop = config.run_stop_input;
        let hertz = config.profile.regular_input_hertz().unwrap_or(u32::MAX);
        let count = channels.len();
        Inputs {
            channels,
            filtered: ChannelSet::EMPTY,
            moving: ChannelSet::EMPTY,
            roles,
            latched: ChannelSet::EMPTY,
            operating: false,
            first_fall: ChannelSet::EMPTY,
            ignores_first_fall: config.profile == profile::Profile::M241_2019,
            events: vec![0; count],
            speed: Speed {
                period: Span::from_nanos(1_000_000_000 / i64::from(hertz)),
                regular,
                rose: vec![Time::MIN; count],
                over: ChannelSet::EMPTY,
            },
            accepted: Vec::with_capacity(MOST_ACCEPTED),
            next: Time::MAX,
        }
    }

    /// Every input.
    pub(in crate::io) fn all(&self) -> ChannelSet {
        ChannelSet::first(self.channels.len())
    }

    /// The inputs' electronics come up at `now`: everything behind the terminals starts from 0.
    pub(in crate::io) fn power_on(&mut self, now: Time) {
        self.filtered = ChannelSet::EMPTY;
        self.latched = ChannelSet::EMPTY;
        self.first_fall = ChannelSet::EMPTY;
        self.accepted.clear();
        self.events.fill(0);
        for (n, channel) in self.channels.iter_mut().enumerate() {
            self.moving.set(n, channel.power_on(now));
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
            (self.operating, self.latched) = (operating, ChannelSet::EMPTY);
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
        let turned = (before ^ self.filtered).intersects(self.roles.watched);
        let rose = self.channels[input].set(now, high) && high;
        if !high && !self.channels[input].out() {
            // What was on at power-on is off again before it was accepted: no falling edge of it will come.
            self.first_fall.remove(input);
        }
        self.moving.insert(input);
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
        if soon && speed.regular.contains(input) && !speed.over.contains(input) {
            speed.over.insert(input);
            self.accepted.push(InputEvent::Overdriven(input));
        }
    }

    /// The inputs at 1 after the filters at `now`.
    #[inline]
    pub(in crate::io) fn levels(&mut self, now: Time) -> ChannelSet {
        if !self.moving.is_empty() {
            self.evaluate(now);
        }
        self.filtered
    }

    /// The inputs that a task finds at 1 at `now`, and which inputs it reads: only MAST reads latched ones, and that read empties
    /// their latches (io:STD-IN-04).
    #[inline]
    pub(in crate::io) fn read(&mut self, now: Time, mast: bool) -> (ChannelSet, ChannelSet) {
        let levels = self.levels(now);
        if mast {
            (levels | std::mem::take(&mut self.latched), self.all())
        } else {
            (levels, self.all() - self.roles.latch)
        }
    }

    /// The level behind the filter of the Run/Stop input at `now`, where one is configured.
    pub(in crate::io) fn run_stop(&mut self, now: Time) -> Option<bool> {
        self.roles.run_stop.map(|input| self.levels(now).contains(input))
    }

    /// Whether terminal I`input` is at 1.
    pub(in crate::io) fn terminal(&self, input: usize) -> bool {
        self.channels.get(input).is_some_and(InputChannel::terminal)
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
            self.roles.watched.insert(input);
            self.schedule();
        }
    }

    /// What an observer sees of an input; unknown for one that the reference does not have.
    pub(in crate::io) fn show(&self, input: usize, part: InputProbe) -> Value {
        let Some(events) = self.events.get(input) else { return Value::Unknown };
        let is_in = |set: ChannelSet| Value::Bool(set.contains(input));
        match part {
            InputProbe::Filtered => is_in(self.filtered),
            InputProbe::Latched => is_in(self.latched),
            InputProbe::Events => Value::Int(i64::from(*events)),
            InputProbe::Overdriven => is_in(self.speed.over),
        }
    }

    fn evaluate(&mut self, now: Time) {
        for input in self.moving {
            self.advance(input, now);
            if !self.channels[input].moves() {
                self.moving.remove(input);
            }
        }
    }

    fn advance(&mut self, n: usize, now: Time) {
        let Inputs { channels, filtered, roles, latched, first_fall, events, accepted, .. } = self;
        let operating = self.operating;
        channels[n].advance(now, |_, high| {
            filtered.set(n, high);
            if operating && high && roles.latch.contains(n) {
                latched.insert(n);
            }
            let ignored = !high && first_fall.contains(n);
            if ignored {
                first_fall.remove(n);
            }
            let wanted = if high { roles.rising } else { roles.falling }.contains(n);
            if operating && wanted && !ignored {
                events[n] = events[n].wrapping_add(1);
                accepted.push(InputEvent::Event(n));
            }
            if roles.run_stop == Some(n) {
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
        for input in self.moving & self.roles.attentive() {
            self.next = self.next.min(self.channels[input].next());
        }
    }
}
