//! The interpreter: executes operations until the budget, the cycle or a watch ends the slice.

mod fast;
mod library;
mod number;
mod operations;
mod quick;
mod service;
mod text;
mod world;

pub(crate) use fast::PreparedCode;
pub(crate) use service::finish_service;

use crate::code::{AddressBase, Op, Operand, map};
use crate::host::{Host, MachineSlice, ProgramFault, ProgramFaultKind, StopReason};
use crate::library::{Service, convert};
use crate::program::Program;
use crate::state::{Debug, PinOffsets, Scratch, ServiceCall, TaskRegisters, TaskState};
use crate::types::Elementary;
use library::CallResult;
use number::{Canonical, RawNumber, max_f32, max_f64, min_f32, min_f64, shift, spread, turn};
use operations::operations;
use quick::{QuickContext, QuickPlace};
use signal::{Span, Time};
use text::{TextOperands, TextSpan};
use world::{By, ProgramMemory, Stored};

/// Why the loop ended.
enum Exit {
    Budget(u32),
    Done,
    Touched,
    Break,
    Service(Service, i64),
    Fault(ProgramFaultKind),
}

/// What a slice works on, besides the task.
pub(crate) struct MachineParts<'a> {
    pub program: &'a Program,
    pub prepared: &'a PreparedCode,
    /// Beside the program's native blocks.
    pub natives: &'a [PinOffsets],
    pub memory: &'a mut [u8],
    pub flags: &'a [u8],
    pub scratch: &'a mut Scratch,
    pub debug: &'a mut Debug,
    /// Gathers the flags of bytes that changed.
    pub changed: &'a mut u8,
    /// Nanoseconds that pass for what blocks and functions see of the time, for each nanosecond of cost: 1 or 0.
    pub pace: i64,
}

