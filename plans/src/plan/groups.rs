//! `group`: steps and claims with a name and arguments.

use std::collections::BTreeMap;
use std::ops::Range;

use document::{Data, Diagnostic, Entry, Fields, Findings, Node, Table, suggest};

use super::envelope::{self, ListEntry};
use super::keys::{ARG_KEYS, GROUP_KEYS};
use super::read::MAX_STEPS;
use crate::codes;
use crate::lang::{has_reference, is_id};

/// Groups that run others, one within another.
pub(super) const DEEPEST: usize = 8;
/// Most groups of a plan, with those of the files that it includes.
const MOST_GROUPS: usize = 1_000;
/// Ids that steps of a group cannot have: they are parts of the step that runs it.
pub(super) const RESERVED: &[&str] = &["begin", "done", "pulse"];

/// An argument of a group.
#[derive(Debug)]
pub(super) struct Arg {
    pub(super) name: String,
    /// What it is where a call does not say; `None`: every call has to.
    pub(super) default: Option<Node>,
    /// Where it is declared.
    pub(super) place: Range<usize>,
}

/// A group.
#[derive(Debug)]
pub(super) struct PlanGroup {
    pub(super) name: String,
    pub(super) place: Range<usize>,
    pub(super) args: Vec<Arg>,
    pub(super) steps: Vec<ListEntry>,
    pub(super) expect: Vec<ListEntry>,
    pub(super) measure: Vec<ListEntry>,
}

/// The groups of a plan. Reports what is wrong with them; `None` where they run each other without end.
pub(super) fn read(root: &Table, out: &mut Findings) -> Option<Vec<PlanGroup>> {
    let Some(node) = root.get("group") else { return Some(Vec::new()) };
    let Some(table) = node.as_table() else {
        let help = "write [group.NAME] and below it args, steps and expect";
        out.bad(codes::WRONG_TYPE, node, format!("`group` is {}, not a table", node.kind()), help);
        return Some(Vec::new());
    };
    if table.entries.len() > MOST_GROUPS {
        let message = format!("the plan has {} groups; {MOST_GROUPS} is the most", table.entries.len());
        out.bad(codes::TOO_LARGE, node, message, "split the plan");
        return None;
    }
    let groups: Vec<PlanGroup> = table.entries.iter().filter_map(|entry| group(entry, out)).collect();
    (!endless(&groups, out)).then_some(groups)
}

fn group(entry: &Entry, out: &mut Findings) -> Option<PlanGroup> {
    if !is_id(&entry.key) {
        let help = "letters, digits, `_`, and `-` before a letter; it begins with a letter";
        let message = format!("`{}` cannot be the name of a group", entry.key);
        out.error(codes::GROUP, entry.key_span.clone(), message, help);
        return None;
    }
    let Some(table) = entry.node.as_table() else {
        let message = format!("the group `{}` is {}, not a table", entry.key, entry.node.kind());
        out.bad(codes::WRONG_TYPE, &entry.node, message, "write [group.NAME] and below it its keys");
        return None;
    };
    // The lists have verbs, which no table of keys knows.
    let mut own = table.clone();
    own.entries.retain(|entry| !matches!(entry.key.as_str(), "steps" | "expect" | "measure"));
    let fields = Fields::check(&own, entry.key_span.clone(), "group", GROUP_KEYS, out);
    let args = match fields.get("args").and_then(Node::as_table) {
        Some(table) => table.entries.iter().filter_map(|entry| arg(entry, out)).collect(),
        None => Vec::new(),
    };
    let mut list = |key: &str| {
        let mut here = Vec::new();
        if let Some(Data::Array(entries)) = table.get(key).map(|node| &node.data) {
            entries.iter().for_each(|entry| of_no_row(entry, out));
        }
        // Without rows of its own: what names one was reported, and is of every row.
        let mut bare = table.clone();
        bare.entries.retain(|entry| entry.key == key);
        strip(&mut bare);
        here.extend(envelope::list(&bare, key, &[], out));
        here
    };
    let (steps, expect, measure) = (list("steps"), list("expect"), list("measure"));
    if steps.is_empty() && expect.is_empty() && measure.is_empty() {
        let message = format!("the group `{}` does and claims nothing", entry.key);
        out.error(
            codes::GROUP,
            entry.key_span.clone(),
            message,
            "give it steps = [ ... ] or expect = [ ... ]",
        );
    }
    Some(PlanGroup { name: entry.key.clone(), place: entry.key_span.clone(), args, steps, expect, measure })
}

