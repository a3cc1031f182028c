//! What a counter or meter is, and what of it cannot be.

use profile::EventEdges;
use signal::Span;
use std::fmt;
use thiserror::Error;

/// The parameters of a counter or meter.
#[derive(Clone, Debug, PartialEq)]
pub struct CounterConfig {
    /// Its type, with the inputs of its pulses.
    pub kind: CounterKind,
    /// The input of the pulses: n for In.
    pub a: u8,
    /// What it does with them.
    pub mode: CounterMode,
    /// Highest frequency of the pulses that is expected, in hertz: what lets fewer pass is warned of (io:STD-IN-05).
    pub expected: Option<u32>,
    /// Input EN, which enables it where the program authorises that (io:STD-HSC-04).
    pub enable: Option<u8>,
    /// Input SYNC, which presets it (io:STD-HSC-05).
    pub sync: Option<SyncInput>,
    /// Inputs CAP0 and CAP1, which store its value (io:STD-HSC-13).
    pub captures: [Option<CaptureInput>; 2],
    /// Up to four thresholds, strictly increasing (io:STD-HSC-11).
    pub thresholds: Vec<Threshold>,
    /// Reflex outputs 0 and 1 (io:STD-HSC-12).
    pub reflex: [Reflex; 2],
}

/// Types of counters (io:EXP-01).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CounterKind {
    /// One input and nothing else.
    Simple,
    /// A Main counter with one phase; meters are of this type, too.
    Single,
    /// A Main counter with two phases.
    Dual {
        /// The second phase: n for In.
        b: u8,
        /// How the phases count.
        phases: PhaseMode,
    },
}

/// The eight input modes of two phases (io:STD-HSC-09, VH-HSC-07).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PhaseMode {
    /// A rising edge of A adds 1, one of B takes 1 away.
    #[default]
    UpDown,
    /// A rising edge of A adds 1 while B is 0, and takes 1 away while B is 1.
    PulseDirection,
    /// The first edge of A in each cycle counts; up where A comes before B.
    X1,
    /// Both edges of A count.
    X2,
    /// Every edge counts.
    X4,
    /// As [`PhaseMode::X1`], with the opposite direction.
    ReverseX1,
    /// As [`PhaseMode::X2`], with the opposite direction.
    ReverseX2,
    /// As [`PhaseMode::X4`], with the opposite direction.
    ReverseX4,
}

/// What a counter does with its pulses (io: section 17.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CounterMode {
    /// Counts down to 0 from the value that a preset loads.
    OneShot {
        /// 1...2 147 483 647.
        preset: i32,
    },
    /// Counts round from 0 to the modulo less 1.
    ModuloLoop {
        /// 2...2 147 483 647.
        modulo: i32,
    },
    /// Counts up and down through all values of a DINT from the value that a preset loads.
    FreeLarge {
        /// Any DINT.
        preset: i32,
        /// What happens at the ends.
        limits: LimitsMode,
    },
    /// The pulses of each of successive windows.
    EventCounting {
        /// 0.1, 1, 10 or 60 s.
        window: Span,
    },
    /// A frequency in hertz.
    Frequency {
        /// Window of a measurement: 10, 100 or 1000 ms.
        window: Span,
    },
    /// A time between edges, in units of the resolution.
    Period {
        /// Between which edges.
        measures: PeriodMeasurement,
        /// 0.1, 1, 100 or 1000 us.
        resolution: Span,
        /// Without an edge for so long the value is 0 and not valid; 0 for never.
        timeout: Span,
    },
}

/// What happens at the ends of the range (VH-HSC-06).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LimitsMode {
    /// The value is held and not valid until the next preset.
    #[default]
    Lock,
    /// Counting goes on at the other end.
    Rollover,
}

/// Which time a period meter measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PeriodMeasurement {
    /// From a rising edge to the next one.
    #[default]
    Period,
    /// From a rising edge to the next falling one.
    PulseWidth,
}

/// The input that presets a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncInput {
    /// n for In.
    pub input: u8,
    /// Edges that preset.
    pub edges: EventEdges,
    /// The level that input EN must have at the edge, where that matters.
    pub while_enable: Option<bool>,
}

/// An input that stores the value of a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CaptureInput {
    /// n for In.
    pub input: u8,
    /// Edges that store.
    pub edges: EventEdges,
}

/// A value that the counter's is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threshold {
    /// The value.
    pub value: i32,
    /// When its event is raised.
    pub event: ThresholdEvent,
}

/// When a threshold raises its event (VH-HSC-24, VH-HSC-25). The value is above a threshold that it has reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThresholdEvent {
    /// Never.
    #[default]
    None,
    /// The value comes to be above it.
    Upwards,
    /// The value comes to be below it.
    Downwards,
    /// Either.
    Both,
    /// The value is below it: raised when that begins.
    Below,
    /// The value is above it: raised when that begins.
    Above,
    /// The value is between it and the next one: raised when that begins.
    Between,
}

