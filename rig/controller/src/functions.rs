//! The expert functions in the controller: edges of the terminals go to them, what they bring about goes to outputs,
//! tasks and the log (io: sections 6 and 7).
//!
//! Images, forcing and defaults have no say in the outputs of expert functions (io:OUT-21, io:HSC-05): those follow the
//! functions in RUNNING, rest at 0 or at their defaults in STOPPED and HALT (io:OUT-19), and are as all others
//! without an application.

use crate::watch::class;
use crate::{Config, Controller, Effects, EventSource, LogEntry, OutputsInStop, State};
use expert::{Effect, ExpertFunctions, FunctionKind, FunctionProbe, Operation};
use signal::{Cause, Time, Value};

/// The functions, and what the controller lets them do.
#[derive(Clone, Debug)]
pub(crate) struct Functions {
    expert: ExpertFunctions,
    operation: Operation,
    /// Outputs of pulse trains, which have no defaults (io:PLS-04).
    pulses: u32,
    /// What the outputs show while the functions rest, bit n for Qn.
    rest: u32,
    /// Something happened with an edge and nobody looked at it yet.
    due: Time,
    /// The place of the next effect.
    place: usize,
    observed: bool,
    /// Outputs whose square waves hardware makes, bit n for Qn.
    offloaded: u32,
    /// Outputs that protection has switched off, as the functions know it, bit n for Qn.
    cut: u32,
}

impl Functions {
    /// The functions of a configuration that was checked, without power.
    pub(crate) fn new(config: &Config) -> Functions {
        let is_axis = |kind: &FunctionKind| matches!(kind, FunctionKind::Axis(_));
        let axes = config.expert.functions.iter().filter(|function| is_axis(&function.kind));
        Functions {
            expert: ExpertFunctions::new(&config.expert, &config.input_conditions()).counted(config.counted),
            operation: Operation::Off,
            pulses: axes.fold(0, |mask, axis| mask | axis.kind.outputs()),
            rest: 0,
            due: Time::MAX,
            place: 0,
            observed: false,
            offloaded: 0,
            cut: 0,
        }
    }

    /// hardware makes the square waves on these outputs.
    fn offload_pulses(&mut self, outputs: u32) {
        self.offloaded = outputs;
        self.expert.offload_pulses(outputs);
    }

    /// The outputs that functions drive, bit n for Qn.
    #[inline]
    pub(crate) const fn outputs(&self) -> u32 {
        self.expert.outputs()
    }

    /// Whether a function drives Q`output`.
    pub(crate) fn drives(&self, output: usize) -> bool {
        u32::try_from(output)
            .ok()
            .and_then(|n| self.outputs().checked_shr(n))
            .is_some_and(|bits| bits & 1 == 1)
    }

    /// The functions as blocks reach them.
    #[inline]
    pub(crate) fn expert_mut(&mut self) -> &mut ExpertFunctions {
        &mut self.expert
    }

    /// The level at terminal I`input` from `now` on.
    #[inline]
    pub(crate) fn edge(&mut self, now: Time, input: usize, high: bool) {
        let before = self.expert.next() <= now;
        self.expert.edge(now, input, high);
        if before || self.expert.next() <= now {
            self.due = now;
        }
    }

    /// So many edges at terminal I`input` are known to be missing before `now`.
    pub(crate) fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        self.expert.report_missed_edges(now, input, edges);
        self.due = now;
    }

    /// Hardware behind terminal I`input` has counted so far, by `now`.
    pub(crate) fn count(&mut self, now: Time, input: usize, steps: i64) {
        self.expert.count(now, input, steps);
        self.due = now;
    }

    /// When something here happens by itself; [`Time::MAX`] for never.
    #[inline]
    pub(crate) fn next(&self) -> Time {
        self.expert.next().min(self.due)
    }

    /// What a function shows.
    pub(crate) fn read(&self, function: usize, fact: FunctionProbe) -> Value {
        self.expert.read(function, fact)
    }

    /// Facts are observed from now on: calls of blocks may change them.
    pub(crate) fn observe(&mut self) {
        self.observed = true;
        self.expert.observe();
    }

    /// The next effect that nobody took yet.
    fn take(&mut self) -> Option<(Time, Effect)> {
        let effect = self.expert.take(self.place);
        self.place = if effect.is_some() { self.place + 1 } else { 0 };
        effect
    }

    /// Protection has the stages of these outputs switched off from `now` on (io:STD-PTO-14).
    pub(crate) fn protect(&mut self, now: Time, cut: u32) {
        let cut = cut & self.outputs();
        // That it let go is to be known, too: an axis can be reset then.
        if cut | self.cut != 0 {
            self.expert.protect(now, cut);
        }
        self.cut = cut;
    }

    /// A cold reset or a download (io:STD-HSC-15).
    pub(crate) fn reset(&mut self, now: Time) {
        self.expert.reset(now);
    }
}

