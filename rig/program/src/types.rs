//! The elementary types and how their values sit in 64-bit cells.

use signal::{Size, Value, of_single};

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
    /// Nanoseconds in 64 bits, unsigned: 0 to 2^63 - 1 is what the rig takes.
    Ltime,
    /// Seconds since 1970-01-01, at midnight, in 32 bits.
    Date,
    /// Milliseconds since midnight in 32 bits.
    Tod,
    /// Seconds since 1970-01-01 in 32 bits.
    Dt,
    /// Nanoseconds since 1970-01-01, at midnight, in 64 bits.
    Ldate,
    /// Nanoseconds since midnight in 64 bits.
    Ltod,
    /// Nanoseconds since 1970-01-01 in 64 bits.
    Ldt,
    /// IEEE 754 single; the cell holds its bits.
    Real,
    /// IEEE 754 double; the cell holds its bits.
    Lreal,
    /// One character of a STRING: 8 bits.
    Char,
    /// One character of a WSTRING: 16 bits.
    Wchar,
}

use Elementary::*;

impl Elementary {
    /// Every elementary type.
    pub const ALL: [Elementary; 25] = [
        Bool, Sint, Usint, Int, Uint, Dint, Udint, Lint, Ulint, Byte, Word, Dword, Lword, Time, Ltime, Date,
        Tod, Dt, Ldate, Ltod, Ldt, Real, Lreal, Char, Wchar,
    ];

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
            Ltime => "LTIME",
            Date => "DATE",
            Tod => "TIME_OF_DAY",
            Dt => "DATE_AND_TIME",
            Ldate => "LDATE",
            Ltod => "LTIME_OF_DAY",
            Ldt => "LDATE_AND_TIME",
            Real => "REAL",
            Lreal => "LREAL",
            Char => "CHAR",
            Wchar => "WCHAR",
        }
    }

    /// The type with this keyword, in capitals.
    pub(crate) fn named(key: &str) -> Option<Self> {
        match key {
            "TOD" => Some(Tod),
            "DT" => Some(Dt),
            "LTOD" => Some(Ltod),
            "LDT" => Some(Ldt),
            _ => Self::ALL.into_iter().find(|t| t.name() == key),
        }
    }

    /// Width: 1, 8, 16, 32 or 64.
    pub const fn bits(self) -> u32 {
        match self {
            Bool => 1,
            Sint | Usint | Byte | Char => 8,
            Int | Uint | Word | Wchar => 16,
            Dint | Udint | Dword | Time | Date | Tod | Dt | Real => 32,
            Lint | Ulint | Lword | Ltime | Ldate | Ltod | Ldt | Lreal => 64,
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

    /// The least and the greatest magnitude of a REAL beside 0, as they are written; of an LREAL for any other type
    /// (controller:DT-01).
    pub const fn magnitudes(self) -> (&'static str, &'static str) {
        match self {
            Real => ("1.175494351E-38", "3.402823466E+38"),
            _ => ("2.2250738585072014E-308", "1.7976931348623157E+308"),
        }
    }

    /// Whether a REAL, an LREAL for any other type, holds the number: 0, or one whose nearest has a normal magnitude.
    pub fn holds_real(self, number: f64) -> bool {
        let normal = if matches!(self, Real) { (number as f32).is_normal() } else { number.is_normal() };
        normal || number == 0.0
    }

    /// Whole numbers and bit strings.
    pub const fn is_integer(self) -> bool {
        matches!(self, Sint | Usint | Int | Uint | Dint | Udint | Lint | Ulint | Byte | Word | Dword | Lword)
    }

    /// Whether the processor computes it in more bits than it has: whole numbers of fewer than 32.
    pub(crate) const fn is_promoted(self) -> bool {
        self.is_integer() && self.bits() < 32
    }

    /// The type that a whole number is computed in: one of at least 32 bits, signed or not as this one.
    pub(crate) const fn promoted(self) -> Elementary {
        match (self.is_promoted(), self.signed()) {
            (true, true) => Dint,
            (true, false) => Udint,
            (false, _) => self,
        }
    }

    /// REAL and LREAL.
    pub const fn is_real(self) -> bool {
        matches!(self, Real | Lreal)
    }

    /// TIME and LTIME.
    pub const fn is_duration(self) -> bool {
        matches!(self, Time | Ltime)
    }

    /// Dates and times of day, short and long.
    pub const fn is_date(self) -> bool {
        matches!(self, Date | Tod | Dt | Ldate | Ltod | Ldt)
    }

    /// CHAR and WCHAR.
    pub const fn is_char(self) -> bool {
        matches!(self, Char | Wchar)
    }

    /// 64 bits unsigned: the only cells whose order is not that of `i64`.
    pub(crate) const fn wide_unsigned(self) -> bool {
        matches!(self, Ulint | Lword | Ltime | Ldate | Ltod | Ldt)
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
        if self.signed() {
            let cut = 64 - self.bits();
            (n << cut) >> cut
        } else if self.bits() == 64 {
            n
        } else {
            n & ((1 << self.bits()) - 1)
        }
    }

    /// The number in a cell.
    pub(crate) const fn number(self, cell: i64) -> i128 {
        if self.wide_unsigned() { cell as u64 as i128 } else { cell as i128 }
    }

    /// Nanoseconds in one step of a duration, a time of day or a date; `None` for what is no time.
    pub const fn nanos(self) -> Option<u64> {
        match self {
            Ltime | Ldate | Ltod | Ldt => Some(1),
            Time | Tod => Some(1_000_000),
            Date | Dt => Some(1_000_000_000),
            _ => None,
        }
    }

    /// A cell as the value that plans and traces speak of; TIME in nanoseconds, a REAL as the decimal that it stands for.
    pub(crate) fn value(self, cell: i64) -> Value {
        match self {
            Bool => Value::Bool(cell & 1 == 1),
            Real => Value::Real(of_single(f32::from_bits(cell as u32))),
            Lreal => Value::Real(f64::from_bits(cell as u64)),
            Ulint | Byte | Word | Dword | Lword => Value::Word(cell as u64),
            _ => match self.nanos() {
                Some(nanos) => Value::Int(cell * nanos as i64),
                None => Value::Int(cell),
            },
        }
    }

    /// A value as a cell: cut to the width; TIME and times of day from nanoseconds down to whole milliseconds, dates
    /// to whole seconds. `None` for what has no number.
    pub(crate) fn cell(self, value: Value) -> Option<i64> {
        match self {
            Bool => return value.as_bool().map(i64::from),
            Real => return value.as_real().map(|n| i64::from((n as f32).to_bits())),
            Lreal => return value.as_real().map(|n| n.to_bits() as i64),
            _ => {}
        }
        let number = value.as_int()? as i64;
        Some(self.wrap(number.div_euclid(self.nanos().unwrap_or(1) as i64)))
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
    pub(crate) const fn class(self) -> TypeClass {
        match self {
            Bool => TypeClass::Bool,
            Sint | Usint | Byte | Int | Uint | Word | Char | Wchar => TypeClass::Int,
            Dint | Udint | Dword | Time | Date | Tod | Dt => TypeClass::Dint,
            Lint | Ulint | Lword | Ltime | Ldate | Ltod | Ldt => TypeClass::Long,
            Real => TypeClass::Real,
            Lreal => TypeClass::Lreal,
        }
    }
}

/// What costs the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TypeClass {
    Bool,
    Int,
    Dint,
    Long,
    Real,
    Lreal,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_canonical_for_every_width() {
        // controller:DT-01 - against the ranges, not against the tables that wrap() uses.
        for ty in Elementary::ALL.into_iter().filter(|ty| !ty.is_real()) {
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
