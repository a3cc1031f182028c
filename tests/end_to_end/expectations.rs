//! Every verb of `expect` and every kind of measurement, passing, failing and left open, word for word.
//!
//! `tests/verbs/expect/VERB.toml` has a row for each; `VERB.txt` beside it is what a user reads of them.
//! `SCANRIG_BLESS=1 cargo test -p scanrig-cli --test end_to_end expectations` writes the texts again.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use record::{CaseRecord, Verdict};
use reports::text::{Style, details};

use crate::plan_folder::PlanFolder;
use crate::project_folder::root;

/// A step that did not come fails its case by itself, so that the claim about it is never what leaves one open; and the
/// model knows the figures of its tasks at every instant.
const NEVER_OPEN: &[&str] = &["happens", "task"];

/// The kinds of measurements: each key that names one, each way to take a value over a window.
const MEASUREMENTS: &[&str] = &[
    "time",
    "value",
    "min",
    "max",
    "mean",
    "rms",
    "span",
    "frequency",
    "duty",
    "period",
    "width",
    "jitter",
    "position",
    "profile",
    "speed",
];

/// What a user reads of a case, and the figures of what passed.
fn shown(case: &CaseRecord) -> String {
    let mut out = details(case, Style::default());
    for claim in case.claims.iter().filter(|claim| claim.verdict == Verdict::Pass) {
        let margin = claim.margin.as_ref().map_or(String::new(), |margin| format!(", margin {margin}"));
        writeln!(out, "  ✓ {}: {}{margin}", claim.expected, claim.observed).unwrap();
    }
    for taken in case.measurements.iter().filter(|taken| taken.verdict == Verdict::Pass) {
        let margin = taken.margin.as_ref().map_or(String::new(), |margin| format!(", margin {margin}"));
        writeln!(out, "  ✓ {}: {:?} {}{margin}", taken.what, taken.value.unwrap(), taken.unit).unwrap();
    }
    out
}

/// Runs the plan of each name and compares what comes of it.
fn check(folder: &str, names: &[&str], never_open: &[&str]) {
    let path = root().join("tests/verbs").join(folder);
    let mut wrong = String::new();
    for name in names {
        let plan = format!("{name}.toml");
        assert!(path.join(&plan).is_file(), "tests/verbs/{folder}/{plan} is missing");
        let records = PlanFolder { path: path.clone(), changed: None }.run(&plan, 1);
        let text: String = records.iter().map(shown).collect::<Vec<_>>().join("\n");
        let verdicts: Vec<Verdict> = records.iter().map(|record| record.verdict).collect();
        let open = if never_open.contains(name) { None } else { Some(Verdict::Inconclusive) };
        let wanted: Vec<Verdict> =
            [Some(Verdict::Pass), Some(Verdict::Fail), open].into_iter().flatten().collect();
        assert_eq!(verdicts, wanted, "{plan}: {text}");
        let golden = path.join(format!("{name}.txt"));
        if std::env::var_os("SCANRIG_BLESS").is_some() {
            std::fs::write(&golden, &text).unwrap();
        }
        let known = std::fs::read_to_string(&golden).unwrap_or_default();
        if known != text {
            write!(wrong, "{folder}/{name} reads now:\n{text}\nand should read:\n{known}\n").unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    no_others(&path, names);
}

/// A plan of a verb that is no more would be run by nobody.
fn no_others(path: &Path, names: &[&str]) {
    let files = std::fs::read_dir(path).unwrap().map(|file| file.unwrap().path());
    let found: BTreeSet<String> =
        files.map(|file| file.file_stem().unwrap().to_string_lossy().into_owned()).collect();
    let names: BTreeSet<String> = names.iter().map(|name| (*name).to_owned()).collect();
    assert_eq!(found, names);
}

#[test]
fn every_verb_of_expect() {
    let names: Vec<&str> = plans::expect::VERBS.iter().map(|verb| verb.name).collect();
    check("expect", &names, NEVER_OPEN);
}

#[test]
fn every_kind_of_measurement() {
    check("measure", MEASUREMENTS, &[]);
    let mut known: BTreeSet<String> = MEASUREMENTS.iter().map(|name| (*name).to_owned()).collect();
    // A kind that is added to the keys has to be added here. The first of several is what `width` takes.
    let keys = plans::measure::KEYS.iter().filter_map(|key| key.name.strip_suffix("-of"));
    for name in keys.chain(plans::measure::Statistic::NAMES.iter().copied().filter(|take| *take != "first")) {
        assert!(known.remove(name), "{name}");
    }
    assert_eq!(known, BTreeSet::from(["time".to_owned()]));
}
