//! Just enough of XML: elements, their texts, the five entities and numbers.

use super::SourceFault;

/// A piece of a document, in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum XmlEvent<'t> {
    /// The name of the element and its `Name` or `name`.
    Open(&'t str, &'t str),
    Close(&'t str),
    /// Text, with entities replaced.
    Text(String),
    /// A line break between elements, inside a tag or a remark.
    Break,
}

/// Bytes of the longest name of an entity and its semicolon.
const LONGEST_ENTITY: usize = 16;

/// How deep elements may stand inside each other.
const DEPTH: usize = 100;

/// Reads a document and gives its pieces to `take`, each with its place and the characters before it in its line.
pub(super) fn read<'t>(
    text: &'t str,
    mut take: impl FnMut(XmlEvent<'t>, usize) -> Result<(), SourceFault>,
) -> Result<(), SourceFault> {
    let mut open: Vec<&str> = Vec::new();
    let mut at = 0;
    while let Some(rest) = text.get(at..).filter(|rest| !rest.is_empty()) {
        let start = at;
        if let Some(body) = rest.strip_prefix("<![CDATA[") {
            let end = body.find("]]>").ok_or(SourceFault::new(start, "CDATA is not closed"))?;
            take(XmlEvent::Text(body.get(..end).unwrap_or("").to_owned()), start + 9)?;
            at += 9 + end + 3;
        } else if rest.starts_with("<!--") || rest.starts_with("<?") || rest.starts_with("<!") {
            let close = if rest.starts_with("<!--") { "-->" } else { ">" };
            let end = rest.find(close).ok_or(SourceFault::new(start, "a remark is not closed"))?;
            at += end + close.len();
            breaks(text, start, at, &mut take)?;
        } else if let Some(tag) = rest.strip_prefix('<') {
            let end = tag_end(tag).ok_or(SourceFault::new(start, "a tag is not closed"))?;
            let tag = tag.get(..end).unwrap_or("");
            at += end + 2;
            breaks(text, start, at, &mut take)?;
            if let Some(name) = tag.strip_prefix('/') {
                let name = local(name.trim_end());
                if open.pop() != Some(name) {
                    return Err(SourceFault::new(start, "this tag closes nothing"));
                }
                take(XmlEvent::Close(name), start)?;
                continue;
            }
            let (body, empty) = tag.strip_suffix('/').map_or((tag, false), |body| (body, true));
            let name = local(body.split_ascii_whitespace().next().unwrap_or(""));
            take(XmlEvent::Open(name, attribute(body)), start)?;
            if empty {
                take(XmlEvent::Close(name), start)?;
            } else {
                open.push(name);
            }
            if open.len() > DEPTH {
                return Err(SourceFault::new(start, "elements stand too deep inside each other"));
            }
        } else {
            let end = rest.find('<').unwrap_or(rest.len());
            let body = rest.get(..end).unwrap_or("");
            at += end;
            if body.trim().is_empty() {
                breaks(text, start, at, &mut take)?;
            } else {
                take(XmlEvent::Text(unescaped(body)), start)?;
            }
        }
    }
    if open.is_empty() { Ok(()) } else { Err(SourceFault::new(text.len(), "an element is not closed")) }
}

/// Line breaks that belong to no text.
fn breaks<'t>(
    text: &str,
    from: usize,
    to: usize,
    take: &mut impl FnMut(XmlEvent<'t>, usize) -> Result<(), SourceFault>,
) -> Result<(), SourceFault> {
    let skipped = text.get(from..to).unwrap_or("");
    skipped.match_indices('\n').try_for_each(|(at, _)| take(XmlEvent::Break, from + at))
}

/// Where `>` closes a tag, past what stands in quotes.
fn tag_end(tag: &str) -> Option<usize> {
    let mut quote = None;
    for (at, byte) in tag.bytes().enumerate() {
        match quote {
            Some(open) if byte == open => quote = None,
            Some(_) => {}
            None if byte == b'"' || byte == b'\'' => quote = Some(byte),
            None if byte == b'>' => return Some(at),
            None => {}
        }
    }
    None
}

/// A name without the short form of its name space.
fn local(name: &str) -> &str {
    name.rsplit(':').next().unwrap_or(name)
}

/// The value of `Name` in a tag.
fn attribute(tag: &str) -> &str {
    let value = |key: &str| {
        let (before, after) = tag.split_once(key)?;
        before.ends_with(char::is_whitespace).then_some(())?;
        let quote = after.chars().next()?;
        after.get(1..)?.split(quote).next()
    };
    value("Name=").or_else(|| value("name=")).unwrap_or("")
}

/// Entities replaced. One that is not known stays as it is.
fn unescaped(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('&') {
        plain.push_str(before);
        // No entity is longer; a text of `&` alone would be looked through once for each.
        let end = after.bytes().take(LONGEST_ENTITY).position(|byte| byte == b';');
        let known = end.and_then(|end| Some((character(after.get(..end)?)?, after.get(end + 1..)?)));
        rest = match known {
            Some((c, after)) => {
                plain.push(c);
                after
            }
            None => {
                plain.push('&');
                after
            }
        };
    }
    plain.push_str(rest);
    plain
}

fn character(name: &str) -> Option<char> {
    match name {
        "lt" => Some('<'),
        "gt" => Some('>'),
        "amp" => Some('&'),
        "quot" => Some('"'),
        "apos" => Some('\''),
        _ => {
            let number = name.strip_prefix('#')?;
            let code = match number.strip_prefix('x') {
                Some(digits) => u32::from_str_radix(digits, 16),
                None => number.parse(),
            };
            char::from_u32(code.ok()?)
        }
    }
}
