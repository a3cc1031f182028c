//! The page of the modes of analogue channels.

use document::{Data, Fields, Findings, KeySpec, KeyType, Node, Table, check_value};
use profile::{AnalogueMode, ModuleFamily};
use signal::{Decimal, Unit};

use crate::source::{self, SOURCE};

/// The keys of a mode.
const MODE_KEYS: &[KeySpec] = &[
    KeySpec::optional("group", KeyType::Text, "The name that stands for several modes."),
    KeySpec::required("unit", KeyType::Text, "What the channel carries."),
    KeySpec::optional("low", KeyType::Number, "The value of the channel's Minimum."),
    KeySpec::optional("high", KeyType::Number, "The value of the channel's Maximum."),
    KeySpec::optional("under-range", KeyType::Number, "From this value down the channel is under range."),
    KeySpec::optional("over-range", KeyType::Number, "From this value up the channel is over range."),
    KeySpec::optional("step", KeyType::Number, "What one count is."),
    KeySpec::optional("extended", KeyType::Bool, "Whether it is an extended range."),
    KeySpec::optional("source", SOURCE, "Where figures are from that no document has."),
];

/// A mode of a family, with the group that it may be named by.
struct FamilyMode {
    family: ModuleFamily,
    group: Option<String>,
    mode: AnalogueMode,
}

/// Every mode of every family.
pub(crate) struct Modes(Vec<FamilyMode>);

impl Modes {
    /// Reads the page.
    pub(crate) fn read(page: &Table, out: &mut Findings) -> Modes {
        let mut modes = Vec::new();
        for entry in &page.entries {
            let Some(family) = ModuleFamily::ALL.into_iter().find(|family| family.name() == entry.key) else {
                let message = format!("`{}` is no family of modules", entry.key);
                out.error(out.codes().unknown_key, entry.key_span.clone(), message, "write TM2, TM3 or TMC4");
                continue;
            };
            if !check_value(&entry.node, &entry.key, &KeyType::Map(&KeyType::Table(MODE_KEYS)), out) {
                continue;
            }
            for one in entry.node.as_table().map_or(&[][..], |table| &table.entries) {
                let Some(table) = one.node.as_table() else { continue };
                let fields = Fields::checked(table, MODE_KEYS);
                let mode = AnalogueMode {
                    name: one.key.clone(),
                    unit: Unit::new(fields.text("unit").unwrap_or_default()),
                    low: fields.get("low").and_then(decimal),
                    high: fields.get("high").and_then(decimal),
                    over_range: fields.get("over-range").and_then(decimal),
                    under_range: fields.get("under-range").and_then(decimal),
                    step: fields.get("step").and_then(decimal),
                    extended: fields.boolean("extended").unwrap_or(false),
                    sources: source::read(fields.get("source"), table, false, out),
                };
                modes.push(FamilyMode { family, group: fields.text("group").map(String::from), mode });
            }
        }
        Modes(modes)
    }

    /// The modes of a family that a list names, each by its name or by that of its group.
    pub(crate) fn named(
        &self,
        family: ModuleFamily,
        names: &[Node],
        out: &mut Findings,
    ) -> Vec<AnalogueMode> {
        let mut found = Vec::new();
        for node in names {
            let name = node.as_text().unwrap_or_default();
            let before = found.len();
            let named = self.0.iter().filter(|one| {
                one.family == family && (one.mode.name == name || one.group.as_deref() == Some(name))
            });
            found.extend(named.map(|one| one.mode.clone()));
            if found.len() == before {
                let message = format!("`{name}` is no mode of {}", family.name());
                out.bad(out.codes().unreadable, node, message, "add it to modes.toml");
            }
        }
        found
    }
}

/// The number as it is written.
fn decimal(node: &Node) -> Option<Decimal> {
    match &node.data {
        Data::Integer(number) => Some(Decimal::from(i128::from(*number))),
        Data::Float(text) => Decimal::split(text).ok().map(|(number, _)| number),
        _ => None,
    }
}
