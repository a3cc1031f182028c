//! A real controller on the board's lines. It runs by itself: the rig switches its supply and its Run/Stop switch, sees
//! what its alarm output says of its state, and drives and sees its terminals as channels of the board.

use crate::subject::capability::Capability;
use crate::subject::hook::{Hook, HookError};
use crate::subject::{Startup, Subject};
use controller::{Command, CommandError, Effect, Effects, ProbeId, State, Terminal};
use drivers::{Board, BoardFile, ChannelId, External as Settings};
use signal::{Address, Cause, Span, Time, Value, When};
use std::sync::atomic::AtomicBool;

/// The place of the supply among what it drives.
pub const POWER: usize = 0;

/// The place of the Run/Stop switch among what it drives.
pub const RUN_STOP: usize = 1;

/// The place of the alarm line among what it sees.
pub const ALARM: usize = 0;

/// The number of what shows its state.
pub const STATE: ProbeId = ProbeId(0);

/// The state of a controller that has its supply and does not show that it runs: which one it is nobody can see.
pub const NOT_RUNNING: (i64, &str) = (-1, "not RUNNING");

/// How far it is on its way into the state in which a case begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Its supply is not asked for.
    Off,
    /// Its supply stays off until this instant, to be sure of what it begins with.
    Cut(Time),
    /// It boots since the first instant, and is there by the second where nothing shows it.
    Boots(Time, Time),
    /// It is there, not before this instant.
    There(Time),
}

/// A real controller.
#[derive(Debug)]
pub struct ExternalController {
    settings: Settings,
    hook: Hook,
    initial: State,
    has_power: bool,
    has_switch: bool,
    has_alarm: bool,
    /// Whether its supply is on, as far as the rig has to do with it.
    supply: bool,
    /// Where its Run/Stop switch stands.
    run: bool,
    /// What its alarm output says, and since when at the earliest.
    alarm: Option<bool>,
    since: Time,
    way: Way,
    /// The state as it was reported last.
    reported: Value,
    /// The case has begun.
    begun: bool,
    loaded: bool,
}

impl ExternalController {
    /// A controller whose case begins in `initial`, with its switch at Run or not.
    pub fn new(
        file: &BoardFile,
        settings: Settings,
        board: &dyn Board,
        initial: State,
        run: bool,
        hook: Hook,
    ) -> ExternalController {
        let safe = |channel: Option<ChannelId>| {
            let channel = channel.and_then(|channel| board.channels().get(usize::from(channel.0)));
            channel.is_some_and(|channel| channel.safe == Value::Bool(true))
        };
        ExternalController {
            settings,
            hook,
            initial,
            has_power: file.lines.power.is_some(),
            has_switch: file.lines.run_stop.is_some(),
            has_alarm: file.lines.alarm.is_some(),
            // Before the case begins its lines are as safe has them.
            supply: file.lines.power.is_none() || safe(file.lines.power),
            run,
            alarm: None,
            since: Time::ZERO,
            way: Way::Off,
            reported: Value::Unknown,
            begun: false,
            loaded: false,
        }
    }

    /// What its lines show of its state.
    fn shown(&self) -> Value {
        match (self.alarm, self.supply) {
            (Some(true), _) => Value::Int(State::Running.number()),
            (Some(false), false) => Value::Int(State::Off.number()),
            (Some(false), true) => Value::Int(NOT_RUNNING.0),
            (None, _) => Value::Unknown,
        }
    }

    /// Reports the state where it is another one, from `at` on.
    fn report(&mut self, at: Time, effects: &mut Effects) {
        let shown = self.shown();
        // The executor shows where the case begins: there the state and the start are one.
        if self.reported != shown && self.begun {
            self.reported = shown;
            effects.list.push(Effect::Changed { at, probe: STATE, value: shown, cause: Cause::Controller });
        }
    }

    /// Puts one of its lines to a level.
    fn put(at: Time, output: usize, on: bool, effects: &mut Effects) {
        let (terminal, cause) = (Terminal::output(output), Cause::Controller);
        effects.list.push(Effect::Terminal {
            at,
            terminal,
            value: Value::Bool(on),
            cause,
            early: Span::ZERO,
        });
    }

    fn switch_supply(&mut self, now: Time, on: bool, effects: &mut Effects) {
        if self.has_power {
            self.supply = on;
            ExternalController::put(now, POWER, on, effects);
        }
    }

    /// It has its supply from `now` on.
    fn boots(&mut self, now: Time) {
        let by = now.saturating_add(self.settings.boot);
        self.way = match self.initial {
            State::Booting => Way::There(now),
            _ => Way::Boots(now, by),
        };
    }

    /// Lets it come into the state in which the case begins: from its supply on where the rig can do that.
    fn set_out(&mut self, now: Time, effects: &mut Effects) {
        if self.has_power && (self.settings.cycle || self.initial == State::Booting) {
            self.switch_supply(now, false, effects);
            self.way = Way::Cut(now.saturating_add(self.settings.off));
            return;
        }
        self.switch_supply(now, true, effects);
        self.boots(now);
        if let (Way::Boots(_, by), Some(true), State::Running) = (self.way, self.alarm, self.initial) {
            self.way = Way::Boots(self.since, by);
            self.arrive(self.since);
        }
    }

