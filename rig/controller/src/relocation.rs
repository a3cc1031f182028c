//! The relocation table: scattered variables in contiguous registers (controller: section 6).

use crate::Application;
use profile::{Profile, READ_TABLE, SystemField, TABLE_WORDS, WRITE_TABLE};
use signal::{Address, Value};

/// The relocation table as configured: one for a controller (controller:REL-01). Names or full paths, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Relocation {
    /// What stands from %MW60200 on.
    pub read: Vec<String>,
    /// What stands from %MW62200 on.
    pub write: Vec<String>,
}

/// A part of the table (controller:REL-02).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// From %MW60200 on.
    Read,
    /// From %MW62200 on.
    Write,
}

impl Part {
    /// The first register.
    pub const fn first(self) -> u16 {
        match self {
            Part::Read => READ_TABLE,
            Part::Write => WRITE_TABLE,
        }
    }
}

/// How a variable of the application fills registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// TRUE or FALSE in bit 0.
    Bit,
    /// A whole number or bit string of so many registers, the low word first.
    Whole(u16),
    /// A REAL.
    Real,
    /// An LREAL.
    Long,
}

impl Form {
    const fn words(self) -> u16 {
        match self {
            Form::Bit => 1,
            Form::Whole(words) => words,
            Form::Real => 2,
            Form::Long => 4,
        }
    }

    /// The bits of a value.
    fn bits(self, value: Value) -> u64 {
        match (self, value) {
            (Form::Real, value) => value.as_real().map_or(0, |real| u64::from((real as f32).to_bits())),
            (Form::Long, value) => value.as_real().map_or(0, f64::to_bits),
            (_, value) => value.as_int().map_or(0, |whole| whole as u64),
        }
    }

    /// The value of these bits.
    fn value(self, bits: u64) -> Value {
        match self {
            Form::Bit => Value::Bool(bits & 1 != 0),
            Form::Whole(_) => Value::Word(bits),
            Form::Real => Value::Real(f64::from(f32::from_bits(bits as u32))),
            Form::Long => Value::Real(f64::from_bits(bits)),
        }
    }
}

/// Where a variable of the application is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Located {
    /// A variable by its number.
    Variable(u32, Form),
    /// A place in memory.
    Memory(Address),
}

/// What a row stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    System(SystemField),
    Application(Located),
}

/// A row of the table (controller:REL-03).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// The first register; none where the variable does not exist, which is shown as -1 (controller:REL-05).
    pub address: Option<u16>,
    /// Length in registers; 0 where the variable does not exist.
    pub words: u16,
    pub(crate) target: Option<Target>,
}

/// The rows with their addresses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    pub read: Vec<Row>,
    pub write: Vec<Row>,
}

impl Table {
    /// Packs the rows in their order, without gaps (controller:REL-04): a row whose variable does not exist takes no
    /// room. `Err` with the place of the first row that does not fit.
    pub(crate) fn pack(
        wanted: &Relocation,
        application: Option<&dyn Application>,
        profile: Profile,
    ) -> Result<Table, (Part, usize)> {
        let part = |part: Part, names: &[String]| {
            let mut next = 0;
            let mut rows = Vec::with_capacity(names.len());
            for (place, name) in names.iter().enumerate() {
                let target = target(name, application);
                let words = target.map_or(0, |target| target.words(profile));
                if next + words > TABLE_WORDS {
                    return Err((part, place));
                }
                rows.push(Row { address: target.map(|_| part.first() + next), words, target });
                next += words;
            }
            Ok(rows)
        };
        Ok(Table { read: part(Part::Read, &wanted.read)?, write: part(Part::Write, &wanted.write)? })
    }

    pub(crate) fn part(&self, part: Part) -> &[Row] {
        match part {
            Part::Read => &self.read,
            Part::Write => &self.write,
        }
    }

    /// The row that covers a register, and which of its words it is.
    pub(crate) fn at(&self, part: Part, register: u16) -> Option<(Target, u16)> {
        self.part(part).iter().find_map(|row| {
            let word = register.checked_sub(row.address?)?;
            Some((row.target.filter(|_| word < row.words)?, word))
        })
    }
}

