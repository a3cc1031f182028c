//! One case of a plan: its values put in, held against the tables of keys and read.

use std::cell::RefCell;
use std::sync::Arc;

use document::{Diagnostic, Entry, Fields, Findings, Node, Table};
use record::GuardBand;
use signal::Span;

use super::envelope::{self, EXPECTATION, EntryForm};
use super::expand::{self, PlacedEntry};
use super::keys::PLAN_KEYS;
use super::names::CaseNames;
use super::read::PlanDocument;
use super::settings::SETTINGS_KEYS;
use super::step::{StepReader, step_names};
use super::variants::{Variant, show};
use super::{
    Case, DelayModel, ExpectedRefusal, PlanSettings, check, facts, global_checks, refusal, settings, times,
};
use crate::codes;
use crate::expect::{self, Expectation, FilePlace, ReadContext};
use crate::lang::{Anchor, Bindings, PlanNames, substitute};
use crate::measure::{self, Measurement};
use crate::signals;
use crate::signals::frames::{self, PlanFrames};
use crate::steps::ProgramRef;

/// The case of this number, with `seed` for what it leaves to chance. `None` after it reported what is wrong.
pub(super) fn case(document: &PlanDocument, number: u64, seed: u64, out: &mut Findings) -> Option<Case> {
    let variant = document.variants.get(number)?;
    let Ok(refusal) = refusal::read(document, &variant, out) else { return None };
    match refusal {
        Some(refusal) if refusal.is_of_the_plan() => {
            let mut own = Findings::new(&document.file, codes::TOML);
            let case = whole(document, number, seed, Some(refusal.clone()), &mut own);
            // That the plan contradicts itself is no refusal that it can ask for.
            let is_contradiction = |one: &Diagnostic| one.code == codes::REFUSED_AND_CLAIMS;
            let (contradictions, found): (Vec<_>, Vec<_>) =
                own.into_vec().into_iter().partition(is_contradiction);
            if !contradictions.is_empty() {
                contradictions.into_iter().for_each(|one| out.push(one));
                return None;
            }
            Some(case.unwrap_or_else(|| unreadable(document, &variant, refusal, found)))
        }
        refusal => whole(document, number, seed, refusal, out),
    }
}

/// A case whose plan cannot be read, as it is expected of it.
fn unreadable(
    document: &PlanDocument,
    variant: &Variant<'_>,
    mut refusal: ExpectedRefusal,
    found: Vec<Diagnostic>,
) -> Case {
    refusal.found = found;
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
        settings: PlanSettings::default(),
        model: DelayModel::default(),
        program: ProgramRef::None,
        board: None,
        signals: Vec::new(),
        unspoken: Vec::new(),
        steps: Vec::new(),
        expectations: Vec::new(),
        measurements: Vec::new(),
        invariants: Vec::new(),
        alarms: Vec::new(),
        ends: Anchor::START,
        ends_from: None,
        timeout: Span::ZERO,
        teardown: Span::ZERO,
        needs: Vec::new(),
        proves: facts::proves(&fields, &mut again),
        tags: facts::tags(&fields, &mut again),
        profiles: facts::profiles(&fields, &mut again),
        repeat: 1,
        refusal: Some(refusal),
    }
}

/// The plan's own keys with the case's values put in.
fn head(document: &PlanDocument, bindings: &Bindings<'_>, out: &mut Findings) -> Table {
    let mut head = Table::default();
    for entry in &document.head.entries {
        let node = substitute(&entry.node, bindings, out).into_owned();
        head.entries.push(Entry { key: entry.key.clone(), key_span: entry.key_span.clone(), node });
    }
    head
}

