//! States and the ways between them: power, boot, stop, errors.

use crate::boot::{BootFacts, decide};
use crate::controller::Forced;
use crate::watch::class;
use crate::{
    APPLICATION_FILE, Application, Controller, Effect, Effects, Entry, HaltOutputs, NonVolatile,
    OutputsInStop, STATE_FILE, State, VariableReset,
};
use profile::{ApplicationError, BOOT_STAGES, BootProjectStatus, Profile, StopCause};
use signal::{Cause, Span, Time};

const MAGIC: &[u8; 4] = b"SRST";

/// Keeps the state for the boot decision.
pub(crate) fn record(store: &mut dyn NonVolatile, state: State, signature: u64) {
    let mut bytes = [0; 17];
    bytes[..4].copy_from_slice(MAGIC);
    bytes[4] = state.number() as u8;
    bytes[5..13].copy_from_slice(&signature.to_le_bytes());
    let sum = crc32fast::hash(&bytes[..13]);
    bytes[13..].copy_from_slice(&sum.to_le_bytes());
    store.write(STATE_FILE, &bytes);
}

/// The state before, and the signature of the application that was in memory.
fn recorded(store: &dyn NonVolatile) -> Option<(State, u64)> {
    let bytes: [u8; 17] = store.read(STATE_FILE)?.try_into().ok()?;
    let (body, sum) = bytes.split_last_chunk::<4>()?;
    if !body.starts_with(MAGIC) || crc32fast::hash(body) != u32::from_le_bytes(*sum) {
        return None;
    }
    let signature = u64::from_le_bytes(body[5..13].try_into().ok()?);
    Some((State::from_number(i64::from(body[4]))?, signature))
}

impl Controller {
    /// The supply comes on: BOOTING (controller:TR-01), or nothing where it was gone for less than the hold-up time.
    pub fn power_on(&mut self, now: Time, fx: &mut Effects) {
        self.come_to(now);
        if self.power.hold_up.take().is_some() {
            self.note(now, Entry::SupplyBack, fx);
        } else if self.state == State::Off {
            self.inputs.power_on(now);
            self.power.system_error = false;
            // A power cycle clears the diagnostics (controller:WD-15).
            self.system.error = ApplicationError::None;
            self.system.stop_cause = StopCause::Unknown;
            self.boot(now, fx);
        }
    }

    /// The supply goes: the controller lives on for its hold-up time (controller:HW-08, controller:HW-09).
    pub fn power_off(&mut self, now: Time, fx: &mut Effects) {
        self.come_to(now);
        if self.state != State::Off && self.power.hold_up.is_none() {
            self.power.hold_up = Some(now.saturating_add(self.config.profile.hold_up()));
            self.note(now, Entry::SupplyLost, fx);
        }
    }

    /// The end of the hold-up time: whatever is volatile is lost, a save under way is torn (controller:REM-07).
    pub(crate) fn go_off(&mut self, now: Time, fx: &mut Effects) {
        self.context.tear(now, &mut *self.store);
        self.unload(now);
        self.power.hold_up = None;
        self.power.stage = None;
        self.enter(State::Off, now, fx);
    }

    /// Begins BOOTING.
    fn boot(&mut self, now: Time, fx: &mut Effects) {
        self.unload(now);
        self.system.boot_project = BootProjectStatus::None;
        self.power.stage = Some((0, now.saturating_add(BOOT_STAGES[0])));
        self.enter(State::Booting, now, fx);
    }

    /// The application and everything volatile is gone; outputs in hardware initialization values, forcing deleted.
    pub(crate) fn unload(&mut self, now: Time) {
        self.cease();
        self.application = None;
        self.context.abandon();
        self.memory.clear();
        (self.forced_inputs, self.forced_outputs) = (Forced::default(), Forced::default());
        self.power.refresh = None;
        self.outputs.initialize(now);
    }

    /// Execution ends where it is.
    pub(crate) fn cease(&mut self) {
        let cpu = &mut self.cpu;
        (cpu.ready, cpu.active, cpu.in_flight, cpu.stopping) = (0, 0, None, None);
    }

    /// A step of BOOTING is over.
    pub(crate) fn next_stage(&mut self, stage: usize, now: Time, fx: &mut Effects) {
        let next = stage + 1;
        self.power.stage = BOOT_STAGES.get(next).map(|length| (next, now.saturating_add(*length)));
        if self.power.stage.is_none() {
            self.end_boot(now, fx);
        }
    }

