//! XML text: elements with attributes and texts, escaped.

use std::fmt::Write;

/// An element being written.
#[derive(Debug, Default)]
pub(super) struct Xml {
    out: String,
}

impl Xml {
    /// Opens an element at a depth. It is closed by [`Xml::close`] with the same name and depth.
    pub(super) fn open(&mut self, depth: usize, name: &str, attributes: &[(&str, &str)]) {
        self.begin(depth, name, attributes);
        self.out.push_str(">\n");
    }

    /// An element without content.
    pub(super) fn empty(&mut self, depth: usize, name: &str, attributes: &[(&str, &str)]) {
        self.begin(depth, name, attributes);
        self.out.push_str("/>\n");
    }

    /// An element with nothing but text.
    pub(super) fn text(&mut self, depth: usize, name: &str, attributes: &[(&str, &str)], text: &str) {
        self.begin(depth, name, attributes);
        self.out.push('>');
        escape(&mut self.out, text, false);
        // Writing to a String cannot fail.
        let _ = writeln!(self.out, "</{name}>");
    }

    /// Closes an element.
    pub(super) fn close(&mut self, depth: usize, name: &str) {
        let _ = writeln!(self.out, "{:1$}</{name}>", "", 4 * depth);
    }

    /// Appends what was written elsewhere.
    pub(super) fn append(&mut self, other: &Xml) {
        self.out.push_str(&other.out);
    }

    /// How much was written, bytes.
    pub(super) fn len(&self) -> usize {
        self.out.len()
    }

    /// The whole as a file.
    pub(super) fn file(self) -> String {
        format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}", self.out)
    }

    fn begin(&mut self, depth: usize, name: &str, attributes: &[(&str, &str)]) {
        let _ = write!(self.out, "{:1$}<{name}", "", 4 * depth);
        for (name, value) in attributes {
            let _ = write!(self.out, " {name}=\"");
            escape(&mut self.out, value, true);
            self.out.push('"');
        }
    }
}

/// Appends a text as XML has it. What XML cannot hold at all becomes `�`.
fn escape(out: &mut String, text: &str, attribute: bool) {
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' if attribute => out.push_str("&quot;"),
            // A reader of attributes makes blanks of these, of a text a line feed of a return.
            '\n' | '\t' if attribute => {
                let _ = write!(out, "&#{};", u32::from(c));
            }
            '\n' | '\t' => out.push(c),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
}