    /// It reached the state in which the case begins, not before `earliest`.
    fn arrive(&mut self, earliest: Time) {
        if let Way::Boots(since, _) = self.way {
            self.way = Way::There(earliest.max(since));
        }
    }
}

impl Subject for ExternalController {
    fn inner(&self) -> Option<&dyn Subject> {
        None
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Subject> {
        None
    }

    fn capabilities(&self) -> &'static [Capability] {
        match (self.has_power, self.has_switch) {
            (true, true) => &[Capability::Power, Capability::RunStop],
            (true, false) => &[Capability::Power],
            (false, true) => &[Capability::RunStop],
            (false, false) => &[],
        }
    }

    fn is_model(&self) -> bool {
        false
    }

    fn state(&self) -> State {
        match self.way {
            Way::Off | Way::Cut(_) => State::Off,
            Way::Boots(..) => State::Booting,
            Way::There(_) => self.initial,
        }
    }

    fn power(&mut self, now: Time, on: bool, effects: &mut Effects) {
        if self.way != Way::Off {
            // A step of the plan.
            self.switch_supply(now, on, effects);
        } else if on {
            if self.has_switch {
                ExternalController::put(now, RUN_STOP, self.run, effects);
            }
            if self.settings.load.is_empty() {
                self.set_out(now, effects);
            } else {
                // The command that loads it finds it switched on.
                self.switch_supply(now, true, effects);
            }
        }
        self.report(now, effects);
    }

    fn run(&mut self, limit: Time, _effects: &mut Effects) -> Time {
        limit
    }

    fn is_computing(&self) -> bool {
        false
    }

    fn next_timer(&self) -> Option<Time> {
        match self.way {
            Way::Cut(until) => Some(until),
            Way::Boots(_, by) => Some(by),
            Way::Off | Way::There(_) => None,
        }
    }

    fn fire(&mut self, now: Time, effects: &mut Effects) {
        match self.way {
            Way::Cut(until) if until <= now => {
                self.switch_supply(now, true, effects);
                self.boots(now);
            }
            // Where its alarm output shows it, silence means that it is not there.
            Way::Boots(since, by) if by <= now => {
                if self.has_alarm && self.initial == State::Running {
                    self.way = Way::Boots(since, Time::MAX);
                } else {
                    self.arrive(since);
                }
            }
            _ => {}
        }
        self.report(now, effects);
    }

    // Its inputs and outputs are the board's alone.
    fn terminal(&self, _: Address) -> Option<Terminal> {
        None
    }

    fn set_input(&mut self, _now: Time, at: When, terminal: Terminal, value: Value, effects: &mut Effects) {
        if terminal != Terminal::input(ALARM) {
            return;
        }
        self.alarm = value.as_bool();
        // It may have changed its state earlier than its output shows.
        let earliest = at.earliest.saturating_add(-self.settings.jitter).max(Time::ZERO);
        self.since = earliest;
        if self.alarm == Some(true) && self.initial == State::Running {
            self.arrive(earliest);
        }
        self.report(earliest, effects);
    }

    fn output(&self, terminal: Terminal) -> Value {
        match terminal {
            terminal if terminal == Terminal::output(POWER) => Value::Bool(self.supply),
            terminal if terminal == Terminal::output(RUN_STOP) => Value::Bool(self.run),
            _ => Value::Unknown,
        }
    }

    fn command(&mut self, now: Time, command: &Command, effects: &mut Effects) -> Result<(), CommandError> {
        match command {
            Command::Switch(run) if self.has_switch => {
                self.run = *run;
                ExternalController::put(now, RUN_STOP, *run, effects);
                Ok(())
            }
            _ => Err(CommandError::State(self.state())),
        }
    }

    fn notice(&mut self, _: Time, _: &str) {}

    fn startup(&mut self) -> Option<&mut dyn Startup> {
        Some(self)
    }
}

impl Startup for ExternalController {
    fn load(&mut self, interrupt: &AtomicBool) -> Result<(), HookError> {
        if self.settings.load.is_empty() {
            return Ok(());
        }
        self.loaded = true;
        self.hook.run("load", &self.settings.load, self.settings.load_within, interrupt)
    }

    fn loaded(&mut self, now: Time, effects: &mut Effects) {
        if self.settings.load.is_empty() {
            return;
        }
        self.set_out(now, effects);
        self.report(now, effects);
    }

    fn unload(&mut self, interrupt: &AtomicBool) -> Result<(), HookError> {
        if self.settings.unload.is_empty() || !self.loaded && !self.settings.load.is_empty() {
            return Ok(());
        }
        self.loaded = false;
        self.hook.run("unload", &self.settings.unload, self.settings.load_within, interrupt)
    }

    fn limit(&self) -> Span {
        let (boot, off) = (self.settings.boot, self.settings.off);
        Span::from_nanos(boot.as_nanos().saturating_add(off.as_nanos())) + Span::from_secs(1)
    }

    fn begin(&mut self) -> Option<(Time, Value)> {
        let Way::There(earliest) = self.way else { return None };
        self.begun = true;
        self.reported = self.shown();
        Some((earliest, self.reported))
    }

    fn state_probe(&self) -> Option<ProbeId> {
        Some(STATE)
    }
}

/// Whatever ended the case, what was loaded is unloaded.
impl Drop for ExternalController {
    fn drop(&mut self) {
        if self.loaded {
            let _ = self.unload(&AtomicBool::new(false));
        }
    }
}
