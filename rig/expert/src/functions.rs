//! All functions of a controller together.

use crate::axis::Axis;
use crate::counter::Counter;
use crate::filter::Filter;
use crate::wave::SquareWave;
use crate::{ExpertConfig, ExpertEffects, ExpertOperation, FunctionKind, FunctionProbe, InputConditions};
use profile::ChannelSet;
use signal::{Time, Value};

/// An edge at the terminal of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputEdge {
    /// When.
    pub at: Time,
    /// n for In.
    pub input: u8,
    /// The level from then on.
    pub high: bool,
}

/// One function.
#[derive(Clone, Debug)]
pub(crate) enum FunctionUnit {
    Counter(Box<Counter>),
    Axis(Box<Axis>),
    Pwm(SquareWave),
    Generator(SquareWave),
}

/// Calls a method of whatever the unit is.
macro_rules! each {
    ($unit:expr, $it:ident => $call:expr) => {
        match $unit {
            FunctionUnit::Counter($it) => $call,
            FunctionUnit::Axis($it) => $call,
            FunctionUnit::Pwm($it) => $call,
            FunctionUnit::Generator($it) => $call,
        }
    };
}

/// The expert functions of one controller.
#[derive(Clone, Debug)]
pub struct ExpertFunctions {
    units: Vec<FunctionUnit>,
    /// By input number.
    filters: Vec<Filter>,
    /// By input number: the units that look at it, bit n for unit n.
    listeners: Vec<u32>,
    /// Inputs whose filters have something to come.
    pending: ChannelSet,
    /// When the first of them does, and when the first unit does something by itself.
    filter_next: Time,
    unit_next: Time,
    outputs: ChannelSet,
    /// The task whose cycle calls blocks.
    task: Option<usize>,
    fx: ExpertEffects,
    /// Somebody looks at what functions show.
    observed: bool,
}

impl ExpertFunctions {
    /// The functions of a configuration that [`ExpertConfig::check`] accepts, without power. `inputs` are the conditions
    /// of each input from I0 on.
    pub fn new(config: &ExpertConfig, inputs: &[InputConditions]) -> ExpertFunctions {
        let mut counters = 0;
        let units: Vec<FunctionUnit> = (0..)
            .zip(&config.functions)
            .map(|(place, function)| match &function.kind {
                FunctionKind::Counter(it) => {
                    counters += 1;
                    FunctionUnit::Counter(Box::new(Counter::new(it, place, counters - 1)))
                }
                FunctionKind::Axis(it) => FunctionUnit::Axis(Box::new(Axis::new(it, place))),
                FunctionKind::Pwm(it) => FunctionUnit::Pwm(SquareWave::pwm(it)),
                FunctionKind::Generator(it) => FunctionUnit::Generator(SquareWave::generator(it)),
            })
            .collect();
        let used = |unit: &FunctionUnit| each!(unit, it => it.inputs());
        let listeners = (0..inputs.len())
            .map(|input| {
                let looks = |unit| u32::from(used(unit).contains(input));
                (0..).zip(&units).fold(0, |units, (place, unit)| units | looks(unit) << place)
            })
            .collect();
        let outputs = units.iter().flat_map(|unit| each!(unit, it => it.outputs())).collect();
        ExpertFunctions {
            units,
            filters: inputs.iter().map(Filter::new).collect(),
            listeners,
            pending: ChannelSet::EMPTY,
            filter_next: Time::MAX,
            unit_next: Time::MAX,
            outputs,
            task: None,
            fx: ExpertEffects::new(),
            observed: false,
        }
    }

    /// Hardware counts the pulses at these inputs: counters whose pulses they are take what it counted by
    /// [`ExpertFunctions::count`], and no edges of their phases.
    #[must_use]
    pub fn counted(mut self, inputs: ChannelSet) -> ExpertFunctions {
        for unit in &mut self.units {
            if let FunctionUnit::Counter(counter) = unit {
                counter.counted(inputs);
            }
        }
        self
    }