/// Takes `rows` out of the entries of a list.
fn strip(table: &mut Table) {
    for entry in &mut table.entries {
        let Data::Array(list) = &mut entry.node.data else { continue };
        for one in list {
            if let Data::Table(table) = &mut one.data {
                table.entries.retain(|entry| entry.key != "rows");
            }
        }
    }
}

/// Reports what belongs to the plan alone: rows, and phases that make cases.
fn of_no_row(entry: &Node, out: &mut Findings) {
    let Some(table) = entry.as_table() else { return };
    if let Some(rows) = table.entry("rows") {
        let help = "give `rows` to the steps that run the group";
        out.error(codes::IN_GROUP, rows.key_span.clone(), "a group has no rows", help);
    }
    let phase = table.get("phase").and_then(Node::as_table);
    if let Some(positions) = phase.and_then(|phase| phase.entry("positions")) {
        let help = "give the `phase` to the step that runs the group";
        out.error(codes::IN_GROUP, positions.key_span.clone(), "the steps of a group make no cases", help);
    }
}

fn arg(entry: &Entry, out: &mut Findings) -> Option<Arg> {
    let fault = match &entry.node.data {
        _ if !is_id(&entry.key) || entry.key == "group" => Some("cannot be the name of an argument"),
        Data::Table(table) => {
            let before = out.errors();
            Fields::check(table, entry.node.span.clone(), "argument", ARG_KEYS, out);
            if out.errors() > before {
                return None;
            }
            None
        }
        _ => None,
    };
    let default = match &entry.node.data {
        Data::Table(table) => table.get("default").cloned(),
        _ => Some(entry.node.clone()),
    };
    if let Some(fault) = fault {
        out.error(
            codes::ARGUMENT,
            entry.key_span.clone(),
            format!("`{}` {fault}", entry.key),
            "write it as in args = { pause = \"10 ms\" }",
        );
        return None;
    }
    if let Some(default) = &default
        && has_reference(default)
    {
        let message = "the default of an argument is a value and no reference";
        out.bad(codes::ARGUMENT, default, message, "let the calls give it");
        return None;
    }
    Some(Arg { name: entry.key.clone(), default, place: entry.key_span.clone() })
}

/// Whether each group is run by one of these steps, or by a group that is.
pub(super) fn run_by_steps(steps: &[ListEntry], groups: &[PlanGroup]) -> Vec<bool> {
    let places = places(groups);
    let runs = |list: &[ListEntry]| -> Vec<usize> {
        let names = list.iter().filter_map(|step| run_by(&step.node)?.as_text());
        names.filter_map(|name| places.get(name).copied()).collect()
    };
    let mut run = vec![false; groups.len()];
    let mut open = runs(steps);
    while let Some(group) = open.pop() {
        if !std::mem::replace(&mut run[group], true) {
            open.extend(runs(&groups[group].steps));
        }
    }
    run
}

/// The group that a step runs, by its name as written.
fn run_by(step: &Node) -> Option<&Node> {
    step.as_table()?.get("run")?.as_table()?.get("group")
}

/// The group of a call; reports a name that none has.
pub(super) fn find<'g>(groups: &'g [PlanGroup], node: &Node, out: &mut Findings) -> Option<&'g PlanGroup> {
    let name = node.as_text()?;
    let found = groups.iter().find(|group| group.name == name);
    if found.is_none() {
        let help = match suggest(name, groups.iter().map(|group| group.name.as_str())) {
            Some(meant) => format!("did you mean `{meant}`?"),
            None if groups.is_empty() => "the plan has no [group.NAME]".to_owned(),
            None => {
                let names: Vec<&str> = groups.iter().map(|group| group.name.as_str()).take(20).collect();
                format!("the groups are {}", names.join(", "))
            }
        };
        out.bad(codes::GROUP, node, format!("there is no group `{name}`"), help);
    }
    found
}

