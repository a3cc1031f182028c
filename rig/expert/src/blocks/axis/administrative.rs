//! Blocks that change an axis without moving it.

use super::{
    AXIS, BlockCall, BlockType, LAST, OUTCOME, PinType, Places, SHOWN, TICKET, ValueType, execute, input,
    output, pick, unknown,
};
use crate::axis::{CaptureTrigger, CommandPhase};

pub(in crate::blocks) const BLOCKS: &[BlockType] = &[
    BlockType { name: "MC_Power_PTO", pins: POWER, run: power },
    BlockType { name: "MC_SetPosition_PTO", pins: SET_POSITION, run: set_position },
    BlockType { name: "MC_WriteParameter_PTO", pins: WRITE_PARAMETER, run: write_parameter },
    BlockType { name: "MC_TouchProbe_PTO", pins: TOUCH_PROBE, run: touch_probe },
    BlockType { name: "MC_AbortTrigger_PTO", pins: ABORT_TRIGGER, run: abort_trigger },
    BlockType { name: "MC_Reset_PTO", pins: RESET, run: reset },
];

const REFERENCE: PinType = input("Axis", ValueType::Reference);
const START: PinType = input("Execute", ValueType::Bool);
const DONE: PinType = output("Done", ValueType::Bool);
const BUSY: PinType = output("Busy", ValueType::Bool);
const ERROR: PinType = output("Error", ValueType::Bool);
const ERROR_ID: PinType = output("ErrorID", ValueType::Word);

const POWER: &[PinType] = &[
    REFERENCE,
    input("Enable", ValueType::Bool),
    output("Status", ValueType::Bool),
    output("Valid", ValueType::Bool),
    ERROR,
    ERROR_ID,
];

/// Works with the level of Enable, not its edge.
fn power(call: &mut BlockCall<'_>) {
    let pins = &mut *call.pins;
    let enable = pins.get(1) != 0;
    let status = call.expert.call(call.now, pins.get(AXIS), pick, |axis, fx| {
        axis.power(call.now, enable, fx);
        axis.powered()
    });
    match status {
        Some(status) => {
            pins.set(2, status.into());
            pins.set(3, 1);
            pins.set(4, 0);
            pins.set(5, 0);
        }
        None => unknown(pins, 4, 5),
    }
}

const SET_POSITION: &[PinType] = &[
    REFERENCE,
    START,
    input("Position", ValueType::Dint),
    input("Relative", ValueType::Bool),
    DONE,
    BUSY,
    ERROR,
    ERROR_ID,
    LAST,
    TICKET,
    OUTCOME,
    SHOWN,
];

fn set_position(call: &mut BlockCall<'_>) {
    execute(
        call,
        &Places::simple(4),
        |body| {
            let from = if body.pins.get(3) != 0 { body.axis.position() } else { 0 };
            body.axis.set_position(from.saturating_add(body.pins.get(2))).map(|()| 0)
        },
        |_, _| CommandPhase::Done,
    );
}

const WRITE_PARAMETER: &[PinType] = &[
    REFERENCE,
    START,
    input("ParameterNumber", ValueType::Int),
    input("Value", ValueType::Dint),
    DONE,
    BUSY,
    ERROR,
    ERROR_ID,
    LAST,
    TICKET,
    OUTCOME,
    SHOWN,
];

fn write_parameter(call: &mut BlockCall<'_>) {
    execute(
        call,
        &Places::simple(4),
        |body| body.axis.set_parameter(body.pins.get(2), body.pins.get(3)).map(|()| 0),
        |_, _| CommandPhase::Done,
    );
}

const TOUCH_PROBE: &[PinType] = &[
    REFERENCE,
    START,
    input("WindowOnly", ValueType::Bool),
    input("FirstPosition", ValueType::Dint),
    input("LastPosition", ValueType::Dint),
    input("FallingEdge", ValueType::Bool),
    output("RecordedPosition", ValueType::Dint),
    DONE,
    BUSY,
    output("Active", ValueType::Bool),
    output("CommandAborted", ValueType::Bool),
    ERROR,
    ERROR_ID,
    LAST,
    TICKET,
    OUTCOME,
    SHOWN,
];

fn touch_probe(call: &mut BlockCall<'_>) {
    let mut recorded = None;
    execute(
        call,
        &Places::command(7),
        |body| {
            let pins = &body.pins;
            let window = (pins.get(2) != 0).then(|| (pins.get(3), pins.get(4)));
            body.axis.touch(CaptureTrigger { rising: pins.get(5) == 0, window })
        },
        |axis, ticket| {
            let (phase, position) = axis.touched(ticket);
            recorded = (phase == CommandPhase::Done).then_some(position);
            phase
        },
    );
    if let Some(position) = recorded {
        call.pins.set(6, position);
    }
}

const ABORT_TRIGGER: &[PinType] =
    &[REFERENCE, START, DONE, BUSY, ERROR, ERROR_ID, LAST, TICKET, OUTCOME, SHOWN];

fn abort_trigger(call: &mut BlockCall<'_>) {
    execute(
        call,
        &Places::simple(2),
        |body| body.axis.abort_trigger().map(|()| 0),
        |_, _| CommandPhase::Done,
    );
}

const RESET: &[PinType] = ABORT_TRIGGER;

fn reset(call: &mut BlockCall<'_>) {
    execute(
        call,
        &Places::simple(2),
        |_| Ok(0),
        |axis, _| match axis.acknowledge() {
            Ok(true) => CommandPhase::Done,
            Ok(false) => CommandPhase::Active,
            Err(fault) => CommandPhase::Failed(fault),
        },
    );
}
