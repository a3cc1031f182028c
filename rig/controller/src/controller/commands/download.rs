//! Download (controller: section 14.9).

use crate::CommandError;
use crate::controller::Controller;
use crate::controller::transition::ApplicationStart;
use crate::first_cycle::FirstCycle;
use crate::{APPLICATION_FILE, Application, Effects, LoadError, LogEntry, State, VariableReset};
use profile::{Family, StopCause};
use signal::Time;

impl Controller {
    /// Download (controller:DL-02, controller:TR-16): RETAIN variables and other data start again, persistent ones that
    /// both applications have and %MW0...%MW999 are kept. With `boot` it becomes the boot application too
    /// (controller:STATE-12).
    pub(in crate::controller) fn command_download(
        &mut self,
        bundle: &[u8],
        boot: bool,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        self.check_recoverable()?;
        let runs = matches!(self.state, State::Running | State::Breakpoint);
        if !runs && !matches!(self.state, State::Stopped | State::Halt | State::Empty) {
            return Err(CommandError::State(self.state));
        }
        self.replace(bundle, boot, now, fx)?;
        self.initial_outputs(ApplicationStart::Download, State::Stopped, now, fx);
        self.rest(State::Stopped, now, fx);
        Ok(())
    }

    /// Multiple download (controller:TR-19, controller:TR-20): never writes the boot application (controller:STATE-13).
    pub(in crate::controller) fn command_multiple_download(
        &mut self,
        bundle: &[u8],
        start: bool,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        self.check_recoverable()?;
        let halt = self.state == State::Halt && self.config.reference.family == Family::M241;
        if !halt && !matches!(self.state, State::Running | State::Breakpoint | State::Stopped | State::Empty)
        {
            return Err(CommandError::State(self.state));
        }
        self.replace(bundle, false, now, fx)?;
        if start && self.may_run(now).is_ok() {
            self.initial_outputs(ApplicationStart::Download, State::Running, now, fx);
            self.enter_running(now, fx);
        } else {
            self.initial_outputs(ApplicationStart::Download, State::Stopped, now, fx);
            self.rest(State::Stopped, now, fx);
        }
        Ok(())
    }

    /// Another application takes the place of the one in memory, which is erased first.
    fn replace(
        &mut self,
        bundle: &[u8],
        boot: bool,
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        let cause = self.stopped_by(StopCause::User);
        let old = self.application.take();
        self.scheduler.abort_cycles();
        self.remanent.abandon();
        self.power.creating = None;
        self.clear_diagnostics(cause);
        match self.build(bundle) {
            Ok(new) => {
                self.take_over(old, new, bundle, boot, now, fx);
                Ok(())
            }
            Err(error) => {
                self.fail_download(error, boot, now, fx);
                Err(CommandError::Application(error))
            }
        }
    }

    fn take_over(
        &mut self,
        old: Option<Box<dyn Application>>,
        mut new: Box<dyn Application>,
        bundle: &[u8],
        boot: bool,
        now: Time,
        fx: &mut Effects,
    ) {
        self.log_warnings(&*new, now, fx);
        new.reset(VariableReset::ALL);
        if let Some(old) = old {
            let mut image = vec![0; old.retained_len()];
            old.save_retained(&mut image);
            new.adopt_retained(&old.retained_map(), &image);
        }
        self.memory.reset(|word| !new.associates(word));
        new.initialize(&mut self.memory);
        self.io.reset_functions(now);
        self.system.events = 0;
        self.remanent.newest(self.files.store());
        self.remanent.prepare(&*new, boot, self.files.store_mut());
        self.remanent.save_now(&*new, &self.memory, self.files.store_mut());
        self.system.first_cycle = FirstCycle::Cold;
        self.install(new, bundle);
        if boot {
            self.create_boot_application(now);
        } else {
            self.boot_file_changed();
        }
    }

    /// controller:DL-04: the old application is already erased.
    fn fail_download(&mut self, error: LoadError, boot: bool, now: Time, fx: &mut Effects) {
        self.log_entry(now, LogEntry::Load(error), fx);
        self.unload(now);
        if boot {
            self.files.store_mut().remove(APPLICATION_FILE);
        }
        self.boot_file_changed();
        self.enter(State::Empty, now, fx);
    }
}
