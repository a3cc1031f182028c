//! The lists of one case: those of the plan, with what groups bring after each step that runs one.

use std::borrow::Cow;
use std::ops::Range;
use std::rc::Rc;

use document::{Data, Findings, Node, suggest};
use signal::Span;

use super::envelope::ListEntry;
use super::groups::{self, DEEPEST, PlanGroup};
use super::keys::MOST_TIMES;
use super::read::{MAX_STEPS, PlanDocument, size};
use crate::codes;
use crate::lang::{Anchor, AnchorBase, Bindings, substitute};
use crate::steps::CasePart;

/// A step that runs a group, as what the group brings knows it.
#[derive(Debug, Default)]
pub(super) struct GroupCall {
    /// Its id with those of the steps that lead to it; empty for the plan itself.
    pub(super) path: String,
    /// Where it and they stand, the innermost first.
    places: Vec<Range<usize>>,
}

impl GroupCall {
    /// Findings are about what this call brings from now on.
    pub(super) fn announce(&self, out: &mut Findings) {
        out.set_context(self.places.iter().map(|place| (place.clone(), String::from("run from here"))));
    }

    /// The full id of something within.
    pub(super) fn id(&self, local: &str) -> String {
        if self.path.is_empty() { local.to_owned() } else { format!("{}.{local}", self.path) }
    }
}

/// An entry of one of the case's lists.
#[derive(Debug)]
pub(super) struct PlacedEntry<'d> {
    /// Place in the plan's own list; `None` for what a group brings.
    pub(super) listed: Option<usize>,
    /// With every reference replaced.
    pub(super) node: Cow<'d, Node>,
    /// The part of the case, for steps.
    pub(super) part: CasePart,
    /// The call that brings it.
    pub(super) call: Rc<GroupCall>,
    /// For steps, the place of the one that runs their group.
    pub(super) parent: Option<usize>,
    /// One of several calls of one step: its number, and how long after the step it comes.
    pub(super) turn: Option<(u64, Span)>,
}

impl PlacedEntry<'_> {
    /// The step's id in the case, if it says one.
    pub(super) fn id(&self) -> Option<String> {
        let local = self.node.as_table()?.get("id")?.as_text()?;
        Some(match self.turn {
            Some((n, _)) => format!("{}[{n}]", self.call.id(local)),
            None => self.call.id(local),
        })
    }

    /// The instant of one of several calls.
    pub(super) fn instant(&self, local: &str) -> Option<Anchor> {
        self.turn.map(|(_, offset)| Anchor { base: AnchorBase::Step(self.call.id(local)), offset })
    }
}

/// The lists of one case.
#[derive(Debug, Default)]
pub(super) struct Lists<'d> {
    pub(super) steps: Vec<PlacedEntry<'d>>,
    pub(super) expect: Vec<PlacedEntry<'d>>,
    pub(super) measure: Vec<PlacedEntry<'d>>,
}

/// The lists of the case of this row. An entry whose references cannot be replaced is left out: what they would be is
/// not known.
pub(super) fn lists<'d>(
    document: &'d PlanDocument,
    row: Option<&str>,
    bindings: &Bindings<'d>,
    out: &mut Findings,
) -> Lists<'d> {
    let plan = Rc::new(GroupCall::default());
    let mut expander = Expander {
        groups: &document.groups,
        plan: bindings,
        lists: Lists::default(),
        values: MOST_VALUES,
        is_full: false,
    };
    let expect = present(&document.expect, row, bindings, &plan, out);
    let measure = present(&document.measure, row, bindings, &plan, out);
    expander.claims(expect, measure, out);
    for step in present(&document.steps, row, bindings, &plan, out) {
        expander.step(step, 0, out);
    }
    out.set_context([]);
    expander.lists
}

/// The entries of a list that this row has.
pub(super) fn present<'d>(
    list: &'d [ListEntry],
    row: Option<&str>,
    bindings: &Bindings<'_>,
    call: &Rc<GroupCall>,
    out: &mut Findings,
) -> Vec<PlacedEntry<'d>> {
    let mut here = Vec::with_capacity(list.len());
    for (at, listed) in list.iter().enumerate().filter(|(_, listed)| listed.is_in(row)) {
        let before = out.errors();
        let node = substitute(&listed.node, bindings, out);
        if out.errors() == before {
            let (call, part) = (Rc::clone(call), listed.part);
            let listed = call.path.is_empty().then_some(at);
            here.push(PlacedEntry { listed, node, part, call, parent: None, turn: None });
        }
    }
    here
}