    /// Loads the boot application and decides the state (controller:TR-03...07).
    fn end_boot(&mut self, now: Time, fx: &mut Effects) {
        let (previous, before) = recorded(&*self.store).unwrap_or((State::Off, 0));
        let file = self.store.read(APPLICATION_FILE);
        let present = file.is_some();
        let bundle = file.filter(|_| !self.power.system_error);
        let application = bundle.and_then(|bundle| match self.build(&bundle) {
            Ok(application) => Some(application),
            Err(error) => {
                self.note(now, Entry::Load(error), fx);
                None
            }
        });
        let mut facts = BootFacts {
            family: self.config.reference.family,
            system_error: self.power.system_error,
            application: application.is_some(),
            remanents: false,
            same: false,
            previous,
            mode: self.config.starting_mode,
            switch_at_run: self.power.switch_at_run,
        };
        if let Some(application) = application {
            facts.same = application.signature() == before;
            facts.remanents = self.load(application, now, fx);
        }
        let outcome = decide(&facts);
        self.note(now, Entry::Boot { row: outcome.row }, fx);
        if outcome.state == State::Empty {
            if present && facts.system_error {
                self.system.boot_project = BootProjectStatus::Different;
            }
            self.enter(State::Empty, now, fx);
            return;
        }
        self.system.boot_project = BootProjectStatus::Valid;
        self.system.stop_cause = match (facts.remanents, facts.same, previous) {
            (true, _, State::Running) => StopCause::PowerFail,
            (true, ..) => StopCause::Unknown,
            // Files may be placed without a download: then the application differs from the one before.
            (false, false, State::Running | State::Stopped | State::Halt) => {
                StopCause::BootApplicationMismatch
            }
            (false, ..) => StopCause::RetainMismatch,
        };
        if !facts.remanents {
            self.note(now, Entry::ContextInvalid, fx);
            self.save_if_dirty(now);
        }
        self.initial_outputs(outcome.state, now, fx);
        match outcome.state {
            State::Running => self.enter_running(now, fx),
            _ => self.rest(State::Stopped, now, fx),
        }
    }

    /// Takes an application into memory with the saved context; whether that was valid (controller:STATE-10).
    fn load(&mut self, application: Box<dyn Application>, now: Time, fx: &mut Effects) -> bool {
        if let Some((byte, tasks)) = self.shared_output_byte(&*application) {
            self.note(now, Entry::SharedOutputByte { byte, tasks }, fx);
        }
        let mut application = application;
        application.reset(VariableReset::ALL);
        self.memory.clear();
        let saved = self.context.newest(&*self.store);
        self.context.prepare(&*application);
        let valid = saved.is_some_and(|saved| {
            let valid =
                saved.signature == application.signature() && application.restore_retained(&saved.variables);
            if valid {
                let words = self.memory.remanent_mut();
                for (word, bytes) in saved.words.chunks_exact(2).enumerate() {
                    if !application.associates(word as u32) {
                        words[word * 2..word * 2 + 2].copy_from_slice(bytes);
                    }
                }
            }
            valid
        });
        if !valid {
            application.reset(VariableReset::ALL);
        }
        application.initialize(&mut self.memory);
        self.context.dirty = !valid;
        self.install(application);
        valid
    }

    pub(crate) fn install(&mut self, application: Box<dyn Application>) {
        self.application = Some(application);
        self.watch_again();
        for task in &mut self.tasks {
            task.figures = Default::default();
            task.consecutive = 0;
        }
    }

    /// Outputs behind a boot, a download or a reset (controller:OUT-05, controller:OUT-06): software initialization
    /// values where a variable defines one, else default values; in 2014 the default values wherever it stays STOPPED.
    pub(crate) fn initial_outputs(&mut self, state: State, now: Time, fx: &mut Effects) {
        let mask = self.outputs.mask();
        let defined = self.memory.written_outputs() & mask;
        let defaults = match (self.config.profile, state) {
            (Profile::M241_2014, State::Stopped) => mask,
            (Profile::M241_2014, _) => 0,
            _ => mask & !defined,
        };
        self.memory.set_output_bits(self.config.output_defaults, defaults, Cause::Controller);
        self.power.stop_image = match self.config.outputs_in_stop {
            OutputsInStop::Keep => None,
            OutputsInStop::Default => Some(self.memory.output_bits() & mask),
        };
        self.write_outputs(now, fx);
    }

