//! Pulse width modulation and frequency generators: a square wave on one output (io:STD-PWM-01, io:STD-FG-01).

mod period;
#[cfg(test)]
mod tests;

use crate::{ExpertEffect, ExpertEffects, ExpertOperation, FunctionProbe};
use period::Period;
use profile::{ChannelSet, EventEdges, FAST_OUTPUTS, GENERATOR_TENTHS, PWM_TENTHS, REGULAR_OUTPUT_TENTHS};
use signal::{Time, Value};
use std::fmt;

/// The parameters of a pulse width modulation or a frequency generator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaveConfig {
    /// The output of the pulses: n for Qn.
    pub output: u8,
    /// Input EN, which enables it where the program authorises that: n for In.
    pub enable: Option<u8>,
    /// Input SYNC, which restarts the period where the program authorises that: n for In.
    pub sync: Option<u8>,
    /// Which edges of that input do.
    pub sync_edges: EventEdges,
}

/// What an input or output is to a pulse width modulation or frequency generator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum WaveRole {
    /// The pulses.
    A,
    /// Enables.
    Enable,
    /// Restarts the period.
    Sync,
}

impl fmt::Display for WaveRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            WaveRole::A => "A",
            WaveRole::Enable => "EN",
            WaveRole::Sync => "SYNC",
        })
    }
}

impl WaveConfig {
    /// Pulses on output Q`output`, without inputs.
    pub const fn new(output: u8) -> WaveConfig {
        WaveConfig { output, enable: None, sync: None, sync_edges: EventEdges::Rising }
    }

    /// The inputs that it takes: n for In.
    pub fn inputs(&self) -> impl Iterator<Item = (WaveRole, u8)> + use<> {
        let enable = self.enable.map(|input| (WaveRole::Enable, input));
        enable.into_iter().chain(self.sync.map(|input| (WaveRole::Sync, input)))
    }

    /// The outputs that it takes: n for Qn.
    pub fn outputs(&self) -> impl Iterator<Item = (WaveRole, u8)> + use<> {
        [(WaveRole::A, self.output)].into_iter()
    }
}

/// Duty of a frequency generator, in tenths of a percent.
pub(crate) const HALF: u16 = 500;

/// ErrorID: a frequency or duty that the output cannot have (io:STD-PWM-03).
pub(crate) const INVALID_PARAMETER: i64 = 3;

/// What a wave looks like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct WaveShape {
    /// In tenths of a hertz; 0 for an output that stays at 0.
    pub frequency: u32,
    /// In tenths of a percent, 0...1000.
    pub duty: u16,
}

/// What a block asks for by one call.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WaveRequest {
    /// Enabled by the program.
    pub enable: bool,
    /// Enabled by the input while it is 1.
    pub enable_by_input: bool,
    /// The period starts again.
    pub sync: bool,
    /// The input may let the period start again.
    pub sync_by_input: bool,
    /// The shape, where it is one that the function has at all.
    pub shape: Option<WaveShape>,
}

/// What a block shows after its call. At most one of the three is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct WaveStatus {
    /// The output has the shape that was asked for.
    pub in_frequency: bool,
    /// It still has another one: the period is not over.
    pub busy: bool,
    /// The shape is none that the output can have (io:STD-PWM-03).
    pub refused: bool,
}

/// A square wave on one output.
#[derive(Clone, Debug)]
pub(crate) struct SquareWave {
    output: u8,
    enable_input: Option<u8>,
    sync_input: Option<u8>,
    sync_edges: EventEdges,
    /// Highest frequency of the output, in tenths of a hertz.
    most: u32,
    /// The application is RUNNING.
    running: bool,
    /// What the last call let it do.
    enable: bool,
    enable_by_input: bool,
    sync_by_input: bool,
    /// Level of the enable input.
    input: bool,
    /// The last call asked for what cannot be.
    refused: bool,
    /// The shape from the next period on.
    wanted: WaveShape,
    /// The period that runs; none while it is not enabled.
    period: Option<Period>,
    /// What the output is commanded.
    level: bool,
    /// When the output or the shape changes by itself.
    due: Time,
    /// Rising edges since power-on.
    pulses: u64,
    /// Hardware makes the pulses.
    offloaded: bool,
    /// What they make now, if anything.
    reported: Option<WaveShape>,
}