/// The case as it would run, or be refused by what only its bench knows.
fn whole(
    document: &PlanDocument,
    number: u64,
    seed: u64,
    refusal: Option<ExpectedRefusal>,
    out: &mut Findings,
) -> Option<Case> {
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
        None => PlanSettings::default(),
    };
    let bound = fields
        .get("signals")
        .and_then(Node::as_table)
        .map_or_else(Vec::new, |table| signals::read(table, out));

    let mut bound = bound;
    let frames = fields.get("frames").and_then(Node::as_table).map_or_else(PlanFrames::default, |table| {
        let taken = |name: &str| bound.iter().any(|binding| binding.name == name);
        frames::read(table, &document.text.databases, &taken, out)
    });
    bound.extend(frames.bindings);
    let lists = expand::lists(document, row, &bindings, out);
    let here = &lists.steps;
    let scope = CaseNames {
        steps: step_names(here),
        parts: here.iter().map(|step| step.part).collect(),
        call: RefCell::default(),
        elsewhere: elsewhere(document, row),
        row,
        tables: &document.text.tables,
        databases: &document.text.databases,
        frames: frames.named,
        bound_names: bound.iter().map(|binding| binding.name.clone()).collect(),
        bound,
        spoken_of: RefCell::default(),
        used: RefCell::default(),
    };
    let reader = StepReader { document, variant: &variant, number, seed, scope: &scope };
    let (mut steps, written) = reader.read(here, out);
    scope.enter(&Default::default(), out);
    let ends = match fields.get("ends") {
        Some(node) => scope.anchor(node, out).map(|anchor| (anchor, node)),
        None => None,
    };
    let settled = if out.errors() > before { None } else { times::resolve(&mut steps, &written, ends, out) };

    let expectations = expectations(document, &lists.expect, &scope, out);
    let guard = measure::guard(&fields).unwrap_or_default();
    let measurements = measurements(document, &lists.measure, guard, &scope, out);
    scope.enter(&Default::default(), out);
    if lists.expect.is_empty() && lists.measure.is_empty() && refusal.is_none() && !document.groups.is_empty()
    {
        let help = "add an expectation, or a step that runs a group that has one";
        out.error(codes::NOTHING_CLAIMED, 0..0, "the case neither claims nor measures anything", help);
    }
    let standing = global_checks::of_case(document, row, &bindings, &scope, out);
    if let Some(refused) = head.entry("refused").or_else(|| head.entry("warned")) {
        claims_or_refusal(refused, refusal.as_ref(), expectations.len() + measurements.len(), out);
    }
    let program = facts::program(document, &fields, &settings, out);
    let mut needs = facts::needs(&fields, out);
    let proves = facts::proves(&fields, out);
    let tags = facts::tags(&fields, out);
    let profiles = facts::profiles(&fields, out);
    let mut timeout = settled.as_ref().map_or(Span::ZERO, |settled| settled.allowance);
    if let Some(given) = fields.duration("timeout") {
        timeout = given;
    }
    if out.errors() > before {
        return None;
    }
    let settled = settled?;
    let spoken_of = scope.spoken_of.into_inner();
    let own = scope.bound.iter().filter(|binding| document.text.joined.is_first(binding.span.start));
    let unspoken =
        own.map(|binding| &binding.name).filter(|name| !spoken_of.contains(*name)).cloned().collect();
    let mut all = scope.bound;
    // What another file binds is there for those plans that use it.
    all.retain(|binding| {
        document.text.joined.is_first(binding.span.start) || spoken_of.contains(&binding.name)
    });
    all.extend(scope.used.into_inner().list);
    let parts = check::CheckedParts {
        steps: &steps,
        ends: &settled.ends,
        ends_given: fields.has("ends"),
        expectations: &expectations,
        measurements: &measurements,
        signals: &all,
        settings: &settings,
    };
    check::case(&parts, out);
    if out.errors() > before {
        return None;
    }
    facts::implied_needs(&steps, &all, &mut needs);
    Some(Case {
        name: name(document, &variant),
        title: fields.text("title").unwrap_or(&document.name).to_owned(),
        row: row.map(str::to_owned),
        parameters: bindings.iter().map(|(name, value)| (name.to_owned(), show(value))).collect(),
        settings,
        model: match fields.text("model") {
            Some(name) if name == DelayModel::WorstCase.name() => DelayModel::WorstCase,
            _ => DelayModel::Exact,
        },
        program,
        board: fields.text("board").map(str::to_owned),
        signals: all,
        unspoken,
        steps,
        expectations,
        measurements,
        invariants: standing.invariants,
        alarms: standing.alarms,
        ends: settled.ends,
        ends_from: settled.ends_from,
        timeout,
        teardown: settled.teardown,
        needs,
        proves,
        tags,
        profiles,
        // Nothing of what is refused depends on chance.
        repeat: match refusal {
            None => fields.integer("repeat").and_then(|turns| u32::try_from(turns).ok()).unwrap_or(1),
            Some(_) => 1,
        },
        refusal,
    })
}

/// Reports a case that is refused and claims something all the same, and one that is not and claims nothing.
fn claims_or_refusal(refused: &Entry, refusal: Option<&ExpectedRefusal>, claims: usize, out: &mut Findings) {
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
            out.error(codes::REFUSED_AND_CLAIMS, place, message, help);
        }
        _ => {}
    }
}

/// Ids of steps that this row does not have.
fn elsewhere(document: &PlanDocument, row: Option<&str>) -> Vec<String> {
    let others = document.steps.iter().filter(|step| !step.is_in(row));
    others.filter_map(|step| Some(step.node.as_table()?.get("id")?.as_text()?.to_owned())).collect()
}

/// The plan's path with what makes this case of it.
fn name(document: &PlanDocument, variant: &Variant<'_>) -> String {
    format!("{}{}{}", document.name, variant.suffix(), phase_suffix(variant, document))
}

