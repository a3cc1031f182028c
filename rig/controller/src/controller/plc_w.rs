//! Commands by PLC_W (controller: section 14.3) and TM3_BUS_W (io: section 11): written by the program, or from outside.

use super::Controller;
use crate::probes::class;
use crate::{Effects, SystemVariable, VariableReset, WriteError};
use profile::{PLC_W_KEY, PlcCommand, StopCause};
use signal::{Cause, Time, Value};

impl Controller {
    /// Somebody outside writes a system variable (controller:CMD-03, controller:CMD-04).
    pub(super) fn write_system(
        &mut self,
        variable: SystemVariable,
        value: Value,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), WriteError> {
        if !variable.is_written() {
            return Err(WriteError::ReadOnly);
        }
        let number = value.as_int().ok_or(WriteError::NotANumber)? as u16;
        if let (Some(link), Some(application)) = (self.system.link(variable), &mut self.application) {
            application.write(link, Value::Word(u64::from(number)));
        }
        let (passive, restart) = self.system.bus_control;
        match variable {
            SystemVariable::BusErrorPassive => {
                self.set_bus_control((number, restart), now, fx);
                return Ok(());
            }
            SystemVariable::BusRestart => {
                self.set_bus_control((passive, number), now, fx);
                return Ok(());
            }
            _ => {}
        }
        let (control, open) = match variable {
            SystemVariable::PlcControl => (number, self.system.open),
            _ => (self.system.control, number),
        };
        self.set_plc_w(control, open, StopCause::Network, now, fx);
        Ok(())
    }

    /// The program may have written PLC_W or TM3_BUS_W.
    pub(super) fn check_commands(&mut self, now: Time, fx: &mut Effects) {
        self.check_bus_control(now, fx);
        self.check_plc_w(now, fx);
    }

    fn check_bus_control(&mut self, now: Time, fx: &mut Effects) {
        let Some(application) = &self.application else { return };
        let written = |variable, now| {
            let link = self.system.link(variable)?;
            Some(application.read(link).as_int().map_or(now, |number| number as u16))
        };
        let (passive, restart) = self.system.bus_control;
        let control = (
            written(SystemVariable::BusErrorPassive, passive).unwrap_or(passive),
            written(SystemVariable::BusRestart, restart).unwrap_or(restart),
        );
        if control != self.system.bus_control {
            self.set_bus_control(control, now, fx);
        }
    }

    /// Takes the commands to the expansion bus: how it handles errors, and from 0 to 1 its restart, which needs active handling
    /// and a module in error, with the fault bits that come of it (io:ERR-16, io:ERR-17).
    fn set_bus_control(&mut self, control: (u16, u16), now: Time, fx: &mut Effects) {
        let before = std::mem::replace(&mut self.system.bus_control, control);
        self.modules.bus.set_passive(control.0 == 1);
        if (before.1, control.1) == (0, 1) {
            self.modules.bus.restart(now);
        }
        self.observe(class::STATE | class::LED, now, Cause::Controller, fx);
    }

    fn check_plc_w(&mut self, now: Time, fx: &mut Effects) {
        let (Some(open), Some(application)) =
            (self.system.link(SystemVariable::OpenPlcControl), &self.application)
        else {
            return;
        };
        let number = |link: u32| application.read(link).as_int().map_or(0, |number| number as u16);
        let control = self.system.link(SystemVariable::PlcControl).map_or(0, number);
        let open = number(open);
        if (control, open) != (self.system.control, self.system.open) {
            self.set_plc_w(control, open, StopCause::Program, now, fx);
        }
    }

    /// Takes the values, and executes the command where the key passes from 0 to its value (controller:CMD-01,
    /// controller:CMD-02). A command that the state does not take is no error.
    fn set_plc_w(&mut self, control: u16, open: u16, by: StopCause, now: Time, fx: &mut Effects) {
        let before = std::mem::replace(&mut self.system.open, open);
        self.system.control = control;
        self.observe(class::STATE, now, Cause::Controller, fx);
        if before != 0 || open != PLC_W_KEY {
            return;
        }
        let _ = match PlcCommand::from_code(control) {
            Some(PlcCommand::Stop) => self.command_stop(by, now, fx),
            // A program that runs has no use for it: it comes from outside only.
            Some(PlcCommand::Run) => self.command_run(now, fx),
            Some(PlcCommand::ResetCold) => self.command_reset(VariableReset::COLD, now, fx),
            Some(PlcCommand::ResetWarm) => self.command_reset(VariableReset::WARM, now, fx),
            None => Ok(()),
        };
    }

    /// PLC_W and TM3_BUS_W are 0 after every reset, download and boot; the application's own variables have their initial values.
    pub(super) fn clear_plc_w(&mut self) {
        (self.system.control, self.system.open) = (0, 0);
        self.system.bus_control = (0, 0);
        self.modules.bus.set_passive(false);
        self.registers.set_writable(0, 0);
    }
}
