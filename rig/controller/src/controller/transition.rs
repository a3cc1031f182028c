//! States and the ways between them: power, boot, stop, errors.

use super::Controller;
use crate::last_state::{Dates, LastState};
use crate::modules::DefaultedOutputs;
use crate::probes::class;
use crate::{Application, Effect, Effects, HaltOutputs, LogEntry, OutputsInStop, State, TaskConfig};
use profile::{
    ApplicationError, BOOT_STAGES, BootProjectStatus, ChannelSet, OUTPUT_INITIALIZATION, Profile, StopCause,
};
use signal::{Cause, Span, Time};

/// What the outputs of an application begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ApplicationStart {
    /// A boot: hardware initialization values have been there up to now.
    Boot,
    /// A download.
    Download,
    /// A reset of the application that is there already.
    Reset,
}

impl Controller {
    /// The supply comes on: BOOTING (controller:TR-01), or nothing where it was gone for less than the hold-up time.
    pub fn power_on(&mut self, now: Time, fx: &mut Effects) {
        self.scheduler.idle_until(now);
        if self.power.hold_up.take().is_some() {
            self.log_entry(now, LogEntry::SupplyBack, fx);
            self.observe(class::STATE, now, Cause::Controller, fx);
        } else if self.state == State::Off {
            self.power_modules(now);
            self.leds.power_on(now);
            self.system.rtc.power_on(now);
            self.system.battery_led_inhibited = false;
            self.power.script = false;
            self.clear_errors(None);
            self.system.stop_cause = LastState::load(self.files.store()).stop_cause;
            self.boot(now, fx);
            let longest = self.config.profile.longest_without_power_cycle();
            self.power.cycle_due = longest.map(|longest| now.saturating_add(longest));
        }
    }

    /// The supply goes: the controller lives on for its hold-up time (controller:HW-08, controller:HW-09).
    pub fn power_off(&mut self, now: Time, fx: &mut Effects) {
        self.scheduler.idle_until(now);
        if self.state != State::Off && self.power.hold_up.is_none() {
            self.power.hold_up = Some(now.saturating_add(self.config.profile.hold_up()));
            self.log_entry(now, LogEntry::SupplyLost, fx);
            self.observe(class::STATE, now, Cause::Controller, fx);
        }
    }

    /// The end of the hold-up time: whatever is volatile is lost, a save under way is torn (controller:REM-07).
    pub(super) fn go_off(&mut self, now: Time, fx: &mut Effects) {
        self.remanent.tear(now, self.files.store_mut());
        self.unload(now);
        self.system.dates.off = self.system.rtc.date(now);
        self.system.rtc.power_off();
        self.power.hold_up = None;
        self.power.stage = None;
        self.power.cycle_due = None;
        self.cut_modules(now);
        self.enter(State::Off, now, fx);
    }

    /// Begins BOOTING. Forcing waits for the boot application; after a power cycle there is none.
    pub(super) fn boot(&mut self, now: Time, fx: &mut Effects) {
        let (forced, of_modules) = (self.io.forced(), self.modules.bus.forced());
        self.unload(now);
        self.io.restore_forced(forced);
        self.modules.bus.restore_forced(of_modules);
        self.system.dates = Dates::load(self.files.store());
        self.system.boot_project = BootProjectStatus::None;
        self.system.events = 0;
        self.power.stage = Some((0, now.saturating_add(BOOT_STAGES[0])));
        self.power.needs_power_cycle = false;
        self.enter(State::Booting, now, fx);
    }

    /// The application and everything volatile is gone; outputs in hardware initialization values, forcing deleted.
    pub(super) fn unload(&mut self, now: Time) {
        self.abort_cycles();
        self.application = None;
        self.relocate();
        self.bundle.clear();
        self.power.creating = None;
        self.remanent.abandon();
        self.memory.clear();
        self.clear_forcing();
        self.io.unload_functions(now);
        self.leds.identify(false);
        self.power.refresh = None;
        self.io.abandon_initialization();
        self.modules.forget_fallback();
        self.modules.unload();
        self.initialize_outputs(now);
    }

    /// Execution ends where it is.
    fn abort_cycles(&mut self) {
        self.pending = None;
        self.scheduler.abort_cycles();
    }

    /// A step of BOOTING is over.
    pub(super) fn next_stage(&mut self, stage: usize, now: Time, fx: &mut Effects) {
        let next = stage + 1;
        self.power.stage = BOOT_STAGES.get(next).map(|length| (next, now.saturating_add(*length)));
        match self.power.stage {
            Some(_) => self.observe(class::STATE, now, Cause::Controller, fx),
            None => self.end_boot(now, fx),
        }
    }

    /// An application that came in this bundle is the one in memory.
    pub(super) fn install(&mut self, application: Box<dyn Application>, bundle: &[u8]) {
        self.application = Some(application);
        self.bundle = bundle.to_vec();
        self.clear_commands();
        self.scheduler.begin_application();
        self.attach();
    }

