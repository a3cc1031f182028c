//! Commands by PLC_W (controller: section 14.3), TM3_BUS_W (io: section 11), SERIAL_W and ETH_W: words that the program writes,
//! or somebody outside, and what follows where one passes from 0 to another value.

use super::Controller;
use crate::probes::class;
use crate::{Effects, VariableReset, WriteError};
use profile::{BusWrite, PLC_W_KEY, PlcCommand, PlcWrite, StopCause, SystemField, SystemVariable};
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
        if !variable.is_writable() {
            return Err(WriteError::ReadOnly);
        }
        let number = value.as_int().ok_or(WriteError::NotANumber)? as u16;
        if let (Some(link), Some(application)) = (self.system.links.written(variable), &mut self.application)
        {
            application.write(link, Value::Word(u64::from(number)));
        }
        let opened = self.take_word(variable, number, now);
        self.words_written(opened, StopCause::Network, now, fx);
        Ok(())
    }

    /// The program may have written words: all are taken before a command is executed.
    pub(super) fn check_commands(&mut self, now: Time, fx: &mut Effects) {
        let (mut changed, mut opened) = (false, false);
        for place in 0..self.system.links.written.len() {
            let link = self.system.links.written[place];
            let Some(application) = &self.application else { return };
            let variable = SystemVariable { field: link.field, part: link.part };
            let number = application.read(link.number).as_int().map_or(0, |number| number as u16);
            if number != self.system.words.get(variable) {
                changed = true;
                opened |= self.take_word(variable, number, now);
            }
        }
        if changed {
            self.words_written(opened, StopCause::Program, now, fx);
        }
    }

    /// Takes a word, with what follows of it at once; whether it was the key that has the command executed.
    fn take_word(&mut self, variable: SystemVariable, new: u16, now: Time) -> bool {
        let before = self.system.words.replace(variable, new);
        let is_rise = (before, new) == (0, 1);
        match variable.field {
            // controller:CMD-01, controller:CMD-02
            SystemField::PlcW(PlcWrite::OpenPlcControl) => return (before, new) == (0, PLC_W_KEY),
            // plcsystem:PLCR-11
            SystemField::PlcW(PlcWrite::ResetCounterEvent) if is_rise => self.system.events = 0,
            SystemField::Tm3BusW(BusWrite::ErrorPassive) => self.modules.bus.set_passive(new == 1),
            // It needs active handling and a module in error, with the fault bits that come of it (io:ERR-16, io:ERR-17).
            SystemField::Tm3BusW(BusWrite::Restart) if is_rise => self.modules.bus.restart(now),
            // The counters of serial lines and of Ethernet rest at 0.
            _ => {}
        }
        false
    }

    /// Words were taken: they show, and the command is executed where the key opened it. A command that the state does not
    /// take is no error.
    fn words_written(&mut self, opened: bool, by: StopCause, now: Time, fx: &mut Effects) {
        self.observe(class::STATE | class::LED, now, Cause::Controller, fx);
        if !opened {
            return;
        }
        let _ = match PlcCommand::from_code(self.system.words.get(PlcWrite::PlcControl)) {
            Some(PlcCommand::Stop) => self.command_stop(by, now, fx),
            // A program that runs has no use for it: it comes from outside only.
            Some(PlcCommand::Run) => self.command_run(now, fx),
            Some(PlcCommand::ResetCold) => self.command_reset(VariableReset::COLD, now, fx),
            Some(PlcCommand::ResetWarm) => self.command_reset(VariableReset::WARM, now, fx),
            None => Ok(()),
        };
    }

    /// The words are 0 after every reset, download and boot; the application's own variables have their initial values.
    pub(super) fn clear_commands(&mut self) {
        self.system.words.clear();
        self.modules.bus.set_passive(false);
    }
}
