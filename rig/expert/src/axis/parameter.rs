//! Parameters that a program can read and write, with the numbers of PLCopen.

use super::config::{LONGEST_RAMP_MS, RampUnit};
use super::profile::Ramps;
use super::ramp::HERTZ;
use super::{Axis, AxisConfig, AxisFault};
use signal::Time;

/// A parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AxisParameter {
    CommandedPosition,
    UpperLimit,
    LowerLimit,
    UpperLimitEnabled,
    LowerLimitEnabled,
    MaxVelocitySystem,
    MaxVelocity,
    ActualVelocity,
    CommandedVelocity,
    MaxAccelerationSystem,
    MaxAcceleration,
    MaxDecelerationSystem,
    MaxDeceleration,
    StartVelocity,
    StopVelocity,
    FastStop,
}

/// Numbers up to 15 are those of PLCopen, the others a definition of the rig.
const NUMBERS: [(i64, AxisParameter); 16] = [
    (1, AxisParameter::CommandedPosition),
    (2, AxisParameter::UpperLimit),
    (3, AxisParameter::LowerLimit),
    (4, AxisParameter::UpperLimitEnabled),
    (5, AxisParameter::LowerLimitEnabled),
    (8, AxisParameter::MaxVelocitySystem),
    (9, AxisParameter::MaxVelocity),
    (10, AxisParameter::ActualVelocity),
    (11, AxisParameter::CommandedVelocity),
    (12, AxisParameter::MaxAccelerationSystem),
    (13, AxisParameter::MaxAcceleration),
    (14, AxisParameter::MaxDecelerationSystem),
    (15, AxisParameter::MaxDeceleration),
    (1000, AxisParameter::StartVelocity),
    (1001, AxisParameter::StopVelocity),
    (1002, AxisParameter::FastStop),
];

fn parameter(number: i64) -> Result<AxisParameter, AxisFault> {
    let found = NUMBERS.iter().find(|(known, _)| *known == number);
    found.map(|(_, parameter)| *parameter).ok_or(AxisFault::UnknownParameter)
}

/// What holds for the next commands.
#[derive(Clone, Debug)]
pub struct AxisParameters {
    lower: i64,
    upper: i64,
    lower_enabled: bool,
    upper_enabled: bool,
    max_velocity: u32,
    max_acceleration: u32,
    max_deceleration: u32,
    start_velocity: u32,
    stop_velocity: u32,
    fast_stop: u32,
}

impl AxisParameters {
    pub fn new(config: &AxisConfig) -> AxisParameters {
        let (lower, upper) = config.software_limits.unwrap_or((i32::MIN, i32::MAX));
        AxisParameters {
            lower: lower.into(),
            upper: upper.into(),
            lower_enabled: config.software_limits.is_some(),
            upper_enabled: config.software_limits.is_some(),
            max_velocity: config.max_velocity,
            max_acceleration: config.max_acceleration,
            max_deceleration: config.max_deceleration,
            start_velocity: config.start_velocity,
            stop_velocity: config.stop_velocity,
            fast_stop: config.fast_stop,
        }
    }

    /// Whether a position is at or beyond the software limit of a direction.
    pub fn beyond(&self, forward: bool, position: i64) -> bool {
        if forward {
            self.upper_enabled && position >= self.upper
        } else {
            self.lower_enabled && position <= self.lower
        }
    }

    /// The first and the last velocity, in units.
    pub fn velocities(&self) -> (i64, i64) {
        (i64::from(self.start_velocity) * HERTZ, i64::from(self.stop_velocity) * HERTZ)
    }

    pub const fn fast_stop(&self) -> u32 {
        self.fast_stop
    }
}

impl Axis {
    /// A velocity in hertz as units.
    pub fn velocity_of(&self, hertz: i64) -> Result<i64, AxisFault> {
        if (0..=i64::from(self.parameters.max_velocity)).contains(&hertz) {
            Ok(hertz * HERTZ)
        } else {
            Err(AxisFault::InvalidVelocity)
        }
    }

    /// How velocities up to one in units change, with the numbers that a block gives.
    pub fn ramps_of(
        &self,
        velocity: i64,
        acceleration: i64,
        deceleration: i64,
        jerk_ratio: i64,
    ) -> Result<Ramps, AxisFault> {
        let ramp = |given: i64, most: u32, fault| {
            let least_steep = i64::from(LONGEST_RAMP_MS);
            let range = match self.config.ramp_unit {
                RampUnit::HertzPerMs => {
                    let hertz = velocity / HERTZ;
                    (hertz / least_steep + i64::from(hertz % least_steep != 0)).max(1)..=i64::from(most)
                }
                RampUnit::Ms => i64::from(most)..=least_steep,
            };
            let given = range.contains(&given).then_some(given).and_then(|it| u32::try_from(it).ok());
            given.map(|it| self.config.rate(it)).ok_or(fault)
        };
        let jerk_ratio = match jerk_ratio {
            0 => self.config.jerk_ratio,
            1..=100 => jerk_ratio as u8,
            _ => return Err(AxisFault::InvalidJerkRatio),
        };
        Ok(Ramps {
            rise: ramp(acceleration, self.parameters.max_acceleration, AxisFault::InvalidAcceleration)?,
            fall: ramp(deceleration, self.parameters.max_deceleration, AxisFault::InvalidDeceleration)?,
            jerk_ratio,
        })
    }