fn target(name: &str, application: Option<&dyn Application>) -> Option<Target> {
    if let Some(field) = SystemField::find(name) {
        return Some(Target::System(field));
    }
    if name.starts_with('%') {
        return Address::parse(name).ok().map(|address| Target::Application(Located::Memory(address)));
    }
    application?.locate(name).map(Target::Application)
}

impl Target {
    fn words(self, profile: Profile) -> u16 {
        match self {
            Target::System(field) => field.words(profile),
            Target::Application(Located::Variable(_, form)) => form.words(),
            Target::Application(Located::Memory(address)) => address.bit_len().div_ceil(16) as u16,
        }
    }
}

/// One register of a variable's value.
pub(crate) fn word_of(form: Form, value: Value, word: u16) -> u16 {
    (form.bits(value) >> (16 * u32::from(word.min(3)))) as u16
}

/// A variable's value with one of its registers replaced.
pub(crate) fn with_word(form: Form, value: Value, word: u16, new: u16) -> Value {
    let shift = 16 * u32::from(word.min(3));
    form.value(form.bits(value) & !(0xFFFF << shift) | u64::from(new) << shift)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &[&str]) -> Vec<String> {
        list.iter().map(|name| (*name).to_owned()).collect()
    }

    // controller:REL-04, the worked example of 2019; variables of the application are told by the plans.
    #[test]
    fn rows_are_packed_without_gaps() {
        let wanted = Relocation {
            read: names(&["PLC_R.i_dwSerialNumber", "PLC_R.i_sNodeName", "PLC_R.i_sProductRef", "%MW5"]),
            write: names(&[
                "PLC_W.q_wResetCounterEvent",
                "ETH_W.q_wResetCounter",
                "%MW6",
                "%MD9",
                "gone",
                "%MX7.3",
            ]),
        };
        let table = Table::pack(&wanted, None, Profile::M241_2019).unwrap();
        let rows = |rows: &[Row]| rows.iter().map(|row| (row.address, row.words)).collect::<Vec<_>>();
        assert_eq!(
            rows(&table.read),
            [(Some(60_200), 2), (Some(60_202), 16), (Some(60_218), 16), (Some(60_234), 1)]
        );
        let write = [(Some(62_200), 1), (Some(62_201), 1), (Some(62_202), 1), (Some(62_203), 2), (None, 0)];
        assert_eq!(rows(&table.write)[..5], write);
        assert_eq!(rows(&table.write)[5], (Some(62_205), 1));
        let m251 = Table::pack(&wanted, None, Profile::M251_2024).unwrap();
        assert_eq!(m251.read[2].address, Some(60_252), "a node name of 99 characters takes 50 words");
    }

    #[test]
    fn a_part_has_1800_words() {
        let most =
            Relocation { read: vec![String::from("%MD0"); 900], write: vec![String::from("%MW0"); 1_800] };
        assert!(Table::pack(&most, None, Profile::M241_2014).is_ok());
        let more = Relocation { read: vec![String::from("%MD0"); 901], ..most.clone() };
        assert_eq!(Table::pack(&more, None, Profile::M241_2014).unwrap_err(), (Part::Read, 900));
        let more = Relocation { write: vec![String::from("%MW0"); 1_801], ..most };
        assert_eq!(Table::pack(&more, None, Profile::M241_2014).unwrap_err(), (Part::Write, 1_800));
    }

    #[test]
    fn words_of_values() {
        let value = Value::Int(-2);
        assert_eq!((word_of(Form::Whole(2), value, 0), word_of(Form::Whole(2), value, 1)), (0xFFFE, 0xFFFF));
        assert_eq!(with_word(Form::Whole(2), Value::Word(0x1234_5678), 1, 0xABCD), Value::Word(0xABCD_5678));
        assert_eq!(word_of(Form::Real, Value::Real(1.0), 1), 0x3F80);
        assert_eq!(with_word(Form::Real, Value::Real(1.0), 1, 0x4000), Value::Real(2.0));
        assert_eq!(with_word(Form::Bit, Value::Bool(false), 0, 1), Value::Bool(true));
    }
}