/// One slice of a task. The variant with `DEBUG` minds breakpoints and coverage.
///
/// Everything that an operation touches often is a local variable here; what happens seldom is in functions that are
/// kept out of line. Operands are read and written with one check of bounds each, whose failure is the slow path.
pub(crate) fn run<const DEBUG: bool>(
    parts: MachineParts<'_>,
    task: &mut TaskState,
    now: Time,
    budget: Span,
    host: &mut dyn Host,
) -> MachineSlice {
    let MachineParts { program, prepared, natives, memory, flags, scratch, debug, changed, pace } = parts;
    let budget = budget.as_nanos().max(0);
    let mut left = budget;
    if task.position >= task.programs.len() {
        return MachineSlice { used: Span::ZERO, stop: StopReason::Done };
    }
    let mut world = ProgramMemory { program, flags, host, changed: 0 };
    let PreparedCode { code, indexes, quick } = prepared;
    let (code, indexes) = (code.as_slice(), indexes.as_slice());
    // As long as the memory: one check of bounds does for both.
    let Some(flags) = flags.get(..memory.len()) else {
        return MachineSlice { used: Span::ZERO, stop: StopReason::Done };
    };
    let units = program.units.as_slice();
    let TaskRegisters { pc, this, base, mut unit } = task.registers;
    let mut pc = pc as usize;
    let mut here = pc;
    // By `From`.
    let mut bases = [0, this, base];
    let mut branched = false;

    let exit = 'slice: loop {
        if !DEBUG && let Some(entry) = quick.entry(pc) {
            let around = QuickContext { program, memory, flags, pins: natives, task, now, budget, pace };
            QuickPlace { pc, left, bases, unit } =
                quick.go(around, entry, QuickPlace { pc, left, bases, unit });
        }
        let Some(step) = code.get(pc) else { break Exit::Fault(ProgramFaultKind::Internal) };
        if DEBUG && debug.stops(pc, task) {
            break Exit::Break;
        }
        left -= i64::from(step.cost);
        if left < 0 {
            left += i64::from(step.cost);
            break Exit::Budget(step.cost);
        }
        if DEBUG {
            debug.passed(std::mem::take(&mut branched).then_some(here), pc, program);
            branched = step.op.branches();
            debug.begin(pc, task);
        }
        here = pc;
        pc += 1;
        let [from_a, from_b, from_c] = step.from;
        let mut a = bases[from_a as usize].wrapping_add(step.a);
        let mut b = bases[from_b as usize].wrapping_add(step.b);
        let mut c = bases[from_c as usize].wrapping_add(step.c);

        macro_rules! fault {
            ($kind:ident) => {
                break 'slice Exit::Fault(ProgramFaultKind::$kind)
            };
        }
        // Where an operand that stands in a table leads.
        macro_rules! resolve {
            ($operand:expr) => {
                resolve!($operand, BadReference)
            };
            ($operand:expr, $kind:ident) => {
                match place(memory, bases, $operand) {
                    Some(at) => at,
                    None => fault!($kind),
                }
            };
        }
        macro_rules! load {
            (f32, $at:expr) => {
                f32::from_bits(load!(u32, $at))
            };
            (f64, $at:expr) => {
                f64::from_bits(load!(u64, $at))
            };
            ($ty:ident, $at:expr) => {{
                let at: u32 = $at;
                let bytes = memory.get(at as usize..at as usize + size_of::<$ty>());
                match bytes.and_then(|bytes| bytes.first_chunk()) {
                    Some(bytes) => $ty::from_le_bytes(*bytes),
                    None => match world.load(memory, at, $ty::BITS / 8) {
                        Some(value) => value as $ty,
                        None => fault!(BadReference),
                    },
                }
            }};
        }
        macro_rules! settle {
            ($stored:expr) => {
                match $stored {
                    Stored::Fine => {}
                    Stored::Touched => break 'slice Exit::Touched,
                    Stored::Bad => fault!(ReservedWrite),
                }
            };
        }
        macro_rules! put {
            ($at:expr, $value:expr) => {{
                let value = $value;
                let at: u32 = $at;
                let bytes = value.to_le_bytes();
                let first = at as usize;
                // As an array: a copy of a slice is a call.
                let to = memory.get_mut(first..).and_then(|rest| rest.first_chunk_mut());
                match (to, flags.get(first)) {
                    (Some(to), Some(0)) => *to = bytes,
                    _ => settle!(world.store(
                        memory,
                        at,
                        bytes.len() as u32,
                        value as u64,
                        By { pc: here, unit }
                    )),
                }
            }};
        }
        macro_rules! one {
            ($ty:ident, |$b:ident| $result:expr) => {{
                let $b = load!($ty, b);
                put!(a, RawNumber::raw($result));
            }};
        }
        macro_rules! two {
            ($ty:ident, |$b:ident, $c:ident| $result:expr) => {{
                let $b = load!($ty, b);
                let $c = load!($ty, c);
                put!(a, RawNumber::raw($result));
            }};
        }
        macro_rules! divide {
            ($ty:ident, $divide:ident) => {{
                let b = load!($ty, b);
                let c = load!($ty, c);
                if c == 0 {
                    fault!(DivisionByZero);
                }
                put!(a, b.$divide(c));
            }};
        }
        macro_rules! divide_real {
            ($ty:ident) => {{
                let b = load!($ty, b);
                let c = load!($ty, c);
                if c == 0.0 {
                    fault!(RealDivisionByZero);
                }
                put!(a, RawNumber::raw((b / c).canonical()));
            }};
        }
        macro_rules! count {
            ($ty:ident, |$b:ident, $n:ident| $result:expr) => {{
                let $b = load!($ty, b);
                let $n = load!(i64, c);
                put!(a, $result);
            }};
        }
        macro_rules! compare {
            ($ty:ident, |$b:ident, $c:ident| $holds:expr) => {{
                let $b = load!($ty, b);
                let $c = load!($ty, c);
                put!(a, u8::from($holds));
            }};
        }
        macro_rules! jump {
            ($ty:ident, |$b:ident, $c:ident| $holds:expr) => {{
                let $b = load!($ty, b);
                let $c = load!($ty, c);
                if $holds {
                    pc = a as usize;
                }
            }};
        }
        macro_rules! test {
            (|$b:ident| $holds:expr) => {{
                let $b = load!(u8, b);
                if $holds {
                    pc = a as usize;
                }
            }};
        }
        macro_rules! index {
            ($ty:ident, |$n:ident| $nth:expr) => {{
                let $n = load!($ty, b);
                let nth: i64 = $nth;
                let Some(index) = indexes.get(c as usize) else { fault!(Internal) };
                if nth < index.low || nth > index.high {
                    fault!(Bounds);
                }
                let mut first = bases[index.from as usize].wrapping_add(index.of);
                if index.indirect {
                    first = load!(u32, first);
                    if first < map::FIRST {
                        if index.stored {
                            fault!(ReservedWrite);
                        }
                        fault!(BadReference);
                    }
                }
                let offset = nth.wrapping_sub(index.low).wrapping_mul(i64::from(index.stride));
                let at = first.wrapping_add(offset as u32);
                put!(a, at);
            }};
        }
        macro_rules! turn {
            ($ty:ident) => {{
                let next = load!($ty, b).wrapping_add(1);
                // The end may be the variable itself.
                let end = if b == c { next } else { load!($ty, c) };
                if next <= end {
                    pc = a as usize;
                }
                put!(b, next);
            }};
        }
        // The frame after the running one, for a callee, with the room that it takes checked.
        macro_rules! room {
            ($callee:expr) => {{
                let Some(callee) = units.get($callee as usize) else { fault!(Internal) };
                let size = units.get(usize::from(unit)).map_or(0, |unit| unit.frame);
                let next = bases[2].saturating_add(size);
                if next.saturating_add(callee.frame) > task.end || task.callers.len() >= task.depth {
                    fault!(StackDepth);
                }
                (callee, next)
            }};
        }
        macro_rules! frame {
            ($callee:expr) => {{
                let (callee, next) = room!($callee);
                let end = next as usize + callee.template.len();
                match memory.get_mut(next as usize..end) {
                    Some(frame) => frame.copy_from_slice(&callee.template),
                    None => fault!(Internal),
                }
            }};
        }
        macro_rules! call {
            ($callee:expr, $this:expr) => {{
                let (callee, next) = room!($callee);
                task.callers.push(TaskRegisters { pc: pc as u32, this: bases[1], base: bases[2], unit });
                bases = [0, $this, next];
                unit = $callee as u16;
                pc = callee.entry as usize;
            }};
        }
        // The instance whose address is at an operand, and its class.
        macro_rules! class {
            ($at:expr) => {{
                let at = load!(u32, $at);
                let word = match memory.get(at as usize..).and_then(|memory| memory.first_chunk()) {
                    Some(bytes) if at >= map::FIRST => u32::from_le_bytes(*bytes),
                    _ => fault!(BadReference),
                };
                let class = (word as usize).checked_sub(1).and_then(|class| program.classes.get(class));
                let Some(class) = class else { fault!(BadReference) };
                (at, class)
            }};
        }
        macro_rules! method {
            () => {{
                let (at, class) = class!(b);
                match class.methods.get(a as usize) {
                    Some(Some(method)) => (at, *method),
                    _ => fault!(BadReference),
                }
            }};
        }

        macro_rules! follow {
            ($bit:literal, $at:ident, $kind:ident) => {
                if step.indirect & $bit != 0 {
                    $at = load!(u32, $at);
                    if $at < map::FIRST {
                        fault!($kind);
                    }
                }
            };
        }
        if step.indirect != 0 {
            follow!(2, b, BadReference);
            follow!(4, c, BadReference);
            // What an operation writes is `a` always, and it reads before.
            follow!(1, a, ReservedWrite);
        }

        macro_rules! op {
            ($name:ident) => {
                Op::$name
            };
        }
        operations!(step.op, {
            Op::Copy => {
                let (to, from) = (a, b);
                match world.copy(memory, to, from, c, By { pc: here, unit }) {
                    Some(stored) => settle!(stored),
                    None => fault!(BadReference),
                }
            }
            Op::Address => put!(a, b),
            Op::Convert => {
                let ty = |place: u32| Elementary::ALL.get((place & 0xFF) as usize).copied();
                let (Some(from), Some(to)) = (ty(c >> 8), ty(c)) else { fault!(Internal) };
                let at = b;
                let Some(cell) = world.cell(memory, at, from) else { fault!(BadReference) };
                let cell = convert(from, to, cell);
                let at = a;
                settle!(world.store(memory, at, to.bytes() as u32, cell as u64, By { pc: here, unit }));
            }
            Op::LoadBit => {
                let at = b;
                match world.load_bit(memory, at, c) {
                    Some(on) => put!(a, u8::from(on)),
                    None => fault!(BadReference),
                }
            }
            Op::StoreBit => {
                let on = load!(u8, b) != 0;
                let at = a;
                settle!(world.store_bit(memory, at, c, on, By { pc: here, unit }));
            }
            Op::Jump => pc = a as usize,
            Op::Frame => frame!(a),
            Op::FrameVirtual => {
                let (_, method) = method!();
                frame!(method);
            }
            Op::Call => call!(a, 0),
            Op::CallThis => {
                let this = b;
                if this as usize >= memory.len() {
                    fault!(BadReference);
                }
                call!(a, this);
            }
            Op::CallSame => call!(a, bases[1]),
            Op::CallVirtual => {
                let (this, method) = method!();
                call!(method, this);
            }
            Op::CallNative => {
                let at = b;
                let (Some(native), Some(pins)) = (program.natives.get(a as usize), natives.get(a as usize))
                else {
                    fault!(Internal)
                };
                let now = now.saturating_add(Span::from_nanos((budget - left) * pace));
                match world.call_native(memory, native, pins, at, now) {
                    Stored::Bad => fault!(BadReference),
                    stored => settle!(stored),
                }
            }
            Op::CallLibrary => {
                let Some(call) = program.library.get(b as usize) else { fault!(Internal) };
                let place = |memory: &[u8], operand| place(memory, bases, operand);
                let now = now.saturating_add(Span::from_nanos((budget - left) * pace));
                match world.call_library(memory, scratch, call, place, now, By { pc: here, unit }) {
                    Ok(CallResult::Done(stored)) => settle!(stored),
                    Ok(CallResult::Asks(service, argument)) => {
                        task.asks = Some(ServiceCall { call: b, service, argument, answer: None });
                        break 'slice Exit::Service(service, argument);
                    }
                    Err(kind) => break 'slice Exit::Fault(kind),
                }
            }
            Op::MoveText => {
                let Some(pair) = program.texts.get(c as usize) else { fault!(Internal) };
                let pair = TextOperands {
                    to: TextSpan::new(resolve!(pair.to.at, ReservedWrite), &pair.to),
                    of: TextSpan::new(resolve!(pair.of.at), &pair.of),
                };
                match world.move_text(memory, &pair, By { pc: here, unit }) {
                    Some(stored) => settle!(stored),
                    None => fault!(BadReference),
                }
            }
            Op::CompareText => {
                let Some(pair) = program.texts.get(c as usize) else { fault!(Internal) };
                let pair = TextOperands {
                    to: TextSpan::new(resolve!(pair.to.at), &pair.to),
                    of: TextSpan::new(resolve!(pair.of.at), &pair.of),
                };
                match world.compare_text(memory, &pair) {
                    Some(order) => put!(a, order),
                    None => fault!(BadReference),
                }
            }
            Op::IsKind => {
                let is = if load!(u32, b) == 0 { false } else { class!(b).1.kinds.binary_search(&c).is_ok() };
                put!(a, u8::from(is));
            }
            Op::Return => match task.callers.pop() {
                Some(caller) => {
                    pc = caller.pc as usize;
                    unit = caller.unit;
                    bases = [0, caller.this, caller.base];
                }
                None => {
                    task.position += 1;
                    if !task.enter(program, memory) {
                        break Exit::Done;
                    }
                    let TaskRegisters { pc: entry, this, base, unit: next } = task.registers;
                    (pc, unit, bases) = (entry as usize, next, [0, this, base]);
                }
            },
            // What is made for the quick loop alone.
            _ => fault!(Internal),
        })
    };
    if DEBUG && branched && !matches!(exit, Exit::Fault(_)) {
        debug.passed(Some(here), pc, program);
    }
    *changed |= world.changed;
    task.registers = TaskRegisters { pc: pc as u32, this: bases[1], base: bases[2], unit };
    let stop = match exit {
        Exit::Budget(next) => StopReason::Budget { next: Span::from_nanos(i64::from(next)) },
        Exit::Done => StopReason::Done,
        Exit::Touched => {
            let (file, line) = program.source_of(unit, here);
            StopReason::Touched { file, line }
        }
        Exit::Break => StopReason::Break,
        Exit::Service(service, argument) => StopReason::Service { service, argument },
        Exit::Fault(kind) => {
            task.position = task.programs.len();
            let (file, line) = program.source_of(unit, here);
            StopReason::Fault(ProgramFault { kind, file, line })
        }
    };
    MachineSlice { used: Span::from_nanos(budget - left), stop }
}

/// The address of an operand, for what resolves a list of them; `None` for a bad reference.
fn place(memory: &[u8], bases: [u32; 3], operand: Operand) -> Option<u32> {
    let [zero, this, frame] = bases;
    let base = match operand.base() {
        AddressBase::Absolute => zero,
        AddressBase::This => this,
        AddressBase::Frame | AddressBase::Indirect => frame,
    };
    let at = base.wrapping_add(operand.offset());
    if operand.base() != AddressBase::Indirect {
        return Some(at);
    }
    let bytes = memory.get(at as usize..)?.first_chunk()?;
    Some(u32::from_le_bytes(*bytes)).filter(|at| *at >= map::FIRST)
}
