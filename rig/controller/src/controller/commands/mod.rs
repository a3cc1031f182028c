//! What commands do (controller: section 14.4).

mod boot_application;
mod download;
mod origin;
mod reboot;
mod reset;
mod run_stop;

use super::Controller;
use crate::probes::class;
use crate::{Command, CommandError, Effects, VariableReset};
use profile::StopCause;
use signal::{Cause, Time};

impl Controller {
    /// Obeys a command at `now`, between two operations of the application.
    ///
    /// # Errors
    /// [`CommandError`]; nothing has happened then, except that a download whose application is not valid has erased the
    /// old one.
    pub fn command(&mut self, now: Time, command: Command, fx: &mut Effects) -> Result<(), CommandError> {
        self.scheduler.idle_until(now);
        let done = match command {
            Command::Run => self.command_run(now, fx),
            Command::Stop => self.command_stop(StopCause::User, now, fx),
            Command::ResetWarm => self.command_reset(VariableReset::WARM, now, fx),
            Command::ResetCold => self.command_reset(VariableReset::COLD, now, fx),
            Command::ResetOrigin => self.command_reset_origin(now, fx),
            Command::ResetOriginDevice(reset) => self.command_reset_origin_device(reset, now, fx),
            Command::Reboot => self.command_reboot(now, fx),
            Command::Download(bundle) => self.command_download(&bundle, true, now, fx),
            Command::DownloadToMemory(bundle) => self.command_download(&bundle, false, now, fx),
            Command::MultipleDownload { bundle, start } => {
                self.command_multiple_download(&bundle, start, now, fx)
            }
            Command::CreateBootApplication => self.command_create_boot_application(now, fx),
            Command::PlaceBootApplication(bundle) => self.command_place_boot_application(&bundle, now, fx),
            Command::DeleteApplication => self.command_delete_application(now, fx),
            Command::Firmware { valid } => self.command_firmware(valid),
            Command::Force { address, value } => self.force(address, Some(value)),
            Command::Unforce(address) => self.force(address, None),
            Command::Switch(run) => {
                self.move_switch(run, now, fx);
                Ok(())
            }
            Command::OnlineChange(bundle) => self.command_online_change(&bundle, now, fx),
            Command::Breakpoint { file, line } => self.set_breakpoint(file, line),
            Command::Resume => self.resume(now, fx),
            Command::StepStatement => self.step_statement(now, fx),
            Command::ClearBreakpoints => {
                self.clear_breakpoints(now, fx);
                Ok(())
            }
            Command::LogIn => self.log_in(now, fx),
            Command::LogOut { keep_forcing } => self.log_out(keep_forcing, now, fx),
            Command::Identify(on) => self.identify(on, now, fx),
            Command::SetClock { seconds } => self.set_clock(seconds, now),
        };
        self.observe(class::FILE, now, Cause::Controller, fx);
        done
    }

    /// plcsystem:FUN-03
    fn set_clock(&mut self, seconds: i64, now: Time) -> Result<(), CommandError> {
        self.state.status().ok_or(CommandError::State(self.state))?;
        self.system.rtc.set(seconds, now);
        Ok(())
    }

    /// controller:LED-03
    fn identify(&mut self, on: bool, now: Time, fx: &mut Effects) -> Result<(), CommandError> {
        self.state.status().ok_or(CommandError::State(self.state))?;
        self.leds.identify(on);
        self.observe(class::STATE, now, Cause::Controller, fx);
        Ok(())
    }
}
