//! The end of BOOTING: the boot application is loaded, the saved context checked, the state decided.

use super::Controller;
use super::transition::ApplicationStart;
use crate::boot::{BootFacts, decide};
use crate::first_cycle::FirstCycle;
use crate::last_state::LastState;
use crate::remanent::Saved;
use crate::{APPLICATION_FILE, Application, Effects, LogEntry, RETAIN_MAP, State, VariableReset};
use profile::{BootProjectStatus, Profile, StopCause};
use signal::Time;

/// What the check of the context found (controller:STATE-10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Check {
    /// Application and remanent variables are those of the boot application.
    Valid,
    /// No whole context, or one with variables that the application does not have (controller:REM-06).
    Variables,
    /// A context of another application with the same variables.
    Application,
}

impl Controller {
    /// Loads the boot application and decides the state (controller:TR-02...07).
    pub(super) fn end_boot(&mut self, now: Time, fx: &mut Effects) {
        let LastState { state: previous, signature: before, .. } = LastState::load(self.files.store());
        let loaded = self.power.firmware && !self.power.system_error;
        let bundle = self.files.store().read(APPLICATION_FILE).filter(|_| loaded);
        let mut invalid = false;
        let application = bundle.and_then(|bundle| match self.build(&bundle) {
            Ok(application) => Some((application, bundle)),
            Err(error) => {
                invalid = true;
                self.log_entry(now, LogEntry::Load(error), fx);
                None
            }
        });
        let mut facts = BootFacts {
            profile: self.config.profile,
            family: self.config.reference.family,
            firmware: self.power.firmware,
            system_error: self.power.system_error,
            application: application.is_some(),
            remanents: false,
            same: false,
            previous,
            mode: self.config.starting_mode,
            switch_at_run: self.power.switch_at_run,
            run_input: self.io.run_stop(now),
            script: self.power.script,
        };
        let mut check = Check::Valid;
        if let Some((application, bundle)) = application {
            facts.same = application.signature() == before;
            check = self.load(application, &bundle, now, fx);
            facts.remanents = check == Check::Valid;
            self.system.first_cycle = if facts.remanents { FirstCycle::Warm } else { FirstCycle::Cold };
        }
        self.boot_file_changed();
        if invalid {
            // What is no application is no boot project either.
            self.system.boot_project = BootProjectStatus::None;
        }
        let outcome = decide(&facts);
        self.log_entry(now, LogEntry::Boot { row: outcome.row }, fx);
        if previous == State::Running && !facts.script {
            self.system.stop_cause = StopCause::PowerFail;
        }
        if matches!(outcome.state, State::Empty | State::InvalidOs) {
            // controller:FRC-07
            self.clear_forcing();
            self.enter(outcome.state, now, fx);
            return;
        }
        // What the boot itself stops for goes before what stopped the controller before it (plcsystem:PLCR-10).
        match check {
            Check::Variables => self.system.stop_cause = StopCause::RetainMismatch,
            Check::Application => self.system.stop_cause = StopCause::BootApplicationMismatch,
            Check::Valid if !facts.same && previous != State::Empty => {
                self.system.stop_cause = StopCause::BootApplicationMismatch;
            }
            Check::Valid => {}
        }
        if check != Check::Valid {
            self.log_entry(now, LogEntry::ContextInvalid, fx);
            self.save_if_dirty(now);
        }
        self.initial_outputs(ApplicationStart::Boot, outcome.state, now, fx);
        match outcome.state {
            State::Running => self.enter_running(now, fx),
            _ => self.rest(State::Stopped, now, fx),
        }
    }

    /// Takes an application into memory with the saved context.
    fn load(
        &mut self,
        mut application: Box<dyn Application>,
        bundle: &[u8],
        now: Time,
        fx: &mut Effects,
    ) -> Check {
        self.log_warnings(&*application, now, fx);
        application.reset(VariableReset::ALL);
        self.memory.clear();
        let saved = self.remanent.newest(self.files.store());
        let map = self.files.store().read(RETAIN_MAP).unwrap_or_default();
        let check = match &saved {
            None => Check::Variables,
            Some(saved) => self.restore(saved, &mut *application, &map),
        };
        application.initialize(&mut self.memory);
        self.remanent.prepare(&*application, true, self.files.store_mut());
        self.remanent.dirty = check != Check::Valid;
        self.install(application, bundle);
        check
    }

    /// What of a saved context an application takes.
    fn restore(&mut self, saved: &Saved, application: &mut dyn Application, map: &[u8]) -> Check {
        if saved.signature == application.signature() {
            if !application.restore_retained(&saved.variables) {
                application.reset(VariableReset::ALL);
                return Check::Variables;
            }
            self.restore_words(saved, application);
            if saved.declarations != application.declarations() {
                // controller:REM-02 note 1: the online change that made it modified more than code.
                application.reset(VariableReset::COLD);
            }
            return Check::Valid;
        }
        let online_change = saved.parent == application.signature();
        let same = application.adopt_retained(map, &saved.variables);
        if online_change {
            // controller:RB-04: as by reset cold.
            self.restore_words(saved, application);
        } else if self.config.profile == Profile::M241_2014 {
            // controller:REM-02 note 2 stands in the later documents alone.
            application.reset(VariableReset::ALL);
        }
        if same { Check::Application } else { Check::Variables }
    }

    /// %MW0...%MW999, but for the words that are variables' (controller:REM-03).
    fn restore_words(&mut self, saved: &Saved, application: &dyn Application) {
        let words = self.memory.remanent_mut();
        for (word, bytes) in saved.words.chunks_exact(2).enumerate() {
            if !application.associates(word as u32) {
                words[word * 2..word * 2 + 2].copy_from_slice(bytes);
            }
        }
    }
}
