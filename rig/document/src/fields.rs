//! Typed access to a table that was held against its table of keys.

use std::ops::Range;

use signal::Span;

use crate::{Data, Entry, Findings, KeySpec, KeyType, Node, Table, suggest};

/// A table together with which of its keys are right. Whatever is wrong was reported by [`Fields::check`];
/// the accessors give `None` both for a key left out and for a wrong one, and report nothing.
#[derive(Clone, Copy, Debug)]
pub struct Fields<'a> {
    table: &'a Table,
    /// One bit for each of the specs' places: the value is there and right.
    good: u128,
    specs: &'static [KeySpec],
}

impl<'a> Fields<'a> {
    /// Holds `table` against `specs` and reports what is wrong. `place` is where the table stands, for keys
    /// that are missing; `what` names it in messages, as in `step`.
    pub fn check(
        table: &'a Table,
        place: Range<usize>,
        what: &str,
        specs: &'static [KeySpec],
        out: &mut Findings,
    ) -> Self {
        debug_assert!(specs.len() <= 128, "one bit for each key");
        let mut good = 0u128;
        let mut missing: Vec<&str> =
            specs.iter().filter(|spec| spec.required).map(|spec| spec.name).collect();
        for entry in &table.entries {
            match specs.iter().position(|spec| spec.name == entry.key) {
                Some(at) => {
                    missing.retain(|name| *name != entry.key);
                    let what = &entry.key;
                    good |= u128::from(check_value(&entry.node, what, &specs[at].ty, out)) << at;
                }
                None => match specs.iter().find(|spec| !spec.was.is_empty() && spec.was == entry.key) {
                    Some(spec) => {
                        missing.retain(|name| *name != spec.name);
                        let message = format!("`{}` of the {what} is called `{}` now", entry.key, spec.name);
                        let help = match table.entries.iter().any(|other| other.key == spec.name) {
                            true => format!("remove it: `{}` is there, too", spec.name),
                            false => format!("write `{}`; its value stays as it is", spec.name),
                        };
                        out.error(out.codes().unknown_key, entry.key_span.clone(), message, help);
                    }
                    None => unknown_key(entry, what, specs, out),
                },
            }
        }
        for name in missing {
            let message = format!("the {what} has no `{name}`");
            let help = specs.iter().find(|spec| spec.name == name).map_or_else(String::new, |spec| {
                let doc = lower_first(spec.doc.trim_end_matches('.'));
                let example = spec.ty.describe();
                if example.contains("such as") {
                    format!("add `{name}`: {doc}; {example}")
                } else {
                    format!("add `{name}`: {doc}")
                }
            });
            out.error(out.codes().missing_key, place.clone(), message, help);
        }
        Fields { table, good, specs }
    }

    /// The fields of a table that was held against `specs` before and found right, as a part of a larger one.
    /// Reports nothing.
    pub fn checked(table: &'a Table, specs: &'static [KeySpec]) -> Self {
        Fields { table, good: u128::MAX, specs }
    }

    /// The table itself.
    pub fn table(&self) -> &'a Table {
        self.table
    }

    /// Whether the key is written in the table, right or wrong.
    pub fn has(&self, name: &str) -> bool {
        self.table.get(name).is_some()
    }

    /// The value of a key, if it is there and right.
    pub fn get(&self, name: &str) -> Option<&'a Node> {
        let at = self.specs.iter().position(|spec| spec.name == name)?;
        if self.good >> at & 1 == 0 {
            return None;
        }
        self.table.get(name)
    }

    /// The key with its place, if its value is right.
    pub fn entry(&self, name: &str) -> Option<&'a Entry> {
        self.get(name)?;
        self.table.entry(name)
    }

    /// A text.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        self.get(name)?.as_text()
    }

    /// A whole number.
    pub fn integer(&self, name: &str) -> Option<i64> {
        match self.get(name)?.data {
            Data::Integer(number) => Some(number),
            _ => None,
        }
    }

    /// A Boolean.
    pub fn boolean(&self, name: &str) -> Option<bool> {
        match self.get(name)?.data {
            Data::Bool(on) => Some(on),
            _ => None,
        }
    }

    /// A number as a float, for values of signals and physics; never for time.
    pub fn number(&self, name: &str) -> Option<f64> {
        match &self.get(name)?.data {
            Data::Integer(number) => Some(*number as f64),
            Data::Float(text) => text.parse().ok(),
            _ => None,
        }
    }

    /// A duration.
    pub fn duration(&self, name: &str) -> Option<Span> {
        Span::parse(self.text(name)?).ok()
    }

    /// The values of a list, or the one value that stands in its place; empty when the key is left out.
    pub fn each(&self, name: &str) -> &'a [Node] {
        match self.get(name) {
            Some(Node { data: Data::Array(list), .. }) => list,
            Some(one) => std::slice::from_ref(one),
            None => &[],
        }
    }

    /// A table within, by the keys that its [`KeyType::Table`] names. Reports nothing: it was checked.
    pub fn inner(&self, name: &str) -> Option<Fields<'a>> {
        let node = self.get(name)?;
        let spec = self.specs.iter().find(|spec| spec.name == name)?;
        let table = node.as_table()?;
        let specs = table_specs(&spec.ty)?;
        Some(Fields::checked(table, specs))
    }
}

