//! Fast counters and meters (io: sections 17.2 and 17.3).
//!
//! Levels of one instant act together, in this order: enable, pulses, captures, preset.

mod compare;
mod config;
mod count;
mod decode;
mod meter;
mod param;
mod rate_limit;
mod steps;

pub use config::{
    CaptureInput, CounterConfig, CounterFault, CounterKind, CounterMode, CounterRole, LimitsMode,
    PeriodMeasurement, PhaseMode, Reflex, SyncInput, Threshold, ThresholdEvent,
};
pub(crate) use param::{CounterParam, ParamFault};

use crate::{ExpertEffect, ExpertEffects, ExpertOperation, FunctionProbe};
use compare::Comparator;
use decode::{DecodeTable, MissedEdgeError};
use meter::Meter;
use param::CounterParams;
use profile::ChannelSet;
use rate_limit::PulseRateLimit;
use signal::{Time, Value};

/// Tasks whose samples of the value are kept; no profile has more.
const TASKS: usize = 32;

/// Levels that a counter looks at.
mod role {
    pub const A: u8 = 1;
    pub const B: u8 = 2;
    pub const ENABLE: u8 = 4;
    pub const SYNC: u8 = 8;
    pub const CAPTURE: [u8; 2] = [16, 32];
}

/// What a program commands a counter, in bits (io:STD-HSC-03).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Controls(pub u16);

impl Controls {
    /// F_Enable: enables by itself.
    pub const ENABLE: Controls = Controls(1);
    /// EN_Enable: input EN enables.
    pub const BY_EN: Controls = Controls(1 << 1);
    /// EN_Preset: input SYNC presets.
    pub const BY_SYNC: Controls = Controls(1 << 2);
    /// EN_Cap: inputs CAP store the value.
    pub const BY_CAP: Controls = Controls(1 << 3);
    /// EN_Compare: the value is compared with thresholds.
    pub const COMPARE: Controls = Controls(1 << 4);
    /// SuspendCompare: comparison and outputs stay as they are.
    pub const SUSPEND: Controls = Controls(1 << 5);
    /// EN_Out0 and EN_Out1: reflexes drive their outputs.
    pub const OUT: [Controls; 2] = [Controls(1 << 6), Controls(1 << 7)];
    /// F_Out0 and F_Out1: the outputs are on.
    pub const FORCE_OUT: [Controls; 2] = [Controls(1 << 8), Controls(1 << 9)];

    const fn has(self, other: Controls) -> bool {
        self.0 & other.0 != 0
    }
}

/// Flags that stay until they are acknowledged (io:STD-HSC-06).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flag {
    Modulo,
    Preset,
    /// Of every capture.
    Capture,
}

/// What was wrong with the pulses, as bits of [`FunctionProbe::Error`] and of EXPERTGetDiag.
pub(crate) mod diag {
    /// Both phases changed at once.
    pub const PHASES: u8 = 1;
    /// The value would have gone beyond its upper limit, and is held there.
    pub const OVERFLOW: u8 = 2;
    /// The value would have gone beyond its lower limit, and is held there.
    pub const UNDERFLOW: u8 = 4;
    /// Edges are known to be missing: the rig's finding, not the controller's.
    pub const LOST: u8 = 8;
}

