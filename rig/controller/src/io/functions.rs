//! The expert functions beside the embedded inputs and outputs (io: sections 6 and 7).
//!
//! Images, forcing and defaults have no say in the outputs of expert functions (io:OUT-21, io:HSC-05): those follow the
//! functions in RUNNING, rest at 0 or at their defaults in STOPPED and HALT (io:OUT-19), and are as all others
//! without an application.

use crate::config::{Config, OutputsInStop};
use crate::state::State;
use expert::{ExpertEffect, ExpertFunctions, ExpertOperation, FunctionKind, FunctionProbe};
use profile::ChannelSet;
use signal::{Time, Value};

/// The functions, and what the controller lets them do.
#[derive(Clone, Debug)]
pub(super) struct Functions {
    expert: ExpertFunctions,
    /// The functions as they are when the electronics come up.
    initial: ExpertFunctions,
    pub(super) operation: ExpertOperation,
    /// Outputs of pulse trains, which have no defaults (io:PLS-04).
    pulses: ChannelSet,
    /// What the outputs show while the functions rest: the outputs that are at 1.
    pub(super) rest: ChannelSet,
    /// Something happened with an edge and nobody looked at it yet.
    due: Time,
    /// The place of the next effect.
    place: usize,
    observed: bool,
    /// Outputs whose square waves hardware makes.
    offloaded: ChannelSet,
    /// Outputs that protection has switched off, as the functions know it.
    cut: ChannelSet,
}

impl Functions {
    /// The functions of a configuration that was checked, without power.
    pub(super) fn new(config: &Config) -> Functions {
        let is_axis = |kind: &FunctionKind| matches!(kind, FunctionKind::Axis(_));
        let axes = config.expert.functions.iter().filter(|function| is_axis(&function.kind));
        let expert = ExpertFunctions::new(&config.expert, &config.input_conditions()).counted(config.counted);
        Functions {
            initial: expert.clone(),
            expert,
            operation: ExpertOperation::Off,
            pulses: axes.flat_map(|axis| axis.kind.outputs()).collect(),
            rest: ChannelSet::EMPTY,
            due: Time::MAX,
            place: 0,
            observed: false,
            offloaded: ChannelSet::EMPTY,
            cut: ChannelSet::EMPTY,
        }
    }

    /// Hardware makes the square waves on these outputs.
    pub(super) fn offload_pulses(&mut self, outputs: ChannelSet) {
        self.offloaded = outputs;
        self.expert.offload_pulses(outputs);
    }

    /// The outputs that functions drive.
    #[inline]
    pub(super) const fn outputs(&self) -> ChannelSet {
        self.expert.outputs()
    }

    /// Whether a function drives Q`output`.
    pub(super) fn drives(&self, output: usize) -> bool {
        self.outputs().contains(output)
    }

    /// The functions as blocks reach them.
    #[inline]
    pub(super) fn expert_mut(&mut self) -> &mut ExpertFunctions {
        &mut self.expert
    }

    /// The level at terminal I`input` from `now` on.
    #[inline]
    pub(super) fn edge(&mut self, now: Time, input: usize, high: bool) {
        let before = self.expert.next() <= now;
        self.expert.edge(now, input, high);
        if before || self.expert.next() <= now {
            self.due = now;
        }
    }

    /// So many edges at terminal I`input` are known to be missing before `now`.
    pub(super) fn report_missed_edges(&mut self, now: Time, input: usize, edges: u32) {
        self.expert.report_missed_edges(now, input, edges);
        self.due = now;
    }

    /// Hardware at terminal I`input` counted so many steps more by `now`.
    pub(super) fn count(&mut self, now: Time, input: usize, steps: i64) {
        self.expert.count(now, input, steps);
        self.due = now;
    }

    /// When something here happens by itself; [`Time::MAX`] for never.
    #[inline]
    pub(super) fn next(&self) -> Time {
        self.expert.next().min(self.due)
    }

    /// What a function shows.
    pub(super) fn read(&self, function: usize, fact: FunctionProbe) -> Value {
        self.expert.read(function, fact)
    }

    /// Facts are observed from now on: calls of blocks may change them.
    pub(super) fn observe(&mut self) {
        self.observed = true;
        self.expert.observe();
    }

    /// The next effect that nobody took yet.
    pub(super) fn take(&mut self) -> Option<(Time, ExpertEffect)> {
        let effect = self.expert.take(self.place);
        self.place = if effect.is_some() { self.place + 1 } else { 0 };
        effect
    }

    /// Protection has the stages of these outputs switched off from `now` on (io:STD-PTO-14).
    pub(super) fn protect(&mut self, now: Time, cut: ChannelSet) {
        let cut = cut & self.outputs();
        // That it let go is to be known, too: an axis can be reset then.
        if !(cut | self.cut).is_empty() {
            self.expert.protect(now, cut);
        }
        self.cut = cut;
    }

    /// A cold reset or a download (io:STD-HSC-15).
    pub(super) fn reset(&mut self, now: Time) {
        self.expert.reset(now);
    }
}

impl Functions {
    /// The electronics of the inputs come up: everything after the terminals starts again, with the levels there.
    pub(super) fn power_on(&mut self, now: Time, inputs: usize, high: impl Fn(usize) -> bool) {
        self.expert.clone_from(&self.initial);
        (self.operation, self.due, self.place) = (ExpertOperation::Off, Time::MAX, 0);
        (self.rest, self.cut) = (ChannelSet::EMPTY, ChannelSet::EMPTY);
        self.offload_pulses(self.offloaded);
        if self.observed {
            self.observe();
        }
        for input in (0..inputs).filter(|input| high(*input)) {
            self.edge(now, input, true);
        }
    }

    /// Lets them do what is due at `now`; whether anything was.
    #[inline]
    pub(super) fn fire(&mut self, now: Time) -> bool {
        let due = self.next() <= now;
        if due {
            self.due = Time::MAX;
            self.expert.fire(now);
        }
        due
    }

    /// They do what the controller lets them from `now` on.
    pub(super) fn operate(&mut self, now: Time, operation: ExpertOperation) {
        self.operation = operation;
        self.expert.operate(now, operation);
    }

    /// What their outputs will show while they rest (io:OUT-19).
    pub(super) fn prepare_rest(&mut self, outputs: OutputsInStop, defaults: ChannelSet) {
        self.rest = match outputs {
            OutputsInStop::Keep => ChannelSet::EMPTY,
            OutputsInStop::Default => (defaults & self.outputs()) - self.pulses,
        };
    }

    /// The application is gone, and with it all that the functions know.
    pub(super) fn unload(&mut self, now: Time) {
        self.rest = ChannelSet::EMPTY;
        self.operate(now, ExpertOperation::Off);
        self.expert.reset(now);
        while self.take().is_some() {}
    }
}

/// What a state lets the functions do.
pub(super) const fn operation_in(state: State) -> ExpertOperation {
    match state {
        // At a breakpoint only the tasks stand still (io:STD-PTO-13).
        State::Running | State::Breakpoint => ExpertOperation::Running,
        State::Stopped | State::Halt => ExpertOperation::Stopped,
        State::Off | State::Booting | State::InvalidOs | State::Empty => ExpertOperation::Off,
    }
}