    /// Learns of the application what is asked of it by paths and tasks.
    pub(super) fn attach(&mut self) {
        self.relocate();
        self.watch_again();
        self.link_system();
        self.scheduler.find_triggers(self.application.as_deref());
        self.share_channels();
    }

    /// Outputs after a boot, a download or a reset (controller:OUT-05, controller:OUT-06): software initialization
    /// values where a variable defines one, else default values; in 2014 the default values wherever it stays STOPPED.
    /// Before them a download shows hardware initialization values for a while, and the controller of 2014 shows the
    /// initial values of the image. Outputs of expert functions are as others then, but for a download, which shows their
    /// defaults at once (controller:RW-01, io:OUT-28, io:OUT-25).
    pub(super) fn initial_outputs(
        &mut self,
        beginning: ApplicationStart,
        state: State,
        now: Time,
        fx: &mut Effects,
    ) {
        self.ports.note_restart(now);
        self.modules.start(now);
        if state == State::Stopped {
            // In RUNNING forcing waits for the outputs' tasks (controller:FRC-05).
            self.io.act_forcing(None);
        }
        let all = self.io.all_outputs();
        let old = self.config.profile == Profile::M241_2014;
        let defaults = match (old, state) {
            (true, State::Stopped) => all,
            (true, _) => ChannelSet::EMPTY,
            (false, _) => all - self.memory.written_outputs(),
        };
        self.modules.begin_initialization(match (old, state) {
            (true, State::Stopped) => DefaultedOutputs::All,
            (true, _) => DefaultedOutputs::None,
            (false, _) => DefaultedOutputs::Unwritten,
        });
        let first = if old { state == State::Stopped } else { beginning == ApplicationStart::Download };
        self.io.begin_initialization(now.saturating_add(OUTPUT_INITIALIZATION), defaults);
        match (first, old) {
            (false, _) => return self.end_initialization(now, fx),
            (true, true) => self.exchange_outputs(None, now, fx),
            (true, false) => self.initialize_outputs(now),
        }
        match beginning {
            ApplicationStart::Download => self.io.rest_at_defaults(now),
            ApplicationStart::Boot | ApplicationStart::Reset => self.io.rest_at_initial_values(now),
        }
    }

    /// Initialization values are over: outputs without a value of their own take their defaults.
    pub(super) fn end_initialization(&mut self, now: Time, fx: &mut Effects) {
        let ended = self.io.end_initialization(self.config.outputs_in_stop, &mut self.memory);
        let Some(changed) = ended else { return };
        let changed = self.modules.end_initialization(&mut self.memory) || changed;
        if changed {
            self.observe(class::MEMORY, now, Cause::Controller, fx);
        }
        if self.state == State::Stopped {
            self.io.act_forcing(None);
        }
        self.exchange_outputs(None, now, fx);
        self.io.rest_at_defaults(now);
    }

    /// Enters RUNNING: the tasks start again (controller:TR-06, controller:TR-08).
    pub(super) fn enter_running(&mut self, now: Time, fx: &mut Effects) {
        self.abort_cycles();
        self.end_initialization(now, fx);
        self.power.refresh = None;
        self.system.first_cycle.enter_running();
        self.begin_tasks(now);
        self.enter(State::Running, now, fx);
    }

    /// RUNNING -> STOPPED (controller:TR-09).
    pub(super) fn enter_stopped(&mut self, now: Time, cause: StopCause, fx: &mut Effects) {
        self.system.stop_cause = cause;
        self.log_entry(now, LogEntry::Stopped(cause), fx);
        self.fall_back(self.config.outputs_in_stop, now, fx);
        self.rest(State::Stopped, now, fx);
    }

    /// RUNNING -> HALT (controller:TR-10): the fallback is applied at once.
    pub(super) fn enter_halt(&mut self, now: Time, error: ApplicationError, fx: &mut Effects) {
        self.halt(now, StopCause::Exception, error, fx);
    }

    /// RUNNING -> HALT for this cause.
    pub(super) fn halt(&mut self, now: Time, cause: StopCause, error: ApplicationError, fx: &mut Effects) {
        self.system.stop_cause = cause;
        self.system.error = error;
        self.log_entry(now, LogEntry::Stopped(cause), fx);
        let outputs = match self.config.halt_outputs {
            HaltOutputs::Configured => self.config.outputs_in_stop,
            HaltOutputs::Default => OutputsInStop::Default,
        };
        self.fall_back(outputs, now, fx);
        self.rest(State::Halt, now, fx);
    }

    /// A system error: reboot into EMPTY (controller:TR-12, controller:WD-15).
    pub(super) fn system_error(
        &mut self,
        now: Time,
        cause: StopCause,
        error: ApplicationError,
        fx: &mut Effects,
    ) {
        self.system.stop_cause = cause;
        self.system.error = error;
        (self.power.system_error, self.power.script) = (true, false);
        self.record_crash();
        self.log_entry(now, LogEntry::Stopped(cause), fx);
        self.save_last_state(State::Empty);
        self.boot(now, fx);
    }