/// A counter or meter.
#[derive(Clone, Debug)]
pub(crate) struct Counter {
    place: u8,
    number: u8,
    simple: bool,
    /// When [`Counter::fire`] has something to do.
    next: Time,
    /// Roles of the inputs, by number.
    roles: [u8; 32],
    levels: u8,
    /// Roles whose levels changed at `next`.
    changed: u8,
    table: DecodeTable,
    weight: u64,
    lost: MissedEdgeError,
    /// Pulses of A since the last edge of B.
    since_b: u64,
    sync: Option<SyncInput>,
    captures: [Option<CaptureInput>; 2],
    outputs: [Option<u8>; 2],
    params: CounterParams,
    controls: Controls,
    operating: bool,
    /// The enable condition, while the controller runs.
    enabled: bool,
    /// It counts once it is enabled: from the first preset on, where a mode needs one, and until it ends.
    active: bool,
    valid: bool,
    value: i64,
    modulo_flag: bool,
    preset_flag: bool,
    /// What was stored, and whether nobody has acknowledged it yet.
    captured: [(i64, bool); 2],
    diag: u8,
    excess: u64,
    overdriven: bool,
    paces: [PulseRateLimit; 2],
    compare: Comparator,
    meter: Meter,
    /// The input at which hardware counts its pulses.
    fed: Option<u8>,
    /// Levels of the reflex outputs.
    out: [bool; 2],
    /// The value at the start of each task's cycle (io:STD-HSC-07).
    samples: [i64; TASKS],
    initial: DownloadedParams,
}

/// What starts again with a download.
#[derive(Clone, Debug)]
struct DownloadedParams {
    params: CounterParams,
    compare: Comparator,
}

impl Counter {
    /// A counter of a configuration without faults; `number` is its place among the counters.
    pub fn new(config: &CounterConfig, place: u8, number: u8) -> Counter {
        let mut roles = [0; 32];
        for (role, input) in config.inputs() {
            let bit = match role {
                CounterRole::A => role::A,
                CounterRole::B => role::B,
                CounterRole::Enable => role::ENABLE,
                CounterRole::Sync => role::SYNC,
                CounterRole::Capture(n) => role::CAPTURE[usize::from(n)],
                CounterRole::Reflex(_) => 0,
            };
            if let Some(place) = roles.get_mut(usize::from(input)) {
                *place |= bit;
            }
        }
        let (b, phases) = match config.kind {
            CounterKind::Dual { b, phases } => (b, Some(phases)),
            CounterKind::Simple | CounterKind::Single => (config.a, None),
        };
        let pace = |input: u8| PulseRateLimit::new(config.highest(usize::from(input) < profile::FAST_INPUTS));
        let params = CounterParams::new(config);
        let compare = Comparator::new(config);
        let mut counter = Counter {
            place,
            number,
            simple: config.kind == CounterKind::Simple,
            next: Time::MAX,
            roles,
            levels: 0,
            changed: 0,
            table: phases.map_or_else(decode::of_one, decode::of_phases),
            weight: phases.map_or(1, decode::weight),
            lost: MissedEdgeError::of(phases),
            since_b: 0,
            sync: config.sync,
            captures: config.captures,
            outputs: [config.reflex[0].output, config.reflex[1].output],
            params: params.clone(),
            controls: Controls::default(),
            operating: false,
            enabled: false,
            active: false,
            valid: false,
            value: 0,
            modulo_flag: false,
            preset_flag: false,
            captured: [(0, false); 2],
            diag: 0,
            excess: 0,
            overdriven: false,
            paces: [pace(config.a), pace(b)],
            compare: compare.clone(),
            meter: Meter::new(config.mode),
            fed: None,
            out: [false; 2],
            samples: [0; TASKS],
            initial: DownloadedParams { params, compare },
        };
        counter.clear();
        counter
    }

    /// All that it counted and was set is forgotten.
    fn clear(&mut self) {
        self.params = self.initial.params.clone();
        self.compare = self.initial.compare.clone();
        self.controls = Controls::default();
        self.meter.stop();
        self.enabled = false;
        let mode = self.params.mode();
        self.active = !matches!(mode, CounterMode::OneShot { .. } | CounterMode::FreeLarge { .. });
        self.valid = self.active && !matches!(mode, CounterMode::EventCounting { .. });
        self.value = 0;
        (self.modulo_flag, self.preset_flag) = (false, false);
        self.captured = [(0, false); 2];
        (self.diag, self.excess, self.overdriven) = (0, 0, false);
        self.samples = [0; TASKS];
    }