/// A reflex output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reflex {
    /// The output: n for Qn. Without one the reflex can only be read.
    pub output: Option<u8>,
    /// The zones in which it is on: bit n while n thresholds are reached.
    pub zones: u8,
}

/// What of a counter's parameters cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum CounterFault {
    /// This type of counter does not have this mode.
    #[error("this type of counter does not have this mode")]
    Mode,
    /// The preset value is not in 1...2 147 483 647.
    #[error("a preset value of {0} is not in 1...2147483647")]
    Preset(i32),
    /// The modulo is not in 2...2 147 483 647.
    #[error("a modulo of {0} is not in 2...2147483647")]
    Modulo(i32),
    /// The window is none of those of the mode.
    #[error("this mode has no window of {0}")]
    Window(Span),
    /// The resolution is none of 0.1, 1, 100 and 1000 us.
    #[error("a resolution of {0} is none of 100 ns, 1 us, 100 us and 1 ms")]
    Resolution(Span),
    /// The timeout is negative.
    #[error("a timeout of {0} is negative")]
    Timeout(Span),
    /// This type or mode has no input for this.
    #[error("this counter has no input {0}")]
    Input(CounterRole),
    /// SYNC asks for a level of EN, and there is no EN.
    #[error("SYNC asks for a level of EN, and there is no EN")]
    SyncWithoutEnable,
    /// This type or mode does not compare.
    #[error("this counter does not compare its value with thresholds")]
    Thresholds,
    /// There are more than four thresholds.
    #[error("{0} thresholds are more than four")]
    TooManyThresholds(usize),
    /// Threshold n is not above the one before it.
    #[error("threshold {0} is not above the one before it")]
    ThresholdOrder(u8),
    /// Threshold n is no value that the counter can have.
    #[error("threshold {0} is outside the values that this counter can have")]
    ThresholdRange(u8),
    /// Threshold n raises its event between it and the next one, which there is not.
    #[error("threshold {0} is the last one: there is none that its event could lie below")]
    NoNextThreshold(u8),
    /// Reflex n has an output or zones, and there is no threshold.
    #[error("reflex {0} needs thresholds, and there is none")]
    ReflexWithoutThreshold(u8),
    /// Reflex n is on in a zone that there is not.
    #[error("reflex {0} is on in a zone that there is not")]
    ReflexZone(u8),
}

/// What an input or output is to a counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CounterRole {
    /// The pulses.
    A,
    /// The second phase.
    B,
    /// Enables.
    Enable,
    /// Presets.
    Sync,
    /// Stores the value, 0 or 1.
    Capture(u8),
    /// Reflex output 0 or 1.
    Reflex(u8),
}

impl CounterConfig {
    /// A counter that counts the pulses of one input and has nothing else.
    pub fn new(kind: CounterKind, a: u8, mode: CounterMode) -> CounterConfig {
        CounterConfig {
            kind,
            a,
            mode,
            expected: None,
            enable: None,
            sync: None,
            captures: [None; 2],
            thresholds: Vec::new(),
            reflex: [Reflex::default(); 2],
        }
    }

