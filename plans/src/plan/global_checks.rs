//! Invariants and alarms: claims that stand in a plan for all of its cases, or in a suite or board file for the cases
//! of all plans that it covers.
//!
//! Those of suites and boards are read once for what is wrong with them, and again for each case: a name that the case
//! has for something else gets another one in the trace.

use std::cell::RefCell;
use std::sync::Arc;

use document::{Diagnostic, Fields, Findings, KeySpec, KeyType, Node, SourceFile, Table, line_col, toml};
use record::ClaimOrigin;
use signal::Span;

use super::build::{expectation, place};
use super::envelope::EntryForm;
use super::expand::{PlacedEntry, present};
use super::keys::EXPECT_KEYS;
use super::names::CaseNames;
use super::read::PlanDocument;
use super::{Case, facts};
use crate::alarm::{Alarm, AlarmCondition};
use crate::codes;
use crate::expect::FilePlace;
use crate::expect::GlobalCheck;
use crate::lang::PlanNames;
use crate::lang::{Anchor, Bindings, Literal};
use crate::signals::{self, SIGNAL_TYPE};
use crate::signals::{SignalBinding, SignalSource};
use crate::steps::StepNames;

/// The keys of an alarm's `when`.
const WHEN_KEYS: &[KeySpec] = &[
    KeySpec::required("signal", KeyType::SignalRef, "The signal that is watched."),
    KeySpec::optional("above", KeyType::Value, "The limit that it must not stay above."),
    KeySpec::optional("below", KeyType::Value, "The limit that it must not stay below."),
    KeySpec::optional("is", KeyType::Value, "The value that it must not keep."),
];

/// The keys of an alarm.
pub(super) const ALARM_KEYS: &[KeySpec] = &[
    KeySpec::required("name", KeyType::Text, "What the alarm is called."),
    KeySpec::required("when", KeyType::Table(WHEN_KEYS), "What must not last."),
    KeySpec::optional("delay", KeyType::Duration, "How long it may last; not at all if left out."),
    KeySpec::optional(
        "hysteresis",
        KeyType::Quantity,
        "How far the value has to come back from the limit before the condition is over.",
    ),
    KeySpec::optional("ends", KeyType::Bool, "Whether it ends the case; true if left out."),
    KeySpec::optional("rows", KeyType::List(&KeyType::Text), "The rows that have it; all if left out."),
];

/// The keys of a suite file.
pub const SUITE_KEYS: &[KeySpec] = &[
    KeySpec::required("format", KeyType::Integer(1, 1), "The format of the suite file, 1."),
    KeySpec::optional("title", KeyType::Text, "What the plans of the suite have in common."),
    KeySpec::optional("signals", KeyType::Map(&SIGNAL_TYPE), "Names and what they stand for."),
    KeySpec::optional(
        "invariants",
        KeyType::List(&KeyType::Table(EXPECT_KEYS)),
        "What is claimed of every case of every plan.",
    ),
    KeySpec::optional(
        "alarms",
        KeyType::List(&KeyType::Table(ALARM_KEYS)),
        "What ends a case when it lasts.",
    ),
];

/// Most invariants and alarms of a file: each is followed in every case.
const MOST: usize = 200;

const INVARIANT: EntryForm = EntryForm {
    what: "invariant",
    list: "invariants",
    own: EXPECT_KEYS,
    code: codes::EXPECT_VERB,
    alone: None,
};

/// What was read for a case.
#[derive(Debug, Default)]
pub(super) struct CaseChecks {
    pub(super) invariants: Vec<GlobalCheck>,
    pub(super) alarms: Vec<Arc<Alarm>>,
}

/// The plan's own invariants and alarms for one of its cases.
pub(super) fn of_case(
    document: &PlanDocument,
    row: Option<&str>,
    bindings: &Bindings<'_>,
    scope: &CaseNames<'_>,
    out: &mut Findings,
) -> CaseChecks {
    let names = GlobalNames { scope, rename: &str::to_owned };
    let mut standing = CaseChecks::default();
    let plan = Default::default();
    for PlacedEntry { node, .. } in present(&document.invariants, row, bindings, &plan, out) {
        standing.invariant(&node, &names, ClaimOrigin::Plan, place(document, &node), out);
    }
    for PlacedEntry { node, .. } in present(&document.alarms, row, bindings, &plan, out) {
        standing.alarm(&node, &names, ClaimOrigin::Plan, place(document, &node), out);
    }
    standing
}

