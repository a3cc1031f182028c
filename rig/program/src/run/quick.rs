//! The loop for the plain case: operations in the machine's own memory that nobody watches. What is anything else -
//! a fault, the host's areas, a watched byte, a call, a budget that is too short - is left to the loop of
//! [`super::run`], with everything as it is before that operation. So this loop decides how fast operations are, and
//! never what they do.
//!
//! Time is taken at once for a run of operations up to the next jump. What was not executed is given back at the end.

use super::fast::{FastIndex, From};
use super::number::{Canonical, Raw, max_f32, max_f64, min_f32, min_f64, shift, spread, turn};
use super::operations::operations;
use crate::code::{Op, map};

/// An operation, with the lookups of elements that stood before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub op: Op,
    /// The bases of `a`, `b`, `c`.
    pub from: [From; 3],
    /// Two bits for each of `a`, `b`, `c`: [`DIRECT`], [`INDIRECT`] or [`LOOKUP`].
    pub modes: u8,
    /// Places; for jumps, `a` is a place in the steps.
    pub a: u32,
    pub b: u32,
    pub c: u32,
    /// Of all operations from this one to the next jump, with it.
    pub cost: u32,
}

/// What a step stands for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Origin {
    /// Its first operation.
    pub pc: u32,
    /// Operations before its last one: lookups and the sums that they look up.
    pub folded: u8,
    /// Lookups, from `first` on in the order of the code.
    pub lookups: u8,
    pub first: u32,
}

/// The operand stands where its offset leads.
pub(super) const DIRECT: u8 = 0;
/// Its address stands there.
pub(super) const INDIRECT: u8 = 1;
/// It is an element: the field is a place in the lookups.
pub(super) const LOOKUP: u8 = 2;

/// Types of indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum IndexType {
    /// `add` is the place of the element.
    Constant,
    /// 16 bits.
    Narrow,
    /// 32 bits.
    Wide,
}

/// An operation that finds an element. Bounds are those of the index's type, so that numbers that wrap around at its
/// width do: signed or not makes no difference.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lookup {
    /// The index.
    pub index: u32,
    /// What makes the element's place of the index: a constant that the program adds, less the lower bound.
    pub add: u32,
    /// The place of the last element.
    pub last: u32,
    /// The array.
    pub of: u32,
    pub stride: u32,
    pub index_from: From,
    pub from: From,
    pub ty: IndexType,
    pub indirect: bool,
}

/// What a lookup leaves in the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Left {
    /// Where the element's address goes.
    pub slot: u32,
    /// Where the sum goes that is the index, if there is one.
    pub sum: Option<u32>,
    pub low: u32,
}

/// No step begins at the operation.
pub(super) const NONE: u32 = u32::MAX;

/// The code as this loop takes it.
#[derive(Clone, Debug, Default)]
pub(super) struct Quick {
    pub steps: Vec<Step>,
    /// Beside the steps.
    pub origins: Vec<Origin>,
    /// By operation: the step that begins there, if it is worth going on there with this loop.
    pub entries: Vec<u32>,
    /// By operation: its own cost.
    pub costs: Vec<u32>,
    pub lookups: Vec<Lookup>,
    /// Beside the lookups.
    pub left: Vec<Left>,
    pub indexes: Vec<FastIndex>,
}

#[inline(always)]
fn read<const N: usize>(memory: &[u8], at: usize) -> Option<[u8; N]> {
    memory.get(at..at + N)?.first_chunk().copied()
}

/// Where an offset leads.
#[inline(always)]
fn place(bases: [u32; 3], from: From, offset: u32) -> usize {
    bases[from as usize].wrapping_add(offset) as usize
}

/// The address that stands at a place.
#[inline(always)]
fn follow(memory: &[u8], at: usize) -> Option<usize> {
    let at = u32::from_le_bytes(read(memory, at)?);
    if at < map::FIRST { None } else { Some(at as usize) }
}

impl Lookup {
    /// The place of the element in the array.
    #[inline(always)]
    fn nth(&self, memory: &[u8], bases: [u32; 3]) -> Option<u32> {
        let at = place(bases, self.index_from, self.index);
        let nth = match self.ty {
            IndexType::Wide => u32::from_le_bytes(read(memory, at)?).wrapping_add(self.add),
            IndexType::Narrow => {
                u32::from(u16::from_le_bytes(read(memory, at)?).wrapping_add(self.add as u16))
            }
            IndexType::Constant => self.add,
        };
        // An index below the lower bound wraps to beyond the last element.
        if nth > self.last { None } else { Some(nth) }
    }

    /// The address of the element.
    #[inline(always)]
    fn find(&self, memory: &[u8], bases: [u32; 3]) -> Option<usize> {
        let nth = self.nth(memory, bases)?;
        let mut first = place(bases, self.from, self.of);
        if self.indirect {
            first = follow(memory, first)?;
        }
        Some((first as u32).wrapping_add(nth.wrapping_mul(self.stride)) as usize)
    }