/// Reports the first circle of groups that run each other, if there is one.
fn endless(groups: &[PlanGroup], out: &mut Findings) -> bool {
    let places = places(groups);
    let place = |name: &str| places.get(name).copied();
    // What a group was found to be: not looked at, on the way, free of circles.
    let mut marks = vec![0u8; groups.len()];
    for first in 0..groups.len() {
        let mut path: Vec<(usize, usize)> = vec![(first, 0)];
        while let Some((group, step)) = path.pop() {
            let Some(listed) = groups[group].steps.get(step) else {
                marks[group] = 2;
                continue;
            };
            marks[group] = 1;
            path.push((group, step + 1));
            let Some(next) = run_by(&listed.node).and_then(Node::as_text).and_then(place) else { continue };
            match marks[next] {
                0 => path.push((next, 0)),
                1 => {
                    let from = path.iter().position(|(one, _)| *one == next).unwrap_or(0);
                    let names: Vec<&str> =
                        path[from..].iter().take(8).map(|(one, _)| groups[*one].name.as_str()).collect();
                    let message = format!("these groups run each other without end: {}", names.join(", "));
                    let found = Diagnostic::error(codes::RECURSION, message)
                        .at(out.file().to_owned(), listed.node.span.clone(), "")
                        .at(out.file().to_owned(), groups[next].place.clone(), "this group again")
                        .help("let a step come several times with `every`");
                    out.push(found);
                    return true;
                }
                _ => {}
            }
        }
    }
    false
}

/// The places of groups by their names.
fn places(groups: &[PlanGroup]) -> BTreeMap<&str, usize> {
    // Of two groups of one name, which TOML does not have, the first counts.
    groups.iter().enumerate().rev().map(|(place, group)| (group.name.as_str(), place)).collect()
}

/// How many values the calls of these steps put into a case, at most about: bounds the time that checking takes. Each
/// group is weighed once for each depth, however often it is run.
pub(super) fn weight(steps: &[ListEntry], groups: &[PlanGroup]) -> u64 {
    let places = places(groups);
    let calls = |steps: &[ListEntry]| -> Vec<(usize, u64)> {
        let calls = steps.iter().filter_map(|step| {
            let place = *places.get(run_by(&step.node)?.as_text()?)?;
            let times =
                step.node.as_table()?.get("every").and_then(|every| every.as_table()?.get("times").cloned());
            let times = match times.map(|times| times.data) {
                None => 1,
                Some(Data::Integer(times)) => u64::try_from(times).unwrap_or(1),
                Some(_) => MAX_STEPS as u64,
            };
            Some((place, times))
        });
        calls.collect()
    };
    let own = |group: &PlanGroup| -> u64 {
        let lists = [&group.steps, &group.expect, &group.measure];
        lists.iter().flat_map(|list| list.iter()).map(|one| super::read::size(&one.node)).sum()
    };
    let own: Vec<u64> = groups.iter().map(own).collect();
    let of_groups: Vec<Vec<(usize, u64)>> = groups.iter().map(|group| calls(&group.steps)).collect();
    let sum = |calls: &[(usize, u64)], inner: &[u64]| {
        let each =
            |(place, times): &(usize, u64)| own[*place].saturating_add(inner[*place]).saturating_mul(*times);
        calls.iter().map(each).fold(0, u64::saturating_add)
    };
    // What the calls of each group bring, from the innermost depth outwards.
    let mut inner = vec![0u64; groups.len()];
    for _ in 0..DEEPEST {
        inner = of_groups.iter().map(|calls| sum(calls, &inner)).collect();
    }
    sum(&calls(steps), &inner)
}
