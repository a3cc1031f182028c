//! Axes of a plan's settings as the controller takes them.

use expert::{AxisConfig, AxisParameterError, AxisRole, DriveInput, PulseOutput, RampUnit};
use plans::plan::FunctionSettings;

/// Steepest ramp, in milliseconds.
const STEEPEST_MS: u32 = 1;
/// Ramp after errors of the axis, in milliseconds.
const FAST_STOP_MS: u32 = 20;

/// An axis, or the key that it lacks.
pub(super) fn axis(said: &FunctionSettings, a: u8) -> Result<AxisConfig, &'static str> {
    let output = match said.word("output") {
        Some("clockwise") => PulseOutput::ClockwiseCounterclockwise,
        Some("pulse") => PulseOutput::Pulse,
        Some("quadrature") => PulseOutput::Quadrature,
        _ => PulseOutput::PulseDirection,
    };
    let b = said.terminal("b");
    if b.is_none() && output != PulseOutput::Pulse {
        return Err("b");
    }
    let in_ms = said.word("ramp-unit") == Some("ms");
    let defaults = AxisConfig::new(a, b.unwrap_or(a));
    let number = |key: &str| said.number(key).and_then(|number| u32::try_from(number).ok());
    let ramp = |key: &str, default: u32, default_ms: u32| {
        number(key).unwrap_or(if in_ms { default_ms } else { default })
    };
    let low = |role: &str| said.words("active-low").iter().any(|word| word == role);
    let input = |key: &str| said.terminal(key).map(|input| DriveInput { input, inverted: low(key) });
    let limits = match *said.numbers("software-limits") {
        [] => None,
        [lower, upper] => i32::try_from(lower).ok().zip(i32::try_from(upper).ok()),
        _ => return Err("software-limits = [SMALLEST, LARGEST]"),
    };
    Ok(AxisConfig {
        output,
        b,
        drive_enable: said.terminal("drive-enable"),
        reference: input("ref"),
        index: input("index"),
        probe: input("probe"),
        limit_positive: input("limit-positive"),
        limit_negative: input("limit-negative"),
        drive_ready: input("drive-ready"),
        start_velocity: number("start-velocity").unwrap_or(defaults.start_velocity),
        stop_velocity: number("stop-velocity").unwrap_or(defaults.stop_velocity),
        max_velocity: number("max-velocity").unwrap_or(defaults.max_velocity),
        ramp_unit: if in_ms { RampUnit::Ms } else { RampUnit::HertzPerMs },
        max_acceleration: ramp("max-acceleration", defaults.max_acceleration, STEEPEST_MS),
        max_deceleration: ramp("max-deceleration", defaults.max_deceleration, STEEPEST_MS),
        fast_stop: ramp("fast-stop", defaults.fast_stop, FAST_STOP_MS),
        jerk_ratio: number("jerk-ratio").and_then(|it| u8::try_from(it).ok()).unwrap_or(defaults.jerk_ratio),
        software_limits: limits,
        backlash: number("backlash").unwrap_or(defaults.backlash),
        direction_delay: said.time("direction-delay"),
        direction_inverted: said.flag("direction-inverted").unwrap_or(defaults.direction_inverted),
        ..defaults
    })
}

/// The key that says which input or output has a role.
pub(super) const fn key_of(role: AxisRole) -> &'static str {
    match role {
        AxisRole::A => "a",
        AxisRole::B => "b",
        AxisRole::DriveEnable => "drive-enable",
        AxisRole::Reference => "ref",
        AxisRole::Index => "index",
        AxisRole::Probe => "probe",
        AxisRole::LimitPositive => "limit-positive",
        AxisRole::LimitNegative => "limit-negative",
        AxisRole::DriveReady => "drive-ready",
    }
}

/// The key that a parameter is about.
pub(super) fn key_of_parameter(error: AxisParameterError) -> String {
    match error {
        AxisParameterError::OutOfRange { parameter, .. } | AxisParameterError::OnlyDirection(parameter) => {
            parameter.replace('_', "-")
        }
        AxisParameterError::NoB | AxisParameterError::NeedlessB => "b".to_owned(),
        AxisParameterError::OnlyQuadrature => "backlash".to_owned(),
        AxisParameterError::Limits => "software-limits".to_owned(),
    }
}
