//! The blocks of axes, with the handshakes of PLCopen Motion Control (io:STD-PTO-04).

mod administrative;
mod moves;
mod reads;
#[cfg(test)]
mod tests;

use super::{BlockCall, BlockPinKind, BlockPins, BlockType, PinType, ValueType, pin};
use crate::ExpertEffects;
use crate::axis::{Axis, AxisFault, CommandPhase};
use crate::functions::FunctionUnit;
use signal::Time;

pub(super) use administrative::BLOCKS as ADMINISTRATIVE;
pub(super) use moves::BLOCKS as MOVES;
pub(super) use reads::BLOCKS as READS;

const AXIS: usize = 0;
const EXECUTE: usize = 1;

const fn input(name: &'static str, ty: ValueType) -> PinType {
    pin(name, BlockPinKind::Input, ty)
}

const fn output(name: &'static str, ty: ValueType) -> PinType {
    pin(name, BlockPinKind::Output, ty)
}

/// The block's own memory: Execute of the last call, the command that runs, what became of it, and whether that was
/// shown by a call.
const LAST: PinType = pin("last Execute", BlockPinKind::Hidden, ValueType::Bool);
const TICKET: PinType = pin("command", BlockPinKind::Hidden, ValueType::Udint);
const OUTCOME: PinType = pin("outcome", BlockPinKind::Hidden, ValueType::Int);
const SHOWN: PinType = pin("outcome shown", BlockPinKind::Hidden, ValueType::Bool);

fn pick(unit: &mut FunctionUnit) -> Option<&mut Axis> {
    if let FunctionUnit::Axis(axis) = unit { Some(axis.as_mut()) } else { None }
}

/// Where the outputs of a block with Execute are. Its memory begins after them, in the order of the constants above.
struct Places {
    done: usize,
    busy: usize,
    active: Option<usize>,
    aborted: Option<usize>,
    error: usize,
    error_id: usize,
    memory: usize,
}

impl Places {
    /// Done, Busy, Active, CommandAborted, Error, ErrorID from a place on.
    const fn command(first: usize) -> Places {
        Places {
            done: first,
            busy: first + 1,
            active: Some(first + 2),
            aborted: Some(first + 3),
            error: first + 4,
            error_id: first + 5,
            memory: first + 6,
        }
    }

    /// Done, Busy, Error, ErrorID from a place on.
    const fn simple(first: usize) -> Places {
        Places {
            done: first,
            busy: first + 1,
            active: None,
            aborted: None,
            error: first + 2,
            error_id: first + 3,
            memory: first + 4,
        }
    }
}

/// What became of the command of a block, as its memory holds it; below 0 the number of its error.
const IDLE: i64 = 0;
const RUNNING: i64 = 1;
const DONE: i64 = 2;
const ABORTED: i64 = 3;

fn failed(fault: AxisFault) -> i64 {
    -i64::from(fault.number())
}

/// What a block does with its axis.
struct Body<'a> {
    now: Time,
    axis: &'a mut Axis,
    pins: &'a mut dyn BlockPins,
    fx: &'a mut ExpertEffects,
}

/// One call of a block that acts with the rising edge of Execute: `start` gives the command, `phase` says how far it is.
/// Its end is shown until Execute is FALSE, and by one call at least.
fn execute(
    call: &mut BlockCall<'_>,
    places: &Places,
    start: impl FnOnce(&mut Body<'_>) -> Result<u32, AxisFault>,
    phase: impl FnOnce(&mut Axis, u32) -> CommandPhase,
) {
    let pins = &mut *call.pins;
    let now = call.now;
    let known = call.expert.call(now, pins.get(AXIS), pick, |axis, fx| {
        let (last, ticket, outcome, shown) =
            (places.memory, places.memory + 1, places.memory + 2, places.memory + 3);
        let wanted = pins.get(EXECUTE) != 0;
        let mut body = Body { now, axis, pins: &mut *pins, fx };
        if wanted && body.pins.get(last) == 0 {
            let started = start(&mut body);
            pins.set(outcome, started.map_or_else(failed, |_| RUNNING));
            pins.set(ticket, started.unwrap_or(0).into());
            pins.set(shown, 0);
        } else if !wanted && pins.get(shown) != 0 {
            pins.set(outcome, IDLE);
            pins.set(shown, 0);
        }
        pins.set(last, wanted.into());
        let mut going = None;
        if pins.get(outcome) == RUNNING {
            let command = u32::try_from(pins.get(ticket)).unwrap_or(0);
            match phase(axis, command) {
                CommandPhase::Done => pins.set(outcome, DONE),
                CommandPhase::Aborted => pins.set(outcome, ABORTED),
                CommandPhase::Failed(fault) => pins.set(outcome, failed(fault)),
                other => going = Some(other),
            }
        }
        let outcome = pins.get(outcome);
        pins.set(shown, (!(IDLE..DONE).contains(&outcome)).into());
        // MoveVelocity has InVelocity in the place of Done.
        pins.set(places.done, (outcome == DONE || going == Some(CommandPhase::InVelocity)).into());
        pins.set(places.busy, (outcome == RUNNING).into());
        if let Some(active) = places.active {
            pins.set(active, matches!(going, Some(CommandPhase::Active | CommandPhase::InVelocity)).into());
        }
        if let Some(aborted) = places.aborted {
            pins.set(aborted, (outcome == ABORTED).into());
        }
        pins.set(places.error, (outcome < IDLE).into());
        pins.set(places.error_id, (-outcome).max(IDLE));
    });
    if known.is_none() {
        // What the block shows of its command waits until it knows the axis again.
        let ends = [Some(places.done), Some(places.busy), places.active, places.aborted];
        ends.into_iter().flatten().for_each(|place| pins.set(place, 0));
        unknown(pins, places.error, places.error_id);
    }
}

/// The reference is none of an axis (io:EXP-06).
fn unknown(pins: &mut dyn BlockPins, error: usize, error_id: usize) {
    pins.set(error, 1);
    pins.set(error_id, AxisFault::UnknownAxis.number().into());
}
