//! What the memory of a program holds: types as the outside sees them, and the variables by their paths.

use crate::types::Elementary;

/// A place in `Program::shapes`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ShapeId(pub u32);

/// A type as it lies in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MemoryLayout {
    /// One value.
    Elementary(Elementary),
    /// A value with names: the name and cell of each.
    Enumeration {
        /// As declared.
        name: String,
        /// The type of its cells.
        base: Elementary,
        /// Names as declared with their cells.
        values: Vec<(String, i64)>,
    },
    /// A whole number with narrower limits.
    Subrange {
        /// The type of its cells.
        base: Elementary,
        /// Least value.
        low: i64,
        /// Greatest value.
        high: i64,
    },
    /// STRING or WSTRING: units of one or two bytes, ended by 0 or by the storage.
    Text {
        /// WSTRING.
        wide: bool,
        /// Characters that fit, without the closing 0.
        length: u32,
    },
    /// Elements of one type, the last dimension fastest.
    Array {
        /// Lower and upper bound of each dimension.
        dimensions: Vec<(i64, i64)>,
        /// Type of the elements.
        of: ShapeId,
        /// Bytes from one element to the next.
        stride: u32,
    },
    /// A structure, a union, or an instance of a block or program.
    Members {
        /// Name of the type.
        name: String,
        /// Name as declared, offset in bytes, type.
        members: Vec<Member>,
        /// Bytes.
        size: u32,
        /// An instance of a block.
        block: bool,
    },
    /// An address of 32 bits: pointers, references, interfaces, in-outs.
    Address,
}

impl MemoryLayout {
    /// The type of its cell, for one value.
    pub fn elementary(&self) -> Option<Elementary> {
        match self {
            MemoryLayout::Elementary(ty) => Some(*ty),
            MemoryLayout::Enumeration { base, .. } | MemoryLayout::Subrange { base, .. } => Some(*base),
            MemoryLayout::Text { .. }
            | MemoryLayout::Array { .. }
            | MemoryLayout::Members { .. }
            | MemoryLayout::Address => None,
        }
    }

    /// Bytes that one takes.
    pub fn bytes(&self) -> u32 {
        match self {
            MemoryLayout::Elementary(ty)
            | MemoryLayout::Enumeration { base: ty, .. }
            | MemoryLayout::Subrange { base: ty, .. } => ty.bytes() as u32,
            MemoryLayout::Text { wide, length } => {
                length.saturating_add(1).saturating_mul(1 + u32::from(*wide))
            }
            MemoryLayout::Array { dimensions, stride, .. } => count(dimensions).saturating_mul(*stride),
            MemoryLayout::Members { size, .. } => *size,
            MemoryLayout::Address => 4,
        }
    }
}

/// Elements of an array.
pub(crate) fn count(dimensions: &[(i64, i64)]) -> u32 {
    dimensions.iter().fold(1, |count: u32, (low, high)| {
        let width = i128::from(*high) - i128::from(*low) + 1;
        count.saturating_mul(u32::try_from(width).unwrap_or(if width < 0 { 0 } else { u32::MAX }))
    })
}

/// A member of a structure or block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// As declared.
    pub name: String,
    /// Bytes from the start.
    pub offset: u32,
    /// Its type.
    pub shape: ShapeId,
}

/// A variable that is no part of another: a global one, or the instance of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Root {
    /// `MAIN` for a program, `MAIN.x` for a located variable of it, the bare name of a global variable.
    pub path: String,
    /// Its type.
    pub shape: ShapeId,
    /// Address in the machine's address space.
    pub address: u32,
    /// Bit of that byte, for a BOOL in the images or the mapped memory; else 0.
    pub bit: u8,
    /// Place of the source file that declares it.
    pub file: u16,
}