    /// The inputs that it takes: n for In.
    pub fn inputs(&self) -> impl Iterator<Item = (CounterRole, u8)> + '_ {
        let b = match self.kind {
            CounterKind::Dual { b, .. } => Some((CounterRole::B, b)),
            _ => None,
        };
        let captures = (0..).zip(&self.captures);
        [(CounterRole::A, self.a)]
            .into_iter()
            .chain(b)
            .chain(self.enable.map(|input| (CounterRole::Enable, input)))
            .chain(self.sync.map(|sync| (CounterRole::Sync, sync.input)))
            .chain(captures.filter_map(|(n, it)| it.map(|it| (CounterRole::Capture(n), it.input))))
    }

    /// The outputs that it takes: n for Qn.
    pub fn outputs(&self) -> impl Iterator<Item = (CounterRole, u8)> + '_ {
        (0..).zip(&self.reflex).filter_map(|(n, it)| it.output.map(|output| (CounterRole::Reflex(n), output)))
    }

    /// The highest frequency of its pulses in hertz: 200 kHz, with two phases 100 kHz, on a regular input 1 kHz
    /// (io:STD-HSC-16).
    pub const fn highest(&self, fast: bool) -> u32 {
        match self.kind {
            _ if !fast => 1_000,
            CounterKind::Dual { .. } => 100_000,
            CounterKind::Simple | CounterKind::Single => 200_000,
        }
    }

    /// Whether it compares its value with thresholds (io:STD-HSC-11, VH-HSC-20, VH-HSC-26).
    const fn compares(&self) -> bool {
        !matches!((self.kind, self.mode), (CounterKind::Simple, _) | (_, CounterMode::EventCounting { .. }))
    }

    /// What of it cannot be, in the order of its fields. Which inputs and outputs there are for it is not looked at.
    pub fn faults(&self) -> Vec<CounterFault> {
        let mut faults = Vec::new();
        let possible = match self.mode {
            CounterMode::OneShot { .. } => !matches!(self.kind, CounterKind::Dual { .. }),
            CounterMode::ModuloLoop { .. } => true,
            CounterMode::FreeLarge { .. } => matches!(self.kind, CounterKind::Dual { .. }),
            CounterMode::EventCounting { .. }
            | CounterMode::Frequency { .. }
            | CounterMode::Period { .. } => self.kind == CounterKind::Single,
        };
        if !possible {
            faults.push(CounterFault::Mode);
        }
        faults.extend(self.mode.faults());
        let simple = self.kind == CounterKind::Simple;
        let meter = matches!(self.mode, CounterMode::Frequency { .. } | CounterMode::Period { .. });
        for (role, _) in self.inputs() {
            let unknown = match role {
                CounterRole::Enable => simple,
                CounterRole::Sync | CounterRole::Capture(_) => simple || meter,
                _ => false,
            };
            if unknown {
                faults.push(CounterFault::Input(role));
            }
        }
        if self.enable.is_none() && self.sync.is_some_and(|sync| sync.while_enable.is_some()) {
            faults.push(CounterFault::SyncWithoutEnable);
        }
        self.comparison_faults(&mut faults);
        faults
    }

    fn comparison_faults(&self, faults: &mut Vec<CounterFault>) {
        let count = self.thresholds.len();
        if count > 0 && !self.compares() {
            faults.push(CounterFault::Thresholds);
        }
        if count > 4 {
            faults.push(CounterFault::TooManyThresholds(count));
        }
        let (lowest, highest) = self.mode.range();
        for (n, threshold) in (0..).zip(&self.thresholds) {
            if n > 0 && threshold.value <= self.thresholds[usize::from(n) - 1].value {
                faults.push(CounterFault::ThresholdOrder(n));
            }
            if !(lowest..=highest).contains(&threshold.value) {
                faults.push(CounterFault::ThresholdRange(n));
            }
            if threshold.event == ThresholdEvent::Between && usize::from(n) + 1 == count {
                faults.push(CounterFault::NoNextThreshold(n));
            }
        }
        for (n, reflex) in (0..).zip(&self.reflex) {
            if count == 0 && (reflex.output.is_some() || reflex.zones != 0) {
                faults.push(CounterFault::ReflexWithoutThreshold(n));
            } else if u32::from(reflex.zones) >> (count + 1).min(31) != 0 {
                faults.push(CounterFault::ReflexZone(n));
            }
        }
    }
}

impl CounterMode {
    /// Windows of event counting.
    pub const EVENT_WINDOWS: [Span; 4] =
        [Span::from_millis(100), Span::from_secs(1), Span::from_secs(10), Span::from_secs(60)];

    /// Windows of a frequency meter.
    pub const FREQUENCY_WINDOWS: [Span; 3] =
        [Span::from_millis(10), Span::from_millis(100), Span::from_millis(1000)];

    /// Resolutions of a period meter.
    pub const RESOLUTIONS: [Span; 4] =
        [Span::from_nanos(100), Span::from_micros(1), Span::from_micros(100), Span::from_micros(1000)];

    /// The values that a counter of this mode can have.
    pub(super) const fn range(&self) -> (i32, i32) {
        match *self {
            CounterMode::OneShot { preset } => (0, preset),
            CounterMode::ModuloLoop { modulo } => (0, modulo.saturating_sub(1)),
            CounterMode::FreeLarge { .. } => (i32::MIN, i32::MAX),
            CounterMode::EventCounting { .. }
            | CounterMode::Frequency { .. }
            | CounterMode::Period { .. } => (0, i32::MAX),
        }
    }

    fn faults(&self) -> impl Iterator<Item = CounterFault> + use<> {
        let unless = |right: bool, fault| (!right).then_some(fault);
        let (first, second) = match *self {
            CounterMode::OneShot { preset } => (unless(preset >= 1, CounterFault::Preset(preset)), None),
            CounterMode::ModuloLoop { modulo } => (unless(modulo >= 2, CounterFault::Modulo(modulo)), None),
            CounterMode::FreeLarge { .. } => (None, None),
            CounterMode::EventCounting { window } => {
                (unless(Self::EVENT_WINDOWS.contains(&window), CounterFault::Window(window)), None)
            }
            CounterMode::Frequency { window } => {
                (unless(Self::FREQUENCY_WINDOWS.contains(&window), CounterFault::Window(window)), None)
            }
            CounterMode::Period { resolution, timeout, .. } => (
                unless(Self::RESOLUTIONS.contains(&resolution), CounterFault::Resolution(resolution)),
                unless(!timeout.is_negative(), CounterFault::Timeout(timeout)),
            ),
        };
        first.into_iter().chain(second)
    }
}

impl fmt::Display for CounterRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CounterRole::A => f.write_str("A"),
            CounterRole::B => f.write_str("B"),
            CounterRole::Enable => f.write_str("EN"),
            CounterRole::Sync => f.write_str("SYNC"),
            CounterRole::Capture(n) => write!(f, "CAP{n}"),
            CounterRole::Reflex(n) => write!(f, "reflex output {n}"),
        }
    }
}
