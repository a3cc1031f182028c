//! The register held against the shipped plans, without running them: `tests/run` runs them by themselves.

use super::status::{self, ProofStatus, RegisterRow};
use crate::plan_files::library::{self, REGISTER, ShippedFiles};
use plans::Case;
use plans::register::{OPEN, RequirementClass, RequirementRegister};
use plans::signals::SignalSource;
use record::{CaseRecord, RunRecord, Verdict};
use runtime::suite;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What is known to fall short of the rule, in lists that only become shorter.
const EXCEPTIONS: &str = include_str!("../../../../plans/register-exceptions.toml");

/// What the shipped plans cite.
struct ShippedCitations {
    /// A run in which every case passed.
    run: RunRecord,
    /// What is cited by a case that claims something outside of the controller's own words.
    seen_outside: BTreeSet<String>,
}

fn citations() -> ShippedCitations {
    let mut found = ShippedCitations { run: RunRecord::default(), seen_outside: BTreeSet::new() };
    for path in library::plans() {
        let loaded = suite::load_plan(&ShippedFiles, &path, None, &[], 1, &mut Vec::new()).unwrap();
        let outside: Vec<bool> = loaded.plan.cases().map(|case| looks_outside(&case)).collect();
        for job in loaded.jobs(0, 1, 1) {
            if outside[usize::try_from(job.case).unwrap()] {
                found.seen_outside.extend(job.proves.iter().cloned());
            }
            found.run.push(CaseRecord {
                name: job.name,
                profile: job.profile.name().to_owned(),
                proves: job.proves,
                verdict: Verdict::Pass,
                ..CaseRecord::default()
            });
        }
    }
    found
}

/// Whether a case claims or measures something at a terminal, in a register or at an indicator, or of what is refused: not
/// only states, figures, logs and variables, which the controller says of itself.
fn looks_outside(case: &Case) -> bool {
    let outside = |name: &str| {
        case.signals.iter().any(|bound| {
            bound.name == name
                && match &bound.source {
                    SignalSource::Line(_)
                    | SignalSource::Memory(_)
                    | SignalSource::Image(_)
                    | SignalSource::Channel(_)
                    | SignalSource::Register { .. }
                    | SignalSource::Frames(_)
                    | SignalSource::FrameSignal(_)
                    | SignalSource::Relocation { .. } => true,
                    // Clients read them by their registers.
                    SignalSource::Path(path) => path.starts_with("PLC_R.") || path.starts_with("PLC_W."),
                    SignalSource::Task { .. } | SignalSource::Log(_) | SignalSource::File { .. } => false,
                }
        })
    };
    case.refusal.is_some()
        || case
            .expectations
            .iter()
            .any(|one| one.verb == "led" || one.claim.signals().iter().any(|name| outside(name)))
        || case.measurements.iter().any(|one| one.signals().iter().any(|name| outside(name)))
}

/// Whether a line shows several statements: a semicolon, a table, words for more than one guide, or *and* before a verb.
/// It finds too many: a reader takes one off the list by clauses or by a line that says one thing.
fn shows_several_statements(asks: &str) -> bool {
    const VERBS: [&str; 46] = [
        "adds",
        "alternates",
        "are",
        "can",
        "cannot",
        "changes",
        "clears",
        "counts",
        "disables",
        "does",
        "ends",
        "gives",
        "goes",
        "has",
        "have",
        "holds",
        "ignores",
        "is",
        "keeps",
        "leaves",
        "lets",
        "lights",
        "loses",
        "makes",
        "may",
        "must",
        "produces",
        "puts",
        "reacts",
        "reads",
        "receives",
        "reports",
        "resets",
        "restarts",
        "retries",
        "returns",
        "runs",
        "saves",
        "sets",
        "shows",
        "starts",
        "stays",
        "stops",
        "takes",
        "waits",
        "writes",
    ];
    let words: Vec<&str> = asks.split([' ', ',', ':', '(', ')']).filter(|word| !word.is_empty()).collect();
    let guides = ["2014", "2019", "M251"].into_iter().filter(|guide| asks.contains(guide)).count();
    asks.contains(';')
        || guides > 1
        || words.iter().any(|word| ["table", "tabulated", "matrix"].contains(word))
        || words.windows(2).any(|pair| pair[0] == "and" && VERBS.contains(&pair[1]))
}