    /// Leaves in the frame what the operations of the lookup do.
    fn keep(&self, memory: &mut [u8], bases: [u32; 3], left: &Left) {
        let (Some(nth), Some(at)) = (self.nth(memory, bases), self.find(memory, bases)) else { return };
        let mut write = |offset: u32, bytes: &[u8]| {
            let first = place(bases, From::Frame, offset);
            if let Some(to) = memory.get_mut(first..first + bytes.len()) {
                to.copy_from_slice(bytes);
            }
        };
        if let Some(sum) = left.sum {
            let index = nth.wrapping_add(left.low).to_le_bytes();
            write(sum, if self.ty == IndexType::Narrow { &index[..2] } else { &index });
        }
        write(left.slot, &(at as u32).to_le_bytes());
    }
}

impl Quick {
    /// Goes on from operation `pc` as far as it can: the operation that comes next and the time that is left then.
    #[inline(always)]
    pub fn run(
        &self,
        memory: &mut [u8],
        flags: &[u8],
        bases: [u32; 3],
        pc: usize,
        left: i64,
    ) -> (usize, i64) {
        match self.entries.get(pc) {
            Some(entry) if *entry != NONE => self.go(memory, flags, bases, *entry as usize, left),
            _ => (pc, left),
        }
    }

    #[inline(never)]
    fn go(
        &self,
        memory: &mut [u8],
        flags: &[u8],
        bases: [u32; 3],
        entry: usize,
        mut left: i64,
    ) -> (usize, i64) {
        // A copy lies on this stack, where an index finds it at once.
        let bases = std::convert::identity(bases);
        let (steps, lookups) = (self.steps.as_slice(), self.lookups.as_slice());
        // As long as the memory: one check of bounds does for both.
        let Some(flags) = flags.get(..memory.len()) else { return (NONE as usize, left) };
        let mut position = entry;
        'run: loop {
            let Some(first) = steps.get(position) else { return (NONE as usize, left) };
            left -= i64::from(first.cost);
            if left < 0 {
                return self.before(position, left);
            }
            loop {
                let Some(step) = steps.get(position) else { return (NONE as usize, left) };
                macro_rules! op {
                    ($name:ident) => {
                        Op::$name
                    };
                }
                let [from_a, from_b, from_c] = step.from;
                let mut a = place(bases, from_a, step.a);
                let mut b = place(bases, from_b, step.b);
                let mut c = place(bases, from_c, step.c);
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
                        match (memory.get_mut(first..first + bytes.len()), flags.get(first)) {
                            (Some(to), Some(0)) => to.copy_from_slice(&bytes),
                            _ => break 'run,
                        }
                    }};
                }
                macro_rules! one {
                    ($ty:ident, |$b:ident| $result:expr) => {{
                        let $b = load!($ty, b);
                        put!(a, Raw::raw($result));
                    }};
                }
                macro_rules! two {
                    ($ty:ident, |$b:ident, $c:ident| $result:expr) => {{
                        let $b = load!($ty, b);
                        let $c = load!($ty, c);
                        put!(a, Raw::raw($result));
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
                // Goes on with a run of operations.
                macro_rules! enter {
                    ($position:expr) => {{
                        position = $position;
                        continue 'run;
                    }};
                }
                // A jump; if it leads nowhere, nothing of it has happened.
                macro_rules! leap {
                    () => {{
                        if a >= steps.len() {
                            break 'run;
                        }
                        enter!(a);
                    }};
                }
                macro_rules! branch {
                    ($holds:expr) => {{
                        if $holds {
                            leap!();
                        }
                        enter!(position + 1);
                    }};
                }
                macro_rules! jump {
                    ($ty:ident, |$b:ident, $c:ident| $holds:expr) => {{
                        let $b = load!($ty, b);
                        let $c = load!($ty, c);
                        branch!($holds)
                    }};
                }
                macro_rules! test {
                    (|$b:ident| $holds:expr) => {{
                        let $b = load!(u8, b);
                        branch!($holds)
                    }};
                }
                macro_rules! index {
                    ($ty:ident, |$n:ident| $nth:expr) => {{
                        let $n = load!($ty, b);
                        let nth: i64 = $nth;
                        let Some(index) = self.indexes.get(c) else { fault!(Internal) };
                        if nth < index.low || nth > index.high {
                            fault!(Bounds);
                        }
                        let mut first = place(bases, index.from, index.of);
                        if index.indirect {
                            match follow(memory, first) {
                                Some(at) => first = at,
                                None => fault!(BadReference),
                            }
                        }
                        let offset = nth.wrapping_sub(index.low).wrapping_mul(i64::from(index.stride));
                        put!(a, (first as u32).wrapping_add(offset as u32));
                    }};
                }
                macro_rules! turn {
                    ($ty:ident) => {{
                        let n = load!($ty, b);
                        if n < load!($ty, c) {
                            put!(b, n.wrapping_add(1));
                            leap!();
                        }
                        if let Some(next) = n.checked_add(1) {
                            put!(b, next);
                        }
                        enter!(position + 1);
                    }};
                }
                macro_rules! by {
                    ($ty:ident, |$b:ident, $by:ident| $next:expr) => {{
                        let $b = load!($ty, b);
                        let $by = load!(i64, c);
                        match $next {
                            Some(next) => put!(b, next),
                            None => leap!(),
                        }
                        enter!(position + 1);
                    }};
                }

                macro_rules! resolve {
                    ($place:ident, $nth:literal) => {
                        match step.modes >> (2 * $nth) & 3 {
                            DIRECT => {}
                            INDIRECT => match follow(memory, $place) {
                                Some(at) => $place = at,
                                None => return self.before(position, left),
                            },
                            _ => {
                                let Some(lookup) = lookups.get($place) else {
                                    return self.before(position, left);
                                };
                                match lookup.find(memory, bases) {
                                    Some(at) => $place = at,
                                    None => return self.before(position, left),
                                }
                            }
                        }
                    };
                }
                if step.modes != 0 {
                    resolve!(a, 0);
                    resolve!(b, 1);
                    resolve!(c, 2);
                }
                macro_rules! grow {
                    ($ty:ident) => {{
                        let at = a;
                        put!(at, load!($ty, at).wrapping_add(c as $ty));
                    }};
                }
                macro_rules! sum {
                    ($ty:ident) => {
                        put!(a, load!($ty, b).wrapping_add(c as $ty))
                    };
                }
                macro_rules! beside {
                    ($ty:ident, |$b:ident, $constant:ident| $holds:expr) => {{
                        let ($b, $constant) = (load!($ty, b), c as $ty);
                        branch!($holds)
                    }};
                }
                macro_rules! turn_to {
                    ($ty:ident) => {{
                        let at = b;
                        let n = load!($ty, at);
                        if n < c as $ty {
                            put!(at, n.wrapping_add(1));
                            leap!();
                        }
                        if let Some(next) = n.checked_add(1) {
                            put!(at, next);
                        }
                        enter!(position + 1);
                    }};
                }

                operations!(step.op, {
                    Op::Set8 => put!(a, c as u8),
                    Op::Set16 => put!(a, c as u16),
                    Op::Set32 => put!(a, c as u32),
                    Op::Grow16 => grow!(u16),
                    Op::Grow32 => grow!(u32),
                    Op::Sum16 => sum!(u16),
                    Op::Sum32 => sum!(u32),
                    Op::Equal8 => beside!(u8, |b, constant| b == constant),
                    Op::Equal16 => beside!(u16, |b, constant| b == constant),
                    Op::Equal32 => beside!(u32, |b, constant| b == constant),
                    Op::Other8 => beside!(u8, |b, constant| b != constant),
                    Op::Other16 => beside!(u16, |b, constant| b != constant),
                    Op::Other32 => beside!(u32, |b, constant| b != constant),
                    Op::Less16 => beside!(i16, |b, constant| b < constant),
                    Op::Less32 => beside!(i32, |b, constant| b < constant),
                    Op::LessEqual16 => beside!(i16, |b, constant| b <= constant),
                    Op::LessEqual32 => beside!(i32, |b, constant| b <= constant),
                    Op::Greater16 => beside!(i16, |b, constant| b > constant),
                    Op::Greater32 => beside!(i32, |b, constant| b > constant),
                    Op::GreaterEqual16 => beside!(i16, |b, constant| b >= constant),
                    Op::GreaterEqual32 => beside!(i32, |b, constant| b >= constant),
                    Op::Turn16 => turn_to!(i16),
                    Op::Turn32 => turn_to!(i32),
                    Op::Jump => leap!(),
                    // All of them are named, so that there is nothing to test before the jump to an arm.
                    Op::Copy
                    | Op::Address
                    | Op::Convert
                    | Op::LoadBit
                    | Op::StoreBit
                    | Op::Frame
                    | Op::FrameVirtual
                    | Op::Call
                    | Op::CallThis
                    | Op::CallSame
                    | Op::CallVirtual
                    | Op::CallNative
                    | Op::CallLibrary
                    | Op::MoveText
                    | Op::CompareText
                    | Op::IsKind
                    | Op::Return => break 'run,
                });
                position += 1;
            }
        }
        let (mut pc, mut left) = self.before(position, left);
        let Some(origin) = self.origins.get(position) else { return (pc, left) };
        // The operation goes on without its lookups, from what they leave.
        let pairs = lookups.iter().zip(&self.left).skip(origin.first as usize);
        for (lookup, kept) in pairs.take(usize::from(origin.lookups)) {
            lookup.keep(memory, bases, kept);
        }
        for _ in 0..origin.folded {
            left -= self.costs.get(pc).map_or(0, |cost| i64::from(*cost));
            pc += 1;
        }
        (pc, left)
    }

    /// The operation at which a step begins, and the time that is left if nothing from there on runs.
    #[cold]
    #[inline(never)]
    fn before(&self, position: usize, left: i64) -> (usize, i64) {
        let cost = self.steps.get(position).map_or(0, |step| i64::from(step.cost));
        (self.origins.get(position).map_or(NONE as usize, |origin| origin.pc as usize), left + cost)
    }
}
