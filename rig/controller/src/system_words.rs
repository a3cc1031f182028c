//! The words of the structures that are written, and the system variables that an application mentions.

use profile::{Profile, SystemField, SystemStructure, SystemVariable};

/// The words of PLC_W, SERIAL_W, ETH_W and TM3_BUS_W.
#[derive(Clone, Debug)]
pub(crate) struct SystemWords(Vec<(SystemVariable, u16)>);

impl Default for SystemWords {
    fn default() -> Self {
        // This profile has every structure that is written.
        let written = SystemVariable::all(Profile::M251_2024).filter(|variable| variable.is_writable());
        SystemWords(written.map(|variable| (variable, 0)).collect())
    }
}

impl SystemWords {
    /// A word; 0 for what is not written.
    pub(crate) fn get(&self, variable: impl Into<SystemVariable>) -> u16 {
        let variable = variable.into();
        self.0.iter().find(|(known, _)| *known == variable).map_or(0, |(_, word)| *word)
    }

    /// Writes a word: what it was.
    pub(crate) fn replace(&mut self, variable: SystemVariable, new: u16) -> u16 {
        let found = self.0.iter_mut().find(|(known, _)| *known == variable);
        found.map_or(new, |(_, word)| std::mem::replace(word, new))
    }

    /// All words are 0.
    pub(crate) fn clear(&mut self) {
        self.0.iter_mut().for_each(|(_, word)| *word = 0);
    }
}

/// A system variable that the application has, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SystemLink {
    /// The member, and the element where its structure is an array.
    pub field: SystemField,
    pub part: u8,
    /// Which two bytes of it, where it is an array of bytes or a text.
    pub word: Option<u16>,
    /// The number of the variable in the application.
    pub number: u32,
}

/// The system variables that the application has, too, by what becomes of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct SystemLinks {
    /// What the controller shows and never changes.
    pub fixed: Vec<SystemLink>,
    /// What the controller shows.
    pub live: Vec<SystemLink>,
    /// What the application writes.
    pub written: Vec<SystemLink>,
}

impl SystemLinks {
    /// The number of a word that the application writes.
    pub(crate) fn written(&self, variable: SystemVariable) -> Option<u32> {
        let is_it = |link: &&SystemLink| (link.field, link.part) == (variable.field, variable.part);
        self.written.iter().find(is_it).map(|link| link.number)
    }

    /// Whether the application has this one.
    pub(crate) fn shows(&self, field: SystemField) -> bool {
        self.live.iter().any(|link| link.field == field)
    }

    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.fixed.clear();
        self.live.clear();
        self.written.clear();
    }
}

/// How the names of the elements of a structure begin: one name for a structure that is no array.
pub(crate) fn element_names(structure: SystemStructure) -> impl Iterator<Item = (u8, String)> {
    let name = structure.name();
    (0..structure.elements().unwrap_or(1)).map(move |element| {
        let whole = match structure.elements() {
            Some(_) => format!("{name}[{element}]"),
            None => name.to_owned(),
        };
        (element as u8, whole)
    })
}
