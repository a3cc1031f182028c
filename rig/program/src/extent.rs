//! Variables that are more than one value, as the bytes that they take.

use crate::program::{Program, Storage, VarRef};
use crate::shape::{MemoryLayout, ShapeId};
use crate::types::Elementary;
use crate::walk::Spot;

/// Types that stand inside each other, at most.
const DEPTH: u32 = 200;

/// The bytes of a text, an array or a structure as they lie in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extent {
    /// The first byte.
    pub first: Storage,
    /// How many there are.
    pub bytes: u32,
}

impl Program {
    /// The bytes of the text, array or structure at a path, in capitals or not. `None` for a single value, which
    /// [`Program::find`] describes, and for what has a block or an address in it.
    pub fn extent(&self, path: &str) -> Option<Extent> {
        let spot = Spot::find(self, path)?;
        let shape = self.shape(spot.shape)?;
        if shape.elementary().is_some() || spot.bit != 0 || !self.is_plain(spot.shape, 0) {
            return None;
        }
        Some(Extent { first: spot.storage(Elementary::Byte)?, bytes: shape.bytes() })
    }

    /// Whether a type has values and texts alone in it.
    fn is_plain(&self, id: ShapeId, depth: u32) -> bool {
        let inner = |id: ShapeId| depth < DEPTH && self.is_plain(id, depth + 1);
        match self.shape(id) {
            Some(
                MemoryLayout::Elementary(_)
                | MemoryLayout::Enumeration { .. }
                | MemoryLayout::Subrange { .. }
                | MemoryLayout::Text { .. },
            ) => true,
            Some(MemoryLayout::Array { of, .. }) => inner(*of),
            Some(MemoryLayout::Members { members, block, .. }) => {
                !block && members.iter().all(|member| inner(member.shape))
            }
            Some(MemoryLayout::Address) | None => false,
        }
    }
}

impl VarRef {
    /// Two bytes of an extent of `bytes` bytes that begins here, from byte `2 * word` on: a WORD, or the BYTE at the end
    /// of an odd number. `None` beyond the extent.
    pub fn word_of(self, bytes: u32, word: u16) -> Option<VarRef> {
        let from = 2 * u32::from(word);
        let ty = match bytes.checked_sub(from)? {
            0 => return None,
            1 => Elementary::Byte,
            _ => Elementary::Word,
        };
        Some(VarRef::new(self.address().checked_add(from)?, ty))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use crate::{Machine, compile};
    use document::SourceFile;
    use signal::{Address, Area, Size, Value};

    // controller:REL-03
    #[test]
    fn texts_arrays_and_structures_have_bytes_and_single_values_have_none() {
        let text = "TYPE pair : STRUCT a : INT; name : STRING[4]; END_STRUCT; other : STRUCT t : TON; END_STRUCT; END_TYPE
            PROGRAM MAIN VAR n : INT; s : STRING[9] := 'abc'; w : WSTRING[2]; a : ARRAY [1..3] OF BYTE := [1, 2, 3];
            p : pair; t : TON; o : other; address : POINTER TO INT; m AT %MB6 : ARRAY [0..2] OF INT; END_VAR END_PROGRAM";
        let program = compile(&[SourceFile::new("a.st", text)], &Options::default()).unwrap();
        let bytes = |path: &str| program.extent(path).map(|extent| extent.bytes);
        assert_eq!(bytes("main.s"), Some(10));
        assert_eq!(bytes("MAIN.w"), Some(6));
        assert_eq!(bytes("MAIN.a"), Some(3));
        assert_eq!(bytes("MAIN.p.name"), Some(5));
        assert!(bytes("MAIN.p").is_some_and(|bytes| bytes >= 7));
        for none in ["MAIN.n", "MAIN.a[2]", "MAIN.t", "MAIN.o", "MAIN.address", "MAIN", "MAIN.gone"] {
            assert_eq!(bytes(none), None, "{none}");
        }
        let located = Storage::Located(Address::new(Area::Memory, Size::Byte, 6).unwrap());
        assert_eq!(program.extent("MAIN.m"), Some(Extent { first: located, bytes: 6 }));

        let Some(Extent { first: Storage::Cell(array), bytes }) = program.extent("MAIN.a") else { panic!() };
        let machine = Machine::new(program.into(), &[vec![0]]).unwrap();
        let word = |word| array.word_of(bytes, word).map(|variable| machine.read(variable));
        assert_eq!([word(0), word(1), word(2)], [Some(Value::Word(0x0201)), Some(Value::Word(3)), None]);
    }
}
