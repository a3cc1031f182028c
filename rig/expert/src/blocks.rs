//! The function blocks by which programs use expert functions: a table of names, pins and bodies.

mod axis;
mod hsc;
mod wave;

use crate::ExpertFunctions;
use signal::Time;
use std::fmt;

/// Who may set a pin. The language of the caller has such kinds, too; neither crate knows the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockPinKind {
    /// Set by the caller.
    Input,
    /// Read by the caller.
    Output,
    /// The block's own memory, not visible to the program.
    Hidden,
}

/// Type of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueType {
    /// BOOL.
    Bool,
    /// The number of a function: type EXPERT_REF, a WORD (io:EXP-16).
    Reference,
    /// WORD.
    Word,
    /// INT.
    Int,
    /// DINT.
    Dint,
    /// UDINT.
    Udint,
    /// LINT; hidden pins.
    Lint,
}

/// One pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinType {
    /// Name as documented; programs may write it in any case of letters.
    pub name: &'static str,
    /// Who may set it.
    pub kind: BlockPinKind,
    /// Its type.
    pub ty: ValueType,
}

/// The pins of an instance during a call, by their places; all are 0 at first.
pub trait BlockPins {
    /// The value of a pin; 0 where there is no such pin.
    fn get(&self, pin: usize) -> i64;
    /// Sets a pin, cut to its type.
    fn set(&mut self, pin: usize, value: i64);
}

/// One call of a block.
pub struct BlockCall<'a> {
    /// Modelled time at which it takes effect.
    pub now: Time,
    /// The pins of the instance.
    pub pins: &'a mut dyn BlockPins,
    /// The functions.
    pub expert: &'a mut ExpertFunctions,
}

impl fmt::Debug for BlockCall<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BlockCall").field("now", &self.now).finish_non_exhaustive()
    }
}

/// A type of function block.
#[derive(Clone, Copy, Debug)]
pub struct BlockType {
    /// Name as documented.
    pub name: &'static str,
    /// BlockPins in the order of positional parameters.
    pub pins: &'static [PinType],
    /// One call: allocates nothing, ends in bounded time.
    pub run: fn(&mut BlockCall<'_>),
}

/// A pin of a table.
const fn pin(name: &'static str, kind: BlockPinKind, ty: ValueType) -> PinType {
    PinType { name, kind, ty }
}

/// Every block.
pub const BLOCKS: &[&[BlockType]] =
    &[hsc::BLOCKS, axis::MOVES, axis::ADMINISTRATIVE, axis::READS, wave::BLOCKS];
