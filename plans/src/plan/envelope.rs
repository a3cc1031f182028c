//! What steps, expectations and measurements have in common: a list of tables, each with one verb key and the
//! rows that it belongs to.

use std::collections::BTreeSet;

use document::{Data, Entry, Findings, KeySpec, Node, Table, suggest};

use super::keys::{EXPECT_KEYS, STEP_KEYS};
use super::variants::PlanRow;
use crate::codes;
use crate::steps::CasePart;

/// An entry of one of the plan's lists.
#[derive(Clone, Debug)]
pub(super) struct ListEntry {
    pub(super) node: Node,
    /// The part of the case, for steps.
    pub(super) part: CasePart,
    /// The rows that have it; `None`: all.
    rows: Option<BTreeSet<String>>,
}

impl ListEntry {
    /// Whether the case of this row has the entry.
    pub(super) fn is_in(&self, row: Option<&str>) -> bool {
        match (&self.rows, row) {
            (None, _) => true,
            (Some(rows), Some(row)) => rows.contains(row),
            (Some(_), None) => false,
        }
    }
}

/// The entries of a list of the root; reports what is no table, and rows that do not exist. `rows` leaves the
/// entries of lists whose own keys do not name it.
pub(super) fn list(root: &Table, key: &str, rows: &[PlanRow], out: &mut Findings) -> Vec<ListEntry> {
    let Some(node) = root.get(key) else { return Vec::new() };
    let Data::Array(entries) = &node.data else {
        let help = format!("write {key} = [ ... ] with one {{ ... }} per line, or [[{key}]]");
        out.error(
            codes::WRONG_TYPE,
            node.span.clone(),
            format!("`{key}` is {}, not a list", node.kind()),
            help,
        );
        return Vec::new();
    };
    let known: BTreeSet<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    let mut listed = Vec::with_capacity(entries.len());
    for entry in entries {
        let Data::Table(table) = &entry.data else {
            let message = format!("an entry of `{key}` is {}, not a table", entry.kind());
            out.error(codes::WRONG_TYPE, entry.span.clone(), message, "write it as { ... }");
            continue;
        };
        let named = table.get("rows").map(|node| row_names(node, &known, out));
        let part = match key {
            "setup" => CasePart::Setup,
            "teardown" => CasePart::Teardown,
            _ => CasePart::Main,
        };
        listed.push(ListEntry { node: entry.clone(), part, rows: named });
    }
    listed
}

/// The rows that an entry names.
pub(super) fn row_names(node: &Node, rows: &BTreeSet<&str>, out: &mut Findings) -> BTreeSet<String> {
    let Data::Array(list) = &node.data else {
        let help = "write rows = [\"over\"]";
        out.error(
            codes::WRONG_TYPE,
            node.span.clone(),
            format!("`rows` is {}, not a list", node.kind()),
            help,
        );
        return BTreeSet::new();
    };
    let mut names = BTreeSet::new();
    if list.is_empty() {
        let help = "name the rows, or remove `rows` for all of them";
        out.error(codes::UNKNOWN_ROW, node.span.clone(), "no row has this entry", help);
    }
    for one in list {
        let Some(name) = one.as_text() else {
            out.error(
                codes::WRONG_TYPE,
                one.span.clone(),
                "the name of a row is a text",
                "write rows = [\"NAME\"]",
            );
            continue;
        };
        if !rows.contains(name) {
            // Looking for what was meant takes time; what is not kept needs none.
            let candidates = rows.iter().copied().take(if out.is_full() { 0 } else { usize::MAX });
            let help = match suggest(name, candidates) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None if rows.is_empty() => "the plan has no [rows]".to_owned(),
                None => {
                    let names: Vec<&str> = rows.iter().copied().take(20).collect();
                    format!("the rows are {}", names.join(", "))
                }
            };
            out.error(codes::UNKNOWN_ROW, one.span.clone(), format!("there is no row `{name}`"), help);
        }
        names.insert(name.to_owned());
    }
    names
}

/// What kind of entry is looked at, for messages.
pub(super) struct EntryForm {
    /// `step`.
    pub(super) what: &'static str,
    /// `steps`.
    pub(super) list: &'static str,
    /// The keys besides the verb.
    pub(super) own: &'static [KeySpec],
    /// The code under which a wrong verb is reported.
    pub(super) code: &'static str,
    /// The own key that makes a verb unnecessary.
    pub(super) alone: Option<&'static str>,
}

/// A step.
pub(super) const STEP: EntryForm =
    EntryForm { what: "step", list: "steps", own: STEP_KEYS, code: codes::STEP_VERB, alone: Some("when") };

/// An expectation.
pub(super) const EXPECTATION: EntryForm = EntryForm {
    what: "expectation",
    list: "expect",
    own: EXPECT_KEYS,
    code: codes::EXPECT_VERB,
    alone: None,
};

/// The one verb of an entry (`None` where it needs none), and its own keys as a table. Reports no verb, an unknown
/// one and two.
pub(super) fn verb<'t>(
    node: &'t Node,
    form: &EntryForm,
    verbs: &[&'static str],
    out: &mut Findings,
) -> Option<(Option<&'t Entry>, Table)> {
    let table = node.as_table()?;
    let mut own = Table::default();
    let mut found: Vec<&Entry> = Vec::new();
    let mut unknown: Vec<&Entry> = Vec::new();
    for entry in &table.entries {
        if form.own.iter().any(|spec| spec.name == entry.key) {
            own.entries.push(entry.clone());
        } else if verbs.contains(&entry.key.as_str()) {
            found.push(entry);
        } else {
            unknown.push(entry);
        }
    }
    for entry in &unknown {
        // With no verb among the keys, the unknown one is most likely it.
        let (code, message) = match found.is_empty() {
            true => (form.code, format!("`{}` is not a verb of `{}`", entry.key, form.list)),
            false => (codes::UNKNOWN_KEY, format!("`{}` is not a key of the {}", entry.key, form.what)),
        };
        let candidates = verbs.iter().copied().chain(form.own.iter().map(|spec| spec.name));
        let help = match suggest(&entry.key, candidates) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None => format!("the verbs are {}", verbs.join(", ")),
        };
        out.error(code, entry.key_span.clone(), message, help);
    }
    match (found.as_slice(), unknown.is_empty()) {
        ([one], _) => Some((Some(one), own)),
        ([], true) if form.alone.is_some_and(|key| own.get(key).is_some()) => Some((None, own)),
        ([], true) => {
            let message = format!("the {} has no verb", form.what);
            out.error(form.code, node.span.clone(), message, format!("the verbs are {}", verbs.join(", ")));
            None
        }
        ([], false) => None,
        ([first, second, ..], _) => {
            let message = format!("the {} has two verbs, `{}` and `{}`", form.what, first.key, second.key);
            let help = format!("write two entries of `{}`", form.list);
            out.error(form.code, second.key_span.clone(), message, help);
            None
        }
    }
}
