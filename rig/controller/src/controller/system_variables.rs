//! What the system variables show, and how a program that mentions them sees them.

use super::Controller;
use crate::probes::class;
use crate::{Effects, Probe, SystemVariable};
use profile::{Family, IoStatus};
use signal::{Cause, Time, Value};

impl Controller {
    /// What a system variable shows; unknown while no service answers.
    pub(super) fn read_system(&self, variable: SystemVariable) -> Value {
        let Some(status) = self.state.status() else { return Value::Unknown };
        let system = &self.system;
        Value::Word(match variable {
            SystemVariable::VendorId => u64::from(profile::VENDOR_ID),
            SystemVariable::Status => u64::from(status.code()),
            SystemVariable::BootProjectStatus => u64::from(system.boot_project.code()),
            SystemVariable::LastStopCause => u64::from(system.stop_cause.code()),
            SystemVariable::LastApplicationError => u64::from(system.error.code()),
            SystemVariable::SystemFault1 => {
                self.external.word(self.modules.bus.status() != IoStatus::Ok, self.modules.tm4_error())
            }
            SystemVariable::IoStatus1 | SystemVariable::LocalIoStatus => match self.local_io_status() {
                Some(status) => u64::from(status.code()),
                None => return Value::Unknown,
            },
            SystemVariable::IoStatus2 => u64::from(self.modules.status(self.state).code()),
            SystemVariable::Tm3BusState => u64::from(self.modules.bus.start_state().code()),
            SystemVariable::ModuleId(index) => u64::from(self.modules.bus.id(usize::from(index))),
            SystemVariable::ModuleState(index) => u64::from(self.module_state(usize::from(index)).code()),
            SystemVariable::ClockBatteryStatus => u64::from(self.system.rtc.charge()),
            SystemVariable::LastStopTime => u64::from(system.dates.stop),
            SystemVariable::LastPowerOffDate => u64::from(system.dates.off),
            SystemVariable::Clock10Ms | SystemVariable::Clock100Ms | SystemVariable::Clock1S => {
                return Value::Bool(system.clocks.level(variable, self.scheduler.now()));
            }
            SystemVariable::EventsCounter => u64::from(system.events),
            SystemVariable::RunStopInput => {
                match (self.config.reference.family, self.config.run_stop_input) {
                    (Family::M251, _) => 0,
                    (Family::M241, Some(input)) => input as u64,
                    (Family::M241, None) => 0xFF,
                }
            }
            SystemVariable::OpenPlcControl => u64::from(system.open),
            SystemVariable::PlcControl => u64::from(system.control),
            SystemVariable::BusErrorPassive => u64::from(system.bus_control.0),
            SystemVariable::BusRestart => u64::from(system.bus_control.1),
        })
    }

    /// Looks up the system variables that a new application mentions.
    pub(super) fn link_system(&mut self) {
        let application = self.application.as_deref();
        let find = |variable: &SystemVariable| Some((*variable, application?.variable(variable.name())?));
        self.system.set_links(SystemVariable::ALL.iter().filter_map(find));
        if application.is_none() {
            return;
        }
        self.watch_system();
        self.start_clocks();
        self.show_system();
    }

    /// Has the application stop where it writes a system variable.
    pub(super) fn watch_system(&mut self) {
        let Some(application) = &mut self.application else { return };
        for (variable, number) in self.system.links() {
            if variable.is_written() {
                application.watch(*number);
            }
        }
    }

    /// Has the edges come of the clock bits that somebody looks at.
    pub(super) fn start_clocks(&mut self) {
        let (now, system, probes) = (self.scheduler.now(), &self.system, &self.probes);
        let mut clocks = system.clocks;
        clocks.observe(now, |variable| {
            system.link(variable).is_some() || probes.find(&Probe::System(variable)).is_some()
        });
        self.system.clocks = clocks;
    }

    /// When the next edge of a clock bit is due.
    pub(super) fn clock_due(&self) -> Time {
        if self.state.status().is_some() { self.system.clocks.next() } else { Time::MAX }
    }

    /// The edges of clock bits due at `now`.
    pub(super) fn fire_clocks(&mut self, now: Time, fx: &mut Effects) {
        if self.clock_due() <= now {
            self.system.clocks.fire(now);
            self.observe(class::STATE, now, Cause::Controller, fx);
        }
    }

    /// Shows the program the system variables that it mentions.
    #[inline]
    pub(super) fn show_system(&mut self) {
        for place in 0..self.system.links().len() {
            let (variable, number) = self.system.links()[place];
            let value = self.read_system(variable);
            if !variable.is_written()
                && value != Value::Unknown
                && let Some(application) = &mut self.application
            {
                application.write(number, value);
            }
        }
    }
}