    /// The steepest ramps, for a command that needs none.
    pub fn steepest_ramps(&self) -> Ramps {
        Ramps {
            rise: self.config.rate(self.parameters.max_acceleration),
            fall: self.config.rate(self.parameters.max_deceleration),
            jerk_ratio: 0,
        }
    }

    /// How the axis slows down from its velocity.
    pub fn slowing_ramps(&self, now: Time, deceleration: i64, jerk_ratio: i64) -> Result<Ramps, AxisFault> {
        let velocity = self.velocity(now).abs() * HERTZ;
        self.ramps_of(velocity, self.parameters.max_acceleration.into(), deceleration, jerk_ratio)
    }

    /// The value of a parameter.
    pub fn parameter(&self, now: Time, number: i64) -> Result<i64, AxisFault> {
        let values = &self.parameters;
        Ok(match parameter(number)? {
            AxisParameter::CommandedPosition => self.position(),
            AxisParameter::UpperLimit => values.upper,
            AxisParameter::LowerLimit => values.lower,
            AxisParameter::UpperLimitEnabled => values.upper_enabled.into(),
            AxisParameter::LowerLimitEnabled => values.lower_enabled.into(),
            AxisParameter::MaxVelocitySystem => self.config.max_velocity.into(),
            AxisParameter::MaxVelocity => values.max_velocity.into(),
            // An open loop: what is commanded is what there is (io:PLS-01).
            AxisParameter::ActualVelocity | AxisParameter::CommandedVelocity => self.velocity(now),
            AxisParameter::MaxAccelerationSystem => self.config.max_acceleration.into(),
            AxisParameter::MaxAcceleration => values.max_acceleration.into(),
            AxisParameter::MaxDecelerationSystem => self.config.max_deceleration.into(),
            AxisParameter::MaxDeceleration => values.max_deceleration.into(),
            AxisParameter::StartVelocity => values.start_velocity.into(),
            AxisParameter::StopVelocity => values.stop_velocity.into(),
            AxisParameter::FastStop => values.fast_stop.into(),
        })
    }

    /// Changes a parameter; commands that come afterwards obey it.
    pub fn set_parameter(&mut self, number: i64, value: i64) -> Result<(), AxisFault> {
        let parameter = parameter(number)?;
        let mut changed = self.parameters.clone();
        let whole = || i32::try_from(value).map(i64::from).map_err(|_| AxisFault::InvalidParameterValue);
        let flag = || match value {
            0 | 1 => Ok(value == 1),
            _ => Err(AxisFault::InvalidParameterValue),
        };
        let within = |least: u32, most: u32| {
            let value = u32::try_from(value).map_err(|_| AxisFault::InvalidParameterValue)?;
            (least..=most).contains(&value).then_some(value).ok_or(AxisFault::InvalidParameterValue)
        };
        // The steepest ramp is the largest number of hertz a millisecond, or the smallest of milliseconds.
        let ramp = |steepest: u32| match self.config.ramp_unit {
            RampUnit::HertzPerMs => within(1, steepest),
            RampUnit::Ms => within(steepest, LONGEST_RAMP_MS),
        };
        match parameter {
            AxisParameter::UpperLimit => changed.upper = whole()?,
            AxisParameter::LowerLimit => changed.lower = whole()?,
            AxisParameter::UpperLimitEnabled => changed.upper_enabled = flag()?,
            AxisParameter::LowerLimitEnabled => changed.lower_enabled = flag()?,
            AxisParameter::MaxVelocity => changed.max_velocity = within(1, self.config.max_velocity)?,
            AxisParameter::MaxAcceleration => changed.max_acceleration = ramp(self.config.max_acceleration)?,
            AxisParameter::MaxDeceleration => changed.max_deceleration = ramp(self.config.max_deceleration)?,
            AxisParameter::StartVelocity => changed.start_velocity = within(0, self.parameters.max_velocity)?,
            AxisParameter::StopVelocity => changed.stop_velocity = within(0, self.parameters.max_velocity)?,
            AxisParameter::FastStop => changed.fast_stop = within(1, self.config.steepest())?,
            _ => return Err(AxisFault::ReadOnlyParameter),
        }
        if changed.lower >= changed.upper {
            return Err(AxisFault::InvalidParameterValue);
        }
        self.parameters = changed;
        Ok(())
    }
}