impl CaseChecks {
    fn invariant(
        &mut self,
        node: &Node,
        names: &GlobalNames<'_>,
        origin: ClaimOrigin,
        place: FilePlace,
        out: &mut Findings,
    ) {
        let Some(mut read) = expectation(node, &INVARIANT, names, out) else { return };
        // An instant after `@` is read with its signal.
        if let Some(anchor) = read.claim.anchors().into_iter().find(|anchor| anchor.base.step().is_some()) {
            hangs_on_step(anchor, node, out);
            return;
        }
        read.place = Some(place);
        self.invariants.push(GlobalCheck { expectation: read, origin });
    }

    fn alarm(
        &mut self,
        node: &Node,
        names: &GlobalNames<'_>,
        origin: ClaimOrigin,
        place: FilePlace,
        out: &mut Findings,
    ) {
        let Some(alarm) = alarm(node, names, origin, place, out) else { return };
        if self.alarms.iter().any(|known| known.name == alarm.name) {
            let message = format!("two alarms have the name `{}`", alarm.name);
            out.error(codes::NAME_TWICE, node.span.clone(), message, "give one of them another name");
            return;
        }
        self.alarms.push(Arc::new(alarm));
    }
}

fn hangs_on_step(anchor: &Anchor, node: &Node, out: &mut Findings) {
    let message = format!("`{anchor}` is an instant of a step, and an invariant holds in every case");
    let help = "count from `start` or `end`, or make it an expectation of the plan";
    out.bad(codes::GUARD_STEP, node, message, help);
}

fn alarm(
    node: &Node,
    names: &GlobalNames<'_>,
    origin: ClaimOrigin,
    place: FilePlace,
    out: &mut Findings,
) -> Option<Alarm> {
    let before = out.errors();
    let fields = Fields::check(node.as_table()?, node.span.clone(), "alarm", ALARM_KEYS, out);
    if out.errors() > before {
        return None;
    }
    let name = fields.text("name")?.trim().to_owned();
    let when = fields.inner("when")?;
    let signal = names.whole_signal(when.get("signal")?, out)?;
    let given: Vec<&str> = ["above", "below", "is"].into_iter().filter(|key| when.has(key)).collect();
    let [key] = given.as_slice() else {
        let place = fields.get("when").map_or_else(|| node.span.clone(), |when| when.span.clone());
        let message = "the alarm waits for nothing, or for two things";
        out.error(codes::ALARM, place, message, "give one of `above`, `below` and `is`");
        return None;
    };
    let limit = Literal::read(when.get(key)?, out)?;
    let mut hysteresis = None;
    if let Some(node) = fields.get("hysteresis") {
        let band = Literal::read(node, out)?;
        let number = band
            .quantity()
            .map_or_else(|| band.value().and_then(signal::Value::as_real), |band| Some(band.number.as_f64()));
        if *key == "is" {
            let message = "`hysteresis` does not apply to a value that is met or not";
            out.bad(codes::ALARM, node, message, "remove it, or give `above` or `below`");
            return None;
        }
        if number.is_none_or(|number| number < 0.0) {
            let help = "it says how far the value comes back from the limit, as in \"0.2 bar\"";
            out.bad(codes::ALARM, node, "the hysteresis is below 0", help);
            return None;
        }
        hysteresis = Some(band);
    }
    let condition = match *key {
        "above" => AlarmCondition::Above(limit),
        "below" => AlarmCondition::Below(limit),
        _ => AlarmCondition::Is(limit),
    };
    let delay = fields.duration("delay").unwrap_or(Span::ZERO);
    let ends = fields.boolean("ends") != Some(false);
    Some(Alarm { name, signal, condition, delay, hysteresis, ends, place, origin })
}

/// The names that a claim may speak of which holds in every case: none of a step, and signals as the trace of this
/// case calls them.
struct GlobalNames<'a> {
    scope: &'a CaseNames<'a>,
    rename: &'a dyn Fn(&str) -> String,
}

impl GlobalNames<'_> {
    fn whole_signal(&self, node: &Node, out: &mut Findings) -> Option<String> {
        Some((self.rename)(&self.scope.whole_signal(node, out)?))
    }
}

impl PlanNames for GlobalNames<'_> {
    fn anchor(&self, node: &Node, out: &mut Findings) -> Option<Anchor> {
        if let Some(anchor) = node.as_text().and_then(|text| Anchor::parse(text).ok())
            && anchor.base.step().is_some()
        {
            hangs_on_step(&anchor, node, out);
            return None;
        }
        self.scope.anchor(node, out)
    }

    fn signal(&self, node: &Node, out: &mut Findings) -> Option<String> {
        Some((self.rename)(&self.scope.signal(node, out)?))
    }

    fn at_value(&self, node: &Node, out: &mut Findings) -> Option<(String, Option<Anchor>)> {
        let (name, at) = self.scope.at_value(node, out)?;
        Some(((self.rename)(&name), at))
    }
}