/// Fails with what has to be added to a list of the exceptions, which needs a reason that a reviewer accepts, and what can
/// be taken off.
fn held_against(list: &str, found: &BTreeSet<String>) {
    let file = document::SourceFile::new("register-exceptions.toml", EXCEPTIONS);
    let table = document::toml::parse(&file, plans::TOML).unwrap();
    let listed = table.get(list).and_then(document::Node::as_array).unwrap();
    let names: Vec<&str> = listed.iter().map(|name| name.as_text().unwrap()).collect();
    assert!(names.is_sorted(), "`{list}` is not in order");
    let listed: BTreeSet<String> = names.iter().map(|name| (*name).to_owned()).collect();
    assert_eq!(listed.len(), names.len(), "`{list}` names one twice");
    let new: Vec<&String> = found.difference(&listed).collect();
    let gone: Vec<&String> = listed.difference(found).collect();
    assert!(
        new.is_empty() && gone.is_empty(),
        "`{list}` of plans/register-exceptions.toml\nnew, to be corrected: {new:#?}\nto be taken off: {gone:#?}"
    );
}

#[test]
fn the_register_says_of_each_requirement_what_its_proof_lacks() {
    let register = RequirementRegister::read(REGISTER).unwrap();
    let found = citations();
    let proofs = status::proofs(&found.run);
    let unknown: Vec<&String> = proofs.keys().filter(|cited| !register.knows(cited)).collect();
    assert!(unknown.is_empty(), "cited, but not in the register: {unknown:#?}");
    let rows = status::rows(&register, &proofs);
    let single = |row: &&RegisterRow<'_>| row.id.contains('#') || row.entry.clauses.is_empty();
    let mut wrong = Vec::new();
    for row in rows.iter().filter(single) {
        let (open, decision) = (row.proof.open.is_some(), row.proof.decision.is_some());
        let stand_in = !row.proof.stand_in.is_empty();
        let cited = row.profiles.iter().any(|(.., cases)| !cases.is_empty());
        match row.status {
            ProofStatus::NotProven if !open => wrong.push(format!("{}: has no `open`", row.id)),
            ProofStatus::NotProven if decision || stand_in => {
                wrong.push(format!("{}: nothing proves it, by decision or stand-in either", row.id));
            }
            status if status.is_proven() && open => wrong.push(format!("{}: is proven, and `open`", row.id)),
            _ => {}
        }
        if row.proof.class == RequirementClass::NotReproducible && cited {
            wrong.push(format!("{}: is cited, and not reproducible", row.id));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");

    let tables = rows.iter().filter(|row| !single(row));
    let whole = tables.filter(|row| proofs.contains_key(&row.id));
    held_against("cited-whole", &whole.map(|row| row.id.clone()).collect());
    let inside = rows.iter().filter(single).filter(|row| proofs.contains_key(&row.id));
    let inside = inside.filter(|row| !found.seen_outside.contains(&row.id));
    held_against("no-terminal", &inside.map(|row| row.id.clone()).collect());
}

#[test]
fn a_line_of_several_statements_has_clauses() {
    let register = RequirementRegister::read(REGISTER).unwrap();
    let several = register.entries.iter().filter(|entry| {
        entry.clauses.is_empty()
            && entry.proof.class != RequirementClass::NotReproducible
            // Until something proves it, nothing can be proven of half of it.
            && entry.proof.open.is_none()
            && shows_several_statements(&entry.asks)
    });
    held_against("several-statements", &several.map(|entry| entry.id.clone()).collect());
}

#[test]
fn statements_are_found_by_words() {
    for one in [
        "STOP in RUNNING gives STOPPED",
        "Retain and persistent store holds 64 Kbytes",
        "A task has priority, type with interval or event, and watchdog settings",
    ] {
        assert!(!shows_several_statements(one), "{one}");
    }
    for several in [
        "Priorities 0 to 31 are accepted; other numbers are refused",
        "The output falls and stays at 0",
        "5 kHz under the 2014 profile, 1 kHz under 2019",
        "Folders match the table of the profile",
    ] {
        assert!(shows_several_statements(several), "{several}");
    }
}

#[test]
fn what_the_register_names_is_there() {
    let register = RequirementRegister::read(REGISTER).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/decisions");
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let numbers: BTreeSet<u16> =
        names.filter_map(|name| name.to_str().and_then(|name| name.get(..4)?.parse().ok())).collect();
    let facts = |entry: &plans::register::Requirement| {
        let clauses = entry.clauses.iter().map(|clause| clause.proof.clone());
        std::iter::once(entry.proof.clone()).chain(clauses).collect::<Vec<_>>()
    };
    let mut open = BTreeMap::new();
    for fact in register.entries.iter().flat_map(facts) {
        if let Some(number) = fact.decision {
            assert!(numbers.contains(&number), "there is no decision {number}");
        }
        if let Some(word) = fact.open {
            *open.entry(word).or_insert(0) += 1;
        }
    }
    // A word that nothing waits for any more is a part that is there.
    let unused: Vec<&&str> = OPEN.iter().filter(|word| !open.contains_key(**word)).collect();
    assert!(unused.is_empty(), "nothing waits for {unused:?}: take it off `OPEN` and docs/requirements.md");
}
