//! Which functions a controller can have, and on which inputs and outputs: the rules of io: section 6.2 and
//! io:STD-ASG-01.

mod error;

pub use error::{ExpertError, ExpertFault, ExpertWarning};

use crate::{AxisRole, CounterKind, CounterRole, ExpertConfig, FunctionKind, InputConditions, WaveRole};
use profile::{ChannelSet, ExpertLimits, FAST_INPUTS, Profile, Reference};
use std::fmt;

/// An input or output of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Terminal {
    /// n for In.
    Input(u8),
    /// n for Qn.
    Output(u8),
}

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

impl fmt::Display for Terminal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Terminal::Input(n) => write!(f, "I{n}"),
            Terminal::Output(n) => write!(f, "Q{n}"),
        }
    }
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
    pub fn terminals(&self) -> Vec<(ChannelRole, Terminal)> {
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
        let inputs = self.terminals().into_iter().filter_map(|(_, terminal)| match terminal {
            Terminal::Input(n) => Some(usize::from(n)),
            Terminal::Output(_) => None,
        });
        inputs.collect()
    }

    /// The outputs that the function may drive.
    pub fn outputs(&self) -> ChannelSet {
        let outputs = self.terminals().into_iter().filter_map(|(_, terminal)| match terminal {
            Terminal::Input(_) => None,
            Terminal::Output(n) => Some(usize::from(n)),
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
) -> Vec<(ChannelRole, Terminal)> {
    let inputs = inputs.map(|(it, n)| (role(it), Terminal::Input(n)));
    inputs.chain(outputs.map(|(it, n)| (role(it), Terminal::Output(n)))).collect()
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
            // What is one too many is reported of the first that is, and of every one behind it.
            if it.kind.is_shared() && shared > self.limits.shared {
                self.error(function, None, ExpertFault::Shared { most: self.limits.shared });
            } else if matches!(it.kind, FunctionKind::Axis(_)) && axes > self.limits.axes {
                self.error(function, None, ExpertFault::Axes { most: self.limits.axes });
            }
            self.parameters(function, &it.kind);
            for (role, terminal) in it.kind.terminals() {
                self.terminal(function, role, terminal);
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

    fn terminal(&mut self, function: usize, role: ChannelRole, terminal: Terminal) {
        let fault = self.own_fault(role, terminal).or_else(|| self.assigned(function, role, terminal));
        if let Some(fault) = fault {
            self.error(function, Some(role), fault);
        }
    }

    /// What is wrong with an input or output whatever else functions take.
    fn own_fault(&self, role: ChannelRole, terminal: Terminal) -> Option<ExpertFault> {
        let (there, usable) = match terminal {
            Terminal::Input(_) => (self.reference.input_count(), self.limits.inputs),
            Terminal::Output(_) => (self.reference.output_count(), self.limits.reflexes),
        };
        let (Terminal::Input(n) | Terminal::Output(n)) = terminal;
        let is = |place: Option<usize>| place == Some(usize::from(n));
        if usize::from(n) >= there {
            return Some(ExpertFault::Missing(terminal));
        }
        if !usable.contains(n.into()) {
            return Some(ExpertFault::Unusable(terminal));
        }
        if matches!(role, ChannelRole::Counter(CounterRole::Capture(capture)) if capture >= self.limits.captures)
        {
            return Some(ExpertFault::Capture);
        }
        match terminal {
            Terminal::Input(_) if is(self.taken.run_stop) => Some(ExpertFault::RunStop(terminal)),
            Terminal::Input(_) if self.taken.advanced.contains(n.into()) => {
                Some(ExpertFault::Advanced(terminal))
            }
            Terminal::Output(_) if is(self.taken.alarm) => Some(ExpertFault::Alarm(terminal)),
            Terminal::Output(_)
                if !matches!(role, ChannelRole::Counter(_)) && !self.limits.pulses.contains(n.into()) =>
            {
                Some(ExpertFault::Pulses(terminal))
            }
            _ => None,
        }
    }

    /// Whether a role before this one has the terminal.
    fn assigned(&self, function: usize, role: ChannelRole, terminal: Terminal) -> Option<ExpertFault> {
        let before = self.config.functions[..=function].iter().enumerate();
        let mut roles = before.flat_map(|(place, it)| {
            it.kind.terminals().into_iter().map(move |(role, terminal)| (place, role, terminal))
        });
        let (other, its, _) = roles.find(|(_, _, its)| *its == terminal)?;
        ((other, its) != (function, role)).then_some(ExpertFault::Assigned {
            terminal,
            function: other,
            role: its,
        })
    }
}
