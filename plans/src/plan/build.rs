//! One case of a plan: its values put in, held against the tables of keys and read.

use std::borrow::Cow;
use std::cell::RefCell;

use document::{Entry, Fields, Findings, Node, Table};
use signal::Span;

use super::envelope::{self, Form, Listed};
use super::keys::{EXPECT_KEYS, PLAN_KEYS};
use super::read::Document;
use super::scope::Scope;
use super::settings::SETTINGS_KEYS;
use super::step::{StepReader, step_names};
use super::variants::{Variant, show};
use super::{Case, ProgramRef, Refusal, Settings, facts, refusal, settings, signals, times};
use crate::codes;
use crate::expect::{self, Context, Expectation, Names, Place};
use crate::lang::{Anchor, Bindings, substitute};
use crate::measure::{self, Measurement};

const EXPECTATION: Form =
    Form { what: "expectation", list: "expect", own: EXPECT_KEYS, code: codes::EXPECT_VERB, alone: None };

/// The case of this number. `None` after it reported what is wrong.
pub(super) fn case(document: &Document, number: u64, out: &mut Findings) -> Option<Case> {
    let variant = document.variants.get(number)?;
    let Ok(refusal) = refusal::read(document, &variant, out) else { return None };
    match refusal {
        Some(refusal) if refusal.is_of_the_plan() => {
            let mut own = Findings::new(&document.file, codes::TOML);
            let case = whole(document, number, Some(refusal.clone()), &mut own);
            Some(case.unwrap_or_else(|| unreadable(document, &variant, refusal, own)))
        }
        refusal => whole(document, number, refusal, out),
    }
}

/// A case whose plan cannot be read, as it is expected of it.
fn unreadable(document: &Document, variant: &Variant<'_>, mut refusal: Refusal, found: Findings) -> Case {
    refusal.found = found.into_vec();
    let bindings = variant.bindings();
    // What is wrong is found already.
    let mut again = Findings::new(&document.file, codes::TOML);
    let head = head(document, &bindings, &mut again);
    let fields = Fields::check(&head, 0..0, "plan", PLAN_KEYS, &mut again);
    Case {
        name: name(document, variant),
        title: fields.text("title").unwrap_or(&document.name).to_owned(),
        row: variant.row.map(|row| row.name.clone()),
        parameters: bindings.iter().map(|(name, value)| (name.to_owned(), show(value))).collect(),
        settings: Settings::default(),
        program: ProgramRef::None,
        board: None,
        signals: Vec::new(),
        steps: Vec::new(),
        expectations: Vec::new(),
        measurements: Vec::new(),
        ends: Anchor::START,
        timeout: Span::ZERO,
        needs: Vec::new(),
        proves: facts::proves(&fields, &mut again),
        profiles: facts::profiles(&fields, &mut again),
        refusal: Some(refusal),
    }
}

/// The plan's own keys with the case's values put in.
fn head(document: &Document, bindings: &Bindings<'_>, out: &mut Findings) -> Table {
    let mut head = Table::default();
    for entry in &document.head.entries {
        let node = substitute(&entry.node, bindings, out).into_owned();
        head.entries.push(Entry { key: entry.key.clone(), key_span: entry.key_span.clone(), node });
    }
    head
}

/// The case as it would run, or be refused by what only its bench knows.
fn whole(document: &Document, number: u64, refusal: Option<Refusal>, out: &mut Findings) -> Option<Case> {
    let variant = document.variants.get(number)?;
    let bindings = variant.bindings();
    let row = variant.row.map(|row| row.name.as_str());
    let before = out.errors();

    let head = head(document, &bindings, out);
    let fields = Fields::check(&head, 0..0, "plan", PLAN_KEYS, out);
    let settings = match head.get("settings").and_then(|node| Some((node, node.as_table()?))) {
        // Held against its keys once more: what is right in it is then read even where something else is wrong.
        Some((node, table)) => {
            let inner = Fields::check(table, node.span.clone(), "table `settings`", SETTINGS_KEYS, out);
            settings::read(&inner, out)
        }
        None => Settings::default(),
    };
    let bound = fields
        .get("signals")
        .and_then(Node::as_table)
        .map_or_else(Vec::new, |table| signals::read(table, out));

    let here = present(&document.steps, row, &bindings, out);
    let scope = Scope {
        steps: step_names(&here),
        elsewhere: elsewhere(document, row),
        row,
        bound_names: bound.iter().map(|binding| binding.name.clone()).collect(),
        bound,
        used: RefCell::default(),
    };
    let reader = StepReader { document, variant: &variant, number, scope: &scope };
    let (mut steps, written) = reader.read(&here, out);
    let ends = match fields.get("ends") {
        Some(node) => scope.anchor(node, out).map(|anchor| (anchor, node)),
        None => None,
    };
    let settled = if out.errors() > before { None } else { times::settle(&mut steps, &written, ends, out) };

    let expectations = expectations(document, row, &bindings, &scope, out);
    let measurements = measurements(document, row, &bindings, &scope, out);
    if let Some(refused) = head.entry("refused").or_else(|| head.entry("warned")) {
        claims_or_refusal(refused, refusal.as_ref(), expectations.len() + measurements.len(), out);
    }
    let program = facts::program(document, &fields, &settings, out);
    let mut needs = facts::needs(&fields, out);
    let proves = facts::proves(&fields, out);
    let profiles = facts::profiles(&fields, out);
    let mut timeout = settled.as_ref().map_or(Span::ZERO, |(_, allowance)| *allowance);
    if let Some(given) = fields.duration("timeout") {
        timeout = given;
    }
    if out.errors() > before {
        return None;
    }
    let (ends, _) = settled?;
    let mut all = scope.bound;
    all.extend(scope.used.into_inner().list);
    facts::implied_needs(&steps, &all, &mut needs);
    Some(Case {
        name: name(document, &variant),
        title: fields.text("title").unwrap_or(&document.name).to_owned(),
        row: row.map(str::to_owned),
        parameters: bindings.iter().map(|(name, value)| (name.to_owned(), show(value))).collect(),
        settings,
        program,
        board: fields.text("board").map(str::to_owned),
        signals: all,
        steps,
        expectations,
        measurements,
        ends,
        timeout,
        needs,
        proves,
        profiles,
        refusal,
    })
}