/// Most values that the references of one case are replaced by, in all its entries: bounds the memory that it takes.
const MOST_VALUES: u64 = 500_000;
/// Most claims and measurements of a case, with those of its groups.
const MOST_CLAIMS: usize = 10_000;

struct Expander<'d, 'b> {
    groups: &'d [PlanGroup],
    /// What rows, sweeps and parameters are in this case.
    plan: &'b Bindings<'d>,
    lists: Lists<'d>,
    /// How many values more may be put in.
    values: u64,
    /// A limit was reached, and reported: nothing is added any more.
    is_full: bool,
}

impl<'d> Expander<'d, '_> {
    /// Takes room for the values of an entry that are its own; reports where there is none left.
    fn has_room(&mut self, values: u64, place: &Range<usize>, out: &mut Findings) -> bool {
        match self.values.checked_sub(values) {
            _ if self.is_full => false,
            Some(left) => {
                self.values = left;
                true
            }
            None => {
                self.is_full = true;
                let message = format!("with its references the case has more than {MOST_VALUES} values");
                let help = "give groups fewer or shorter arguments, or run them less often";
                out.error(codes::TOO_MANY_STEPS, place.clone(), message, help);
                false
            }
        }
    }

    /// Adds claims and measurements.
    fn claims(&mut self, expect: Vec<PlacedEntry<'d>>, measure: Vec<PlacedEntry<'d>>, out: &mut Findings) {
        for (entry, is_measurement) in expect
            .into_iter()
            .map(|entry| (entry, false))
            .chain(measure.into_iter().map(|entry| (entry, true)))
        {
            if !self.has_room(own_values(&entry.node), &entry.node.span, out) {
                return;
            }
            if self.lists.expect.len() + self.lists.measure.len() >= MOST_CLAIMS {
                self.is_full = true;
                let message = format!("with its groups the case has more than {MOST_CLAIMS} claims");
                let help = "claim of all pulses of a train at once, or split the plan";
                out.error(codes::TOO_MANY_CLAIMS, entry.node.span.clone(), message, help);
                return;
            }
            if is_measurement {
                self.lists.measure.push(entry);
            } else {
                self.lists.expect.push(entry);
            }
        }
    }

    /// Adds a step and what it runs.
    fn step(&mut self, step: PlacedEntry<'d>, depth: usize, out: &mut Findings) {
        if !self.has_room(own_values(&step.node), &step.node.span, out) {
            return;
        }
        if self.lists.steps.len() >= MAX_STEPS {
            self.is_full = true;
            let message = format!("with its groups the case has more than {MAX_STEPS} steps");
            out.error(codes::TOO_MANY_STEPS, step.node.span.clone(), message, "a train has many pulses");
            return;
        }
        let run = step.node.as_table().and_then(|table| table.get("run")).cloned();
        let (Some(run), Some(id)) = (run, step.id()) else {
            self.lists.steps.push(step);
            return;
        };
        let parent = self.lists.steps.len();
        let node = step.node.clone();
        let (part, call) = (step.part, Rc::clone(&step.call));
        self.lists.steps.push(step);
        let Some((group, args)) = self.arguments(&run, &call, out) else { return };
        let given: u64 = args.iter().map(|(_, value)| size(value)).sum();
        let mut places = vec![node.span.clone()];
        places.extend(call.places.iter().cloned());
        if depth >= DEEPEST {
            let message = format!("groups run each other more than {DEEPEST} deep");
            out.error(
                codes::RECURSION,
                node.span.clone(),
                message,
                "run the steps of the innermost groups directly",
            );
            return;
        }
        let Some(turns) = turns(&node) else {
            if !self.has_room(given, &node.span, out) {
                return;
            }
            let inner = Rc::new(GroupCall { path: id, places });
            self.bring(group, &args, &inner, part, parent, depth, out);
            return;
        };
        for (n, after) in turns {
            let values = own_values(&node) + given;
            if self.lists.steps.len() >= MAX_STEPS || out.is_full() || !self.has_room(values, &node.span, out)
            {
                break;
            }
            let place = self.lists.steps.len();
            let path = format!("{id}[{n}]");
            let (node, call) = (node.clone(), Rc::clone(&call));
            let turn = Some((n, after));
            self.lists.steps.push(PlacedEntry { listed: None, node, part, call, parent: Some(parent), turn });
            let inner = Rc::new(GroupCall { path, places: places.clone() });
            self.bring(group, &args, &inner, part, place, depth, out);
        }
        call.announce(out);
    }

    /// Adds what a group brings to a call.
    #[expect(clippy::too_many_arguments, reason = "what a call is")]
    fn bring(
        &mut self,
        group: &'d PlanGroup,
        args: &[(&'d str, Node)],
        call: &Rc<GroupCall>,
        part: CasePart,
        parent: usize,
        depth: usize,
        out: &mut Findings,
    ) {
        let mut bindings = Bindings::default();
        for (name, value) in args {
            bindings.add(name, Cow::Owned(value.clone()), Some(value.span.clone()));
        }
        bindings.append(self.plan);
        call.announce(out);
        let expect = present(&group.expect, None, &bindings, call, out);
        let measure = present(&group.measure, None, &bindings, call, out);
        self.claims(expect, measure, out);
        if self.is_full {
            return;
        }
        for step in present(&group.steps, None, &bindings, call, out) {
            call.announce(out);
            self.step(PlacedEntry { part, parent: Some(parent), ..step }, depth + 1, out);
        }
    }

    /// The group of a call and its arguments. `None` after it reported what is wrong.
    fn arguments(
        &self,
        run: &Node,
        call: &GroupCall,
        out: &mut Findings,
    ) -> Option<(&'d PlanGroup, Vec<(&'d str, Node)>)> {
        call.announce(out);
        let table = run.as_table()?;
        let Some(name) = table.get("group") else {
            let help = "write run = { group = \"NAME\" } with the group's arguments beside it";
            out.bad(codes::MISSING_KEY, run, "the call names no `group`", help);
            return None;
        };
        if name.as_text().is_none() || name.origin.is_some() {
            let message = "the name of a group is a text of its own, without a reference";
            out.bad(codes::GROUP, name, message, "give `rows` to a step for each group");
            return None;
        }
        let group = groups::find(self.groups, name, out)?;
        let before = out.errors();
        for entry in table.entries.iter().filter(|entry| entry.key != "group") {
            if group.args.iter().any(|arg| arg.name == entry.key) {
                continue;
            }
            let help = match suggest(&entry.key, group.args.iter().map(|arg| arg.name.as_str())) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None if group.args.is_empty() => "it has none".to_owned(),
                None => {
                    let names: Vec<&str> = group.args.iter().map(|arg| arg.name.as_str()).collect();
                    format!("they are {}", names.join(", "))
                }
            };
            let message = format!("`{}` is no argument of the group `{}`", entry.key, group.name);
            out.error(codes::ARGUMENT, entry.key_span.clone(), message, help);
        }
        let mut args = Vec::with_capacity(group.args.len());
        for arg in &group.args {
            match table.get(&arg.name).or(arg.default.as_ref()) {
                Some(Node { data: Data::Table(_), span, .. }) => {
                    let message = format!("the argument `{}` is a table", arg.name);
                    let help = "bind a signal that is written as a table under `signals`, and give its name";
                    out.error(codes::ARGUMENT, span.clone(), message, help);
                }
                Some(value) => args.push((arg.name.as_str(), value.clone())),
                None => {
                    let message = format!("the call gives no `{}` to the group `{}`", arg.name, group.name);
                    let found = document::Diagnostic::error(codes::ARGUMENT, message)
                        .at(out.file().to_owned(), run.span.clone(), "")
                        .at(out.file().to_owned(), arg.place.clone(), "declared here without a default")
                        .help(format!("add {} = ... beside `group`", arg.name));
                    out.push(found);
                }
            }
        }
        (out.errors() == before).then_some((group, args))
    }
}

/// How many values an entry has for itself: those of the plan's text it only points at.
#[expect(clippy::ptr_arg, reason = "whether it is borrowed is what is asked")]
fn own_values(node: &Cow<'_, Node>) -> u64 {
    match node {
        Cow::Borrowed(_) => 0,
        Cow::Owned(node) => size(node),
    }
}

/// The calls of a step that comes again and again, each with its distance from the first. `None` for a step that comes
/// once. What is wrong is reported when the step is read.
fn turns(node: &Node) -> Option<Vec<(u64, Span)>> {
    let every = node.as_table()?.get("every")?.as_table()?;
    let Some(Data::Integer(times)) = every.get("times").map(|times| &times.data) else {
        return Some(Vec::new());
    };
    let Some(period) = every.get("period").and_then(|period| Span::parse(period.as_text()?).ok()) else {
        return Some(Vec::new());
    };
    let times = u64::try_from((*times).clamp(0, MOST_TIMES)).unwrap_or(0).min(MAX_STEPS as u64);
    let after =
        |n: u64| Span::from_nanos(period.as_nanos().saturating_mul(i64::try_from(n).unwrap_or(i64::MAX)));
    Some((0..times).map(|n| (n + 1, after(n))).collect())
}
