//! Where variables of the application are, and how they fill registers.

use signal::{Address, Size, Value, of_single};

/// How a variable of the application fills registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegisterFormat {
    /// TRUE or FALSE in bit 0.
    Bit,
    /// A whole number or bit string of so many registers, the low word first.
    Whole(u16),
    /// A REAL.
    Real,
    /// An LREAL.
    Long,
}

impl RegisterFormat {
    pub(crate) const fn words(self) -> u16 {
        match self {
            RegisterFormat::Bit => 1,
            RegisterFormat::Whole(words) => words,
            RegisterFormat::Real => 2,
            RegisterFormat::Long => 4,
        }
    }

    /// The bits of a value.
    fn bits(self, value: Value) -> u64 {
        match (self, value) {
            (RegisterFormat::Real, value) => {
                value.as_real().map_or(0, |real| u64::from((real as f32).to_bits()))
            }
            (RegisterFormat::Long, value) => value.as_real().map_or(0, f64::to_bits),
            (_, value) => value.as_int().map_or(0, |whole| whole as u64),
        }
    }

    /// The value of these bits.
    fn value(self, bits: u64) -> Value {
        match self {
            RegisterFormat::Bit => Value::Bool(bits & 1 != 0),
            RegisterFormat::Whole(_) => Value::Word(bits),
            RegisterFormat::Real => Value::Real(of_single(f32::from_bits(bits as u32))),
            RegisterFormat::Long => Value::Real(f64::from_bits(bits)),
        }
    }
}

/// Where a variable of the application is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableLocation {
    /// A variable by its number.
    Variable(u32, RegisterFormat),
    /// A place in memory.
    Memory(Address),
    /// A text, an array or a structure, two of its bytes in each register, the lower one first.
    Extent {
        /// Where its first byte is.
        first: ExtentStart,
        /// How many bytes it has.
        bytes: u32,
    },
}

/// Where an extent begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtentStart {
    /// The number of its first byte: [`crate::Application::word_of`] has its words.
    Variable(u32),
    /// A byte of memory.
    Memory(Address),
}

impl VariableLocation {
    /// How many registers it takes.
    pub(crate) fn words(self) -> u32 {
        match self {
            VariableLocation::Variable(_, form) => u32::from(form.words()),
            VariableLocation::Memory(address) => address.bit_len().div_ceil(16),
            VariableLocation::Extent { bytes, .. } => bytes.div_ceil(2),
        }
    }
}

/// The bytes of memory behind one register of an extent that begins at `first`; one at the end of an odd number.
pub(crate) fn memory_bytes(first: Address, bytes: u32, word: u16) -> impl Iterator<Item = Address> {
    let offset = 2 * u32::from(word);
    (offset..bytes.min(offset + 2)).filter_map(move |byte| {
        Address::new(first.area(), Size::Byte, (first.bit_offset() / 8).checked_add(byte)?)
    })
}

/// One register of a variable's value.
pub(crate) fn word_of(form: RegisterFormat, value: Value, word: u16) -> u16 {
    (form.bits(value) >> (16 * u32::from(word.min(3)))) as u16
}

/// A variable's value with one of its registers replaced.
pub(crate) fn with_word(form: RegisterFormat, value: Value, word: u16, new: u16) -> Value {
    let shift = 16 * u32::from(word.min(3));
    form.value(form.bits(value) & !(0xFFFF << shift) | u64::from(new) << shift)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_values() {
        let value = Value::Int(-2);
        assert_eq!(
            (word_of(RegisterFormat::Whole(2), value, 0), word_of(RegisterFormat::Whole(2), value, 1)),
            (0xFFFE, 0xFFFF)
        );
        assert_eq!(
            with_word(RegisterFormat::Whole(2), Value::Word(0x1234_5678), 1, 0xABCD),
            Value::Word(0xABCD_5678)
        );
        assert_eq!(word_of(RegisterFormat::Real, Value::Real(1.0), 1), 0x3F80);
        assert_eq!(with_word(RegisterFormat::Real, Value::Real(1.0), 1, 0x4000), Value::Real(2.0));
        assert_eq!(with_word(RegisterFormat::Bit, Value::Bool(false), 0, 1), Value::Bool(true));
    }
}
