//! A plan's text to a plan: what holds for all cases is read once, every case is checked and then made again
//! when it is asked for, so that a plan of many cases needs no memory for them.

use std::ops::Range;
use std::sync::Arc;

use document::{Data, Diagnostic, Entry, Findings, Joined, Node, SourceFile, Table};
use profile::Profile;

use super::build;
use super::check::Unspoken;
use super::envelope::{self, ListEntry};
use super::groups::{self, PlanGroup};
use super::include::{PlanText, gather};
use super::variants::Variants;
use super::{Case, refusal, uncalled};
use crate::codes;
use crate::steps::ProgramRef;

/// Most cases of a plan.
pub const MAX_CASES: u64 = 100_000;
/// Most steps of a plan.
pub const MAX_STEPS: usize = 10_000;
/// Most values, in all cases together, that a plan may have: bounds the time that checking it takes.
const MAX_WORK: u64 = 3_000_000;
/// Reading stops after this many cases with errors: further ones say the same.
const MAX_FAULTY_CASES: usize = 10;

/// Keys of the root that are not the same table for each case, or are read once.
const APART: &[&str] = &[
    "include",
    "setup",
    "steps",
    "teardown",
    "expect",
    "measure",
    "group",
    "invariants",
    "alarms",
    "rows",
    "sweep",
    "parameters",
    "program-text",
    "description",
];

/// The lists of steps, in the order in which they come.
const STEPS: [&str; 3] = ["setup", "steps", "teardown"];

/// What was read of a plan's text before its cases are made.
#[derive(Debug)]
pub(super) struct PlanDocument {
    pub(super) file: SourceFile,
    /// It and the files that it includes.
    pub(super) text: PlanText,
    /// The file's name, for places of claims.
    pub(super) file_name: Arc<str>,
    /// The plan's path without `.toml`: the first part of every case's name.
    pub(super) name: String,
    /// The root without [`APART`].
    pub(super) head: Table,
    /// Setup, main and teardown, one after another.
    pub(super) steps: Vec<ListEntry>,
    pub(super) groups: Vec<PlanGroup>,
    pub(super) expect: Vec<ListEntry>,
    pub(super) measure: Vec<ListEntry>,
    pub(super) invariants: Vec<ListEntry>,
    pub(super) alarms: Vec<ListEntry>,
    pub(super) variants: Variants,
    pub(super) program_text: Option<ProgramRef>,
    /// The byte at which each line begins.
    lines: Vec<usize>,
    pub(super) seed: u64,
}

impl PlanDocument {
    /// The line of a byte, from 1.
    pub(super) fn line(&self, byte: usize) -> u32 {
        if !self.text.joined.is_first(byte) {
            return self.text.joined.line(byte);
        }
        u32::try_from(self.lines.partition_point(|start| *start <= byte)).unwrap_or(u32::MAX)
    }
}

/// A plan that was read and found right: every one of its cases can be made.
#[derive(Debug)]
pub struct Plan {
    /// Path as the user gave it.
    pub path: String,
    /// What it shows; the file's name where the plan does not say.
    pub title: String,
    /// What a reader should know.
    pub description: String,
    /// IDs of the requirements that it proves.
    pub proves: Vec<String>,
    /// The profiles that it holds for; empty for all.
    pub profiles: Vec<Profile>,
    /// What is worth knowing about it.
    pub warnings: Vec<Diagnostic>,
    turns: u64,
    document: PlanDocument,
}

impl Plan {
    /// Number of cases.
    pub fn len(&self) -> u64 {
        self.document.variants.len()
    }

    /// Never: a plan that was found right has a case.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where the value of a key of the plan stands, in the bytes of all its files; its beginning where it has none.
    pub fn place_of(&self, key: &str) -> Range<usize> {
        self.document.head.entry(key).map_or(0..0, |entry| entry.node.span.clone())
    }

    /// The case of this number from 0; `None` after the last.
    pub fn case(&self, number: u64) -> Option<Case> {
        self.case_with(number, self.document.seed).ok()
    }

    /// The case of this number from 0 with another seed for what it leaves to chance.
    ///
    /// # Errors
    /// What is wrong with it: a phase that is drawn again can move a step after the end of the case.
    pub fn case_with(&self, number: u64, seed: u64) -> Result<Case, Vec<Diagnostic>> {
        let mut out = Findings::new(&self.document.file, codes::TOML);
        build::case(&self.document, number, seed, &mut out).ok_or_else(|| out.into_vec())
    }

    /// Number of runs: each case as often as it is repeated.
    pub fn turns(&self) -> u64 {
        self.turns
    }

    /// All cases in order, made one by one.
    pub fn cases(&self) -> impl Iterator<Item = Case> + '_ {
        (0..self.len()).filter_map(|number| self.case(number))
    }

    /// The plan's text.
    pub fn source(&self) -> &SourceFile {
        &self.document.file
    }

    /// The plan as it was gathered, to be read again.
    pub fn text(&self) -> &PlanText {
        &self.document.text
    }

    /// The plan's text with those of the files that it includes. The places of its cases count through all of them:
    /// [`Joined::locate`] names the right file in findings about them.
    pub fn joined(&self) -> &Joined {
        &self.document.text.joined
    }
}