/// `[train.phase=3/16]` for each step that the case moves.
fn phase_suffix(variant: &Variant<'_>, document: &PlanDocument) -> String {
    let mut suffix = String::new();
    for (step, position, count) in &variant.phases {
        let id =
            document.steps[*step].node.as_table().and_then(|table| table.get("id")).and_then(Node::as_text);
        suffix.push_str(&format!("[{}.phase={position}/{count}]", id.unwrap_or_default()));
    }
    suffix
}

fn expectations(
    document: &PlanDocument,
    here: &[PlacedEntry<'_>],
    scope: &CaseNames<'_>,
    out: &mut Findings,
) -> Vec<Expectation> {
    let mut list = Vec::new();
    for PlacedEntry { node, call, .. } in here {
        scope.enter(call, out);
        if let Some(mut read) = expectation(node, &EXPECTATION, scope, out) {
            if !call.path.is_empty() && !read.name.is_empty() {
                read.name = format!("{}: {}", call.path, read.name);
            }
            read.place = Some(place(document, node));
            list.push(read);
        }
    }
    list
}

/// One entry of a list of claims, without its place. Reports what is wrong with it.
pub(super) fn expectation(
    node: &Node,
    form: &EntryForm,
    names: &dyn PlanNames,
    out: &mut Findings,
) -> Option<Expectation> {
    if let Some(guard) = guard_of_claim(node) {
        let message =
            "a claim has no guard band: it is judged over all placements and has no figure of its own";
        let help = "measure it: a table of `measure` with the limits and the `guard`";
        out.error(codes::GUARD_BAND, guard.key_span.clone(), message, help);
        return None;
    }
    let verbs: Vec<&'static str> = expect::VERBS.iter().map(|verb| verb.name).collect();
    let (entry, own) = envelope::verb(node, form, &verbs, out)?;
    let entry = entry?;
    let fields = Fields::check(&own, node.span.clone(), form.what, form.own, out);
    let verb = expect::verb(&entry.key)?;
    let Some(table) = entry.node.as_table() else {
        let message = format!("`{}` is {}, not a table", entry.key, entry.node.kind());
        let help = format!("write {} = {{ ... }}; its keys are {}", entry.key, key_names(verb.keys));
        out.bad(codes::WRONG_TYPE, &entry.node, message, help);
        return None;
    };
    let before = out.errors();
    let what = format!("claim `{}`", verb.name);
    let claim_fields = Fields::check(table, entry.node.span.clone(), &what, verb.keys, out);
    if out.errors() > before {
        return None;
    }
    let mut context = ReadContext { out, names, place: entry.node.span.clone() };
    let claim = (verb.read)(&claim_fields, &mut context)?;
    let name = fields.text("name").unwrap_or_default().to_owned();
    Some(Expectation { name, verb: verb.name, claim, place: None })
}

/// The key of a guard band beside the verb of a claim, or among the keys of the verb.
fn guard_of_claim(node: &Node) -> Option<&Entry> {
    let table = node.as_table()?;
    let inner = table.entries.iter().filter_map(|entry| entry.node.as_table());
    std::iter::once(table).chain(inner).find_map(|table| table.entry(measure::GUARD))
}

fn key_names(keys: &[document::KeySpec]) -> String {
    keys.iter().map(|key| key.name).collect::<Vec<_>>().join(", ")
}

pub(super) fn place(document: &PlanDocument, node: &Node) -> FilePlace {
    if document.text.joined.is_first(node.span.start) {
        let line = document.line(node.span.start);
        return FilePlace { file: document.file_name.clone(), span: node.span.clone(), line };
    }
    let (file, span) = document.text.joined.span(&node.span);
    FilePlace { file: Arc::from(file.name.as_str()), span, line: document.line(node.span.start) }
}

fn measurements(
    document: &PlanDocument,
    here: &[PlacedEntry<'_>],
    guard: GuardBand,
    scope: &CaseNames<'_>,
    out: &mut Findings,
) -> Vec<Measurement> {
    let mut list = Vec::new();
    for PlacedEntry { node, call, .. } in here {
        scope.enter(call, out);
        let Some(table) = node.as_table() else { continue };
        let mut table = table.clone();
        // Which rows have it is settled; the rest is the measurement's own.
        table.entries.retain(|entry| entry.key != "rows");
        let before = out.errors();
        let fields = Fields::check(&table, node.span.clone(), "measurement", measure::KEYS, out);
        if out.errors() > before {
            continue;
        }
        let mut context = ReadContext { out, names: scope, place: node.span.clone() };
        if let Some(mut measurement) = measure::read(&fields, guard, &mut context) {
            if !call.path.is_empty() {
                measurement.name = format!("{}: {}", call.path, measurement.name);
            }
            measurement.place = Some(place(document, node));
            list.push(measurement);
        }
    }
    list
}