    /// Outputs when RUNNING is left (controller:STOP-03): the configured state or the forced value.
    fn fall_back(&mut self, outputs: OutputsInStop, now: Time, fx: &mut Effects) {
        self.io.fall_back(outputs);
        self.modules.fall_back(outputs);
        self.write_stop_image(now, fx);
    }

    fn write_stop_image(&mut self, now: Time, fx: &mut Effects) {
        let embedded = self.io.set_stop_image(&mut self.memory);
        if self.modules.set_stop_image(&mut self.memory) || embedded {
            self.observe(class::MEMORY, now, Cause::Controller, fx);
        }
        self.io.act_forcing(None);
        self.exchange_outputs(None, now, fx);
    }

    /// Enters STOPPED or HALT; inputs and outputs go on being updated in the bus cycle where configured.
    pub(super) fn rest(&mut self, state: State, now: Time, fx: &mut Effects) {
        self.abort_cycles();
        self.power.refresh = self.config.update_io_in_stop.then(|| now.saturating_add(self.bus_cycle()));
        self.enter(state, now, fx);
    }

    /// Interval of the bus cycle task (controller:DEV-10), and where it has none the interval of MAST where that is
    /// not said.
    fn bus_cycle(&self) -> Span {
        let task = self.config.bus_cycle().and_then(|place| self.config.tasks.get(place));
        task.and_then(TaskConfig::interval).unwrap_or(Span::from_millis(20))
    }

    /// Update of inputs and outputs in STOPPED and HALT (controller:STOP-04, controller:FRC-04).
    pub(super) fn refresh(&mut self, now: Time, fx: &mut Effects) {
        self.power.refresh = Some(now.saturating_add(self.bus_cycle()));
        self.exchange_inputs(None, now, fx);
        if !self.io.is_initializing() {
            self.write_stop_image(now, fx);
        }
        if self.state == State::Stopped {
            self.save_if_dirty(now);
        }
    }

    pub(super) fn enter(&mut self, state: State, now: Time, fx: &mut Effects) {
        let from = std::mem::replace(&mut self.state, state);
        self.leave(from, now);
        self.io.enter(now, state);
        self.scheduler.restart_at(now);
        self.operate_functions(now, fx);
        self.io.drive_alarm(now, &self.memory);
        if matches!(state, State::Empty | State::Stopped | State::Running | State::Halt) {
            self.save_last_state(state);
        }
        self.ports.note_state(now, state);
        fx.push(Effect::State { at: now, state });
        self.log_entry(now, LogEntry::State { from, to: state }, fx);
        self.observe(class::ALL, now, Cause::Controller, fx);
    }

    /// Keeps the state for the next boot. The cause of a system error is forgotten with the error (controller:WD-15).
    pub(super) fn save_last_state(&mut self, state: State) {
        let signature = self.application.as_ref().map_or(0, |application| application.signature());
        let stop_cause = if self.power.system_error { StopCause::Unknown } else { self.system.stop_cause };
        LastState { state, signature, stop_cause }.save(self.files.store_mut());
    }

    /// The indications of errors are cleared; `stopped` is why RUNNING is left with that. Else the cause of the last stop
    /// stays (plcsystem:PLCR-02), but for that of a system error (controller:WD-15).
    pub(super) fn clear_errors(&mut self, stopped: Option<StopCause>) {
        if self.power.system_error || stopped.is_some() {
            self.system.stop_cause = stopped.unwrap_or(StopCause::Unknown);
        }
        self.power.system_error = false;
        self.system.error = ApplicationError::None;
    }

    /// This cause, where RUNNING is about to be left.
    pub(super) fn stopped_by(&self, cause: StopCause) -> Option<StopCause> {
        matches!(self.state, State::Running | State::Breakpoint).then_some(cause)
    }

    /// Whatever a state that is left takes with it: instants of the last stop and of power off.
    fn leave(&mut self, from: State, now: Time) {
        if from == State::Booting && self.state.status().is_some() {
            self.system.clocks.begin(now);
        }
        // A breakpoint is a stop too, and what comes after it is none again (controller:SYS-02).
        if from == State::Running || self.state == State::Off {
            if from == State::Running {
                self.system.dates.stop = self.system.rtc.date(now);
            }
            self.system.dates.save(self.files.store_mut());
        }
    }

    /// Puts what is accepted with a warning into the log, as the application comes into memory.
    pub(super) fn log_warnings(&mut self, application: &dyn Application, now: Time, fx: &mut Effects) {
        let of_application = self.warning_of(application);
        for warning in of_application.into_iter().chain(self.config.warnings()) {
            self.log_entry(now, LogEntry::Warning(warning), fx);
        }
    }

    /// Puts an entry into the log.
    pub(super) fn log_entry(&mut self, at: Time, entry: LogEntry, fx: &mut Effects) {
        fx.push(Effect::Log { at, entry });
    }
}
