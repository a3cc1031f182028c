//! Blocks that read something of an axis.

use super::{AXIS, BlockCall, BlockType, PinType, ValueType, input, output, pick, unknown};
use crate::axis::{Axis, AxisFault, AxisState};
use signal::Time;

pub(in crate::blocks) const BLOCKS: &[BlockType] = &[
    BlockType { name: "MC_ReadStatus_PTO", pins: STATUS, run: |call| read(call, 2, status) },
    BlockType { name: "MC_ReadMotionState_PTO", pins: MOTION_STATE, run: |call| read(call, 2, motion_state) },
    BlockType {
        name: "MC_ReadActualVelocity_PTO",
        pins: VELOCITY,
        run: |call| read(call, 2, |axis, now, _| Ok([axis.velocity(now)])),
    },
    BlockType {
        name: "MC_ReadActualPosition_PTO",
        pins: POSITION,
        run: |call| read(call, 2, |axis, _, _| Ok([axis.position()])),
    },
    BlockType {
        name: "MC_ReadParameter_PTO",
        pins: PARAMETER,
        run: |call| read(call, 3, |axis, now, number| Ok([axis.parameter(now, number)?])),
    },
    BlockType {
        name: "MC_ReadAxisError_PTO",
        pins: AXIS_ERROR,
        run: |call| read(call, 2, |axis, _, _| Ok([axis.fault().map_or(0, |it| it.number().into())])),
    },
];

const REFERENCE: PinType = input("Axis", ValueType::Reference);
const ENABLE: PinType = input("Enable", ValueType::Bool);
const VALID: PinType = output("Valid", ValueType::Bool);
const BUSY: PinType = output("Busy", ValueType::Bool);
const ERROR: PinType = output("Error", ValueType::Bool);
const ERROR_ID: PinType = output("ErrorID", ValueType::Word);

const VELOCITY: &[PinType] =
    &[REFERENCE, ENABLE, VALID, BUSY, ERROR, ERROR_ID, output("Velocity", ValueType::Dint)];
const POSITION: &[PinType] =
    &[REFERENCE, ENABLE, VALID, BUSY, ERROR, ERROR_ID, output("Position", ValueType::Dint)];
const AXIS_ERROR: &[PinType] =
    &[REFERENCE, ENABLE, VALID, BUSY, ERROR, ERROR_ID, output("AxisErrorID", ValueType::Word)];
const PARAMETER: &[PinType] = &[
    REFERENCE,
    ENABLE,
    input("ParameterNumber", ValueType::Int),
    VALID,
    BUSY,
    ERROR,
    ERROR_ID,
    output("Value", ValueType::Dint),
];
const STATUS: &[PinType] = &[
    REFERENCE,
    ENABLE,
    VALID,
    BUSY,
    ERROR,
    ERROR_ID,
    output("ErrorStop", ValueType::Bool),
    output("Disabled", ValueType::Bool),
    output("Stopping", ValueType::Bool),
    output("Homing", ValueType::Bool),
    output("Standstill", ValueType::Bool),
    output("DiscreteMotion", ValueType::Bool),
    output("ContinuousMotion", ValueType::Bool),
    output("IsHomed", ValueType::Bool),
    output("QueueFull", ValueType::Bool),
];
const MOTION_STATE: &[PinType] = &[
    REFERENCE,
    ENABLE,
    VALID,
    BUSY,
    ERROR,
    ERROR_ID,
    output("ConstantVelocity", ValueType::Bool),
    output("Accelerating", ValueType::Bool),
    output("Decelerating", ValueType::Bool),
    output("DirectionPositive", ValueType::Bool),
    output("DirectionNegative", ValueType::Bool),
];

fn status(axis: &Axis, _: Time, _: i64) -> Result<[i64; 9], AxisFault> {
    let is = |state| i64::from(axis.state() == state);
    Ok([
        is(AxisState::ErrorStop),
        is(AxisState::Disabled),
        is(AxisState::Stopping),
        is(AxisState::Homing),
        is(AxisState::Standstill),
        is(AxisState::DiscreteMotion),
        is(AxisState::ContinuousMotion),
        axis.homed().into(),
        axis.queue_full().into(),
    ])
}

fn motion_state(axis: &Axis, now: Time, _: i64) -> Result<[i64; 5], AxisFault> {
    let trend = axis.trend(now);
    let moves = trend.is_some();
    Ok([
        (trend == Some(0)).into(),
        (trend > Some(0)).into(),
        trend.is_some_and(|trend| trend < 0).into(),
        (moves && axis.forward()).into(),
        (moves && !axis.forward()).into(),
    ])
}

/// One call of a block that works while Enable is TRUE. Valid, Busy, Error and ErrorID stand at `first`, what it reads
/// after them; a number that it asks for stands at place 2.
fn read<const N: usize>(
    call: &mut BlockCall<'_>,
    first: usize,
    values: impl FnOnce(&Axis, Time, i64) -> Result<[i64; N], AxisFault>,
) {
    let pins = &mut *call.pins;
    let (enabled, number) = (pins.get(1) != 0, pins.get(2));
    let values = call.expert.call(call.now, pins.get(AXIS), pick, |axis, _| {
        if enabled { values(axis, call.now, number).map(Some) } else { Ok(None) }
    });
    let Some(values) = values else {
        pins.set(first, 0);
        pins.set(first + 1, 0);
        unknown(pins, first + 2, first + 3);
        return;
    };
    let fault = values.err();
    let values = values.ok().flatten();
    pins.set(first, values.is_some().into());
    pins.set(first + 1, enabled.into());
    pins.set(first + 2, fault.is_some().into());
    pins.set(first + 3, fault.map_or(0, |fault| fault.number().into()));
    for (place, value) in (first + 4..).zip(values.unwrap_or([0; N])) {
        pins.set(place, value);
    }
}
