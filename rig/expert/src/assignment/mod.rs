//! Which functions a controller can have, and on which inputs and outputs: the rules of io: section 6.2 and
//! io:STD-ASG-01.

mod error;

pub use error::{ExpertError, ExpertFault, ExpertWarning};

use crate::{AxisRole, CounterKind, CounterRole, ExpertConfig, FunctionKind, InputConditions, WaveRole};
use profile::{ChannelSet, ExpertLimits, FAST_INPUTS, IoChannel, Profile, Reference};
use std::fmt;

/// What an input or output is to a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ChannelRole {
    /// To a counter or meter.
    Counter(CounterRole),
    /// To an axis.
    Axis(AxisRole),
    /// To a pulse width modulation or frequency generator.
    Wave(WaveRole),
}

/// What else the controller uses of its inputs and outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReservedChannels {
    /// The inputs with Latch or Event.
    pub advanced: ChannelSet,
    /// The Run/Stop input: n for In.
    pub run_stop: Option<usize>,
    /// The alarm output: n for Qn.
    pub alarm: Option<usize>,
}

impl fmt::Display for ChannelRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ChannelRole::Counter(role) => write!(f, "{role}"),
            ChannelRole::Axis(role) => write!(f, "{role}"),
            ChannelRole::Wave(role) => write!(f, "{role}"),
        }
    }
}

impl FunctionKind {
    /// The inputs and outputs that the function takes, and what for.
    pub fn channels(&self) -> Vec<(ChannelRole, IoChannel)> {
        match self {
            FunctionKind::Counter(it) => both(it.inputs(), it.outputs(), ChannelRole::Counter),
            FunctionKind::Axis(it) => both(it.inputs(), it.outputs(), ChannelRole::Axis),
            FunctionKind::Pwm(it) | FunctionKind::Generator(it) => {
                both(it.inputs(), it.outputs(), ChannelRole::Wave)
            }
        }
    }

    /// The inputs that the function looks at.
    pub fn inputs(&self) -> ChannelSet {
        let inputs = self.channels().into_iter().filter_map(|(_, channel)| match channel {
            IoChannel::Input(n) => Some(n),
            IoChannel::Output(_) => None,
        });
        inputs.collect()
    }

    /// The outputs that the function may drive.
    pub fn outputs(&self) -> ChannelSet {
        let outputs = self.channels().into_iter().filter_map(|(_, channel)| match channel {
            IoChannel::Input(_) => None,
            IoChannel::Output(n) => Some(n),
        });
        outputs.collect()
    }

    /// Whether it is of the class of which there are few: whatever is no HSC Simple (io:EXP-08).
    fn is_shared(&self) -> bool {
        !matches!(self, FunctionKind::Counter(it) if it.kind == CounterKind::Simple)
    }
}

fn both<R>(
    inputs: impl Iterator<Item = (R, u8)>,
    outputs: impl Iterator<Item = (R, u8)>,
    role: fn(R) -> ChannelRole,
) -> Vec<(ChannelRole, IoChannel)> {
    let inputs = inputs.map(|(it, n)| (role(it), IoChannel::Input(n.into())));
    inputs.chain(outputs.map(|(it, n)| (role(it), IoChannel::Output(n.into())))).collect()
}

impl ExpertConfig {
    /// The inputs that functions look at.
    pub fn inputs(&self) -> ChannelSet {
        self.functions.iter().flat_map(|function| function.kind.inputs()).collect()
    }

    /// The outputs that functions may drive.
    pub fn outputs(&self) -> ChannelSet {
        self.functions.iter().flat_map(|function| function.kind.outputs()).collect()
    }

    /// Everything for which no controller of the profile accepts these functions, in the order of the functions.
    pub fn check(
        &self,
        profile: Profile,
        reference: &Reference,
        taken: &ReservedChannels,
    ) -> Vec<ExpertError> {
        Check { config: self, limits: profile.expert_limits(reference), reference, taken, errors: Vec::new() }
            .run()
    }

    /// Counters whose inputs let fewer pulses pass than they are meant to count (io:STD-IN-05). `inputs` are the
    /// conditions of each input from I0 on.
    pub fn warnings(&self, inputs: &[InputConditions]) -> Vec<ExpertWarning> {
        let mut warnings = Vec::new();
        for (function, it) in self.functions.iter().enumerate() {
            let FunctionKind::Counter(counter) = &it.kind else { continue };
            let Some(expected) = counter.expected else { continue };
            let phases = [CounterRole::A, CounterRole::B];
            for (role, input) in counter.inputs().filter(|(role, _)| phases.contains(role)) {
                let bounce = inputs.get(usize::from(input)).map(|it| it.bounce).unwrap_or_default();
                let fast = usize::from(input) < FAST_INPUTS;
                let passes = 1_000_000_000_i64.checked_div(2 * bounce.as_nanos()).unwrap_or(i64::MAX);
                let most = u32::try_from(passes).unwrap_or(u32::MAX).min(counter.highest(fast));
                if expected > most {
                    let role = ChannelRole::Counter(role);
                    warnings.push(ExpertWarning { function, role, bounce, expected, most });
                }
            }
        }
        warnings
    }
}

