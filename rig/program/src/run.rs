//! The interpreter: executes operations until the budget, the cycle or a watch ends the slice.

use crate::code::{Bounds, Op};
use crate::machine::{Fault, FaultKind, Host, OPERANDS, Registers, Slice, Stop, Task, WATCHED};
use crate::native::Pins;
use crate::program::Program;
use crate::types::Elementary;
use signal::{Span, Time};

/// One slice of a task. `changed` collects the flags of cells that changed.
#[allow(clippy::too_many_arguments)]
pub(crate) fn run<H: Host>(
    program: &Program,
    cells: &mut [i64],
    flags: &[u8],
    task: &mut Task,
    changed: &mut u8,
    now: Time,
    budget: Span,
    host: &mut H,
) -> Slice {
    let budget = budget.as_nanos().max(0);
    let mut left = budget;
    if task.position >= task.programs.len() {
        return Slice { used: Span::ZERO, stop: Stop::Done };
    }
    let mut pc = task.registers.pc as usize;
    let mut this = task.registers.this;
    let mut base = task.registers.base as usize;
    let mut unit = task.registers.unit;
    let mut sp = task.registers.sp;
    let mut acc = task.registers.acc;
    let (code, plain) = (program.code.as_slice(), program.plain.as_slice());
    let units = program.units.as_slice();
    let Task { programs, position, registers, callers, frames, operands } = task;
    let operands: &mut [i64; OPERANDS] = operands;

    let stop = 'slice: loop {
        let Some(mut step) = code.get(pc) else {
            *position = programs.len();
            break Stop::Fault(Fault { kind: FaultKind::Internal, file: 0, line: 0 });
        };
        let mut after = left - i64::from(step.cost);
        if after < 0 {
            // Of a run of operations the first one may fit.
            step = plain.get(pc).unwrap_or(step);
            after = left - i64::from(step.cost);
            if after < 0 {
                break Stop::Budget { next: Span::from_nanos(i64::from(step.cost)) };
            }
        }
        left = after;
        pc += 1;

        macro_rules! fault {
            ($kind:ident) => {{
                *position = programs.len();
                let file = units.get(usize::from(unit)).map_or(0, |unit| unit.file);
                break 'slice Stop::Fault(Fault { kind: FaultKind::$kind, file, line: step.line });
            }};
        }
        // Operands: `acc` is the top, `sp` counts those below. A byte cannot leave the array, and the compiler
        // has made sure that it does not wrap.
        macro_rules! push {
            ($value:expr) => {{
                let value = $value;
                operands[usize::from(sp)] = acc;
                sp = sp.wrapping_add(1);
                acc = value;
            }};
        }
        macro_rules! pop {
            () => {{
                let top = acc;
                sp = sp.wrapping_sub(1);
                acc = operands[usize::from(sp)];
                top
            }};
        }
        macro_rules! binary {
            (|$a:ident, $b:ident| $result:expr) => {{
                let $b = pop!();
                let $a = acc;
                acc = $result;
            }};
        }
        macro_rules! load {
            ($from:expr, $at:expr) => {
                match $from.get($at as usize) {
                    Some(cell) => *cell,
                    None => fault!(Internal),
                }
            };
        }
        macro_rules! store {
            ($at:expr, $value:expr) => {{
                let (at, value) = ($at as usize, $value);
                let (Some(cell), Some(flag)) = (cells.get_mut(at), flags.get(at)) else { fault!(Internal) };
                if *flag != 0 && *cell != value {
                    *cell = value;
                    *changed |= flag;
                    if flag & WATCHED != 0 {
                        break 'slice Stop::Touched;
                    }
                }
                *cell = value;
            }};
        }
        macro_rules! store_local {
            ($at:expr, $value:expr) => {{
                let value = $value;
                match frames.get_mut(base + $at as usize) {
                    Some(cell) => *cell = value,
                    None => fault!(Internal),
                }
            }};
        }
        macro_rules! call {
            ($unit:expr, $this:expr) => {{
                let frame = units.get(usize::from(unit)).map_or(0, |unit| unit.frame as usize);
                let Some(callee) = units.get(usize::from($unit)) else { fault!(Internal) };
                let caller = Registers { pc: pc as u32, this, base: base as u32, unit, sp: 0, acc: 0 };
                if callers.len() == callers.capacity() {
                    fault!(Internal);
                }
                callers.push(caller);
                this = $this;
                base += frame;
                unit = $unit;
                pc = callee.entry as usize;
                callee
            }};
        }
        macro_rules! compare {
            (|$a:ident, $b:ident| $holds:expr, $to:expr) => {{
                let $b = pop!();
                let $a = pop!();
                pc = if $holds { pc + 1 } else { $to as usize };
            }};
        }
        // `skipped` operations stand between this one and the next: the rest of the run.
        macro_rules! compare_cell {
            ($skipped:expr, |$a:ident, $b:ident| $holds:expr, $at:expr, $k:expr, $to:expr) => {{
                let ($a, $b) = (load!(cells, $at), i64::from($k));
                pc = if $holds { pc + $skipped } else { $to as usize };
            }};
        }
        macro_rules! native {
            ($native:expr, $first:expr) => {{
                let first = $first as usize;
                let Some(native) = program.natives.get(usize::from($native)) else { fault!(Internal) };
                let range = first..first + native.pins.len();
                let (Some(pins), Some(marks)) = (cells.get_mut(range.clone()), flags.get(range)) else {
                    fault!(Internal)
                };
                let at = now.saturating_add(Span::from_nanos(budget - left));
                let mut pins = Pins { cells: pins, flags: marks, now: at, changed: 0 };
                (native.run)(&mut pins);
                *changed |= pins.changed;
                if pins.changed & WATCHED != 0 {
                    break 'slice Stop::Touched;
                }
            }};
        }

        match step.op {
            Op::Const(n) => push!(i64::from(n)),
            Op::Wide(at) => push!(load!(program.wide, at)),
            Op::Load(at) => push!(load!(cells, at)),
            Op::LoadThis(at) => push!(load!(cells, this + at)),
            Op::LoadLocal(at) => push!(load!(frames, base + at as usize)),
            Op::LoadAt(at) => acc = load!(cells, acc + i64::from(at)),
            Op::LoadThisAt(at) => acc = load!(cells, acc + i64::from(this + at)),
            Op::LoadLocalAt(at) => acc = load!(frames, acc as usize + base + at as usize),
            Op::LoadIo(at) => {
                let Some(located) = program.located.get(at as usize) else { fault!(Internal) };
                push!(located.ty.wrap(host.load(located.address) as i64));
            }
            Op::Store(at) => {
                let value = pop!();
                store!(at, value);
            }
            Op::StoreThis(at) => {
                let value = pop!();
                store!(this + at, value);
            }
            Op::StoreLocal(at) => {
                let value = pop!();
                store_local!(at, value);
            }
            Op::StoreAt(at) => {
                let value = pop!();
                let offset = pop!();
                store!(offset + i64::from(at), value);
            }
            Op::StoreThisAt(at) => {
                let value = pop!();
                let offset = pop!();
                store!(offset + i64::from(this + at), value);
            }
            Op::StoreLocalAt(at) => {
                let value = pop!();
                let offset = pop!();
                store_local!(offset as usize + at as usize, value);
            }
            Op::StoreIo(at) => {
                let value = pop!();
                let Some(located) = program.located.get(at as usize) else { fault!(Internal) };
                let file = units.get(usize::from(unit)).map_or(0, |unit| unit.file);
                if host.store(located.address, value as u64, file, step.line) {
                    break Stop::Touched;
                }
            }
            Op::Index(at) => match program.bounds.get(at as usize) {
                Some(&Bounds { low, high, stride }) if low <= acc && acc <= high => {
                    acc = (acc - low) * i64::from(stride);
                }
                Some(_) => fault!(Bounds),
                None => fault!(Internal),
            },
            Op::Add(ty) => binary!(|a, b| ty.wrap(a.wrapping_add(b))),
            Op::Sub(ty) => binary!(|a, b| ty.wrap(a.wrapping_sub(b))),
            Op::Mul(ty) => binary!(|a, b| ty.wrap(a.wrapping_mul(b))),
            Op::Div(_) | Op::Mod(_) if acc == 0 => fault!(DivisionByZero),
            Op::Div(ty) if ty.wide_unsigned() => binary!(|a, b| (a as u64 / b as u64) as i64),
            Op::Div(ty) => binary!(|a, b| ty.wrap(a.wrapping_div(b))),
            Op::Mod(ty) if ty.wide_unsigned() => binary!(|a, b| (a as u64 % b as u64) as i64),
            Op::Mod(_) => binary!(|a, b| a.wrapping_rem(b)),
            Op::AddConst(ty, n) => acc = ty.wrap(acc.wrapping_add(i64::from(n))),
            Op::EqConst(n) => acc = i64::from(acc == i64::from(n)),
            Op::LtConst(n) => acc = i64::from(acc < i64::from(n)),
            Op::GtConst(n) => acc = i64::from(acc > i64::from(n)),
            Op::And => binary!(|a, b| a & b),
            Op::Or => binary!(|a, b| a | b),
            Op::Xor => binary!(|a, b| a ^ b),
            Op::Not(ty) => acc = ty.wrap(!acc),
            Op::Neg(ty) => acc = ty.wrap(acc.wrapping_neg()),
            Op::Eq => binary!(|a, b| i64::from(a == b)),
            Op::Ne => binary!(|a, b| i64::from(a != b)),
            Op::Lt => binary!(|a, b| i64::from(a < b)),
            Op::Le => binary!(|a, b| i64::from(a <= b)),
            Op::Gt => binary!(|a, b| i64::from(a > b)),
            Op::Ge => binary!(|a, b| i64::from(a >= b)),
            Op::LtWide => binary!(|a, b| i64::from((a as u64) < b as u64)),
            Op::LeWide => binary!(|a, b| i64::from(a as u64 <= b as u64)),
            Op::GtWide => binary!(|a, b| i64::from(a as u64 > b as u64)),
            Op::GeWide => binary!(|a, b| i64::from(a as u64 >= b as u64)),
            Op::Wrap(ty) => acc = ty.wrap(acc),
            Op::Truth => acc = i64::from(acc != 0),
            Op::Abs(ty) => acc = ty.wrap(acc.wrapping_abs()),
            Op::Min => binary!(|a, b| a.min(b)),
            Op::Max => binary!(|a, b| a.max(b)),
            Op::MinWide => binary!(|a, b| (a as u64).min(b as u64) as i64),
            Op::MaxWide => binary!(|a, b| (a as u64).max(b as u64) as i64),
            Op::Sel => {
                let if_true = pop!();
                let if_false = pop!();
                acc = if acc != 0 { if_true } else { if_false };
            }
            Op::Shl(ty) => binary!(|a, n| shift(n, ty).map_or(0, |n| ty.wrap(a << n))),
            Op::Shr(ty) => binary!(|a, n| shift(n, ty).map_or(0, |n| ty.wrap((bits(a, ty) >> n) as i64))),
            Op::Rol(ty) => binary!(|a, n| rotate(a, n, ty)),
            Op::Ror(ty) => binary!(|a, n| rotate(a, n.wrapping_neg(), ty)),
            Op::Jump(to) => pc = to as usize,
            Op::JumpIfNot(to) => {
                if pop!() == 0 {
                    pc = to as usize;
                }
            }
            Op::JumpIf(to) => {
                if pop!() != 0 {
                    pc = to as usize;
                }
            }
            Op::Within(ty) => {
                let (step, end) = (pop!(), pop!());
                let (value, end) = (ty.number(acc), ty.number(end));
                acc = i64::from(if step < 0 { value >= end } else { value <= end });
            }
            Op::NextOrJump(ty, to) => {
                let step = pop!();
                match next(acc, step, ty) {
                    Some(next) => acc = next,
                    None => {
                        pop!();
                        pc = to as usize;
                    }
                }
            }
            Op::CallFunction(callee) => {
                let callee = call!(callee, this);
                let inputs = callee.inputs as usize;
                let Some(frame) = frames.get_mut(base..base + callee.template.len()) else {
                    fault!(Internal)
                };
                frame.copy_from_slice(&callee.template);
                for place in (1..=inputs).rev() {
                    let value = pop!();
                    store_local!(place, value);
                }
            }
            Op::CallBlock(callee, first) => {
                call!(callee, first);
            }
            Op::CallBlockThis(callee, first) => {
                call!(callee, this + first);
            }
            Op::CallBlockAt(callee, first) => {
                let offset = pop!();
                call!(callee, first + offset as u32);
            }
            Op::CallBlockThisAt(callee, first) => {
                let offset = pop!();
                call!(callee, this + first + offset as u32);
            }
            Op::CallNative(native, first) => native!(native, first),
            Op::CallNativeThis(native, first) => native!(native, this + first),
            Op::CallNativeAt(native, first) => {
                let offset = pop!();
                native!(native, first + offset as u32);
            }
            Op::CallNativeThisAt(native, first) => {
                let offset = pop!();
                native!(native, this + first + offset as u32);
            }
            Op::Return => {
                let result = if units.get(usize::from(unit)).is_some_and(|unit| unit.has_result) {
                    Some(load!(frames, base))
                } else {
                    None
                };
                match callers.pop() {
                    Some(caller) => {
                        pc = caller.pc as usize;
                        this = caller.this;
                        base = caller.base as usize;
                        unit = caller.unit;
                        if let Some(result) = result {
                            push!(result);
                        }
                    }
                    None => {
                        *position += 1;
                        let Some(next) = programs.get(*position) else { break Stop::Done };
                        unit = *next;
                        pc = units.get(usize::from(unit)).map_or(0, |unit| unit.entry) as usize;
                        (this, base, sp, acc) = (0, 0, 0, 0);
                    }
                }
            }
            // Runs: `pc` stands behind the first operation.
            Op::IfEq(at, k, to) => compare_cell!(2, |a, b| a == b, at, k, to),
            Op::IfLt(at, k, to) => compare_cell!(2, |a, b| a < b, at, k, to),
            Op::IfGt(at, k, to) => compare_cell!(2, |a, b| a > b, at, k, to),
            Op::IfLe(at, k, to) => compare_cell!(3, |a, b| a <= b, at, k, to),
            Op::IfGe(at, k, to) => compare_cell!(3, |a, b| a >= b, at, k, to),
            Op::IfTrue(at, to) => compare_cell!(1, |a, b| a != b, at, 0, to),
            Op::LocalEqJump(at, k, to) => {
                let local = load!(frames, base + at as usize);
                pc = if local == i64::from(k) { to as usize } else { pc + 2 };
            }
            Op::NextCell(ty, at, by, to) => match next(load!(cells, at), i64::from(by), ty) {
                Some(next) => {
                    pc += 2;
                    push!(next);
                }
                None => pc = to as usize,
            },
            Op::GtCell(at, k) => {
                pc += 1;
                push!(i64::from(load!(cells, at) > i64::from(k)));
            }
            Op::LtCell(at, k) => {
                pc += 1;
                push!(i64::from(load!(cells, at) < i64::from(k)));
            }
            Op::DivCell(ty, at, k) => {
                pc += 2;
                push!(ty.wrap(load!(cells, at).wrapping_div(i64::from(k))));
            }
            Op::AndNot(ty) => {
                pc += 1;
                binary!(|a, b| a & ty.wrap(!b));
            }
            Op::AndTo(to) => {
                pc += 1;
                let (b, a) = (pop!(), pop!());
                store!(to, a & b);
            }
            Op::OrTo(to) => {
                pc += 1;
                let (b, a) = (pop!(), pop!());
                store!(to, a | b);
            }
            Op::Move(from, to) => {
                pc += 1;
                store!(to, load!(cells, from));
            }
            Op::Set(n, to) => {
                pc += 1;
                store!(to, i64::from(n));
            }
            Op::AddConstTo(ty, at, n, to) => {
                pc += 2;
                store!(to, ty.wrap(load!(cells, at).wrapping_add(i64::from(n))));
            }
            Op::AddTo(ty, to) => {
                pc += 1;
                let (b, a) = (pop!(), pop!());
                store!(to, ty.wrap(a.wrapping_add(b)));
            }
            Op::AndCell(at) => {
                pc += 1;
                acc &= load!(cells, at);
            }
            Op::OrCell(at) => {
                pc += 1;
                acc |= load!(cells, at);
            }
            Op::AddCell(ty, at) => {
                pc += 1;
                acc = ty.wrap(acc.wrapping_add(load!(cells, at)));
            }
            Op::LoadConst(at, n) => {
                pc += 1;
                push!(load!(cells, at));
                push!(i64::from(n));
            }
            Op::LoadTwo(first, second) => {
                pc += 1;
                push!(load!(cells, first));
                push!(load!(cells, second));
            }
            Op::StoreJump(at, to) => {
                if flags.get(at as usize) == Some(&0) {
                    let value = pop!();
                    store!(at, value);
                    pc = to as usize;
                } else {
                    // Somebody may want to look between the two: the jump stays behind.
                    left += plain.get(pc).map_or(0, |jump| i64::from(jump.cost));
                    let value = pop!();
                    store!(at, value);
                }
            }
            Op::IndexLoad(at, first) => match program.bounds.get(at as usize) {
                Some(&Bounds { low, high, stride }) if low <= acc && acc <= high => {
                    pc += 1;
                    acc = load!(cells, (acc - low) * i64::from(stride) + i64::from(first));
                }
                Some(_) => {
                    left += plain.get(pc).map_or(0, |load| i64::from(load.cost));
                    fault!(Bounds);
                }
                None => fault!(Internal),
            },
            Op::EqJump(to) => compare!(|a, b| a == b, to),
            Op::LtJump(to) => compare!(|a, b| a < b, to),
            Op::LeJump(to) => compare!(|a, b| a <= b, to),
            Op::GtJump(to) => compare!(|a, b| a > b, to),
            Op::GeJump(to) => compare!(|a, b| a >= b, to),
        }
    };
    *registers = Registers { pc: pc as u32, this, base: base as u32, unit, sp, acc };
    Slice { used: Span::from_nanos(budget - left), stop }
}

const _: () = assert!(OPERANDS == 256, "the operand stack is indexed by a byte");

/// The unsigned bits of a cell.
fn bits(cell: i64, ty: Elementary) -> u64 {
    if ty.bits() == 64 { cell as u64 } else { cell as u64 & ((1 << ty.bits()) - 1) }
}

/// The next value of a FOR; `None` where the type cannot hold it.
#[inline]
fn next(value: i64, step: i64, ty: Elementary) -> Option<i64> {
    // In the cells of all other types numbers are what they are.
    if ty.wide_unsigned() {
        (value as u64).checked_add_signed(step).map(|next| next as i64)
    } else {
        value.checked_add(step).filter(|next| ty.wrap(*next) == *next)
    }
}

/// A shift count; `None` where every bit is shifted out.
fn shift(n: i64, ty: Elementary) -> Option<u32> {
    u32::try_from(n).ok().filter(|n| *n < ty.bits())
}

fn rotate(cell: i64, n: i64, ty: Elementary) -> i64 {
    let n = n.rem_euclid(i64::from(ty.bits())) as u32;
    let bits = bits(cell, ty);
    let right = if n == 0 { 0 } else { bits >> (ty.bits() - n) };
    ty.wrap((bits << n | right) as i64)
}