/// Reads a plan that names no other files. `parameters` are name and value of what the command line gives; `seed` decides what the plan
/// leaves to chance.
///
/// # Errors
/// Everything that is wrong with the plan, in its cases as they would run, with codes of [`crate::CODES`].
pub fn read(file: &SourceFile, parameters: &[(String, String)], seed: u64) -> Result<Plan, Vec<Diagnostic>> {
    let text = gather(file, &mut |_| Err(String::from("no files can be included here")))?;
    read_gathered(&text, parameters, seed)
}

/// Reads a plan with what it includes, as [`gather`] made it. `parameters` are name and value of what the command line
/// gives; `seed` decides what the plan leaves to chance.
///
/// # Errors
/// Everything that is wrong with the plan, in its cases as they would run, with codes of [`crate::CODES`].
pub fn read_gathered(
    text: &PlanText,
    parameters: &[(String, String)],
    seed: u64,
) -> Result<Plan, Vec<Diagnostic>> {
    let locate = |mut found: Vec<Diagnostic>| {
        text.joined.locate(&mut found);
        found
    };
    let mut plan = read_joined(text, parameters, seed).map_err(locate)?;
    text.joined.locate(&mut plan.warnings);
    Ok(plan)
}

/// The plan, with findings whose places count through all files.
fn read_joined(text: &PlanText, parameters: &[(String, String)], seed: u64) -> Result<Plan, Vec<Diagnostic>> {
    let file = text.file();
    let mut out = Findings::new(file, codes::TOML);
    if !format_is_known(&text.root, &mut out) {
        return Err(out.into_vec());
    }
    let root = text.merged(&mut out);
    let mut variants = Variants::read(&root, parameters, &mut out);
    let Some(groups) = groups::read(&root, &mut out) else { return Err(out.into_vec()) };
    let steps: Vec<ListEntry> =
        STEPS.iter().flat_map(|key| envelope::list(&root, key, &variants.rows, &mut out)).collect();
    let expect = envelope::list(&root, "expect", &variants.rows, &mut out);
    let measure = envelope::list(&root, "measure", &variants.rows, &mut out);
    let invariants = envelope::list(&root, "invariants", &variants.rows, &mut out);
    let alarms = envelope::list(&root, "alarms", &variants.rows, &mut out);
    for (group, is_run) in groups.iter().zip(groups::run_by_steps(&steps, &groups)) {
        if is_run {
            continue;
        }
        // What another file defines is there for those plans that use it.
        if text.joined.is_first(group.place.start) {
            let message =
                format!("no step runs the group `{}`: nothing of it is done or claimed", group.name);
            let help = format!("add a step with run = {{ group = \"{}\" }}, or remove the group", group.name);
            out.error(codes::GROUP_NOT_RUN, group.place.clone(), message, help);
        } else {
            uncalled::check(group, &mut out);
        }
    }
    if steps.len() > MAX_STEPS {
        let message = format!("the plan has {} steps; {MAX_STEPS} is the most", steps.len());
        out.error(
            codes::TOO_MANY_STEPS,
            steps[MAX_STEPS].node.span.clone(),
            message,
            "a train has many pulses",
        );
        return Err(out.into_vec());
    }
    let claims = [&expect, &measure, &invariants, &alarms];
    let of_group = |group: &PlanGroup| !group.expect.is_empty() || !group.measure.is_empty();
    if claims.iter().all(|list| list.is_empty())
        && !groups.iter().any(of_group)
        && !refusal::is_there(&root)
        && !out.has_errors()
    {
        let help = "add expect = [ ... ] or measure = [ ... ]: a plan that claims nothing would always pass";
        out.error(codes::NOTHING_CLAIMED, 0..0, "the plan neither claims nor measures anything", help);
    }
    let nodes: u64 = [&steps, &expect, &measure, &invariants, &alarms]
        .iter()
        .flat_map(|list| list.iter())
        .map(|one| size(&one.node))
        .chain(
            root.entries
                .iter()
                .filter(|entry| !APART.contains(&entry.key.as_str()))
                .map(|entry| size(&entry.node)),
        )
        .chain([groups::weight(&steps, &groups)])
        .fold(0, u64::saturating_add);
    if !is_feasible(variants.rows.len() as u64, nodes, &mut out) {
        return Err(out.into_vec());
    }
    variants.count(
        |row| {
            let here = steps.iter().enumerate().filter(|(_, step)| step.is_in(row));
            here.filter_map(|(at, step)| Some((at, positions(&step.node)?))).collect()
        },
        &mut out,
    );
    let program_text = program_text(&root, &mut out);
    let description = description(&root, &mut out);
    let mut head = root;
    head.entries.retain(|entry| !APART.contains(&entry.key.as_str()));
    if !is_feasible(variants.len(), nodes, &mut out) {
        return Err(out.into_vec());
    }
    let document = PlanDocument {
        file: file.clone(),
        text: text.clone(),
        file_name: Arc::from(file.name.as_str()),
        name: file.name.strip_suffix(".toml").unwrap_or(&file.name).to_owned(),
        head,
        steps,
        groups,
        expect,
        measure,
        invariants,
        alarms,
        variants,
        program_text,
        lines: line_starts(&file.text),
        seed,
    };
    let mut first = None;
    let mut turns = 0;
    let mut faulty = 0;
    let mut unspoken = Unspoken::default();
    for number in 0..document.variants.len() {
        let before = out.errors();
        let case = build::case(&document, number, seed, &mut out);
        turns += case.as_ref().map_or(0, |case| u64::from(case.repeat));
        match &case {
            // A case that is refused has no use for its names.
            Some(case) if case.refusal.is_none() => unspoken.case(&case.unspoken),
            _ => {}
        }
        if number == 0 {
            first = case;
        }
        faulty += usize::from(out.errors() > before);
        if faulty >= MAX_FAULTY_CASES || out.is_full() {
            break;
        }
    }
    if turns > MAX_CASES {
        let place = document.head.entry("repeat").map_or(0..0, |entry| entry.node.span.clone());
        let message = format!("the cases have {turns} turns together; {MAX_CASES} is the most");
        out.error(codes::TOO_MANY_TURNS, place, message, "repeat them less often");
    }
    let failed = out.has_errors();
    if let (false, Some(first)) = (failed, &first) {
        unspoken.report(&first.signals, &mut out);
        super::check::guard_of_nothing(&document, &mut out);
    }
    let found = out.into_vec();
    let first = match first {
        Some(first) if !failed => first,
        _ => return Err(found),
    };
    Ok(Plan {
        path: file.name.clone(),
        title: document.head.get("title").and_then(Node::as_text).unwrap_or(&document.name).to_owned(),
        description,
        proves: first.proves,
        profiles: first.profiles,
        warnings: found,
        turns,
        document,
    })
}

