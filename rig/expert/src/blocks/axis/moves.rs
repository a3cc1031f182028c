//! Blocks that move an axis.

use super::{
    AXIS, BlockCall, BlockType, Body, EXECUTE, LAST, OUTCOME, PinType, Places, SHOWN, TICKET, ValueType,
    execute, input, output, pick,
};
use crate::axis::{AxisCommand, AxisFault, BufferMode, Homing, HomingMethod, MotionCommand};
use signal::Span;

pub(in crate::blocks) const BLOCKS: &[BlockType] = &[
    BlockType {
        name: "MC_MoveAbsolute_PTO",
        pins: MOVE_ABSOLUTE,
        run: |call| travel(call, MotionCommand::To),
    },
    BlockType {
        name: "MC_MoveRelative_PTO",
        pins: MOVE_RELATIVE,
        run: |call| travel(call, MotionCommand::By),
    },
    BlockType { name: "MC_MoveVelocity_PTO", pins: MOVE_VELOCITY, run: move_velocity },
    BlockType { name: "MC_Halt_PTO", pins: HALT, run: halt },
    BlockType { name: "MC_Stop_PTO", pins: STOP, run: stop },
    BlockType { name: "MC_Home_PTO", pins: HOME, run: home },
];

const DONE: PinType = output("Done", ValueType::Bool);
const BUSY: PinType = output("Busy", ValueType::Bool);
const ACTIVE: PinType = output("Active", ValueType::Bool);
const ABORTED: PinType = output("CommandAborted", ValueType::Bool);
const ERROR: PinType = output("Error", ValueType::Bool);
const ERROR_ID: PinType = output("ErrorID", ValueType::Word);
const REFERENCE: PinType = input("Axis", ValueType::Reference);
const START: PinType = input("Execute", ValueType::Bool);
const VELOCITY: PinType = input("Velocity", ValueType::Dint);
const ACCELERATION: PinType = input("Acceleration", ValueType::Dint);
const DECELERATION: PinType = input("Deceleration", ValueType::Dint);
const JERK_RATIO: PinType = input("JerkRatio", ValueType::Int);
const DIRECTION: PinType = input("Direction", ValueType::Int);
const BUFFER_MODE: PinType = input("BufferMode", ValueType::Int);
/// Of buffer mode seBufferedDelay, in milliseconds.
const DELAY: PinType = input("Delay", ValueType::Udint);

const fn travel_pins(goal: &'static str) -> [PinType; 19] {
    [
        REFERENCE,
        START,
        input(goal, ValueType::Dint),
        VELOCITY,
        ACCELERATION,
        DECELERATION,
        JERK_RATIO,
        BUFFER_MODE,
        DELAY,
        DONE,
        BUSY,
        ACTIVE,
        ABORTED,
        ERROR,
        ERROR_ID,
        LAST,
        TICKET,
        OUTCOME,
        SHOWN,
    ]
}
const MOVE_ABSOLUTE: &[PinType] = &travel_pins("Position");
const MOVE_RELATIVE: &[PinType] = &travel_pins("Distance");

fn travel(call: &mut BlockCall<'_>, order: fn(i64) -> MotionCommand) {
    execute(
        call,
        &Places::command(9),
        |body| {
            let order = order(body.pins.get(2));
            let velocity = velocity(body, 3)?;
            // No pulses get nowhere.
            if velocity == 0 {
                return Err(AxisFault::InvalidVelocity);
            }
            command(body, order, velocity, 4, Some(7))
        },
        |axis, ticket| axis.phase(ticket),
    );
}

const MOVE_VELOCITY: &[PinType] = &[
    REFERENCE,
    START,
    VELOCITY,
    ACCELERATION,
    DECELERATION,
    JERK_RATIO,
    BUFFER_MODE,
    DELAY,
    DIRECTION,
    output("InVelocity", ValueType::Bool),
    BUSY,
    ACTIVE,
    ABORTED,
    ERROR,
    ERROR_ID,
    LAST,
    TICKET,
    OUTCOME,
    SHOWN,
];

fn move_velocity(call: &mut BlockCall<'_>) {
    execute(
        call,
        &Places::command(9),
        |body| {
            // A negative velocity turns the direction round.
            let backwards = body.pins.get(2) < 0;
            let forward = direction(body, 8)?;
            let forward = match forward {
                Some(forward) => Some(forward != backwards),
                None if backwards => Some(!body.axis.forward()),
                None => None,
            };
            let velocity = body.axis.velocity_of(body.pins.get(2).abs())?;
            command(body, MotionCommand::Velocity(forward), velocity, 3, Some(6))
        },
        |axis, ticket| axis.phase(ticket),
    );
}

const HALT: &[PinType] = &[
    REFERENCE,
    START,
    DECELERATION,
    JERK_RATIO,
    BUFFER_MODE,
    DELAY,
    DONE,
    BUSY,
    ACTIVE,
    ABORTED,
    ERROR,
    ERROR_ID,
    LAST,
    TICKET,
    OUTCOME,
    SHOWN,
];

