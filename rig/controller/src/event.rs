//! Events of the hardware, and the rate at which events may come.

use crate::{Config, Controller, Effects, LogEntry, State, TaskKind};
use profile::{ApplicationError, EVENT_LATENCY, EVENT_WINDOW, Family, Profile, Reference};
use signal::{Address, Area, Size, Time};
use std::fmt;

/// What starts an external event task (controller:TASK-41, io:EVT-02).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EventSource {
    /// An edge at In.
    Input(usize),
    /// A threshold of a fast counter.
    Threshold {
        /// The counter.
        counter: u8,
        /// The threshold.
        threshold: u8,
    },
    /// The stop of a fast counter.
    CounterStop(u8),
    /// SYNC of the CANopen manager.
    CanSync,
}

impl EventSource {
    /// The event of this name: the address of an input, or the name of the profile's documents (io:EVT-04), such as
    /// `HSC0_STOP` (`BLOCK0_HSCSTOP` in 2014), `HSC0_TH1` (`BLOCK0_TH1`), `CAN_1_SYNC`, in any case of letters.
    pub fn find(name: &str, profile: Profile) -> Option<EventSource> {
        if let Ok(at) = Address::parse(name) {
            let input = at.area() == Area::Input && at.size() == Size::Bit;
            return usize::try_from(at.bit_offset()).ok().filter(|_| input).map(EventSource::Input);
        }
        let name = name.to_ascii_uppercase();
        if name == "CAN_1_SYNC" {
            return Some(EventSource::CanSync);
        }
        let (block, stop) = match profile {
            Profile::M241_2014 => ("BLOCK", "HSCSTOP"),
            Profile::M241_2019 | Profile::M251_2024 => ("HSC", "STOP"),
        };
        let (counter, event) = name.strip_prefix(block)?.split_once('_')?;
        let digit = |text: &str| text.parse().ok().filter(|_| text.len() == 1);
        let counter = digit(counter)?;
        if event == stop {
            return Some(EventSource::CounterStop(counter));
        }
        Some(EventSource::Threshold { counter, threshold: digit(event.strip_prefix("TH")?)? })
    }

    /// Whether this controller has the event: an M241 those of the inputs I0...I7, in 2014 of I8...I11 too, and those
    /// of its counters; a controller with CANopen SYNC (controller:TASK-41, controller:TASK-45, io:EVT-03).
    pub fn exists(self, profile: Profile, reference: &Reference) -> bool {
        let inputs = if profile == Profile::M241_2014 { 12 } else { 8 };
        match self {
            EventSource::Input(input) => {
                reference.family == Family::M241 && input < inputs && input < reference.input_count()
            }
            EventSource::Threshold { .. } | EventSource::CounterStop(_) => reference.family == Family::M241,
            EventSource::CanSync => reference.canopen,
        }
    }
}

impl fmt::Display for EventSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EventSource::Input(input) => write!(f, "%IX{}.{}", input / 8, input % 8),
            EventSource::Threshold { counter, threshold } => write!(f, "HSC{counter}_TH{threshold}"),
            EventSource::CounterStop(counter) => write!(f, "HSC{counter}_STOP"),
            EventSource::CanSync => f.write_str("CAN_1_SYNC"),
        }
    }
}

/// The instants of the last events: one more than the limit within the window is too many.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EventRate {
    last: [Time; 6],
    next: usize,
}

impl EventRate {
    pub(crate) const fn new() -> EventRate {
        EventRate { last: [Time::MIN; 6], next: 0 }
    }

    /// Counts an event at `now`; whether it is the one that exceeds `limit` within [`EVENT_WINDOW`]
    /// (controller:TASK-31). Events a whole window apart are not in one window.
    fn exceeded(&mut self, now: Time, limit: usize) -> bool {
        let limit = limit.clamp(1, self.last.len());
        let place = self.next % limit;
        let before = std::mem::replace(&mut self.last[place], now);
        self.next = (place + 1) % limit;
        before != Time::MIN && before.saturating_add(EVENT_WINDOW) > now
    }
}

/// Events on their way to the tasks that they release, oldest first: all take the same time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EventQueue {
    list: [(Time, usize); 32],
    first: usize,
    count: usize,
}

impl EventQueue {
    pub(crate) const fn new() -> EventQueue {
        EventQueue { list: [(Time::MAX, 0); 32], first: 0, count: 0 }
    }

    /// When the next one arrives; [`Time::MAX`] for none.
    #[inline]
    pub(crate) fn next(&self) -> Time {
        if self.count == 0 { Time::MAX } else { self.list[self.first].0 }
    }

    /// FALSE where there is no room: the event is lost.
    fn put(&mut self, at: Time, rank: usize) -> bool {
        if self.count == self.list.len() {
            return false;
        }
        self.list[(self.first + self.count) % self.list.len()] = (at, rank);
        self.count += 1;
        true
    }

