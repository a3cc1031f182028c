//! Plants: what the controller's outputs act on and its inputs come from. A kind of plant is a file with its keys, its
//! reader and its law, and a line in `KINDS`.

mod conveyor;
mod cylinder;
mod dead_time;
mod decimals;
mod drive;
mod heater;
mod lag;
mod motor;
mod position;
mod program;
mod reader;
mod sampled;
mod second_order;
mod switches;
mod tank;
mod transmitter;
mod travel;
mod valve;

use std::sync::Arc;

use document::{Fields, Findings, KeySpec, KeyType, Node};

use crate::circuit::PlantSpec;
use crate::codes;

pub use lag::{LagSpec, LagTarget};
pub(crate) use reader::{ChannelNames, PlantReader};
pub use switches::SwitchSpec;

/// A kind of plant, as board files have it.
#[derive(Debug)]
pub(crate) struct PlantKind {
    /// Its word.
    pub(crate) name: &'static str,
    /// Its keys besides `kind` and `name`. One that several kinds have means the same in all of them.
    pub(crate) keys: &'static [KeySpec],
    /// Makes the description of a table that was held against the keys. `None` after it reported what is wrong.
    pub(crate) read: fn(&mut PlantReader<'_, '_>) -> Option<Arc<dyn PlantSpec>>,
}

/// Every kind of plant, in alphabetical order.
const KINDS: &[PlantKind] = &[
    conveyor::KIND,
    cylinder::KIND,
    dead_time::KIND,
    heater::KIND,
    lag::KIND,
    motor::KIND,
    program::KIND,
    second_order::KIND,
    tank::KIND,
    transmitter::KIND,
    valve::KIND,
];

const NAMES: [&str; KINDS.len()] = {
    let mut names = [""; KINDS.len()];
    let mut at = 0;
    while at < KINDS.len() {
        names[at] = KINDS[at].name;
        at += 1;
    }
    names
};

const KIND: KeySpec = KeySpec::required("kind", KeyType::Choice(&NAMES), "What it is");
const NAME: KeySpec = KeySpec::required("name", KeyType::Text, "Its name");

/// The keys of every kind of plant together: those that a board file may have.
pub(crate) const KEYS: &[KeySpec] = {
    const ALL: ([KeySpec; MOST], usize) = all_keys();
    const LIST: [KeySpec; ALL.1] = {
        let mut list = [KIND; ALL.1];
        let mut at = 0;
        while at < ALL.1 {
            list[at] = ALL.0[at];
            at += 1;
        }
        list
    };
    &LIST
};

/// The most keys of all kinds together: as many as [`Fields`] can have.
const MOST: usize = 128;

const fn all_keys() -> ([KeySpec; MOST], usize) {
    let mut list = [KIND; MOST];
    list[1] = NAME;
    let mut count = 2;
    let mut kind = 0;
    while kind < KINDS.len() {
        let mut at = 0;
        while at < KINDS[kind].keys.len() {
            let key = KINDS[kind].keys[at];
            if !has(&list, count, key.name) {
                // Which are missing depends on the kind.
                list[count] = KeySpec { required: false, ..key };
                count += 1;
            }
            at += 1;
        }
        kind += 1;
    }
    (list, count)
}

const fn has(list: &[KeySpec], count: usize, name: &str) -> bool {
    let mut at = 0;
    while at < count {
        if same(list[at].name.as_bytes(), name.as_bytes()) {
            return true;
        }
        at += 1;
    }
    false
}

const fn same(one: &[u8], other: &[u8]) -> bool {
    if one.len() != other.len() {
        return false;
    }
    let mut at = 0;
    while at < one.len() {
        if one[at] != other[at] {
            return false;
        }
        at += 1;
    }
    true
}

/// The plant of a table that was held against [`KEYS`]. `None` after what is wrong was reported.
pub(crate) fn read(node: &Node, names: &dyn ChannelNames, out: &mut Findings) -> Option<Arc<dyn PlantSpec>> {
    let table = node.as_table()?;
    let fields = Fields::checked(table, KEYS);
    let kind = KINDS.iter().find(|kind| Some(kind.name) == fields.text("kind"))?;
    let before = out.errors();
    let own = |name: &str| kind.keys.iter().chain([&KIND, &NAME]).any(|key| key.name == name);
    for entry in table.entries.iter().filter(|entry| !own(&entry.key)) {
        let with: Vec<String> = KINDS
            .iter()
            .filter(|kind| kind.keys.iter().any(|key| key.name == entry.key))
            .map(|kind| format!("\"{}\"", kind.name))
            .collect();
        let message = format!("a plant of kind \"{}\" has no `{}`", kind.name, entry.key);
        let help = format!("remove it; kinds that have it: {}", with.join(", "));
        out.error(codes::PLANT_KEY, entry.key_span.clone(), message, help);
    }
    for key in kind.keys.iter().filter(|key| key.required && !fields.has(key.name)) {
        let message = format!("a plant of kind \"{}\" needs `{}`", kind.name, key.name);
        let help = format!("add `{} = ...`: {}", key.name, key.doc);
        out.error(codes::MISSING_KEY, node.span.clone(), message, help);
    }
    if out.errors() > before {
        return None;
    }
    let spec = (kind.read)(&mut PlantReader::new(fields, node, names, out))?;
    (out.errors() == before).then_some(spec)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_in_order_and_keys_mean_one_thing() {
        assert!(KINDS.windows(2).all(|pair| pair[0].name < pair[1].name));
        for key in KINDS.iter().flat_map(|kind| kind.keys) {
            let first = KEYS.iter().find(|known| known.name == key.name).unwrap();
            assert_eq!(*first, KeySpec { required: false, ..*key });
        }
    }
}