    /// Enters RUNNING: every task is released at once (controller:TR-06, controller:TR-08).
    pub(crate) fn enter_running(&mut self, now: Time, fx: &mut Effects) {
        self.cease();
        self.power.refresh = None;
        for (rank, task) in self.tasks.iter_mut().enumerate() {
            task.next_release = now.saturating_add(task.interval);
            task.consecutive = 0;
            self.cpu.ready |= 1 << rank;
        }
        self.enter(State::Running, now, fx);
    }

    /// RUNNING -> STOPPED (controller:TR-09).
    pub(crate) fn enter_stopped(&mut self, now: Time, cause: StopCause, fx: &mut Effects) {
        self.system.stop_cause = cause;
        self.note(now, Entry::Stopped(cause), fx);
        self.fall_back(self.config.outputs_in_stop, now, fx);
        self.rest(State::Stopped, now, fx);
    }

    /// RUNNING -> HALT (controller:TR-10): the fallback is applied at once.
    pub(crate) fn enter_halt(&mut self, now: Time, error: ApplicationError, fx: &mut Effects) {
        self.system.stop_cause = StopCause::Exception;
        self.system.error = error;
        self.note(now, Entry::Stopped(StopCause::Exception), fx);
        let outputs = match self.config.halt_outputs {
            HaltOutputs::Configured => self.config.outputs_in_stop,
            HaltOutputs::Default => OutputsInStop::Default,
        };
        self.fall_back(outputs, now, fx);
        self.rest(State::Halt, now, fx);
    }

    /// A system error: reboot into EMPTY (controller:TR-12, controller:WD-15).
    pub(crate) fn system_error(
        &mut self,
        now: Time,
        cause: StopCause,
        error: ApplicationError,
        fx: &mut Effects,
    ) {
        self.system.stop_cause = cause;
        self.system.error = error;
        self.power.system_error = true;
        self.note(now, Entry::Stopped(cause), fx);
        record(&mut *self.store, State::Empty, 0);
        self.boot(now, fx);
    }

    /// Outputs when RUNNING is left (controller:STOP-03): the configured state or the forced value.
    fn fall_back(&mut self, outputs: OutputsInStop, now: Time, fx: &mut Effects) {
        self.power.stop_image = match outputs {
            OutputsInStop::Keep => None,
            OutputsInStop::Default => Some(self.config.output_defaults),
        };
        self.write_stop_image(now, fx);
    }

    fn write_stop_image(&mut self, now: Time, fx: &mut Effects) {
        if let Some(bits) = self.power.stop_image
            && self.memory.set_output_bits(bits, self.outputs.mask(), Cause::Controller)
        {
            self.observe(class::MEMORY, now, Cause::Controller, fx);
        }
        self.write_outputs(now, fx);
    }

    /// Enters STOPPED or HALT; inputs and outputs go on being updated in the bus cycle where configured.
    pub(crate) fn rest(&mut self, state: State, now: Time, fx: &mut Effects) {
        self.cease();
        self.power.refresh = self.config.update_io_in_stop.then(|| now.saturating_add(self.bus_cycle()));
        self.enter(state, now, fx);
    }

    /// Interval of the bus cycle task: MAST (controller:DEV-10).
    fn bus_cycle(&self) -> Span {
        let mast = self.config.task("MAST").and_then(|place| self.config.tasks.get(place));
        mast.map_or(Span::from_millis(20), |task| task.interval())
    }

    /// Update of inputs and outputs in STOPPED and HALT (controller:STOP-04, controller:FRC-04).
    pub(crate) fn refresh(&mut self, now: Time, fx: &mut Effects) {
        self.power.refresh = Some(now.saturating_add(self.bus_cycle()));
        self.read_inputs(now, fx);
        self.write_stop_image(now, fx);
        if self.state == State::Stopped {
            self.save_if_dirty(now);
        }
    }

    pub(crate) fn enter(&mut self, state: State, now: Time, fx: &mut Effects) {
        let from = std::mem::replace(&mut self.state, state);
        // The processor starts anew; what was under way at `now` never completes.
        self.cpu.at = now;
        if matches!(state, State::Empty | State::Stopped | State::Running | State::Halt) {
            let signature = self.application.as_ref().map_or(0, |application| application.signature());
            record(&mut *self.store, state, signature);
        }
        fx.push(Effect::State { at: now, state });
        self.note(now, Entry::State { from, to: state }, fx);
        self.observe(class::ALL, now, Cause::Controller, fx);
    }

    /// Puts an entry into the log.
    pub(crate) fn note(&mut self, at: Time, entry: Entry, fx: &mut Effects) {
        fx.push(Effect::Log { at, entry });
    }
}