/// Reports a case that is refused and claims something all the same, and one that is not and claims nothing.
fn claims_or_refusal(refused: &Entry, refusal: Option<&Refusal>, claims: usize, out: &mut Findings) {
    let place = refused.key_span.clone();
    match (refusal, claims) {
        (None, 0) => {
            let message = "a row that is neither refused nor warned of claims and measures nothing";
            out.error(codes::NOTHING_CLAIMED, place, message, "add an expectation for it");
        }
        (Some(_), 1..) => {
            let message =
                "a case that is refused or warned of never runs: it has nothing to claim or measure";
            let help = "give `rows` to it, or to the expectations of the rows that run";
            out.error(codes::CLAIM, place, message, help);
        }
        _ => {}
    }
}

/// The entries of a list that this row has, with their places in the list and their references replaced. One
/// whose references cannot be replaced is left out: what they would be is not known.
fn present<'d>(
    list: &'d [Listed],
    row: Option<&str>,
    bindings: &Bindings<'_>,
    out: &mut Findings,
) -> Vec<(usize, Cow<'d, Node>)> {
    let mut here = Vec::with_capacity(list.len());
    for (at, listed) in list.iter().enumerate().filter(|(_, listed)| listed.is_in(row)) {
        let before = out.errors();
        let node = substitute(&listed.node, bindings, out);
        if out.errors() == before {
            here.push((at, node));
        }
    }
    here
}

/// Ids of steps that this row does not have.
fn elsewhere(document: &Document, row: Option<&str>) -> Vec<String> {
    let others = document.steps.iter().filter(|step| !step.is_in(row));
    others.filter_map(|step| Some(step.node.as_table()?.get("id")?.as_text()?.to_owned())).collect()
}

/// The plan's path with what makes this case of it.
fn name(document: &Document, variant: &Variant<'_>) -> String {
    format!("{}{}{}", document.name, variant.suffix(), phase_suffix(variant, document))
}

/// `[train.phase=3/16]` for each step that the case moves.
fn phase_suffix(variant: &Variant<'_>, document: &Document) -> String {
    let mut suffix = String::new();
    for (step, position, count) in &variant.phases {
        let id =
            document.steps[*step].node.as_table().and_then(|table| table.get("id")).and_then(Node::as_text);
        suffix.push_str(&format!("[{}.phase={position}/{count}]", id.unwrap_or_default()));
    }
    suffix
}

fn expectations(
    document: &Document,
    row: Option<&str>,
    bindings: &Bindings<'_>,
    scope: &Scope<'_>,
    out: &mut Findings,
) -> Vec<Expectation> {
    let verbs: Vec<&'static str> = expect::VERBS.iter().map(|verb| verb.name).collect();
    let mut list = Vec::new();
    for (_, node) in present(&document.expect, row, bindings, out) {
        let Some((Some(entry), own)) = envelope::verb(&node, &EXPECTATION, &verbs, out) else { continue };
        let fields = Fields::check(&own, node.span.clone(), "expectation", EXPECT_KEYS, out);
        let Some(verb) = expect::verb(&entry.key) else { continue };
        let Some(table) = entry.node.as_table() else {
            let message = format!("`{}` is {}, not a table", entry.key, entry.node.kind());
            let help = format!("write {} = {{ ... }}; its keys are {}", entry.key, key_names(verb.keys));
            out.bad(codes::WRONG_TYPE, &entry.node, message, help);
            continue;
        };
        let before = out.errors();
        let what = format!("claim `{}`", verb.name);
        let claim_fields = Fields::check(table, entry.node.span.clone(), &what, verb.keys, out);
        if out.errors() > before {
            continue;
        }
        let mut context = Context { out, names: scope, place: entry.node.span.clone() };
        if let Some(claim) = (verb.read)(&claim_fields, &mut context) {
            let name = fields.text("name").unwrap_or_default().to_owned();
            list.push(Expectation { name, verb: verb.name, claim, place: Some(place(document, &node)) });
        }
    }
    list
}

fn key_names(keys: &[document::KeySpec]) -> String {
    keys.iter().map(|key| key.name).collect::<Vec<_>>().join(", ")
}

fn place(document: &Document, node: &Node) -> Place {
    Place { file: document.file_name.clone(), span: node.span.clone(), line: document.line(node.span.start) }
}

fn measurements(
    document: &Document,
    row: Option<&str>,
    bindings: &Bindings<'_>,
    scope: &Scope<'_>,
    out: &mut Findings,
) -> Vec<Measurement> {
    let mut list = Vec::new();
    for (_, node) in present(&document.measure, row, bindings, out) {
        let Some(table) = node.as_table() else { continue };
        let mut table = table.clone();
        // Which rows have it is settled; the rest is the measurement's own.
        table.entries.retain(|entry| entry.key != "rows");
        let before = out.errors();
        let fields = Fields::check(&table, node.span.clone(), "measurement", measure::KEYS, out);
        if out.errors() > before {
            continue;
        }
        let mut context = Context { out, names: scope, place: node.span.clone() };
        if let Some(mut measurement) = measure::read(&fields, &mut context) {
            measurement.place = Some(place(document, &node));
            list.push(measurement);
        }
    }
    list
}
