//! The loop itself.

use super::super::number::{Canonical, RawNumber, max_f32, max_f64, min_f32, min_f64, shift, spread, turn};
use super::super::operations::operations;
use super::call::Calls;
use super::lookup::{follow, place, read};
use super::steps::steps;
use super::{BASED, DIRECT, INDIRECT, PLAIN, Quick, QuickContext, QuickPlace};
use crate::code::Op;

impl Quick {
    /// Goes on from a step as far as it can.
    #[inline(never)]
    pub(in super::super) fn go(&self, around: QuickContext<'_>, entry: u32, from: QuickPlace) -> QuickPlace {
        let mut left = from.left;
        let (steps, lookups) = (self.steps.as_slice(), self.lookups.as_slice());
        let Some((mut calls, memory, flags)) = Calls::new(around, from.bases, from.unit) else { return from };
        let Some(rest) = steps.get(entry as usize..) else { return from };
        let mut rest = rest.iter();
        'run: while let Some(mut step) = rest.next() {
            left -= i64::from(step.cost);
            if left < 0 {
                break;
            }
            loop {
                macro_rules! op {
                    ($name:ident) => {
                        Op::$name
                    };
                }
                macro_rules! fault {
                    ($kind:ident) => {
                        break 'run
                    };
                }
                macro_rules! load {
                    (f32, $at:expr) => {
                        f32::from_bits(load!(u32, $at))
                    };
                    (f64, $at:expr) => {
                        f64::from_bits(load!(u64, $at))
                    };
                    ($ty:ident, $at:expr) => {
                        match read(memory, $at) {
                            Some(bytes) => $ty::from_le_bytes(bytes),
                            None => break 'run,
                        }
                    };
                }
                macro_rules! put {
                    ($at:expr, $value:expr) => {{
                        let bytes = $value.to_le_bytes();
                        let first: usize = $at;
                        // As an array: a copy of a slice is a call.
                        let to = memory.get_mut(first..).and_then(|rest| rest.first_chunk_mut());
                        match (to, flags.get(first)) {
                            (Some(to), Some(0)) => *to = bytes,
                            _ => break 'run,
                        }
                    }};
                }
                // Where operands are is up to the macros `a`, `b`, `c`, `d` and `of`.
                macro_rules! one {
                    ($ty:ident, |$b:ident| $result:expr) => {{
                        let $b = load!($ty, b!());
                        put!(a!(), RawNumber::raw($result));
                    }};
                }
                macro_rules! two {
                    ($ty:ident, |$b:ident, $c:ident| $result:expr) => {{
                        let $b = load!($ty, b!());
                        let $c = load!($ty, c!());
                        put!(a!(), RawNumber::raw($result));
                    }};
                }
                macro_rules! divide {
                    ($ty:ident, $divide:ident) => {{
                        let b = load!($ty, b!());
                        let c = load!($ty, c!());
                        if c == 0 {
                            fault!(DivisionByZero);
                        }
                        put!(a!(), b.$divide(c));
                    }};
                }
                macro_rules! divide_real {
                    ($ty:ident) => {{
                        let b = load!($ty, b!());
                        let c = load!($ty, c!());
                        if c == 0.0 {
                            fault!(RealDivisionByZero);
                        }
                        put!(a!(), RawNumber::raw((b / c).canonical()));
                    }};
                }
                macro_rules! count {
                    ($ty:ident, |$b:ident, $n:ident| $result:expr) => {{
                        let $b = load!($ty, b!());
                        let $n = load!(i64, c!());
                        put!(a!(), $result);
                    }};
                }
                macro_rules! compare {
                    ($ty:ident, |$b:ident, $c:ident| $holds:expr) => {{
                        let $b = load!($ty, b!());
                        let $c = load!($ty, c!());
                        put!(a!(), u8::from($holds));
                    }};
                }
                // Goes on with a run of operations.
                macro_rules! next {
                    () => {
                        continue 'run
                    };
                }
                macro_rules! enter {
                    ($position:expr) => {{
                        match steps.get($position as usize..) {
                            Some(steps) => rest = steps.iter(),
                            None => fault!(Internal),
                        }
                        next!();
                    }};
                }
                macro_rules! branch {
                    ($holds:expr) => {{
                        if $holds {
                            enter!(step.a);
                        }
                        next!();
                    }};
                }
                macro_rules! jump {
                    ($ty:ident, |$b:ident, $c:ident| $holds:expr) => {{
                        let $b = load!($ty, b!());
                        let $c = load!($ty, c!());
                        branch!($holds)
                    }};
                }
                macro_rules! test {
                    (|$b:ident| $holds:expr) => {{
                        let $b = load!(u8, b!());
                        branch!($holds)
                    }};
                }
                macro_rules! index {
                    ($ty:ident, |$n:ident| $nth:expr) => {{
                        let $n = load!($ty, b!());
                        let nth: i64 = $nth;
                        let Some(index) = self.indexes.get(step.c as usize) else { fault!(Internal) };
                        if nth < index.low || nth > index.high {
                            fault!(Bounds);
                        }
                        let mut first = place(&calls.bases, index.from, index.of);
                        if index.indirect {
                            match follow(memory, first) {
                                Some(at) => first = at,
                                None => fault!(BadReference),
                            }
                        }
                        let offset = nth.wrapping_sub(index.low).wrapping_mul(i64::from(index.stride));
                        put!(a!(), (first as u32).wrapping_add(offset as u32));
                    }};
                }
                macro_rules! turn {
                    ($ty:ident) => {
                        turn!($ty, load!($ty, c!()))
                    };
                    ($ty:ident, $end:expr) => {{
                        let at = b!();
                        let n = load!($ty, at);
                        let next = n.wrapping_add(1);
                        put!(at, next);
                        branch!(next <= $end)
                    }};
                }
                // The constant that the step holds.
                macro_rules! grow {
                    ($ty:ident) => {{
                        let at = a!();
                        put!(at, load!($ty, at).wrapping_add(step.c as $ty));
                    }};
                }
                macro_rules! sum {
                    ($ty:ident) => {
                        put!(a!(), load!($ty, b!()).wrapping_add(step.c as $ty))
                    };
                }
                macro_rules! beside {
                    ($ty:ident, |$b:ident, $constant:ident| $holds:expr) => {{
                        let ($b, $constant) = (load!($ty, b!()), step.c as $ty);
                        branch!($holds)
                    }};
                }
                // The element, found by adding a number to the index.
                macro_rules! element {
                    ($add:expr, $stride:expr) => {{
                        let at = c!();
                        let nth = if step.narrow {
                            u32::from(load!(u16, at).wrapping_add($add as u16))
                        } else {
                            load!(u32, at).wrapping_add($add)
                        };
                        if nth > step.last {
                            fault!(Bounds);
                        }
                        (of!() as u32).wrapping_add(nth.wrapping_mul($stride)) as usize
                    }};
                    ($ty:ident) => {
                        element!(step.d, size_of::<$ty>() as u32)
                    };
                }
                macro_rules! fetch {
                    ($ty:ident) => {
                        put!(a!(), load!($ty, element!($ty)))
                    };
                }
                macro_rules! keep {
                    ($ty:ident) => {{
                        let at = element!($ty);
                        put!(at, load!($ty, b!()));
                    }};
                }
                macro_rules! shift_element {
                    ($ty:ident) => {{
                        let at = element!($ty);
                        let from = element!(step.b, size_of::<$ty>() as u32);
                        put!(at, load!($ty, from));
                    }};
                }
                macro_rules! to_offset {
                    ($ty:ident) => {{
                        let Some(at) = follow(memory, a!()) else { fault!(BadReference) };
                        put!((at as u32).wrapping_add(step.d) as usize, load!($ty, b!()));
                    }};
                }
                macro_rules! by_element {
                    (|$b:ident, $element:ident| $holds:expr) => {{
                        let $b = load!(i32, b!());
                        let $element = load!(i32, element!(i32));
                        branch!($holds)
                    }};
                }
                macro_rules! move_and_set {
                    ($ty:ident, $constant:ident) => {{
                        let (at, value, to) = (a!(), load!($ty, b!()), c!());
                        // Both or nothing.
                        if to + size_of::<$constant>() > memory.len() || flags.get(to) != Some(&0) {
                            fault!(BadReference);
                        }
                        put!(at, value);
                        put!(to, step.d as $constant);
                    }};
                }
                macro_rules! grow_and {
                    (|$n:ident, $constant:ident| $holds:expr) => {{
                        let at = b!();
                        let $n = load!(i32, at).wrapping_add(step.c as i32);
                        let $constant = step.d as i32;
                        put!(at, $n);
                        branch!($holds)
                    }};
                }
                macro_rules! mul_and {
                    (|$n:ident, $d:ident| $holds:expr) => {{
                        let $n = load!(i32, b!()).wrapping_mul(load!(i32, c!()));
                        let $d = load!(i32, d!());
                        branch!($holds)
                    }};
                }
                macro_rules! mod_and {
                    (|$n:ident, $constant:ident| $holds:expr) => {{
                        let by = load!(i32, c!());
                        if by == 0 {
                            fault!(DivisionByZero);
                        }
                        let $n = load!(i32, b!()).wrapping_rem(by);
                        let $constant = step.d as i32;
                        branch!($holds)
                    }};
                }
                macro_rules! call {
                    ($this:expr) => {{
                        let this = $this;
                        match self.call(&mut calls, step.a, this, step.c) {
                            Some(entry) => enter!(entry),
                            None => fault!(StackDepth),
                        }
                    }};
                }
                // With the instance at a place.
                macro_rules! call_this {
                    ($this:expr) => {
                        match $this {
                            this if this < memory.len() => call!(this as u32),
                            _ => fault!(BadReference),
                        }
                    };
                }
                macro_rules! native {
                    ($native:ident) => {{
                        if !self.$native(&calls, (memory, flags), (step.a, b!()), left) {
                            fault!(BadReference);
                        }
                        next!();
                    }};
                }

                macro_rules! execute {
                    ($($calls:tt)*) => {
                        steps!(step, {
                            $($calls)*
                            // All of them are named, so that there is nothing to test before the jump to an arm.
                            Op::Copy
                            | Op::Convert
                            | Op::LoadBit
                            | Op::StoreBit
                            | Op::FrameVirtual
                            | Op::CallVirtual
                            | Op::CallLibrary
                            | Op::MoveText
                            | Op::CompareText
                            | Op::IsKind
                            | Op::Leave => break 'run,
                        })
                    };
                }
                if step.modes == PLAIN {
                    macro_rules! a {
                        () => {
                            step.a as usize
                        };
                    }
                    macro_rules! b {
                        () => {
                            step.b as usize
                        };
                    }
                    macro_rules! c {
                        () => {
                            step.c as usize
                        };
                    }
                    macro_rules! d {
                        () => {
                            step.d as usize
                        };
                    }
                    macro_rules! of {
                        () => {
                            step.of
                        };
                    }
                    execute! {
                        // They are all based.
                        Op::Frame
                        | Op::Call
                        | Op::CallSame
                        | Op::CallThis
                        | Op::CallThrough
                        | Op::CallNative
                        | Op::Return => break 'run,
                    }
                } else {
                    macro_rules! d {
                        () => {
                            place(&calls.bases, step.from[3], step.d)
                        };
                    }
                    macro_rules! of {
                        () => {
                            place(&calls.bases, step.from[3], step.of)
                        };
                    }
                    if step.modes == BASED {
                        macro_rules! a {
                            () => {
                                place(&calls.bases, step.from[0], step.a)
                            };
                        }
                        macro_rules! b {
                            () => {
                                place(&calls.bases, step.from[1], step.b)
                            };
                        }
                        macro_rules! c {
                            () => {
                                place(&calls.bases, step.from[2], step.c)
                            };
                        }
                        execute! {
                            Op::Frame => {
                                if !self.frame(&calls, memory, step.a) {
                                    fault!(StackDepth);
                                }
                            }
                            Op::Call => call!(0),
                            Op::CallSame => call!(calls.bases[1]),
                            Op::CallThis => call_this!(b!()),
                            Op::CallThrough => match follow(memory, b!()) {
                                Some(this) => call_this!(this),
                                None => fault!(BadReference),
                            },
                            Op::CallNative => native!(native),
                            Op::Return => match self.back(&mut calls) {
                                Some(to) => enter!(to),
                                None => fault!(Internal),
                            },
                        }
                    } else {
                        macro_rules! resolve {
                            ($nth:literal, $field:ident) => {{
                                let at = place(&calls.bases, step.from[$nth], step.$field);
                                match step.modes >> (2 * $nth) & 3 {
                                    DIRECT => at,
                                    INDIRECT => match follow(memory, at) {
                                        Some(at) => at,
                                        None => break 'run,
                                    },
                                    _ => match lookups
                                        .get(at)
                                        .and_then(|lookup| lookup.find(memory, &calls.bases))
                                    {
                                        Some(at) => at,
                                        None => break 'run,
                                    },
                                }
                            }};
                        }
                        let (a, b, c) = (resolve!(0, a), resolve!(1, b), resolve!(2, c));
                        macro_rules! a {
                            () => {
                                a
                            };
                        }
                        macro_rules! b {
                            () => {
                                b
                            };
                        }
                        macro_rules! c {
                            () => {
                                c
                            };
                        }
                        execute! {
                            Op::CallThis => call_this!(b!()),
                            Op::CallNative => native!(native_aside),
                            Op::Frame | Op::Call | Op::CallSame | Op::CallThrough | Op::Return => break 'run,
                        }
                    }
                }
                step = match rest.next() {
                    Some(step) => step,
                    None => break 'run,
                };
            }
        }
        // The one that does not happen is not in the rest any more.
        let position = steps.len().saturating_sub(rest.len() + 1);
        self.before(position, QuickPlace { pc: 0, left, bases: calls.bases, unit: calls.unit })
    }
}