/// A check under way.
struct Check<'a> {
    config: &'a ExpertConfig,
    limits: ExpertLimits,
    reference: &'a Reference,
    taken: &'a ReservedChannels,
    errors: Vec<ExpertError>,
}

impl Check<'_> {
    fn run(mut self) -> Vec<ExpertError> {
        let (mut shared, mut axes) = (0, 0);
        for (function, it) in self.config.functions.iter().enumerate() {
            self.name(function, &it.name);
            if self.reference.input_count() == 0 {
                self.error(function, None, ExpertFault::NoEmbedded);
                continue;
            }
            shared += usize::from(it.kind.is_shared());
            axes += usize::from(matches!(it.kind, FunctionKind::Axis(_)));
            // What is one too many is reported of the first that is, and of every one after it.
            if it.kind.is_shared() && shared > self.limits.shared {
                self.error(function, None, ExpertFault::Shared { most: self.limits.shared });
            } else if matches!(it.kind, FunctionKind::Axis(_)) && axes > self.limits.axes {
                self.error(function, None, ExpertFault::Axes { most: self.limits.axes });
            }
            self.parameters(function, &it.kind);
            for (role, channel) in it.kind.channels() {
                self.channel(function, role, channel);
            }
        }
        self.errors
    }

    fn error(&mut self, function: usize, role: Option<ChannelRole>, fault: ExpertFault) {
        self.errors.push(ExpertError { function, role, fault });
    }

    fn name(&mut self, function: usize, name: &str) {
        let letters = name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        let begins = name.bytes().next().is_some_and(|byte| !byte.is_ascii_digit());
        let underscores = name.contains("__") || name.ends_with('_');
        if !letters || !begins || underscores || name.eq_ignore_ascii_case("None") {
            self.error(function, None, ExpertFault::Name);
        }
        let before = &self.config.functions[..function];
        if let Some(other) = before.iter().position(|other| other.name.eq_ignore_ascii_case(name)) {
            self.error(function, None, ExpertFault::SameName(other));
        }
    }

    fn parameters(&mut self, function: usize, kind: &FunctionKind) {
        match kind {
            FunctionKind::Counter(counter) => {
                for fault in counter.faults() {
                    self.error(function, None, ExpertFault::Counter(fault));
                }
                let found = counter.inputs().count();
                if found > self.limits.main_inputs {
                    self.error(function, None, ExpertFault::Inputs { found, most: self.limits.main_inputs });
                }
            }
            FunctionKind::Axis(axis) => {
                for fault in axis.check() {
                    self.error(function, None, ExpertFault::Axis(fault));
                }
            }
            FunctionKind::Pwm(_) | FunctionKind::Generator(_) => {}
        }
    }

    fn channel(&mut self, function: usize, role: ChannelRole, channel: IoChannel) {
        let fault = self.own_fault(role, channel).or_else(|| self.assigned(function, role, channel));
        if let Some(fault) = fault {
            self.error(function, Some(role), fault);
        }
    }

    /// What is wrong with an input or output whatever else functions take.
    fn own_fault(&self, role: ChannelRole, channel: IoChannel) -> Option<ExpertFault> {
        let (there, usable) = match channel {
            IoChannel::Input(_) => (self.reference.input_count(), self.limits.inputs),
            IoChannel::Output(_) => (self.reference.output_count(), self.limits.reflexes),
        };
        let (IoChannel::Input(n) | IoChannel::Output(n)) = channel;
        let is = |place: Option<usize>| place == Some(n);
        if n >= there {
            return Some(ExpertFault::Missing(channel));
        }
        if !usable.contains(n) {
            return Some(ExpertFault::Unusable(channel));
        }
        if matches!(role, ChannelRole::Counter(CounterRole::Capture(capture)) if capture >= self.limits.captures)
        {
            return Some(ExpertFault::Capture);
        }
        match channel {
            IoChannel::Input(_) if is(self.taken.run_stop) => Some(ExpertFault::RunStop(channel)),
            IoChannel::Input(_) if self.taken.advanced.contains(n) => Some(ExpertFault::Advanced(channel)),
            IoChannel::Output(_) if is(self.taken.alarm) => Some(ExpertFault::Alarm(channel)),
            IoChannel::Output(_)
                if !matches!(role, ChannelRole::Counter(_)) && !self.limits.pulses.contains(n) =>
            {
                Some(ExpertFault::Pulses(channel))
            }
            _ => None,
        }
    }

    /// Whether a role before this one has the channel.
    fn assigned(&self, function: usize, role: ChannelRole, channel: IoChannel) -> Option<ExpertFault> {
        let before = self.config.functions[..=function].iter().enumerate();
        let mut roles = before.flat_map(|(place, it)| {
            it.kind.channels().into_iter().map(move |(role, channel)| (place, role, channel))
        });
        let (other, its, _) = roles.find(|(_, _, its)| *its == channel)?;
        ((other, its) != (function, role)).then_some(ExpertFault::Assigned {
            channel,
            function: other,
            role: its,
        })
    }
}