fn halt(call: &mut BlockCall<'_>) {
    execute(
        call,
        &Places::command(6),
        |body| slow_down(body, MotionCommand::Halt, Some(4)),
        |axis, ticket| axis.phase(ticket),
    );
}

const STOP: &[PinType] = &[
    REFERENCE,
    START,
    DECELERATION,
    JERK_RATIO,
    DONE,
    BUSY,
    ACTIVE,
    ABORTED,
    ERROR,
    ERROR_ID,
    LAST,
    TICKET,
    OUTCOME,
    SHOWN,
];

fn stop(call: &mut BlockCall<'_>) {
    execute(
        call,
        &Places::command(4),
        |body| slow_down(body, MotionCommand::Stop, None),
        |axis, ticket| axis.phase(ticket),
    );
    // Stopping lasts until Execute is FALSE, even if that was long ago.
    if call.pins.get(EXECUTE) == 0
        && let Ok(ticket) = u32::try_from(call.pins.get(11))
    {
        call.expert.call(call.now, call.pins.get(AXIS), pick, |axis, _| axis.release(ticket));
    }
}

const HOME: &[PinType] = &[
    REFERENCE,
    START,
    input("Mode", ValueType::Int),
    input("Position", ValueType::Dint),
    input("HighVelocity", ValueType::Dint),
    input("LowVelocity", ValueType::Dint),
    ACCELERATION,
    DECELERATION,
    JERK_RATIO,
    DIRECTION,
    input("Offset", ValueType::Dint),
    DONE,
    BUSY,
    ACTIVE,
    ABORTED,
    ERROR,
    ERROR_ID,
    LAST,
    TICKET,
    OUTCOME,
    SHOWN,
];

fn home(call: &mut BlockCall<'_>) {
    execute(
        call,
        &Places::command(11),
        |body| {
            let mode = Homing::of(body.pins.get(2)).ok_or(AxisFault::InvalidHomingMode)?;
            let position = body.pins.get(3);
            if mode == Homing::PositionSetting {
                // Nothing moves, so nothing is asked of velocities.
                let method = HomingMethod { mode, forward: true, position, fast: 0, slow: 0, offset: 0 };
                let ramps = body.axis.steepest_ramps();
                return body.axis.command(body.now, plain(MotionCommand::Home(method), 0, ramps), body.fx);
            }
            let (fast, slow) = (velocity(body, 4)?, velocity(body, 5)?);
            if slow == 0 || fast < slow {
                return Err(AxisFault::InvalidVelocity);
            }
            let forward = direction(body, 9)?.ok_or(AxisFault::InvalidDirection)?;
            let offset = body.pins.get(10);
            let method = HomingMethod { mode, forward, position, fast, slow, offset };
            command(body, MotionCommand::Home(method), fast, 6, None)
        },
        |axis, ticket| axis.phase(ticket),
    );
}

fn velocity(body: &Body<'_>, place: usize) -> Result<i64, AxisFault> {
    body.axis.velocity_of(body.pins.get(place))
}

/// The numbers of PLCopen: 1 positive, 3 negative, 4 the current one. 0, which an unused pin has, is positive.
fn direction(body: &Body<'_>, place: usize) -> Result<Option<bool>, AxisFault> {
    match body.pins.get(place) {
        0 | 1 => Ok(Some(true)),
        3 => Ok(Some(false)),
        4 => Ok(None),
        _ => Err(AxisFault::InvalidDirection),
    }
}

fn plain(order: MotionCommand, velocity: i64, ramps: crate::axis::Ramps) -> AxisCommand {
    AxisCommand { order, velocity, ramps, mode: BufferMode::Aborting, delay: Span::ZERO }
}

/// Gives a command whose acceleration, deceleration and jerk ratio stand from a place on, and whose buffer mode and delay
/// do from another.
fn command(
    body: &mut Body<'_>,
    order: MotionCommand,
    velocity: i64,
    ramps: usize,
    mode: Option<usize>,
) -> Result<u32, AxisFault> {
    let (acceleration, deceleration, jerk_ratio) =
        (body.pins.get(ramps), body.pins.get(ramps + 1), body.pins.get(ramps + 2));
    let ramps = body.axis.ramps_of(velocity, acceleration, deceleration, jerk_ratio)?;
    give(body, plain(order, velocity, ramps), mode)
}

/// Gives a command that only slows down.
fn slow_down(body: &mut Body<'_>, order: MotionCommand, mode: Option<usize>) -> Result<u32, AxisFault> {
    let ramps = body.axis.slowing_ramps(body.now, body.pins.get(2), body.pins.get(3))?;
    give(body, plain(order, 0, ramps), mode)
}

fn give(body: &mut Body<'_>, mut command: AxisCommand, mode: Option<usize>) -> Result<u32, AxisFault> {
    if let Some(place) = mode {
        command.mode = BufferMode::of(body.pins.get(place)).ok_or(AxisFault::InvalidBufferMode)?;
        command.delay = Span::from_millis(body.pins.get(place + 1));
    }
    body.axis.command(body.now, command, body.fx)
}
