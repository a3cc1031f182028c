//! What a member of a system structure is, and the macro that declares the tables of them.

use super::enumeration::Enumeration;
use super::{SystemField, text_words};
use crate::{Family, Profile};

/// Type of a member. What the documents type as an enumeration is a WORD with an [`Enumeration`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MemberType {
    /// BOOL.
    Bool,
    /// BYTE.
    Byte,
    /// WORD.
    Word,
    /// UINT.
    Uint,
    /// DWORD.
    Dword,
    /// UDINT.
    Udint,
    /// LWORD.
    Lword,
    /// ARRAY[0..n-1] OF BYTE of so many bytes, 1...8.
    Bytes(u8),
    /// STRING of so many characters.
    Text(u16),
}

impl MemberType {
    /// Bits of a value; of an array of bytes those of one of them, none of a text.
    pub const fn bits(self) -> u32 {
        match self {
            MemberType::Bool => 1,
            MemberType::Byte | MemberType::Bytes(_) => 8,
            MemberType::Word | MemberType::Uint => 16,
            MemberType::Dword | MemberType::Udint => 32,
            MemberType::Lword => 64,
            MemberType::Text(_) => 0,
        }
    }

    /// Registers that it takes (controller:REL-04). A text of n characters has n + 1 bytes.
    pub const fn words(self) -> u16 {
        match self {
            MemberType::Bool | MemberType::Byte | MemberType::Word | MemberType::Uint => 1,
            MemberType::Dword | MemberType::Udint => 2,
            MemberType::Lword => 4,
            MemberType::Bytes(bytes) => (bytes as u16).div_ceil(2),
            MemberType::Text(characters) => text_words(characters),
        }
    }

    /// As it is declared in Structured Text.
    pub fn declaration(self) -> String {
        match self {
            MemberType::Bool => String::from("BOOL"),
            MemberType::Byte => String::from("BYTE"),
            MemberType::Word => String::from("WORD"),
            MemberType::Uint => String::from("UINT"),
            MemberType::Dword => String::from("DWORD"),
            MemberType::Udint => String::from("UDINT"),
            MemberType::Lword => String::from("LWORD"),
            MemberType::Bytes(bytes) => format!("ARRAY[0..{}] OF BYTE", bytes.saturating_sub(1)),
            MemberType::Text(characters) => format!("STRING({characters})"),
        }
    }
}

/// Where the value of a member comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MemberSource {
    /// The controller, at any moment.
    Live,
    /// The controller, which never changes it.
    Fixed,
    /// Nothing feeds it yet: it has this value.
    Rest(u64),
}

/// A member of a system structure.
#[derive(Clone, Copy, Debug)]
pub struct SystemMember {
    /// Its name in the structure.
    pub name: &'static str,
    /// Another name of it, which a program may use, too.
    pub alias: Option<&'static str>,
    /// What it is.
    pub field: SystemField,
    ty: MemberType,
    /// The type in an M251, where it is another one.
    ty_m251: Option<MemberType>,
    /// Unit of its value; empty for none.
    pub unit: &'static str,
    /// The names of its values.
    pub enumeration: Option<&'static Enumeration>,
    /// The profiles whose controllers have it.
    pub profiles: &'static [Profile],
    /// The first register where it is located; `None` for what only the relocation table brings to the network.
    pub register: Option<u16>,
    /// Where its value comes from.
    pub source: MemberSource,
    /// The requirement that asks for it.
    pub requirement: &'static str,
    /// What it means, as a sentence.
    pub meaning: &'static str,
}

/// The profiles of the M241.
pub(super) const M241: &[Profile] = &[Profile::M241_2014, Profile::M241_2019];
/// The profiles that may command the expansion bus.
pub(super) const SINCE_2019: &[Profile] = &[Profile::M241_2019, Profile::M251_2024];

impl SystemMember {
    pub(super) const fn new(
        field: SystemField,
        name: &'static str,
        ty: MemberType,
        requirement: &'static str,
        meaning: &'static str,
    ) -> SystemMember {
        SystemMember {
            name,
            alias: None,
            field,
            ty,
            ty_m251: None,
            unit: "",
            enumeration: None,
            profiles: &Profile::ALL,
            register: None,
            source: MemberSource::Live,
            requirement,
            meaning,
        }
    }

    pub(super) const fn alias(mut self, alias: &'static str) -> SystemMember {
        self.alias = Some(alias);
        self
    }

    pub(super) const fn in_m251(mut self, ty: MemberType) -> SystemMember {
        self.ty_m251 = Some(ty);
        self
    }

    pub(super) const fn unit(mut self, unit: &'static str) -> SystemMember {
        self.unit = unit;
        self
    }

    pub(super) const fn names(mut self, enumeration: &'static Enumeration) -> SystemMember {
        self.enumeration = Some(enumeration);
        self
    }

    pub(super) const fn only(mut self, profiles: &'static [Profile]) -> SystemMember {
        self.profiles = profiles;
        self
    }

    pub(super) const fn at(mut self, register: u16) -> SystemMember {
        self.register = Some(register);
        self
    }

    pub(super) const fn fixed(mut self) -> SystemMember {
        self.source = MemberSource::Fixed;
        self
    }

    pub(super) const fn rest(mut self, value: u64) -> SystemMember {
        self.source = MemberSource::Rest(value);
        self
    }

    /// Its type in a controller of this profile.
    pub const fn ty(&self, profile: Profile) -> MemberType {
        match (profile.family(), self.ty_m251) {
            (Family::M251, Some(ty)) => ty,
            _ => self.ty,
        }
    }

    /// Whether a controller of this profile has it.
    pub fn exists(&self, profile: Profile) -> bool {
        self.profiles.contains(&profile)
    }

    /// Whether it has this name, in any case of letters.
    pub fn is_named(&self, name: &str) -> bool {
        self.name.eq_ignore_ascii_case(name)
            || self.alias.is_some_and(|alias| alias.eq_ignore_ascii_case(name))
    }

    /// Its names: the one that the documents give it, and another one where there is one.
    pub fn names_of_it(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.name).chain(self.alias)
    }
}

/// Declares the members of a structure: an enumeration of them, which is what [`SystemField`] says of this structure, and
/// the table. A line is `Variant = "name": Type, [properties], "requirement", "meaning";`.
macro_rules! members {
    (
        $(#[$doc:meta])* $fields:ident of $structure:ident, $table:ident:
        $($variant:ident = $name:literal: $ty:expr, [$($property:ident($($value:expr),*)),*], $requirement:literal, $meaning:literal;)+
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $fields {
            $(#[doc = $meaning] $variant,)+
        }

        /// The members in the order of the documents, by the places of their variants.
        pub(super) const $table: &[SystemMember] = &[$(
            SystemMember::new(SystemField::$structure($fields::$variant), $name, $ty, $requirement, $meaning)
                $(.$property($($value),*))*,
        )+];

        impl From<$fields> for SystemField {
            fn from(field: $fields) -> SystemField {
                SystemField::$structure(field)
            }
        }

        impl From<$fields> for SystemVariable {
            fn from(field: $fields) -> SystemVariable {
                SystemVariable { field: field.into(), part: 0 }
            }
        }
    };
}

pub(super) use members;