    /// The rank of the task whose event has arrived by `now`.
    pub(crate) fn take(&mut self, now: Time) -> Option<usize> {
        if self.next() > now {
            return None;
        }
        let (_, rank) = self.list[self.first];
        self.first = (self.first + 1) % self.list.len();
        self.count -= 1;
        Some(rank)
    }
}

impl Config {
    /// Whether the input of an event is configured to raise it, on a controller that has the event. An advanced input
    /// of 2014 beyond the fast ones needs no configuration (io:EVT-03).
    pub(crate) fn raises(&self, source: EventSource) -> bool {
        match source {
            EventSource::Input(input) if input < self.reference.fast_inputs => {
                self.inputs.get(input).is_some_and(|input| input.event.is_some())
            }
            _ => true,
        }
    }

    /// The inputs that raise events on rising edges because a task is started by them, bit n for In (io:EVT-03).
    pub(crate) fn advanced_inputs(&self) -> u32 {
        self.tasks.iter().fold(0, |mask, task| match task.kind {
            TaskKind::ExternalEvent { source: EventSource::Input(input) }
                if (self.reference.fast_inputs..32).contains(&input) =>
            {
                mask | 1 << input
            }
            _ => mask,
        })
    }
}

impl Controller {
    /// An event of the hardware at `now`: it releases the external event tasks of this source
    /// [`profile::EVENT_LATENCY`] later (controller:TASK-40, io:EVT-01). Nothing happens outside RUNNING. More
    /// events than the 2019 profile takes stop the application (controller:TASK-43).
    pub fn external_event(&mut self, source: EventSource, now: Time, fx: &mut Effects) {
        for rank in 0..self.tasks.len() {
            if self.state != State::Running || self.cpu.stopping.is_some() {
                return;
            }
            if self.tasks[rank].source != Some(source) {
                continue;
            }
            if !self.arrivals.put(now.saturating_add(EVENT_LATENCY), rank) {
                self.tasks[rank].figures.lost += 1;
            }
            let limit = self.config.profile.event_limit();
            if self.config.profile == Profile::M241_2019 && self.external_rate.exceeded(now, limit) {
                self.too_many_events(now, fx);
            }
        }
    }

    /// A Boolean variable became TRUE that starts the task of this rank (controller:TASK-30).
    pub(crate) fn software_event(&mut self, rank: usize, now: Time, fx: &mut Effects) {
        self.make_ready(rank, now);
        if self.event_rate.exceeded(now, self.config.profile.event_limit()) {
            self.too_many_events(now, fx);
        }
    }

    /// controller:WD-06
    fn too_many_events(&mut self, now: Time, fx: &mut Effects) {
        self.log_entry(now, LogEntry::TooManyEvents, fx);
        self.enter_halt(now, ApplicationError::TooManyEvents, fx);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // controller:TASK-41, io:EVT-02, io:EVT-03, io:EVT-04
    #[test]
    fn events_of_each_profile() {
        let (old, new, m251) = (Profile::M241_2014, Profile::M241_2019, Profile::M251_2024);
        let exists = |name: &str, profile: Profile| {
            EventSource::find(name, profile)
                .is_some_and(|source| source.exists(profile, profile.default_reference()))
        };
        for (name, expected) in [
            ("%IX0.0", [true, true, false]),
            ("%IX0.7", [true, true, false]),
            ("%IX1.0", [true, false, false]),
            ("%IX1.3", [true, false, false]),
            ("%IX1.4", [false; 3]),
            ("%QX0.0", [false; 3]),
            ("%IB0", [false; 3]),
            ("BLOCK0_HSCSTOP", [true, false, false]),
            ("block1_th0", [true, false, false]),
            ("HSC0_STOP", [false, true, false]),
            ("HSC7_TH1", [false, true, false]),
            ("HSC_STOP", [false; 3]),
            ("HSC10_STOP", [false; 3]),
            ("CAN_1_SYNC", [true; 3]),
            ("CAN_2_SYNC", [false; 3]),
        ] {
            assert_eq!([old, new, m251].map(|profile| exists(name, profile)), expected, "{name}");
        }
        let mese = Reference::find("TM251MESE").unwrap();
        assert!(!EventSource::CanSync.exists(m251, mese));
    }

    // controller:TASK-31
    #[test]
    fn one_event_more_than_the_limit_in_a_window() {
        let us = |n: i64| Time::from_nanos(n * 1_000);
        let exceeded = |times: &[i64], limit| {
            let mut rate = EventRate::new();
            times.iter().map(|at| rate.exceeded(us(*at), limit)).collect::<Vec<_>>()
        };
        assert_eq!(exceeded(&[0, 1, 2, 3, 4, 5], 5), [false, false, false, false, false, true]);
        assert_eq!(exceeded(&[0, 1, 2, 3, 4, 5, 999], 6), [false, false, false, false, false, false, true]);
        assert_eq!(exceeded(&[0, 1, 2, 3, 4, 5, 1000], 6), [false; 7]);
        // One at the very beginning of time is an event like any other.
        assert_eq!(exceeded(&[0, 0, 0], 2), [false, false, true]);
    }
}
