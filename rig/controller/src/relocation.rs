//! The relocation table: scattered variables in contiguous registers (controller: section 6).

use crate::application::Application;
use crate::config::{RelocationConfig, RelocationPart};
use crate::location::VariableLocation;
use profile::{Profile, SystemField, SystemMember, SystemVariable, TABLE_WORDS};
use signal::Address;

/// What a row stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RelocationTarget {
    /// A member of a system structure, and the element where the structure is an array.
    Member(SystemField, u8),
    /// A byte of a member that is an array of bytes.
    Variable(SystemVariable),
    Application(VariableLocation),
}

/// A row of the table (controller:REL-03).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RelocationRow {
    /// The first register; none where the variable does not exist, which is shown as -1 (controller:REL-05).
    pub address: Option<u16>,
    /// Length in registers; 0 where the variable does not exist.
    pub words: u16,
    pub(crate) target: Option<RelocationTarget>,
}

/// The rows with their addresses.
#[derive(Clone, Debug, Default)]
pub(crate) struct RelocationTable {
    pub read: Vec<RelocationRow>,
    pub write: Vec<RelocationRow>,
}

impl RelocationTable {
    /// Packs the rows in their order, without gaps (controller:REL-04): a row whose variable does not exist takes no
    /// room. `Err` with the place of the first row that does not fit.
    pub(crate) fn pack(
        wanted: &RelocationConfig,
        application: Option<&dyn Application>,
        profile: Profile,
    ) -> Result<RelocationTable, (RelocationPart, usize)> {
        let part = |part: RelocationPart, names: &[String]| {
            let mut next: u32 = 0;
            let mut rows = Vec::with_capacity(names.len());
            for (place, name) in names.iter().enumerate() {
                let target = target(name, application, profile);
                let words = target.map_or(0, |target| target.words(profile));
                let after = next.saturating_add(words);
                if after > u32::from(TABLE_WORDS) {
                    return Err((part, place));
                }
                // Neither is above the words of a table.
                let (offset, words) = (next as u16, words as u16);
                rows.push(RelocationRow { address: target.map(|_| part.first() + offset), words, target });
                next = after;
            }
            Ok(rows)
        };
        Ok(RelocationTable {
            read: part(RelocationPart::Read, &wanted.read)?,
            write: part(RelocationPart::Write, &wanted.write)?,
        })
    }

    pub(crate) fn part(&self, part: RelocationPart) -> &[RelocationRow] {
        match part {
            RelocationPart::Read => &self.read,
            RelocationPart::Write => &self.write,
        }
    }

    /// The row that covers a register, and which of its words it is.
    pub(crate) fn at(&self, part: RelocationPart, register: u16) -> Option<(RelocationTarget, u16)> {
        self.part(part).iter().find_map(|row| {
            let word = register.checked_sub(row.address?)?;
            Some((row.target.filter(|_| word < row.words)?, word))
        })
    }
}

fn target(name: &str, application: Option<&dyn Application>, profile: Profile) -> Option<RelocationTarget> {
    if let Some((member, part)) = SystemMember::find(name, profile) {
        return Some(RelocationTarget::Member(member.field, part));
    }
    if let Some(variable) = SystemVariable::find(name, profile) {
        return Some(RelocationTarget::Variable(variable));
    }
    if name.starts_with('%') {
        return Address::parse(name)
            .ok()
            .map(|address| RelocationTarget::Application(VariableLocation::Memory(address)));
    }
    application?.locate(name).map(RelocationTarget::Application)
}

impl RelocationTarget {
    fn words(self, profile: Profile) -> u32 {
        match self {
            RelocationTarget::Member(field, _) => u32::from(field.member().ty(profile).words()),
            RelocationTarget::Variable(_) => 1,
            RelocationTarget::Application(located) => located.words(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &[&str]) -> Vec<String> {
        list.iter().map(|name| (*name).to_owned()).collect()
    }

    // controller:REL-04, the worked example of 2019; variables of the application are proven by the plans.
    #[test]
    fn rows_are_packed_without_gaps() {
        let wanted = RelocationConfig {
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
        let table = RelocationTable::pack(&wanted, None, Profile::M241_2019).unwrap();
        let rows =
            |rows: &[RelocationRow]| rows.iter().map(|row| (row.address, row.words)).collect::<Vec<_>>();
        assert_eq!(
            rows(&table.read),
            [(Some(60_200), 2), (Some(60_202), 16), (Some(60_218), 16), (Some(60_234), 1)]
        );
        let write = [(Some(62_200), 1), (Some(62_201), 1), (Some(62_202), 1), (Some(62_203), 2), (None, 0)];
        assert_eq!(rows(&table.write)[..5], write);
        assert_eq!(rows(&table.write)[5], (Some(62_205), 1));
        let m251 = RelocationTable::pack(&wanted, None, Profile::M251_2024).unwrap();
        assert_eq!(m251.read[2].address, Some(60_252), "a node name of 99 characters takes 50 words");
    }

    #[test]
    fn a_part_has_1800_words() {
        let most = RelocationConfig {
            read: vec![String::from("%MD0"); 900],
            write: vec![String::from("%MW0"); 1_800],
        };
        assert!(RelocationTable::pack(&most, None, Profile::M241_2014).is_ok());
        let more = RelocationConfig { read: vec![String::from("%MD0"); 901], ..most.clone() };
        assert_eq!(
            RelocationTable::pack(&more, None, Profile::M241_2014).unwrap_err(),
            (RelocationPart::Read, 900)
        );
        let more = RelocationConfig { write: vec![String::from("%MW0"); 1_801], ..most };
        assert_eq!(
            RelocationTable::pack(&more, None, Profile::M241_2014).unwrap_err(),
            (RelocationPart::Write, 1_800)
        );
    }
}