impl SquareWave {
    /// A pulse width modulation.
    pub fn pwm(config: &WaveConfig) -> SquareWave {
        SquareWave::new(config, PWM_TENTHS)
    }

    /// A frequency generator.
    pub fn generator(config: &WaveConfig) -> SquareWave {
        SquareWave::new(config, GENERATOR_TENTHS)
    }

    /// `most` is the highest frequency of a fast output.
    fn new(config: &WaveConfig, most: u32) -> SquareWave {
        let fast = usize::from(config.output) < FAST_OUTPUTS;
        SquareWave {
            output: config.output,
            enable_input: config.enable,
            sync_input: config.sync,
            sync_edges: config.sync_edges,
            most: if fast { most } else { REGULAR_OUTPUT_TENTHS },
            running: false,
            enable: false,
            enable_by_input: false,
            sync_by_input: false,
            input: false,
            refused: false,
            wanted: WaveShape::default(),
            period: None,
            level: false,
            due: Time::MAX,
            pulses: 0,
            offloaded: false,
            reported: None,
        }
    }

    /// hardware makes the pulses from now on.
    pub fn offload_pulses(&mut self) {
        self.offloaded = true;
    }

    /// One call of a block: what is asked for holds from now on, and stays after the call.
    pub fn call(&mut self, now: Time, request: &WaveRequest, fx: &mut ExpertEffects) -> WaveStatus {
        let wanted = request.shape.filter(|shape| shape.frequency <= self.most);
        let asked = request.enable || request.enable_by_input;
        self.refused = asked && wanted.is_none();
        if self.refused {
            // The output stays as it was, but what is no longer allowed ends all the same.
            self.enable &= request.enable;
            self.enable_by_input &= request.enable_by_input;
            self.sync_by_input &= request.sync_by_input;
            self.update_enable(now, fx);
            return WaveStatus { refused: true, ..WaveStatus::default() };
        }
        self.enable = request.enable;
        self.enable_by_input = request.enable_by_input;
        self.sync_by_input = request.sync_by_input;
        if let Some(shape) = wanted
            && asked
        {
            self.request_shape(now, shape, fx);
        }
        self.update_enable(now, fx);
        if request.sync {
            self.restart(now, fx);
        }
        let Some(period) = &self.period else { return WaveStatus::default() };
        let reached = period.shape == self.wanted;
        WaveStatus { in_frequency: reached, busy: !reached, refused: false }
    }

    /// The shape from the next period on. An output that does not pulse has no edge that shows its periods, but
    /// they pass all the same.
    fn request_shape(&mut self, now: Time, shape: WaveShape, fx: &mut ExpertEffects) {
        self.wanted = shape;
        let Some(period) = &mut self.period else { return };
        if period.shape.frequency == 0 {
            // It waits for nothing: another duty is reached at once, too.
            if shape != period.shape {
                self.begin(now, 0, fx);
            }
        } else if period.is_constant() || self.offloaded {
            self.due = if period.shape == shape {
                Time::MAX
            } else {
                period.skip(now);
                period.end().0
            };
            let next = Period { shape, ..*period };
            if self.reported.is_some() && !next.is_constant() {
                // Whoever makes the pulses waits for the end of a period of their own.
                self.report_wave(now, &next, fx);
            }
        }
    }

    /// A period begins; `rest` is what its start lies after `at`, in parts of a nanosecond of which the frequency says
    /// how many there are.
    fn begin(&mut self, at: Time, rest: u32, fx: &mut ExpertEffects) {
        let period = Period { shape: self.wanted, start: at, rest };
        let is_made = self.offloaded && !period.is_constant();
        if is_made {
            self.report_wave(at, &period, fx);
        } else {
            self.drive(at, period.shape.frequency != 0 && period.shape.duty != 0, fx);
        }
        self.due = if is_made || period.is_constant() { Time::MAX } else { period.fall() };
        self.period = Some(period);
    }

    fn drive(&mut self, at: Time, on: bool, fx: &mut ExpertEffects) {
        let pulsed = self.reported.take().is_some();
        if self.level != on || pulsed {
            self.level = on;
            self.pulses += u64::from(on);
            fx.push(at, ExpertEffect::Output { output: self.output, on });
        }
    }

