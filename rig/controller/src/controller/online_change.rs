//! Online change: another application takes over while the controller runs, and variables keep their values
//! (controller:TR-17, controller:TR-18, controller:STATE-13). It takes no modelled time, and waits for the end of the
//! cycles under way as a stop does, so that no cycle is half of one application.

use super::Controller;
use crate::CommandError;
use crate::probes::class;
use crate::{Application, Effects, LogEntry, State};
use profile::StopCause;
use signal::{Cause, Time};

/// An application that will take over.
pub(super) struct Pending {
    application: Box<dyn Application>,
    bundle: Vec<u8>,
}

impl Controller {
    /// Online change (controller:TR-17, controller:TR-18).
    pub(super) fn command_online_change(
        &mut self,
        bundle: &[u8],
        now: Time,
        fx: &mut Effects,
    ) -> Result<(), CommandError> {
        if !matches!(self.state, State::Running | State::Stopped) {
            return Err(CommandError::State(self.state));
        }
        if self.scheduler.stopping().is_some() {
            return Err(CommandError::Stopping);
        }
        let application = self.build(bundle).map_err(CommandError::Change)?;
        self.pending = Some(Pending { application, bundle: bundle.to_vec() });
        self.scheduler.set_changing(true);
        if self.scheduler.is_between_cycles() {
            self.change(now, fx);
        }
        Ok(())
    }

    /// The application that waits takes over, no cycle being under way.
    pub(super) fn change(&mut self, now: Time, fx: &mut Effects) {
        let Some(Pending { mut application, bundle }) = self.pending.take() else { return };
        self.scheduler.set_changing(false);
        let Some(old) = &mut self.application else { return };
        let Some(code_only) = application.succeed(&mut **old) else { return };
        self.application = Some(application);
        self.attach();
        self.bundle = bundle;
        self.boot_file_changed();
        if let Some(application) = &self.application {
            // A save under way was of the old application.
            self.remanent.prepare_change(&**application, self.files.store_mut());
        }
        self.remanent.dirty = true;
        self.save_if_dirty(now);
        self.save_last_state(self.state);
        self.log_entry(now, LogEntry::OnlineChange { code_only }, fx);
        self.observe(class::ALL, now, Cause::Controller, fx);
        if self.state == State::Running && self.scheduler.stopping().is_none() {
            let inhibited = match self.may_run(now) {
                Ok(()) => return,
                Err(CommandError::RunStopInput) => StopCause::Input,
                Err(_) => StopCause::Switch,
            };
            self.enter_stopped(now, inhibited, fx);
        }
    }
}
