//! Every verb of `steps`, passing, failing and left open, word for word.
//!
//! `tests/verbs/steps/VERB.toml` has a row that passes, with a claim that allows the exact instant alone, and one that
//! fails. On a rig whose waits end late nobody can say whether that instant was kept. `VERB.txt` beside it is what a user
//! reads of the three. `SCANRIG_BLESS=1 cargo test -p scanrig-cli --test end_to_end stimuli` writes the texts again.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::sync::atomic::AtomicBool;

use record::{CaseRecord, Verdict};
use reports::text::{Style, details};
use runtime::suite::{self, Disk, FileSource, LoadedPlan};
use runtime::{ClockKind, RunOptions, run_case};
use signal::Span;

use crate::project_folder::root;

/// How late the waits of the late rig end at most.
const LATE: Span = Span::from_millis(5);

/// Verbs that need a person, who has tests of their own: `operator` of the runtime.
const ASKING: &[&str] = &["ask"];

/// The verbs that have a plan here.
fn verbs() -> impl Iterator<Item = &'static str> {
    plans::steps::VERBS.iter().map(|verb| verb.name).filter(|verb| !ASKING.contains(verb))
}

/// The plans, by names without a folder.
struct StimulusPlans;

impl FileSource for StimulusPlans {
    fn read(&self, path: &str) -> Result<String, String> {
        Disk.read(&root().join("tests/verbs/steps").join(path).to_string_lossy())
    }
}

fn load(verb: &str) -> LoadedPlan {
    let found = suite::load_plan(&StimulusPlans, &format!("{verb}.toml"), None, &[], 1, &mut Vec::new());
    found.unwrap_or_else(|found| panic!("tests/verbs/steps/{verb}.toml: {found:#?}"))
}

/// The record of a row of a plan.
fn run(plan: &LoadedPlan, row: &str, clock: ClockKind) -> CaseRecord {
    let jobs = plan.jobs(0, 1, 1);
    let job = jobs.iter().find(|job| job.name.ends_with(&format!("[{row}]"))).unwrap();
    let case = plan.plan.case(job.case).unwrap();
    let interrupt = AtomicBool::new(false);
    let files = plan.files(&case, job).unwrap();
    run_case(&case, &files, &RunOptions::new(clock, &interrupt)).unwrap().record
}

/// What a user reads of a case, and the figures of what passed.
fn shown(case: &CaseRecord) -> String {
    let mut out = details(case, Style::default());
    for claim in case.claims.iter().filter(|claim| claim.verdict == Verdict::Pass) {
        let margin = claim.margin.as_ref().map_or(String::new(), |margin| format!(", margin {margin}"));
        writeln!(out, "  ✓ {}: {}{margin}", claim.expected, claim.observed).unwrap();
    }
    out
}

#[test]
fn every_verb_of_steps() {
    let mut wrong = String::new();
    for verb in verbs() {
        let plan = load(verb);
        let uses = plan.plan.cases().all(|case| case.steps.iter().any(|step| step.stimulus.verb() == verb));
        assert!(uses, "tests/verbs/steps/{verb}.toml has no `{verb}`");
        let records = [
            run(&plan, "passes", ClockKind::Virtual),
            run(&plan, "fails", ClockKind::Virtual),
            run(&plan, "passes", ClockKind::Late(LATE)),
        ];
        let [passes, fails, late] = records.each_ref().map(shown);
        let text = format!("{passes}\n{fails}\nOn a rig that is up to {LATE} late:\n{late}");
        let verdicts = records.map(|record| record.verdict);
        assert_eq!(verdicts, [Verdict::Pass, Verdict::Fail, Verdict::Inconclusive], "{verb}: {text}");
        let golden = root().join(format!("tests/verbs/steps/{verb}.txt"));
        if std::env::var_os("SCANRIG_BLESS").is_some() {
            std::fs::write(&golden, &text).unwrap();
        }
        let known = std::fs::read_to_string(&golden).unwrap_or_default();
        if known != text {
            write!(wrong, "{verb} reads now:\n{text}\nand should read:\n{known}\n").unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// A plan of a verb that is no more would be run by nobody.
#[test]
fn no_plan_is_of_an_unknown_verb() {
    let files = std::fs::read_dir(root().join("tests/verbs/steps")).unwrap().map(|file| file.unwrap().path());
    let found: BTreeSet<String> = files
        .filter(|path| path.is_file())
        .map(|file| file.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    let names: BTreeSet<String> = verbs().map(str::to_owned).collect();
    assert_eq!(found, names);
}
