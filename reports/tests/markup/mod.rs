//! A strict reader of the markup that the reports write: tags nest, attributes are quoted, texts are escaped.

/// Elements of HTML without an end tag.
const VOID: [&str; 4] = ["meta", "input", "br", "hr"];

/// An opened element.
#[derive(Debug)]
pub struct Element {
    pub name: String,
    pub attributes: Vec<(String, String)>,
}

/// Reads the text and returns all elements, or says what is wrong near which text.
pub fn read(text: &str) -> Result<Vec<Element>, String> {
    let mut rest = text;
    let (mut open, mut all): (Vec<String>, Vec<Element>) = (Vec::new(), Vec::new());
    if let Some(bad) = text.chars().find(|c| c.is_control() && *c != '\n') {
        return Err(format!("control character {bad:?}"));
    }
    while let Some(at) = rest.find('<') {
        if rest[..at].contains('>') {
            return Err(format!("a bare > before {:.60}", &rest[at..]));
        }
        rest = &rest[at..];
        let near = rest.chars().take(120).collect::<String>();
        if let Some(after) = rest.strip_prefix("<!DOCTYPE html>") {
            rest = after;
        } else if rest.starts_with("<?") {
            rest = rest.split_once("?>").ok_or("unclosed declaration")?.1;
        } else if let Some(tag) = rest.strip_prefix("</") {
            let (name, after) = tag.split_once('>').ok_or("unclosed end tag")?;
            if open.pop().as_deref() != Some(name) {
                return Err(format!("unexpected </{name}> near {near}"));
            }
            rest = after;
        } else {
            let (element, closed, after) = start_tag(&rest[1..]).ok_or(format!("bad tag near {near}"))?;
            rest = after;
            let name = element.name.clone();
            if matches!(name.as_str(), "script" | "style") {
                // Raw text up to the end tag.
                rest = &rest[rest.find(&format!("</{name}>")).ok_or("unclosed raw text")?..];
            }
            if !closed && !VOID.contains(&name.as_str()) {
                open.push(name);
            }
            all.push(element);
        }
    }
    if open.is_empty() { Ok(all) } else { Err(format!("never closed: {open:?}")) }
}

fn start_tag(text: &str) -> Option<(Element, bool, &str)> {
    let end = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '-')?;
    let name = text[..end].to_owned();
    let (mut rest, mut attributes) = (&text[end..], Vec::<(String, String)>::new());
    if name.is_empty() {
        return None;
    }
    loop {
        let trimmed = rest.trim_start();
        if let Some(after) = trimmed.strip_prefix("/>") {
            return Some((Element { name, attributes }, true, after));
        }
        if let Some(after) = trimmed.strip_prefix('>') {
            return Some((Element { name, attributes }, false, after));
        }
        // Attributes stand apart from each other.
        if trimmed.len() == rest.len() {
            return None;
        }
        let end = trimmed.find(|c: char| !c.is_ascii_alphanumeric() && !"-_:.".contains(c))?;
        let key = trimmed[..end].to_owned();
        if key.is_empty() || attributes.iter().any(|(other, _)| *other == key) {
            return None;
        }
        rest = &trimmed[end..];
        let mut value = String::new();
        if let Some(after) = rest.strip_prefix("=\"") {
            let (inside, after) = after.split_once('"')?;
            if inside.contains('<') {
                return None;
            }
            (value, rest) = (inside.to_owned(), after);
        }
        attributes.push((key, value));
    }
}

impl Element {
    /// The attribute of this name.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.attributes.iter().find(|(k, _)| k == key).map(|(_, value)| value.as_str())
    }
}