/// Whether the plan is of format 1. Of another one nothing else can be said.
fn format_is_known(root: &Table, out: &mut Findings) -> bool {
    match root.entry("format").map(|entry| &entry.node) {
        Some(Node { data: Data::Integer(1), .. }) => true,
        Some(node) => {
            let help = "this rig reads format = 1";
            out.error(codes::FORMAT, node.span.clone(), "the plan's format is not supported", help);
            false
        }
        // That it is missing is reported with the other keys; the rest is read as format 1.
        None => true,
    }
}

/// How many cases the phase of a step makes; `None` without a phase.
fn positions(step: &Node) -> Option<u64> {
    let phase = step.as_table()?.get("phase")?.as_table()?;
    match phase.get("positions").map(|node| &node.data) {
        Some(Data::Integer(count)) => Some(u64::try_from(*count).unwrap_or(1).max(1)),
        // Wrong ones are reported when the step is read.
        _ => None,
    }
}

fn program_text(root: &Table, out: &mut Findings) -> Option<ProgramRef> {
    let entry = root.entry("program-text")?;
    if let Some(program) = root.entry("program") {
        let message = "the plan has both `program` and `program-text`";
        out.error(codes::PROGRAM, program.key_span.clone(), message, "leave one of them");
    }
    let text = text_of(entry, "write it between ''' and '''", out)?;
    Some(ProgramRef::Text { text: text.to_owned(), at: entry.node.content })
}

fn description(root: &Table, out: &mut Findings) -> String {
    let entry = root.entry("description");
    entry.and_then(|entry| text_of(entry, "write it in quotes", out)).unwrap_or_default().to_owned()
}

/// The text of a key in which references are not replaced.
fn text_of<'t>(entry: &'t Entry, help: &str, out: &mut Findings) -> Option<&'t str> {
    let text = entry.node.as_text();
    if text.is_none() {
        let message = format!("`{}` is {}, not a text", entry.key, entry.node.kind());
        out.error(codes::WRONG_TYPE, entry.node.span.clone(), message, help);
    }
    text
}

/// Reports so many cases of so many values that checking them would take too long.
fn is_feasible(cases: u64, nodes: u64, out: &mut Findings) -> bool {
    let feasible = cases.saturating_mul(nodes.max(1)) <= MAX_WORK;
    if !feasible {
        let message = format!("{cases} cases of {nodes} values each are too many");
        out.error(codes::TOO_MANY_CASES, 0..0, message, "widen the steps of a sweep, or split the plan");
    }
    feasible
}

/// Number of values in a value, itself included.
pub(super) fn size(node: &Node) -> u64 {
    match &node.data {
        Data::Array(list) => 1 + list.iter().map(size).sum::<u64>(),
        Data::Table(table) => 1 + table.entries.iter().map(|entry| size(&entry.node)).sum::<u64>(),
        _ => 1,
    }
}

fn line_starts(text: &str) -> Vec<usize> {
    let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1);
    std::iter::once(0).chain(ends).collect()
}
