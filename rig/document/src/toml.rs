//! TOML text to a tree with places, several errors in one run.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::place::floor;
use crate::{Codes, Data, Diagnostic, Entry, Findings, Node, SourceFile, Table, strict};

/// Deepest tree that is handed on.
const MAX_DEPTH: usize = 64;

/// Reads a TOML 1.0 text.
///
/// Tables and lists keep the order of the file. Bounded for any input: see `codes.too_large`.
///
/// # Errors
/// Everything that is wrong with the text as TOML, by place, under `codes.syntax`, `codes.newer_toml` and
/// `codes.too_large`.
pub fn parse(file: &SourceFile, codes: Codes) -> Result<Table, Vec<Diagnostic>> {
    let mut out = Findings::new(file, codes);
    if !strict::check(file, &mut out) {
        return Err(out.into_vec());
    }
    let (root, errors) = DeTable::parse_recoverable(&file.text);
    for error in &errors {
        if out.is_full() {
            break;
        }
        let span = error.span().unwrap_or(0..0);
        let help = hint(&file.text, &span);
        out.error(codes.syntax, span, sentence(error.message()), help);
    }
    let root = table(root.into_inner(), &file.text, 0, &mut out);
    if out.has_errors() { Err(out.into_vec()) } else { Ok(root) }
}

fn table(table: DeTable<'_>, text: &str, depth: usize, out: &mut Findings) -> Table {
    let mut entries: Vec<Entry> = Vec::with_capacity(table.len());
    for (key, value) in table {
        let key_span = key.span();
        entries.push(Entry {
            key: key.into_inner().into_owned(),
            key_span,
            node: node(value, text, depth + 1, out),
        });
    }
    entries.sort_by_key(|entry| entry.key_span.start);
    Table { entries }
}

fn node(value: Spanned<DeValue<'_>>, text: &str, depth: usize, out: &mut Findings) -> Node {
    let span = value.span();
    if depth > MAX_DEPTH {
        if !out.is_full() {
            out.error(out.codes().too_large, span.clone(), "nested too deep", "flatten it");
        }
        return Node::new(span, Data::Bool(false));
    }
    let data = match value.into_inner() {
        DeValue::String(content) => {
            let mut node = Node::new(span.clone(), Data::Text(content.clone().into_owned()));
            node.content = content_start(text, &span, &content);
            return node;
        }
        DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => Data::Integer(number),
            Err(_) if number.radix() == 10 => Data::Float(number.as_str().to_owned()),
            Err(_) => {
                let help = "integers in another base have 64 bits; write a larger number in base ten";
                out.error(out.codes().syntax, span.clone(), "the integer does not fit into 64 bits", help);
                Data::Integer(0)
            }
        },
        DeValue::Float(number) => Data::Float(number.as_str().to_owned()),
        DeValue::Boolean(on) => Data::Bool(on),
        DeValue::Datetime(_) => Data::Datetime(text.get(span.clone()).unwrap_or_default().to_owned()),
        DeValue::Array(list) => {
            Data::Array(list.into_iter().map(|one| node(one, text, depth + 1, out)).collect())
        }
        DeValue::Table(inner) => Data::Table(table(inner, text, depth + 1, out)),
    };
    Node::new(span, data)
}

/// Where a text's content begins in the file, if it stands there as it is.
fn content_start(text: &str, span: &Range<usize>, content: &str) -> Option<usize> {
    let raw = text.get(span.clone())?;
    // A text without quotes is what the parser made of an error.
    if !raw.starts_with(['"', '\'']) {
        return None;
    }
    let quotes = if raw.starts_with("\"\"\"") || raw.starts_with("'''") { 3 } else { 1 };
    let mut start = quotes.min(raw.len());
    if quotes == 3 {
        if raw[start..].starts_with("\r\n") {
            start += 2;
        } else if raw[start..].starts_with('\n') {
            start += 1;
        }
    }
    raw[start..].starts_with(content).then_some(span.start + start)
}

fn sentence(message: &str) -> String {
    format!("not TOML: {}", message.trim_end_matches('.'))
}

/// The fix for what people commonly write in place of a TOML value.
fn hint(text: &str, span: &Range<usize>) -> String {
    let at = floor(text, span.start);
    let line_start = text[..at].rfind('\n').map_or(0, |at| at + 1);
    let line_end = text[at..].find('\n').map_or(text.len(), |end| at + end);
    let line = &text[line_start..line_end];
    // The value around the place: after the last `=` before it, up to the mark that ends it.
    let value_start = line[..at - line_start].rfind('=').map_or(0, |at| at + 1);
    let rest = line[value_start..].trim_start();
    let value = rest.split([',', '}', ']', '#', '=']).next().unwrap_or_default().trim();
    let first = value.chars().next();
    if value.is_empty() {
        return String::new();
    }
    match value {
        "TRUE" | "True" | "FALSE" | "False" => return format!("write {}", value.to_lowercase()),
        _ => {}
    }
    let plain = value.len() <= 60 && !value.contains(['"', '\'', '{', '[']);
    match first {
        Some(c) if plain && value_start > 0 && (c.is_ascii_digit() || c == '-' || c == '+' || c == '.') => {
            format!("a number with a unit is a text: write \"{value}\"")
        }
        Some(c) if plain && value_start > 0 && (c.is_alphabetic() || c == '%' || c == '$') => {
            format!("a text needs quotes: write \"{value}\"")
        }
        _ => String::new(),
    }
}
