//! Observed values: each change becomes an effect.

use super::Controller;
use crate::probes::class;
use crate::{Effect, Effects, Probe, ProbeId, RegisterProbe};
use signal::{Area, Cause, Time};

impl Controller {
    /// From now on, every change of what the probe shows is an [`Effect::Changed`] with the number returned. The
    /// value at this moment is not reported: [`Controller::read`] reads it. A probe that is observed already has its
    /// number again. Variables stay observed over power cycles and downloads.
    pub fn watch(&mut self, probe: Probe) -> ProbeId {
        if let Some(known) = self.probes.find(&probe) {
            return known;
        }
        self.attend_to(probe);
        let number = self.probes.add(probe, self.read(&probe));
        if matches!(probe, Probe::System(_) | Probe::Register(_)) {
            self.start_clocks();
        }
        number
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
            Probe::Input { input, .. } => self.io.watch_input(input),
            Probe::Expert { .. } => self.io.observe_functions(),
            _ => {}
        }
    }

    /// Room for so many observed probes: to observe them takes no memory then.
    pub fn reserve_watches(&mut self, probes: usize) {
        self.probes.reserve(probes);
    }

    /// Ends [`Controller::watch`]. Its number may be that of another probe from now on.
    pub fn unwatch(&mut self, probe: ProbeId) {
        match self.probes.remove(probe) {
            Some(Probe::Address(at)) => self.memory.unwatch(at),
            Some(Probe::Variable(variable)) => {
                if let Some(application) = &mut self.application {
                    application.unwatch(variable);
                }
            }
            // What reports the others costs little, or is shared.
            _ => {}
        }
    }

    /// Has everything report its changes again that stopped doing so when another probe went. However many went, it
    /// is done once, before the next of what the marks are for.
    #[inline]
    pub(super) fn refresh_watches(&mut self) {
        if self.probes.take_stale() {
            self.attend_again();
        }
    }

    #[cold]
    fn attend_again(&mut self) {
        for place in 0..self.probes.len() {
            if let Some(probe @ (Probe::Address(_) | Probe::Variable(_) | Probe::Register(_))) =
                self.probes.get(place)
            {
                self.attend_to(probe);
            }
        }
        self.watch_system();
        self.start_clocks();
    }

    /// Has a new application watch the variables that are observed.
    pub(super) fn watch_again(&mut self) {
        let Some(application) = &mut self.application else { return };
        for probe in self.probes.iter() {
            if let Probe::Variable(variable) = probe {
                application.watch(*variable);
            }
        }
    }

    /// Reports the changes of observed values of these classes; the program sees its system variables change, too.
    #[inline]
    pub(super) fn observe(&mut self, classes: u16, at: Time, cause: Cause, fx: &mut Effects) {
        if classes & (class::STATE | class::FILE) != 0 {
            self.show_system();
        }
        if self.probes.has_class(classes) {
            self.report(classes, at, cause, fx);
        }
    }

    /// Reports the changes of observed memory and variables.
    pub(super) fn observe_memory(&mut self, at: Time, cause: Cause, fx: &mut Effects) {
        self.observe(class::MEMORY | class::VARIABLE, at, cause, fx);
    }

    fn report(&mut self, classes: u16, at: Time, cause: Cause, fx: &mut Effects) {
        self.leds.report(at);
        for place in 0..self.probes.len() {
            let Some(probe) = self.probes.of_class(place, classes) else { continue };
            let value = self.read(&probe);
            if self.probes.update(place, value) {
                let cause = match probe {
                    Probe::Address(address) if address.area() == Area::Output => {
                        self.memory.writer(address.bit_offset() as usize)
                    }
                    _ => cause,
                };
                fx.push(Effect::Changed { at, probe: ProbeId(place as u32), value, cause });
            }
        }
        if self.probes.has_class(class::LED) && classes & (class::STATE | class::LED) != 0 {
            self.leds.set_next(self.next_observed_flash(at));
        }
    }
}
