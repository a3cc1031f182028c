//! The forms that other tools and people's eyes depend on. After a wanted change write them again:
//! `cargo run -p scanrig-reports --example page text > reports/tests/golden/run.txt` (and `junit`, `run.xml`; `ctrf`,
//! `ctrf.json`; `markdown`, `summary.md`; `measurements`, `measurements.csv`; `claims`, `claims.csv`).

use record::{CaseRecord, RunRecord};
use scanrig_reports::{csv, ctrf, junit, markdown, text};
use std::collections::BTreeSet;

fn same(got: &str, wanted: &str) {
    for (number, (got, wanted)) in got.lines().zip(wanted.lines()).enumerate() {
        assert_eq!(got, wanted, "line {}", number + 1);
    }
    assert_eq!(got.lines().count(), wanted.lines().count());
}

#[test]
fn the_terminal_summary() {
    same(&text::render(&crate::fixture::example(), text::Style::default()), include_str!("golden/run.txt"));
}

#[test]
fn the_junit_file() {
    same(&junit::render(&crate::fixture::example(), "out"), include_str!("golden/run.xml"));
}

#[test]
fn the_ctrf_file() {
    same(&ctrf::render(&crate::fixture::example()), include_str!("golden/ctrf.json"));
}

#[test]
fn the_summary_for_a_merge_request() {
    same(&markdown::render(&crate::fixture::example()), include_str!("golden/summary.md"));
}

#[test]
fn the_tables_for_a_spreadsheet() {
    let run = crate::fixture::example();
    same(&csv::measurements(&run), include_str!("golden/measurements.csv"));
    same(&csv::claims(&run), include_str!("golden/claims.csv"));
    assert!(csv::claims(&run).lines().all(|line| !line.ends_with('\r')), "lines() takes the return with it");
    assert_eq!(csv::claims(&run).matches("\r\n").count(), csv::claims(&run).matches('\n').count());
}

/// No name of a user is a formula, a mention, a link or markup elsewhere.
#[test]
fn hostile_names_stay_names() {
    let mut run = crate::fixture::hostile();
    run.cases[1].name = "=HYPERLINK(\"x\")".into();
    for claim in &mut run.cases[1].claims {
        claim.name = "@SUM(1)".into();
        claim.expected = "- [x](http://x) @all `` ` | <img>".into();
    }
    let claims = csv::claims(&run);
    assert!(
        claims.contains("\r\n\"'=HYPERLINK(\"\"x\"\")\",") && claims.contains(",\"'@SUM(1)\","),
        "{claims}"
    );
    let summary = markdown::render(&run);
    assert!(summary.contains("```- [x](http://x) @all `` ` \\| <img>```"), "{summary}");
    assert!(!summary.contains('\u{1b}') && !summary.contains('\u{202e}'));
    let ctrf: serde_json::Value = serde_json::from_str(&ctrf::render(&run)).unwrap();
    assert_eq!(ctrf["results"]["tests"].as_array().unwrap().len(), run.cases.len());
}

#[test]
fn colour_changes_nothing_but_colour() {
    let colored = text::render(&crate::fixture::example(), text::Style { color: true, quiet: false });
    let mut plain = String::new();
    let mut rest = colored.as_str();
    while let Some((before, after)) = rest.split_once('\u{1b}') {
        plain.push_str(before);
        rest = after.split_once('m').unwrap().1;
    }
    plain.push_str(rest);
    assert_eq!(plain, text::render(&crate::fixture::example(), text::Style::default()));
}

#[test]
fn quiet_leaves_what_needs_attention() {
    let quiet = text::render(&crate::fixture::example(), text::Style { color: false, quiet: true });
    assert!(!quiet.contains("PASS") && !quiet.contains("N/A"));
    assert!(
        quiet.contains("FAIL")
            && quiet.contains("INCONCLUSIVE")
            && quiet.contains("Summary: 3 passed, 1 failed")
    );
}

#[test]
fn names_do_not_reach_the_terminal_as_sequences() {
    let shown = text::render(&crate::fixture::hostile(), text::Style::default());
    assert!(shown.chars().all(|c| c == '\n' || !c.is_control()));
    assert!(!shown.contains('\u{202e}'));
}

#[test]
fn junit_stays_well_formed_and_its_names_unique() {
    let mut run = crate::fixture::hostile();
    for name in ["a/b[1]", "a/b[1]", "a/b[1]", "a/b[1] #2", "", "", "/"] {
        run.push(CaseRecord { name: name.into(), ..CaseRecord::default() });
    }
    let text = junit::render(&run, "");
    let elements = crate::markup::read(&text).unwrap_or_else(|fault| panic!("{fault}"));
    let cases: Vec<_> = elements.iter().filter(|e| e.name == "testcase").collect();
    let names: BTreeSet<_> = cases.iter().map(|e| (e.get("classname"), e.get("name"))).collect();
    assert_eq!((cases.len(), names.len()), (run.cases.len(), run.cases.len()));
    // Not green: one failure each for fail and inconclusive, one error, and everything unjudged is skipped.
    let count = |name: &str| elements.iter().filter(|e| e.name == name).count();
    assert_eq!((count("failure"), count("error"), count("skipped")), (2, 1, 2 + 7));
}

#[test]
fn a_run_without_cases_has_every_form() {
    let run = RunRecord::new("0.1.0", record::Provenance::default());
    assert_eq!(
        text::render(&run, text::Style::default()).trim(),
        "Summary: 0 passed, 0 failed, 0 inconclusive, 0 not applicable"
    );
    assert!(crate::markup::read(&junit::render(&run, "")).is_ok());
}