    /// The accepted level of input `input` from `at` on. It acts with the [`Counter::fire`] of this instant.
    #[inline]
    pub fn edge(&mut self, at: Time, input: u8, high: bool, _fx: &mut ExpertEffects) {
        let bit = self.roles[usize::from(input & 31)];
        self.changed |= bit;
        self.levels = if high { self.levels | bit } else { self.levels & !bit };
        self.next = at;
    }

    /// When something happens without an edge; [`Time::MAX`] for never.
    #[inline]
    pub const fn next(&self) -> Time {
        self.next
    }

    #[inline]
    pub fn fire(&mut self, now: Time, fx: &mut ExpertEffects) {
        while self.meter.next() <= now {
            let at = self.meter.next();
            let measurement = self.meter.elapse();
            self.measured(at, measurement, fx);
        }
        if self.changed != 0 {
            let changed = std::mem::take(&mut self.changed);
            self.take_levels(now, changed, fx);
        }
        self.next = self.meter.next();
    }

    /// What the controller lets it do (io:HSC-06, io:STD-HSC-15).
    pub fn operate(&mut self, now: Time, operation: ExpertOperation, fx: &mut ExpertEffects) {
        self.operating = operation == ExpertOperation::Running;
        match operation {
            ExpertOperation::Running => {}
            ExpertOperation::Stopped => {
                self.active &= !matches!(self.params.mode(), CounterMode::OneShot { .. })
            }
            ExpertOperation::Off => self.clear(),
        }
        self.refresh_enable(now);
        self.refresh_outputs(now, fx);
        self.next = self.meter.next();
    }

    /// After a cold reset or a download (io:STD-HSC-15).
    pub fn reset(&mut self, now: Time, fx: &mut ExpertEffects) {
        self.clear();
        self.refresh_outputs(now, fx);
        self.next = self.meter.next();
    }

    /// What the program commands it from `now` on.
    pub fn control(&mut self, now: Time, controls: Controls, fx: &mut ExpertEffects) {
        if controls != self.controls {
            self.controls = controls;
            self.refresh_enable(now);
            let (on, suspended) = (controls.has(Controls::COMPARE), controls.has(Controls::SUSPEND));
            let raised = self.compare.switch(on, suspended, self.value);
            self.raise(now, raised, fx);
            self.refresh_outputs(now, fx);
            self.next = self.meter.next();
        }
    }

    /// A flag is acknowledged.
    pub fn acknowledge(&mut self, flag: Flag) {
        match flag {
            Flag::Modulo => self.modulo_flag = false,
            Flag::Preset => self.preset_flag = false,
            Flag::Capture => self.captured.iter_mut().for_each(|(_, flag)| *flag = false),
        }
    }

    /// A task's cycle begins.
    pub fn sample(&mut self, task: usize) {
        if let Some(place) = self.samples.get_mut(task) {
            *place = self.value;
        }
    }

    /// The value at the start of a task's cycle; without a task, that of now.
    pub fn sampled(&self, task: Option<usize>) -> i64 {
        task.and_then(|task| self.samples.get(task)).copied().unwrap_or(self.value)
    }

    /// What register of a capture holds; None where there is no such capture.
    pub fn captured(&self, n: usize) -> Option<i64> {
        self.captures.get(n).copied().flatten().map(|_| self.captured[n].0)
    }

    /// Whether it is of type Simple.
    pub const fn is_simple(&self) -> bool {
        self.simple
    }

    /// What the controller finds wrong with its pulses.
    pub const fn diag(&self) -> u8 {
        self.diag & !diag::LOST
    }

    /// Whether output `n` of the block, 0 or 1, is on.
    pub const fn out(&self, n: usize) -> bool {
        self.out[n]
    }

