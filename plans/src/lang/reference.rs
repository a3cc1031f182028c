//! `$name`: values of rows, sweeps and parameters put into the plan's fields.

use std::borrow::Cow;
use std::ops::Range;

use document::{Data, Diagnostic, Entry, Findings, Node, Table, ValueOrigin, suggest};

use super::words::id_length;
use crate::codes;

/// Longest text that a row, sweep or parameter may give, in bytes: bounds what references multiply.
pub const MAX_VALUE_BYTES: usize = 256;
/// Longest text that may come of putting references into it, in bytes.
const MAX_TEXT_BYTES: usize = 4096;

/// Name, value, and where the value stands (`None`: it came from the command line).
type Binding<'a> = (&'a str, Cow<'a, Node>, Option<Range<usize>>);

/// The values of one case, by name.
#[derive(Clone, Debug, Default)]
pub struct Bindings<'a> {
    values: Vec<Binding<'a>>,
    /// Row of the case with its place, for messages.
    row: Option<(&'a str, Range<usize>)>,
}

impl<'a> Bindings<'a> {
    /// No values, for a case of this row.
    pub fn of_row(row: Option<(&'a str, Range<usize>)>) -> Self {
        Bindings { values: Vec::new(), row }
    }

    /// Adds a value.
    pub fn add(&mut self, name: &'a str, value: Cow<'a, Node>, place: Option<Range<usize>>) {
        self.values.push((name, value, place));
    }

    /// Adds all of `others` after: those that are here already go before them.
    pub fn append(&mut self, others: &Bindings<'a>) {
        self.values.extend(others.values.iter().cloned());
        if self.row.is_none() {
            self.row.clone_from(&others.row);
        }
    }

    /// The names with their values, in the order added.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Node)> {
        self.values.iter().map(|(name, value, _)| (*name, value.as_ref()))
    }

    fn get(&self, name: &str) -> Option<(&Node, &Option<Range<usize>>)> {
        self.values.iter().find(|(known, ..)| *known == name).map(|(_, value, place)| (value.as_ref(), place))
    }
}

/// The value with every reference replaced; borrowed where there is none. A reference that is the whole text
/// takes the type of its value, one inside a text its text. `$$` writes a `$`.
///
/// What cannot be replaced is reported and stays.
pub fn substitute<'n>(node: &'n Node, bindings: &Bindings<'_>, out: &mut Findings) -> Cow<'n, Node> {
    if !has_reference(node) {
        return Cow::Borrowed(node);
    }
    let data = match &node.data {
        Data::Text(text) => return Cow::Owned(replace(node, text, bindings, out)),
        Data::Array(list) => {
            Data::Array(list.iter().map(|one| substitute(one, bindings, out).into_owned()).collect())
        }
        Data::Table(table) => Data::Table(Table {
            entries: table
                .entries
                .iter()
                .map(|entry| Entry {
                    key: entry.key.clone(),
                    key_span: entry.key_span.clone(),
                    node: substitute(&entry.node, bindings, out).into_owned(),
                })
                .collect(),
        }),
        other => other.clone(),
    };
    Cow::Owned(Node { span: node.span.clone(), data, content: node.content, origin: node.origin.clone() })
}

/// Whether a `$` stands in a text of the value.
pub(crate) fn has_reference(node: &Node) -> bool {
    match &node.data {
        Data::Text(text) => text.contains('$'),
        Data::Array(list) => list.iter().any(has_reference),
        Data::Table(table) => table.entries.iter().any(|entry| has_reference(&entry.node)),
        _ => false,
    }
}

fn replace(node: &Node, text: &str, bindings: &Bindings<'_>, out: &mut Findings) -> Node {
    if let Some(name) = text.strip_prefix('$')
        && !name.is_empty()
        && id_length(name) == name.len()
    {
        return whole(node, name, bindings, out);
    }
    let mut result = String::with_capacity(text.len());
    let mut origin = None;
    let mut at = 0;
    while let Some(dollar) = text[at..].find('$').map(|found| at + found) {
        result.push_str(&text[at..dollar]);
        let rest = &text[dollar + 1..];
        if rest.starts_with('$') {
            result.push('$');
            at = dollar + 2;
            continue;
        }
        let length = id_length(rest);
        at = dollar + 1 + length;
        let name = &rest[..length];
        if length == 0 {
            let help = "write the name of a row's column, sweep or parameter after `$`; write `$$` for a `$`";
            out.bad_inside(
                codes::REFERENCE_FORM,
                node,
                Some(dollar..at),
                "a `$` with no name after it",
                help,
            );
            return node.clone();
        }
        let Some((value, place)) = bindings.get(name) else {
            unknown(node, name, dollar..at, bindings, out);
            return node.clone();
        };
        match &value.data {
            Data::Text(part) | Data::Float(part) | Data::Datetime(part) => result.push_str(part),
            Data::Integer(number) => result.push_str(&number.to_string()),
            Data::Bool(on) => result.push_str(if *on { "true" } else { "false" }),
            Data::Array(_) | Data::Table(_) => {
                let message = format!("`${name}` is {}: it cannot stand inside a text", value.kind());
                out.bad_inside(
                    codes::REFERENCE_FORM,
                    node,
                    Some(dollar..at),
                    message,
                    "let it stand alone, or give it a number or text",
                );
                return node.clone();
            }
        }
        if result.len() > MAX_TEXT_BYTES {
            let message = format!("with its references the text is longer than {MAX_TEXT_BYTES} bytes");
            out.bad(codes::REFERENCE_FORM, node, message, "give the names shorter values");
            return node.clone();
        }
        origin = Some(Box::new(ValueOrigin { name: name.to_owned(), span: place.clone(), whole: false }));
    }
    result.push_str(&text[at..]);
    Node { span: node.span.clone(), data: Data::Text(result), content: None, origin }
}

/// The value of a reference that is the whole text.
fn whole(node: &Node, name: &str, bindings: &Bindings<'_>, out: &mut Findings) -> Node {
    match bindings.get(name) {
        Some((value, place)) => Node {
            span: node.span.clone(),
            data: value.data.clone(),
            content: None,
            origin: Some(Box::new(ValueOrigin { name: name.to_owned(), span: place.clone(), whole: true })),
        },
        None => {
            unknown(node, name, 0..name.len() + 1, bindings, out);
            node.clone()
        }
    }
}

fn unknown(node: &Node, name: &str, within: Range<usize>, bindings: &Bindings<'_>, out: &mut Findings) {
    let help = match suggest(name, bindings.iter().map(|(known, _)| known)) {
        Some(meant) => format!("did you mean `${meant}`?"),
        None => "define it in [rows], [sweep] or [parameters]".to_owned(),
    };
    let span = node.inner(within);
    // One row is enough to show it.
    if out.reported(codes::REFERENCE, &span) {
        out.count_again();
        return;
    }
    let mut found = Diagnostic::error(codes::REFERENCE, format!("`${name}` is not defined"))
        .at(out.file().to_owned(), span, "")
        .help(help);
    if let Some((row, place)) = &bindings.row {
        found = found.at(out.file().to_owned(), place.clone(), format!("in the case of row `{row}`"));
    }
    out.push(found);
}
