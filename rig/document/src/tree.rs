//! The tree of a TOML file with the place of every key and value.

use std::ops::Range;

/// Where a value came from when a reference stood in its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValueOrigin {
    /// Name of the reference, without `$`.
    pub name: String,
    /// Where the value is written in the same file, `None` when it came from the command line.
    pub span: Option<Range<usize>>,
    /// Whether the reference is the whole of the value; if it is only a part of a text, places inside the
    /// text cannot be told apart.
    pub whole: bool,
}

/// A value with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Bytes of the file, quotes and brackets included.
    pub span: Range<usize>,
    /// What it is.
    pub data: Data,
    /// Byte of the file at which a text's content begins, where the content is in the file as it is (no
    /// escapes, no substitution).
    pub content: Option<usize>,
    /// Where the value came from, if a reference stood here.
    pub origin: Option<Box<ValueOrigin>>,
}

/// What a value is.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// A text.
    Text(String),
    /// A whole number of 64 bits.
    Integer(i64),
    /// A number with a point or an exponent, or a whole one of more than 64 bits, as written, without `_`.
    Float(String),
    /// `true` or `false`.
    Bool(bool),
    /// A date or a time, as written.
    Datetime(String),
    /// A list.
    Array(Vec<Node>),
    /// A table.
    Table(Table),
}

/// A table in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The keys with their values, in the order of the file.
    pub entries: Vec<Entry>,
}

/// A key with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The key without quotes.
    pub key: String,
    /// Bytes of the key.
    pub key_span: Range<usize>,
    /// The value.
    pub node: Node,
}

impl Table {
    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entry(key).map(|entry| &entry.node)
    }

    /// Moves every place in it by this many bytes: the table of a file that is read after others.
    pub fn shift(&mut self, by: usize) {
        let moved = |span: &Range<usize>| span.start + by..span.end + by;
        for entry in &mut self.entries {
            entry.key_span = moved(&entry.key_span);
            entry.node.shift(by);
        }
    }

    /// A key with its value.
    pub fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }
}

impl Node {
    /// A value of the given place.
    pub fn new(span: Range<usize>, data: Data) -> Self {
        Node { span, data, content: None, origin: None }
    }

    /// Moves every place in it by this many bytes.
    pub fn shift(&mut self, by: usize) {
        self.span = self.span.start + by..self.span.end + by;
        self.content = self.content.map(|start| start + by);
        match &mut self.data {
            Data::Array(list) => list.iter_mut().for_each(|one| one.shift(by)),
            Data::Table(table) => table.shift(by),
            _ => {}
        }
    }

    /// The text, if it is one.
    pub fn as_text(&self) -> Option<&str> {
        match &self.data {
            Data::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The list, if it is one.
    pub fn as_array(&self) -> Option<&[Node]> {
        match &self.data {
            Data::Array(list) => Some(list),
            _ => None,
        }
    }

    /// The table, if it is one.
    pub fn as_table(&self) -> Option<&Table> {
        match &self.data {
            Data::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The bytes of the file after `within` of the text's content; the whole value where that cannot be told.
    pub fn inner(&self, within: Range<usize>) -> Range<usize> {
        match self.content {
            Some(start) if start + within.end <= self.span.end => start + within.start..start + within.end,
            _ => self.span.clone(),
        }
    }

    /// What it is, with its article: `a text`, `an integer`.
    pub fn kind(&self) -> &'static str {
        match self.data {
            Data::Text(_) => "a text",
            Data::Integer(_) => "an integer",
            Data::Float(ref text) if text.contains(['.', 'e', 'E', 'n']) => "a float",
            Data::Float(_) => "an integer of more than 64 bits",
            Data::Bool(_) => "a Boolean",
            Data::Datetime(_) => "a TOML date or time",
            Data::Array(_) => "a list",
            Data::Table(_) => "a table",
        }
    }
}