/// The invariants and alarms of a suite or board file, without what is wrong with them.
#[derive(Clone, Debug)]
pub struct GlobalChecks {
    file: SourceFile,
    name: Arc<str>,
    origin: ClaimOrigin,
    signals: Vec<SignalBinding>,
    invariants: Vec<Node>,
    alarms: Vec<Node>,
    /// What is worth knowing about the file.
    pub warnings: Vec<Diagnostic>,
}

impl GlobalChecks {
    /// Reads a suite file.
    ///
    /// # Errors
    /// Everything that is wrong with it, with codes of [`crate::CODES`].
    pub fn of_suite(file: &SourceFile) -> Result<GlobalChecks, Vec<Diagnostic>> {
        let root = toml::parse(file, codes::TOML)?;
        let mut out = Findings::new(file, codes::TOML);
        let mut head = root.clone();
        // Entries with verbs have keys of their own.
        head.entries.retain(|entry| !["invariants", "alarms"].contains(&entry.key.as_str()));
        let fields = Fields::check(&head, 0..0, "suite file", SUITE_KEYS, &mut out);
        let table = fields.get("signals").and_then(Node::as_table);
        let signals = table.map_or_else(Vec::new, |table| signals::read(table, &mut out));
        GlobalChecks::read(file, ClaimOrigin::Suite, &root, signals, out)
    }

    /// Reads what a board file says besides the board: its names are the board's channels and the controller's
    /// terminals. The rest of the file is read by others.
    ///
    /// # Errors
    /// Everything that is wrong with its invariants and alarms.
    pub fn of_board(file: &SourceFile) -> Result<GlobalChecks, Vec<Diagnostic>> {
        let root = toml::parse(file, codes::TOML)?;
        GlobalChecks::read(file, ClaimOrigin::Board, &root, Vec::new(), Findings::new(file, codes::TOML))
    }

    fn read(
        file: &SourceFile,
        origin: ClaimOrigin,
        root: &Table,
        signals: Vec<SignalBinding>,
        mut out: Findings,
    ) -> Result<GlobalChecks, Vec<Diagnostic>> {
        let mut list = |key| entries(root, key, &mut out);
        let (invariants, alarms) = (list("invariants"), list("alarms"));
        let name = Arc::from(file.name.as_str());
        let mut guards = GlobalChecks {
            file: file.clone(),
            name,
            origin,
            signals,
            invariants,
            alarms,
            warnings: Vec::new(),
        };
        let scope = guards.scope();
        guards.standing(&scope, &str::to_owned, &mut out);
        let spoken_of = scope.spoken_of.into_inner();
        let failed = out.has_errors();
        // What is not used may be what a wrong entry means.
        let unused = guards.signals.iter().filter(|bound| !failed && !spoken_of.contains(&bound.name));
        unused.for_each(|bound| super::check::unused(bound, &mut out));
        let found = out.into_vec();
        if failed {
            return Err(found);
        }
        guards.warnings = found;
        Ok(guards)
    }

    /// The file.
    pub fn file(&self) -> &SourceFile {
        &self.file
    }

    /// The kind of the file.
    pub fn origin(&self) -> ClaimOrigin {
        self.origin
    }

    /// Whether it guards nothing.
    pub fn is_empty(&self) -> bool {
        self.invariants.is_empty() && self.alarms.is_empty()
    }