/// What a state lets the functions do.
const fn operation_in(state: State) -> Operation {
    match state {
        // At a breakpoint only the tasks stand still (io:STD-PTO-13).
        State::Running | State::Breakpoint => Operation::Running,
        State::Stopped | State::Halt => Operation::Stopped,
        State::Off | State::Booting | State::InvalidOs | State::Empty => Operation::Off,
    }
}

impl Controller {
    /// Square waves of expert functions on these outputs, bit n for Qn, are made by hardware: what is reported of them is
    /// [`crate::Effect::Wave`], and no edges. To be called without power; it stays so.
    pub fn offload_pulses(&mut self, outputs: u32) {
        self.functions.offload_pulses(outputs);
    }

    /// The electronics of the inputs come up: everything behind the terminals starts again, with the levels there.
    pub(crate) fn power_functions(&mut self, now: Time) {
        let (observed, offloaded) = (self.functions.observed, self.functions.offloaded);
        self.functions = Functions::new(&self.config);
        self.functions.offload_pulses(offloaded);
        if observed {
            self.functions.observe();
        }
        for input in 0..self.config.reference.input_count() {
            if self.inputs.terminal(input) {
                self.functions.edge(now, input, true);
            }
        }
    }

    /// Lets the functions do what is due at `now`.
    #[inline]
    pub(crate) fn fire_functions(&mut self, now: Time, fx: &mut Effects) {
        if self.functions.next() <= now {
            self.functions.due = Time::MAX;
            self.functions.expert.fire(now);
            self.apply_function_effects(now, fx);
            self.observe(class::EXPERT, now, Cause::Controller, fx);
        }
    }

    /// What the functions brought about takes effect.
    fn apply_function_effects(&mut self, now: Time, fx: &mut Effects) {
        let mut driven = false;
        while let Some((at, effect)) = self.functions.take() {
            match effect {
                Effect::Output { output, on } => {
                    if self.functions.operation == Operation::Running {
                        let bit = 1 << output;
                        self.outputs.command(at, if on { bit } else { 0 }, bit);
                        driven = true;
                    }
                }
                Effect::Wave { output, period, high } => {
                    if self.functions.operation == Operation::Running {
                        self.outputs.pulse(at, output, period, high);
                        driven = true;
                    }
                }
                Effect::PeriodRestarted { output } => {
                    fx.push(crate::Effect::PeriodRestarted { at, output: output.into() })
                }
                Effect::Threshold { counter, threshold } => {
                    self.external_event(EventSource::Threshold { counter, threshold }, at, fx);
                }
                Effect::Stop { counter } => self.external_event(EventSource::CounterStop(counter), at, fx),
                Effect::Overdriven { function } => {
                    self.log_entry(at, LogEntry::FunctionOverdriven { function: function.into() }, fx);
                }
                // A fact of the axis and of its blocks.
                Effect::AxisError { .. } => {}
            }
        }
        if driven && !self.protection.is_quiet() {
            self.protect(now, fx);
        }
    }

    /// The functions do what the state lets them, and the outputs of those that rest go to rest.
    pub(crate) fn operate_functions(&mut self, now: Time, fx: &mut Effects) {
        let operation = operation_in(self.state);
        if self.functions.operation == operation {
            return;
        }
        self.apply_function_effects(now, fx);
        self.functions.operation = operation;
        self.functions.expert.operate(now, operation);
        let which = self.functions.outputs();
        match operation {
            Operation::Running => self.outputs.command(now, 0, which),
            Operation::Stopped => self.outputs.command(now, self.functions.rest, which),
            Operation::Off => {}
        }
        self.apply_function_effects(now, fx);
    }

    /// Outputs of functions rest at their default values from `now` on, but for those of pulse trains (io:OUT-24,
    /// io:OUT-25, io:PLS-04).
    pub(crate) fn rest_at_defaults(&mut self, now: Time) {
        self.prepare_rest(OutputsInStop::Default);
        self.outputs.command(now, self.functions.rest, self.functions.outputs());
    }

    /// What the outputs of functions will show while they rest (io:OUT-19).
    pub(crate) fn prepare_rest(&mut self, outputs: OutputsInStop) {
        let functions = &mut self.functions;
        functions.rest = match outputs {
            OutputsInStop::Keep => 0,
            OutputsInStop::Default => self.config.output_defaults & functions.outputs() & !functions.pulses,
        };
    }

    /// The application is gone, and with it all that the functions know.
    pub(crate) fn unload_functions(&mut self, now: Time) {
        let functions = &mut self.functions;
        functions.operation = Operation::Off;
        functions.rest = 0;
        functions.expert.operate(now, Operation::Off);
        functions.expert.reset(now);
        while functions.take().is_some() {}
    }
}
