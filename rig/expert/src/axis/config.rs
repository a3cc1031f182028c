//! The parameters of an axis (io:STD-PTO-02).

use super::ramp::RampRate;
use signal::Span;
use std::fmt;
use thiserror::Error;

/// What the outputs of a pulse train say (io:STD-PTO-01).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PulseOutput {
    /// Pulses on A, the direction on B.
    #[default]
    PulseDirection,
    /// Pulses for larger positions on A, for smaller ones on B.
    ClockwiseCounterclockwise,
    /// Pulses on A alone; the axis has one direction.
    Pulse,
    /// A and B a quarter of a period apart: A goes first for larger positions, B for smaller ones. A pulse is a whole
    /// period.
    Quadrature,
}

/// In what accelerations are given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RampUnit {
    /// Hertz a millisecond.
    #[default]
    HertzPerMs,
    /// Milliseconds from 0 to the maximum velocity.
    Ms,
}

/// What an input or output is to an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum AxisRole {
    /// The output A.
    A,
    /// The output B.
    B,
    /// Enables the drive.
    DriveEnable,
    /// The switch of homing.
    Reference,
    /// The zero mark of homing.
    Index,
    /// Captures positions, starts moves.
    Probe,
    /// The limit switch for larger positions.
    LimitPositive,
    /// The limit switch for smaller positions.
    LimitNegative,
    /// The drive is ready.
    DriveReady,
}

impl fmt::Display for AxisRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            AxisRole::A => "A",
            AxisRole::B => "B",
            AxisRole::DriveEnable => "driveEnable",
            AxisRole::Reference => "REF",
            AxisRole::Index => "INDEX",
            AxisRole::Probe => "PROBE",
            AxisRole::LimitPositive => "limP",
            AxisRole::LimitNegative => "limN",
            AxisRole::DriveReady => "driveReady",
        })
    }
}

/// An input of the drive or of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriveInput {
    /// n for In.
    pub input: u8,
    /// Whether it acts with its 0, as a contact that opens does.
    pub inverted: bool,
}

/// The parameters of a pulse train output and its axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisConfig {
    /// What the outputs say.
    pub output: PulseOutput,
    /// The output A: n for Qn.
    pub a: u8,
    /// The output B; none with [`PulseOutput::Pulse`].
    pub b: Option<u8>,
    /// The output that enables the drive.
    pub drive_enable: Option<u8>,
    /// REF: the switch of homing.
    pub reference: Option<DriveInput>,
    /// INDEX: the zero mark of homing.
    pub index: Option<DriveInput>,
    /// PROBE: captures positions, starts moves.
    pub probe: Option<DriveInput>,
    /// The limit switch for larger positions.
    pub limit_positive: Option<DriveInput>,
    /// The limit switch for smaller positions.
    pub limit_negative: Option<DriveInput>,
    /// The drive is ready.
    pub drive_ready: Option<DriveInput>,
    /// Velocity at which motions begin, in hertz; 0 for what the acceleration gives within 1 ms.
    pub start_velocity: u32,
    /// Velocity at which motions end, in hertz; 0 for what the deceleration gives within 1 ms.
    pub stop_velocity: u32,
    /// Highest velocity, in hertz.
    pub max_velocity: u32,
    /// Unit of all accelerations, of blocks too.
    pub ramp_unit: RampUnit,
    /// Highest acceleration.
    pub max_acceleration: u32,
    /// Highest deceleration.
    pub max_deceleration: u32,
    /// Deceleration after errors of the axis.
    pub fast_stop: u32,
    /// Part of a ramp that is curved, in percent, where a block gives none.
    pub jerk_ratio: u8,
    /// The smallest and the largest position.
    pub software_limits: Option<(i32, i32)>,
    /// Pulses that a change of direction needs before the mechanics follow; only with [`PulseOutput::Quadrature`].
    pub backlash: u32,
    /// Time from a change of direction to the next pulse; none for one period of the first velocity.
    pub direction_delay: Option<Span>,
    /// Whether B is 0 for larger positions.
    pub direction_inverted: bool,
}

/// Highest velocity of an axis on fast outputs, in hertz (io:STD-PTO-02).
const FAST: u32 = 100_000;
/// Highest velocity on a regular output, in hertz (io:EXP-03).
const REGULAR: u32 = 1_000;
/// The outputs from this one on are regular.
const FIRST_REGULAR: u8 = profile::FAST_OUTPUTS as u8;
/// The longest ramp up to the highest velocity, in milliseconds (io:STD-PTO-06).
pub const LONGEST_RAMP_MS: u32 = 80_000;
/// The steepest ramp, in hertz a millisecond.
pub const STEEPEST: u32 = 100_000;

/// A parameter of an axis that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum AxisParameterError {
    /// A number out of its range.
    #[error("{} is {given}, and has to be {}...{}", parameter.replace('_', " "), range.0, range.1)]
    OutOfRange {
        /// The parameter: the name of its field.
        parameter: &'static str,
        /// What was given.
        given: i64,
        /// The smallest and the largest number that it may be.
        range: (i64, i64),
    },
    /// The output mode needs an output B.
    #[error("this output mode needs an output B")]
    NoB,
    /// The output mode has no output B.
    #[error("the output mode pulse has no output B")]
    NeedlessB,
    /// A parameter that only the output mode quadrature has.
    #[error("backlash is compensated only in the output mode quadrature")]
    OnlyQuadrature,
    /// A parameter that only the output mode pulse and direction has: the name of its field.
    #[error("{} belongs to the output mode pulse and direction alone", .0.replace('_', " "))]
    OnlyDirection(&'static str),
    /// The lower software limit is not below the upper one.
    #[error("the lower software limit has to be below the upper one")]
    Limits,
}