/// The keys that a table of this type has.
fn table_specs(ty: &KeyType) -> Option<&'static [KeySpec]> {
    match ty {
        KeyType::Table(specs) => Some(specs),
        KeyType::OneOrMore(inner) => table_specs(inner),
        KeyType::Either(types) => types.iter().find_map(table_specs),
        _ => None,
    }
}

fn unknown_key(entry: &Entry, what: &str, specs: &[KeySpec], out: &mut Findings) {
    let message = format!("`{}` is not a key of the {what}", entry.key);
    // Looking for what was meant takes time; what is not kept needs none.
    let names = specs.iter().map(|spec| spec.name).take(if out.is_full() { 0 } else { usize::MAX });
    let help = match suggest(&entry.key, names) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => {
            let names: Vec<&str> = specs.iter().map(|spec| spec.name).collect();
            format!("its keys are {}", names.join(", "))
        }
    };
    out.error(out.codes().unknown_key, entry.key_span.clone(), message, help);
}

/// Checks one value against a type; `what` is its key. `true` if it is right, else everything wrong with it was
/// reported.
pub fn check_value(node: &Node, what: &str, ty: &KeyType, out: &mut Findings) -> bool {
    match (ty, &node.data) {
        (KeyType::Any, _)
        | (KeyType::Text, Data::Text(_))
        | (KeyType::Bool, Data::Bool(_))
        | (KeyType::Number | KeyType::Quantity | KeyType::Range | KeyType::Value, Data::Integer(_))
        | (KeyType::Value, Data::Bool(_)) => true,
        (KeyType::Number | KeyType::Quantity | KeyType::Range | KeyType::Value, Data::Float(text)) => {
            finite(node, text, out)
        }
        (
            KeyType::Anchor | KeyType::SignalRef | KeyType::Quantity | KeyType::Range | KeyType::Value,
            Data::Text(text),
        ) => not_empty(node, what, text, ty, out),
        // A signal may be a table such as { image = "%IX0.0" }; which, its reader knows.
        (KeyType::SignalRef, Data::Table(_)) => true,
        (KeyType::Integer(min, max), Data::Integer(number)) => {
            let fits = (*min..=*max).contains(number);
            if !fits {
                let message = format!("`{what}` is {number}; expected {}", ty.describe());
                out.bad(out.codes().unreadable, node, message, format!("write {}", ty.example()));
            }
            fits
        }
        (KeyType::Duration, Data::Text(text)) => duration(node, what, text, out),
        (KeyType::Choice(words), Data::Text(text)) => choice(node, what, text, words, out),
        (KeyType::List(inner), Data::Array(list)) => each(list, what, inner, out),
        (KeyType::OneOrMore(inner), Data::Array(list)) if !list.is_empty() => each(list, what, inner, out),
        (KeyType::OneOrMore(inner), data) if !matches!(data, Data::Array(_)) => {
            check_value(node, what, inner, out)
        }
        (KeyType::Table(specs), Data::Table(table)) => {
            let before = out.errors();
            Fields::check(table, node.span.clone(), &format!("table `{what}`"), specs, out);
            out.errors() == before
        }
        (KeyType::Map(inner), Data::Table(table)) => {
            let mut right = true;
            for entry in &table.entries {
                right &= check_value(&entry.node, &entry.key, inner, out);
            }
            right
        }
        (KeyType::Either(types), data) => match types.iter().find(|ty| takes(ty, data)) {
            Some(ty) => check_value(node, what, ty, out),
            None => wrong_type(node, what, ty, out),
        },
        _ => wrong_type(node, what, ty, out),
    }
}

fn each(list: &[Node], what: &str, inner: &KeyType, out: &mut Findings) -> bool {
    let mut right = true;
    for one in list {
        right &= check_value(one, what, inner, out);
    }
    right
}

/// Whether a value of this TOML type can be of the key's type at all: picks the branch of an `Either`.
fn takes(ty: &KeyType, data: &Data) -> bool {
    match ty {
        KeyType::Any => true,
        KeyType::Text | KeyType::Duration | KeyType::Anchor | KeyType::Choice(_) => {
            matches!(data, Data::Text(_))
        }
        KeyType::SignalRef => matches!(data, Data::Text(_) | Data::Table(_)),
        KeyType::Bool => matches!(data, Data::Bool(_)),
        KeyType::Integer(..) => matches!(data, Data::Integer(_)),
        KeyType::Number => matches!(data, Data::Integer(_) | Data::Float(_)),
        KeyType::Quantity | KeyType::Range => {
            matches!(data, Data::Integer(_) | Data::Float(_) | Data::Text(_))
        }
        KeyType::Value => matches!(data, Data::Integer(_) | Data::Float(_) | Data::Text(_) | Data::Bool(_)),
        KeyType::List(_) => matches!(data, Data::Array(_)),
        KeyType::OneOrMore(inner) => matches!(data, Data::Array(_)) || takes(inner, data),
        KeyType::Table(_) | KeyType::Map(_) => matches!(data, Data::Table(_)),
        KeyType::Either(types) => types.iter().any(|ty| takes(ty, data)),
    }
}