    /// A pulse at the terminal of an input was too short for its filters. That is what filters are for, but at a rate
    /// beyond the limit nobody knows whether a real counter would miss it, too.
    pub fn report_suppressed_pulse(&mut self, at: Time, input: u8, fx: &mut ExpertEffects) {
        let role = self.roles[usize::from(input & 31)];
        if role & (role::A | role::B) != 0 && self.enabled && self.active {
            let pulses = self.paces[usize::from(role == role::B)].report_suppressed_pulse(at);
            if pulses > 0 {
                self.add_uncertainty(at, pulses.saturating_mul(self.weight), fx);
            }
        }
    }

    /// So many edges of an input are known to be missing (io: section 18): the value may be off.
    pub fn report_missed_edges(&mut self, at: Time, input: u8, edges: u32, fx: &mut ExpertEffects) {
        let role = self.roles[usize::from(input & 31)];
        self.diag |= diag::LOST;
        let counts = match role {
            _ if self.fed == Some(input) => u64::from(edges),
            role::A => self.lost.of_a(edges),
            role::B => self.lost.of_b(edges, self.since_b),
            role::ENABLE if !self.controls.has(Controls::BY_EN) => 0,
            role::SYNC if !self.controls.has(Controls::BY_SYNC) => 0,
            // What was counted in between, or would have been, is not known.
            role::ENABLE | role::SYNC => u64::MAX,
            _ => 0,
        };
        self.add_uncertainty(at, counts, fx);
    }

    pub fn read(&self, fact: FunctionProbe) -> Option<Value> {
        let flag = |on: bool| Some(Value::Bool(on));
        match fact {
            FunctionProbe::Value => Some(Value::Int(self.value)),
            FunctionProbe::Captured => Some(Value::Int(self.captured[0].0)),
            FunctionProbe::Valid => flag(self.valid),
            FunctionProbe::Run => flag(self.operating && self.active),
            FunctionProbe::Error => Some(Value::Int(i64::from(self.diag))),
            FunctionProbe::Threshold(n) => flag(n < 4 && self.compare.reached() >> n & 1 == 1),
            FunctionProbe::Reflex(n) => flag(n < 2 && self.compare.reflex(usize::from(n))),
            FunctionProbe::ModuloFlag => flag(self.modulo_flag),
            FunctionProbe::PresetFlag => flag(self.preset_flag),
            FunctionProbe::CaptureFlag => flag(self.captured.iter().any(|(_, flag)| *flag)),
            FunctionProbe::Excess => Some(Value::Int(i64::try_from(self.excess).unwrap_or(i64::MAX))),
            _ => None,
        }
    }

    /// The outputs that it may drive.
    pub fn outputs(&self) -> ChannelSet {
        self.outputs.iter().flatten().map(|output| usize::from(*output)).collect()
    }

    /// The inputs that it looks at.
    pub fn inputs(&self) -> ChannelSet {
        (0..self.roles.len()).filter(|input| self.roles[*input] != 0).collect()
    }

    /// Thresholds raise their events.
    #[inline]
    fn raise(&self, at: Time, thresholds: u8, fx: &mut ExpertEffects) {
        for threshold in (0..4).filter(|n| thresholds >> n & 1 == 1) {
            fx.push(at, ExpertEffect::Threshold { counter: self.number, threshold });
        }
    }

    /// The outputs follow what they depend on (io:STD-HSC-12); suspended, they stay.
    fn refresh_outputs(&mut self, at: Time, fx: &mut ExpertEffects) {
        if self.operating && self.compare.is_suspended() {
            return;
        }
        for n in 0..2 {
            let forced = self.controls.has(Controls::FORCE_OUT[n]);
            let reflex = self.controls.has(Controls::OUT[n]) && self.compare.reflex(n);
            let on = self.operating && (forced || reflex);
            if on != self.out[n] {
                self.out[n] = on;
                if let Some(output) = self.outputs[n] {
                    fx.push(at, ExpertEffect::Output { output, on });
                }
            }
        }
    }
}