    /// Hardware at terminal I`input` counted so many steps more by `at`, below 0 backwards, in the direction that it found.
    /// Instants never go backwards.
    pub fn count(&mut self, at: Time, input: usize, steps: i64) {
        self.fire(at);
        let listening = self.listeners.get(input).copied().unwrap_or(0);
        for (place, unit) in self.units.iter_mut().enumerate() {
            if let (1, FunctionUnit::Counter(counter)) = (listening >> place & 1, unit) {
                counter.take_steps(at, input as u8, steps, &mut self.fx);
            }
        }
    }

    /// Somebody looks at what functions show, from now on: whoever calls blocks has to say so each time.
    pub fn observe(&mut self) {
        self.observed = true;
    }

    /// Whether somebody looks at what functions show.
    #[inline]
    pub const fn is_observed(&self) -> bool {
        self.observed
    }

    /// The outputs that functions drive: images have no say in them.
    #[inline]
    pub const fn outputs(&self) -> ChannelSet {
        self.outputs
    }

    /// Square waves on these outputs are made by hardware from now on: their functions bring about
    /// [`crate::ExpertEffect::Wave`] in place of edges, and nobody counts their pulses.
    pub fn offload_pulses(&mut self, outputs: ChannelSet) {
        for unit in &mut self.units {
            if let FunctionUnit::Pwm(wave) | FunctionUnit::Generator(wave) = unit
                && wave.outputs().intersects(outputs)
            {
                wave.offload_pulses();
            }
        }
    }

    /// The level at terminal I`input` from `at` on. Instants never go backwards.
    #[inline]
    pub fn edge(&mut self, at: Time, input: usize, high: bool) {
        if self.listeners.get(input).is_none_or(|units| *units == 0) {
            return;
        }
        if self.next() <= at {
            self.fire(at);
        }
        if self.filters[input].set(at, high) {
            self.report_suppressed_pulse(at, input);
        }
        self.pending.insert(input);
        self.filter_next = self.filter_next.min(self.filters[input].next());
        if self.filter_next <= at {
            self.fire(at);
        }
    }

    /// A pulse at the terminal of an input was too short for its filters.
    #[cold]
    fn report_suppressed_pulse(&mut self, at: Time, input: usize) {
        let listening = self.listeners[input];
        for (place, unit) in self.units.iter_mut().enumerate() {
            if let (1, FunctionUnit::Counter(counter)) = (listening >> place & 1, unit) {
                counter.report_suppressed_pulse(at, input as u8, &mut self.fx);
            }
        }
    }

    /// [`ExpertFunctions::edge`] for one after the other, up to the first after which there are effects to take. Returns how many
    /// it took.
    pub fn edges(&mut self, edges: &[InputEdge]) -> usize {
        for (place, edge) in edges.iter().enumerate() {
            self.edge(edge.at, usize::from(edge.input), edge.high);
            if !self.fx.as_slice().is_empty() {
                return place + 1;
            }
        }
        edges.len()
    }

    /// So many edges at the terminal of an input are known to be missing before `at`: counters that look at it report how
    /// far they may be off.
    pub fn report_missed_edges(&mut self, at: Time, input: usize, edges: u32) {
        self.fire(at);
        let listening = self.listeners.get(input).copied().unwrap_or(0);
        for (place, unit) in self.units.iter_mut().enumerate() {
            if let (1, FunctionUnit::Counter(counter)) = (listening >> place & 1, unit) {
                counter.report_missed_edges(at, input as u8, edges, &mut self.fx);
            }
        }
    }

    /// ExpertEffects that nobody took yet.
    pub fn effects(&self) -> &ExpertEffects {
        &self.fx
    }

    /// A cycle of a task begins at `now`: until its next one, blocks that it calls show the values of now
    /// (io:STD-HSC-07).
    pub fn sample(&mut self, now: Time, task: usize) {
        self.fire(now);
        for unit in &mut self.units {
            if let FunctionUnit::Counter(counter) = unit {
                counter.sample(task);
            }
        }
    }

    /// Blocks are called by a cycle of this task from here on.
    #[inline]
    pub fn enter(&mut self, task: usize) {
        self.task = Some(task);
    }