    /// Tells whoever makes the pulses what a period that is not constant looks like, where that is news.
    fn report_wave(&mut self, at: Time, period: &Period, fx: &mut ExpertEffects) {
        if self.reported != Some(period.shape) {
            self.reported = Some(period.shape);
            let (period, high) = period.rounded();
            fx.push(at, ExpertEffect::Wave { output: self.output, period, high });
        }
    }

    /// Starts or ends the wave, as what enables it says.
    fn update_enable(&mut self, now: Time, fx: &mut ExpertEffects) {
        let enabled = self.running && (self.enable || self.enable_by_input && self.input);
        if enabled && self.period.is_none() {
            self.begin(now, 0, fx);
        } else if !enabled && self.period.is_some() {
            self.period = None;
            self.due = Time::MAX;
            self.drive(now, false, fx);
        }
    }

    /// Sync: the period starts again (io:STD-PWM-02).
    fn restart(&mut self, now: Time, fx: &mut ExpertEffects) {
        if self.period.is_some() {
            if self.reported.is_some() {
                fx.push(now, ExpertEffect::PeriodRestarted { output: self.output });
            }
            self.begin(now, 0, fx);
        }
    }

    /// The accepted level of input `input` from `at` on.
    pub fn edge(&mut self, at: Time, input: u8, high: bool, fx: &mut ExpertEffects) {
        if self.enable_input == Some(input) {
            self.input = high;
            self.update_enable(at, fx);
        }
        if self.sync_input == Some(input) && self.sync_by_input && self.sync_edges.includes(high) {
            self.restart(at, fx);
        }
    }

    /// When something happens without an edge; [`Time::MAX`] for never.
    pub fn next(&self) -> Time {
        self.due
    }

    pub fn fire(&mut self, now: Time, fx: &mut ExpertEffects) {
        while self.due <= now {
            let at = self.due;
            // Without a period nothing is due.
            let Some(period) = &self.period else { return };
            if self.level && !period.is_constant() && !self.offloaded {
                self.due = period.end().0;
                self.drive(at, false, fx);
            } else {
                let rest = if period.shape.frequency == self.wanted.frequency { period.end().1 } else { 0 };
                self.begin(at, rest, fx);
            }
        }
    }

    /// Expert functions cease to operate outside RUNNING (io:OUT-20), and begin again by the next call of their block.
    pub fn operate(&mut self, now: Time, operation: ExpertOperation, fx: &mut ExpertEffects) {
        self.running = operation == ExpertOperation::Running;
        if !self.running {
            self.clear(now, fx);
        }
        if operation == ExpertOperation::Off {
            self.pulses = 0;
        }
    }

    /// After a cold reset or a download.
    pub fn reset(&mut self, now: Time, fx: &mut ExpertEffects) {
        self.clear(now, fx);
    }

    fn clear(&mut self, now: Time, fx: &mut ExpertEffects) {
        (self.enable, self.enable_by_input, self.sync_by_input, self.refused) = (false, false, false, false);
        self.update_enable(now, fx);
    }

    pub fn read(&self, fact: FunctionProbe) -> Option<Value> {
        let shape = self.period.as_ref().map(|period| period.shape).unwrap_or_default();
        match fact {
            FunctionProbe::Run => Some(Value::Bool(self.period.is_some())),
            FunctionProbe::Frequency => Some(Value::Int(shape.frequency.into())),
            FunctionProbe::Duty => Some(Value::Int(shape.duty.into())),
            FunctionProbe::Error => Some(Value::Int(if self.refused { INVALID_PARAMETER } else { 0 })),
            // Nobody counts those that hardware makes.
            FunctionProbe::Pulses if self.offloaded => Some(Value::Unknown),
            FunctionProbe::Pulses => Some(Value::Word(self.pulses)),
            _ => None,
        }
    }

    /// The outputs that it may drive.
    pub fn outputs(&self) -> ChannelSet {
        ChannelSet::of(self.output.into())
    }

    /// The inputs that it looks at.
    pub fn inputs(&self) -> ChannelSet {
        [self.enable_input, self.sync_input].into_iter().flatten().map(usize::from).collect()
    }
}
