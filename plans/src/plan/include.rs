//! `include`: signals, groups, parameters and settings from other files.
//!
//! The files are gathered before a plan is read, since reading a plan opens nothing; their tables then go into that
//! of the plan.

use std::collections::BTreeMap;

use document::{Data, Diagnostic, Entry, Fields, Findings, Joined, KeyType, Node, SourceFile, Table, toml};

use super::keys::INCLUDED_KEYS;
use super::settings::SETTINGS_KEYS;
use super::variants::Variants;
use super::{groups, uncalled};
use crate::codes;
use crate::frames::can::Databases;
use crate::signals::{self, frames};
use crate::table::ValueTables;

/// Most files that a plan includes, whether itself or through others.
const MOST_FILES: usize = 64;
/// Most bytes of all of them.
const MOST_BYTES: usize = 4 << 20;
/// What the tables of files are joined in, name by name.
const NAMED: &[&str] = &["signals", "frames", "group", "parameters"];
/// The list that is joined.
const INVARIANTS: &str = "invariants";
/// What is joined key by key.
const SETTINGS: &str = "settings";

/// A plan's text with those of the files that it includes.
#[derive(Clone, Debug)]
pub struct PlanText {
    /// All of them.
    pub(super) joined: Joined,
    /// The table of the plan itself.
    pub(super) root: Table,
    /// Those of the others, in the order in which they are included.
    others: Vec<Table>,
    /// The tables of values that they name.
    pub(super) tables: ValueTables,
    /// The DBC files that they name.
    pub(super) databases: Databases,
}

