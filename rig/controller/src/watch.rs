//! Observed values: each change becomes an effect.

use crate::{Controller, Effect, Effects, Probe, ProbeId, RegisterFact};
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
    list: Vec<(Probe, Value)>,
    classes: u16,
}

impl Watches {
    /// Whether a probe is observed.
    pub(crate) fn has(&self, probe: &Probe) -> bool {
        self.list.iter().any(|(known, _)| known == probe)
    }

    /// How many probes are observed.
    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// The probe of this number.
    pub(crate) fn get(&self, place: usize) -> Option<Probe> {
        self.list.get(place).map(|(probe, _)| *probe)
    }
}

impl Controller {
    /// From now on, every change of what the probe shows is an [`Effect::Changed`] with the number returned. The
    /// value at this moment is not reported: [`Controller::read`] tells it. A probe that is observed already has its
    /// number again. Variables stay observed over power cycles and downloads.
    pub fn watch(&mut self, probe: Probe) -> ProbeId {
        if let Some(place) = self.watches.list.iter().position(|(at, _)| *at == probe) {
            return ProbeId(place as u32);
        }
        match probe {
            Probe::Address(at) => self.memory.watch(at),
            Probe::Variable(variable) => {
                if let Some(application) = &mut self.application {
                    application.watch(variable);
                }
            }
            Probe::Register(RegisterFact::Value(register)) => self.watch_register(register),
            Probe::Input { input, .. } => self.inputs.watch(input),
            Probe::Expert { .. } => self.functions.observe(),
            _ => {}
        }
        self.watches.classes |= class_of(&probe);
        self.watches.list.push((probe, self.read(&probe)));
        self.start_clocks();
        ProbeId(self.watches.list.len() as u32 - 1)
    }

    /// Has a new application watch the variables that are observed.
    pub(crate) fn watch_again(&mut self) {
        let Some(application) = &mut self.application else { return };
        for (probe, _) in &self.watches.list {
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
            let (probe, last) = self.watches.list[place];
            if class_of(&probe) & classes == 0 {
                continue;
            }
            let value = self.read(&probe);
            if value != last {
                self.watches.list[place].1 = value;
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
        self.watches.list.iter().map(next).min().unwrap_or(Time::MAX)
    }
}
