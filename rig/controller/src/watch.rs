//! Observed values: each change becomes an effect.

use crate::{Controller, Effect, Effects, Probe, ProbeId, RegisterProbe};
use signal::{Area, Cause, Time, Value};

/// What can change together: probes are looked at only when something of their kind happened.
pub(crate) mod class {
    pub const MEMORY: u16 = 1;
    pub const VARIABLE: u16 = 2;
    pub const STATE: u16 = 4;
    pub const FIGURE: u16 = 8;
    pub const TERMINAL: u16 = 16;
    pub const INPUT: u16 = 32;
    pub const LED: u16 = 64;
    pub const FILE: u16 = 128;
    pub const EXPERT: u16 = 256;
    pub const ALL: u16 = 511;
}

fn class_of(probe: &Probe) -> u16 {
    match probe {
        Probe::Address(_) => class::MEMORY,
        Probe::Variable(_) => class::VARIABLE,
        Probe::State | Probe::System(_) | Probe::Led(_) => class::STATE,
        Probe::LedLit(_) => class::STATE | class::LED,
        Probe::TaskFigure { .. } => class::FIGURE,
        Probe::Input { .. } => class::INPUT,
        Probe::Terminal(_) | Probe::Output(_) => class::TERMINAL,
        Probe::File(_) => class::FILE,
        Probe::Expert { .. } => class::EXPERT,
        Probe::Register(_) => class::MEMORY | class::VARIABLE | class::STATE | class::FILE,
    }
}

/// The observed probes with their last values.
#[derive(Clone, Debug, Default)]
pub(crate) struct Watches {
    /// Nothing at the places of those that are observed no more: the next ones take them.
    list: Vec<Option<(Probe, Value)>>,
    /// Of the observed probes; of some that were, too, while `torn`.
    classes: u16,
    /// A probe went, and marks that it had in common with others went with it.
    torn: bool,
}

impl Watches {
    /// Whether a probe is observed.
    pub(crate) fn has(&self, probe: &Probe) -> bool {
        self.list.iter().flatten().any(|(known, _)| known == probe)
    }

    /// Behind the last place of an observed probe.
    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// The probe of this number.
    pub(crate) fn get(&self, place: usize) -> Option<Probe> {
        self.list.get(place)?.map(|(probe, _)| probe)
    }
}

impl Controller {
    /// From now on, every change of what the probe shows is an [`Effect::Changed`] with the number returned. The
    /// value at this moment is not reported: [`Controller::read`] tells it. A probe that is observed already has its
    /// number again. Variables stay observed over power cycles and downloads.
    pub fn watch(&mut self, probe: Probe) -> ProbeId {
        let known = self.watches.list.iter().position(|at| at.is_some_and(|(at, _)| at == probe));
        if let Some(place) = known {
            return ProbeId(place as u32);
        }
        self.attend_to(probe);
        self.watches.classes |= class_of(&probe);
        let watched = Some((probe, self.read(&probe)));
        let free = self.watches.list.iter().position(Option::is_none);
        let place = free.unwrap_or(self.watches.list.len());
        match self.watches.list.get_mut(place) {
            Some(free) => *free = watched,
            None => self.watches.list.push(watched),
        }
        if matches!(probe, Probe::System(_)) {
            self.start_clocks();
        }
        ProbeId(place as u32)
    }

    /// Has the parts that a probe reads report its changes.
    fn attend_to(&mut self, probe: Probe) {
        match probe {
            Probe::Address(at) => self.memory.watch(at),
            Probe::Variable(variable) => {
                if let Some(application) = &mut self.application {
                    application.watch(variable);
                }
            }
            Probe::Register(RegisterProbe::Value(register)) => self.watch_register(register),
            Probe::Input { input, .. } => self.inputs.watch(input),
            Probe::Expert { .. } => self.functions.observe(),
            _ => {}
        }
    }

    /// Room for so many observed probes: to observe them takes no memory then.
    pub fn reserve_watches(&mut self, probes: usize) {
        self.watches.list.reserve(probes.saturating_sub(self.watches.list.len()));
    }

    /// Ends [`Controller::watch`]. Its number may be that of another probe from now on.
    pub fn unwatch(&mut self, probe: ProbeId) {
        let place = self.watches.list.get_mut(probe.0 as usize);
        let Some((probe, _)) = place.and_then(Option::take) else { return };
        match probe {
            Probe::Address(at) => self.memory.unwatch(at),
            Probe::Variable(variable) => {
                if let Some(application) = &mut self.application {
                    application.unwatch(variable);
                }
            }
            // What tells of the others costs little, or is shared.
            _ => {}
        }
        self.watches.torn = true;
    }

    /// Has everything report its changes again that stopped doing so when another probe went. However many went, it
    /// is done once, before the next of what the marks are for.
    #[inline]
    pub(crate) fn refresh_watches(&mut self) {
        if std::mem::take(&mut self.watches.torn) {
            self.attend_again();
        }
    }

    #[cold]
    fn attend_again(&mut self) {
        self.watches.classes = 0;
        for place in 0..self.watches.list.len() {
            let Some((probe, _)) = self.watches.list[place] else { continue };
            self.watches.classes |= class_of(&probe);
            if matches!(probe, Probe::Address(_) | Probe::Variable(_) | Probe::Register(_)) {
                self.attend_to(probe);
            }
        }
        self.watch_system();
        self.start_clocks();
    }

    /// Has a new application watch the variables that are observed.
    pub(crate) fn watch_again(&mut self) {
        let Some(application) = &mut self.application else { return };
        for (probe, _) in self.watches.list.iter().flatten() {
            if let Probe::Variable(variable) = probe {
                application.watch(*variable);
            }
        }
    }

    /// Reports the changes of observed values of these classes; the program sees its system variables change, too.
    #[inline]
    pub(crate) fn observe(&mut self, classes: u16, at: Time, cause: Cause, fx: &mut Effects) {
        if classes & class::STATE != 0 {
            self.show_system();
        }
        if self.watches.classes & classes != 0 {
            self.report(classes, at, cause, fx);
        }
    }

    /// Reports the changes of observed memory and variables.
    pub(crate) fn observe_memory(&mut self, at: Time, cause: Cause, fx: &mut Effects) {
        self.observe(class::MEMORY | class::VARIABLE, at, cause, fx);
    }

    fn report(&mut self, classes: u16, at: Time, cause: Cause, fx: &mut Effects) {
        self.leds.seen = at;
        for place in 0..self.watches.list.len() {
            let Some((probe, last)) = self.watches.list[place] else { continue };
            if class_of(&probe) & classes == 0 {
                continue;
            }
            let value = self.read(&probe);
            if value != last {
                self.watches.list[place] = Some((probe, value));
                let cause = match probe {
                    Probe::Address(address) if address.area() == Area::Output => {
                        self.memory.writer(address.bit_offset())
                    }
                    _ => cause,
                };
                fx.push(Effect::Changed { at, probe: ProbeId(place as u32), value, cause });
            }
        }
        if self.watches.classes & class::LED != 0 && classes & (class::STATE | class::LED) != 0 {
            self.leds.next = self.next_observed_flash(at);
        }
    }

    /// When an observed indicator is lit or goes dark next.
    fn next_observed_flash(&self, now: Time) -> Time {
        let next = |(probe, _): &(Probe, Value)| match probe {
            Probe::LedLit(led) => self.next_flash(*led, now),
            _ => Time::MAX,
        };
        self.watches.list.iter().flatten().map(next).min().unwrap_or(Time::MAX)
    }
}