    /// The task whose cycle calls blocks, where somebody said it.
    #[inline]
    pub(crate) const fn task(&self) -> Option<usize> {
        self.task
    }

    /// When something happens by itself; [`Time::MAX`] for never. ExpertEffects that nobody took yet are due at once.
    #[inline]
    pub fn next(&self) -> Time {
        self.filter_next.min(self.unit_next).min(self.fx.first())
    }

    /// Lets everything happen that is due up to `now`, in the order of its instants; at one instant inputs by number,
    /// then functions by place.
    pub fn fire(&mut self, now: Time) {
        loop {
            let at = self.filter_next.min(self.unit_next);
            if at > now || at == Time::MAX {
                return;
            }
            if self.filter_next <= at {
                self.pass_inputs(at);
            }
            for unit in &mut self.units {
                if each!(unit, it => it.next()) <= at {
                    each!(unit, it => it.fire(at, &mut self.fx));
                }
            }
            self.schedule();
        }
    }

    /// Levels that filters accept at `at` go to the functions.
    fn pass_inputs(&mut self, at: Time) {
        for input in std::mem::take(&mut self.pending) {
            let filter = &mut self.filters[input];
            if let Some(high) = filter.accept(at) {
                let mut units = self.listeners[input];
                while units != 0 {
                    let place = units.trailing_zeros() as usize;
                    units &= units - 1;
                    each!(&mut self.units[place], it => it.edge(at, input as u8, high, &mut self.fx));
                }
            }
            self.pending.set(input, self.filters[input].next() != Time::MAX);
        }
    }

    /// Works out when something happens next.
    fn schedule(&mut self) {
        self.filter_next = Time::MAX;
        for input in self.pending {
            self.filter_next = self.filter_next.min(self.filters[input].next());
        }
        self.unit_next =
            self.units.iter().map(|unit| each!(unit, it => it.next())).min().unwrap_or(Time::MAX);
    }

    /// What the controller lets the functions do from `now` on.
    pub fn operate(&mut self, now: Time, operation: ExpertOperation) {
        self.fire(now);
        for unit in &mut self.units {
            each!(unit, it => it.operate(now, operation, &mut self.fx));
        }
        self.schedule();
    }

    /// Outputs whose stages protection switched off from `now` on: axes on them go to ErrorStop
    /// (io:STD-PTO-14).
    pub fn protect(&mut self, now: Time, cut: ChannelSet) {
        self.fire(now);
        for unit in &mut self.units {
            if let FunctionUnit::Axis(axis) = unit {
                axis.protect(now, cut, &mut self.fx);
            }
        }
        self.schedule();
    }

    /// A cold reset or a download at `now`: values and flags start again (io:STD-HSC-15).
    pub fn reset(&mut self, now: Time) {
        self.fire(now);
        for unit in &mut self.units {
            each!(unit, it => it.reset(now, &mut self.fx));
        }
        self.schedule();
    }

    /// What a block does to the function with this number, counted from 1 (io:EXP-16); None where there is none, or none
    /// that `pick` takes.
    pub(crate) fn call<U, R>(
        &mut self,
        now: Time,
        reference: i64,
        pick: fn(&mut FunctionUnit) -> Option<&mut U>,
        body: impl FnOnce(&mut U, &mut ExpertEffects) -> R,
    ) -> Option<R> {
        let place = usize::try_from(reference).ok()?.checked_sub(1)?;
        self.fire(now);
        let result = body(pick(self.units.get_mut(place)?)?, &mut self.fx);
        self.schedule();
        Some(result)
    }

    /// What a function shows; unknown for what it does not have.
    pub fn read(&self, function: usize, fact: FunctionProbe) -> Value {
        let unit = self.units.get(function);
        unit.and_then(|unit| each!(unit, it => it.read(fact))).unwrap_or(Value::Unknown)
    }

    /// The next effect that happened, in their order; `place` counts from 0, and after the last one they are forgotten.
    pub fn take(&mut self, place: usize) -> Option<(Time, crate::ExpertEffect)> {
        self.fx.take(place)
    }
}