fn finite(node: &Node, text: &str, out: &mut Findings) -> bool {
    let right = text.parse::<f64>().is_ok_and(f64::is_finite);
    if !right {
        let help = "nan, inf and numbers beyond 1e308 cannot be compared with anything";
        out.bad(out.codes().wrong_type, node, format!("`{text}` is no finite number"), help);
    }
    right
}

fn not_empty(node: &Node, what: &str, text: &str, ty: &KeyType, out: &mut Findings) -> bool {
    // A value may be the empty text; a name, an instant or a range may not.
    let right = matches!(ty, KeyType::Value) || !text.trim().is_empty();
    if !right {
        let message = format!("`{what}` is empty; expected {}", ty.describe());
        out.bad(out.codes().unreadable, node, message, format!("write {}", ty.example()));
    }
    right
}

fn duration(node: &Node, what: &str, text: &str, out: &mut Findings) -> bool {
    match Span::parse(text) {
        Ok(span) if span.is_negative() => {
            let message = format!("`{what}` is a duration below 0");
            out.bad(out.codes().unreadable, node, message, "durations count forwards: remove the minus sign");
            false
        }
        Ok(_) => true,
        Err(error) => {
            let at = error.at;
            let end = text[at..].find(char::is_whitespace).map_or(text.len(), |end| at + end);
            let help = format!("write {}", KeyType::Duration.describe());
            out.bad_inside(
                out.codes().unreadable,
                node,
                Some(at..end.max(at)),
                format!("`{what}` does not read as a duration: {error}"),
                help,
            );
            false
        }
    }
}

fn choice(node: &Node, what: &str, text: &str, words: &[&'static str], out: &mut Findings) -> bool {
    if words.contains(&text) {
        return true;
    }
    let shown: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    let help = match suggest(text, words.iter().copied()) {
        Some(meant) => format!("did you mean \"{meant}\"?"),
        None => format!("`{what}` is one of {}", shown.join(", ")),
    };
    out.bad(out.codes().unreadable, node, format!("`{what}` cannot be \"{text}\""), help);
    false
}

fn wrong_type(node: &Node, what: &str, ty: &KeyType, out: &mut Findings) -> bool {
    let help = match &node.data {
        Data::Datetime(text) if matches!(ty, KeyType::Anchor) => {
            format!("{text} is a TOML date or time: count from `start`, as in \"start + 10 s\"")
        }
        Data::Datetime(text) if matches!(ty, KeyType::Text) => {
            format!("{text} is a TOML date or time: write it between quotes")
        }
        Data::Datetime(text) if takes(ty, &Data::Text(String::new())) => {
            format!("{text} is a TOML date or time, not a duration: write \"10 s\"")
        }
        Data::Text(_) | Data::Integer(_) if matches!(ty, KeyType::List(_)) => "put it between [ and ]".into(),
        Data::Float(text) if matches!(ty, KeyType::Integer(..)) && text.contains(['.', 'e', 'E', 'n']) => {
            format!("{text} is a float because of its point or exponent: write the digits, as in 1000")
        }
        Data::Integer(number) if matches!(ty, KeyType::Duration) => {
            format!("a duration is a text with a unit: write \"{number} ms\" or \"{number} s\"")
        }
        Data::Float(number) if matches!(ty, KeyType::Duration) => {
            format!("a duration is a text with a unit, so that it is exact: write \"{number} s\"")
        }
        Data::Integer(0 | 1) if matches!(ty, KeyType::Bool) => "write true or false".into(),
        Data::Text(text) if matches!(ty, KeyType::Bool) && matches!(text.as_str(), "true" | "false") => {
            format!("write {text} without quotes")
        }
        Data::Text(text) if matches!(ty, KeyType::Integer(..)) && text.parse::<i64>().is_ok() => {
            format!("write {text} without quotes")
        }
        Data::Array(list) if list.is_empty() && matches!(ty, KeyType::OneOrMore(_)) => {
            "an empty list says nothing: remove the key".into()
        }
        Data::Integer(number) if matches!(ty, KeyType::Text) => format!("write \"{number}\""),
        Data::Float(text) if matches!(ty, KeyType::Text) => format!("write \"{text}\""),
        Data::Bool(on) if matches!(ty, KeyType::Text) => format!("write \"{on}\""),
        Data::Integer(number) if matches!(ty, KeyType::Anchor) => {
            format!("write \"start + {number} s\", or an instant of a step such as \"press + {number} ms\"")
        }
        _ => format!("write {}", ty.example()),
    };
    let message = format!("`{what}` is {}; expected {}", node.kind(), ty.describe());
    out.bad(out.codes().wrong_type, node, message, help);
    false
}

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_lowercase().chain(chars).collect())
}