/// A path beside another file, without `.` and `..` where they can be resolved.
fn beside(file: &str, path: &str) -> String {
    let whole = match file.rfind('/') {
        Some(at) if !path.starts_with('/') => format!("{}/{path}", &file[..at]),
        _ => path.to_owned(),
    };
    let mut parts: Vec<&str> = Vec::new();
    for (place, part) in whole.split('/').enumerate() {
        match part {
            "." => {}
            "" if place > 0 => {}
            ".." if parts.last().is_some_and(|last| !matches!(*last, ".." | "")) => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// Reads the files that a plan includes, and the tables of values that it names. `open` gives the text of a path beside
/// the plan.
///
/// # Errors
/// Findings in the plan's TOML and that of the files, files that cannot be read or include each other.
pub fn gather(
    file: &SourceFile,
    open: &mut dyn FnMut(&str) -> Result<String, String>,
) -> Result<PlanText, Vec<Diagnostic>> {
    let root = toml::parse(file, codes::TOML)?;
    let mut gathering = Gathering {
        joined: Joined::new(file.clone()),
        others: Vec::new(),
        paths: BTreeMap::new(),
        open: &mut *open,
    };
    let mut out = Findings::new(file, codes::TOML);
    let own = plain(&file.name);
    gathering.paths.insert(own.clone(), true);
    gathering.follow(&root, &own, &mut out);
    let Gathering { joined, others, open, .. } = gathering;
    if out.has_errors() {
        let mut found = out.into_vec();
        joined.locate(&mut found);
        return Err(found);
    }
    let mut beside_plan = |name: &str| {
        let path = beside(&own, name);
        open(&path).map(|text| SourceFile::new(path, text))
    };
    let roots = || std::iter::once(&root).chain(&others);
    let tables = ValueTables::gather(roots(), &mut beside_plan);
    let databases = Databases::gather(roots(), &mut beside_plan);
    Ok(PlanText { joined, root, others, tables, databases })
}

/// Checks a file that is there to be included, with what it includes itself.
pub fn check_included(
    file: &SourceFile,
    open: &mut dyn FnMut(&str) -> Result<String, String>,
) -> Vec<Diagnostic> {
    let text = match gather(file, open) {
        Ok(text) => text,
        Err(found) => return found,
    };
    let mut out = Findings::new(file, codes::TOML);
    let root = text.merged(&mut out);
    let fields = Fields::check(&root, 0..0, "included file", INCLUDED_KEYS, &mut out);
    if let Some(table) = fields.get("signals").and_then(Node::as_table) {
        signals::read(table, &mut out);
    }
    if let Some(table) = fields.get("frames").and_then(Node::as_table) {
        frames::read(table, &text.databases, &|_| false, &mut out);
    }
    if let Some(node) = fields.get(SETTINGS) {
        document::check_value(node, SETTINGS, &KeyType::Table(SETTINGS_KEYS), &mut out);
    }
    Variants::read(&root, &[], &mut out);
    for group in groups::read(&root, &mut out).iter().flatten() {
        uncalled::check(group, &mut out);
    }
    let mut found = out.into_vec();
    text.joined.locate(&mut found);
    found
}

/// A path without `.` and `..`.
fn plain(path: &str) -> String {
    beside("", path)
}

struct Gathering<'o> {
    joined: Joined,
    others: Vec<Table>,
    /// Every file, and whether it is one of those that lead here.
    paths: BTreeMap<String, bool>,
    open: &'o mut dyn FnMut(&str) -> Result<String, String>,
}

impl Gathering<'_> {
    /// Reads what the file at `path` includes.
    fn follow(&mut self, table: &Table, path: &str, out: &mut Findings) {
        let Some(node) = table.get("include") else { return };
        let list = match &node.data {
            Data::Array(list) => list.as_slice(),
            _ => std::slice::from_ref(node),
        };
        for node in list {
            let Some(name) = node.as_text().filter(|name| !name.trim().is_empty()) else {
                let message = format!("`include` is {}, not the name of a file", node.kind());
                out.bad(codes::WRONG_TYPE, node, message, "write include = [\"common.toml\"]");
                continue;
            };
            let path = beside(path, name);
            match self.paths.get(&path) {
                // Two files may include a third one: it is there once.
                Some(false) => continue,
                Some(true) => {
                    let message = format!("`{name}` includes itself, or a file that includes it");
                    out.bad(codes::INCLUDE, node, message, "let one of the files do without the other");
                    continue;
                }
                None => {}
            }
            if let Some(table) = self.read(&path, node, out) {
                self.paths.insert(path.clone(), true);
                self.follow(&table, &path, out);
                self.paths.insert(path, false);
                self.others.push(table);
            }
        }
    }

    /// The table of an included file. `None` after what is wrong was reported.
    fn read(&mut self, path: &str, node: &Node, out: &mut Findings) -> Option<Table> {
        if self.paths.len() > MOST_FILES {
            let message = format!("a plan includes at most {MOST_FILES} files");
            out.bad(codes::INCLUDE, node, message, "put some of them together");
            return None;
        }
        let text = match (self.open)(path) {
            Ok(text) => text,
            Err(why) => {
                let message = format!("`{path}` cannot be read: {why}");
                out.bad(codes::INCLUDE, node, message, "the path is relative to the file that includes it");
                return None;
            }
        };
        if self.joined.next() + text.len() > MOST_BYTES {
            let message = format!("a plan and what it includes have at most {MOST_BYTES} bytes");
            out.bad(codes::TOO_LARGE, node, message, "include less, or split the plan");
            return None;
        }
        let file = SourceFile::new(path, text);
        let mut table = match toml::parse(&file, codes::TOML) {
            Ok(table) => table,
            Err(found) => {
                found.into_iter().for_each(|one| out.push(one));
                return None;
            }
        };
        let place = self.joined.next();
        self.joined.append(file, &mut table);
        let before = out.errors();
        // That it is missing is reported with the other keys.
        if let Some(Node { data: Data::Integer(format), span, .. }) = table.get("format")
            && *format != 1
        {
            let help = "this rig reads format = 1";
            out.error(codes::FORMAT, span.clone(), "the file's format is not supported", help);
        }
        Fields::check(&table, place..place, "included file", INCLUDED_KEYS, out);
        (out.errors() == before).then_some(table)
    }
}

impl PlanText {
    /// The plan's own file.
    pub fn file(&self) -> &SourceFile {
        self.joined.first()
    }

    /// The files that it includes.
    pub fn included(&self) -> impl Iterator<Item = &SourceFile> {
        self.joined.others()
    }

    /// The same plan under another name.
    #[must_use]
    pub fn named(mut self, name: &str) -> PlanText {
        self.joined.rename_first(name);
        self
    }

    /// The names of its parameters, those of the files that it includes too.
    pub fn parameters(&self) -> Vec<String> {
        let tables = std::iter::once(&self.root).chain(&self.others);
        let parameters = tables.filter_map(|table| table.get("parameters")?.as_table());
        parameters.flat_map(|table| table.entries.iter().map(|entry| entry.key.clone())).collect()
    }

    /// The plan's table with what it includes in it; reports names that two files define.
    pub(super) fn merged(&self, out: &mut Findings) -> Table {
        let mut root = self.root.clone();
        let own = root.clone();
        for other in &self.others {
            for key in NAMED {
                let Some(entry) = other.entry(key) else { continue };
                join(&mut root, entry, &|_| false, out);
            }
            if let Some(entry) = other.entry(INVARIANTS) {
                append(&mut root, entry);
            }
            if let Some(entry) = other.entry(SETTINGS) {
                // What the plan itself says goes before what it includes.
                let said = own.get(SETTINGS).and_then(Node::as_table);
                join(&mut root, entry, &|key| said.is_some_and(|said| said.get(key).is_some()), out);
            }
        }
        root
    }
}

/// Puts the entries of an included list after those of the same key.
fn append(root: &mut Table, entry: &Entry) {
    let Some(at) = root.entries.iter().position(|known| known.key == entry.key) else {
        root.entries.push(entry.clone());
        return;
    };
    // What is no list is reported where it is read.
    if let (Data::Array(known), Data::Array(more)) = (&mut root.entries[at].node.data, &entry.node.data) {
        known.extend(more.iter().cloned());
    }
}

/// Puts the entries of an included table into that of the same key.
fn join(root: &mut Table, entry: &Entry, is_said: &dyn Fn(&str) -> bool, out: &mut Findings) {
    let Some(at) = root.entries.iter().position(|known| known.key == entry.key) else {
        root.entries.push(entry.clone());
        return;
    };
    // What is no table is reported where it is read.
    let Data::Table(known) = &mut root.entries[at].node.data else { return };
    let Some(more) = entry.node.as_table() else {
        let message = format!("`{}` is {}, not a table", entry.key, entry.node.kind());
        out.bad(codes::WRONG_TYPE, &entry.node, message, format!("write {} = {{ ... }}", entry.key));
        return;
    };
    for one in &more.entries {
        match known.entry(&one.key) {
            None => known.entries.push(one.clone()),
            Some(_) if is_said(&one.key) => {}
            Some(first) => {
                let message = format!("`{}` of `{}` is defined twice", one.key, entry.key);
                let found = Diagnostic::error(codes::INCLUDED_TWICE, message)
                    .at(out.file().to_owned(), one.key_span.clone(), "the second")
                    .at(out.file().to_owned(), first.key_span.clone(), "the first")
                    .help("rename one of them");
                out.push(found);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::beside;

    #[test]
    fn one_file_has_one_path() {
        for (file, path, whole) in [
            ("a/b.toml", "c.toml", "a/c.toml"),
            ("a/b.toml", "./c.toml", "a/c.toml"),
            ("a/b.toml", "../c.toml", "c.toml"),
            ("a/x/b.toml", "../../c.toml", "c.toml"),
            ("b.toml", "../c.toml", "../c.toml"),
            ("../b.toml", "../c.toml", "../../c.toml"),
            ("/a/b.toml", "../../c.toml", "/../c.toml"),
            ("a/b.toml", "/x//c.toml", "/x/c.toml"),
            ("b.toml", "d/c.toml", "d/c.toml"),
        ] {
            assert_eq!(beside(file, path), whole, "{path} beside {file}");
        }
    }
}
