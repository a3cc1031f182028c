//! The tables of keys: the one description of a format that its reader checks by and its schema is made from.

/// A key of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeySpec {
    /// The key as written.
    pub name: &'static str,
    /// What its value is.
    pub ty: KeyType,
    /// Whether the table is wrong without it.
    pub required: bool,
    /// What it means, one sentence, for the schema and the manual.
    pub doc: &'static str,
    /// What it was called in an earlier version; empty where it has had one name.
    pub was: &'static str,
}

impl KeySpec {
    /// A key that must be there.
    pub const fn required(name: &'static str, ty: KeyType, doc: &'static str) -> Self {
        KeySpec { name, ty, required: true, doc, was: "" }
    }

    /// A key that may be left out.
    pub const fn optional(name: &'static str, ty: KeyType, doc: &'static str) -> Self {
        KeySpec { name, ty, required: false, doc, was: "" }
    }

    /// The key with the name that it had in an earlier version. The finding about that name gives the new one.
    #[must_use]
    pub const fn was(self, was: &'static str) -> Self {
        KeySpec { was, ..self }
    }
}

/// What a value is. The small languages inside texts have one grammar each: durations and quantities are
/// checked here, anchors and signals by the reader that knows them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyType {
    /// Any text.
    Text,
    /// `true` or `false`.
    Bool,
    /// A whole number within these limits, both included.
    Integer(i64, i64),
    /// An integer or a finite float.
    Number,
    /// A text with a duration of at least 0, as in `"10 ms"`.
    Duration,
    /// A number, or a text with a number and its unit, as in `"200 kHz"`.
    Quantity,
    /// A text with a range, as in `"100 ms .. 100.3 ms"`, or a number or quantity for a single point.
    Range,
    /// A text with an instant, as in `"start + 1 s"`; its grammar belongs to the plans.
    Anchor,
    /// A text that names a signal, or a table that does, as in `{ image = "%IX0.0" }`.
    SignalRef,
    /// A value of a signal: Boolean, number, or a text with a state, a bit string or a quantity.
    Value,
    /// A text out of these.
    Choice(&'static [&'static str]),
    /// A list of values, none excluded.
    List(&'static KeyType),
    /// A value, or a list of at least one.
    OneOrMore(&'static KeyType),
    /// A table with these keys and no others.
    Table(&'static [KeySpec]),
    /// A table with free keys, all values of one type.
    Map(&'static KeyType),
    /// A value of one of these types.
    Either(&'static [KeyType]),
    /// Anything; its reader checks it.
    Any,
}

impl KeyType {
    /// What to write for such a value, with an example: fits after `write`.
    pub fn example(&self) -> String {
        match self {
            KeyType::Text => "a text in quotes, as in \"...\"".into(),
            KeyType::SignalRef => "the name of a signal in quotes, as in \"lamp\" or \"%IX0.0\"".into(),
            KeyType::Integer(min, max) => {
                format!("{} without quotes, such as {}", self.describe(), 1.clamp(*min, *max))
            }
            KeyType::Number => "a number without quotes, such as 1.5".into(),
            KeyType::List(inner) => format!("[ ... ], each entry {}", inner.example()),
            KeyType::OneOrMore(inner) => inner.example(),
            KeyType::Table(keys) => {
                let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
                format!("{}; its keys are {}", self.describe(), names.join(", "))
            }
            KeyType::Map(_) => format!("{}, as in {{ name = ... }}", self.describe()),
            KeyType::Either(types) => {
                let all: Vec<String> = types.iter().map(KeyType::example).collect();
                all.join(", or ")
            }
            _ => self.describe(),
        }
    }

    /// What is expected, with an example: fits after `expected`.
    pub fn describe(&self) -> String {
        match self {
            KeyType::Text => "a text in quotes".into(),
            KeyType::Bool => "true or false".into(),
            KeyType::Integer(i64::MIN, i64::MAX) => "an integer".into(),
            KeyType::Integer(min, i64::MAX) => format!("an integer of at least {min}"),
            KeyType::Integer(min, max) => format!("an integer from {min} to {max}"),
            KeyType::Number => "a number".into(),
            KeyType::Duration => "a duration such as \"10 ms\"".into(),
            KeyType::Quantity => "a number, or a quantity such as \"200 kHz\"".into(),
            KeyType::Range => "a range such as \"100 ms .. 100.3 ms\"".into(),
            KeyType::Anchor => "an instant such as \"start + 1 s\"".into(),
            KeyType::SignalRef => "the name of a signal".into(),
            KeyType::Value => {
                "a value: true, false, a number, or a text such as \"RUNNING\" or \"16#0010\"".into()
            }
            KeyType::Choice(words) => {
                let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                format!("one of {}", words.join(", "))
            }
            KeyType::List(inner) => format!("a list, each entry {}", inner.describe()),
            KeyType::OneOrMore(inner) => format!("{}, or a list of such", inner.describe()),
            KeyType::Table(keys) => {
                let shown: Vec<&str> = keys.iter().filter(|key| key.required).map(|key| key.name).collect();
                let example = shown.iter().map(|name| format!("{name} = ...")).collect::<Vec<_>>().join(", ");
                if example.is_empty() { "a table { ... }".into() } else { format!("a table {{ {example} }}") }
            }
            KeyType::Map(inner) => format!("a table of names, each value {}", inner.describe()),
            KeyType::Either(types) => {
                let all: Vec<String> = types.iter().map(KeyType::describe).collect();
                all.join(", or ")
            }
            KeyType::Any => "a value".into(),
        }
    }
}