impl AxisConfig {
    /// An axis with pulses and direction on two outputs, and otherwise the default of each parameter.
    pub fn new(a: u8, b: u8) -> AxisConfig {
        AxisConfig {
            output: PulseOutput::PulseDirection,
            a,
            b: Some(b),
            drive_enable: None,
            reference: None,
            index: None,
            probe: None,
            limit_positive: None,
            limit_negative: None,
            drive_ready: None,
            start_velocity: 0,
            stop_velocity: 0,
            max_velocity: if a.max(b) < FIRST_REGULAR { FAST } else { REGULAR },
            ramp_unit: RampUnit::HertzPerMs,
            max_acceleration: STEEPEST,
            max_deceleration: STEEPEST,
            fast_stop: 5_000,
            jerk_ratio: 0,
            software_limits: None,
            backlash: 0,
            direction_delay: None,
            direction_inverted: false,
        }
    }

    /// The highest velocity that its outputs can make, in hertz.
    pub fn fastest(&self) -> u32 {
        if self.a.max(self.b.unwrap_or(self.a)) < FIRST_REGULAR { FAST } else { REGULAR }
    }

    /// The outputs that it takes: n for Qn.
    pub fn outputs(&self) -> impl Iterator<Item = (AxisRole, u8)> + use<> {
        [(AxisRole::A, Some(self.a)), (AxisRole::B, self.b), (AxisRole::DriveEnable, self.drive_enable)]
            .into_iter()
            .filter_map(|(role, output)| output.map(|output| (role, output)))
    }

    /// The inputs that it takes: n for In.
    pub fn inputs(&self) -> impl Iterator<Item = (AxisRole, u8)> + use<> {
        [
            (AxisRole::Reference, self.reference),
            (AxisRole::Index, self.index),
            (AxisRole::Probe, self.probe),
            (AxisRole::LimitPositive, self.limit_positive),
            (AxisRole::LimitNegative, self.limit_negative),
            (AxisRole::DriveReady, self.drive_ready),
        ]
        .into_iter()
        .filter_map(|(role, input)| input.map(|input| (role, input.input)))
    }

    /// What its parameters have wrong, whatever other functions there are.
    pub fn check(&self) -> Vec<AxisParameterError> {
        let mut errors = Vec::new();
        let mut range = |parameter, given: i64, least: i64, most: i64| {
            if !(least..=most).contains(&given) {
                errors.push(AxisParameterError::OutOfRange { parameter, given, range: (least, most) });
            }
        };
        let fastest = i64::from(self.fastest());
        let most = i64::from(self.max_velocity).min(fastest);
        range("max_velocity", self.max_velocity.into(), 1, fastest);
        range("start_velocity", self.start_velocity.into(), 0, most);
        range("stop_velocity", self.stop_velocity.into(), 0, most);
        let (least, most) = (1, i64::from(self.steepest()));
        range("max_acceleration", self.max_acceleration.into(), least, most);
        range("max_deceleration", self.max_deceleration.into(), least, most);
        range("fast_stop", self.fast_stop.into(), least, most);
        range("jerk_ratio", self.jerk_ratio.into(), 0, 100);
        if let Some(delay) = self.direction_delay {
            range("direction_delay", delay.as_nanos(), super::train::LEAST_DELAY, i64::MAX / 4);
        }
        match (self.output, self.b) {
            (PulseOutput::Pulse, Some(_)) => errors.push(AxisParameterError::NeedlessB),
            (PulseOutput::Pulse, None) | (_, Some(_)) => {}
            (_, None) => errors.push(AxisParameterError::NoB),
        }
        if self.output != PulseOutput::Quadrature && self.backlash > 0 {
            errors.push(AxisParameterError::OnlyQuadrature);
        }
        if self.output != PulseOutput::PulseDirection {
            if self.direction_delay.is_some() {
                errors.push(AxisParameterError::OnlyDirection("direction_delay"));
            }
            if self.direction_inverted {
                errors.push(AxisParameterError::OnlyDirection("direction_inverted"));
            }
        }
        if self.software_limits.is_some_and(|(lower, upper)| lower >= upper) {
            errors.push(AxisParameterError::Limits);
        }
        errors
    }

    /// The largest number that an acceleration may be.
    pub(crate) fn steepest(&self) -> u32 {
        match self.ramp_unit {
            RampUnit::HertzPerMs => STEEPEST,
            RampUnit::Ms => LONGEST_RAMP_MS,
        }
    }

    /// An acceleration in the axis' unit.
    pub(crate) fn rate(&self, acceleration: u32) -> RampRate {
        match self.ramp_unit {
            RampUnit::HertzPerMs => RampRate::hertz_per_ms(acceleration),
            RampUnit::Ms => RampRate::within_ms(self.max_velocity, acceleration),
        }
    }
}