    fn scope(&self) -> CaseNames<'_> {
        CaseNames {
            steps: Default::default(),
            parts: Default::default(),
            call: RefCell::default(),
            elsewhere: Vec::new(),
            row: None,
            bound_names: self.signals.iter().map(|binding| binding.name.clone()).collect(),
            bound: self.signals.clone(),
            spoken_of: RefCell::default(),
            used: RefCell::default(),
            // Nothing of it drives a signal.
            tables: &crate::table::NONE,
            databases: &crate::frames::can::NONE,
            frames: Default::default(),
        }
    }

    /// Reads every entry by the names of `scope`, which the trace calls as `rename` says.
    fn standing(
        &self,
        scope: &CaseNames<'_>,
        rename: &dyn Fn(&str) -> String,
        out: &mut Findings,
    ) -> CaseChecks {
        let names = GlobalNames { scope, rename };
        let place = |node: &Node| {
            let line = u32::try_from(line_col(&self.file.text, node.span.start).0).unwrap_or(u32::MAX);
            FilePlace { file: self.name.clone(), span: node.span.clone(), line }
        };
        let mut standing = CaseChecks::default();
        for node in &self.invariants {
            standing.invariant(node, &names, self.origin, place(node), out);
        }
        for node in &self.alarms {
            standing.alarm(node, &names, self.origin, place(node), out);
        }
        standing
    }

    /// Adds the invariants and alarms, and the signals that they speak of, to a case.
    ///
    /// # Errors
    /// An alarm whose name the case has already.
    pub fn attach(&self, case: &mut Case) -> Result<(), Vec<Diagnostic>> {
        // What a name of this file is called in the trace is known when it is known what it stands for; so the
        // entries are read twice, first for the names.
        let mut out = Findings::new(&self.file, codes::TOML);
        let scope = self.scope();
        self.standing(&scope, &str::to_owned, &mut out);
        let spoken_of = scope.spoken_of.borrow().clone();
        let bound = self.signals.iter().filter(|binding| spoken_of.contains(&binding.name)).cloned();
        let mut bindings: Vec<SignalBinding> = bound.collect();
        bindings.extend(scope.used.borrow().list.iter().cloned());
        let mut aliases: Vec<(String, String)> = Vec::new();
        let mut added = Vec::new();
        for mut binding in bindings {
            if let (ClaimOrigin::Board, SignalSource::Path(name)) = (self.origin, &binding.source) {
                // A board knows no program: its own names go before those of any.
                binding.source = SignalSource::Channel(name.clone());
            }
            let name = alias(&binding, case, self.origin);
            aliases.push((std::mem::replace(&mut binding.name, name.clone()), name));
            if !case.signals.iter().any(|known| known.name == binding.name) {
                binding.file = Some(self.name.clone());
                added.push(binding);
            }
        }
        let rename = |name: &str| {
            let alias = aliases.iter().find(|(known, _)| known == name);
            alias.map_or_else(|| name.to_owned(), |(_, alias)| alias.clone())
        };
        let standing = self.standing(&self.scope(), &rename, &mut out);
        for alarm in &standing.alarms {
            if let Some(first) = case.alarms.iter().find(|known| known.name == alarm.name) {
                let message = format!("two alarms have the name `{}`", alarm.name);
                let found = Diagnostic::error(codes::NAME_TWICE, message)
                    .at(&*self.name, alarm.place.span.clone(), "the second")
                    .at(&*first.place.file, first.place.span.clone(), "the first");
                out.push(found.help("give one of them another name"));
            }
        }
        if out.has_errors() {
            return Err(out.into_vec());
        }
        facts::implied_needs(&[], &added, &mut case.needs);
        case.signals.extend(added);
        case.invariants.extend(standing.invariants);
        case.alarms.extend(standing.alarms);
        Ok(())
    }
}

/// The entries of a list of the file; reports what is no table, too many, and rows.
fn entries(root: &Table, key: &str, out: &mut Findings) -> Vec<Node> {
    let Some(node) = root.get(key) else { return Vec::new() };
    let Some(list) = node.as_array() else {
        let help = format!("write {key} = [ ... ] with one {{ ... }} per line, or [[{key}]]");
        out.bad(codes::WRONG_TYPE, node, format!("`{key}` is {}, not a list", node.kind()), help);
        return Vec::new();
    };
    if let Some(node) = list.get(MOST) {
        let message = format!("`{key}` has more than {MOST} entries");
        out.bad(codes::TOO_LARGE, node, message, "each of them is followed in every case");
    }
    for node in list {
        let Some(table) = node.as_table() else {
            let message = format!("an entry of `{key}` is {}, not a table", node.kind());
            out.bad(codes::WRONG_TYPE, node, message, "write it as { ... }");
            continue;
        };
        if let Some(rows) = table.entry("rows") {
            let help = "what only some rows have belongs into their plan";
            out.error(codes::UNKNOWN_ROW, rows.key_span.clone(), "a file beside the plans has no rows", help);
        }
    }
    list.to_vec()
}

/// What the trace of a case calls a signal of another file: its own name, unless the case has that for something else
/// or does not record all of it.
fn alias(binding: &SignalBinding, case: &Case, origin: ClaimOrigin) -> String {
    let word = if origin == ClaimOrigin::Board { "board" } else { "suite" };
    let names = std::iter::once(binding.name.clone())
        .chain(std::iter::once(format!("{word} {}", binding.name)))
        .chain((2..).map(|count| format!("{word} {} {count}", binding.name)));
    let free = |name: &String| {
        let known = case.signals.iter().find(|known| known.name == *name);
        known.is_none_or(|known| known.source == binding.source && known.recording == binding.recording)
    };
    let mut names = names.filter(free);
    names.next().unwrap_or_default()
}
