//! The expert functions in the controller: what they bring about goes to outputs, tasks and the log (io: sections 6 and 7).

use super::Controller;
use crate::io::FunctionEffect;
use crate::probes::class;
use crate::{Effects, ExternalEventSource, LogEntry, State};
use expert::ExpertEffect;
use profile::IoChannel;
use signal::{Cause, Time};

impl Controller {
    /// Square waves of expert functions on these embedded outputs are made by hardware: what is reported of them is
    /// [`crate::Effect::Wave`], and no edges. To be called without power; it stays so.
    pub fn offload_pulses(&mut self, outputs: &[IoChannel]) {
        let outputs = outputs.iter().filter_map(|channel| match channel {
            IoChannel::Output(output) => Some(*output),
            IoChannel::Input(_) => None,
        });
        self.io.offload_pulses(outputs.collect());
    }

    /// Reports at `now`, the end of what is looked at, the embedded outputs whose edges are still to come and may be there
    /// already: [`crate::Effect::Unsettled`], only with [`crate::Config::worst_case`].
    pub fn report_unsettled(&mut self, now: Time, fx: &mut Effects) {
        self.io.report_unsettled(now, fx);
    }

    /// So many edges at terminal I`input` are known to be missing before `now`: an expert function that counts them is off by
    /// up to so many, and says so (io:STD-HSC-16).
    pub fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        if self.state != State::Off {
            self.io.report_missed_edges(now, input, edges);
        }
    }

    /// Hardware at terminal I`input` counted so many steps more by `now`, below 0 backwards. Only inputs that
    /// [`crate::Config::counted`] names are counted at.
    pub fn count(&mut self, now: Time, input: usize, steps: i64) {
        if self.state != State::Off {
            self.io.count(now, input, steps);
        }
    }

    /// Lets the functions do what is due at `now`.
    #[inline]
    pub(super) fn fire_functions(&mut self, now: Time, fx: &mut Effects) {
        if self.io.fire_functions(now) {
            self.apply_function_effects(now, fx);
            self.observe(class::EXPERT, now, Cause::Controller, fx);
        }
    }

    /// What the functions brought about takes effect.
    fn apply_function_effects(&mut self, now: Time, fx: &mut Effects) {
        let mut driven = false;
        while let Some((at, effect)) = self.io.take_function_effect() {
            match effect {
                FunctionEffect::Driven => driven = true,
                FunctionEffect::Raised(effect) => self.function_event(at, effect, fx),
            }
        }
        if driven && !self.io.is_quiet() {
            self.protect(now, fx);
        }
    }

    fn function_event(&mut self, at: Time, effect: ExpertEffect, fx: &mut Effects) {
        match effect {
            ExpertEffect::PeriodRestarted { output } => {
                fx.push(crate::Effect::PeriodRestarted { at, output: output.into() });
            }
            ExpertEffect::Threshold { counter, threshold } => {
                self.external_event(ExternalEventSource::Threshold { counter, threshold }, at, fx);
            }
            ExpertEffect::Stop { counter } => {
                self.external_event(ExternalEventSource::CounterStop(counter), at, fx)
            }
            ExpertEffect::Overdriven { function } => {
                self.log_entry(at, LogEntry::FunctionOverdriven { function: function.into() }, fx);
            }
            // Commands of outputs that rest; a fact of the axis and of its blocks.
            ExpertEffect::Output { .. } | ExpertEffect::Wave { .. } | ExpertEffect::AxisError { .. } => {}
        }
    }

    /// The functions do what the state lets them, and the outputs of those that rest go to rest.
    pub(super) fn operate_functions(&mut self, now: Time, fx: &mut Effects) {
        if !self.io.changes_operation(self.state) {
            return;
        }
        self.apply_function_effects(now, fx);
        self.io.operate_functions(now, self.state);
        self.apply_function_effects(now, fx);
    }
}
