//! The elementary types and how their values sit in 64-bit cells.

use signal::{Size, Value};

/// An elementary type (controller:DT-01). Every value of one fits one 64-bit cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Elementary {
    /// FALSE or TRUE.
    Bool,
    /// 8 bits signed.
    Sint,
    /// 8 bits unsigned.
    Usint,
    /// 16 bits signed.
    Int,
    /// 16 bits unsigned.
    Uint,
    /// 32 bits signed.
    Dint,
    /// 32 bits unsigned.
    Udint,
    /// 64 bits signed.
    Lint,
    /// 64 bits unsigned.
    Ulint,
    /// Bit string of 8.
    Byte,
    /// Bit string of 16.
    Word,
    /// Bit string of 32.
    Dword,
    /// Bit string of 64.
    Lword,
    /// Milliseconds in 32 bits, 0 to 4294967295.
    Time,
}

use Elementary::*;

impl Elementary {
    /// Every elementary type.
    pub const ALL: [Elementary; 14] =
        [Bool, Sint, Usint, Int, Uint, Dint, Udint, Lint, Ulint, Byte, Word, Dword, Lword, Time];

    /// The keyword.
    pub const fn name(self) -> &'static str {
        match self {
            Bool => "BOOL",
            Sint => "SINT",
            Usint => "USINT",
            Int => "INT",
            Uint => "UINT",
            Dint => "DINT",
            Udint => "UDINT",
            Lint => "LINT",
            Ulint => "ULINT",
            Byte => "BYTE",
            Word => "WORD",
            Dword => "DWORD",
            Lword => "LWORD",
            Time => "TIME",
        }
    }

    /// The type with this keyword, in capitals.
    pub(crate) fn named(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.name() == key)
    }

    /// Width: 1, 8, 16, 32 or 64.
    pub const fn bits(self) -> u32 {
        match self {
            Bool => 1,
            Sint | Usint | Byte => 8,
            Int | Uint | Word => 16,
            Dint | Udint | Dword | Time => 32,
            Lint | Ulint | Lword => 64,
        }
    }

    /// Bytes of a stored value: 1, 2, 4 or 8.
    pub const fn bytes(self) -> usize {
        self.bits().div_ceil(8) as usize
    }

    /// Whether values can be negative.
    pub const fn signed(self) -> bool {
        matches!(self, Sint | Int | Dint | Lint)
    }

    /// BYTE, WORD, DWORD and LWORD.
    pub const fn is_bit_string(self) -> bool {
        matches!(self, Byte | Word | Dword | Lword)
    }

    /// Numbers and bit strings: what arithmetic takes besides TIME.
    pub(crate) const fn is_integer(self) -> bool {
        !matches!(self, Bool | Time)
    }

    /// 64 bits unsigned: the only cells whose order is not that of `i64`.
    pub(crate) const fn wide_unsigned(self) -> bool {
        matches!(self, Ulint | Lword)
    }

    /// Smallest and largest value.
    pub const fn range(self) -> (i128, i128) {
        if self.signed() {
            (-(1i128 << (self.bits() - 1)), (1i128 << (self.bits() - 1)) - 1)
        } else {
            (0, (1i128 << self.bits()) - 1)
        }
    }

    /// Whether every value of `other` is a value of this type.
    pub(crate) fn holds(self, other: Elementary) -> bool {
        let ((low, high), (other_low, other_high)) = (self.range(), other.range());
        low <= other_low && other_high <= high
    }

    /// A 64-bit result cut to the width of the type and put in its cell form: signed types sign-extended,
    /// the others zero-extended.
    #[inline(always)]
    pub(crate) const fn wrap(self, n: i64) -> i64 {
        // Tables instead of a match: this is behind every addition.
        const SHIFT: [u8; 16] = [63, 56, 56, 48, 48, 32, 32, 0, 0, 56, 48, 32, 0, 32, 0, 0];
        const MASK: [i64; 16] = [
            1,
            -1,
            0xFF,
            -1,
            0xFFFF,
            -1,
            0xFFFF_FFFF,
            -1,
            -1,
            0xFF,
            0xFFFF,
            0xFFFF_FFFF,
            -1,
            0xFFFF_FFFF,
            -1,
            -1,
        ];
        let at = self as usize & 15;
        ((n << SHIFT[at]) >> SHIFT[at]) & MASK[at]
    }

    /// The number in a cell.
    pub(crate) const fn number(self, cell: i64) -> i128 {
        if self.wide_unsigned() { cell as u64 as i128 } else { cell as i128 }
    }

    /// A cell as the value that plans and traces speak of; TIME in nanoseconds.
    pub(crate) const fn value(self, cell: i64) -> Value {
        match self {
            Bool => Value::Bool(cell & 1 == 1),
            Time => Value::Int(cell * 1_000_000),
            Ulint | Byte | Word | Dword | Lword => Value::Word(cell as u64),
            _ => Value::Int(cell),
        }
    }

    /// A value as a cell: cut to the width, TIME from nanoseconds down to whole milliseconds. `None` for what has no number.
    pub(crate) fn cell(self, value: Value) -> Option<i64> {
        if self == Bool {
            return value.as_bool().map(i64::from);
        }
        let number = value.as_int()? as i64;
        Some(if self == Time { self.wrap(number.div_euclid(1_000_000)) } else { self.wrap(number) })
    }

    /// Whether a located variable of this type covers exactly an address of `size`.
    pub(crate) const fn fits(self, size: Size) -> bool {
        self.bits() == size.bits()
    }

    /// The bit string that a direct address of `size` is read as.
    pub(crate) const fn of_size(size: Size) -> Elementary {
        match size {
            Size::Bit => Bool,
            Size::Byte => Byte,
            Size::Word => Word,
            Size::Double => Dword,
            Size::Long => Lword,
        }
    }

    /// Which cost of [`crate::Costs`] applies.
    pub(crate) const fn class(self) -> Class {
        match self {
            Bool => Class::Bool,
            Sint | Usint | Byte | Int | Uint | Word => Class::Int,
            Dint | Udint | Dword | Time => Class::Dint,
            Lint | Ulint | Lword => Class::Long,
        }
    }
}

/// What costs the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    Bool,
    Int,
    Dint,
    Long,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_canonical_for_every_width() {
        // controller:DT-01 - against the ranges, not against the tables that wrap() uses.
        for ty in Elementary::ALL {
            let (low, high) = ty.range();
            for n in [
                0,
                1,
                -1,
                127,
                128,
                255,
                256,
                -128,
                -129,
                65_535,
                65_536,
                i64::MAX,
                i64::MIN,
                1 << 32,
                -(1 << 31),
            ] {
                let number = ty.number(ty.wrap(n));
                assert!(number >= low && number <= high, "{} {n}", ty.name());
                assert_eq!((number - i128::from(n)).rem_euclid(1i128 << ty.bits()), 0, "{} {n}", ty.name());
            }
        }
    }
}
